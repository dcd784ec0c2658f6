"""Fronts: what nothing else betters in both of two numbers, and what it costs to come down to a target.

Both numbers are positive and less is better: first the cost, then the error.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

FLOOR = 1e-16  # an error of zero is drawn and interpolated as this one: nothing in float64 is finer

Pair = tuple[float, float]  # cost, error


class Reach(NamedTuple):
    """What it costs to come down to a target.

    Attributes
    ----------
    cost : float
        NaN if the target is not reached.
    how : str
        "between" two neighbours of one ladder, "at" a measured point, "below" the cheapest point, which is
        better than the target already (so that `cost` is an upper bound), or "" if it is not reached.
    place : int
        Of the first point in its ladder that reaches the target; -1 if none does.
    """

    cost: float
    how: str
    place: int = -1


NOWHERE = Reach(math.nan, "")


def front(points: Sequence[Pair]) -> list[Pair]:
    """Points that no other equals or betters in both numbers, from left to right."""
    return [points[k] for k in front_places(points)]


def front_places(points: Sequence[Pair]) -> list[int]:
    """Where in `points` those of the front stand, cheapest first."""
    kept: list[int] = []
    for k in sorted(range(len(points)), key=points.__getitem__):
        if not kept or points[k][1] < points[kept[-1]][1]:
            kept.append(k)
    return kept


def reach(ladder: Sequence[Pair], target: float) -> Reach:
    """Cost at which a ladder of settings, coarse to fine, comes down to the `target` error.

    On the front of the ladder the target is bracketed and the cost interpolated in log cost over log error, but
    only between two settings that are neighbours in the ladder: where a setting between them did worse, the
    cheapest measured point within the target counts.  Nothing is extrapolated.
    """
    kept = front_places(ladder)
    within = next((n for n, k in enumerate(kept) if ladder[k][1] <= target), None)
    if within is None:
        return NOWHERE
    place = kept[within]
    cost, error = ladder[place]
    if within == 0:
        return Reach(cost, "below", place)
    before = kept[within - 1]
    if abs(place - before) != 1 or error == target:
        return Reach(cost, "at", place)
    return Reach(_interpolated(ladder[before], ladder[place], target), "between", place)


def _interpolated(coarse: Pair, fine: Pair, target: float) -> float:
    (cost, fine_cost), errors = (coarse[0], fine[0]), (coarse[1], max(fine[1], FLOOR))
    part = math.log(errors[0] / target) / math.log(errors[0] / errors[1])
    return cost * (fine_cost / cost) ** part
