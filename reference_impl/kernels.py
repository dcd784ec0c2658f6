"""Compiled vector and rotation arithmetic.

Everything the engine computes many times a step is compiled on first use and kept in numba's cache.
No fast-math and no threads: the same input gives the same bits.  With NUMBA_DISABLE_JIT=1 the same
functions run as plain Python.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

kernel = njit(cache=True, error_model="numpy")


@kernel
def dot(a, b):
    """a·b of two 3-vectors."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def norm(a):
    """Length of a 3-vector."""
    return math.sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])


@kernel
def cross(a, b):
    """a × b."""
    out = np.empty(3)
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]
    return out


@kernel
def apply(m, a):
    """Matrix times vector, m a."""
    out = np.empty(3)
    for i in range(3):
        out[i] = m[i, 0] * a[0] + m[i, 1] * a[1] + m[i, 2] * a[2]
    return out


@kernel
def apply_transposed(m, a):
    """Transposed matrix times vector, mᵀ a: the world vector a in the frame whose axes are m's columns."""
    out = np.empty(3)
    for i in range(3):
        out[i] = m[0, i] * a[0] + m[1, i] * a[1] + m[2, i] * a[2]
    return out


@kernel
def matrix(q):
    """Rotation matrix of the quaternion q, which need not have unit length: columns are the body axes in the world."""
    s = 2.0 / (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    w, x, y, z = q[0], q[1], q[2], q[3]
    m = np.empty((3, 3))
    m[0, 0] = 1.0 - s * (y * y + z * z)
    m[0, 1] = s * (x * y - w * z)
    m[0, 2] = s * (x * z + w * y)
    m[1, 0] = s * (x * y + w * z)
    m[1, 1] = 1.0 - s * (x * x + z * z)
    m[1, 2] = s * (y * z - w * x)
    m[2, 0] = s * (x * z - w * y)
    m[2, 1] = s * (y * z + w * x)
    m[2, 2] = 1.0 - s * (x * x + y * y)
    return m


@kernel
def turned(q, angle):
    """Quaternion of the attitude q turned further by the world rotation vector `angle` [rad], of unit length."""
    half = 0.5 * norm(angle)
    c = math.cos(half)
    s = 0.5 if half == 0.0 else 0.5 * math.sin(half) / half
    x, y, z = s * angle[0], s * angle[1], s * angle[2]
    out = np.empty(4)
    out[0] = c * q[0] - x * q[1] - y * q[2] - z * q[3]
    out[1] = c * q[1] + x * q[0] + y * q[3] - z * q[2]
    out[2] = c * q[2] - x * q[3] + y * q[0] + z * q[1]
    out[3] = c * q[3] + x * q[2] - y * q[1] + z * q[0]
    size = math.sqrt(out[0] * out[0] + out[1] * out[1] + out[2] * out[2] + out[3] * out[3])
    for c in range(4):
        out[c] /= size
    return out


@kernel
def spin_rate(q, w):
    """Derivative of q under the world angular velocity w, q' = ½ ω q [1/s]."""
    out = np.empty(4)
    out[0] = -0.5 * (w[0] * q[1] + w[1] * q[2] + w[2] * q[3])
    out[1] = 0.5 * (w[0] * q[0] + w[1] * q[3] - w[2] * q[2])
    out[2] = 0.5 * (-w[0] * q[3] + w[1] * q[0] + w[2] * q[1])
    out[3] = 0.5 * (w[0] * q[2] - w[1] * q[1] + w[2] * q[0])
    return out


@kernel
def angular_velocity(q, rate):
    """World angular velocity of an attitude q that changes at `rate`, ω = 2 q' q⁻¹ [rad/s]."""
    size = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]
    s = 2.0 / size
    out = np.empty(3)
    out[0] = s * (-rate[0] * q[1] + rate[1] * q[0] - rate[2] * q[3] + rate[3] * q[2])
    out[1] = s * (-rate[0] * q[2] + rate[1] * q[3] + rate[2] * q[0] - rate[3] * q[1])
    out[2] = s * (-rate[0] * q[3] - rate[1] * q[2] + rate[2] * q[1] + rate[3] * q[0])
    return out


@kernel
def spin(rotation, inverse_inertia, momentum):
    """Angular velocity R I⁻¹ Rᵀ L of the angular momentum L, world frame [rad/s]; I⁻¹ in the body frame."""
    return apply(rotation, apply(inverse_inertia, apply_transposed(rotation, momentum)))
