"""How much of the distance between two profiles each setting explains, one at a time.

The distance is that of their errors in the logarithm.  A setting is tried twice: alone, brought into the first
profile, and last, taken out of the second.  Where settings act together the two differ: nothing of what a setting does
only in company shows when it is alone, and all of it when it is last.  The shares need not add up to one.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from comparisons.pareto import FLOOR

LEAST = 1.05  # ratio of two errors below which there is no distance to explain


@dataclass(frozen=True)
class Part:
    """What one setting explains.

    Attributes
    ----------
    setting : str
    error_with, error_without : float
        Of the first profile with this one setting of the second; of the second without it.  NaN if there is none.
    alone, last : float
        Share of the distance that it covers alone, and that is lost without it.  NaN where an error is missing.
    """

    setting: str
    error_with: float
    error_without: float
    alone: float
    last: float


def explained(
    first: float, second: float, with_one: Mapping[str, float], without_one: Mapping[str, float]
) -> tuple[Part, ...]:
    """What each setting explains of the way from the error of the first profile to that of the second.

    Parameters
    ----------
    first, second : float
        Errors of the two profiles.
    with_one, without_one : mapping
        Setting -> error of the first profile with it; of the second without it.

    Raises
    ------
    ValueError
        If an error of a profile is missing, or they are the same within `LEAST`: then nothing is to be explained.
    """
    if not (math.isfinite(first) and math.isfinite(second)):
        raise ValueError(f"errors of {first!r} and {second!r}: there is no distance where one of them is missing")
    whole = _log(first) - _log(second)
    if abs(whole) < math.log(LEAST):
        raise ValueError(f"errors of {first:.3g} and {second:.3g}: there is no distance to explain")
    parts = []
    for name, error in with_one.items():
        without = without_one[name]
        alone, last = (_log(first) - _log(error)) / whole, (_log(without) - _log(second)) / whole
        parts.append(Part(name, error, without, alone, last))
    return tuple(sorted(parts, key=lambda part: -max(_known(part.alone), _known(part.last))))


def _log(error: float) -> float:
    return math.log(max(error, FLOOR)) if math.isfinite(error) else math.nan


def _known(share: float) -> float:
    return share if math.isfinite(share) else -math.inf
