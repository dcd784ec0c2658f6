"""Advancement of solids (meshes, boxes, capsules, spheres) that need not be convex; see `advancement`.

Every pair of cells is followed on its own, those far apart by the balls of their trees.  Two cells are
apart exactly if one of a few directions separates them: the normals of both, the products of their edges,
the normals of their edges in their own planes; and where radii keep the cells apart, the directions between
their vertices and from vertices to edges.
"""

from __future__ import annotations

import math

import numpy as np

from reference_impl.advancement import CLEAR, EVALUATIONS, HIT, TIRED, difference, room, root, swing
from reference_impl.advancement_boxes import relative
from reference_impl.collide.solids import halves
from reference_impl.kernels import along, angular_velocity, apply, cross, dot, kernel, matrix, minus, norm

SHARP_AXES, ALL_AXES = 17, 44
PARALLEL = 1e-8  # sine of the angle below which two edges have no product


@kernel
def _cell(solid, cell, rotation, w, arms, spins):
    """Vertices of a cell relative to its body's centre, and their velocities by its rotation."""
    for k in range(3):
        arm = apply(rotation, solid.points[solid.cells[cell, k]])
        spin = cross(w, arm)
        for c in range(3):
            arms[k, c], spins[k, c] = arm[c], spin[c]


@kernel
def _between(r, a, b):
    """r + a - b: from a point of b to one of a, whose bodies' centres are r apart."""
    out = np.empty(3)
    for c in range(3):
        out[c] = r[c] + a[c] - b[c]
    return out


@kernel
def _unit(m, dm, least, n, dn):
    """Unit vector along m and its rate; False if m is shorter than `least`."""
    size = norm(m)
    if size <= least:
        return False
    stretch = dot(m, dm) / (size * size)
    for c in range(3):
        n[c] = m[c] / size
        dn[c] = (dm[c] - stretch * m[c]) / size
    return True


@kernel
def _axis(k, r, v, pa, da, wa, pb, db, wb, n, dn):
    """Direction number k of two cells, and its rate as their features turn; False if there is none.

    0, 1: normals; 2-10: edge of a × edge of b; 11-13 and 14-16: normals of the edges in the planes of a and
    b; 17-25: vertex of a to edge of b; 26-34: edge of a to vertex of b; 35-43: vertex to vertex.
    """
    if k < 2 or 11 <= k < 17:
        p, w = (pa, wa) if k == 0 or 11 <= k < 14 else (pb, wb)
        m = cross(minus(p[1], p[0]), minus(p[2], p[0]))
        if k >= 11:
            i = (k - 11) % 3
            m = cross(m, minus(p[(i + 1) % 3], p[i]))
        return _unit(m, cross(w, m), 0.0, n, dn)
    if k < 11:
        i, j = (k - 2) // 3, (k - 2) % 3
        e, f = minus(pa[(i + 1) % 3], pa[i]), minus(pb[(j + 1) % 3], pb[j])
        rate = along(cross(cross(wa, e), f), 1.0, cross(e, cross(wb, f)))
        return _unit(cross(e, f), rate, PARALLEL * norm(e) * norm(f), n, dn)
    i, j = (k - 17) % 9 // 3, (k - 17) % 3
    m, dm = _between(r, pa[i], pb[j]), _between(v, da[i], db[j])
    if k < 35:
        e = minus(pb[(j + 1) % 3], pb[j]) if k < 26 else minus(pa[(i + 1) % 3], pa[i])
        size = norm(e)
        if size == 0.0:
            return False
        for c in range(3):
            e[c] /= size
        de = cross(wb if k < 26 else wa, e)
        s = dot(m, e)
        ds = dot(dm, e) + dot(m, de)
        return _unit(along(m, -s, e), along(along(dm, -ds, e), -s, de), 0.0, n, dn)
    return _unit(m, dm, 0.0, n, dn)


@kernel
def _separation(r, pa, pb, n):
    """Separation of two cells along n or -n, whichever is greater [m], and the sign of that direction."""
    low_a = high_a = dot(n, pa[0])
    low_b = high_b = dot(n, pb[0])
    for k in range(1, 3):
        f, g = dot(n, pa[k]), dot(n, pb[k])
        low_a, high_a, low_b, high_b = min(low_a, f), max(high_a, f), min(low_b, g), max(high_b, g)
    base = dot(n, r)
    forth, back = base + low_a - high_b, low_b - base - high_a
    return (forth, 1.0) if forth >= back else (back, -1.0)


@kernel
def _separations(r, v, pa, da, wa, pb, db, wb, count, lead, out):
    """Separation along the first `count` directions, -inf where there is none; number of the best.

    A normal wins over everything that is better by less than `lead`.
    """
    n, dn = np.empty(3), np.empty(3)
    best = 0
    for k in range(count):
        out[k] = -np.inf
        if _axis(k, r, v, pa, da, wa, pb, db, wb, n, dn):
            out[k] = _separation(r, pa, pb, n)[0]
        if out[k] > out[best] + (lead if k >= 2 and best < 2 else 0.0):
            best = k
    return best


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
def _cells_clear(
    i, j, r, v, sa, ra, wa, bounds_a, sb, rb, wb, bounds_b, pull, window, tolerance, speed, reach, parting,
    learn, kept, out
):  # fmt: skip
    """Time in which cells i and j cannot meet [s], at most `window`; writes gap and rate of what limits it.

    `kept`: direction, its sign and the mask of a pair that contact forces hold, found with `learn`; direction -1
    for others.  Everything is referred to the centres of the cells' vertices, which keeps the bound low.
    """
    pa, da, pb, db = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    _cell(sa, i, ra, wa, pa, da)
    _cell(sb, j, rb, wb, pb, db)
    ca, cb, va, vb = np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3)
    for k in range(3):
        for c in range(3):
            ca[c] += pa[k, c] / 3.0
            cb[c] += pb[k, c] / 3.0
            va[c] += da[k, c] / 3.0
            vb[c] += db[k, c] / 3.0
    size_a = size_b = 0.0
    for k in range(3):
        for c in range(3):
            pa[k, c] -= ca[c]
            pb[k, c] -= cb[c]
            da[k, c] -= va[c]
            db[k, c] -= vb[c]
        size_a, size_b = max(size_a, norm(pa[k])), max(size_b, norm(pb[k]))
    r, v = _between(r, ca, cb), _between(v, va, vb)
    pull += norm(ca) * (bounds_a[4] ** 2 + bounds_a[5]) + norm(cb) * (bounds_b[4] ** 2 + bounds_b[5])
    distance, pace, radii = norm(r), norm(v), sa.radius + sb.radius
    window = min(window, distance / pace if pace > 0.0 else np.inf)
    values, n, dn, limit = np.empty(ALL_AXES), np.empty(3), np.empty(3), np.empty(2)
    count = ALL_AXES if radii > 0.0 else SHARP_AXES
    best, mask = kept[0], kept[2]
    if best < 0:
        best = _separations(r, v, pa, da, wa, pb, db, wb, count, reach if learn else tolerance, values)
    longest, least = -1.0, values[best] - radii - tolerance
    out[0], out[1] = np.inf, 0.0
    for k in range(count):
        if k != best and (kept[0] >= 0 or values[k] - radii < min(0.5 * (values[best] - radii), least)):
            continue
        if not _axis(k, r, v, pa, da, wa, pb, db, wb, n, dn):
            continue
        sign = float(kept[1]) if kept[0] >= 0 else _separation(r, pa, pb, n)[1]
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
    while top > 0:
        top -= 1
        i, j = stack[top, 0], stack[top, 1]
        _balls(sa, i, ra, wa, ca, va)
        _balls(sb, j, rb, wb, cb, vb)
        if norm(_between(r, ca, cb)) - sa.ball[i, 3] - sb.ball[j, 3] - radii >= least:
            continue
        if sa.child[i, 0] < 0 and sb.child[j, 0] < 0:
            _cell(sa, sa.child[i, 1], ra, wa, pa, da)
            _cell(sb, sb.child[j, 1], rb, wb, pb, db)
            best = _separations(r, v, pa, da, wa, pb, db, wb, ALL_AXES if radii > 0.0 else SHARP_AXES, 0.0, values)
            if values[best] - radii < least:
                least = values[best] - radii
                _axis(best, r, v, pa, da, wa, pb, db, wb, n, dn)
                sign = _separation(r, pa, pb, n)[1]
                i = _lowest(pa, n, sign)
                j = _lowest(pb, n, -sign)
                slope = sign * (dot(n, _between(v, da[i], db[j])) + dot(dn, _between(r, pa[i], pb[j])))
        else:
            top = halves(stack, top, i, j, sa.child, sa.ball, sb.child, sb.ball)
    return least, slope
