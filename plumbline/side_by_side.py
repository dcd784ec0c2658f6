"""Two runs, two engines or one engine in two environments, cell beside cell."""

from __future__ import annotations

import math
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from comparisons.cell import Campaign
from comparisons.regression import Baseline, Change, changes, record
from plumbline.results import Results
from plumbline.run_folder import FolderError
from reports.numbers import settings_text, short, with_unit
from reports.regressions import told
from reports.verdict import times_tolerance

WORDS = {
    "identical": ("=", "identical"),
    "in band": ("≈", "same within the band"),
    "improved": ("▲", "B is better"),
    "regressed": ("▼", "B is worse"),
    "moved": ("◆", "differs"),
    "gone": ("∅", "only A answers"),
    "new": ("+", "only in B"),
    "not comparable": ("≁", "not comparable"),
}
NOTHING_ASKED = (2, 4, 5)  # exit codes of a run that brought no answers


@dataclass(frozen=True)
class Line:
    """One pair of cells as printed: values with their unit, and over their tolerance where there is one."""

    scenario: str
    engine: str
    quantity: str
    a: str
    b: str
    ratio: str
    glyph: str
    word: str
    why: str


def carried_out(python: str, words: Sequence[str], out: Path) -> Results:
    """The run `plumbline run WORDS` of the environment of an interpreter, in the folder `out`.

    Raises
    ------
    FolderError
        If plumbline is not installed there or the run brought no answers; with what it said.
    """
    command = [python, "-m", "plumbline", "run", *words, "--out", str(out), "--fail-on", "harness", "--progress", "off"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    except OSError as error:
        raise FolderError(f"cannot start {python}: {error.strerror or error}") from error
    if done.returncode in NOTHING_ASKED or not (out / "run.json").is_file():
        said = (done.stderr.strip() or done.stdout.strip() or "nothing").splitlines()[-1]
        raise FolderError(f"{python} ran nothing (exit code {done.returncode}); it said: {said}")
    return Results.read(out)


def compared(a: Results, b: Results, engines: tuple[str, str] | None = None) -> tuple[Campaign, tuple[Change, ...]]:
    """The cells of `b` beside those of `a`, in a campaign whose baseline is `a`.

    Parameters
    ----------
    engines : pair of names, optional
        Where two engines are compared: that of `a` and that of `b`.
    """
    questions = {label: str(told_of.get("question", "")) for label, told_of in a.campaign.scenarios.items()}
    here, there = (str(r.campaign.fingerprint.get("platform class", "unknown")) for r in (a, b))
    records = [record(cell, questions.get(cell.scenario, ""), here) for cell in a.cells]
    cells = b.cells
    if engines is not None and engines[0] != engines[1]:
        records = [replace(r, engine=engines[1]) for r in records if r.engine == engines[0]]
        cells = tuple(cell for cell in cells if cell.engine == engines[1])
    joined = replace(b.campaign, cells=cells, baseline=Baseline(a.campaign.id, there, tuple(records)).to_plain())
    return joined, changes(joined)


def lines(found: Sequence[Change]) -> list[Line]:
    """What is printed of every pair."""
    return [_line(change) for change in found]


def _line(change: Change) -> Line:
    quantity, before, now = change.quantity, change.before, change.now
    if not quantity and change.cell is not None and (worst := change.cell.worst) is not None:
        quantity, now = worst.quantity, worst.value
        before = change.record.values.get(quantity, math.nan) if change.record else math.nan
    measured = change.cell.of(quantity) if change.cell and quantity else None
    unit = measured.unit if measured else "1"
    limit = measured.tolerance if measured else math.nan
    factor = now / before if before else math.nan
    glyph, word = WORDS[change.outcome]
    return Line(
        scenario=change.scenario,
        engine=change.engine + (f" ({settings_text(change.settings)})" if change.settings else ""),
        quantity=quantity,
        a=_value(before, unit, limit),
        b=_value(now, unit, limit),
        ratio=short(factor) if math.isfinite(factor) else "",
        glyph=glyph,
        word=word,
        why=told(change),
    )


def _value(value: float, unit: str, tolerance: float) -> str:
    if math.isnan(value):
        return "–"
    return with_unit(value, unit) + (f" ({times_tolerance(value / tolerance)})" if tolerance > 0.0 else "")


def versions(results: Results, engine: str | None = None) -> str:
    """Engines of a run with their versions: "mujoco 4.0.1, pymunk 7.3.1"."""
    cells = [c for c in results.cells if engine in (None, c.engine)]
    return ", ".join(dict.fromkeys(f"{c.engine} {c.engine_version}".strip() for c in cells))


def as_plain(a: Results, b: Results, found: Sequence[Change], remarks: Sequence[str]) -> dict[str, Any]:
    """The comparison for programs."""
    pairs = [{**vars(line), "outcome": change.outcome} for line, change in zip(lines(found), found, strict=True)]
    return {"a": str(a.folder), "b": str(b.folder), "remarks": list(remarks), "pairs": pairs}
