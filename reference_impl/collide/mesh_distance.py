"""Exact signed distance of a point from a closed triangle mesh.

The nearest point of each triangle lies in its face, on an edge or at a vertex (Ericson, Real-Time
Collision Detection, 2005, section 5.1.5).  The sign is that of the offset along the pseudo-normal of the
nearest feature: the face's normal, the sum of both at an edge, the sum weighted by the angles at a vertex,
which is right everywhere (Baerentzen and Aanaes, Signed distance computation using the angle weighted
pseudonormal, 2005).  Every triangle is looked at: meant for building fields and for checking them.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from mechanics.shapes import Mesh
from reference_impl.kernels import along, cross, dot, kernel, minus, norm


class Surface(NamedTuple):
    """Triangles with the pseudo-normals of their features; features 0-2: vertices, 3-5: edges from them, 6: face."""

    corners: np.ndarray  # (t, 3, 3) [m]
    normals: np.ndarray  # (t, 7, 3), of any length


def surface_of(mesh: Mesh) -> Surface:
    """The triangles of a mesh and the pseudo-normals of their vertices, edges and faces."""
    triangles = np.array(mesh.triangles)
    corners = np.array(mesh.vertices)[triangles]
    face = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    face /= np.linalg.norm(face, axis=1)[:, None]
    at_vertex = np.zeros((len(mesh.vertices), 3))
    at_edge: dict[tuple[int, int], np.ndarray] = {}
    for t, triangle in enumerate(mesh.triangles):
        for k in range(3):
            p, q, r = (corners[t, (k + s) % 3] for s in range(3))
            angle = np.arctan2(np.linalg.norm(np.cross(q - p, r - p)), (q - p) @ (r - p))
            at_vertex[triangle[k]] += angle * face[t]
            edge = tuple(sorted((triangle[k], triangle[(k + 1) % 3])))
            at_edge[edge] = at_edge.get(edge, np.zeros(3)) + face[t]
    normals = np.empty((len(triangles), 7, 3))
    for t, triangle in enumerate(mesh.triangles):
        for k in range(3):
            normals[t, k] = at_vertex[triangle[k]]
            normals[t, 3 + k] = at_edge[tuple(sorted((triangle[k], triangle[(k + 1) % 3])))]
        normals[t, 6] = face[t]
    return Surface(np.ascontiguousarray(corners), normals)


def mesh_distance(mesh: Mesh) -> Callable[[np.ndarray], np.ndarray]:
    """Function of points (m, 3) in the mesh's frame that returns their exact signed distances (m,) [m]."""
    surface = surface_of(mesh)

    def distance(points: np.ndarray) -> np.ndarray:
        out = np.empty(len(points))
        _signed_distances(surface.corners, surface.normals, np.ascontiguousarray(points, dtype=np.float64), out)
        return out

    return distance


@kernel
def nearest(p, a, b, c):
    """Nearest point of triangle a b c to p, and the feature it lies on (see `Surface`)."""
    ab, ac, ap = minus(b, a), minus(c, a), minus(p, a)
    d1, d2 = dot(ab, ap), dot(ac, ap)
    if d1 <= 0.0 and d2 <= 0.0:
        return a, 0
    bp = minus(p, b)
    d3, d4 = dot(ab, bp), dot(ac, bp)
    if d3 >= 0.0 and d4 <= d3:
        return b, 1
    if d1 * d4 - d3 * d2 <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        return along(a, d1 / (d1 - d3), ab), 3
    cp = minus(p, c)
    d5, d6 = dot(ab, cp), dot(ac, cp)
    if d6 >= 0.0 and d5 <= d6:
        return c, 2
    if d5 * d2 - d1 * d6 <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        return along(a, d2 / (d2 - d6), ac), 5
    if d3 * d6 - d5 * d4 <= 0.0 and d4 >= d3 and d5 >= d6:
        return along(b, (d4 - d3) / ((d4 - d3) + (d5 - d6)), minus(c, b)), 4
    n = cross(ab, ac)
    return along(p, -dot(ap, n) / dot(n, n), n), 6


@kernel
def _signed_distances(corners, normals, points, out):
    for k in range(len(points)):
        least, sign = np.inf, 1.0
        for t in range(len(corners)):
            foot, feature = nearest(points[k], corners[t, 0], corners[t, 1], corners[t, 2])
            offset = minus(points[k], foot)
            distance = norm(offset)
            if distance < least:
                least = distance
                sign = 1.0 if dot(normals[t, feature], offset) >= 0.0 else -1.0
        out[k] = sign * least
