"""Which features of which bodies are closer than a given reach, at one instant: what fixed steps look at.

Spheres, boxes and half-spaces have their own routines (`primitives`, `boxes`).  A mesh meets others with
its vertices, and they meet it in its distance field: every vertex of one, corner of a box or centre of a
sphere is a contact if the distance of the other says so.  Two edges that cross with no vertex inside
are not seen.
"""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

import numpy as np

from mechanics.scene import Scene
from mechanics.shapes import Box, HalfSpace, Mesh, Shape, Sphere
from reference_impl.collide.boxes import box_box
from reference_impl.collide.features import REAL, WHOLE, all_kinematics
from reference_impl.collide.field import Field, box_distance, field_of
from reference_impl.collide.primitives import box_plane, sphere_box, sphere_plane, sphere_sphere
from reference_impl.effects.resting import Pose
from reference_impl.errors import Unsupported
from reference_impl.kernels import kernel, norm
from reference_impl.state import BOX, PLANE, SOLID, SPHERE, Bodies

MOST = 40  # contacts of one pair of primitives
LATERAL = 1e-9  # a corner counts as on a face that far beyond its border [size of the smallest body]
CELLS = 48  # of the field of a mesh, along its greatest extent


class Touch(NamedTuple):
    """m features within reach."""

    ends: np.ndarray  # (m, 2) bodies a and b
    normal: np.ndarray  # (m, 3) unit, from b to a
    point: np.ndarray  # (m, 3) [m]
    gap: np.ndarray  # (m,) [m], negative in overlap


class Overlaps:
    """Contact geometry of one scene.

    Raises
    ------
    Unsupported
        For a body that may touch another and is no Sphere, Box, HalfSpace or Mesh.
    """

    def __init__(self, scene: Scene, bodies: Bodies) -> None:
        self.scene, self.bodies = scene, bodies
        pairs, self.fielded = [], []
        for i, j in scene.pairs():
            for k in (i, j):
                body = scene.bodies[k]
                if not isinstance(body.shape, (Sphere, Box, HalfSpace, Mesh)):
                    kind = type(body.shape).__name__
                    raise Unsupported(f"contact of body {body.name!r}, a {kind}: only Sphere, Box, HalfSpace and Mesh")
            if SOLID in (bodies.shape[i], bodies.shape[j]):
                self.fielded.append((i, j))
            else:
                pairs.append((i, j) if bodies.shape[i] <= bodies.shape[j] else (j, i))
        self.pairs = np.array(pairs, dtype=np.int64).reshape(-1, 2)
        self.local = np.array([getattr(body.shape, "normal", (0.0, 0.0, 0.0)) for body in scene.bodies])
        self.lateral = LATERAL * min((float(bodies.reach[i]) for i in scene.moving), default=1.0)
        self._kinds = np.zeros((MOST * len(pairs) + 1, WHOLE), dtype=np.int64)
        self._reals = np.zeros((MOST * len(pairs) + 1, REAL))
        self._fields: dict[int, Field] = {}

    def features(self, pose: Pose, reach: float) -> tuple[np.ndarray, np.ndarray]:
        """Contacts of spheres, boxes and half-spaces with a gap of at most `reach` [m], as `features` lays them out."""
        b = self.bodies
        n = _features(self.pairs, pose.x, pose.rotation, b.shape, b.half, b.radius, b.normal, self.local, b.reach,
                      reach, self.lateral, self._kinds, self._reals)  # fmt: skip
        return self._kinds[:n].copy(), self._reals[:n].copy()

    def find(self, pose: Pose, reach: float) -> Touch:
        """All contacts with a gap of at most `reach` [m], those of meshes included."""
        kinds, reals = self.features(pose, reach)
        m = len(kinds)
        touch = Touch(kinds[:, :2], np.empty((m, 3)), np.empty((m, 3)), np.empty(m))
        all_kinematics(kinds, reals, pose.x, pose.rotation, pose.v, pose.w, touch.normal, touch.point, touch.gap,
                       np.empty(m), np.empty(m))  # fmt: skip
        found = [touch]
        for i, j in self.fielded:
            if np.linalg.norm(pose.x[i] - pose.x[j]) <= self.bodies.reach[i] + self.bodies.reach[j] + reach:
                found += [self._points_in(a, b, pose, reach) for a, b in ((i, j), (j, i))]
        return Touch(*(np.concatenate(parts) for parts in zip(*found, strict=True)))

    def _points_in(self, a: int, b: int, pose: Pose, reach: float) -> Touch:
        """The points of body a that are inside body b, or within reach of it."""
        points, radius = _points(self.scene.bodies[a].shape)
        world = points @ pose.rotation[a].T + pose.x[a]
        local = (world - pose.x[b]) @ pose.rotation[b]
        which, gap, gradient = self._distance(b, local, reach + radius)
        normal = gradient @ pose.rotation[b].T
        gap = gap - radius
        near = gap <= reach
        which, gap, normal = which[near], gap[near], normal[near]
        ends = np.tile(np.array([a, b]), (len(which), 1))
        return Touch(ends, normal, world[which] - radius * normal, gap)

    def _distance(self, b: int, points: np.ndarray, reach: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Which of `points` (body frame) are near body b, their distances from it and unit gradients."""
        shape = self.scene.bodies[b].shape
        everything = np.arange(len(points))
        match shape:
            case HalfSpace(normal):
                return everything, points @ np.array(normal), np.tile(normal, (len(points), 1))
            case Sphere(radius):
                distance = np.linalg.norm(points, axis=1)
                return everything, distance - radius, points / np.maximum(distance, 1e-300)[:, None]
            case Box(size):
                half = 0.5 * np.array(size)
                return everything, box_distance(points, half), _box_gradient(points, half)
        field = self._fields.setdefault(b, field_of(shape, CELLS)) if b not in self._fields else self._fields[b]
        which = np.flatnonzero(field.contains(points))
        gap, gradient = field.gap_and_gradient(points[which])
        near = gap <= reach
        which, gap, gradient = which[near], gap[near], gradient[near]
        return which, gap, gradient / np.maximum(np.linalg.norm(gradient, axis=1), 1e-300)[:, None]


def _points(shape: Shape) -> tuple[np.ndarray, float]:
    """Points that stand for a body, and by how much they are widened [m]; a half-space has none."""
    match shape:
        case Sphere(radius):
            return np.zeros((1, 3)), radius
        case Box(size):
            return 0.5 * np.array(size) * np.array(list(product((-1.0, 1.0), repeat=3))), 0.0
        case Mesh(vertices):
            return np.array(vertices), 0.0
    return np.zeros((0, 3)), 0.0


def _box_gradient(points: np.ndarray, half: np.ndarray) -> np.ndarray:
    """Unit gradient (m, 3) of the distance from a box; inside, that of the nearest face."""
    excess = np.abs(points) - half
    out = np.maximum(excess, 0.0)
    inside = ~(out > 0.0).any(axis=1)
    out[inside, np.argmax(excess[inside], axis=1)] = 1.0
    return np.where(points < 0.0, -out, out) / np.linalg.norm(out, axis=1)[:, None]


@kernel
def _features(pairs, x, rotation, shape, half, radius, normal, local, bound, reach, lateral, kinds, reals):
    count = 0
    for p in range(len(pairs)):
        a, b = pairs[p, 0], pairs[p, 1]
        if shape[b] != PLANE and norm(x[a] - x[b]) > bound[a] + bound[b] + reach:
            continue
        if shape[a] == SPHERE and shape[b] == SPHERE:
            count = sphere_sphere(a, b, x[a], x[b], radius[a], radius[b], reach, kinds, reals, count)
        elif shape[a] == SPHERE and shape[b] == PLANE:
            count = sphere_plane(a, b, x[a], x[b], radius[a], normal[b], local[b], reach, kinds, reals, count)
        elif shape[a] == SPHERE:
            count = sphere_box(a, b, x[a], x[b], rotation[b], radius[a], half[b], reach, kinds, reals, count)
        elif shape[b] == PLANE:
            count = box_plane(a, b, x[a], rotation[a], half[a], x[b], normal[b], local[b], reach, kinds, reals, count)
        elif shape[a] == BOX:
            count, _ = box_box(
                a, b, x[a], rotation[a], half[a], x[b], rotation[b], half[b], reach, lateral, kinds, reals, count
            )
    return count
