"""How an error falls as a ladder gets finer: the observed order, where it stalls, and where finer is worse.

On an asymptotic stretch the error is C h^p.  The order p is the slope of log error over log h, fitted where
the slopes from rung to rung agree, and nowhere else: pre-asymptotic rungs, plateaus and rounding are left out.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

AGREE = 0.3  # slopes from rung to rung on one asymptotic stretch differ by no more than this
LEAST = 3  # rungs of a stretch
ROUNDING = 1e-12  # relative errors below are rounding, gathered over up to 1e5 steps; nothing is read from them
WORSE = 1.05  # growth of the error at which a finer rung is worse: less is the scatter of phases and samples
FALLING = 0.1  # an error that falls more slowly than h to this power does not converge


@dataclass(frozen=True)
class Order:
    """The observed order of a ladder.

    Attributes
    ----------
    slope : float
        p of error ~ h^p; NaN where no stretch of `LEAST` rungs has one slope.
    first, last : float
        Coarsest and finest rung of the stretch, as h.
    stalls : float
        Error at which finer rungs stay, or NaN: they exist, and fall short of half the order.
    """

    slope: float
    first: float = math.nan
    last: float = math.nan
    stalls: float = math.nan


@dataclass(frozen=True)
class Alarm:
    """A finer rung with a larger error, or with none at all because the run broke (`finer_error` infinite)."""

    coarse: float
    fine: float
    error: float
    finer_error: float

    @property
    def growth(self) -> float:
        """How many times larger the error of the finer rung is."""
        return self.finer_error / self.error if self.error > 0.0 else math.inf


def observed_order(steps: Sequence[float], errors: Sequence[float]) -> Order:
    """Order of the errors over the steps h, given from coarse to fine; those that are not finite are left out.

    Of the stretches with one slope that counts over which the error falls farthest: on a plateau it falls nowhere.

    Raises
    ------
    ValueError
        For steps that do not get finer.
    """
    known = [(h, e) for h, e in zip(steps, errors, strict=True) if math.isfinite(e)]
    h, e = np.array(known).reshape(-1, 2).T
    if (np.diff(h) >= 0.0).any():
        raise ValueError(f"steps = {list(steps)!r} do not get finer")
    above = int(np.argmax(e <= ROUNDING)) if (e <= ROUNDING).any() else len(e)
    stretch = _stretch(np.log(h[:above]), np.log(e[:above]))
    if stretch is None:
        return Order(math.nan)
    first, last = stretch
    slope = float(np.polyfit(np.log(h[first : last + 1]), np.log(e[first : last + 1]), 1)[0])
    return Order(slope, float(h[first]), float(h[last]), _stall(h[:above], e[:above], last, slope))


def _stretch(log_h: np.ndarray, log_e: np.ndarray) -> tuple[int, int] | None:
    """First and last rung of the stretch with one slope over which the error falls farthest, if it falls."""
    slopes = np.diff(log_e) / np.diff(log_h)
    best, farthest = None, 0.0
    for first in range(len(slopes)):
        for last in range(first + LEAST - 1, len(log_h)):
            own = slopes[first:last]
            fallen = log_e[first] - log_e[last]
            if own.max() - own.min() <= AGREE and own.min() > FALLING and fallen > farthest:
                best, farthest = (first, last), fallen
    return best


def _stall(h: np.ndarray, e: np.ndarray, last: int, slope: float) -> float:
    """Least error of the rungs beyond the stretch if they fall by less than half its order, else NaN."""
    if last == len(h) - 1:
        return math.nan
    fallen = math.log(e[last] / e[last + 1 :].min()) / math.log(h[last] / h[-1])
    return float(e[last:].min()) if fallen < 0.5 * slope else math.nan


def alarms(steps: Sequence[float], errors: Sequence[float]) -> tuple[Alarm, ...]:
    """Every rung that is worse than its coarser neighbour, the gravest first.

    `errors` are infinite where the run broke, NaN where nothing is known (then the rung is passed over).
    Rounding is no alarm.
    """
    known = [(h, e) for h, e in zip(steps, errors, strict=True) if not math.isnan(e)]
    found = [
        Alarm(h, finer, e, finer_e)
        for (h, e), (finer, finer_e) in pairwise(known)
        if math.isfinite(e) and finer_e > WORSE * e and finer_e > ROUNDING
    ]
    return tuple(sorted(found, key=lambda alarm: -alarm.growth))
