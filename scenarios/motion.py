"""From the known motion of single bodies to the truth of a whole scene."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from mechanics.arrays import Quats, Vectors
from mechanics.scene import Scene
from mechanics.trajectory import Trajectory


class Motion(NamedTuple):
    """How one body moves at T times.  What is left out stays as it is at the start."""

    x: Vectors  # centre of mass, world frame, (T, 3) [m]
    v: Vectors  # its velocity, (T, 3) [m/s]; after the impact at the time of an impact
    q: Quats | None = None  # (T, 4) unit quaternions, body to world
    w: Vectors | None = None  # angular velocity, world frame, (T, 3) [rad/s]


def trajectory(scene: Scene, t: np.ndarray, motions: Mapping[str, Motion]) -> Trajectory:
    """Motion of every body of `scene` at times `t` [s]; fixed bodies move as they are told to.

    Raises
    ------
    KeyError
        If a body with a mass is not in `motions`.
    """
    start = scene.start()
    x, q, v, w = (np.repeat(a[None], len(t), axis=0) for a in (start.x, start.q, start.v, start.w))
    for i, body in enumerate(scene.bodies):
        if body.fixed and (any(body.velocity) or any(body.acceleration)):
            x[:, i] += t[:, None] * v[:, i] + 0.5 * t[:, None] ** 2 * np.array(body.acceleration)
            v[:, i] += t[:, None] * np.array(body.acceleration)
    for i in scene.moving:
        motion = motions[scene.names[i]]
        x[:, i], v[:, i] = motion.x, motion.v
        if motion.q is not None:
            q[:, i] = motion.q
        if motion.w is not None:
            w[:, i] = motion.w
    return Trajectory(t, x, q, v, w)


def vectors(t: np.ndarray, x: object = 0.0, y: object = 0.0, z: object = 0.0) -> np.ndarray:
    """(T, 3) array of components that are numbers or (T,) arrays."""
    return np.stack([np.broadcast_to(np.asarray(c, dtype=np.float64), t.shape) for c in (x, y, z)], axis=-1)


def line(t: np.ndarray, position: Vectors, velocity: Vectors) -> np.ndarray:
    """Uniform motion from `position` at t = 0, (T, 3) [m]."""
    return np.asarray(position) + t[:, None] * np.asarray(velocity)


def constant(t: np.ndarray, vector: object) -> np.ndarray:
    """The same vector at every time, (T, n)."""
    return np.repeat(np.asarray(vector, dtype=np.float64)[None], len(t), axis=0)
