"""JUnit XML for continuous integration: suite = scenario, case = engine and settings.

Failure (the answer is wrong, or not that of the baseline), error (the engine broke) and skipped (it was not asked,
cannot, or fails for a reason on record) are kept apart.
"""

from __future__ import annotations

import math
import re
from xml.etree import ElementTree as ET

from comparisons.cell import Campaign, Cell
from comparisons.regression import FINDINGS, Change, changes
from reports.regressions import told
from reports.verdict import case_name, mark, ratio, scenarios, sentence

OUTCOME = {
    "fail": "failure",
    "diverged": "failure",
    "xpass": "failure",
    "error": "error",
    "crash": "error",
    "timeout": "error",
    "oom": "error",
    "refused": "skipped",
    "not-installed": "skipped",
    "not-run": "skipped",
    "xfail": "skipped",
}
# what XML 1.0 has no way to write, escaped or not: control characters, lone surrogates, U+FFFE and U+FFFF
FORBIDDEN = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def junit(campaign: Campaign) -> str:
    """The campaign as JUnit XML."""
    found = changes(campaign)
    news = {id(c.cell): c for c in found if c.cell is not None}
    lost = [c for c in found if c.cell is None]
    root = ET.Element("testsuites", name=clean(campaign.title or campaign.id))
    for scenario in dict.fromkeys([*scenarios(campaign), *(c.scenario for c in lost)]):
        suite = ET.SubElement(root, "testsuite", name=clean(scenario))
        if campaign.started:
            suite.set("timestamp", clean(campaign.started).removesuffix("Z"))
        for cell in campaign.cells:
            if cell.scenario == scenario:
                _case(suite, cell, news.get(id(cell)))
        for change in lost:
            if change.scenario == scenario:
                case = ET.SubElement(suite, "testcase", name=clean(change.engine), classname=clean(scenario), time="0")
                _failure(case, change.outcome, f"{change.outcome}: {told(change)}")
        suite.attrib |= _counts(suite)
    root.attrib |= _counts(root)
    ET.indent(root)
    return '<?xml version="1.0" encoding="utf-8"?>\n' + ET.tostring(root, encoding="unicode") + "\n"


def _case(suite: ET.Element, cell: Cell, change: Change | None) -> None:
    case = ET.SubElement(suite, "testcase", name=clean(case_name(cell)), classname=clean(cell.scenario))
    case.set("time", f"{seconds(cell):.6f}")
    _properties(case, cell, change)
    outcome = OUTCOME.get(cell.state)
    news = f"{change.outcome}: {told(change)}" if change and change.outcome in FINDINGS else ""
    if news and outcome in (None, "skipped"):
        _failure(case, change.outcome if change else "", news)
    elif outcome == "skipped":
        ET.SubElement(case, outcome, message=_ascii_times(sentence(cell)))
    elif outcome:
        _failure(case, cell.state, "; ".join(filter(None, (sentence(cell), news))), outcome)
    lines = [f"{mark(cell).glyph} {mark(cell).word}: {sentence(cell)}", *cell.notes]
    if change:
        lines.append(f"against the baseline: {change.outcome}{f': {told(change)}' if told(change) else ''}")
    if cell.reproduce:
        lines.append(f"reproduce: {cell.reproduce}")
    ET.SubElement(case, "system-out").text = clean("\n".join(lines))
    if cell.output:
        ET.SubElement(case, "system-err").text = clean(cell.output)


def _failure(case: ET.Element, kind: str, text: str, outcome: str = "failure") -> None:
    result = ET.SubElement(case, outcome, message=_ascii_times(text), type=kind)
    result.text = _ascii_times(text)


def _ascii_times(text: str) -> str:
    return clean(text.replace("×", "x"))


def _properties(case: ET.Element, cell: Cell, change: Change | None) -> None:
    values = {"engine": cell.engine, "engine_version": cell.engine_version, "state": cell.state}
    values |= {"baseline": change.outcome} if change else {}
    values |= {f"setting.{name}": str(value) for name, value in cell.settings.items()}
    for m in cell.measurements:
        if not math.isnan(m.tolerance):
            values[f"{m.quantity} [{m.unit}]"] = repr(m.value)
            values[f"{m.quantity} / tolerance"] = f"{ratio(m):.6g}"
    if not math.isnan(cell.cost):
        values["cpu seconds per simulated second"] = f"{cell.cost:.6g}"
    box = ET.SubElement(case, "properties")
    for name, value in values.items():
        ET.SubElement(box, "property", name=clean(name), value=clean(value))


def _counts(suite: ET.Element) -> dict[str, str]:
    cases = list(suite.iter("testcase"))
    outcomes = [part.tag for case in cases for part in case]
    return {
        "tests": str(len(cases)),
        "failures": str(outcomes.count("failure")),
        "errors": str(outcomes.count("error")),
        "skipped": str(outcomes.count("skipped")),
        "time": f"{sum(float(case.get('time', 0)) for case in cases):.6f}",
    }


def seconds(cell: Cell) -> float:
    """What advancing the cell cost [s]; 0 if it was not measured."""
    return 0.0 if math.isnan(cell.cost) else cell.cost * cell.duration


def clean(text: str) -> str:
    """`text` without the characters that XML cannot hold."""
    return FORBIDDEN.sub("", text)
