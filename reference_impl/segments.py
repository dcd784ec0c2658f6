"""Where bodies are on the polynomials of their segments of motion, in free flight or in lasting contact."""

from __future__ import annotations

import math

import numpy as np

from reference_impl.kernels import angular_velocity, apply, apply_transposed, kernel, matrix, turned
from reference_impl.state import ORDER


@kernel
def order(series):
    """Order of a polynomial of free flight or of lasting contact: two, five, or all there is."""
    top = 2
    for c in range(series.shape[1]):
        if series[6, c] != 0.0 or series[7, c] != 0.0:
            return ORDER
        if series[3, c] != 0.0 or series[4, c] != 0.0 or series[5, c] != 0.0:
            top = 5
    return top


@kernel
def place(s, x_series, x, v):
    """Position and velocity s seconds into a segment, into the arrays given."""
    top = order(x_series)
    for c in range(3):
        p = x_series[top, c]
        d = 0.0
        for k in range(top - 1, -1, -1):
            d = d * s + p
            p = p * s + x_series[k, c]
        x[c] = p
        v[c] = d


@kernel
def attitude(s, q_series):
    """Quaternion (4 numbers, of about unit length) and its rate (4 numbers) s seconds into a segment."""
    top = order(q_series)
    a, b, c, d = q_series[top, 0], q_series[top, 1], q_series[top, 2], q_series[top, 3]
    da = db = dc = dd = 0.0
    for k in range(top - 1, -1, -1):
        da, db, dc, dd = da * s + a, db * s + b, dc * s + c, dd * s + d
        a, b, c, d = a * s + q_series[k, 0], b * s + q_series[k, 1], c * s + q_series[k, 2], d * s + q_series[k, 3]
    return a, b, c, d, da, db, dc, dd


@kernel
def where(s, x_series, q_series, x, v, q, rate):
    """Position, velocity, quaternion and its rate s seconds into one body's segment, into the arrays given."""
    place(s, x_series, x, v)
    q[0], q[1], q[2], q[3], rate[0], rate[1], rate[2], rate[3] = attitude(s, q_series)


@kernel
def carry(t, plain, inverse_inertia, x, v, q, momentum, begin, x_series, q_series):
    """Set position, velocity and attitude of every body to what its polynomials say at time t.

    A `plain` body in flight turns at a constant angular velocity and its attitude is exact.  A path whose terms of
    order three to five are zero is a parabola: drag has them all, and motion in lasting contact has no others.
    """
    for i in range(len(x)):
        s = t - begin[i]
        parabolic = True
        for c in range(3):
            if x_series[i, 3, c] != 0.0 or x_series[i, 4, c] != 0.0 or x_series[i, 5, c] != 0.0:
                parabolic = False
        top = 2 if parabolic else ORDER
        for c in range(3):
            p = x_series[i, top, c]
            d = 0.0
            for k in range(top - 1, -1, -1):
                d = d * s + p
                p = p * s + x_series[i, k, c]
            x[i, c] = p
            v[i, c] = d
        still = True
        for c in range(4):
            q[i, c] = q_series[i, 0, c]
            still = still and q_series[i, 1, c] == 0.0 and q_series[i, 2, c] == 0.0
        if plain[i] and still:  # friction that lasts turns a sphere as polynomials say
            angle = apply(inverse_inertia[i], momentum[i])
            for c in range(3):
                angle[c] *= s
            now = turned(q_series[i, 0], angle)
            for c in range(4):  # not q[i] = now: numba compiles all of its words for shapes that differ
                q[i, c] = now[c]
            continue
        if still or s == 0.0:
            continue
        a, b, f, g = q_series[i, ORDER]
        for k in range(ORDER - 1, -1, -1):
            a = a * s + q_series[i, k, 0]
            b = b * s + q_series[i, k, 1]
            f = f * s + q_series[i, k, 2]
            g = g * s + q_series[i, k, 3]
        size = math.sqrt(a * a + b * b + f * f + g * g)
        q[i, 0], q[i, 1], q[i, 2], q[i, 3] = a / size, b / size, f / size, g / size


@kernel
def spins(q, inverse_inertia, momentum, w):
    """Angular velocities R I⁻¹ Rᵀ L of all bodies into `w` (n, 3) [rad/s]."""
    body = np.empty(3)
    turn = np.empty(3)
    for i in range(len(q)):
        l = momentum[i]
        if l[0] == 0.0 and l[1] == 0.0 and l[2] == 0.0:
            w[i, 0] = w[i, 1] = w[i, 2] = 0.0
            continue
        a, b, f, g = q[i]
        s = 2.0 / (a * a + b * b + f * f + g * g)
        xx, yy, zz = 1.0 - s * (f * f + g * g), 1.0 - s * (b * b + g * g), 1.0 - s * (b * b + f * f)
        xy, yx = s * (b * f - a * g), s * (b * f + a * g)
        xz, zx = s * (b * g + a * f), s * (b * g - a * f)
        yz, zy = s * (f * g - a * b), s * (f * g + a * b)
        body[0] = xx * l[0] + yx * l[1] + zx * l[2]
        body[1] = xy * l[0] + yy * l[1] + zy * l[2]
        body[2] = xz * l[0] + yz * l[1] + zz * l[2]
        for c in range(3):
            turn[c] = (
                inverse_inertia[i, c, 0] * body[0]
                + inverse_inertia[i, c, 1] * body[1]
                + inverse_inertia[i, c, 2] * body[2]
            )
        w[i, 0] = xx * turn[0] + xy * turn[1] + xz * turn[2]
        w[i, 1] = yx * turn[0] + yy * turn[1] + yz * turn[2]
        w[i, 2] = zx * turn[0] + zy * turn[1] + zz * turn[2]


@kernel
def driven_momentum(s, inertia, x_series, q_series):
    """World angular momentum of a body on which a torque acts, s seconds into its segment [kg m2/s]."""
    x, v, q, rate = np.empty(3), np.empty(3), np.empty(4), np.empty(4)
    where(s, x_series, q_series, x, v, q, rate)
    rotation = matrix(q)
    return apply(rotation, apply(inertia, apply_transposed(rotation, angular_velocity(q, rate))))
