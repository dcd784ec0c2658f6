"""Advancement of boxes and spheres among each other; see `advancement`.

Two boxes are followed along the axes that separate them, a sphere along the line from the nearest point of
a box (or from the centre of another sphere) to its centre.
"""

from __future__ import annotations

import math

import numpy as np

from reference_impl.advancement import CLEAR, EVALUATIONS, HIT, TIRED, difference, root, safe, shadow, swing
from reference_impl.collide.boxes import axis, separations
from reference_impl.collide.primitives import corner
from reference_impl.kernels import angular_velocity, apply, apply_transposed, cross, dot, kernel, matrix, norm
from reference_impl.segments import where


@kernel
def relative(t, begin_a, xs_a, qs_a, begin_b, xs_b, qs_b, r, v, qa, ga, qb, gb):
    """Centre of a less centre of b and its rate, and both quaternions with their rates, at time t."""
    x, u = np.empty(3), np.empty(3)
    where(t - begin_a, xs_a, qs_a, r, v, qa, ga)
    where(t - begin_b, xs_b, qs_b, x, u, qb, gb)
    for c in range(3):
        r[c] -= x[c]
        v[c] -= u[c]


@kernel
def _corners(half):
    out = np.zeros((8, 3))
    for j in range(8):
        corner(half, j, out[j])
    return out


@kernel
def _turning(k, ra, wa, rb, wb, n, dn):
    """Rate of axis k of two boxes, whose direction now is n, as its features turn [1/s]."""
    if k < 6:
        turn = cross(wa if k < 3 else wb, n)
        for c in range(3):
            dn[c] = turn[c]
        return
    i, j = (k - 6) // 3, (k - 6) % 3
    a, b = np.empty(3), np.empty(3)
    for c in range(3):
        a[c], b[c] = ra[c, i], rb[c, j]
    m = cross(a, b)
    first, second = cross(cross(wa, a), b), cross(a, cross(wb, b))
    size = norm(m)
    sign = 1.0 if dot(m, n) > 0.0 else -1.0
    for c in range(3):
        dn[c] = sign * (first[c] + second[c]) / size
    along = dot(dn, n)
    for c in range(3):
        dn[c] -= along * n[c]


@kernel
def _toward(r, v, half, rb, wb, n, dn):
    """Whether the point at r from b's centre is outside box b (or off the centre of a sphere, which has no edges).

    `v` is the velocity of that point relative to b's centre; writes the unit vector from the nearest point of b
    to it and the rate of that vector.
    """
    m, dm = np.empty(3), np.empty(3)
    turning = cross(wb, r)
    square = 0.0
    local, rate = np.empty(3), np.empty(3)
    for c in range(3):
        local[c] = rb[0, c] * r[0] + rb[1, c] * r[1] + rb[2, c] * r[2]
        rate[c] = rb[0, c] * (v[0] - turning[0]) + rb[1, c] * (v[1] - turning[1]) + rb[2, c] * (v[2] - turning[2])
    for c in range(3):
        excess = abs(local[c]) - half[c]
        m[c] = (excess if local[c] > 0.0 else -excess) if excess > 0.0 else 0.0
        dm[c] = rate[c] if excess > 0.0 else 0.0
        square += m[c] * m[c]
    distance = math.sqrt(square)
    if distance == 0.0:
        return False
    along = dot(m, dm) / square
    for c in range(3):
        dm[c] = (dm[c] - m[c] * along) / distance
        m[c] /= distance
    turned, fixed = apply(rb, dm), apply(rb, m)
    carried = cross(wb, fixed)
    for c in range(3):
        n[c] = fixed[c]
        dn[c] = turned[c] + carried[c]
    return True


@kernel
def approach_boxes(
    t, end, begin_a, xs_a, qs_a, half_a, bounds_a, begin_b, xs_b, qs_b, half_b, bounds_b,
    tolerance, speed, touching, reach, parting
):  # fmt: skip
    """Time until which two boxes are clear of each other, or the time they hit.

    Parameters and result as in `approach_plane`.  With `touching` the axis that separates them at time t is
    kept, and corners are left out as there.
    """
    ca, cb = _corners(half_a), _corners(half_b)
    fa, da, fb, db = np.empty(8), np.empty(8), np.empty(8), np.empty(8)
    mask = np.zeros((8, 8), dtype=np.bool_)
    qa, ga, qb, gb = np.empty(4), np.empty(4), np.empty(4), np.empty(4)
    r, v, n, dn = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    values, out, limit = np.empty(15), np.empty(2), np.empty(2)
    size_a, size_b = norm(half_a), norm(half_b)
    pull = difference(bounds_a, bounds_b)
    kept = -1
    for count in range(1, EVALUATIONS + 1):
        relative(t, begin_a, xs_a, qs_a, begin_b, xs_b, qs_b, r, v, qa, ga, qb, gb)
        distance, pace = norm(r), norm(v)
        apart = distance - size_a - size_b
        if apart > 0.0:  # bounding spheres, along the line of centres
            s = root(apart, dot(r, v) / distance, pull)
            if t + s >= end:
                return end, CLEAR, count
            if apart > 1e-3 * (size_a + size_b):
                t += s
                continue
        window = min(end - t, distance / pace if pace > 0.0 else np.inf)
        ra, rb = matrix(qa), matrix(qb)
        wa, wb = angular_velocity(qa, ga), angular_velocity(qb, gb)
        best = separations(ra, half_a, rb, half_b, r, values)
        if touching and kept < 0:
            kept = best
        longest = -1.0
        for k in range(15):
            if kept >= 0:
                if k != kept or not axis(k, ra, rb, r, n):
                    continue
            elif values[k] < min(0.5 * values[best], values[best] - reach):
                continue  # at a touch several axes separate to rounding, and only some go on to do so
            else:
                axis(k, ra, rb, r, n)
            _turning(k, ra, wa, rb, wb, n, dn)
            shadow(ca, ra, wa, n, dn, fa, da)
            shadow(cb, rb, wb, n, dn, fb, db)
            base, drift = dot(n, r), dot(n, v) + dot(dn, r)
            if kept >= 0 and count == 1:
                for i in range(8):
                    for j in range(8):
                        mask[i, j] = base + fa[i] - fb[j] <= reach and drift + da[i] - db[j] <= parting
            turn = norm(dn)
            bound = swing(turn, distance, pace, pull, window)
            bound += size_a * ((turn + bounds_a[4]) ** 2 + bounds_a[5])
            bound += size_b * ((turn + bounds_b[4]) ** 2 + bounds_b[5])
            s = min(safe(base, drift, fa, da, fb, db, bound, tolerance, speed, mask, out), window)
            if s > longest:
                longest = s
                limit[0], limit[1] = out[0], out[1]
        if t + longest >= end:
            return end, CLEAR, count
        if longest >= 0.0 and limit[0] <= tolerance and limit[1] < -speed:
            return t + longest, HIT, count
        t += max(longest, 2e-16 * (window + abs(t)))
    return t, TIRED, EVALUATIONS


@kernel
def approach_sphere(
    t, end, begin_a, xs_a, qs_a, radius_a, bounds_a, begin_b, xs_b, qs_b, half_b, radius_b, bounds_b, tolerance, speed
):
    """Time until which a sphere a is clear of a box or sphere b, or the time they hit; result as `approach_plane`."""
    qa, ga, qb, gb = np.empty(4), np.empty(4), np.empty(4), np.empty(4)
    r, v, n, dn = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    cb, fb, db = _corners(half_b), np.empty(8), np.empty(8)
    none, mask, out = np.zeros(1), np.zeros((1, 8), dtype=np.bool_), np.empty(2)
    size_b = norm(half_b)
    radii = radius_a + radius_b
    pull = difference(bounds_a, bounds_b)
    for count in range(1, EVALUATIONS + 1):
        relative(t, begin_a, xs_a, qs_a, begin_b, xs_b, qs_b, r, v, qa, ga, qb, gb)
        distance, pace = norm(r), norm(v)
        apart = distance - size_b - radii
        if apart > 0.0:
            s = root(apart, dot(r, v) / distance, pull)
            if t + s >= end:
                return end, CLEAR, count
            if apart > 1e-3 * (size_b + radii):
                t += s
                continue
        rb, wb = matrix(qb), angular_velocity(qb, gb)
        if not _toward(r, v, half_b, rb, wb, n, dn):
            return t, HIT, count  # the centre of the sphere lies within the body: nothing separates them
        window = min(end - t, distance / pace if pace > 0.0 else np.inf)
        turn = norm(dn)
        bound = swing(turn, distance, pace, pull, window)
        bound += size_b * ((turn + bounds_b[4]) ** 2 + bounds_b[5])
        shadow(cb, rb, wb, n, dn, fb, db)
        base, drift = dot(n, r) - radii, dot(n, v) + dot(dn, r)
        s = min(safe(base, drift, none, none, fb, db, bound, tolerance, speed, mask, out), window)
        if t + s >= end:
            return end, CLEAR, count
        if out[0] <= tolerance and out[1] < -speed:
            return t + s, HIT, count
        t += max(s, 2e-16 * (window + abs(t)))
    return t, TIRED, EVALUATIONS


@kernel
def gap_boxes(t, begin_a, xs_a, qs_a, half_a, begin_b, xs_b, qs_b, half_b):
    """Greatest separation of two boxes along an axis at time t [m], which is zero when they touch; its rate [m/s]."""
    qa, ga, qb, gb = np.empty(4), np.empty(4), np.empty(4), np.empty(4)
    r, v, n, dn = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    relative(t, begin_a, xs_a, qs_a, begin_b, xs_b, qs_b, r, v, qa, ga, qb, gb)
    ra, rb, wa, wb = matrix(qa), matrix(qb), angular_velocity(qa, ga), angular_velocity(qb, gb)
    values = np.empty(15)
    best = separations(ra, half_a, rb, half_b, r, values)
    axis(best, ra, rb, r, n)
    _turning(best, ra, wa, rb, wb, n, dn)
    fa, da, fb, db = np.empty(8), np.empty(8), np.empty(8), np.empty(8)
    shadow(_corners(half_a), ra, wa, n, dn, fa, da)
    shadow(_corners(half_b), rb, wb, n, dn, fb, db)
    return values[best], dot(n, v) + dot(dn, r) + da[np.argmin(fa)] - db[np.argmax(fb)]


@kernel
def gap_sphere(t, begin_a, xs_a, qs_a, radius_a, begin_b, xs_b, qs_b, half_b, radius_b):
    """Gap of a sphere a and a box or sphere b at time t [m], and its rate [m/s]."""
    qa, ga, qb, gb = np.empty(4), np.empty(4), np.empty(4), np.empty(4)
    r, v, n, dn = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    relative(t, begin_a, xs_a, qs_a, begin_b, xs_b, qs_b, r, v, qa, ga, qb, gb)
    rb, wb = matrix(qb), angular_velocity(qb, gb)
    local = apply_transposed(rb, r)
    square, face = 0.0, 0
    for c in range(3):
        square += max(abs(local[c]) - half_b[c], 0.0) ** 2
        if abs(local[c]) - half_b[c] > abs(local[face]) - half_b[face]:
            face = c
    radii = radius_a + radius_b
    carried = cross(wb, r)
    if _toward(r, v, half_b, rb, wb, n, dn):
        # the nearest point moves across n only
        return math.sqrt(square) - radii, dot(n, v) - dot(n, carried)
    for c in range(3):  # inside: through the nearest face
        n[c] = rb[c, face] if local[face] > 0.0 else -rb[c, face]
    return abs(local[face]) - half_b[face] - radii, dot(n, v) - dot(n, carried)
