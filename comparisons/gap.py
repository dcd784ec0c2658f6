"""Gaps between bodies, from their poses alone.

The gap is negative in overlap, and then it is minus the shortest translation that parts the bodies, to
rounding.  When they are apart, the gap is exact for pairs with a sphere, a capsule or a half-space, and
for two polytopes (boxes, convex meshes) a lower bound of the distance that is positive exactly when they
are apart.  Everything is vectorised over time.

Not measured, and named by `unmeasurable`: a cylinder with anything but a sphere or a half-space, and a
mesh that is not convex with anything but a half-space.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from comparisons.convex import polytope, segment, separation
from mechanics.arrays import Quats, Scalars, Vectors
from mechanics.rotation import rotate, unrotate
from mechanics.scene import Scene
from mechanics.shapes import Box, Capsule, Cylinder, HalfSpace, Mesh, Shape, Sphere, bounding_radius


class Pose(NamedTuple):
    """Positions and orientations of one body at T times."""

    x: Vectors  # (T, 3) [m]
    q: Quats  # (T, 4), body to world

    def at(self, rows: np.ndarray) -> Pose:
        """The pose at some of the times."""
        return Pose(self.x[rows], self.q[rows])


class Overlap(NamedTuple):
    """Two bodies that overlap."""

    a: str
    b: str
    depth: float  # [m]


def unmeasurable(a: Shape, b: Shape) -> str | None:
    """Why the gap between two shapes cannot be measured, or None if it can."""
    if _law(a, b) or _law(b, a):
        return None
    names = " and ".join(
        f"{type(s).__name__}{' that is not convex' if isinstance(s, Mesh) and not s.convex else ''}" for s in (a, b)
    )
    return f"no gap between {names}"


def gap(a: Shape, b: Shape, pose_a: Pose, pose_b: Pose) -> Scalars:
    """(T,) gap between two bodies [m], negative in overlap.

    Raises
    ------
    ValueError
        For a pair of shapes that is not measured (see `unmeasurable`).
    """
    law = _law(a, b)
    if law:
        return law(a, b, pose_a, pose_b)
    law = _law(b, a)
    if law:
        return law(b, a, pose_b, pose_a)
    raise ValueError(unmeasurable(a, b))


def bounded_gap(a: Shape, b: Shape, pose_a: Pose, pose_b: Pose) -> Scalars:
    """(T,) the gap [m] where the bounding balls meet; elsewhere that of the balls, which is a positive lower bound."""
    if HalfSpace in (type(a), type(b)):
        return gap(a, b, pose_a, pose_b)
    apart = np.linalg.norm(pose_a.x - pose_b.x, axis=1) - bounding_radius(a) - bounding_radius(b)
    near = np.flatnonzero(~(apart > 0.0))
    if len(near):
        apart[near] = gap(a, b, pose_a.at(near), pose_b.at(near))
    return apart


def surface_distance(shape: Shape, pose: Pose, point: Vectors) -> tuple[Scalars, Vectors]:
    """Distance of a point from the surface of a body, negative inside [m], and the outward normal there.

    Parameters
    ----------
    shape : Sphere, Box, Capsule, Cylinder, HalfSpace or convex Mesh
    pose : Pose
    point : (T, 3) array, world [m]

    Returns
    -------
    (T,) distances, (T, 3) unit normals in the world frame (at a centre or an axis, where the normal
    is any, one of them).
    """
    match shape:
        case HalfSpace(normal):
            n = rotate(pose.q, np.array(normal))
            return np.einsum("ti,ti->t", n, point - pose.x), n
        case Sphere(radius):
            return _from_core(point - pose.x, radius)
    body = unrotate(pose.q, point - pose.x)
    match shape:
        case Capsule(radius, length):
            along = np.clip(body[:, 2], -0.5 * length, 0.5 * length)
            distance, normal = _from_core(body - along[:, None] * [0.0, 0.0, 1.0], radius)
        case Box(size):
            distance, normal = _from_box(body, 0.5 * np.array(size))
        case Cylinder(radius, length):
            across = np.linalg.norm(body[:, :2], axis=1)
            flat = np.stack([across, body[:, 2]], axis=1)
            distance, slope = _from_box(flat, np.array([radius, 0.5 * length]))
            outward = body[:, :2] / np.where(across > 0.0, across, 1.0)[:, None]
            normal = np.concatenate([outward * slope[:, :1], slope[:, 1:]], axis=1)
        case Mesh():
            distance, normal = _from_mesh(shape, body)
    return distance, rotate(pose.q, normal)


def overlaps(scene: Scene) -> tuple[Overlap, ...]:
    """Pairs of bodies that may touch and overlap at the start by more than 1e-9 of the smaller one's size."""
    found = []
    for i, j in scene.pairs():
        a, b = scene.bodies[i], scene.bodies[j]
        if unmeasurable(a.shape, b.shape):
            continue
        poses = (Pose(np.array([body.position]), np.array([body.orientation])) for body in (a, b))
        depth = -float(bounded_gap(a.shape, b.shape, *poses)[0])
        if depth > 1e-9 * min(bounding_radius(a.shape), bounding_radius(b.shape)):
            found.append(Overlap(a.name, b.name, depth))
    return tuple(found)


Law = Callable[[Shape, Shape, Pose, Pose], Scalars]


def _law(a: Shape, b: Shape) -> Law | None:
    """How the gap of these two shapes is computed, in this order; None if it is not known."""
    if isinstance(b, HalfSpace):
        return None if isinstance(a, HalfSpace) else _above_plane
    if any(isinstance(s, Mesh) and not s.convex for s in (a, b)):
        return None
    if isinstance(a, Sphere):
        return _sphere_gap
    table: dict[tuple[type, type], Law] = {
        (Capsule, Capsule): _capsule_gap,
        (Capsule, Box): _capsule_polytope_gap,
        (Capsule, Mesh): _capsule_polytope_gap,
        (Box, Box): _polytope_gap,
        (Box, Mesh): _polytope_gap,
        (Mesh, Mesh): _polytope_gap,
    }
    return table.get((type(a), type(b)))


def _sphere_gap(a: Shape, b: Shape, pose_a: Pose, pose_b: Pose) -> Scalars:
    return surface_distance(b, pose_b, pose_a.x)[0] - a.radius  # type: ignore[union-attr]


def _above_plane(a: Shape, b: Shape, pose_a: Pose, pose_b: Pose) -> Scalars:
    """Height of the lowest point of `a` above the half-space `b`."""
    height, n = surface_distance(b, pose_b, pose_a.x)
    down = unrotate(pose_a.q, n)
    match a:
        case Sphere(radius):
            return height - radius
        case Box(size):
            return height - np.abs(down) @ (0.5 * np.array(size))
        case Capsule(radius, length):
            return height - 0.5 * length * np.abs(down[:, 2]) - radius
        case Cylinder(radius, length):
            return height - 0.5 * length * np.abs(down[:, 2]) - radius * np.hypot(down[:, 0], down[:, 1])
        case Mesh(vertices):
            return height + (down @ np.array(vertices).T).min(axis=1)
    raise ValueError(unmeasurable(a, b))


def _polytope_gap(a: Shape, b: Shape, pose_a: Pose, pose_b: Pose) -> Scalars:
    return separation(polytope(a), polytope(b), *pose_a, *pose_b)  # type: ignore[arg-type]


def _capsule_gap(a: Capsule, b: Capsule, pose_a: Pose, pose_b: Pose) -> Scalars:
    return _segment_distance(*_ends(a, pose_a), *_ends(b, pose_b)) - a.radius - b.radius


def _capsule_polytope_gap(a: Capsule, b: Box | Mesh, pose_a: Pose, pose_b: Pose) -> Scalars:
    """From the axis to the polytope: the depth if it pierces it, else the distance to faces and edges."""
    solid = polytope(b)
    depth = separation(segment(a), solid, *pose_a, *pose_b)
    ends = _ends(a, pose_a)
    distance = np.minimum(*(surface_distance(b, pose_b, end)[0] for end in ends))
    start, stop = (unrotate(pose_b.q, end - pose_b.x) for end in ends)
    for edge in solid.edges:
        corners = (np.broadcast_to(corner, start.shape) for corner in edge)
        distance = np.minimum(distance, _segment_distance(start, stop, *corners))
    return np.where(depth > 0.0, distance, depth) - a.radius


def _ends(capsule: Capsule, pose: Pose) -> tuple[Vectors, Vectors]:
    half = rotate(pose.q, np.array([0.0, 0.0, 0.5 * capsule.length]))
    return pose.x - half, pose.x + half


def _segment_distance(a: Vectors, b: Vectors, c: Vectors, d: Vectors) -> Scalars:
    """(T,) distance between the segments ab and cd.

    The least of the distances of each end from the other segment and of the points of closest approach
    of the lines, where these lie on the segments: each is an upper bound, one of them is attained.
    """
    u, w, r = b - a, d - c, c - a
    uu, ww, uw = (np.einsum("ti,ti->t", p, q) for p, q in ((u, u), (w, w), (u, w)))
    ru, rw = np.einsum("ti,ti->t", r, u), np.einsum("ti,ti->t", r, w)
    across = uu * ww - uw * uw
    safe = np.where(across > 0.0, across, 1.0)
    s, t = np.clip((ru * ww - rw * uw) / safe, 0.0, 1.0), np.clip((ru * uw - rw * uu) / safe, 0.0, 1.0)
    crossing = np.linalg.norm(a + s[:, None] * u - c - t[:, None] * w, axis=1)
    ends = (_to_segment(a, c, w), _to_segment(b, c, w), _to_segment(c, a, u), _to_segment(d, a, u))
    return np.minimum.reduce([crossing, *ends])


def _to_segment(point: Vectors, start: Vectors, along: Vectors) -> Scalars:
    away = point - start
    s = np.clip(np.einsum("ti,ti->t", away, along) / np.einsum("ti,ti->t", along, along), 0.0, 1.0)
    return np.asarray(np.linalg.norm(away - s[:, None] * along, axis=1))


def _from_core(away: Vectors, radius: float) -> tuple[Scalars, Vectors]:
    """Distance from what is rounded with `radius`, given the vector from its core."""
    distance = np.linalg.norm(away, axis=1)
    normal = np.where(distance[:, None] > 0.0, away / np.where(distance > 0.0, distance, 1.0)[:, None], [0.0, 0.0, 1.0])
    return distance - radius, normal


def _from_box(point: np.ndarray, half: np.ndarray) -> tuple[Scalars, np.ndarray]:
    """Distance of (T, k) points from the box of half edges (k,), and the outward normal."""
    beyond = np.abs(point) - half
    outside = np.maximum(beyond, 0.0)
    distance = np.linalg.norm(outside, axis=1)
    face = np.eye(len(half))[np.argmax(beyond, axis=1)]
    towards = np.where((distance > 0.0)[:, None], outside / np.where(distance > 0.0, distance, 1.0)[:, None], face)
    signed = np.where(distance > 0.0, distance, beyond.max(axis=1))
    return signed, towards * np.where(point < 0.0, -1.0, 1.0)


def _from_mesh(mesh: Mesh, point: Vectors) -> tuple[Scalars, Vectors]:
    solid = polytope(mesh)
    heights = point @ solid.normals.T - solid.offsets
    top = np.argmax(heights, axis=1)
    distance, normal = heights[np.arange(len(point)), top], solid.normals[top]
    outside = np.flatnonzero(distance > 0.0)
    if len(outside):
        nearest = _nearest_on_triangles(point[outside], solid.triangles)
        distance[outside], normal[outside] = _from_core(point[outside] - nearest, 0.0)
    return distance, normal


def _nearest_on_triangles(point: Vectors, triangles: np.ndarray) -> Vectors:
    """(T, 3) the point of a surface of triangles (N, 3, 3) that is nearest to each of the points outside it."""
    best, nearest = np.full(len(point), math.inf), np.zeros_like(point)
    for corners in triangles:
        found = _nearest_on_triangle(point, corners)
        distance = np.linalg.norm(point - found, axis=1)
        closer = distance < best
        best[closer], nearest[closer] = distance[closer], found[closer]
    return nearest


def _nearest_on_triangle(point: Vectors, corners: np.ndarray) -> Vectors:
    """The foot on the plane if it lies in the triangle, else the nearest point of an edge."""
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    normal = normal / np.linalg.norm(normal)
    foot = point - ((point - corners[0]) @ normal)[:, None] * normal
    within = np.ones(len(point), dtype=bool)
    best, nearest = np.full(len(point), math.inf), foot.copy()
    for start, stop in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        along = stop - start
        within &= (foot - start) @ np.cross(normal, along) >= 0.0
        s = np.clip((point - start) @ along / (along @ along), 0.0, 1.0)
        candidate = start + s[:, None] * along
        distance = np.linalg.norm(point - candidate, axis=1)
        closer = distance < best
        best[closer], nearest[closer] = distance[closer], candidate[closer]
    return np.where(within[:, None], foot, nearest)
