"""Unit quaternions (w, x, y, z) that rotate body vectors into the world.

q and -q are the same orientation, so orientations are compared by `angle_between` and never by
component.  Every function works on single values and on batches (leading axes broadcast).
"""

from __future__ import annotations

import numpy as np

from mechanics.arrays import Mat33, Matrices, Quat, Quats, Scalars, Vec3, Vectors

IDENTITY: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)


def product(p: Quats, q: Quats) -> Quats:
    """Hamilton product p q: the rotation q followed by the rotation p."""
    p0, p1, p2, p3 = np.moveaxis(p, -1, 0)
    q0, q1, q2, q3 = np.moveaxis(q, -1, 0)
    return np.stack(
        [
            p0 * q0 - p1 * q1 - p2 * q2 - p3 * q3,
            p0 * q1 + p1 * q0 + p2 * q3 - p3 * q2,
            p0 * q2 - p1 * q3 + p2 * q0 + p3 * q1,
            p0 * q3 + p1 * q2 - p2 * q1 + p3 * q0,
        ],
        axis=-1,
    )


def conjugate(q: Quats) -> Quats:
    """Inverse of a unit quaternion: the rotation backwards."""
    return q * np.array([1.0, -1.0, -1.0, -1.0])


def normalised(q: Quats) -> Quats:
    """Unit quaternion along q."""
    return q / np.linalg.norm(q, axis=-1, keepdims=True)


def cross(a: Vectors, b: Vectors) -> Vectors:
    """a × b, bit for bit what np.cross gives, which takes three times as long for a single pair."""
    out = np.empty(np.broadcast_shapes(a.shape, b.shape))
    a0, a1, a2 = a[..., 0], a[..., 1], a[..., 2]
    b0, b1, b2 = b[..., 0], b[..., 1], b[..., 2]
    out[..., 0] = a1 * b2 - a2 * b1
    out[..., 1] = a2 * b0 - a0 * b2
    out[..., 2] = a0 * b1 - a1 * b0
    return out


def rotate(q: Quats, vector: Vectors) -> Vectors:
    """Body vector(s) turned into the world frame, R(q) v, without building the matrix."""
    u = q[..., 1:]
    twice = 2.0 * cross(u, vector)
    return vector + q[..., :1] * twice + cross(u, twice)


def unrotate(q: Quats, vector: Vectors) -> Vectors:
    """World vector(s) turned into the body frame, R(q)ᵀ v."""
    return rotate(conjugate(q), vector)


def matrix(q: Quats) -> Matrices:
    """Rotation matrix whose columns are the body axes in the world frame."""
    w, x, y, z = np.moveaxis(q, -1, 0)
    rows = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def from_matrix(rotation: Mat33) -> Quat:
    """Unit quaternion of a proper rotation matrix, accurate for every angle.

    The largest of the four squared components is taken as divisor (Shepperd 1978).
    """
    m = rotation
    squares = np.array(
        [1.0 + m[0, 0] + m[1, 1] + m[2, 2], 1.0 + m[0, 0] - m[1, 1] - m[2, 2],
         1.0 - m[0, 0] + m[1, 1] - m[2, 2], 1.0 - m[0, 0] - m[1, 1] + m[2, 2]]
    )  # fmt: skip
    rows = np.array(
        [
            [squares[0], m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]],
            [m[2, 1] - m[1, 2], squares[1], m[0, 1] + m[1, 0], m[0, 2] + m[2, 0]],
            [m[0, 2] - m[2, 0], m[0, 1] + m[1, 0], squares[2], m[1, 2] + m[2, 1]],
            [m[1, 0] - m[0, 1], m[0, 2] + m[2, 0], m[1, 2] + m[2, 1], squares[3]],
        ]
    )
    return normalised(rows[int(np.argmax(squares))])


def exponential(rotation_vector: Vectors) -> Quats:
    """Unit quaternion of the rotation by |φ| about φ [rad]; smooth through φ = 0."""
    half = 0.5 * np.linalg.norm(rotation_vector, axis=-1, keepdims=True)
    # np.sinc(x) = sin(πx)/(πx), so ½ sin(h)/h needs no branch at h = 0
    return np.concatenate([np.cos(half), 0.5 * np.sinc(half / np.pi) * rotation_vector], axis=-1)


def about(axis: Vec3 | tuple[float, float, float], angle: float) -> Quat:
    """Unit quaternion of the rotation by `angle` [rad] about `axis` (any length but zero)."""
    direction = np.asarray(axis, dtype=np.float64)
    return exponential(direction / np.linalg.norm(direction) * angle)


def angle_between(p: Quats, q: Quats) -> Scalars:
    """Angle of the rotation that carries p into q, in [0, π] [rad].

    From 2 atan2(|vector|, |scalar|) of the relative quaternion: the arccosine form cannot see
    angles below 1e-8.
    """
    relative = product(conjugate(p), q)
    return 2.0 * np.arctan2(np.linalg.norm(relative[..., 1:], axis=-1), np.abs(relative[..., 0]))
