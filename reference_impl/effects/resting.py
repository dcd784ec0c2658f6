"""Resting contact: forces that are just large enough.

At every lasting contact the normal force f and the acceleration of the gap obey

    0 <= f,    gap'' = A f + b >= 0,    f·gap'' = 0

(Baraff 1994), where b holds the accelerations without contact forces and what the turning of the
normals and the rotation of the bodies bring (`bias` in `collide.features`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from reference_impl.collide.detect import Contacts, Kinematics, kinematics, rotations
from reference_impl.collide.features import rows
from reference_impl.contact_problem import solve
from reference_impl.kernels import apply_transposed, spin, turned
from reference_impl.state import Bodies, Motion


@dataclass(frozen=True)
class Island:
    """Contacts that act on each other through moving bodies.

    Attributes
    ----------
    bodies : list of int
        The moving bodies.
    contacts : Contacts
    place : (n,) array
        Number of each body of the scene among `bodies`, or -1.
    """

    bodies: list[int]
    contacts: Contacts
    index: np.ndarray  # of the contacts among all
    place: np.ndarray

    def rows(self, k: Kinematics, x: np.ndarray, rotation: np.ndarray, b: Bodies) -> np.ndarray:
        """Scaled contact rows G (contacts, 6 per body)."""
        out = np.empty((len(self.contacts.kinds), 6 * len(self.bodies)))
        rows(self.contacts.kinds, k.normal, k.point, x, rotation, b.root, b.inverse_mass, self.place, out)
        return out


class Pose(NamedTuple):
    """State of all n bodies, with what follows from it."""

    x: np.ndarray  # (n, 3) [m]
    rotation: np.ndarray  # (n, 3, 3)
    v: np.ndarray  # (n, 3) [m/s]
    w: np.ndarray  # (n, 3) [rad/s]
    L: np.ndarray  # (n, 3) [kg m2/s]

    @staticmethod
    def of(x: np.ndarray, q: np.ndarray, v: np.ndarray, momentum: np.ndarray, b: Bodies) -> Pose:
        """From positions, quaternions, velocities and angular momenta."""
        rotation = rotations(q)
        w = np.zeros_like(v)
        for i in np.flatnonzero(momentum.any(axis=1)):
            w[i] = spin(rotation[i], b.inverse_inertia[i], momentum[i])
        return Pose(x, rotation, v, w, momentum)


class Push(NamedTuple):
    """Contact forces of one island and the accelerations under them."""

    force: np.ndarray  # (m,) [N]
    opening: np.ndarray  # (m,) gap'' [m/s2]
    acceleration: np.ndarray  # (bodies, 3) [m/s2]
    torque: np.ndarray  # (bodies, 3) rate of the angular momentum [N m]
    residual: float


def islands(contacts: Contacts, b: Bodies) -> list[Island]:
    """Contacts grouped so that no moving body is in two groups."""
    n = len(b.inverse_mass)
    leader = np.arange(n)

    def find(i: int) -> int:
        while leader[i] != i:
            leader[i] = leader[leader[i]]
            i = leader[i]
        return int(i)

    ends = contacts.kinds[:, :2]
    free = b.inverse_mass > 0.0
    for i, j in ends.tolist():
        if free[i] and free[j]:
            leader[find(j)] = find(i)
    groups: dict[int, list[int]] = {}
    for k, (i, j) in enumerate(ends.tolist()):
        groups.setdefault(find(i if free[i] else j), []).append(k)
    out = []
    for members in groups.values():
        index = np.array(members)
        bodies = sorted({i for i in ends[index].ravel().tolist() if free[i]})
        place = np.full(n, -1)
        place[bodies] = np.arange(len(bodies))
        out.append(Island(bodies, contacts.chosen(index), index, place))
    return out


def scaled_loads(bodies: list[int], pose: Pose, b: Bodies) -> np.ndarray:
    """Scaled acceleration without contact forces, (√m a, Bᵀ Rᵀ torque) of each body."""
    out = np.empty((len(bodies), 6))
    for k, i in enumerate(bodies):
        out[k, :3] = (b.acceleration[i] - b.drag[i] * pose.v[i]) / np.sqrt(b.inverse_mass[i])
        out[k, 3:] = b.root[i].T @ apply_transposed(pose.rotation[i], _torque(i, pose, b))
    return out.ravel()


def _torque(i: int, pose: Pose, b: Bodies) -> np.ndarray:
    """Load torque minus the gyroscopic one, the rate at which ω must follow [N m]."""
    torque = -np.cross(pose.w[i], pose.L[i])
    if b.twisted[i]:
        torque = torque + load_torque(i, pose, b)
    return torque


def load_torque(i: int, pose: Pose, b: Bodies) -> np.ndarray:
    """Torque of the loads on body i, world frame [N m]."""
    m = pose.rotation[i] @ b.lever[i]
    axial = np.array([m[1, 2] - m[2, 1], m[2, 0] - m[0, 2], m[0, 1] - m[1, 0]])
    return b.torque[i] + axial - b.spin_drag[i] * pose.w[i]


def carried(ends: np.ndarray, normal: np.ndarray, of_fixed: np.ndarray) -> np.ndarray:
    """n·(a's - b's) of a vector that only fixed bodies have (n, 3), for each contact."""
    return np.einsum("ij,ij->i", normal, of_fixed[ends[:, 0]] - of_fixed[ends[:, 1]])


def push(island: Island, pose: Pose, b: Bodies, solver: str, guess: np.ndarray | None = None) -> Push:
    """Contact forces of an island and the motion they cause.

    Raises
    ------
    NoSolution
        If no forces keep the bodies apart.
    """
    c = island.contacts
    k = kinematics(c, pose.x, pose.rotation, pose.v, pose.w)
    g = island.rows(k, pose.x, pose.rotation, b)
    free = scaled_loads(island.bodies, pose, b)
    fixed = np.where(b.inverse_mass[:, None] == 0.0, b.acceleration, 0.0)
    answer = solve(g, free, -(k.bias + carried(c.kinds[:, :2], k.normal, fixed)), solver, guess)
    scaled = answer.x.reshape(-1, 6)
    acceleration = scaled[:, :3] * np.sqrt(b.inverse_mass[island.bodies])[:, None]
    torque = np.empty_like(acceleration)
    for at, i in enumerate(island.bodies):
        # I B y is the body torque whose angular acceleration is R B y; add back ω × L, for L' = I α + ω × L
        turn = b.inertia[i] @ (b.root[i] @ scaled[at, 3:])
        torque[at] = pose.rotation[i] @ turn + np.cross(pose.w[i], pose.L[i])
    return Push(answer.f, answer.a, acceleration, torque, answer.residual)


def shift_bodies(m: Motion, b: Bodies, island: Island, pose: Pose, gap: np.ndarray) -> None:
    """Move the bodies of an island, as little as possible in the metric of their masses, to these gaps [m]."""
    k = kinematics(island.contacts, pose.x, pose.rotation, pose.v, pose.w)
    excess = k.gap - gap
    if not excess.any():
        return
    g = island.rows(k, pose.x, pose.rotation, b)
    length = np.sqrt(np.einsum("ij,ij->i", g, g))
    shift = -np.linalg.lstsq(g / length[:, None], excess / length, rcond=1e-10)[0].reshape(-1, 6)
    for at, i in enumerate(island.bodies):
        m.x[i] += shift[at, :3] * np.sqrt(b.inverse_mass[i])
        if b.quickness[i] > 0.0:
            m.q[i] = turned(m.q[i], pose.rotation[i] @ (b.root[i] @ shift[at, 3:]))
