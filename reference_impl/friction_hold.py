"""Forces of contacts whose states are known: linear algebra, with the most even split of the load."""

from __future__ import annotations

import numpy as np

from reference_impl.friction_cone import HOLDS, SLIPS
from reference_impl.kernels import kernel
from reference_impl.pseudo_inverse import pseudo_inverse, times, turned_times

RANK = 1e-12  # relative singular value below which contacts count as redundant
SPLITS = 30  # of the load between redundant contacts that are tried


@kernel
def hold(g, c, d, mu, modes, way, r, x):
    """Forces into `r` and motion into `x` (at first 0 and c) that hold what `modes` say at zero; False if none do.

    Of several splits of the load the smallest in the mean square, with no contact that slips pulling.  Where
    redundant contacts slide in different directions the motion depends on the split, so this one is a choice; it
    depends continuously on the state.
    """
    index = held_rows(modes)
    q, k = len(index), g.shape[1]
    if q == 0:
        return True
    rows, columns, least = np.empty((q, k)), np.empty((q, k)), np.empty(q)
    limited = np.zeros(q, dtype=np.bool_)
    for e in range(q):
        at = index[e]
        i = at // 3
        least[e] = d[at]
        rows[e] = g[at]
        columns[e] = g[at]
        if modes[i] == SLIPS:
            limited[e] = True
            for j in range(k):
                columns[e, j] -= mu[i] * (way[i, 0] * g[at + 1, j] + way[i, 1] * g[at + 2, j])
    force = np.zeros(q)
    held = share(rows, columns, least, limited, c, x, force) if limited.any() else spread(rows, least, x, force)
    if not held:
        return False
    for e in range(q):
        at = index[e]
        i = at // 3
        r[at] = force[e]
        if modes[i] == SLIPS:
            r[at + 1], r[at + 2] = -mu[i] * force[e] * way[i, 0], -mu[i] * force[e] * way[i, 1]
    return True


@kernel
def held_rows(modes):
    """Places of the relative motions that are held: all of a contact that holds, the normal one of one that slips."""
    index = np.empty(3 * len(modes), dtype=np.int64)
    q = 0
    for i in range(len(modes)):
        for a in range(3):
            if modes[i] == HOLDS or (modes[i] == SLIPS and a == 0):
                index[q] = 3 * i + a
                q += 1
    return index[:q]


@kernel
def spread(rows, least, x, force):
    """Add to `x` the motion that brings rows x to `least`, and to `force` the smallest forces that do it."""
    q, k = rows.shape
    inverse, short, step, push = np.empty((k, q)), np.empty(q), np.empty(k), np.empty(q)
    if pseudo_inverse(rows, RANK, inverse) < 0:
        return False
    for _ in range(2):
        lacking(rows, least, x, short)
        times(inverse, short, step)
        turned_times(inverse, step, push)
        for e in range(q):
            force[e] += push[e]
        for j in range(k):
            x[j] += step[j]
    return True


@kernel
def share(rows, columns, least, limited, c, x, force):
    """The same where forces act along `columns`, and where the `limited` ones may only push; False if none do."""
    q, k = rows.shape
    matrix, inverse, short, step = np.empty((q, q)), np.empty((q, q)), np.empty(q), np.empty(q)
    for e in range(q):
        for f in range(q):
            total = 0.0
            for j in range(k):
                total += rows[e, j] * columns[f, j]
            matrix[e, f] = total
    chosen = np.ones(q, dtype=np.bool_)
    if not split(matrix, rows, least, limited, c, chosen, inverse):
        return False
    change = np.empty(k)
    for _ in range(3):
        lacking(rows, least, x, short)
        times(inverse, short, step)
        turned_times(columns, step, change)
        for e in range(q):
            force[e] += step[e]
        for j in range(k):
            x[j] += change[j]
    return True


@kernel
def split(matrix, rows, least, limited, c, chosen, inverse):
    """Find which forces carry the load, into `chosen`, and what turns a lack into them; False if no choice stays.

    Least norm: force = (matrixᵀ y)₊ on the limited ones.
    """
    q = len(least)
    short, y, again, pull = np.empty(q), np.empty(q), np.empty(q), np.empty(q)
    for _ in range(SPLITS):
        part = matrix.copy()
        for e in range(q):
            if not chosen[e]:
                part[:, e] = 0.0
        rank = pseudo_inverse(part, RANK, inverse)
        if rank < 0:
            return False
        if rank == q:
            return True
        lacking(rows, least, c, short)
        times(inverse, short, again)
        turned_times(inverse, again, y)
        turned_times(matrix, y, pull)
        change = False
        size = np.abs(pull).max()
        for e in range(q):
            wanted = not limited[e] or pull[e] > -1e-14 * size
            if wanted != chosen[e]:
                chosen[e] = wanted
                change = True
        if not change:
            return True
    return False


@kernel
def lacking(rows, least, x, short):
    """`short` = least - rows x."""
    times(rows, x, short)
    for e in range(len(least)):
        short[e] = least[e] - short[e]
