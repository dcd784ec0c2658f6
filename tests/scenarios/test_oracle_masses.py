"""Mass properties against numbers computed elsewhere with 40 digits; see `conftest`."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np

from mechanics.inertia import mass_properties
from mechanics.shapes import Box, Capsule, Cylinder, Mesh, Shape, Sphere

DENSITY = 1000.0  # [kg/m3]


def weighed(shape: Shape) -> tuple[float, np.ndarray]:
    """Mass [kg] and moments about the centre of mass along the body axes [kg m2]."""
    found = mass_properties(shape)
    mass = DENSITY * found.volume
    return mass, mass * np.diag(found.inertia)


def tetrahedron() -> Mesh:
    corners = [(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)]
    scale = 1.0 / math.sqrt(8.0)
    return Mesh(tuple(tuple(scale * c for c in v) for v in corners), ((0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)))


def octahedron() -> Mesh:
    axes = np.vstack([np.eye(3), -np.eye(3)]) / math.sqrt(2.0)
    faces = [(a, b, c) if (a > 2) ^ (b > 2) ^ (c > 2) ^ True else (a, c, b)
             for a in (0, 3) for b in (1, 4) for c in (2, 5)]  # fmt: skip
    return Mesh(tuple(map(tuple, axes.tolist())), tuple(faces))


def angle_iron() -> Mesh:
    """A bar of 2 x 1 x 1 m with a cube of 1 m on one end."""
    rim = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)]
    caps = [(0, k + 1, k) for k in range(1, 5)] + [(6, 6 + k, 7 + k) for k in range(1, 5)]
    sides = [f for k in range(6) for f in ((k, (k + 1) % 6, 6 + (k + 1) % 6), (k, 6 + (k + 1) % 6, 6 + k))]
    return Mesh(tuple((x, y, z) for z in (0.0, 1.0) for x, y in rim), (*caps, *sides), convex=False)


def standard_solids() -> Mapping[str, float]:
    said: dict[str, float] = {}
    said["box_m"], box = weighed(Box((0.1, 0.4, 0.9)))
    said["sphere_m"], ball = weighed(Sphere(0.2))
    said["cylinder_m"], cylinder = weighed(Cylinder(0.1, 0.5))
    said["capsule_m"], capsule = weighed(Capsule(0.1, 0.4))
    said["tetra_m"], tetra = weighed(tetrahedron())
    said["octa_m"], octa = weighed(octahedron())
    iron = mass_properties(angle_iron())
    said["Lshape_m"] = DENSITY * iron.volume
    moments = said["Lshape_m"] * iron.inertia
    said |= {f"box_I{k}": box[k] for k in range(3)} | {f"Lshape_com{k}": iron.centre[k] for k in range(3)}
    products = (moments[0, 0], moments[1, 1], moments[2, 2], moments[0, 1])
    said |= {f"Lshape_I_com(xx,yy,zz,xy){k}": value for k, value in enumerate(products)}
    return said | {"sphere_I": ball[0], "cylinder_I_axis": cylinder[2], "cylinder_I_diam": cylinder[0],
                   "capsule_I_axis": capsule[2], "capsule_I_diam": capsule[0], "tetra_I": tetra[0],
                   "octa_I": octa[0]}  # fmt: skip


ENTRIES: dict[str, Callable[[], Mapping[str, float]]] = {"H01": standard_solids}


def test_the_truth_has_the_printed_number(compute, quantity, printed):
    assert float(compute()[quantity]) == printed
