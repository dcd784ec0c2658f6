"""Bodies and their motion as arrays.

Motion between events is kept as polynomials in the time since the segment began: positions and
quaternions of every body at any time of its segment come from here, for sampling and for the search
of the next contact alike.  World frame, SI.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from mechanics.effects import Rotation
from mechanics.scene import Scene
from mechanics.shapes import Box, Cylinder, HalfSpace, Sphere, bounding_radius

SPHERE, BOX, PLANE, CYLINDER, SOLID = 0, 1, 2, 3, 4  # a solid is a mesh or capsule
ORDER = 20  # of the Taylor polynomials of free flight: of 14 to 24 within 5 % of the least time per second of motion


class Bodies(NamedTuple):
    """What n bodies are and which loads act on them; fixed bodies have zero inverse mass and inertia."""

    inverse_mass: np.ndarray  # (n,) [1/kg]
    inverse_inertia: np.ndarray  # (n, 3, 3) body frame [1/(kg m2)]; zero: does not turn
    root: np.ndarray  # (n, 3, 3) B with B Bᵀ = inverse inertia
    inertia: np.ndarray  # (n, 3, 3) body frame [kg m2]
    moments: np.ndarray  # (n, 3) principal moments [kg m2]
    frame: np.ndarray  # (n, 4) quaternion of the principal axes in the body frame
    quickness: np.ndarray  # (n,) inverse of the smallest principal moment [1/(kg m2)]
    unevenness: np.ndarray  # (n,) greatest (I_j - I_k) / I_i of the principal moments
    acceleration: np.ndarray  # (n, 3) by constant loads, or prescribed [m/s2]
    torque: np.ndarray  # (n, 3) constant, world frame [N m]
    lever: np.ndarray  # (n, 3, 3) Σ p Fᵀ of world forces F at body points p [N m]
    drag: np.ndarray  # (n,) linear drag over mass [1/s]
    spin_drag: np.ndarray  # (n,) angular drag [N m s]
    shape: np.ndarray  # (n,) SPHERE, BOX, PLANE, CYLINDER or SOLID
    half: np.ndarray  # (n, 3) half edges of boxes [m]
    radius: np.ndarray  # (n,) of spheres [m]
    normal: np.ndarray  # (n, 3) of half-spaces, world frame
    reach: np.ndarray  # (n,) bounding radius [m]
    twisted: np.ndarray  # (n,) a torque acts
    plain: np.ndarray  # (n,) a sphere without a torque: turns at constant angular velocity


@dataclass
class Motion:
    """State of n bodies at time `t`, and the polynomials that carry them on from `begin` to `end`.

    Attributes
    ----------
    x, v : (n, 3) arrays [m, m/s];  q : (n, 4) array;  L : (n, 3) array [kg m2/s]
        Position, velocity, attitude and angular momentum about the centre of mass at time `t`.
    begin, end : (n,) arrays [s]
        Interval in which the polynomials of a body hold.
    x_series : (n, ORDER + 1, 3) array;  q_series : (n, ORDER + 1, 4) array
        Coefficients of position and quaternion in powers of (time - begin).
    spin_series : (n, ORDER + 1, 3) array
        Coefficients of the angular velocity in the principal axes, in free flight [rad/s].
    kept : (n, 4) array
        What a free rotation keeps, see `integrators.free_flight` [(kg m2/s)2].
    start : (n, 3) array
        Angular momentum at `begin`; conserved in free flight without torque.
    bounds : (n, 6) array
        Mean acceleration (3), greatest deviation from it [m/s2], greatest angular velocity [rad/s]
        and angular acceleration [rad/s2] in the segment.
    """

    x: np.ndarray
    q: np.ndarray
    v: np.ndarray
    L: np.ndarray
    t: float = 0.0
    begin: np.ndarray = field(init=False)
    end: np.ndarray = field(init=False)
    x_series: np.ndarray = field(init=False)
    q_series: np.ndarray = field(init=False)
    spin_series: np.ndarray = field(init=False)
    kept: np.ndarray = field(init=False)
    start: np.ndarray = field(init=False)
    bounds: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        n = len(self.x)
        self.begin, self.end = np.zeros(n), np.zeros(n)
        self.x_series, self.q_series = np.zeros((n, ORDER + 1, 3)), np.zeros((n, ORDER + 1, 4))
        self.spin_series, self.kept = np.zeros((n, ORDER + 1, 3)), np.zeros((n, 4))
        self.start, self.bounds = self.L.copy(), np.zeros((n, 6))


def bodies_of(scene: Scene) -> Bodies:
    """Arrays of the scene's bodies; no loads act yet, and nothing turns unless the scene declares Rotation."""
    n = len(scene.bodies)
    turning = Rotation in scene.needs
    zeros = np.zeros
    matrices = zeros((n, 3, 3))
    b = Bodies(
        zeros(n), matrices, matrices.copy(), matrices.copy(), zeros((n, 3)), np.tile((1.0, 0.0, 0.0, 0.0), (n, 1)),
        zeros(n), zeros(n), zeros((n, 3)), zeros((n, 3)),
        matrices.copy(), zeros(n), zeros(n), np.full(n, SOLID), zeros((n, 3)), zeros(n), zeros((n, 3)), zeros(n),
        zeros(n, dtype=np.bool_), zeros(n, dtype=np.bool_),
    )  # fmt: skip
    for i, body in enumerate(scene.bodies):
        b.reach[i] = bounding_radius(body.shape)
        if isinstance(body.shape, Sphere):
            b.shape[i], b.radius[i] = SPHERE, body.shape.radius
        elif isinstance(body.shape, Box):
            b.shape[i], b.half[i] = BOX, 0.5 * np.array(body.shape.size)
        elif isinstance(body.shape, Cylinder):
            b.shape[i] = CYLINDER
        elif isinstance(body.shape, HalfSpace):
            from mechanics.rotation import rotate

            b.shape[i], b.normal[i] = PLANE, rotate(np.array(body.orientation), np.array(body.shape.normal))
        if body.fixed:
            b.acceleration[i] = body.acceleration
            continue
        b.inverse_mass[i] = 1.0 / body.mass
        if turning:
            inertia = np.array(body.inertia_tensor)
            b.inertia[i] = inertia
            b.inverse_inertia[i], b.root[i] = _inverse_and_root(inertia)
            b.moments[i], b.frame[i] = _principal(inertia)
            low, middle, high = np.sort(b.moments[i])
            b.quickness[i] = 1.0 / low
            b.unevenness[i] = max((high - middle) / low, (high - low) / middle, (middle - low) / high)
    return b


def motion_of(scene: Scene, bodies: Bodies) -> Motion:
    """The motion at t = 0, without segments yet."""
    from reference_impl.kernels import apply, apply_transposed, matrix

    start = scene.start()
    momentum = np.zeros((len(scene.bodies), 3))
    for i in range(len(scene.bodies)):
        if np.any(start.w[i]):
            rotation = matrix(start.q[i])
            momentum[i] = apply(rotation, apply(bodies.inertia[i], apply_transposed(rotation, start.w[i])))
    return Motion(start.x.copy(), start.q.copy(), start.v.copy(), momentum)


def _inverse_and_root(inertia: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Inverse of a tensor and a root B of it, B Bᵀ = I⁻¹; exact to rounding for a diagonal tensor."""
    if not np.any(inertia - np.diag(np.diag(inertia))):
        return np.diag(1.0 / np.diag(inertia)), np.diag(1.0 / np.sqrt(np.diag(inertia)))
    moments, axes = np.linalg.eigh(inertia)
    root = axes / np.sqrt(moments)
    return root @ root.T, root


def _principal(inertia: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Principal moments of a tensor, and the quaternion of their axes; the axes of the body if these are principal."""
    if not np.any(inertia - np.diag(np.diag(inertia))):
        return np.diag(inertia), np.array((1.0, 0.0, 0.0, 0.0))
    from mechanics.rotation import from_matrix

    moments, axes = np.linalg.eigh(inertia)
    if np.linalg.det(axes) < 0.0:
        axes[:, 0] *= -1.0
    return moments, from_matrix(axes)
