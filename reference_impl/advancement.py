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

from reference_impl.integrators import where
from reference_impl.kernels import angular_velocity, apply_transposed, cross, dot, kernel, matrix, norm

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
def widest(corners):
    """Greatest distance of a corner from the body's centre [m]."""
    out = 0.0
    for i in range(len(corners)):
        out = max(out, norm(corners[i]))
    return out


@kernel
def over_plane(t, begin_a, xs_a, qs_a, begin_b, xs_b, normal, q, rate, out):
    """Quaternion of a and its rate at time t; height of a's centre over the plane [m] and its rate into `out`."""
    x, v, y, u = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    where(t - begin_b, xs_b, qs_a, y, u, q, rate)
    where(t - begin_a, xs_a, qs_a, x, v, q, rate)
    out[0] = out[1] = 0.0
    for c in range(3):
        out[0] += normal[c] * (x[c] - y[c])
        out[1] += normal[c] * (v[c] - u[c])


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
    f, df = np.empty(len(corners)), np.empty(len(corners))
    none, zero = np.zeros(1), np.zeros(3)
    mask = np.zeros((len(corners), 1), dtype=np.bool_)
    out, height = np.empty(2), np.empty(2)
    q, rate = np.empty(4), np.empty(4)
    k = difference(bounds_a, bounds_b) + widest(corners) * (bounds_a[4] ** 2 + bounds_a[5])
    for count in range(1, EVALUATIONS + 1):
        over_plane(t, begin_a, xs_a, qs_a, begin_b, xs_b, normal, q, rate, height)
        base, drift = height[0] - radius, height[1]
        shadow(corners, matrix(q), angular_velocity(q, rate), normal, zero, f, df)
        if touching and count == 1:
            for i in range(len(corners)):
                mask[i, 0] = base + f[i] <= reach and drift + df[i] <= parting
        s = safe(base, drift, f, df, none, none, k, tolerance, speed, mask, out)
        if t + s >= end:
            return end, CLEAR, count
        if out[0] <= tolerance and out[1] < -speed:
            return t + s, HIT, count
        t += s
    return t, TIRED, EVALUATIONS


@kernel
def gap_plane(t, begin_a, xs_a, qs_a, corners, radius, begin_b, xs_b, normal):
    """Gap of such a body and a half-space at time t [m], and its rate [m/s]."""
    height, q, rate = np.empty(2), np.empty(4), np.empty(4)
    over_plane(t, begin_a, xs_a, qs_a, begin_b, xs_b, normal, q, rate, height)
    f, df = np.empty(len(corners)), np.empty(len(corners))
    shadow(corners, matrix(q), angular_velocity(q, rate), normal, np.zeros(3), f, df)
    low = 0
    for i in range(1, len(corners)):
        if f[i] < f[low]:
            low = i
    return height[0] - radius + f[low], height[1] + df[low]
