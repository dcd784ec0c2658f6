"""What two shapes do together: one class for each combination.

A pair is put in the order sphere, box, cylinder, solid, half-space.  A solid is a mesh or capsule; a sphere or
box becomes one beside it.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from functools import cached_property
from typing import Any

import numpy as np

from mechanics.scene import Body, Scene
from mechanics.shapes import Cylinder, Mesh
from reference_impl.broad_phase import all_pairs
from reference_impl.collide import primitives
from reference_impl.collide.features import REAL, WHOLE, margin
from reference_impl.collide.solids import Solid, solid_of
from reference_impl.errors import Unsupported
from reference_impl.state import BOX, CYLINDER, PLANE, SOLID, SPHERE, Bodies, Motion
from reference_impl.time_of_contact import parabola, spheres_meet

ORDER = (SPHERE, BOX, CYLINDER, SOLID, PLANE)
MOST = 40  # contacts of one pair of boxes: eight corners of a common polygon and room to spare
DEEP = 1e-4  # overlap up to which features of solids count as touching [size of the smaller]

Found = tuple[np.ndarray, np.ndarray]  # kinds and reals of contacts
Limits = tuple[float, float, bool, float, float]  # tolerance, speed, touching, reach, parting


class Shapes:
    """What the routines need of the bodies of a scene, made when it is asked for."""

    def __init__(self, scene: Scene, bodies: Bodies) -> None:
        self.scene, self.bodies = scene, bodies
        self.local = np.array([getattr(body.shape, "normal", (0.0, 0.0, 0.0)) for body in scene.bodies])
        self._solids: dict[int, Solid] = {}
        self.kinds, self.reals = np.zeros((MOST, WHOLE), dtype=np.int64), np.zeros((MOST, REAL))

    def solid(self, i: int) -> Solid:
        """Body i as a solid."""
        if i not in self._solids:
            self._solids[i] = solid_of(self.scene.bodies[i].shape)
        return self._solids[i]

    def cylinder(self, i: int) -> tuple[float, float]:
        """Radius and half length of body i [m]."""
        shape = self.scene.bodies[i].shape
        assert isinstance(shape, Cylinder)
        return shape.radius, 0.5 * shape.length

    @cached_property
    def corners(self) -> dict[int, np.ndarray]:
        """Corners of boxes and solids, the centre of spheres; filled by `corners_of`."""
        return {}

    def corners_of(self, i: int) -> np.ndarray:
        """Points whose hull, widened by `radius_of`, body i is (k, 3) [m]."""
        if i not in self.corners:
            if self.bodies.shape[i] == SOLID:
                solid = self.solid(i)
                self.corners[i] = np.ascontiguousarray(solid.points[solid.sharp])
            else:
                out = np.zeros((8 if self.bodies.shape[i] == BOX else 1, 3))
                for j in range(len(out)):
                    primitives.corner(self.bodies.half[i], j, out[j])
                self.corners[i] = out
        return self.corners[i]

    def radius_of(self, i: int) -> float:
        """See `corners_of` [m]."""
        return self.solid(i).radius if self.bodies.shape[i] == SOLID else float(self.bodies.radius[i])


class Pair(ABC):
    """Two shapes a and b; methods take the bodies' numbers in the order of the pair.

    Attributes
    ----------
    single : bool
        Whether they touch at one place at most.
    bounded : bool
        Whether a contact can slide off its features.
    """

    single = False
    bounded = False

    def __init__(self, shapes: Shapes) -> None:
        self.shapes = shapes

    @abstractmethod
    def contacts(self, a: int, b: int, x: np.ndarray, rotation: np.ndarray, reach: float) -> Found:
        """Touching features with a gap of at most `reach` [m]."""

    def exact(self, a: int, b: int, t: float, m: Motion, tolerance: float, speed: float) -> float | None:
        """Time of contact where there is a closed form [s], else None."""
        return None

    @abstractmethod
    def approach(self, a: int, b: int, t: float, end: float, m: Motion, limits: Limits) -> tuple[float, int, int]:
        """Conservative advancement, as `advancement.approach_plane`."""

    @abstractmethod
    def gap(self, a: int, b: int, t: float, m: Motion) -> tuple[float, float]:
        """Gap [m] and its rate [m/s]."""

    def margin(self, kinds: np.ndarray, reals: np.ndarray, x: np.ndarray, rotation: np.ndarray) -> float:
        """How far inside its features a contact lies [m]."""
        return math.inf

    def overlap(self, a: int, b: int, x: np.ndarray, rotation: np.ndarray, slack: float) -> float:
        """Overlap that `contacts` does not see [m]."""
        return 0.0


class _Few(Pair):
    """Two shapes that touch at `MOST` places at most."""

    def contacts(self, a: int, b: int, x: np.ndarray, rotation: np.ndarray, reach: float) -> Found:
        s = self.shapes
        count = self._find(a, b, x, rotation, reach, s.kinds, s.reals)
        return s.kinds[:count].copy(), s.reals[:count].copy()

    @abstractmethod
    def _find(self, a: int, b: int, x: np.ndarray, rotation: np.ndarray, reach: float, kinds: Any, reals: Any) -> int:
        """Write the touching features into `kinds` and `reals`; returns how many there are."""


def _flight(m: Motion, i: int) -> tuple[float, np.ndarray, np.ndarray]:
    return m.begin[i], m.x_series[i], m.q_series[i]


def _place(m: Motion, i: int, t: float) -> tuple[np.ndarray, np.ndarray]:
    """Position and velocity of a body on a parabola at time t."""
    s = t - m.begin[i]
    series = m.x_series[i]
    return series[0] + s * (series[1] + s * series[2]), series[1] + 2.0 * s * series[2]


class _Balls(_Few):
    """Sphere and sphere."""

    single = True

    def _find(self, a, b, x, rotation, reach, kinds, reals):
        s = self.shapes.bodies
        return primitives.sphere_sphere(a, b, x[a], x[b], s.radius[a], s.radius[b], reach, kinds, reals, 0)

    def exact(self, a, b, t, m, tolerance, speed):
        if m.bounds[a, 3] or m.bounds[b, 3] or (m.bounds[a, :3] != m.bounds[b, :3]).any():
            return None
        (xa, va), (xb, vb) = _place(m, a, t), _place(m, b, t)
        r, v = xa - xb, va - vb
        if float(r @ v) >= -speed * math.sqrt(float(r @ r)):
            return math.inf
        return t + spheres_meet(r, v, self.shapes.bodies.radius[a] + self.shapes.bodies.radius[b])

    def approach(self, a, b, t, end, m, limits):
        from reference_impl.advancement_boxes import approach_sphere

        s = self.shapes.bodies
        return approach_sphere(t, end, *_flight(m, a), s.radius[a], m.bounds[a], *_flight(m, b), s.half[b],
                               s.radius[b], m.bounds[b], *limits[:2])  # fmt: skip

    def gap(self, a, b, t, m):
        from reference_impl.advancement_boxes import gap_sphere

        s = self.shapes.bodies
        return gap_sphere(t, *_flight(m, a), s.radius[a], *_flight(m, b), s.half[b], s.radius[b])


class _BallBox(_Balls):
    """Sphere and box."""

    bounded = True

    def _find(self, a, b, x, rotation, reach, kinds, reals):
        s = self.shapes.bodies
        return primitives.sphere_box(a, b, x[a], x[b], rotation[b], s.radius[a], s.half[b], reach, kinds, reals, 0)

    def exact(self, a, b, t, m, tolerance, speed):
        return None

    def margin(self, kinds, reals, x, rotation):
        i, j = kinds[:2].tolist()
        half = self.shapes.bodies.half
        return margin(kinds, reals, x[i], rotation[i], x[j], rotation[j], half[i], half[j])


class _Boxes(_Few):
    """Box and box."""

    bounded = True
    margin = _BallBox.margin

    def _find(self, a, b, x, rotation, reach, kinds, reals):
        from reference_impl.collide.boxes import box_box

        half = self.shapes.bodies.half
        return box_box(
            a, b, x[a], rotation[a], half[a], x[b], rotation[b], half[b], reach, reach, kinds, reals, 0
        )[0]  # fmt: skip

    def approach(self, a, b, t, end, m, limits):
        from reference_impl.advancement_boxes import approach_boxes

        half = self.shapes.bodies.half
        return approach_boxes(t, end, *_flight(m, a), half[a], m.bounds[a], *_flight(m, b), half[b], m.bounds[b],
                              *limits)  # fmt: skip

    def gap(self, a, b, t, m):
        from reference_impl.advancement_boxes import gap_boxes

        half = self.shapes.bodies.half
        return gap_boxes(t, *_flight(m, a), half[a], *_flight(m, b), half[b])


class _Grounded(_Few):
    """Box or solid over a half-space."""

    def _find(self, a, b, x, rotation, reach, kinds, reals):
        s, b_ = self.shapes, self.shapes.bodies
        return primitives.corners_plane(a, b, x[a], rotation[a], s.corners_of(a), s.radius_of(a), x[b], b_.normal[b],
                                        s.local[b], reach, kinds, reals, 0)  # fmt: skip

    def contacts(self, a, b, x, rotation, reach):
        most = len(self.shapes.corners_of(a))
        kinds, reals = np.zeros((most, WHOLE), dtype=np.int64), np.zeros((most, REAL))
        count = self._find(a, b, x, rotation, reach, kinds, reals)
        return kinds[:count], reals[:count]

    def approach(self, a, b, t, end, m, limits):
        from reference_impl.advancement import approach_plane

        s = self.shapes
        return approach_plane(t, end, *_flight(m, a), s.corners_of(a), s.radius_of(a), m.bounds[a], m.begin[b],
                              m.x_series[b], s.bodies.normal[b], m.bounds[b], *limits)  # fmt: skip

    def gap(self, a, b, t, m):
        from reference_impl.advancement import gap_plane

        s = self.shapes
        return gap_plane(t, *_flight(m, a), s.corners_of(a), s.radius_of(a), m.begin[b], m.x_series[b],
                         s.bodies.normal[b])  # fmt: skip


class _BallGround(_Grounded):
    """Sphere over a half-space."""

    single = True

    def _find(self, a, b, x, rotation, reach, kinds, reals):
        s = self.shapes.bodies
        return primitives.sphere_plane(a, b, x[a], x[b], s.radius[a], s.normal[b], self.shapes.local[b], reach, kinds,
                                       reals, 0)  # fmt: skip

    def exact(self, a, b, t, m, tolerance, speed):
        if m.bounds[a, 3] or m.bounds[b, 3]:
            return None
        s = self.shapes.bodies
        n = s.normal[b]
        (xa, va), (xb, vb) = _place(m, a, t), _place(m, b, t)
        gap, rate = float(n @ (xa - xb)) - s.radius[a], float(n @ (va - vb))
        pull = float(n @ (m.bounds[a, :3] - m.bounds[b, :3]))
        if gap <= tolerance and abs(rate) <= speed and pull >= 0.0:
            return math.inf
        return t + parabola(gap, rate, pull)


class _CylinderGround(_Few):
    """Cylinder over a half-space."""

    def _find(self, a, b, x, rotation, reach, kinds, reals):
        from reference_impl.collide.cylinders import cylinder_plane

        s = self.shapes.bodies
        return cylinder_plane(a, b, x[a], rotation[a], *self.shapes.cylinder(a), x[b], s.normal[b],
                              self.shapes.local[b], s.acceleration[a] - s.acceleration[b], reach, kinds, reals,
                              0)  # fmt: skip

    def approach(self, a, b, t, end, m, limits):
        from reference_impl.advancement_rims import approach_rims_plane

        return approach_rims_plane(t, end, *_flight(m, a), *self.shapes.cylinder(a), m.bounds[a], m.begin[b],
                                   m.x_series[b], self.shapes.bodies.normal[b], m.bounds[b], *limits)  # fmt: skip

    def gap(self, a, b, t, m):
        from reference_impl.advancement_rims import gap_rims_plane

        return gap_rims_plane(t, *_flight(m, a), *self.shapes.cylinder(a), m.begin[b], m.x_series[b],
                              self.shapes.bodies.normal[b])  # fmt: skip


class _BallCylinder(_Few):
    """Sphere and cylinder."""

    single = True
    bounded = True

    def _find(self, a, b, x, rotation, reach, kinds, reals):
        from reference_impl.collide.cylinders import sphere_cylinder

        return sphere_cylinder(a, b, x[a], x[b], rotation[b], self.shapes.bodies.radius[a], *self.shapes.cylinder(b),
                               reach, kinds, reals, 0)  # fmt: skip

    def approach(self, a, b, t, end, m, limits):
        from reference_impl.advancement_rims import approach_sphere_cylinder

        return approach_sphere_cylinder(t, end, *_flight(m, a), self.shapes.bodies.radius[a], m.bounds[a],
                                        *_flight(m, b), *self.shapes.cylinder(b), m.bounds[b], *limits[:2])  # fmt: skip

    def gap(self, a, b, t, m):
        from reference_impl.advancement_rims import gap_sphere_cylinder

        return gap_sphere_cylinder(t, *_flight(m, a), self.shapes.bodies.radius[a], *_flight(m, b),
                                   *self.shapes.cylinder(b))  # fmt: skip

    def margin(self, kinds, reals, x, rotation):
        from reference_impl.collide.cylinders import cylinder_margin

        i, j = kinds[:2].tolist()
        return cylinder_margin(kinds[2], rotation[j].T @ (x[i] - x[j]), *self.shapes.cylinder(j))


class _Solids(Pair):
    """Solid and solid, box or sphere."""

    bounded = True

    def contacts(self, a, b, x, rotation, reach):
        from reference_impl.collide.solid_contacts import near_cells, solid_solid

        sa, sb = self.shapes.solid(a), self.shapes.solid(b)
        cells = np.empty((256, 2), dtype=np.int64)
        while (near := near_cells(sa, sb, x[a], rotation[a], x[b], rotation[b], reach, cells)) > len(cells):
            cells = np.empty((near, 2), dtype=np.int64)
        size = DEEP * min(self.shapes.bodies.reach[a], self.shapes.bodies.reach[b])
        most = MOST
        while True:
            kinds, reals = np.zeros((most, WHOLE), dtype=np.int64), np.zeros((most, REAL))
            points, normals = np.empty((most, 4)), np.empty((most, 3))
            count = solid_solid(a, b, sa, x[a], rotation[a], sb, x[b], rotation[b], reach, size, reach, cells[:near],
                                kinds, reals, np.empty(most, dtype=np.bool_), points, normals)  # fmt: skip
            if count < most:
                break
            most *= 4
        if sa.convex and sb.convex and sa.radius + sb.radius == 0.0 and count > 1:
            # each normal alone separates the two: that of the most contacts is the face they share
            same = normals[:count] @ normals[:count].T > 1.0 - 1e-12
            chosen = same[int(np.argmax(same.sum(axis=1)))]
            return kinds[:count][chosen], reals[:count][chosen]
        return kinds[:count], reals[:count]

    def approach(self, a, b, t, end, m, limits):
        from reference_impl.advancement_solids import approach_solids

        s = self.shapes
        return approach_solids(t, end, *_flight(m, a), s.solid(a), m.bounds[a], *_flight(m, b), s.solid(b),
                               m.bounds[b], *limits)  # fmt: skip

    def gap(self, a, b, t, m):
        from reference_impl.advancement_solids import gap_solids

        return gap_solids(t, *_flight(m, a), self.shapes.solid(a), *_flight(m, b), self.shapes.solid(b))

    def margin(self, kinds, reals, x, rotation):
        from reference_impl.collide.solid_contacts import solid_margin

        i, j = kinds[:2].tolist()
        s = self.shapes
        return solid_margin(kinds, reals, s.solid(i), x[i], rotation[i], s.solid(j), x[j], rotation[j])

    def overlap(self, a, b, x, rotation, slack):
        from reference_impl.advancement_solids import separation

        sa, sb, zero = self.shapes.solid(a), self.shapes.solid(b), np.zeros(3)
        gap, _ = separation(x[a] - x[b], zero, rotation[a], zero, sa, rotation[b], zero, sb)
        if gap < -slack:
            return -gap
        return max(self._inside(a, b, x, rotation), self._inside(b, a, x, rotation))

    def _inside(self, a: int, b: int, x: np.ndarray, rotation: np.ndarray) -> float:
        """How deep a point of a is within b while the surfaces do not cross [m]."""
        from reference_impl.collide.field import distance_of

        body: Body = self.shapes.scene.bodies[b]
        if not isinstance(body.shape, Mesh) and self.shapes.bodies.shape[b] != BOX:
            return 0.0
        point = rotation[b].T @ (x[a] + rotation[a] @ self.shapes.solid(a).points[0] - x[b])
        depth = -float(distance_of(body.shape)(point[None])[0])
        return depth if depth > self.shapes.bodies.reach[a] * DEEP else 0.0


TABLE: dict[tuple[int, int], type[Pair]] = {
    (SPHERE, SPHERE): _Balls,
    (SPHERE, BOX): _BallBox,
    (SPHERE, CYLINDER): _BallCylinder,
    (SPHERE, SOLID): _Solids,
    (SPHERE, PLANE): _BallGround,
    (BOX, BOX): _Boxes,
    (BOX, SOLID): _Solids,
    (BOX, PLANE): _Grounded,
    (CYLINDER, PLANE): _CylinderGround,
    (SOLID, SOLID): _Solids,
    (SOLID, PLANE): _Grounded,
}


class Routines:
    """The routine of each pair, of which there may be millions."""

    def __init__(self, made: list[Pair], which: np.ndarray) -> None:
        self._made, self._which = made, which

    def __getitem__(self, p: int) -> Pair:
        return self._made[self._which[p]]

    def __add__(self, others: list[Pair]) -> Routines:
        """These and, after them, one for each of others."""
        if not others:
            return self
        numbers = len(self._made) + np.arange(len(others))
        return Routines(self._made + others, np.concatenate([self._which, numbers]))


def pairs_of(scene: Scene, shapes: Shapes) -> tuple[Routines, np.ndarray]:
    """Pairs of bodies that may touch: the routine of each, and their numbers (p, 2) in its order.

    Raises
    ------
    Unsupported
        If there is no routine for two shapes.
    """
    pairs, shape = all_pairs(scene), shapes.bodies.shape
    rank = np.argsort(ORDER)[shape]
    swapped = rank[pairs[:, 0]] > rank[pairs[:, 1]]
    pairs[swapped] = pairs[swapped, ::-1]
    which = np.full(len(pairs), -1, dtype=np.int8)
    for number, (first, second) in enumerate(TABLE):
        which[(shape[pairs[:, 0]] == first) & (shape[pairs[:, 1]] == second)] = number
    for ends in pairs[which < 0].tolist():
        a, b = (f"{scene.bodies[k].name!r}, a {type(scene.bodies[k].shape).__name__}" for k in ends)
        raise Unsupported(f"contact of {a}, with {b}: a Cylinder touches only Sphere and HalfSpace")
    return Routines([kind(shapes) for kind in TABLE.values()], which), pairs
