"""Free flight by power series.

In flight the position is a parabola (exact), or a series where drag acts.  The attitude is a Taylor
series: with the angular momentum l and angular velocity w = I⁻¹ l in the body frame and the
quaternion q,

    l' = l × w + torque,        q' = ½ q w.

Without a torque the world angular momentum is constant and is never integrated: see `spin_series`.
"""

from __future__ import annotations

import math

import numpy as np

from reference_impl.kernels import kernel, matrix, norm
from reference_impl.segments import place
from reference_impl.spin_series import align, begin_spin, compose, fastest_spin, free_series, keep, reach, to_end
from reference_impl.state import ORDER


@kernel
def _driven_series(q, momentum, inverse_inertia, torque, lever, spin_drag, out):
    """Taylor series of the quaternion into `out`; returns the time for which it holds [s].

    `lever` = Σ p Fᵀ of forces F constant in the world at points p fixed in the body: their torque
    in the body frame is Σ p × (Rᵀ F), and Rᵀ F' = (Rᵀ F) × w like every constant world vector.
    """
    rotation = matrix(q)
    l = np.zeros((ORDER + 1, 3))
    w = np.zeros((ORDER + 1, 3))
    axes = np.zeros((ORDER + 1, 3, 3))  # axes[k, m]: k-th coefficient of the world axis m in the body frame
    for c in range(4):
        out[0, c] = q[c]
    for c in range(3):
        l[0, c] = rotation[0, c] * momentum[0] + rotation[1, c] * momentum[1] + rotation[2, c] * momentum[2]
        for m in range(3):
            axes[0, m, c] = rotation[m, c]
    dl = np.empty(3)
    dq = np.empty(4)
    for k in range(ORDER):
        for c in range(3):
            w[k, c] = (
                inverse_inertia[c, 0] * l[k, 0] + inverse_inertia[c, 1] * l[k, 1] + inverse_inertia[c, 2] * l[k, 2]
            )
            dl[c] = 0.0
            dq[c + 1] = 0.0
        dq[0] = 0.0
        for j in range(k + 1):
            a, b, p = l[j], w[k - j], out[j]
            dl[0] += a[1] * b[2] - a[2] * b[1]
            dl[1] += a[2] * b[0] - a[0] * b[2]
            dl[2] += a[0] * b[1] - a[1] * b[0]
            dq[0] += -p[1] * b[0] - p[2] * b[1] - p[3] * b[2]
            dq[1] += p[0] * b[0] + p[2] * b[2] - p[3] * b[1]
            dq[2] += p[0] * b[1] - p[1] * b[2] + p[3] * b[0]
            dq[3] += p[0] * b[2] + p[1] * b[1] - p[2] * b[0]
        _add_torque(dl, axes, w, torque, lever, spin_drag, k)
        for c in range(3):
            l[k + 1, c] = dl[c] / (k + 1.0)
        for c in range(4):
            out[k + 1, c] = 0.5 * dq[c] / (k + 1.0)
    return reach(out)


@kernel
def _add_torque(dl, axes, w, torque, lever, spin_drag, k):
    """Add the k-th coefficient of the torque in the body frame to `dl` and carry the world axes one order on."""
    for m in range(3):
        e = axes[k, m]
        for c in range(3):
            dl[c] += torque[m] * e[c]
        dl[0] += lever[1, m] * e[2] - lever[2, m] * e[1]
        dl[1] += lever[2, m] * e[0] - lever[0, m] * e[2]
        dl[2] += lever[0, m] * e[1] - lever[1, m] * e[0]
        for j in range(k + 1):
            a, b = axes[j, m], w[k - j]
            axes[k + 1, m, 0] += (a[1] * b[2] - a[2] * b[1]) / (k + 1.0)
            axes[k + 1, m, 1] += (a[2] * b[0] - a[0] * b[2]) / (k + 1.0)
            axes[k + 1, m, 2] += (a[0] * b[1] - a[1] * b[0]) / (k + 1.0)
    for c in range(3):
        dl[c] -= spin_drag * w[k, c]


@kernel
def _path_series(x, v, acceleration, drag, out):
    """Series of the position under a constant acceleration and linear drag; returns for how long it holds [s]."""
    for c in range(3):
        out[0, c] = x[c]
        out[1, c] = v[c]
        out[2, c] = 0.5 * (acceleration[c] - drag * v[c])
        for k in range(2, ORDER):
            out[k + 1, c] = -drag * out[k, c] / (k + 1.0) if drag > 0.0 else 0.0
    return 0.5 / drag if drag > 0.0 else np.inf  # (1/2)^(ORDER + 1) over its factorial is far below rounding


@kernel
def _begin_path(x, v, q, acceleration, drag, x_series, q_series, bounds):
    """Path of a body that keeps its attitude, and bounds of what it can do; returns for how long they hold [s]."""
    span = _path_series(x, v, acceleration, drag, x_series)
    for c in range(4):
        q_series[0, c] = q[c]
        for k in range(1, ORDER + 1):
            q_series[k, c] = 0.0
    bounds[3] = bounds[4] = bounds[5] = 0.0
    for c in range(3):
        bounds[c] = 2.0 * x_series[2, c]
    if drag > 0.0:
        bounds[3] = 2.0 * drag * span * (norm(acceleration) + drag * norm(v))
    return span


@kernel
def free_flight(
    x, v, q, momentum, acceleration, drag, moments, frame, quickness, unevenness, turns,
    x_series, q_series, spin_series, kept, bounds
):  # fmt: skip
    """Polynomials of free flight of one body, bounds of what it can do meanwhile, and how long they hold [s].

    `turns` is False for a body whose attitude needs no series: it does not turn, or looks the same from all sides.
    """
    span = _begin_path(x, v, q, acceleration, drag, x_series, q_series, bounds)
    if not turns or norm(momentum) == 0.0:
        return span
    begin_spin(q, momentum, moments, frame, q_series, spin_series, kept)
    fastest = fastest_spin(spin_series[0], moments, quickness)
    bounds[4] = fastest
    # ω₁' = c₁ ω₂ ω₃ with |c| <= unevenness, and Σ ω₂² ω₃² <= |ω|⁴ / 3
    bounds[5] = unevenness * fastest * fastest / math.sqrt(3.0)
    return min(span, free_series(moments, frame, spin_series, q_series))


@kernel
def continued_flight(s, x, v, q, momentum, acceleration, drag, moments, frame, x_series, q_series, spin_series, kept,
                     bounds):  # fmt: skip
    """Polynomials of a free flight from s [s] in its segment on, and how long they hold [s]; also writes x, v and q.

    A body that turns keeps what it has kept since `free_flight`: nothing drifts, whatever the number of segments.
    """
    place(s, x_series, x, v)
    if bounds[4] == 0.0:
        for c in range(4):
            q[c] = q_series[0, c]
        return _begin_path(x, v, q, acceleration, drag, x_series, q_series, bounds)
    span = _path_series(x, v, acceleration, drag, x_series)
    for c in range(3):
        bounds[c] = 2.0 * x_series[2, c]
    if drag > 0.0:
        bounds[3] = 2.0 * drag * span * (norm(acceleration) + drag * norm(v))
    to_end(s, q_series)
    to_end(s, spin_series)
    if frame[0] != 1.0:
        compose(q_series[0], frame[0], frame[1], frame[2], frame[3])
    keep(spin_series[0], moments, kept)
    align(q_series[0], spin_series[0], moments, momentum)
    span = min(span, free_series(moments, frame, spin_series, q_series))
    for c in range(4):
        q[c] = q_series[0, c]
    return span


@kernel
def driven_flight(x, v, q, momentum, acceleration, drag, inverse, quickness, torque, lever, damping, x_series, q_series,
                  bounds):  # fmt: skip
    """As `free_flight`, for a body on which a torque acts: see `_driven_series`."""
    span = _begin_path(x, v, q, acceleration, drag, x_series, q_series, bounds)
    span = min(span, _driven_series(q, momentum, inverse, torque, lever, damping, q_series))
    load = norm(torque) + norm(lever[0]) + norm(lever[1]) + norm(lever[2])
    most = norm(momentum) + (load * span if load > 0.0 else 0.0)
    fastest = quickness * most
    bounds[4] = fastest
    bounds[5] = quickness * (load + damping * fastest + fastest * most)  # ω' = I⁻¹ (torque - ω × L)
    return span


@kernel
def fly_on(t, free, x, v, q, momentum, acceleration, drag, moments, frame, begin, end, start, x_series, q_series,
           spin_series, kept, bounds):  # fmt: skip
    """Continue the flights of the bodies `free` that end by time t, each at its own time, until all last beyond t.

    Returns the number of a body whose series last no time at all, or -1.
    """
    for i in range(len(free)):
        while free[i] and end[i] <= t:
            s = end[i] - begin[i]
            for c in range(3):
                start[i, c] = momentum[i, c]
            begin[i] = end[i]
            end[i] += continued_flight(
                s, x[i], v[i], q[i], momentum[i], acceleration[i], drag[i], moments[i], frame[i], x_series[i],
                q_series[i], spin_series[i], kept[i], bounds[i],
            )  # fmt: skip
            if not end[i] > begin[i]:
                return i
    return -1
