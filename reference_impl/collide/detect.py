"""Pairs of bodies: which touch now, and when the others will.

What a pair of shapes does is in `pairs`, one routine for each combination.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from mechanics.scene import Scene
from reference_impl.advancement import HIT
from reference_impl.collide import primitives
from reference_impl.collide.features import REAL, WHOLE, all_kinematics
from reference_impl.collide.pair import Pair, Shapes
from reference_impl.collide.pairs import pairs_of
from reference_impl.kernels import matrix
from reference_impl.state import Bodies, Motion
from reference_impl.time_of_contact import BRACKETED, Bracket

if TYPE_CHECKING:
    from reference_impl.effects.tether import Cords

COARSE = 1e-2  # gap at which the advancement leaves the rest to another method [smallest body size]
DOUBLINGS = 8  # of the width of a bracket


class Contacts(NamedTuple):
    """m touching features, as `collide.features` lays them out."""

    kinds: np.ndarray  # (m, 5) whole numbers
    reals: np.ndarray  # (m, 14)
    pairs: np.ndarray  # (m,) number of the pair each belongs to

    def chosen(self, which: np.ndarray) -> Contacts:
        """The contacts selected by a boolean or index array."""
        return Contacts(self.kinds[which], self.reals[which], self.pairs[which])


class Kinematics(NamedTuple):
    """Where m contacts are and how their gaps change."""

    normal: np.ndarray  # (m, 3) unit, from b to a
    point: np.ndarray  # (m, 3) [m]
    gap: np.ndarray  # (m,) [m]
    rate: np.ndarray  # (m,) gap' [m/s]
    bias: np.ndarray  # (m,) gap'' of the velocities alone [m/s2]


@dataclass
class Search:
    """How contacts are looked for.

    Attributes
    ----------
    method : str
        One of `time_of_contact.METHODS`.
    tolerance : float
        Gap at which a contact counts as reached [m].
    touch : float
        Features closer than this touch [m].
    speed : float
        Slower approach counts as none [m/s].
    parting : float
        Slower separation of touching features counts as none [m/s].
    coarse : float
        Gap at which the advancement leaves the rest to another method [m].
    evaluations : int
        Of the gap so far.
    refinements : int
        Those of them that another method than the advancement made, in `brackets` brackets.
    """

    method: str
    tolerance: float
    touch: float
    speed: float
    parting: float
    coarse: float = 0.0
    evaluations: int = 0
    refinements: int = 0
    brackets: int = 0


def rotations(q: np.ndarray) -> np.ndarray:
    """Rotation matrices (n, 3, 3) of quaternions (n, 4)."""
    return np.array([matrix(one) for one in q])


def kinematics(contacts: Contacts, x: np.ndarray, rotation: np.ndarray, v: np.ndarray, w: np.ndarray) -> Kinematics:
    """Normals, points, gaps, rates and biases of the contacts for bodies with this state."""
    m = len(contacts.kinds)
    out = Kinematics(np.empty((m, 3)), np.empty((m, 3)), np.empty(m), np.empty(m), np.empty(m))
    all_kinematics(contacts.kinds, contacts.reals, x, rotation, v, w, *out)
    return out


class Detector:
    """Contact geometry of one scene.

    Raises
    ------
    Unsupported
        If bodies may touch whose shapes have no contact routine for each other.
    """

    def __init__(self, scene: Scene, bodies: Bodies, search: Search, cords: Cords) -> None:
        self.search, self.cords = search, cords
        self.shapes = Shapes(scene, bodies)
        routines, pairs = pairs_of(scene, self.shapes)
        self.solid = len(pairs)  # pairs whose shapes may touch; the tethers follow
        self.routines = routines + cords.routines()
        self.pairs = np.concatenate([pairs, cords.ends])
        self.lateral = search.touch
        self._near = np.empty(len(self.pairs), dtype=np.int64)

    @property
    def bodies(self) -> Bodies:
        """The bodies with the loads that act now."""
        return self.shapes.bodies

    @bodies.setter
    def bodies(self, bodies: Bodies) -> None:
        self.shapes.bodies = bodies

    def contacts(self, x: np.ndarray, rotation: np.ndarray, dirty: np.ndarray) -> Contacts:
        """All touching features of the bodies that are `dirty` and of every moving body they touch, and so on.

        `dirty` (boolean, one per body) is extended to that whole cluster.  Fixed bodies do not pass it on.
        """
        found: dict[int, tuple[np.ndarray, np.ndarray]] = {}
        fresh = dirty.copy()
        b = self.bodies
        while fresh.any():
            count = primitives.near(
                x, b.shape, b.normal, b.reach, fresh, self.pairs[: self.solid], self.search.touch, self._near
            )
            held = self.solid + np.flatnonzero(fresh[self.cords.ends].any(axis=1))
            fresh[:] = False
            for p in self._near[:count].tolist() + held.tolist():
                if p in found:
                    continue
                found[p] = self.routines[p].contacts(*self.pairs[p].tolist(), x, rotation, self.search.touch)
                if len(found[p][0]):
                    for body in self.pairs[p].tolist():
                        if not dirty[body] and b.inverse_mass[body] > 0.0:
                            dirty[body] = fresh[body] = True
        order = [p for p in sorted(found) if len(found[p][0])]
        if not order:
            return Contacts(np.zeros((0, WHOLE), dtype=np.int64), np.zeros((0, REAL)), np.zeros(0, dtype=np.int64))
        return Contacts(
            np.concatenate([found[p][0] for p in order]),
            np.concatenate([found[p][1] for p in order]),
            np.concatenate([np.full(len(found[p][0]), p) for p in order]),
        )

    def meet(self, p: int, t: float, end: float, motion: Motion, touching: bool) -> tuple[float, bool]:
        """Time until which pair p is clear, at most `end`, and whether it hits then.

        With `touching` the features that touch at time t are held by contact forces and not looked at.
        """
        search, routine = self.search, self.routines[p]
        a, b = self.pairs[p].tolist()
        if touching and routine.single:
            return end, False
        refined = search.method != "advancement" and not touching
        if not refined:
            exact = routine.exact(a, b, t, motion, search.tolerance, search.speed)
            if exact is not None:
                search.evaluations += 1
                return (exact, True) if exact < end else (end, False)
        tolerance = search.coarse if refined else search.tolerance
        time, found, count = routine.approach(
            a, b, t, end, motion, (tolerance, search.speed, touching, search.touch, search.parting)
        )
        search.evaluations += count
        if refined and found == HIT:
            bracket = self._bracket(routine, a, b, time, end, motion)
            if bracket is not None:
                return self._refined(routine, a, b, bracket, motion), True
            time, found, count = routine.approach(
                a, b, t, end, motion, (search.tolerance, search.speed, touching, search.touch, search.parting)
            )
            search.evaluations += count
        return time, found == HIT

    def gap(self, p: int, t: float, m: Motion) -> tuple[float, float]:
        """Gap of pair p at time t of its segments [m] and its rate [m/s]; of boxes, along the axis that separates most.

        Of solids it is the least of all separations of their cells, which is zero when they touch.
        """
        a, b = self.pairs[p].tolist()
        return self.routines[p].gap(a, b, t, m)

    def margin(self, contacts: Contacts, k: int, x: np.ndarray, rotation: np.ndarray) -> float:
        """How far inside its features contact k lies [m]; negative once they no longer face each other."""
        return self.routines[contacts.pairs[k]].margin(contacts.kinds[k], contacts.reals[k], x, rotation)

    def bounded(self, contacts: Contacts) -> np.ndarray:
        """Which contacts can slide off their features."""
        return np.array([self.routines[p].bounded for p in contacts.pairs.tolist()], dtype=bool)

    def overlap(self, p: int, x: np.ndarray, rotation: np.ndarray) -> float:
        """How deep the bodies of pair p are in each other beyond what `contacts` looks at [m]; 0 if they are not."""
        a, b = self.pairs[p].tolist()
        return self.routines[p].overlap(a, b, x, rotation, self.search.touch)

    def _bracket(self, routine: Pair, a: int, b: int, time: float, end: float, m: Motion) -> Bracket | None:
        """Times before and after the gap closes, from `time` on; None if it does not soon."""
        gap, rate = routine.gap(a, b, time, m)
        self.search.evaluations += 1
        if gap <= self.search.tolerance or rate >= 0.0:
            return None
        width = max(1.5 * gap, self.search.coarse) / -rate  # as far as the advancement left it, at the least
        for _ in range(DOUBLINGS):
            high = min(time + width, end)
            overlap, _ = routine.gap(a, b, high, m)
            self.search.evaluations += 1
            if overlap < 0.0:
                return Bracket(time, high, gap, rate, overlap)
            if high == end:
                return None
            width *= 2.0
        return None

    def _refined(self, routine: Pair, a: int, b: int, bracket: Bracket, m: Motion) -> float:
        search = self.search
        time, count = BRACKETED[search.method](lambda s: routine.gap(a, b, s, m), bracket, search.tolerance)
        search.evaluations += count
        search.refinements += count
        search.brackets += 1
        return time
