"""Conservative advancement of second order: the time of the first contact, which is never passed.

Both bodies move on the polynomials of their segments.  Along a unit vector n that separates them and turns
at a constant rate with its features, every pair of corners has a gap d with

    d(t + s) >= d + d' s - K s²/2,    K >= |d''|.

No contact can happen before the least root of these parabolas, so the search steps there and looks again:
it never passes a contact and converges quadratically.  After Mirtich, Impulse-based dynamic simulation of
rigid body systems (1996), who advances to first order.

Here are what all shapes share, and corners over a half-space; `advancement_boxes` has boxes and spheres
among each other, `advancement_rims` cylinders, `advancement_solids` everything else.
"""

from __future__ import annotations

import math

import numpy as np

from reference_impl.kernels import apply_transposed, cross, dot, kernel, norm
from reference_impl.segments import attitude, order

CLEAR, HIT, TIRED = 0, 1, 2
EVALUATIONS = 5000  # of one call; a search that needs more goes on in the next call


@kernel
def root(gap, rate, k):
    """Least s > 0 at which gap + rate s - k s²/2 comes down to zero [s]; a negative gap must part (rate > 0)."""
    if k <= 0.0:
        return gap / -rate if rate < 0.0 else np.inf
    size = math.sqrt(max(rate * rate + 2.0 * k * gap, 0.0))
    if rate >= 0.0:
        return (rate + size) / k
    return 2.0 * gap / (size - rate)


@kernel
def room(gap, rate, tolerance, speed):
    """How far a pair with this gap [m] and rate [m/s] may come nearer [m].

    A pair that parts keeps its overlap by rounding.  One within `tolerance` that does not approach may come as
    close as -`tolerance`: otherwise the search would stand still there, and creep where a gap opens slowly.
    """
    out = gap if rate > speed else max(gap, 0.0)
    if gap <= tolerance and rate >= -speed:
        out += tolerance
    return out


@kernel
def safe(base, drift, fa, da, fb, db, k, tolerance, speed, mask, out):
    """Time in which no pair of corners can meet [s]; writes gap and rate of the pair that limits it.

    Corner i of a and j of b are `base` + fa[i] - fb[j] apart; masked pairs are not looked at.
    """
    least = np.inf
    out[0], out[1] = np.inf, 0.0
    for i in range(len(fa)):
        for j in range(len(fb)):
            if mask[i, j]:
                continue
            gap = base + fa[i] - fb[j]
            rate = drift + da[i] - db[j]
            free = room(gap, rate, tolerance, speed)
            if least < np.inf and free + rate * least - 0.5 * k * least * least >= 0.0:
                continue
            s = root(free, rate, k)
            if s < least:
                least = s
                out[0], out[1] = gap, rate
    return least


@kernel
def shadow(corners, rotation, w, n, dn, f, df):
    """Corners along n, relative to the body's centre, and how fast that changes."""
    turn = cross(n, w)  # n·(ω × r) = (n × ω)·r
    for c in range(3):
        turn[c] += dn[c]
    along, change = apply_transposed(rotation, n), apply_transposed(rotation, turn)
    for i in range(len(corners)):
        f[i] = dot(along, corners[i])
        df[i] = dot(change, corners[i])


@kernel
def difference(bounds_a, bounds_b):
    """Greatest relative acceleration of the centres [m/s2]."""
    square = 0.0
    for c in range(3):
        square += (bounds_a[c] - bounds_b[c]) ** 2
    return math.sqrt(square) + bounds_a[3] + bounds_b[3]


@kernel
def swing(turn, distance, pace, pull, window):
    """Greatest |d''| of the centres along a vector that turns at `turn` [1/s], for `window` seconds [m/s2].

    The centres are `distance` [m] apart now, at the relative speed `pace` [m/s] and at most `pull` [m/s2].
    """
    quick = pace + (pull * window if window < np.inf else 0.0)
    far = distance + quick * min(window, 1e300)  # what does not turn may have for ever: 0 * inf would be no number
    return turn * turn * far + 2.0 * turn * quick + pull


@kernel
def widest(corners):
    """Greatest distance of a corner from the body's centre [m]."""
    out = 0.0
    for i in range(len(corners)):
        out = max(out, norm(corners[i]))
    return out


@kernel
def height(t, begin_a, xs_a, begin_b, xs_b, normal):
    """Height of a's centre over the plane at time t [m] and its rate [m/s]."""
    s, u = t - begin_a, t - begin_b
    top_a, top_b = order(xs_a), order(xs_b)
    gap = rate = 0.0
    for c in range(3):
        x, y = xs_a[top_a, c], xs_b[top_b, c]
        dx = dy = 0.0
        for k in range(top_a - 1, -1, -1):
            dx, x = dx * s + x, x * s + xs_a[k, c]
        for k in range(top_b - 1, -1, -1):
            dy, y = dy * u + y, y * u + xs_b[k, c]
        gap += normal[c] * (x - y)
        rate += normal[c] * (dx - dy)
    return gap, rate


@kernel
def seen(s, q_series, n):
    """The world vector n in the frame of a body s seconds into its segment, and its rate there (3 numbers each)."""
    a, b, c, d, da, db, dc, dd = attitude(s, q_series)
    part = 2.0 / (a * a + b * b + c * c + d * d)
    x = n[0] - part * ((c * c + d * d) * n[0] - (b * c + a * d) * n[1] - (b * d - a * c) * n[2])
    y = n[1] - part * ((b * b + d * d) * n[1] - (c * d + a * b) * n[2] - (b * c - a * d) * n[0])
    z = n[2] - part * ((b * b + c * c) * n[2] - (b * d + a * c) * n[0] - (c * d - a * b) * n[1])
    # angular velocity in the body, 2 q⁻¹ q'
    p = part * (a * db - b * da - c * dd + d * dc)
    q = part * (a * dc - c * da - d * db + b * dd)
    r = part * (a * dd - d * da - b * dc + c * db)
    return x, y, z, y * r - z * q, z * p - x * r, x * q - y * p


@kernel
def approach_plane(
    t, end, begin_a, xs_a, qs_a, corners, radius, bounds_a, begin_b, xs_b, normal, bounds_b,
    tolerance, speed, touching, reach, parting
):  # fmt: skip
    """Time until which a body a, the hull of `corners` widened by `radius`, is clear of half-space b, or hits it.

    Parameters
    ----------
    t, end : float
        Search from t to end [s].
    corners : (k, 3) array
        In the frame of a; the origin for a sphere.
    touching : bool
        Corners within `reach` [m] at time t that part no faster than `parting` [m/s] are left out: contact
        forces hold them.

    Returns
    -------
    time [s], CLEAR or HIT or TIRED, number of evaluations
    """
    size, pull = widest(corners), difference(bounds_a, bounds_b)
    k = pull + size * (bounds_a[4] ** 2 + bounds_a[5])
    mask = np.zeros(len(corners) if touching else 0, dtype=np.bool_)
    for count in range(1, EVALUATIONS + 1):
        base, drift = height(t, begin_a, xs_a, begin_b, xs_b, normal)
        base -= radius
        if base > 1.001 * size > 0.0:  # the bounding sphere, wherever the corners are
            s = root(base - size, drift, pull)
            if t + s >= end:
                return end, CLEAR, count
            t += s
            continue
        x, y, z, dx, dy, dz = seen(t - begin_a, qs_a, normal)
        least, low, fall = np.inf, np.inf, 0.0
        for i in range(len(corners)):
            gap = base + (x * corners[i, 0] + y * corners[i, 1] + z * corners[i, 2])
            rate = drift + (dx * corners[i, 0] + dy * corners[i, 1] + dz * corners[i, 2])
            if touching:
                if count == 1:
                    mask[i] = gap <= reach and rate <= parting
                if mask[i]:
                    continue
            free = room(gap, rate, tolerance, speed)
            if least < np.inf and free + rate * least - 0.5 * k * least * least >= 0.0:
                continue
            s = root(free, rate, k)
            if s < least:
                least, low, fall = s, gap, rate
        if t + least >= end:
            return end, CLEAR, count
        if low <= tolerance and fall < -speed:
            return t + least, HIT, count
        t += least
    return t, TIRED, EVALUATIONS


@kernel
def gap_plane(t, begin_a, xs_a, qs_a, corners, radius, begin_b, xs_b, normal):
    """Gap of such a body and a half-space at time t [m], and its rate [m/s]."""
    base, drift = height(t, begin_a, xs_a, begin_b, xs_b, normal)
    x, y, z, dx, dy, dz = seen(t - begin_a, qs_a, normal)
    gap, rate = np.inf, 0.0
    for i in range(len(corners)):
        low = base - radius + (x * corners[i, 0] + y * corners[i, 1] + z * corners[i, 2])
        if low < gap:
            gap, rate = low, drift + (dx * corners[i, 0] + dy * corners[i, 1] + dz * corners[i, 2])
    return gap, rate
