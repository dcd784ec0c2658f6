"""Tethers: touches whose gap is the slack.

With r from the anchor of b to that of a the gap is the length less |r|.  A tether is a contact like any other:
its normal, along which its force pulls a, points from the anchor of a to that of b, it has its own restitution when
it goes taut and no friction, and it carries a force >= 0 for as long as it stays taut.

When it next goes taut is found by conservative advancement.  With r(t + s) within ½ K s² of the straight line
r + r' s the gap cannot close before the only positive root of

    |r + r' s| + ½ K s² = length

whose left side is convex.  Where the anchors move alike (K = 0) this is the answer itself.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from mechanics.effects import Tether
from mechanics.rotation import rotate
from mechanics.scene import Scene
from reference_impl.advancement import CLEAR, EVALUATIONS, HIT, TIRED
from reference_impl.collide.features import CORD, REAL, WHOLE
from reference_impl.collide.pair import Found, Limits, Pair
from reference_impl.errors import Unsupported
from reference_impl.kernels import angular_velocity, apply, cross, dot, kernel, matrix, norm
from reference_impl.parts import Parts
from reference_impl.segments import where
from reference_impl.state import Motion

LONGER = 1e-9  # by which a tether may be too long at the start [its length]


class Cord(Pair):
    """One tether as a pair whose gap is the slack."""

    single = True

    def __init__(self, kinds: np.ndarray, reals: np.ndarray) -> None:
        self.kinds, self.reals = kinds, reals  # (1, 5) and (1, 14), see `collide.features`

    def contacts(self, a: int, b: int, x: np.ndarray, rotation: np.ndarray, reach: float) -> Found:
        """The tether if it is taut within `reach` [m], else no contact."""
        real = self.reals[0]
        r = x[a] - x[b] + (rotation[a] @ real[0:3] - rotation[b] @ real[6:9])
        taut = int(real[12] - math.sqrt(float(r @ r)) <= reach)
        return self.kinds[:taut], self.reals[:taut]

    def approach(self, a: int, b: int, t: float, end: float, m: Motion, limits: Limits) -> tuple[float, int, int]:
        """Time until which the tether is slack, or goes taut."""
        return slack(
            t, end, m.begin[a], m.x_series[a], m.q_series[a], m.bounds[a], m.begin[b], m.x_series[b], m.q_series[b],
            m.bounds[b], self.reals[0], *limits[:2],
        )  # fmt: skip

    def gap(self, a: int, b: int, t: float, m: Motion) -> tuple[float, float]:
        """Slack [m] and its rate [m/s]."""
        r, dr = np.empty(3), np.empty(3)
        _apart(t, m.begin[a], m.x_series[a], m.q_series[a], m.begin[b], m.x_series[b], m.q_series[b], self.reals[0],
               r, dr)  # fmt: skip
        distance = math.sqrt(float(r @ r))
        return float(self.reals[0, 12]) - distance, -float(r @ dr) / distance if distance else 0.0


class Cords(NamedTuple):
    """Tethers of a scene."""

    ends: np.ndarray  # (c, 2) bodies a and b
    kinds: np.ndarray  # (c, 5) and
    reals: np.ndarray  # (c, 14) as contacts, see `collide.features`
    restitution: np.ndarray  # (c,)

    def routines(self) -> list[Cord]:
        """The tethers as pairs."""
        return [Cord(self.kinds[k : k + 1], self.reals[k : k + 1]) for k in range(len(self.ends))]


def parts(scene: Scene, effect: Tether) -> Parts:
    """One tether; none between fixed bodies.

    Raises
    ------
    Unsupported
        If its anchors are further apart at the start than it is long, or both bodies are fixed and one moves.
    """
    ends = (scene.index(effect.a), scene.index(effect.b))
    bodies = [scene.bodies[i] for i in ends]
    anchors = (effect.anchor_a, effect.anchor_b)
    places = [
        np.array(body.position) + rotate(np.array(body.orientation), np.array(anchor))
        for body, anchor in zip(bodies, anchors, strict=True)
    ]
    distance = float(np.linalg.norm(places[0] - places[1]))
    who = f"Tether between {effect.a!r} and {effect.b!r}"
    if distance > effect.length * (1.0 + LONGER):
        raise Unsupported(f"{who}: its anchors are {distance:.9g} m apart at the start; allowed: {effect.length:.9g} m")
    if all(body.fixed for body in bodies):
        if any(any(body.velocity) or any(body.acceleration) for body in bodies):
            raise Unsupported(f"{who}: both are fixed and one of them moves; allowed: one body with a mass")
        return Parts()
    kinds = np.array([[*ends, CORD, 0, 0]], dtype=np.int64)
    reals = np.zeros((1, REAL))
    reals[0, 0:3], reals[0, 6:9], reals[0, 12] = *anchors, effect.length
    cord = Cords(np.array([ends], dtype=np.int64), kinds, reals, np.array([effect.restitution]))
    return Parts(cords=(cord,))


def all_of(parts: tuple[Cords, ...]) -> Cords:
    """Several tethers as one array, numbered in their order."""
    empty = Cords(
        np.zeros((0, 2), dtype=np.int64), np.zeros((0, WHOLE), dtype=np.int64), np.zeros((0, REAL)), np.zeros(0)
    )
    cords = Cords(*(np.concatenate(arrays) for arrays in zip(empty, *parts, strict=True)))
    cords.kinds[:, 3] = np.arange(len(cords.kinds))
    return cords


@kernel
def _taut(distance, along, square, k, gap):
    """Greatest root s >= 0 of |r + r' s| + ½ k s² = |r| + gap [s]; inf if there is none.

    `distance` = |r|, `along` = r·r', `square` = |r'|² and gap >= 0.  The growth of the distance is written so that
    it does not cancel.  Newton's method from above, where a convex function lets it come down without passing the root.
    """
    if k == 0.0:
        if square == 0.0:
            return np.inf
        room = gap * (2.0 * distance + gap)
        root = math.sqrt(along * along + square * room)
        return room / (root + along) if along > 0.0 else (root - along) / square
    # |r + r' s| >= |r'| s - |r|, so the root of this bound lies above
    most = 2.0 * distance + gap
    s = 2.0 * most / (math.sqrt(square) + math.sqrt(square + 2.0 * k * most))
    for _ in range(100):
        growth = (2.0 * along + square * s) * s
        far = math.sqrt(max(distance * distance + growth, 0.0))
        if far == 0.0:
            return s
        value = growth / (far + distance) - gap + 0.5 * k * s * s
        slope = (along + square * s) / far + k * s
        if value <= 0.0 or slope <= 0.0:
            return s
        new = s - value / slope
        if not new < s:
            return s
        s = max(new, 0.0)
    return s


@kernel
def _apart(t, begin_a, xs_a, qs_a, begin_b, xs_b, qs_b, reals, r, dr):
    """Writes the way from the anchor of b to that of a at time t of the segments [m], and its rate [m/s]."""
    xa, va, qa, ga = np.empty(3), np.empty(3), np.empty(4), np.empty(4)
    xb, vb, qb, gb = np.empty(3), np.empty(3), np.empty(4), np.empty(4)
    where(t - begin_a, xs_a, qs_a, xa, va, qa, ga)
    where(t - begin_b, xs_b, qs_b, xb, vb, qb, gb)
    arm_a, arm_b = apply(matrix(qa), reals[0:3]), apply(matrix(qb), reals[6:9])
    spin_a, spin_b = cross(angular_velocity(qa, ga), arm_a), cross(angular_velocity(qb, gb), arm_b)
    for c in range(3):
        r[c] = xa[c] - xb[c] + (arm_a[c] - arm_b[c])
        dr[c] = va[c] - vb[c] + (spin_a[c] - spin_b[c])


@kernel
def slack(
    t, end, begin_a, xs_a, qs_a, bounds_a, begin_b, xs_b, qs_b, bounds_b, reals, tolerance, speed
):  # fmt: skip
    """Time until which a tether stays slack, or the time it goes taut.

    Parameters
    ----------
    t, end : float
        Search from t to end [s].
    reals : (14,) array
        The tether as a contact.

    Returns
    -------
    time [s], CLEAR or HIT or TIRED, number of evaluations
    """
    r, dr = np.empty(3), np.empty(3)
    length = reals[12]
    k = bounds_a[3] + bounds_b[3]
    square = 0.0
    for c in range(3):
        square += (bounds_a[c] - bounds_b[c]) ** 2
    k += math.sqrt(square)
    k += norm(reals[0:3]) * (bounds_a[4] ** 2 + bounds_a[5]) + norm(reals[6:9]) * (bounds_b[4] ** 2 + bounds_b[5])
    for count in range(1, EVALUATIONS + 1):
        _apart(t, begin_a, xs_a, qs_a, begin_b, xs_b, qs_b, reals, r, dr)
        distance = norm(r)
        gap, along = length - distance, dot(r, dr)
        rate = -along / distance if distance > 0.0 else 0.0
        room = max(gap, 0.0)  # one that is too long by rounding may be so again
        if gap <= tolerance and abs(rate) <= speed:
            room += tolerance  # neither parting nor not: it may dip by that much, or the search would stand still
        s = _taut(distance, along, dot(dr, dr), k, room)
        if t + s >= end:
            return end, CLEAR, count
        if gap <= tolerance and rate < -speed:
            return t + (s if gap > 0.0 else 0.0), HIT, count
        t += max(s, 1e-16 * (1.0 + abs(t)))
    return t, TIRED, EVALUATIONS
