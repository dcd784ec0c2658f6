"""Box against box: separation along the fifteen axes, and the whole set of touching features.

Two boxes are apart exactly if one of 15 axes separates them: three face normals of each and nine
products of edges (Gottschalk, Lin and Manocha, OBBTree, 1996).  Along any unit vector the separation
is a lower bound of the distance, and the greatest of them is zero exactly when the boxes touch.

At a touch the contacts are: corners of one box on a face of the other, and edges that cross.  Special
positions are collapsed to these: an edge on a face gives its corners on the face and its crossings
with the face's border, two coplanar faces give the corners of their common polygon, parallel edges
give corners.  Nothing is listed twice.
"""

from __future__ import annotations

import math

import numpy as np

from reference_impl.collide.features import EDGES, FACE
from reference_impl.collide.primitives import corner, put
from reference_impl.kernels import apply, apply_transposed, dot, kernel

FACE_PREFERENCE = 1e-11  # [box size]: an edge axis must beat the face axes by more than rounding
PARALLEL = 1e-8  # sine of the angle below which two edges count as parallel


@kernel
def axis(k, ra, rb, r, out):
    """Unit vector number k of the 15, pointing from b to a (r = x_a - x_b); False if its edges are parallel.

    0-2: face normals of a, 3-5: of b, 6 + 3 i + j: edge i of a × edge j of b.
    """
    if k < 3:
        for c in range(3):
            out[c] = ra[c, k]
    elif k < 6:
        for c in range(3):
            out[c] = rb[c, k - 3]
    else:
        i, j = (k - 6) // 3, (k - 6) % 3
        out[0] = ra[1, i] * rb[2, j] - ra[2, i] * rb[1, j]
        out[1] = ra[2, i] * rb[0, j] - ra[0, i] * rb[2, j]
        out[2] = ra[0, i] * rb[1, j] - ra[1, i] * rb[0, j]
        size = math.sqrt(dot(out, out))
        if size < PARALLEL:
            return False
        for c in range(3):
            out[c] /= size
    if dot(out, r) < 0.0:
        for c in range(3):
            out[c] = -out[c]
    return True


@kernel
def extent(n, rotation, half):
    """Half the length of a box's shadow on the unit vector n [m]."""
    out = 0.0
    for c in range(3):
        out += half[c] * abs(n[0] * rotation[0, c] + n[1] * rotation[1, c] + n[2] * rotation[2, c])
    return out


@kernel
def separations(ra, half_a, rb, half_b, r, out):
    """Separation along each of the 15 axes [m] (negative: shadows overlap; -inf: no such axis); number of the best.

    A face axis wins over an edge axis that is better by rounding only.
    """
    n = np.empty(3)
    best = 0
    for k in range(15):
        out[k] = -np.inf
        if axis(k, ra, rb, r, n):
            out[k] = abs(dot(n, r)) - extent(n, ra, half_a) - extent(n, rb, half_b)
        lead = FACE_PREFERENCE * (half_a[0] + half_b[0]) if k == 6 else 0.0
        if k > 6 and best < 6:
            lead = FACE_PREFERENCE * (half_a[0] + half_b[0])
        if out[k] > out[best] + lead:
            best = k
    return best


@kernel
def box_box(a, b, xa, ra, half_a, xb, rb, half_b, reach, lateral, kinds, reals, count):
    """Contacts of boxes a and b whose gap is at most `reach`; returns their new count and the separation [m].

    A corner counts as on a face within `lateral` of its border, a crossing must lie `lateral` inside both edges.
    """
    r = xa - xb
    values = np.empty(15)
    best = separations(ra, half_a, rb, half_b, r, values)
    if values[best] > reach:
        return count, values[best]
    n = np.empty(3)
    axis(best, ra, rb, r, n)
    if best >= 6:
        return _edges(a, b, ra, half_a, rb, half_b, n, best, kinds, reals, count), values[best]
    if best < 3:  # the face belongs to a, which n leaves through its lower side
        for c in range(3):
            n[c] = -n[c]
        return _face(b, a, xb, rb, half_b, xa, ra, half_a, best, n, reach, lateral, kinds, reals, count), values[best]
    return _face(a, b, xa, ra, half_a, xb, rb, half_b, best - 3, n, reach, lateral, kinds, reals, count), values[best]


@kernel
def _edges(a, b, ra, half_a, rb, half_b, n, best, kinds, reals, count):
    """The edges with directions (i, j) of the axis that lie closest together."""
    i, j = (best - 6) // 3, (best - 6) % 3
    down, up = apply_transposed(ra, n), apply_transposed(rb, n)
    put(kinds, reals, count, a, b, EDGES, i, j)
    row = reals[count]
    for c in range(3):
        if c != i:
            row[c] = -half_a[c] if down[c] > 0.0 else half_a[c]
            kinds[count, 3] += (3 if row[c] > 0.0 else 0) * (1 + c)
        if c != j:
            row[6 + c] = half_b[c] if up[c] > 0.0 else -half_b[c]
            kinds[count, 4] += (3 if row[6 + c] > 0.0 else 0) * (1 + c)
    row[3 + i] = 1.0
    row[9 + j] = 1.0
    _orient(row, ra, rb, n)
    return count + 1


@kernel
def _orient(row, ra, rb, n):
    """Direct the edge of b so that the normal a × b of a crossing goes along n."""
    e, f = apply(ra, row[3:6]), apply(rb, row[9:12])
    volume = (e[1] * f[2] - e[2] * f[1]) * n[0] + (e[2] * f[0] - e[0] * f[2]) * n[1]
    volume += (e[0] * f[1] - e[1] * f[0]) * n[2]
    if volume < 0.0:
        for c in range(9, 12):
            row[c] = -row[c]


@kernel
def _face(a, b, xa, ra, half_a, xb, rb, half_b, k, n, reach, lateral, kinds, reals, count):
    """Contacts of box a with the face of box b whose outward normal is n, along axis k of b."""
    side = 1.0 if n[0] * rb[0, k] + n[1] * rb[1, k] + n[2] * rb[2, k] > 0.0 else -1.0
    u, w = (k + 1) % 3, (k + 2) % 3
    first = count
    # corners of a in the frame of b; those at the face are its support
    local = np.empty((8, 3))
    support = np.zeros(8, dtype=np.bool_)
    size = 0
    nearest, least = -1, np.inf
    place = np.empty(3)
    for j in range(8):
        corner(half_a, j, place)
        world = apply(ra, place)
        for c in range(3):
            world[c] += xa[c] - xb[c]
        inside = apply_transposed(rb, world)
        for c in range(3):
            local[j, c] = inside[c]
        if side * inside[k] - half_b[k] <= reach:
            support[j] = True
            size += 1
            out = max(abs(inside[u]) - half_b[u], abs(inside[w]) - half_b[w])
            if out < least:
                nearest, least = j, out
            if out <= lateral:
                count = _corner_on_face(a, b, half_a, j, half_b, k, side, kinds, reals, count)
    if size >= 2:
        count = _border(a, b, ra, half_a, rb, half_b, k, side, n, local, support, lateral, kinds, reals, count)
    if size >= 3:
        count = _corners_below(a, b, xa, ra, half_a, xb, rb, half_b, k, side, n, lateral, kinds, reals, count)
    if count == first and nearest >= 0 and least <= 1e-6 * (half_b[u] + half_b[w]):
        count = _corner_on_face(a, b, half_a, nearest, half_b, k, side, kinds, reals, count)
    return count


@kernel
def _corner_on_face(a, b, half_a, j, half_b, k, side, kinds, reals, count):
    put(kinds, reals, count, a, b, FACE, j, 2 * k + (1 if side > 0.0 else 0))
    corner(half_a, j, reals[count, 0:3])
    reals[count, 6 + k] = side * half_b[k]
    reals[count, 9 + k] = side
    return count + 1


@kernel
def _border(a, b, ra, half_a, rb, half_b, k, side, n, local, support, lateral, kinds, reals, count):
    """Edges of a that lie at the face of b and cross the face's border."""
    u, w = (k + 1) % 3, (k + 2) % 3
    for j in range(8):
        for c in range(3):
            m = j | (1 << c)
            if m == j or not (support[j] and support[m]):
                continue
            for d in range(2):  # borders at ± half along `across`, edges of b along `along`
                across = u if d == 0 else w
                along = w if d == 0 else u
                p, q = local[j], local[m]
                step = q[across] - p[across]
                length = math.sqrt((q[0] - p[0]) ** 2 + (q[1] - p[1]) ** 2 + (q[2] - p[2]) ** 2)
                if abs(step) <= PARALLEL * length:
                    continue
                for sign in range(2):
                    edge = half_b[across] if sign else -half_b[across]
                    part = (edge - p[across]) / step
                    at = p[along] + part * (q[along] - p[along])
                    within = min(part, 1.0 - part) * length
                    if within <= lateral or half_b[along] - abs(at) <= lateral:
                        continue
                    put(kinds, reals, count, a, b, EDGES, 3 * j + c, 9 * along + 3 * sign + k)
                    row = reals[count]
                    corner(half_a, j, row[0:3])
                    row[c] = 0.0
                    row[3 + c] = 1.0
                    row[6 + across] = edge
                    row[6 + k] = side * half_b[k]
                    row[9 + along] = 1.0
                    _orient(row, ra, rb, n)
                    count += 1
    return count


@kernel
def _corners_below(a, b, xa, ra, half_a, xb, rb, half_b, k, side, n, lateral, kinds, reals, count):
    """Corners of the face of b inside the face of a that lies on it, or on its border, but on no corner of a.

    A corner of b within half of `lateral` of a corner of a is left out: there the corner of a is listed.
    """
    face, most = 0, -1.0
    for c in range(3):
        along = abs(n[0] * ra[0, c] + n[1] * ra[1, c] + n[2] * ra[2, c])
        if along > most:
            face, most = c, along
    lower = -1.0 if n[0] * ra[0, face] + n[1] * ra[1, face] + n[2] * ra[2, face] > 0.0 else 1.0
    u, w = (face + 1) % 3, (face + 2) % 3
    place = np.empty(3)
    for j in range(8):
        corner(half_b, j, place)
        if place[k] * side < 0.0:
            continue
        world = apply(rb, place)
        for c in range(3):
            world[c] += xb[c] - xa[c]
        inside = apply_transposed(ra, world)
        room, space = half_a[u] - abs(inside[u]), half_a[w] - abs(inside[w])
        if min(room, space) < -lateral or max(abs(room), abs(space)) <= 0.5 * lateral:
            continue
        put(kinds, reals, count, b, a, FACE, j, 2 * face + (1 if lower > 0.0 else 0))
        corner(half_b, j, reals[count, 0:3])
        reals[count, 6 + face] = lower * half_a[face]
        reals[count, 9 + face] = lower
        count += 1
    return count
