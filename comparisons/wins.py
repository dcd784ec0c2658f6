"""Many scenarios at once: how much is reached within a cost, and who is cheaper than whom where both answer.

The share is absolute: it does not change when an engine is added.  The pairwise counts are over common
scenarios only, and say how many there are.  There is no rank: not every engine is asked the same.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from comparisons.frontier import TARGETS, Frontier

MARGIN = 1.25  # costs closer than this factor are a draw: contention below which a timing is not badged


@dataclass(frozen=True)
class Share:
    """How many (scenario, target) pairs an engine reaches as the cost it may have grows.

    Attributes
    ----------
    engine : str
    costs : tuple of float
        At which one more pair is reached, ascending [CPU ms per simulated second].
    asked : int
        Pairs there are for this engine: of the scenarios it answered at every setting.
    refused, unfinished : int
        Scenarios it refuses, or of which some settings were not run; they are no part of `asked`.
    """

    engine: str
    costs: tuple[float, ...]
    asked: int
    refused: int
    unfinished: int

    def within(self, cost: float) -> float:
        """Share of the pairs asked that are reached within `cost`; NaN if none is asked."""
        return sum(c <= cost for c in self.costs) / self.asked if self.asked else math.nan


@dataclass(frozen=True)
class Duel:
    """One engine against another over the scenarios both were measured on, for one target.

    Attributes
    ----------
    wins, draws, losses : int
        Scenarios on which the first needs less CPU time, the same within `MARGIN`, or more; not to reach the
        target at all is to lose to one that does.
    neither : int
        Common scenarios on which neither reaches it.
    """

    wins: int
    draws: int
    losses: int
    neither: int

    @property
    def common(self) -> int:
        """Scenarios both were measured on."""
        return self.wins + self.draws + self.losses + self.neither


def share(found: Sequence[Frontier], engine: str, targets: Sequence[float] = TARGETS) -> Share:
    """Share of one engine over all its frontiers."""
    own = [f for f in found if f.engine == engine]
    answered = [f for f in own if _counts(f)]
    costs = [f.reach(target)[0].cost for f in answered for target in targets]
    return Share(
        engine,
        tuple(sorted(c for c in costs if not math.isnan(c))),
        len(answered) * len(targets),
        sum(f.absent[0] == "refused" for f in own),
        sum(f.unrun > 0 for f in own),
    )


def duel(found: Sequence[Frontier], first: str, second: str, target: float) -> Duel:
    """The first engine against the second for one target."""
    costs = {
        engine: {f.scenario: f.reach(target)[0].cost for f in found if f.engine == engine and _counts(f)}
        for engine in (first, second)
    }
    common = [name for name in costs[first] if name in costs[second]]
    results = [_result(costs[first][name], costs[second][name]) for name in common]
    return Duel(*(results.count(word) for word in ("win", "draw", "loss", "neither")))


def _counts(found: Frontier) -> bool:
    """Whether an engine answered a scenario at every setting that was planned: only then is "not reached" a result."""
    return found.answered and not found.unrun


def _result(mine: float, other: float) -> str:
    if math.isnan(mine) or math.isnan(other):
        return {(True, True): "neither", (True, False): "loss", (False, True): "win"}[
            math.isnan(mine), math.isnan(other)
        ]
    if max(mine, other) <= MARGIN * min(mine, other):
        return "draw"
    return "win" if mine < other else "loss"
