"""Directions that may separate two cells of solids, how far apart the cells are along them, and how these turn.

Two cells are apart exactly if one of a few directions separates them: the normals of both, the products of their
edges, the normals of their edges in their own planes; and where radii keep the cells apart, the directions between
their vertices and from vertices to edges.
"""

from __future__ import annotations

import numpy as np

from reference_impl.kernels import along, apply, cross, dot, kernel, minus, norm

SHARP_AXES, ALL_AXES = 17, 44
PARALLEL = 1e-8  # sine of the angle below which two edges have no product


@kernel
def place_cell(solid, cell, rotation, w, arms, spins):
    """Vertices of a cell relative to its body's centre, and their velocities by its rotation."""
    for k in range(3):
        arm = apply(rotation, solid.points[solid.cells[cell, k]])
        spin = cross(w, arm)
        for c in range(3):
            arms[k, c], spins[k, c] = arm[c], spin[c]


@kernel
def between(r, a, b):
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
def axis_of_cells(k, r, v, pa, da, wa, pb, db, wb, n, dn):
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
    m, dm = between(r, pa[i], pb[j]), between(v, da[i], db[j])
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
def separation_along(r, pa, pb, n):
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
def separations_of_cells(r, v, pa, da, wa, pb, db, wb, count, lead, out):
    """Separation along the first `count` directions, -inf where there is none; number of the best.

    A normal wins over everything that is better by less than `lead`.
    """
    n, dn = np.empty(3), np.empty(3)
    best = 0
    for k in range(count):
        out[k] = -np.inf
        if axis_of_cells(k, r, v, pa, da, wa, pb, db, wb, n, dn):
            out[k] = separation_along(r, pa, pb, n)[0]
        if out[k] > out[best] + (lead if k >= 2 and best < 2 else 0.0):
            best = k
    return best
