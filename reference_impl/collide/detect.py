"""Pairs of bodies: which touch now, and when the others will.

A pair is put in the order sphere, box, half-space, so that each combination has one routine.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from mechanics.scene import Scene
from reference_impl.collide import primitives
from reference_impl.collide.features import REAL, WHOLE, all_kinematics
from reference_impl.errors import Unsupported
from reference_impl.kernels import matrix
from reference_impl.state import BOX, OTHER, PLANE, SPHERE, Bodies, Motion
from reference_impl.time_of_contact import HIT, bisection, parabola, spheres_meet

MOST = 40  # contacts of one pair: eight corners of a common polygon and room to spare


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
        "advancement" or "bisection".
    tolerance : float
        Gap at which a contact counts as reached [m].
    touch : float
        Features closer than this touch [m].
    speed : float
        Slower approach counts as none [m/s].
    parting : float
        Slower separation of touching features counts as none [m/s].
    """

    method: str
    tolerance: float
    touch: float
    speed: float
    parting: float
    evaluations: int = 0


def pairs_of(scene: Scene, bodies: Bodies) -> np.ndarray:
    """Pairs of bodies that may touch, (p, 2), each in the order sphere, box, half-space.

    Raises
    ------
    Unsupported
        If a body that may touch another has a shape without contact routines here.
    """
    pairs = []
    for i, j in scene.pairs():
        for k in (i, j):
            if bodies.shape[k] == OTHER:
                body = scene.bodies[k]
                kind = type(body.shape).__name__
                raise Unsupported(f"contact of body {body.name!r}, a {kind}: only Sphere, Box and HalfSpace touch")
        pairs.append((i, j) if bodies.shape[i] <= bodies.shape[j] else (j, i))
    return np.array(pairs, dtype=np.int64).reshape(-1, 2)


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
    """Contact geometry of one scene."""

    def __init__(self, scene: Scene, bodies: Bodies, search: Search) -> None:
        self.bodies, self.search = bodies, search
        self.pairs = pairs_of(scene, bodies)
        self.local = np.zeros((len(scene.bodies), 3))  # normals of half-spaces in their own frame
        for i, body in enumerate(scene.bodies):
            if bodies.shape[i] == PLANE:
                self.local[i] = body.shape.normal
        self.lateral = search.touch
        self._kinds = np.zeros((MOST, WHOLE), dtype=np.int64)
        self._reals = np.zeros((MOST, REAL))
        self._near = np.empty(len(self.pairs), dtype=np.int64)

    def contacts(self, x: np.ndarray, rotation: np.ndarray, dirty: np.ndarray) -> Contacts:
        """All touching features of the bodies that are `dirty` and of every moving body they touch, and so on.

        `dirty` (boolean, one per body) is extended to that whole cluster.  Fixed bodies do not pass it on.
        """
        found: dict[int, tuple[np.ndarray, np.ndarray]] = {}
        fresh = dirty.copy()
        b = self.bodies
        while fresh.any():
            count = primitives.near(x, b.shape, b.normal, b.reach, fresh, self.pairs, self.search.touch, self._near)
            fresh[:] = False
            for p in self._near[:count].tolist():
                if p in found:
                    continue
                found[p] = self._of_pair(p, x, rotation)
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

    def _of_pair(self, p: int, x: np.ndarray, rotation: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        s, touch = self.bodies, self.search.touch
        a, b = self.pairs[p].tolist()
        kinds, reals = self._kinds, self._reals
        shapes = (int(s.shape[a]), int(s.shape[b]))
        if shapes == (SPHERE, SPHERE):
            n = primitives.sphere_sphere(a, b, x[a], x[b], s.radius[a], s.radius[b], touch, kinds, reals, 0)
        elif shapes == (SPHERE, PLANE):
            n = primitives.sphere_plane(
                a, b, x[a], x[b], s.radius[a], s.normal[b], self.local[b], touch, kinds, reals, 0
            )
        elif shapes == (SPHERE, BOX):
            n = primitives.sphere_box(a, b, x[a], x[b], rotation[b], s.radius[a], s.half[b], touch, kinds, reals, 0)
        elif shapes == (BOX, PLANE):
            n = primitives.box_plane(
                a, b, x[a], rotation[a], s.half[a], x[b], s.normal[b], self.local[b], touch, kinds, reals, 0
            )
        else:
            from reference_impl.collide.boxes import box_box

            n, _ = box_box(
                a, b, x[a], rotation[a], s.half[a], x[b], rotation[b], s.half[b], touch, self.lateral, kinds, reals, 0
            )
        return kinds[:n].copy(), reals[:n].copy()

    def meet(self, p: int, t: float, end: float, motion: Motion, touching: bool) -> tuple[float, bool]:
        """Time until which pair p is clear, at most `end`, and whether it hits then.

        With `touching` the features that touch at time t are held by contact forces and not looked at.
        """
        a, b = self.pairs[p].tolist()
        s = self.bodies
        single = s.shape[a] == SPHERE
        if touching and single:  # a sphere touches a convex body at one place only
            return end, False
        if single and self.search.method == "advancement":
            exact = self._exact(a, b, t, motion)
            if exact is not None:
                self.search.evaluations += 1
                return (exact, True) if exact < end else (end, False)
        time, found, count = self._advance(a, b, t, end, motion, touching, self.search.tolerance)
        self.search.evaluations += count
        if found == HIT and self.search.method == "bisection":
            time = self._bisected(a, b, time, end, motion)
        return time, found == HIT

    def _exact(self, a: int, b: int, t: float, motion: Motion) -> float | None:
        """Time of contact of a sphere with a sphere or half-space where the gap is quadratic in time, else None."""
        s, m = self.bodies, motion
        if m.bounds[a, 3] or m.bounds[b, 3] or s.shape[b] == BOX:
            return None
        pull = m.bounds[a, :3] - m.bounds[b, :3]
        (xa, va), (xb, vb) = _place(m, a, t), _place(m, b, t)
        r, v = xa - xb, va - vb
        if s.shape[b] == PLANE:
            n = s.normal[b]
            gap, rate = float(n @ r) - s.radius[a], float(n @ v)
            if gap <= self.search.tolerance and abs(rate) <= self.search.speed and float(n @ pull) >= 0.0:
                return math.inf
            return t + parabola(gap, rate, float(n @ pull))
        if pull.any():
            return None
        if float(r @ v) >= -self.search.speed * math.sqrt(float(r @ r)):
            return math.inf
        return t + spheres_meet(r, v, s.radius[a] + s.radius[b])

    def _advance(
        self, a: int, b: int, t: float, end: float, m: Motion, touching: bool, tolerance: float
    ) -> tuple[float, int, int]:
        from reference_impl.time_of_contact import approach_convex, approach_plane

        s, (speed, reach, parting) = self.bodies, (self.search.speed, self.search.touch, self.search.parting)
        first = (m.begin[a], m.x_series[a], m.q_series[a], s.half[a], s.radius[a], m.bounds[a])
        if s.shape[b] == PLANE:
            return approach_plane(
                t,
                end,
                *first,
                m.begin[b],
                m.x_series[b],
                s.normal[b],
                m.bounds[b],
                tolerance,
                speed,
                touching,
                reach,
                parting,
            )
        second = (m.begin[b], m.x_series[b], m.q_series[b], s.half[b], s.radius[b], m.bounds[b])
        return approach_convex(t, end, *first, *second, tolerance, speed, touching, reach, parting)

    def gap(self, p: int, t: float, m: Motion) -> float:
        """Gap of pair p at time t of its segments [m]; between boxes, the separation along the best axis."""
        a, b = self.pairs[p].tolist()
        return self._gap(a, b, t, m)

    def _gap(self, a: int, b: int, t: float, m: Motion) -> float:
        from reference_impl.time_of_contact import gap_convex, gap_plane

        s = self.bodies
        first = (m.begin[a], m.x_series[a], m.q_series[a], s.half[a], s.radius[a])
        if s.shape[b] == PLANE:
            return float(gap_plane(t, *first, m.begin[b], m.x_series[b], s.normal[b]))
        return float(gap_convex(t, *first, m.begin[b], m.x_series[b], m.q_series[b], s.half[b], s.radius[b]))

    def _bisected(self, a: int, b: int, time: float, end: float, m: Motion) -> float:
        """The contact near `time` by bisection in a bracket opened around it; `time` itself if they only graze."""
        width = 1e-6 * max(end - time, 1e-3)
        low = high = time
        for _ in range(30):
            if self._gap(a, b, low, m) > 0.0 and self._gap(a, b, high, m) < 0.0:
                found, count = bisection(lambda s: self._gap(a, b, s, m), low, high, self.search.tolerance)
                self.search.evaluations += count
                return found
            low, high = time - width, time + width
            width *= 2.0
        return time


def _place(m: Motion, i: int, t: float) -> tuple[np.ndarray, np.ndarray]:
    """Position and velocity of a body on a parabola at time t."""
    s = t - m.begin[i]
    series = m.x_series[i]
    return series[0] + s * (series[1] + s * series[2]), series[1] + 2.0 * s * series[2]
