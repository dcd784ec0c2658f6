"""Advancement of solids (meshes, boxes, capsules, spheres) that need not be convex; see `advancement`.

Every pair of cells is followed on its own, those far apart by the balls of their trees; cells along the directions
that may separate them.
"""

from __future__ import annotations

import math

import numpy as np

from reference_impl.advancement import CLEAR, EVALUATIONS, HIT, TIRED, difference, room, root, swing
from reference_impl.advancement_boxes import relative
from reference_impl.collide.cell_axes import (
    ALL_AXES,
    SHARP_AXES,
    axis_of_cells,
    between,
    place_cell,
    separation_along,
    separations_of_cells,
)
from reference_impl.collide.solids import halves
from reference_impl.kernels import angular_velocity, apply, cross, dot, kernel, matrix, norm


@kernel
def _follow(r, v, pa, da, pb, db, n, dn, radii, bound, tolerance, speed, mask, out):
    """Time in which no two vertices of two cells can meet along n [s]; writes gap and rate of those that limit it.

    Bit 3 i + j of `mask`: vertices i and j are not looked at.
    """
    base, drift = dot(n, r) - radii, dot(n, v) + dot(dn, r)
    least = np.inf
    out[0], out[1] = np.inf, 0.0
    for i in range(3):
        f, df = base + dot(n, pa[i]), drift + dot(n, da[i]) + dot(dn, pa[i])
        for j in range(3):
            if (mask >> (3 * i + j)) & 1:
                continue
            gap, rate = f - dot(n, pb[j]), df - dot(n, db[j]) - dot(dn, pb[j])
            s = root(room(gap, rate, tolerance, speed), rate, bound)
            if s < least:
                least = s
                out[0], out[1] = gap, rate
    return least


@kernel
def _held(r, v, pa, da, pb, db, n, dn, radii, reach, parting):
    """Mask of the vertices that touch along n and do not part."""
    base, drift = dot(n, r) - radii, dot(n, v) + dot(dn, r)
    mask = 0
    for i in range(3):
        for j in range(3):
            gap = base + dot(n, pa[i]) - dot(n, pb[j])
            rate = drift + dot(n, da[i]) + dot(dn, pa[i]) - dot(n, db[j]) - dot(dn, pb[j])
            if gap <= reach and rate <= parting:
                mask |= 1 << (3 * i + j)
    return mask


@kernel
def _balls(solid, i, rotation, w, centre, spin):
    arm = apply(rotation, solid.ball[i, :3])
    turn = cross(w, arm)
    for c in range(3):
        centre[c], spin[c] = arm[c], turn[c]
    return norm(arm)


@kernel
def _centre(p, d, centre, velocity):
    """Refer vertices of a cell and their velocities to the centre of the vertices, which is added to the last two.

    Returns the greatest distance of a vertex from it [m].
    """
    for k in range(3):
        for c in range(3):
            centre[c] += p[k, c] / 3.0
            velocity[c] += d[k, c] / 3.0
    size = 0.0
    for k in range(3):
        for c in range(3):
            p[k, c] -= centre[c]
            d[k, c] -= velocity[c]
        size = max(size, norm(p[k]))
    return size


@kernel
def _cells_clear(
    i, j, r, v, sa, ra, wa, bounds_a, sb, rb, wb, bounds_b, pull, window, tolerance, speed, reach, parting,
    learn, kept, out
):  # fmt: skip
    """Time in which cells i and j cannot meet [s], at most `window`; writes gap and rate of what limits it.

    `kept`: direction, its sign and the mask of a pair that contact forces hold, found with `learn`; direction -1
    for others.  Everything is referred to the centres of the cells' vertices, which keeps the bound low.
    """
    pa, da, pb, db = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    place_cell(sa, i, ra, wa, pa, da)
    place_cell(sb, j, rb, wb, pb, db)
    ca, cb, va, vb = np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3)
    size_a, size_b = _centre(pa, da, ca, va), _centre(pb, db, cb, vb)
    r, v = between(r, ca, cb), between(v, va, vb)
    pull += norm(ca) * (bounds_a[4] ** 2 + bounds_a[5]) + norm(cb) * (bounds_b[4] ** 2 + bounds_b[5])
    distance, pace, radii = norm(r), norm(v), sa.radius + sb.radius
    window = min(window, distance / pace if pace > 0.0 else np.inf)
    values, n, dn, limit = np.empty(ALL_AXES), np.empty(3), np.empty(3), np.empty(2)
    count = ALL_AXES if radii > 0.0 else SHARP_AXES
    best, mask = kept[0], kept[2]
    if best < 0:
        best = separations_of_cells(r, v, pa, da, wa, pb, db, wb, count, reach if learn else tolerance, values)
    longest, least = -1.0, values[best] - radii - tolerance
    out[0], out[1] = np.inf, 0.0
    for k in range(count):
        if k != best and (kept[0] >= 0 or values[k] - radii < min(0.5 * (values[best] - radii), least)):
            continue
        if not axis_of_cells(k, r, v, pa, da, wa, pb, db, wb, n, dn):
            continue
        sign = float(kept[1]) if kept[0] >= 0 else separation_along(r, pa, pb, n)[1]
        for c in range(3):
            n[c] *= sign
            dn[c] *= sign
        if learn and k == best and values[k] - radii <= reach:
            mask = _held(r, v, pa, da, pb, db, n, dn, radii, reach, parting)
            if mask:
                kept[0], kept[1], kept[2] = k, int(sign), mask
        turn = norm(dn)
        bound = swing(turn, distance, pace, pull, window)
        bound += size_a * ((turn + bounds_a[4]) ** 2 + bounds_a[5])
        bound += size_b * ((turn + bounds_b[4]) ** 2 + bounds_b[5])
        s = _follow(r, v, pa, da, pb, db, n, dn, radii, bound, tolerance, speed, mask, limit)
        s = min(s, window)
        if kept[0] == k or s > longest:
            longest = s
            out[0], out[1] = limit[0], limit[1]
        if kept[0] == k:
            break
    return longest


@kernel
def _keep(key, row, found, keys, kept):
    """Put `row` of a pair of cells among the `found` kept ones, so that `keys` rise."""
    at = found
    while at > 0 and keys[at - 1] > key:
        keys[at] = keys[at - 1]
        for c in range(3):
            kept[at, c] = kept[at - 1, c]
        at -= 1
    keys[at] = key
    for c in range(3):
        kept[at, c] = row[c]


@kernel
def _recall(key, keys, kept, row):
    """What is kept of a pair of cells into `row`; -1, 0, 0 if nothing is.  `keys` rise."""
    row[0], row[1], row[2] = -1, 0, 0
    low, high = 0, len(keys)
    while low < high:
        middle = (low + high) // 2
        if keys[middle] < key:
            low = middle + 1
        else:
            high = middle
    if low < len(keys) and keys[low] == key:
        row[0], row[1], row[2] = kept[low, 0], kept[low, 1], kept[low, 2]


@kernel
def _look(
    r, v, sa, ra, wa, bounds_a, sb, rb, wb, bounds_b, window, tolerance, speed, reach, parting, learn, keys, kept, out
):
    """Time in which no cells can meet [s], at most `window`; writes gap and rate of what limits it.

    With `learn` the pairs that contact forces hold are put into `keys` and `kept`, otherwise they are taken from
    there.  Returns that time and how many there are (more than there are rows: too few rows).
    """
    pull = difference(bounds_a, bounds_b)
    stack = np.empty((512, 2), dtype=np.int64)
    stack[0, 0] = stack[0, 1] = 0
    top, found = 1, 0
    least, limit, row = window, np.empty(2), np.empty(3, dtype=np.int64)
    ca, va, cb, vb = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    out[0], out[1] = np.inf, 0.0
    while top > 0:
        top -= 1
        i, j = stack[top, 0], stack[top, 1]
        arm_a, arm_b = _balls(sa, i, ra, wa, ca, va), _balls(sb, j, rb, wb, cb, vb)
        square = closing = 0.0
        for c in range(3):
            off = r[c] + ca[c] - cb[c]
            square += off * off
            closing += off * (v[c] + va[c] - vb[c])
        distance = math.sqrt(square)
        apart = distance - sa.ball[i, 3] - sb.ball[j, 3] - sa.radius - sb.radius
        ball = 0.0
        if apart > 0.0:
            k = pull + arm_a * (bounds_a[4] ** 2 + bounds_a[5]) + arm_b * (bounds_b[4] ** 2 + bounds_b[5])
            ball = root(apart, closing / distance, k)
            if ball >= least:
                continue
            if apart > 0.5 * (sa.ball[i, 3] + sb.ball[j, 3] + sa.radius + sb.radius):
                # far for their size: the balls are as good as what is in them
                least = ball
                out[0], out[1] = apart, closing / distance
                continue
        if sa.child[i, 0] < 0 and sb.child[j, 0] < 0:
            key = sa.child[i, 1] * len(sb.cells) + sb.child[j, 1]
            _recall(key, keys[:0] if learn else keys, kept, row)
            s = _cells_clear(
                sa.child[i, 1], sb.child[j, 1], r, v, sa, ra, wa, bounds_a, sb, rb, wb, bounds_b, pull, window,
                tolerance, speed, reach, parting, learn, row, limit,
            )  # fmt: skip
            if learn and row[0] >= 0:
                if found < len(keys):
                    _keep(key, row, found, keys, kept)
                found += 1
            if ball > s:
                s = ball
                limit[0], limit[1] = apart, closing / distance
            if s < least:
                least = s
                out[0], out[1] = limit[0], limit[1]
        else:
            top = halves(stack, top, i, j, sa.child, sa.ball, sb.child, sb.ball)
    return least, found


@kernel
def approach_solids(
    t, end, begin_a, xs_a, qs_a, sa, bounds_a, begin_b, xs_b, qs_b, sb, bounds_b,
    tolerance, speed, touching, reach, parting
):  # fmt: skip
    """Time until which two solids are clear of each other, or the time they hit.

    Parameters and result as in `approach_plane`.  With `touching` each pair of cells that touches at time t keeps
    the direction that separates it, and vertices are left out as there.
    """
    qa, ga, qb, gb = np.empty(4), np.empty(4), np.empty(4), np.empty(4)
    r, v, out = np.empty(3), np.empty(3), np.empty(2)
    rows = 256 if touching else 0
    keys, kept = np.empty(rows, dtype=np.int64), np.empty((rows, 3), dtype=np.int64)
    for count in range(1, EVALUATIONS + 1):
        relative(t, begin_a, xs_a, qs_a, begin_b, xs_b, qs_b, r, v, qa, ga, qb, gb)
        ra, rb, wa, wb = matrix(qa), matrix(qb), angular_velocity(qa, ga), angular_velocity(qb, gb)
        learn = touching and count == 1
        while True:
            s, found = _look(r, v, sa, ra, wa, bounds_a, sb, rb, wb, bounds_b, end - t, tolerance, speed, reach,
                             parting, learn, keys, kept, out)  # fmt: skip
            if found <= len(keys):
                break
            keys, kept = np.empty(found, dtype=np.int64), np.empty((found, 3), dtype=np.int64)
        if learn:
            keys, kept = keys[:found], kept[:found]
        if t + s >= end:
            return end, CLEAR, count
        if s >= 0.0 and out[0] <= tolerance and out[1] < -speed:
            return t + s, HIT, count
        t += max(s, 1e-16 * (1.0 + abs(t)))
    return t, TIRED, EVALUATIONS


@kernel
def gap_solids(t, begin_a, xs_a, qs_a, sa, begin_b, xs_b, qs_b, sb):
    """Least separation of two cells of the solids at time t [m], which is zero when they touch; its rate [m/s]."""
    qa, ga, qb, gb = np.empty(4), np.empty(4), np.empty(4), np.empty(4)
    r, v = np.empty(3), np.empty(3)
    relative(t, begin_a, xs_a, qs_a, begin_b, xs_b, qs_b, r, v, qa, ga, qb, gb)
    return separation(r, v, matrix(qa), angular_velocity(qa, ga), sa, matrix(qb), angular_velocity(qb, gb), sb)


@kernel
def _lowest(points, n, sign):
    """Number of the vertex that is lowest along `sign` n."""
    low = 0
    for k in range(1, 3):
        if sign * dot(n, points[k]) < sign * dot(n, points[low]):
            low = k
    return low


@kernel
def separation(r, v, ra, wa, sa, rb, wb, sb):
    """Least separation of two cells of solids whose centres are r apart [m], and its rate [m/s].

    Negative by as much as the nearest cells would have to move apart: the surfaces cross.
    """
    stack = np.empty((512, 2), dtype=np.int64)
    stack[0, 0] = stack[0, 1] = 0
    top, least, slope = 1, np.inf, 0.0
    pa, da, pb, db = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    ca, va, cb, vb = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    values, n, dn = np.empty(ALL_AXES), np.empty(3), np.empty(3)
    radii = sa.radius + sb.radius
    count = ALL_AXES if radii > 0.0 else SHARP_AXES
    while top > 0:
        top -= 1
        i, j = stack[top, 0], stack[top, 1]
        _balls(sa, i, ra, wa, ca, va)
        _balls(sb, j, rb, wb, cb, vb)
        if norm(between(r, ca, cb)) - sa.ball[i, 3] - sb.ball[j, 3] - radii >= least:
            continue
        if sa.child[i, 0] < 0 and sb.child[j, 0] < 0:
            place_cell(sa, sa.child[i, 1], ra, wa, pa, da)
            place_cell(sb, sb.child[j, 1], rb, wb, pb, db)
            best = separations_of_cells(r, v, pa, da, wa, pb, db, wb, count, 0.0, values)
            if values[best] - radii < least:
                least = values[best] - radii
                axis_of_cells(best, r, v, pa, da, wa, pb, db, wb, n, dn)
                sign = separation_along(r, pa, pb, n)[1]
                i = _lowest(pa, n, sign)
                j = _lowest(pb, n, -sign)
                slope = sign * (dot(n, between(v, da[i], db[j])) + dot(dn, between(r, pa[i], pb[j])))
        else:
            top = halves(stack, top, i, j, sa.child, sa.ball, sb.child, sb.ball)
    return least, slope
