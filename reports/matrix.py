"""The verdict matrix: scenarios down, engines across; the same for page, Markdown and terminal."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from comparisons.cell import Campaign, Cell
from comparisons.measurement import Measurement
from reports.numbers import short, with_unit
from reports.verdict import (
    ABSENT,
    BROKEN,
    Mark,
    anchor,
    chosen,
    description,
    engines,
    mark,
    ratio_text,
    scenarios,
    sentence,
    unjudged,
)


@dataclass(frozen=True)
class Entry:
    """One cell as the matrix shows it.

    Attributes
    ----------
    cell, mark
    ratio : str
        "0.42× tol", or "".
    quantity : str
        The quantity that decides here, where it is not the one that decides in most of the row.
    note : int or None
        Number of the footnote.
    hover : str
        The whole story.
    anchor : str
        Fragment of the cell's entry among all cells.
    others : int
        Cells of the same scenario and engine with other settings.
    """

    cell: Cell
    mark: Mark
    ratio: str
    quantity: str
    note: int | None
    hover: str
    anchor: str
    others: int


@dataclass(frozen=True)
class Row:
    """One scenario.  `decides` names the deciding quantity and its tolerance; `more` counts the other checks."""

    scenario: str
    decides: str
    more: int
    entries: tuple[Entry | None, ...]


@dataclass(frozen=True)
class Matrix:
    """Engines across (fair first), scenarios down, and the footnotes: number n is `footnotes[n - 1]`."""

    engines: tuple[str, ...]
    rows: tuple[Row, ...]
    footnotes: tuple[str, ...]


def matrix(campaign: Campaign) -> Matrix:
    """The verdict matrix of a campaign."""
    table, order = chosen(campaign), engines(campaign)
    fragments = {id(c): name for c, name in zip(campaign.cells, anchor(campaign).values(), strict=True)}
    amount = Counter((c.scenario, c.engine) for c in campaign.cells)
    notes: dict[str, list[str]] = {}
    rows = []
    for scenario in scenarios(campaign):
        cells = [table.get((scenario, e)) for e in order]
        decisive = _decisive([c for c in cells if c])
        entries = []
        for cell in cells:
            if cell is None:
                entries.append(None)
                continue
            text = footnote(cell)
            number = _numbered(notes, text, cell.engine)
            other = cell.worst.quantity if cell.worst and decisive and cell.worst.quantity != decisive.quantity else ""
            others = amount[scenario, cell.engine] - 1
            entries.append(
                Entry(cell, mark(cell), _ratio(cell), other, number, _hover(cell), fragments[id(cell)], others)
            )
        checks = description(campaign, scenario)["checks"]
        rows.append(Row(scenario, _decides(decisive, checks), max(len(checks) - 1, 0), tuple(entries)))
    footnotes = [f"{', '.join(names)}: {text}" for text, names in notes.items()]
    return Matrix(tuple(order), tuple(rows), (*footnotes, *_partly(order, rows)))


def _partly(order: Sequence[str], rows: Sequence[Row]) -> Iterator[str]:
    """One sentence for every engine that ran on some of the scenarios only."""
    for k, engine in enumerate(order):
        present = sum(row.entries[k] is not None for row in rows)
        if present < len(rows):
            yield f"{engine}: run on {present} of {len(rows)} scenarios; on the others when asked for by name"


def _numbered(notes: dict[str, list[str]], text: str, engine: str) -> int | None:
    """Number of the footnote `text`, entered on first sight; engines that share it are listed in front of it."""
    if not text:
        return None
    names = notes.setdefault(text, [])
    if engine not in names:
        names.append(engine)
    return list(notes).index(text) + 1


def footnote(cell: Cell) -> str:
    """What must be said of the cell besides its verdict: why it has none, what is on record, what is approximated."""
    if cell.state in ABSENT or cell.state in BROKEN:
        return sentence(cell)
    return f"on record: {cell.known}" if cell.known else "; ".join(cell.notes)


def _ratio(cell: Cell) -> str:
    if cell.state in ABSENT or unjudged(cell):
        return ""
    if cell.state in BROKEN:
        return f"at {short(cell.time)} s" if cell.time > 0.0 else cell.stage
    law = cell.of("impact law")  # where mechanics leaves the answer open, its name is the answer
    return ", ".join(filter(None, (ratio_text(cell), law.text if law else "")))


def _hover(cell: Cell) -> str:
    return f"{cell.scenario}, {cell.engine}: {mark(cell).word}. {sentence(cell)}"


def _decisive(cells: Sequence[Cell]) -> Measurement | None:
    """The measurement whose quantity is the worst in most cells of the row; the first of equals."""
    worst = [c.worst for c in cells if c.worst is not None]
    if not worst:
        return None
    name = Counter(m.quantity for m in worst).most_common(1)[0][0]
    return next(m for m in worst if m.quantity == name)


def _decides(decisive: Measurement | None, checks: Sequence[dict]) -> str:
    if decisive is not None:
        return f"{decisive.quantity} ≤ {with_unit(decisive.tolerance, decisive.unit)}"
    if checks and not math.isnan(checks[0].get("tolerance", math.nan)):
        return f"{checks[0].get('quantity', '')} ≤ {short(checks[0]['tolerance'])}"
    return "named, not judged"
