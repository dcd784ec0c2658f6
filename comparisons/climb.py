"""Climb: one engine on one ladder, rung by rung, and the frontier it reached.

How an engine broke is one word of a closed vocabulary.  Words that say so themselves (`LOUD`: a refusal, a crash,
a deadline) rank above those for answers that are silently wrong (`comparisons.stability.BREAKS`, and "inaccurate"):
who gets no answer knows it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from comparisons.cell import Cell
from comparisons.stability import BREAKS, words
from scenarios.ladder import Ladder

ABSENT = {"not-installed": "not installed", "not-run": "not run"}
LOUD = {
    "refused": "refused",
    "timeout": "too slow",
    "diverged": "gave up",
    "error": "raised",
    "oom": "out of memory",
    "crash": "crashed",
}
INACCURATE = "inaccurate"  # moves as it may, but not as it must
UNJUDGED = "not judged"
BISECTIONS = 3  # the edge is then known to an eighth of the logarithm of a step between rungs


class Try(NamedTuple):
    """What happened on one rung."""

    rung: float
    broke: str  # how; "" if it held


class Frontier(NamedTuple):
    """How far an engine got.

    `good` is the last rung before the first that broke it, or the last of all; `bad` that first one; either is None
    if there is none.  `again` are harder rungs that held all the same.
    """

    good: float | None
    bad: float | None
    word: str  # how it broke; "" if it never did
    again: tuple[float, ...] = ()

    @property
    def silent(self) -> bool:
        """Whether it broke without saying so."""
        return self.word in BREAKS or self.word == INACCURATE


def how(cell: Cell) -> str:
    """How the engine broke on this cell; "" if it held.

    A state that is not finite is a silent break: the driver found it, not the engine.
    """
    row = cell.of("stability")
    broken = words(row.text) if row is not None else ()
    if cell.state in ABSENT:
        return ABSENT[cell.state]
    if cell.state == "error" and cell.stage == "judge":
        return UNJUDGED
    if cell.state == "diverged" and "not finite" in broken:
        return "not finite"
    if cell.state in LOUD:
        return LOUD[cell.state]
    if cell.state in ("ok", "xpass"):
        return ""
    return broken[0] if broken else INACCURATE


def frontier(tries: Sequence[Try], falling: bool = False) -> Frontier:
    """Frontier of the tries, in whatever order they were made; `falling` if harder rungs are smaller."""
    ordered = sorted(tries, key=lambda t: -t.rung if falling else t.rung)
    first = next((k for k, t in enumerate(ordered) if t.broke), len(ordered))
    good = ordered[first - 1].rung if first else None
    if first == len(ordered):
        return Frontier(good, None, "")
    later = tuple(t.rung for t in ordered[first + 1 :] if not t.broke)
    return Frontier(good, ordered[first].rung, ordered[first].broke, later)


def next_rung(ladder: Ladder, tries: Sequence[Try]) -> float | None:
    """The rung to try now; None if the climb is over.

    The edge of a deadline is one of this machine and that of a refusal is the engine's own to tell: neither is
    bisected.  An engine that is not there, or that the house cannot judge, does not climb on.
    """
    tried = {t.rung for t in tries}
    ended = any(t.broke in (*ABSENT.values(), UNJUDGED) for t in tries)
    broken = any(t.broke for t in tries)
    if ended:
        return None
    if not (broken and ladder.monotone):
        return next((r for r in ladder.rungs if r not in tried), None)
    edge = frontier(tries, ladder.rungs[0] > ladder.rungs[-1])
    if edge.good is None or edge.bad is None or edge.word in (LOUD["timeout"], LOUD["refused"]):
        return None
    if len(tried - set(ladder.rungs)) >= BISECTIONS:
        return None
    return ladder.between(edge.good, edge.bad)
