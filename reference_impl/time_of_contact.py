"""When a gap closes: closed forms, and roots in a bracket with counted evaluations.

`parabola` and `spheres_meet` are exact where the gap of two spheres, or of a sphere and a half-space, is a
quadratic in time.  Everything else is found by `advancement`, which never passes a contact.  The other
methods refine a bracket that the advancement opens, and are there to be compared with it:

    bisection   halves the bracket, as the lecture does: one bit per evaluation
    illinois    false position that halves the value at an end which stays (Dowell and Jarratt, 1971)
    newton      uses the rate of the gap, which comes with it for nothing, and halves where that leads astray
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from reference_impl.kernels import dot, kernel, norm

FREE = 40  # evaluations after which every further one halves the bracket: the budget of `illinois` and `newton`

Gap = Callable[[float], tuple[float, float]]  # time [s] -> gap [m] and its rate [m/s]
Guess = Callable[[float, float, float, float, float], float]  # bracket, last time, its gap and rate -> time [s]


class Bracket(NamedTuple):
    """Times with the gap open and closed, and what is known there."""

    low: float  # [s]
    high: float  # [s]
    gap: float  # at low [m], > 0
    rate: float  # at low [m/s]
    overlap: float  # gap at high [m], < 0


@kernel
def parabola(gap, rate, acceleration):
    """First time s > 0 at which gap + rate s + ½ acceleration s² falls to zero [s]; inf if it never does.

    Bodies that part from a touch, or from an overlap by rounding, meet again when they come back to
    zero.  Each root is written in the form that does not cancel.
    """
    if rate <= 0.0:
        gap = max(gap, 0.0)
    square = rate * rate - 2.0 * acceleration * gap
    if square < 0.0:
        if gap > 0.0:
            return np.inf
        square = rate * rate  # an overlap that never opens counts as a touch
    root = math.sqrt(square)
    if rate < 0.0:
        return 2.0 * gap / (root - rate)
    if acceleration >= 0.0:
        return np.inf
    return (rate + root) / -acceleration


@kernel
def spheres_meet(r, v, radii):
    """First time s >= 0 at which |r + v s| = radii while it decreases [s]; inf if never.

    The gap function is |r|² - radii², divided by its scale so that it is a length.
    """
    approach = dot(r, v)
    if approach >= 0.0:
        return np.inf
    square, distance = dot(v, v), norm(r)
    # the square of what the spheres miss each other by, from the part of v across r (no cancellation)
    along = approach / (distance * distance)
    across = 0.0
    for c in range(3):
        across += (v[c] - r[c] * along) ** 2
    miss = distance * distance * across / square
    if miss > radii * radii:
        return np.inf
    excess = max(distance - radii, 0.0) * (distance + radii)
    return excess / (-approach + math.sqrt(square * (radii * radii - miss)))


def _refined(gap: Gap, bracket: Bracket, tolerance: float, guess: Guess) -> tuple[float, int]:
    """Result of `bisection`, by guesses of the root from the bracket and from time, gap and rate of the last one.

    A guess outside the bracket, or beyond the budget `FREE`, gives way to its middle.
    """
    low, high, count = bracket.low, bracket.high, 0
    t, value, rate = low, bracket.gap, bracket.rate
    while True:
        t = guess(low, high, t, value, rate) if count < FREE else low
        if not low < t < high:
            t = 0.5 * (low + high)
            if t in (low, high):
                return low, count
        value, rate = gap(t)
        count += 1
        if abs(value) <= tolerance:
            return t, count
        if value > 0.0:
            low = t
        else:
            high = t


def bisection(gap: Gap, bracket: Bracket, tolerance: float) -> tuple[float, int]:
    """Time at which the gap is within `tolerance` [m] of zero, and how many times it was evaluated.

    `illinois` and `newton` do the same.  Where rounding leaves no time between the ends of the bracket, its
    lower end is the answer.
    """
    return _refined(gap, bracket, tolerance, lambda low, high, t, value, rate: low)


def illinois(gap: Gap, bracket: Bracket, tolerance: float) -> tuple[float, int]:
    """As `bisection`, by false position."""
    above, below, side = bracket.gap, bracket.overlap, 0  # side: of the last root, 1 open, -1 closed, 0 none yet

    def guess(low: float, high: float, t: float, value: float, rate: float) -> float:
        nonlocal above, below, side
        if t == high:
            above, below, side = (0.5 * above if side == -1 else above), value, -1
        elif t > bracket.low:
            above, below, side = value, (0.5 * below if side == 1 else below), 1
        return low + (high - low) * above / (above - below)

    return _refined(gap, bracket, tolerance, guess)


def newton(gap: Gap, bracket: Bracket, tolerance: float) -> tuple[float, int]:
    """As `bisection`, by Newton's method from the open end of the bracket, which is kept."""
    return _refined(gap, bracket, tolerance, lambda low, high, t, value, rate: t - value / rate if rate < 0.0 else low)


BRACKETED: Mapping[str, Callable[[Gap, Bracket, float], tuple[float, int]]] = {
    "bisection": bisection,
    "illinois": illinois,
    "newton": newton,
}
METHODS = ("advancement", *BRACKETED)
