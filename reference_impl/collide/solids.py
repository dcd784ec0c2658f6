"""Polyhedra widened by a radius: what boxes, meshes, capsules and spheres have in common.

A `Solid` lists the features that can touch.  Edges between coplanar triangles are none, so that a face that
was cut into triangles is one face; edges and corners that only a hole could touch (concave ones) are left
out or fail the test of their directions.  A tree of balls over the triangles finds those that are near.
"""

from __future__ import annotations

import math
from itertools import product
from typing import NamedTuple

import numpy as np

from mechanics.shapes import Box, Capsule, Mesh, Shape, Sphere
from reference_impl.kernels import kernel

FLAT = 1e-9  # sine of the angle below which two triangles lie in one plane
FLAT_EDGE, CONCAVE_EDGE = -1, -2


class Solid(NamedTuple):
    """v vertices, e convex edges, g plane faces, c cells (triangles; a segment or point repeats vertices).

    All in the body frame [m]; feature numbers are rows of these arrays.
    """

    points: np.ndarray  # (v, 3)
    sharp: np.ndarray  # (v,) whether the vertex is a corner, not a point of a plane face or straight edge
    star_start: np.ndarray  # (v + 1,) first row of each vertex in `star`
    star: np.ndarray  # (k, 3) unit directions from each vertex to its neighbours
    middles: np.ndarray  # (e, 3)
    ways: np.ndarray  # (e, 3) unit
    halves: np.ndarray  # (e,) half lengths
    sides: np.ndarray  # (e, 2, 3) unit, across the edge into either face; zero for a segment
    normals: np.ndarray  # (g, 3) outward, unit
    bases: np.ndarray  # (g, 3) a point of each face
    border_start: np.ndarray  # (g + 1,) first row of each face in `border`
    border: np.ndarray  # (k, 2, 3) ends of the segments that bound each face
    cells: np.ndarray  # (c, 3) vertices
    cell_edges: np.ndarray  # (c, 3) edge from each vertex to the next, or FLAT_EDGE or CONCAVE_EDGE
    cell_face: np.ndarray  # (c,) face, or -1
    ball: np.ndarray  # (2 c - 1, 4) centre and radius of the tree's balls
    child: np.ndarray  # (2 c - 1, 2) balls inside each; a leaf holds (-1, cell)
    radius: float  # by which everything is widened
    convex: bool


def solid_of(shape: Shape) -> Solid:
    """The solid of a Sphere, Box, Capsule or Mesh."""
    match shape:
        case Sphere(radius):
            return _thin(np.zeros((1, 3)), radius)
        case Capsule(radius, length):
            return _thin(np.array([(0.0, 0.0, -0.5 * length), (0.0, 0.0, 0.5 * length)]), radius)
        case Box(size):
            corners = 0.5 * np.array(size) * np.array(list(product((-1.0, 1.0), repeat=3)))
            quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
            return _polyhedron(corners, np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]), True)
        case Mesh(vertices, triangles, convex):
            return _polyhedron(np.array(vertices), np.array(triangles), convex)
    raise TypeError(f"{type(shape).__name__} is no polyhedron")


def _thin(points: np.ndarray, radius: float) -> Solid:
    """A point or a segment along z."""
    segment = len(points) == 2
    up = np.array([(0.0, 0.0, 1.0)])
    edges = (points.mean(axis=0)[None], up, points[1:, 2].copy(), np.zeros((1, 2, 3)))
    none = (np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0), np.zeros((0, 2, 3)))
    return Solid(
        points,
        np.ones(len(points), dtype=np.bool_),
        np.arange(3) if segment else np.zeros(2, dtype=np.int64),
        np.concatenate([up, -up]) if segment else np.zeros((0, 3)),
        *(edges if segment else none),
        np.zeros((0, 3)),
        np.zeros((0, 3)),
        np.zeros(1, dtype=np.int64),
        np.zeros((0, 2, 3)),
        np.array([(0, 1, 1)] if segment else [(0, 0, 0)]),
        np.array([(0, FLAT_EDGE, FLAT_EDGE)] if segment else [(FLAT_EDGE,) * 3]),
        np.array([-1]),
        np.array([(0.0, 0.0, 0.0, points[-1, 2])]),
        np.array([(-1, 0)]),
        float(radius),
        True,
    )


def _polyhedron(points: np.ndarray, triangles: np.ndarray, convex: bool) -> Solid:
    corners = points[triangles]
    area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    size = np.linalg.norm(area, axis=1)
    unit = area / size[:, None]
    owner = {(int(t[k]), int(t[(k + 1) % 3])): (n, k) for n, t in enumerate(triangles) for k in range(3)}
    bend = {edge: _bend(points, triangles, unit, owner, edge) for edge in owner}
    face = _faces(len(triangles), owner, bend)
    cell_edges = np.full((len(triangles), 3), FLAT_EDGE)
    middles, ways, halves, sides = [], [], [], []
    for (i, j), (n, k) in owner.items():
        if bend[i, j] < -FLAT:
            cell_edges[n, k] = CONCAVE_EDGE
        if bend[i, j] <= FLAT or i > j:
            continue
        way = points[j] - points[i]
        length = float(np.linalg.norm(way))
        other, at = owner[j, i]
        cell_edges[n, k] = cell_edges[other, at] = len(halves)
        middles.append(0.5 * (points[i] + points[j]))
        ways.append(way / length)
        halves.append(0.5 * length)
        sides.append([np.cross(unit[n], way) / length, np.cross(way, unit[other]) / length])
    order = np.lexsort((-size, face))
    largest = order[np.searchsorted(face[order], np.arange(face.max() + 1))]
    border = [[] for _ in largest]
    star, rim = [[] for _ in points], [[] for _ in points]
    for (i, j), (n, _) in owner.items():
        way = points[j] - points[i]
        star[i].append(way / np.linalg.norm(way))
        if face[n] != face[owner[j, i][0]]:
            border[face[n]].append(points[[i, j]])
            rim[i].append(star[i][-1])
    ball, child = _tree(corners)
    return Solid(
        np.ascontiguousarray(points),
        np.array([_is_sharp(ways) for ways in rim]),
        np.cumsum([0] + [len(s) for s in star]),
        np.array([way for s in star for way in s]),
        np.array(middles),
        np.array(ways),
        np.array(halves),
        np.array(sides),
        unit[largest],
        corners[largest, 0],
        np.cumsum([0] + [len(b) for b in border]),
        np.array([segment for b in border for segment in b]),
        np.ascontiguousarray(triangles, dtype=np.int64),
        cell_edges,
        face,
        ball,
        child,
        0.0,
        bool(convex),
    )


def _bend(points: np.ndarray, triangles: np.ndarray, unit: np.ndarray, owner: dict, edge: tuple[int, int]) -> float:
    """Sine of the angle by which the surface bends at an edge; positive where it is convex."""
    (n, _), (other, _) = owner[edge], owner[edge[::-1]]
    way = points[edge[1]] - points[edge[0]]
    turn = float(np.cross(unit[n], unit[other]) @ way) / float(np.linalg.norm(way))
    return turn if unit[n] @ unit[other] > 0.0 else math.copysign(1.0, turn)


def _faces(count: int, owner: dict, bend: dict) -> np.ndarray:
    """Number of the plane face of each triangle: neighbours across a flat edge share it."""
    leader = list(range(count))

    def find(n: int) -> int:
        while leader[n] != n:
            leader[n] = leader[leader[n]]
            n = leader[n]
        return n

    for (i, j), (n, _) in owner.items():
        if abs(bend[i, j]) <= FLAT:
            leader[find(n)] = find(owner[j, i][0])
    number: dict[int, int] = {}
    return np.array([number.setdefault(find(n), len(number)) for n in range(count)])


def _is_sharp(ways: list[np.ndarray]) -> bool:
    """Whether the edges that leave a vertex between different faces are more than one straight line."""
    return len(ways) > 2 or (len(ways) == 2 and float(np.linalg.norm(np.cross(*ways))) > FLAT)


def _tree(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Balls around halves of halves of the triangles, split at the median along their longest extent."""
    centres = corners.mean(axis=1)
    balls: list[np.ndarray] = []
    children: list[tuple[int, int]] = []

    def build(which: np.ndarray) -> int:
        at = len(balls)
        points = corners[which].reshape(-1, 3)
        middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
        balls.append(np.append(middle, np.linalg.norm(points - middle, axis=1).max()))
        children.append((-1, int(which[0])))
        if len(which) > 1:
            axis = int(np.argmax(np.ptp(centres[which], axis=0)))
            order = which[np.argsort(centres[which, axis], kind="stable")]
            children[at] = (build(order[: len(order) // 2]), build(order[len(order) // 2 :]))
        return at

    build(np.arange(len(corners)))
    return np.array(balls), np.array(children)


@kernel
def halves(stack, top, i, j, child_a, ball_a, child_b, ball_b):
    """Puts both halves of the greater of balls i and j, with the other ball, on the stack; returns its height.

    A ball that is a cell has no halves: then it is the other one that is halved.
    """
    if child_b[j, 0] < 0 or (child_a[i, 0] >= 0 and ball_a[i, 3] >= ball_b[j, 3]):
        for k in range(2):
            stack[top, 0], stack[top, 1] = child_a[i, k], j
            top += 1
    else:
        for k in range(2):
            stack[top, 0], stack[top, 1] = i, child_b[j, k]
            top += 1
    return top
