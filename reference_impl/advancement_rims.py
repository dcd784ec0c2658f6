"""Advancement of a cylinder over a half-space, and of a sphere near a cylinder; see `advancement`.

The corners of a cylinder are the points of its two rims.  Along n a rim whose centre is the height A above
the other body reaches down by R |p|, p being the part of n along the rim's plane, and of all its points

    d(t + s) >= A + A' s - R |p + p' s| - K s²/2,

which is concave in s and has one last root.
"""

from __future__ import annotations

import math

import numpy as np

from reference_impl.advancement import CLEAR, EVALUATIONS, HIT, TIRED, difference, room, root, swing
from reference_impl.advancement_boxes import relative
from reference_impl.kernels import angular_velocity, apply, apply_transposed, cross, dot, kernel, matrix, norm
from reference_impl.segments import where

REFINEMENTS = 60  # Newton steps of `rim_root`, which converge quadratically and from one side


@kernel
def rim_root(height, climb, ring, p, dp, k, tolerance, speed, out):
    """Time in which no point of a rim comes down to zero [s]; writes gap and rate of its lowest point.

    Parameters
    ----------
    height, climb : float
        Of the rim's centre [m] and its rate [m/s].
    ring : float
        Radius of the rim [m].
    p, dp : (2,) arrays
        Part of the normal along the rim's plane, and its rate [1/s].
    """
    size = math.sqrt(p[0] * p[0] + p[1] * p[1])
    pace = math.sqrt(dp[0] * dp[0] + dp[1] * dp[1])
    turn = (p[0] * dp[0] + p[1] * dp[1]) / size if size > 0.0 else pace
    gap, rate = height - ring * size, climb - ring * turn
    out[0], out[1] = gap, rate
    lift = room(gap, rate, tolerance, speed) - gap
    s = root(gap + lift, rate, k)  # right of the root: |p + p' s| rises above its tangent
    if pace == 0.0 or s == np.inf:
        return s
    for _ in range(REFINEMENTS):
        x, y = p[0] + dp[0] * s, p[1] + dp[1] * s
        far = math.sqrt(x * x + y * y)
        value = height + lift + climb * s - ring * far - 0.5 * k * s * s
        slope = climb - k * s
        if far > 0.0:
            slope -= ring * (x * dp[0] + y * dp[1]) / far
        if value >= 0.0 or slope >= 0.0:
            return s
        step = value / slope
        s -= step
        if step <= 1e-16 * s:
            return s
    return s


@kernel
def _rim(side, half, rotation, w, n, dn, p, dp):
    """Height of a rim's centre along n, relative to the body's centre, and its rate; writes p and p'."""
    axis = np.empty(3)
    for k in range(2):
        for c in range(3):
            axis[c] = rotation[c, k]
        p[k] = dot(n, axis)
        dp[k] = dot(dn, axis) + dot(n, cross(w, axis))
    for c in range(3):
        axis[c] = side * half * rotation[c, 2]
    return dot(n, axis), dot(dn, axis) + dot(n, cross(w, axis))


@kernel
def _over_plane(t, begin_a, xs_a, qs_a, begin_b, xs_b, normal, q, rate, out):
    """Quaternion of a and its rate at time t; height of a's centre over the plane [m] and its rate into `out`."""
    x, v, y, u = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    where(t - begin_b, xs_b, qs_a, y, u, q, rate)
    where(t - begin_a, xs_a, qs_a, x, v, q, rate)
    out[0] = out[1] = 0.0
    for c in range(3):
        out[0] += normal[c] * (x[c] - y[c])
        out[1] += normal[c] * (v[c] - u[c])


@kernel
def approach_rims_plane(
    t, end, begin_a, xs_a, qs_a, ring, half, bounds_a, begin_b, xs_b, normal, bounds_b,
    tolerance, speed, touching, reach, parting
):  # fmt: skip
    """Time until which a cylinder a is clear of the half-space b, or the time it hits it.

    Parameters and result as in `approach_plane`.  A rim that contact forces hold at its lowest point can hit
    with its highest one only: then it lies flat.
    """
    height, q, rate = np.empty(2), np.empty(4), np.empty(4)
    p, dp, out, limit, zero = np.empty(2), np.empty(2), np.empty(2), np.empty(2), np.zeros(3)
    held, flat = np.zeros(2, dtype=np.bool_), np.zeros(2, dtype=np.bool_)
    k = difference(bounds_a, bounds_b) + math.sqrt(ring * ring + half * half) * (bounds_a[4] ** 2 + bounds_a[5])
    for count in range(1, EVALUATIONS + 1):
        _over_plane(t, begin_a, xs_a, qs_a, begin_b, xs_b, normal, q, rate, height)
        rotation, w = matrix(q), angular_velocity(q, rate)
        least = np.inf
        limit[0], limit[1] = np.inf, 0.0
        for end_of in range(2):
            centre, climb = _rim(2.0 * end_of - 1.0, half, rotation, w, normal, zero, p, dp)
            centre += height[0]
            climb += height[1]
            s = rim_root(centre, climb, ring, p, dp, k, tolerance, speed, out)
            if touching:
                size = math.sqrt(p[0] * p[0] + p[1] * p[1])
                top, lift = centre + ring * size, climb
                if size > 0.0:  # a convex function of time lies above its tangent
                    lift += ring * (p[0] * dp[0] + p[1] * dp[1]) / size
                if count == 1:
                    held[end_of] = out[0] <= reach and out[1] <= parting
                    flat[end_of] = top <= reach
                if held[end_of]:
                    if flat[end_of]:
                        continue
                    out[0], out[1] = top, lift
                    s = root(room(top, lift, tolerance, speed), lift, k)
            if s < least:
                least = s
                limit[0], limit[1] = out[0], out[1]
        if t + least >= end:
            return end, CLEAR, count
        if limit[0] <= tolerance and limit[1] < -speed:
            return t + least, HIT, count
        t += least
    return t, TIRED, EVALUATIONS


@kernel
def gap_rims_plane(t, begin_a, xs_a, qs_a, ring, half, begin_b, xs_b, normal):
    """Gap of a cylinder and a half-space at time t [m], and its rate [m/s]."""
    height, q, rate = np.empty(2), np.empty(4), np.empty(4)
    _over_plane(t, begin_a, xs_a, qs_a, begin_b, xs_b, normal, q, rate, height)
    rotation, w = matrix(q), angular_velocity(q, rate)
    p, dp = np.empty(2), np.empty(2)
    side = -1.0 if dot(normal, rotation[:, 2]) > 0.0 else 1.0
    centre, climb = _rim(side, half, rotation, w, normal, np.zeros(3), p, dp)
    size = math.sqrt(p[0] * p[0] + p[1] * p[1])
    turn = (p[0] * dp[0] + p[1] * dp[1]) / size if size > 0.0 else math.sqrt(dp[0] * dp[0] + dp[1] * dp[1])
    return height[0] + centre - ring * size, height[1] + climb - ring * turn


@kernel
def _toward(r, v, ring, half, rb, wb, n, dn):
    """Distance of the point at r from cylinder b's centre from the cylinder [m], and its rate [m/s].

    `v` is the velocity of that point relative to b's centre; writes the unit vector from the nearest point of b
    and the rate of that vector.  Inside, the distance is negative and the vector that of the nearest face.
    """
    carried = cross(wb, r)
    local, rate = apply_transposed(rb, r), apply_transposed(rb, v - carried)
    m, dm = np.zeros(3), np.zeros(3)
    rho = math.sqrt(local[0] * local[0] + local[1] * local[1])
    drho = (local[0] * rate[0] + local[1] * rate[1]) / rho if rho > 0.0 else 0.0
    wide, high = rho - ring, abs(local[2]) - half
    if wide > 0.0 or (high <= 0.0 and wide > high):
        for c in range(2):
            m[c] = local[c] / rho * wide
            dm[c] = rate[c] * wide / rho + local[c] / rho * drho * ring / rho
    if high > 0.0 or (wide <= 0.0 and high >= wide):
        m[2] = high if local[2] > 0.0 else -high
        dm[2] = rate[2]
    size = norm(m)
    inside = wide <= 0.0 and high <= 0.0
    if size == 0.0:
        m[2] = 1.0 if local[2] > 0.0 else -1.0
        size = 1.0
    sign = -1.0 if inside else 1.0
    along = dot(m, dm) / size
    for c in range(3):
        m[c] *= sign / size
        dm[c] = (sign * dm[c] - m[c] * along) / size
    turned, fixed = apply(rb, dm), apply(rb, m)
    swing = cross(wb, fixed)
    for c in range(3):
        n[c] = fixed[c]
        dn[c] = turned[c] + swing[c]
    return max(wide, high) if inside else size, dot(n, v) - dot(n, carried)


@kernel
def approach_sphere_cylinder(
    t, end, begin_a, xs_a, qs_a, radius, bounds_a, begin_b, xs_b, qs_b, ring, half, bounds_b, tolerance, speed
):
    """Time until which a sphere a is clear of a cylinder b, or the time they hit; result as `approach_plane`."""
    qa, ga, qb, gb = np.empty(4), np.empty(4), np.empty(4), np.empty(4)
    r, v, n, dn = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    p, dp, out, limit = np.empty(2), np.empty(2), np.empty(2), np.empty(2)
    size = math.sqrt(ring * ring + half * half)
    pull = difference(bounds_a, bounds_b)
    for count in range(1, EVALUATIONS + 1):
        relative(t, begin_a, xs_a, qs_a, begin_b, xs_b, qs_b, r, v, qa, ga, qb, gb)
        distance, pace = norm(r), norm(v)
        apart = distance - size - radius
        if apart > 0.0:
            s = root(apart, dot(r, v) / distance, pull)
            if t + s >= end:
                return end, CLEAR, count
            if apart > 1e-3 * (size + radius):
                t += s
                continue
        rb, wb = matrix(qb), angular_velocity(qb, gb)
        if _toward(r, v, ring, half, rb, wb, n, dn)[0] <= 0.0:
            return t, HIT, count  # the centre of the sphere lies within the cylinder: nothing separates them
        window = min(end - t, distance / pace if pace > 0.0 else np.inf)
        turn = norm(dn)
        bound = swing(turn, distance, pace, pull, window)
        bound += size * ((turn + bounds_b[4]) ** 2 + bounds_b[5])
        least = np.inf
        for end_of in range(2):
            centre, climb = _rim(2.0 * end_of - 1.0, half, rb, wb, n, dn, p, dp)
            height, rise = dot(n, r) - radius - centre, dot(n, v) + dot(dn, r) - climb
            s = rim_root(height, rise, ring, p, dp, bound, tolerance, speed, out)
            if s < least:
                least = s
                limit[0], limit[1] = out[0], out[1]
        least = min(least, window)
        if t + least >= end:
            return end, CLEAR, count
        if limit[0] <= tolerance and limit[1] < -speed:
            return t + least, HIT, count
        t += max(least, 2e-16 * (window + abs(t)))
    return t, TIRED, EVALUATIONS


@kernel
def gap_sphere_cylinder(t, begin_a, xs_a, qs_a, radius, begin_b, xs_b, qs_b, ring, half):
    """Gap of a sphere a and a cylinder b at time t [m], and its rate [m/s]."""
    qa, ga, qb, gb = np.empty(4), np.empty(4), np.empty(4), np.empty(4)
    r, v, n, dn = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    relative(t, begin_a, xs_a, qs_a, begin_b, xs_b, qs_b, r, v, qa, ga, qb, gb)
    gap, rate = _toward(r, v, ring, half, matrix(qb), angular_velocity(qb, gb), n, dn)
    return gap - radius, rate
