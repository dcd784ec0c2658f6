"""Forces of contacts whose states are known: linear algebra, with the most even split of the load."""

from __future__ import annotations

import numpy as np

from reference_impl.friction_cone import HOLDS, SLIPS
from reference_impl.kernels import kernel

RANK = 1e-12  # relative singular value below which contacts count as redundant
SPLITS = 30  # of the load between redundant contacts that are tried


@kernel
def hold(g, c, d, mu, modes, way, r, x):
    """Forces into `r` and motion into `x` (at first 0 and c) that hold what `modes` say at zero; False if none do.

    Of several splits of the load the smallest in the mean square, with no contact that slips pulling.  Where
    redundant contacts slide in different directions the motion depends on the split, so this one is a choice; it
    depends continuously on the state.
    """
    index = _held(modes)
    q, k = len(index), g.shape[1]
    if q == 0:
        return True
    rows, columns, least = np.empty((q, k)), np.empty((q, k)), np.empty(q)
    limited = np.zeros(q, dtype=np.bool_)
    some = False
    for e in range(q):
        at = index[e]
        i = at // 3
        least[e] = d[at]
        rows[e] = g[at]
        columns[e] = g[at]
        if modes[i] == SLIPS:
            limited[e] = some = True
            for j in range(k):
                columns[e, j] -= mu[i] * (way[i, 0] * g[at + 1, j] + way[i, 1] * g[at + 2, j])
    force = np.zeros(q)
    if not some:
        _hold_all(rows, least, force, x)
    elif not _hold_and_rub(rows, columns, least, limited, force, x):
        return False
    for e in range(q):
        at = index[e]
        i = at // 3
        r[at] = force[e]
        if modes[i] == SLIPS:
            r[at + 1], r[at + 2] = -mu[i] * force[e] * way[i, 0], -mu[i] * force[e] * way[i, 1]
    return True


@kernel
def _held(modes):
    """Rows of the problem that are held at zero: all three of a contact that holds, the normal of one that slips."""
    index = np.empty(3 * len(modes), dtype=np.int64)
    q = 0
    for i in range(len(modes)):
        for a in range(3):
            if modes[i] == HOLDS or (modes[i] == SLIPS and a == 0):
                index[q] = 3 * i + a
                q += 1
    return index[:q]


@kernel
def _hold_all(rows, least, force, x):
    """Add the forces of the least norm that bring rows·x to `least`, and what they do to the motion x."""
    u, s, vt = np.linalg.svd(rows, False)
    rank = 0
    for e in range(len(s)):
        rank += s[e] > RANK * s[0]
    u, s, vt = np.ascontiguousarray(u[:, :rank]), s[:rank], np.ascontiguousarray(vt[:rank])
    for _ in range(2):
        step = (u.T @ least) / s - vt @ x
        force += u @ (step / s)
        x += vt.T @ step


@kernel
def _hold_and_rub(rows, columns, least, limited, force, x):
    """As `_hold_all` where the force of row e acts along `columns[e]`, and is none that pulls if `limited[e]`.

    Returns False if no split of the load has been found.
    """
    q = len(least)
    matrix, chosen = rows @ columns.T, np.ones(q, dtype=np.bool_)
    lack = least - rows @ x
    for _ in range(SPLITS):
        inverse, regular = _pseudo_inverse(matrix, chosen)
        if regular:
            break
        # least norm: force = (matrixᵀ y)₊ on the limited ones
        pull = matrix.T @ (inverse.T @ (inverse @ lack))
        change = False
        size = np.abs(pull).max()
        for e in range(q):
            wanted = not limited[e] or pull[e] > -1e-14 * size
            if wanted != chosen[e]:
                chosen[e] = wanted
                change = True
        if not change:
            break
    else:
        return False
    for _ in range(3):
        step = inverse @ (least - rows @ x)
        force += step
        x += columns.T @ step
    return True


@kernel
def _pseudo_inverse(matrix, chosen):
    """Pseudo-inverse of the `chosen` columns of a square matrix, and whether these are regular."""
    q = len(chosen)
    part = matrix.copy()
    for e in range(q):
        if not chosen[e]:
            part[:, e] = 0.0
    u, s, vt = np.linalg.svd(part)
    regular = s[q - 1] > RANK * s[0]
    for e in range(q):
        s[e] = 1.0 / s[e] if s[e] > RANK * s[0] else 0.0
    return np.ascontiguousarray((vt.T * s) @ u.T), regular
