"""JUnit XML for continuous integration: suite = scenario, case = engine and settings.

Failure (the answer is wrong), error (the engine broke) and skipped (it was not asked, cannot, or fails
for a reason on record) are kept apart.
"""

from __future__ import annotations

import math
import re
from xml.etree import ElementTree as ET

from comparisons.cell import Campaign, Cell
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
    root = ET.Element("testsuites", _counts(campaign.cells) | {"name": clean(campaign.title or campaign.id)})
    for scenario in scenarios(campaign):
        cells = [c for c in campaign.cells if c.scenario == scenario]
        suite = ET.SubElement(root, "testsuite", {"name": clean(scenario)} | _counts(cells))
        if campaign.started:
            suite.set("timestamp", clean(campaign.started).removesuffix("Z"))
        for cell in cells:
            _case(suite, cell)
    ET.indent(root)
    return '<?xml version="1.0" encoding="utf-8"?>\n' + ET.tostring(root, encoding="unicode") + "\n"


def _case(suite: ET.Element, cell: Cell) -> None:
    case = ET.SubElement(suite, "testcase", name=clean(case_name(cell)), classname=clean(cell.scenario))
    case.set("time", f"{seconds(cell):.6f}")
    _properties(case, cell)
    outcome = OUTCOME.get(cell.state)
    if outcome:
        message = clean(sentence(cell).replace("×", "x"))
        result = ET.SubElement(case, outcome, message=message)
        if outcome != "skipped":
            result.set("type", cell.state)
            result.text = message
    lines = [f"{mark(cell).glyph} {mark(cell).word}: {sentence(cell)}", *cell.notes]
    if cell.reproduce:
        lines.append(f"reproduce: {cell.reproduce}")
    ET.SubElement(case, "system-out").text = clean("\n".join(lines))
    if cell.output:
        ET.SubElement(case, "system-err").text = clean(cell.output)


def _properties(case: ET.Element, cell: Cell) -> None:
    values = {"engine": cell.engine, "engine_version": cell.engine_version, "state": cell.state}
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


def _counts(cells: tuple[Cell, ...] | list[Cell]) -> dict[str, str]:
    outcomes = [OUTCOME.get(c.state) for c in cells]
    return {
        "tests": str(len(outcomes)),
        "failures": str(outcomes.count("failure")),
        "errors": str(outcomes.count("error")),
        "skipped": str(outcomes.count("skipped")),
        "time": f"{sum(map(seconds, cells)):.6f}",
    }


def seconds(cell: Cell) -> float:
    """What advancing the cell cost [s]; 0 if it was not measured."""
    return 0.0 if math.isnan(cell.cost) else cell.cost * cell.duration


def clean(text: str) -> str:
    """`text` without the characters that XML cannot hold."""
    return FORBIDDEN.sub("", text)
