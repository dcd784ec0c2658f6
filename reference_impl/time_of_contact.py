"""When two bodies next touch.

Both bodies move on the polynomials of their segments.  Three ways to the time at which the gap is zero:

`parabola`
    Closed form where the gap of two spheres, or of a sphere and a half-space, is a quadratic in time.
`conservative advancement`, second order
    Along a unit vector n that separates the bodies and turns at a constant rate Ω with its features,
    every pair of corners has a gap d with d(t + s) >= d + d' s - K s²/2, where K bounds |d''|.  No contact
    can happen before the least root of these parabolas, so the search steps there and looks again: it
    never passes a contact and converges quadratically.  After Mirtich, Impulse-based dynamic simulation
    of rigid body systems (1996), who advances to first order.
`bisection`
    On the gap, in a bracket found by the advancement; for comparison.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from reference_impl.collide.boxes import axis, separations
from reference_impl.collide.primitives import corner
from reference_impl.integrators import where
from reference_impl.kernels import angular_velocity, apply, cross, dot, kernel, matrix, norm

CLEAR, HIT, TIRED = 0, 1, 2
EVALUATIONS = 5000  # of one call; a search that needs more goes on in the next call


def parabola(gap: float, rate: float, acceleration: float) -> float:
    """First time s > 0 at which gap + rate s + ½ acceleration s² falls to zero [s]; inf if it never does.

    Bodies that part from a touch, or from an overlap by rounding, meet again when they come back to
    zero.  Each root is written in the form that does not cancel.
    """
    if rate <= 0.0:
        gap = max(gap, 0.0)
    square = rate * rate - 2.0 * acceleration * gap
    if square < 0.0:
        if gap > 0.0:
            return math.inf
        square = rate * rate  # an overlap that never opens counts as a touch
    root = math.sqrt(square)
    if rate < 0.0:
        return 2.0 * gap / (root - rate)
    if acceleration >= 0.0:
        return math.inf
    return (rate + root) / -acceleration


def spheres_meet(r: np.ndarray, v: np.ndarray, radii: float) -> float:
    """First time s >= 0 at which |r + v s| = radii while it decreases [s]; inf if never.

    The gap function is |r|² - radii², divided by its scale so that it is a length.
    """
    approach = float(r @ v)
    if approach >= 0.0:
        return math.inf
    distance = math.sqrt(float(r @ r))
    square = float(v @ v)
    # the square of what the spheres miss each other by, from the part of v across r (no cancellation)
    across = v - r * (approach / (distance * distance))
    miss = distance * distance * float(across @ across) / square
    if miss > radii * radii:
        return math.inf
    excess = max(distance - radii, 0.0) * (distance + radii)
    return excess / (-approach + math.sqrt(square * (radii * radii - miss)))


def bisection(gap: Callable[[float], float], low: float, high: float, tolerance: float) -> tuple[float, int]:
    """Time at which `gap` is within `tolerance` of zero, and how many times it was evaluated.

    Parameters
    ----------
    gap : function of time [s] -> gap [m]
    low, high : float
        Times with gap > 0 and gap < 0 [s].
    """
    count = 0
    while True:
        middle = 0.5 * (low + high)
        if middle in (low, high):
            return low, count
        value = gap(middle)
        count += 1
        if abs(value) <= tolerance:
            return middle, count
        if value > 0.0:
            low = middle
        else:
            high = middle


@kernel
def _root(gap, rate, k):
    """Least s > 0 at which gap + rate s - k s²/2 comes down to zero [s]; a negative gap must part (rate > 0)."""
    if k <= 0.0:
        return gap / -rate if rate < 0.0 else np.inf
    root = math.sqrt(max(rate * rate + 2.0 * k * gap, 0.0))
    if rate >= 0.0:
        return (rate + root) / k
    return 2.0 * gap / (root - rate)


@kernel
def _safe(base, drift, fa, da, fb, db, k, tolerance, speed, mask, out):
    """Time in which no pair of corners can meet [s]; writes gap and rate of the pair that limits it.

    Corner i of a and j of b are `base` + fa[i] - fb[j] apart; masked pairs are not looked at.  A pair
    within `tolerance` whose rate is below `speed` may come as close as -`tolerance`, otherwise the search
    would stand still there.
    """
    safe = np.inf
    out[0], out[1] = np.inf, 0.0
    for i in range(len(fa)):
        for j in range(len(fb)):
            if mask[i, j]:
                continue
            gap = base + fa[i] - fb[j]
            rate = drift + da[i] - db[j]
            room = gap if rate > speed else max(gap, 0.0)
            if gap <= tolerance and abs(rate) <= speed:
                room += tolerance
            if safe < np.inf and room + rate * safe - 0.5 * k * safe * safe >= 0.0:
                continue
            s = _root(room, rate, k)
            if s < safe:
                safe = s
                out[0], out[1] = gap, rate
    return safe


@kernel
def _corners(half):
    """Corners of a box in its frame; one point at the origin for a body without edges."""
    count = 8 if half[0] > 0.0 else 1
    out = np.zeros((count, 3))
    if count == 8:
        for j in range(8):
            corner(half, j, out[j])
    return out


@kernel
def _shadow(corners, rotation, w, n, dn, f, df):
    """Corners along n, relative to the body's centre, and how fast that changes."""
    for i in range(len(corners)):
        arm = apply(rotation, corners[i])
        f[i] = dot(n, arm)
        df[i] = dot(n, cross(w, arm)) + dot(dn, arm)


@kernel
def _difference(bounds_a, bounds_b):
    """Greatest relative acceleration of the centres [m/s2]."""
    square = 0.0
    for c in range(3):
        square += (bounds_a[c] - bounds_b[c]) ** 2
    return math.sqrt(square) + bounds_a[3] + bounds_b[3]


@kernel
def approach_plane(
    t,
    end,
    begin_a,
    xs_a,
    qs_a,
    half,
    radius,
    bounds_a,
    begin_b,
    xs_b,
    normal,
    bounds_b,
    tolerance,
    speed,
    touching,
    reach,
    parting,
):
    """Time until which a box or sphere a is clear of the half-space b, or the time it hits it.

    Parameters
    ----------
    t, end : float
        Search from t to end [s].
    touching : bool
        Corners within `reach` [m] at time t that part no faster than `parting` [m/s] are left out: contact
        forces hold them.

    Returns
    -------
    time [s], CLEAR or HIT or TIRED, number of evaluations
    """
    corners = _corners(half)
    f, df = np.empty(len(corners)), np.empty(len(corners))
    none = np.zeros(1)
    mask = np.zeros((len(corners), 1), dtype=np.bool_)
    out = np.empty(2)
    x, v, q, rate = np.empty(3), np.empty(3), np.empty(4), np.empty(4)
    y, u = np.empty(3), np.empty(3)
    size = norm(half)
    zero = np.zeros(3)
    k = _difference(bounds_a, bounds_b) + size * (bounds_a[4] ** 2 + bounds_a[5])
    for count in range(1, EVALUATIONS + 1):
        where(t - begin_b, xs_b, qs_a, y, u, q, rate)
        where(t - begin_a, xs_a, qs_a, x, v, q, rate)
        base, drift = -radius, 0.0
        for c in range(3):
            base += normal[c] * (x[c] - y[c])
            drift += normal[c] * (v[c] - u[c])
        _shadow(corners, matrix(q), angular_velocity(q, rate), normal, zero, f, df)
        if touching and count == 1:
            for i in range(len(corners)):
                mask[i, 0] = base + f[i] <= reach and drift + df[i] <= parting
        s = _safe(base, drift, f, df, none, none, k, tolerance, speed, mask, out)
        if t + s >= end:
            return end, CLEAR, count
        if out[0] <= tolerance and out[1] < -speed:
            return t + s, HIT, count
        t += s
    return t, TIRED, EVALUATIONS


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
    """Direction from the nearest point of a box (or the centre of a sphere) b to the point r from b's centre.

    `v` is the velocity of that point relative to b's centre; writes the unit vector and its rate.
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
def approach_convex(
    t, end, begin_a, xs_a, qs_a, half_a, radius_a, bounds_a, begin_b, xs_b, qs_b, half_b, radius_b, bounds_b,
    tolerance, speed, touching, reach, parting
):  # fmt: skip
    """Time until which two bodies are clear of each other, or the time they hit; a sphere must be body a.

    Parameters and result as in `approach_plane`.  With `touching` (boxes only) the axis that
    separates them at time t is kept, and corners are left out as there.
    """
    ca, cb = _corners(half_a), _corners(half_b)
    fa, da, fb, db = np.empty(len(ca)), np.empty(len(ca)), np.empty(len(cb)), np.empty(len(cb))
    mask = np.zeros((len(ca), len(cb)), dtype=np.bool_)
    xa, va, qa, ga = np.empty(3), np.empty(3), np.empty(4), np.empty(4)
    xb, vb, qb, gb = np.empty(3), np.empty(3), np.empty(4), np.empty(4)
    r, v, n, dn = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    values, out, limit = np.empty(15), np.empty(2), np.empty(2)
    size_a, size_b = norm(half_a), norm(half_b)
    boxes = len(ca) == 8 and len(cb) == 8
    pull = _difference(bounds_a, bounds_b)
    kept = -1
    for count in range(1, EVALUATIONS + 1):
        where(t - begin_a, xs_a, qs_a, xa, va, qa, ga)
        where(t - begin_b, xs_b, qs_b, xb, vb, qb, gb)
        for c in range(3):
            r[c], v[c] = xa[c] - xb[c], va[c] - vb[c]
        distance, pace = norm(r), norm(v)
        apart = distance - size_a - size_b - radius_a - radius_b
        if apart > 0.0:  # bounding spheres, along the line of centres
            s = _root(apart, dot(r, v) / distance, pull)
            if t + s >= end:
                return end, CLEAR, count
            if apart > 1e-3 * (size_a + size_b + radius_a + radius_b):
                t += s
                continue
        window = min(end - t, distance / pace if pace > 0.0 else np.inf)
        travel = pull * window
        far = distance + (pace + travel) * window
        quick = pace + travel
        ra, rb = matrix(qa), matrix(qb)
        wa, wb = angular_velocity(qa, ga), angular_velocity(qb, gb)
        best = 0
        if boxes:
            best = separations(ra, half_a, rb, half_b, r, values)
            if touching and kept < 0:
                kept = best
        safe = -1.0
        for k in range(15 if boxes else 1):
            if boxes:
                if kept >= 0:
                    if k != kept or not axis(k, ra, rb, r, n):
                        continue
                elif values[k] < 0.5 * values[best] and k != best:
                    continue
                else:
                    axis(k, ra, rb, r, n)
                _turning(k, ra, wa, rb, wb, n, dn)
            elif not _toward(r, v, half_b, rb, wb, n, dn):
                continue
            _shadow(ca, ra, wa, n, dn, fa, da)
            _shadow(cb, rb, wb, n, dn, fb, db)
            base = dot(n, r) - radius_a - radius_b
            drift = dot(n, v) + dot(dn, r)
            if kept >= 0 and count == 1:
                for i in range(8):
                    for j in range(8):
                        mask[i, j] = base + fa[i] - fb[j] <= reach and drift + da[i] - db[j] <= parting
            turn = norm(dn)
            bound = turn * turn * far + 2.0 * turn * quick + pull
            bound += size_a * ((turn + bounds_a[4]) ** 2 + bounds_a[5])
            bound += size_b * ((turn + bounds_b[4]) ** 2 + bounds_b[5])
            s = min(_safe(base, drift, fa, da, fb, db, bound, tolerance, speed, mask, out), window)
            if s > safe:
                safe = s
                limit[0], limit[1] = out[0], out[1]
        if t + safe >= end:
            return end, CLEAR, count
        if safe >= 0.0 and limit[0] <= tolerance and limit[1] < -speed:
            return t + safe, HIT, count
        if safe < 0.0:  # the centre of a sphere lies within the body: nothing separates them
            return t, HIT, count
        t += max(safe, 1e-16 * (1.0 + abs(t)))
    return t, TIRED, EVALUATIONS


@kernel
def gap_plane(t, begin_a, xs_a, qs_a, half, radius, begin_b, xs_b, normal):
    """Gap of a box or sphere and a half-space at time t [m]."""
    x, v, q, rate = np.empty(3), np.empty(3), np.empty(4), np.empty(4)
    y, u = np.empty(3), np.empty(3)
    where(t - begin_b, xs_b, qs_a, y, u, q, rate)
    where(t - begin_a, xs_a, qs_a, x, v, q, rate)
    m = matrix(q)
    gap = -radius
    for c in range(3):
        gap += normal[c] * (x[c] - y[c])
        gap -= half[c] * abs(normal[0] * m[0, c] + normal[1] * m[1, c] + normal[2] * m[2, c])
    return gap


@kernel
def gap_convex(t, begin_a, xs_a, qs_a, half_a, radius_a, begin_b, xs_b, qs_b, half_b, radius_b):
    """Gap of two bodies at time t [m]: the greatest separation along an axis, which is zero when they touch."""
    xa, va, qa, ga = np.empty(3), np.empty(3), np.empty(4), np.empty(4)
    xb, vb, qb, gb = np.empty(3), np.empty(3), np.empty(4), np.empty(4)
    where(t - begin_a, xs_a, qs_a, xa, va, qa, ga)
    where(t - begin_b, xs_b, qs_b, xb, vb, qb, gb)
    r = np.empty(3)
    for c in range(3):
        r[c] = xa[c] - xb[c]
    ra, rb = matrix(qa), matrix(qb)
    if half_a[0] > 0.0 and half_b[0] > 0.0:
        values = np.empty(15)
        return values[separations(ra, half_a, rb, half_b, r, values)]
    square, deepest = 0.0, -np.inf
    for c in range(3):
        excess = abs(rb[0, c] * r[0] + rb[1, c] * r[1] + rb[2, c] * r[2]) - half_b[c]
        deepest = max(deepest, excess)
        square += max(excess, 0.0) ** 2
    return (math.sqrt(square) if deepest > 0.0 else deepest) - radius_a - radius_b
