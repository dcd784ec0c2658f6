"""Every red, refused or known cell with its reason in words, grouped by what happened and to whom."""

from __future__ import annotations

from dataclasses import dataclass

from comparisons.cell import Campaign, Cell
from reports.verdict import ABSENT, BROKEN, anchor, engines, mark, sentence, unjudged


@dataclass(frozen=True)
class Finding:
    """One reason, and the cells it holds for, each with its fragment in the page."""

    reason: str
    cells: tuple[tuple[Cell, str], ...]


@dataclass(frozen=True)
class Chapter:
    """Findings of one kind.

    Attributes
    ----------
    title, lead : str
    glyph : str
    tone : str
    by_engine : tuple of (engine, findings)
    amount : int
        Number of cells.
    """

    title: str
    lead: str
    glyph: str
    tone: str
    by_engine: tuple[tuple[str, tuple[Finding, ...]], ...]
    amount: int


KINDS = (
    ("Broke", "The engine did not come to an answer.", BROKEN),
    (
        "Beyond tolerance",
        "The answer is wrong by more than a careful user accepts.",
        ("fail",),
    ),
    ("Passes against the record", "On record as failing; take the record back if this is meant to last.", ("xpass",)),
    ("Known", "Beyond tolerance for a reason that has been measured and is on record.", ("xfail",)),
    ("Not judged", "A fault of the harness: a demanded quantity could not be computed.", ("unjudged",)),
    ("Refused or not run", "Not an error: the engine says that it cannot, and why.", ABSENT),
)


def findings(campaign: Campaign) -> tuple[Chapter, ...]:
    """Chapters in order of weight; empty ones are left out."""
    fragments = anchor(campaign)
    chapters = []
    for title, lead, states in KINDS:
        cells = [
            (c, fragments[k])
            for k, c in enumerate(campaign.cells)
            if ("unjudged" if unjudged(c) else c.state) in states
        ]
        if not cells:
            continue
        by_engine = []
        for engine in engines(campaign):
            own = [(c, a) for c, a in cells if c.engine == engine]
            if own:
                by_engine.append((engine, _same_reason(own)))
        sign = mark(cells[0][0])
        chapters.append(Chapter(title, lead, sign.glyph, sign.tone, tuple(by_engine), len(cells)))
    return tuple(chapters)


def _kind(cell: Cell) -> str:
    return "unjudged" if unjudged(cell) else cell.state


def _same_reason(cells: list[tuple[Cell, str]]) -> tuple[Finding, ...]:
    by_reason: dict[str, list[tuple[Cell, str]]] = {}
    for cell, fragment in cells:
        by_reason.setdefault(sentence(cell), []).append((cell, fragment))
    return tuple(Finding(reason, tuple(own)) for reason, own in by_reason.items())
