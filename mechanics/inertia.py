"""Mass properties: volume, centre of mass and inertia of every shape and of closed meshes.

Inertia always comes from here, never from an engine's shape: engines disagree (a capsule's inertia
is that of its bounding box in one of them, a disc is a ball in another).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from mechanics.arrays import Mat33, Quat, SceneError, Vec3, frozen
from mechanics.rotation import from_matrix
from mechanics.shapes import Box, Capsule, Cylinder, HalfSpace, Mesh, Shape, Sphere


class MassProperties(NamedTuple):
    """Mass properties of a homogeneous solid in the body frame."""

    volume: float  # [m3]
    centre: Vec3  # centre of mass [m]
    inertia: Mat33  # about the centre of mass, per unit mass [m2]


def mass_properties(shape: Shape) -> MassProperties:
    """Volume [m3], centre of mass [m] and inertia per unit mass about it [m2] of a homogeneous solid.

    Exact closed forms; a mesh is summed over the signed tetrahedra between its triangles and a
    vertex (Mirtich, Fast and accurate computation of polyhedral mass properties, 1996, gives the
    same integrals).

    Raises
    ------
    SceneError
        For a HalfSpace, which has no mass.
    """
    match shape:
        case Sphere(r):
            return _symmetric(4.0 / 3.0 * math.pi * r**3, 0.4 * r * r, 0.4 * r * r, 0.4 * r * r)
        case Box((a, b, c)):
            return _symmetric(a * b * c, (b * b + c * c) / 12.0, (a * a + c * c) / 12.0, (a * a + b * b) / 12.0)
        case Cylinder(r, h):
            across = r * r / 4.0 + h * h / 12.0
            return _symmetric(math.pi * r * r * h, across, across, r * r / 2.0)
        case Capsule(r, h):
            return _capsule(r, h)
        case Mesh():
            return _mesh(shape)
        case HalfSpace():
            raise SceneError("shape", shape, "a solid with a volume (a HalfSpace can only be fixed)")


def principal(inertia: Mat33) -> tuple[Vec3, Quat]:
    """Principal moments and the quaternion that turns principal axes into body axes.

    A diagonal tensor keeps its axes, so that engines are given the identity where it is true.

    Returns
    -------
    moments : (3,) array [kg m2]
    orientation : (4,) unit quaternion
    """
    if not np.any(inertia - np.diag(np.diag(inertia))):
        return np.diag(inertia).copy(), np.array([1.0, 0.0, 0.0, 0.0])
    moments, axes = np.linalg.eigh(inertia)
    if np.linalg.det(axes) < 0.0:
        axes[:, 0] = -axes[:, 0]
    return moments, from_matrix(axes)


def check_inertia(field: str, inertia: Mat33) -> None:
    """Refuse a tensor that no distribution of mass has.

    Raises
    ------
    SceneError
        If it is not symmetric, not positive definite, or violates the triangle inequality
        I₁ + I₂ >= I₃ of the principal moments (equality: a flat plate).
    """
    if not np.allclose(inertia, inertia.T, rtol=0.0, atol=1e-12 * np.abs(inertia).max()):
        raise SceneError(field, inertia.tolist(), "a symmetric tensor")
    low, middle, high = np.linalg.eigvalsh(inertia)
    if low <= 0.0:
        raise SceneError(field, inertia.tolist(), "positive principal moments")
    if high > (low + middle) * (1.0 + 1e-9):
        allowed = f"I1 + I2 >= I3 (triangle inequality); the principal moments are {low:g}, {middle:g}, {high:g}"
        raise SceneError(field, inertia.tolist(), allowed)


def _symmetric(volume: float, xx: float, yy: float, zz: float) -> MassProperties:
    return MassProperties(volume, frozen([0.0, 0.0, 0.0]), frozen(np.diag([xx, yy, zz])))


def _capsule(r: float, h: float) -> MassProperties:
    tube, cap = math.pi * r * r * h, 2.0 / 3.0 * math.pi * r**3  # one cap
    volume = tube + 2.0 * cap
    along = (tube * r * r / 2.0 + 2.0 * cap * 0.4 * r * r) / volume
    # a hemisphere about its own centre of mass (3r/8 from its flat face): 83/320 m r²
    cap_across = 83.0 / 320.0 * r * r + (h / 2.0 + 3.0 / 8.0 * r) ** 2
    across = (tube * (r * r / 4.0 + h * h / 12.0) + 2.0 * cap * cap_across) / volume
    return _symmetric(volume, across, across, along)


def _mesh(mesh: Mesh) -> MassProperties:
    points = np.array(mesh.vertices)
    apex = points.mean(axis=0)
    a, b, c = np.moveaxis(points[np.array(mesh.triangles)] - apex, 1, 0)
    volumes = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0
    volume = float(volumes.sum())
    s = a + b + c
    centre = np.einsum("i,ij->j", volumes, s) / (4.0 * volume)
    # ∫ x xᵀ over a tetrahedron (0, a, b, c) = V/20 (s sᵀ + a aᵀ + b bᵀ + c cᵀ)
    second = sum(np.einsum("i,ij,ik->jk", volumes, u, u) for u in (s, a, b, c)) / (20.0 * volume)
    second = second - np.outer(centre, centre)
    inertia = np.trace(second) * np.eye(3) - second
    return MassProperties(volume, frozen(centre + apex), frozen(inertia))
