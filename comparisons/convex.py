"""Convex polytopes: boxes and convex meshes as vertices, faces and edges; how deep two of them overlap.

The overlap depth of two convex bodies is the shortest translation that parts them.  For polytopes it is
attained along a face normal of either or along the cross product of an edge of each (separating axis
theorem; Gottschalk, Lin, Manocha, OBBTree, 1996).  Every unit vector d gives a lower bound of the gap,

    s(d) = min over b of d·x - max over a of d·x,

so the largest s over those axes is the gap in overlap, and a lower bound of the distance when apart.
Near-parallel edges give an axis of uncertain direction, which is a bound like any other: it does no harm.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from mechanics.rotation import matrix
from mechanics.shapes import Box, Capsule, Mesh

MANY_EDGES = 256  # pairs of edge directions above which axes are chosen by the Gauss map
BLOCK = 4_000_000  # numbers held at once


@dataclass(frozen=True)
class Polytope:
    """A convex polytope in the body frame.

    Attributes
    ----------
    vertices : (V, 3) array [m]
    normals : (F, 3) array
        Outward unit normals of the faces.
    offsets : (F,) array
        The solid is where normals · x <= offsets [m].
    directions : (D, 3) array
        Unit directions of the edges, up to sign.
    triangles : (N, 3, 3) array
        Corners of the surface [m].
    edges : (E, 2, 3) array
        End points of the edges between faces that are not coplanar [m].
    arcs : (E, 2, 3) array
        Normals of the two faces that meet at each edge.
    """

    vertices: np.ndarray
    normals: np.ndarray
    offsets: np.ndarray
    directions: np.ndarray
    triangles: np.ndarray
    edges: np.ndarray
    arcs: np.ndarray


@lru_cache(maxsize=256)
def polytope(shape: Box | Mesh) -> Polytope:
    """The box or convex mesh as a polytope."""
    if isinstance(shape, Box):
        vertices, triangles = _box(np.array(shape.size))
    else:
        vertices, triangles = np.array(shape.vertices), np.array(shape.triangles)
    corners = vertices[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    owner: dict[tuple[int, int], int] = {}
    for n, (i, j, k) in enumerate(triangles.tolist()):
        owner |= {(i, j): n, (j, k): n, (k, i): n}
    rims = [(i, j, n, owner[j, i]) for (i, j), n in owner.items() if i < j]
    # neighbouring triangles that lie in one plane to rounding are one face: their common edge is none
    rims = [rim for rim in rims if np.linalg.norm(np.cross(normals[rim[2]], normals[rim[3]])) > 1e-12]
    edges = np.array([(vertices[i], vertices[j]) for i, j, _, _ in rims])
    arcs = np.array([(normals[m], normals[n]) for _, _, m, n in rims])
    faces = np.unique(normals.round(12), axis=0, return_index=True)[1]
    # the support in the direction of the normal, so that rounding never cuts a vertex off
    offsets = (normals[faces] @ vertices.T).max(axis=1)
    along = edges[:, 1] - edges[:, 0]
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    return Polytope(vertices, normals[faces], offsets, _up_to_sign(along), corners, edges, arcs)


@lru_cache(maxsize=256)
def segment(capsule: Capsule) -> Polytope:
    """Axis of a capsule as a polytope without faces."""
    half = 0.5 * capsule.length
    ends = np.array([[0.0, 0.0, -half], [0.0, 0.0, half]])
    none = np.zeros((0, 3))
    axis = np.array([[0.0, 0.0, 1.0]])
    return Polytope(ends, none, np.zeros(0), axis, np.zeros((0, 3, 3)), ends[None], np.zeros((0, 2, 3)))


def separation(a: Polytope, b: Polytope, xa: np.ndarray, qa: np.ndarray, xb: np.ndarray, qb: np.ndarray) -> np.ndarray:
    """(T,) gap of two polytopes [m]: minus the overlap depth, exact; a lower bound of the distance when apart.

    Parameters
    ----------
    a, b : Polytope
    xa, xb : (T, 3) [m]; qa, qb : (T, 4)
        Poses, body to world.
    """
    # everything in the frame of a, so that far from the origin nothing is lost
    turn = np.einsum("tji,tjk->tik", matrix(qa), matrix(qb))
    shift = np.einsum("tji,tj->ti", matrix(qa), xb - xa)
    gap = np.full(len(xa), -np.inf)
    for part in _blocks(len(gap), (len(a.normals) + len(b.normals)) * max(len(a.vertices), len(b.vertices))):
        gap[part] = _face_separation(a, b, turn[part], shift[part])
    # where a face parts them the sign is known; edges only sharpen the depth of what overlaps
    close = np.flatnonzero(gap <= 0.0)
    dense = len(a.directions) * len(b.directions) <= MANY_EDGES
    axes, width = (_dense_axes, len(a.directions) * len(b.directions)) if dense else (_gauss_axes, _pairs(a, b))
    for part in _blocks(len(close), width * (3 + (len(a.vertices) + len(b.vertices) if dense else 9))):
        rows = close[part]
        which, directions = axes(a, b, turn[rows])
        bound = _bounds(a, b, directions, turn[rows][which], shift[rows][which])
        np.maximum.at(gap, rows[which], bound)
    return gap


def _face_separation(a: Polytope, b: Polytope, turn: np.ndarray, shift: np.ndarray) -> np.ndarray:
    best = np.full(len(shift), -np.inf)
    if len(a.normals):
        points = np.einsum("tij,vj->tvi", turn, b.vertices) + shift[:, None]
        best = ((points @ a.normals.T).min(axis=1) - a.offsets).max(axis=1)
    if len(b.normals):
        points = np.einsum("tji,tvj->tvi", turn, a.vertices - shift[:, None])
        best = np.maximum(best, ((points @ b.normals.T).min(axis=1) - b.offsets).max(axis=1))
    return np.asarray(best)


def _dense_axes(a: Polytope, b: Polytope, turn: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Cross products of all edge directions: time index and vector of each."""
    turned = np.einsum("tij,dj->tdi", turn, b.directions)
    axes = np.cross(a.directions[None, :, None], turned[:, None]).reshape(-1, 3)
    which = np.repeat(np.arange(len(turn)), len(a.directions) * len(b.directions))
    return which, axes


def _gauss_axes(a: Polytope, b: Polytope, turn: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Cross products of those edges that form a face of the Minkowski difference.

    They are those whose arcs on the Gauss map cross (Gregorius, The separating axis test between
    convex polyhedra, GDC 2013); arcs that only touch meet in a face normal, which is an axis anyway.
    """
    arcs = -np.einsum("tij,ekj->teki", turn, b.arcs)
    rims_a = np.cross(a.arcs[:, 1], a.arcs[:, 0])  # (E, 3)
    rims_b = np.cross(arcs[:, :, 1], arcs[:, :, 0])  # (t, E', 3)
    c, d = (np.einsum("ei,tfi->tef", rims_a, arcs[:, :, k]) for k in (0, 1))
    p, q = (np.einsum("ei,tfi->tef", a.arcs[:, k], rims_b) for k in (0, 1))
    which, i, j = np.nonzero((c * d < 0.0) & (p * q < 0.0) & (c * q > 0.0))
    return which, np.cross(rims_a[i], rims_b[which, j])


def _bounds(a: Polytope, b: Polytope, axes: np.ndarray, turn: np.ndarray, shift: np.ndarray) -> np.ndarray:
    """(K,) the lower bound s of the gap along each axis, in the better of its two senses; -inf for a zero axis."""
    lengths = np.linalg.norm(axes, axis=1)
    usable = lengths > 1e-150
    d = axes / np.where(usable, lengths, 1.0)[:, None]
    d /= np.where(usable, np.linalg.norm(d, axis=1), 1.0)[:, None]
    on_a = d @ a.vertices.T
    on_b = np.einsum("kji,kj->ki", turn, d) @ b.vertices.T
    apart = np.einsum("ki,ki->k", d, shift)
    ahead = apart + on_b.min(axis=1) - on_a.max(axis=1)
    behind = -apart - on_b.max(axis=1) + on_a.min(axis=1)
    return np.where(usable, np.maximum(ahead, behind), -np.inf)


def _pairs(a: Polytope, b: Polytope) -> int:
    return max(len(a.edges) * len(b.edges), 1)


def _blocks(count: int, width: int) -> Iterator[slice]:
    """Slices of 0..count whose arrays of `width` numbers a row stay within memory."""
    step = max(1, BLOCK // max(width, 1))
    for start in range(0, count, step):
        yield slice(start, min(start + step, count))


def _box(size: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and outward triangles of a box; the bits of a vertex's number are its signs along x, y, z."""
    signs = np.array([[(v >> axis & 1) * 2 - 1 for axis in range(3)] for v in range(8)], dtype=np.float64)
    quads = [(0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6)]
    return 0.5 * signs * size, np.array([t for i, j, k, l in quads for t in ((i, j, k), (i, k, l))])


def _up_to_sign(directions: np.ndarray) -> np.ndarray:
    """Each direction once, whichever way it points."""
    flat = directions.round(12)
    leading = flat[np.arange(len(flat)), np.argmax(flat != 0.0, axis=1)]
    kept = np.unique(flat * np.sign(leading)[:, None], axis=0, return_index=True)[1]
    return np.asarray(directions[kept])
