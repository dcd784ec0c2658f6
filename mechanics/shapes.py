"""Shapes, as values in the body frame.

The origin of the body frame is the centre of mass.  Lengths are in metres.  Capsule and Cylinder
have their axis along the body's z; a HalfSpace fills everything below its surface, which passes
through the body's origin.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mechanics.arrays import SceneError, Triple, real, reals


@dataclass(frozen=True)
class Sphere:
    """Solid ball of radius `radius` [m]."""

    radius: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "radius", real("radius", self.radius, above=0.0))


@dataclass(frozen=True)
class Box:
    """Solid box with full edge lengths `size` = (along x, y, z) [m]."""

    size: Triple

    def __post_init__(self) -> None:
        object.__setattr__(self, "size", reals("size", self.size, 3, above=0.0))


@dataclass(frozen=True)
class Capsule:
    """Cylinder of `length` [m] along z between the centres of two hemispherical caps of `radius` [m]."""

    radius: float
    length: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "radius", real("radius", self.radius, above=0.0))
        object.__setattr__(self, "length", real("length", self.length, above=0.0))


@dataclass(frozen=True)
class Cylinder:
    """Solid cylinder of `radius` and full `length` along z [m]."""

    radius: float
    length: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "radius", real("radius", self.radius, above=0.0))
        object.__setattr__(self, "length", real("length", self.length, above=0.0))


@dataclass(frozen=True)
class HalfSpace:
    """Everything on the side of a plane that `normal` (body frame, made a unit vector) points away from.

    Only fixed bodies can have this shape: it has no mass.
    """

    normal: Triple = (0.0, 0.0, 1.0)

    def __post_init__(self) -> None:
        normal = reals("normal", self.normal, 3)
        length = math.sqrt(sum(c * c for c in normal))
        if not 1e-150 < length < 1e150:
            raise SceneError("normal", self.normal, "a vector that can be normalised")
        # a vector that already has unit length stays bitwise as it is
        if abs(length - 1.0) > 1e-15:
            normal = tuple(c / length for c in normal)
        object.__setattr__(self, "normal", normal)


@dataclass(frozen=True)
class Mesh:
    """Solid bounded by a closed triangle mesh.

    Parameters
    ----------
    vertices : sequence of (x, y, z) [m]
    triangles : sequence of (i, j, k)
        Vertex indices, counter-clockwise seen from outside.
    convex : bool
        Whether the solid is convex; checked, because engines treat a convex hull quite differently.

    Raises
    ------
    SceneError
        If the mesh is open, inverted, degenerate (a triangle without area, an unused or repeated
        vertex), not a manifold, or not convex although it is declared so.
    """

    vertices: tuple[Triple, ...]
    triangles: tuple[tuple[int, int, int], ...]
    convex: bool = True

    def __post_init__(self) -> None:
        vertices = tuple(reals(f"vertices[{i}]", v, 3) for i, v in enumerate(self.vertices))
        object.__setattr__(self, "vertices", vertices)
        object.__setattr__(self, "triangles", _indices(self.triangles, len(vertices)))
        if not isinstance(self.convex, bool):
            raise SceneError("convex", self.convex, "True or False")
        _check_closed(self)

    def centred(self) -> Mesh:
        """Return this mesh moved so that its centre of mass is the origin of the body frame."""
        from mechanics.inertia import mass_properties

        centre = mass_properties(self).centre
        moved = np.array(self.vertices) - centre
        return Mesh(tuple(map(tuple, moved.tolist())), self.triangles, self.convex)


SLIVER = 1e-9  # height of a triangle, over the extent of its mesh, below which its normal is not worth having

Shape = Sphere | Box | Capsule | Cylinder | HalfSpace | Mesh

SHAPES: dict[str, type] = {s.__name__: s for s in (Sphere, Box, Capsule, Cylinder, HalfSpace, Mesh)}


def bounding_radius(shape: Shape) -> float:
    """Radius of the smallest ball about the body's origin that holds the shape [m]; infinite for a HalfSpace."""
    match shape:
        case Sphere(radius):
            return radius
        case Box(size):
            return 0.5 * math.sqrt(sum(s * s for s in size))
        case Capsule(radius, length):
            return radius + 0.5 * length
        case Cylinder(radius, length):
            return math.hypot(radius, 0.5 * length)
        case HalfSpace():
            return math.inf
        case Mesh(vertices):
            return max(math.sqrt(x * x + y * y + z * z) for x, y, z in vertices)


def _indices(triangles: Sequence[Sequence[int]], count: int) -> tuple[tuple[int, int, int], ...]:
    checked = []
    for n, triangle in enumerate(triangles):
        field, allowed = f"triangles[{n}]", f"three different vertex indices in 0..{count - 1}"
        whole = len(triangle) == 3 and all(isinstance(i, (int, np.integer)) for i in triangle)
        if not whole or len(set(triangle)) != 3 or not all(0 <= i < count for i in triangle):
            raise SceneError(field, tuple(triangle), allowed)
        checked.append((int(triangle[0]), int(triangle[1]), int(triangle[2])))
    return tuple(checked)


def _check_fans(mesh: Mesh) -> None:
    """Around every vertex the triangles form one closed fan: no two parts hang together at a point."""
    around: list[dict[int, int]] = [{} for _ in mesh.vertices]
    for i, j, k in mesh.triangles:
        around[i][j], around[j][k], around[k][i] = k, i, j
    for v, fan in enumerate(around):
        first = at = next(iter(fan))
        count = 0
        while count == 0 or at != first:
            at, count = fan[at], count + 1
        if count != len(fan):
            raise SceneError("vertices", mesh.vertices[v], f"a manifold (two parts touch at vertex {v})")


def _check_closed(mesh: Mesh) -> None:
    if len(mesh.vertices) < 4 or len(mesh.triangles) < 4:
        raise SceneError("triangles", len(mesh.triangles), "at least 4 vertices and 4 triangles (a closed surface)")
    if len(set(mesh.vertices)) != len(mesh.vertices):
        twice = next(v for v, n in Counter(mesh.vertices).items() if n > 1)
        raise SceneError("vertices", twice, "every vertex once (degenerate mesh: weld repeated vertices)")
    unused = set(range(len(mesh.vertices))) - {i for t in mesh.triangles for i in t}
    if unused:
        raise SceneError("vertices", mesh.vertices[min(unused)], f"every vertex used (vertex {min(unused)} is not)")
    edges = Counter((t[k], t[(k + 1) % 3]) for t in mesh.triangles for k in range(3))
    for (i, j), n in edges.items():
        if n > 1:
            raise SceneError("triangles", (i, j), "each directed edge once (inconsistent winding or not a manifold)")
        if (j, i) not in edges:
            raise SceneError("triangles", (i, j), f"a closed surface (open mesh: edge {i}-{j} has one triangle only)")
    _check_fans(mesh)
    points = np.array(mesh.vertices)
    corners = points[np.array(mesh.triangles)]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    twice_area = np.linalg.norm(normals, axis=1)
    scale = float(np.ptp(points, axis=0).max())
    if twice_area.min() <= 1e-14 * scale**2:
        flat = int(np.argmin(twice_area))
        raise SceneError(f"triangles[{flat}]", mesh.triangles[flat], "an area (degenerate triangle)")
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    if (twice_area / longest).min() <= SLIVER * scale:
        thin = int(np.argmin(twice_area / longest))
        height = twice_area[thin] / longest[thin]
        raise SceneError(f"triangles[{thin}]", mesh.triangles[thin], f"no sliver (its height is {height:g} m)")
    # divergence theorem about one vertex, so that a far offset does not cancel the volume away
    volume = float(np.einsum("ij,ij->", corners[:, 0] - points[0], normals)) / 6.0
    if volume <= 1e-14 * scale**3:
        allowed = "triangles counter-clockwise seen from outside (inverted or degenerate mesh)"
        raise SceneError("triangles", f"volume {volume:g} m3", allowed)
    if mesh.convex:
        unit = normals / twice_area[:, None]
        above = np.einsum("ij,kj->ik", unit, points) - np.einsum("ij,ij->i", unit, corners[:, 0])[:, None]
        if above.max() > 1e-9 * scale:
            raise SceneError("convex", True, f"a convex solid, or convex=False (a vertex is {above.max():g} m outside)")
