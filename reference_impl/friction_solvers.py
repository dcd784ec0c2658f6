"""Solvers of the contact problem with friction that need no good start: sweeps, alternating directions, pivots.

`friction_problem` tells what the problem is, chooses among these and `friction_newton`, and certifies what they
return.  Here normal rows have unit length, forces are (3 m,) arrays (normal, tangent, tangent of each contact),
and NaN says that a solver gave up.  Every loop has a budget.
"""

from __future__ import annotations

import numpy as np

from reference_impl.friction_cone import project, single, single_convex
from reference_impl.kernels import kernel
from reference_impl.pseudo_inverse import turned_times

PIVOTS = 60  # per unknown, of Lemke's method
RELAXATIONS = 3_000


@kernel
def sweep(g, c, d, mu, slides, convex, r, sweeps):
    """Non-smooth Gauss-Seidel on `r`, in place: each contact in turn solved exactly for the others as they are.

    Jourdan, Alart and Jean, A Gauss-Seidel like algorithm to solve frictional contact problems (1998).
    """
    m, k = len(mu), g.shape[1]
    x = np.empty(k)
    turned_times(g, r, x)
    x += c
    w = np.zeros((m, 3, 3))
    for i in range(m):
        for a in range(3):
            for b in range(3):
                for j in range(k):
                    w[i, a, b] += g[3 * i + a, j] * g[3 * i + b, j]
    q, out = np.empty(3), np.empty(3)
    for _ in range(sweeps):
        change, size = 0.0, 0.0
        for i in range(m):
            for a in range(3):
                q[a] = -d[3 * i + a]
                for j in range(k):
                    q[a] += g[3 * i + a, j] * x[j]
            if slides[i]:
                gain = w[i, 0, 0] - mu[i] * w[i, 0, 1]
                if gain <= 0.0:
                    r[:] = np.nan
                    return
                out[0] = max(r[3 * i] - q[0] / gain, 0.0)
                out[1], out[2] = -mu[i] * out[0], 0.0
            else:
                for a in range(3):
                    for b in range(3):
                        q[a] -= w[i, a, b] * r[3 * i + b]
                if convex:
                    out[:] = r[3 * i : 3 * i + 3]
                    single_convex(w[i], q, mu[i], out)
                else:
                    single(w[i], q, mu[i], out)
            for a in range(3):
                step = out[a] - r[3 * i + a]
                r[3 * i + a] = out[a]
                change, size = max(change, abs(step)), max(size, abs(out[a]))
                for j in range(k):
                    x[j] += g[3 * i + a, j] * step
        if change <= 1e-16 * size:
            return


def relax(
    g: np.ndarray, c: np.ndarray, d: np.ndarray, mu: np.ndarray, slides: np.ndarray, convex: bool, start: np.ndarray,
    weight: float,
) -> np.ndarray:  # fmt: skip
    """Alternating directions: a linear problem for all contacts at once against projections of each alone.

    ADMM on min ½ |c + Gᵀ r|² over the cones with the term µ |u_T| n taken from the last iterate (Acary and
    Cadoux, 2013; Cadoux' fixed point inside the loop).  Slow, but it does not mind redundant contacts.
    """
    if slides.any():
        return np.full(len(d), np.nan)
    w = g @ g.T
    free = g @ c - d
    rho = weight * float(np.trace(w)) / len(w)
    inverse = np.linalg.inv(w + rho * np.eye(len(w)))
    z, dual = start.copy(), np.zeros(len(d))
    for _ in range(RELAXATIONS):
        u = (w @ z + free).reshape(-1, 3)
        shift = np.zeros((len(mu), 3))
        if not convex:
            shift[:, 0] = mu * np.sqrt(u[:, 1] ** 2 + u[:, 2] ** 2)
        r = inverse @ (rho * (z - dual) - free - shift.ravel())
        new = np.array([project(*y, k) for y, k in zip((r + dual).reshape(-1, 3), mu, strict=True)]).ravel()
        dual += r - new
        done = float(np.abs(new - z).max()) <= 1e-15 * float(np.abs(new).max()) and float(np.abs(r - new).max()) <= (
            1e-14 * float(np.abs(new).max())
        )
        z = new
        if done:
            break
    return z


def pivot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """z >= 0 with a z + b >= 0 and z·(a z + b) = 0 by Lemke's complementary pivoting; a need not be symmetric.

    Cottle, Pang and Stone, The Linear Complementarity Problem (1992), section 4.4.
    """
    m = len(b)
    scale = float(np.abs(b).max()) if m else 0.0
    if (b >= 0.0).all():
        return np.zeros(m)
    table = np.hstack([np.eye(m), -a, -np.ones((m, 1)), (b / scale)[:, None]])
    basis = np.arange(m)
    entering, row = 2 * m, int(np.argmin(b))
    for _ in range(PIVOTS * m + PIVOTS):
        leaving = int(basis[row])
        table[row] /= table[row, entering]
        others = np.arange(m) != row
        table[others] -= np.outer(table[others, entering], table[row])
        basis[row] = entering
        if leaving == 2 * m:
            z = np.zeros(2 * m)
            z[basis[basis < 2 * m]] = table[basis < 2 * m, -1]
            return np.maximum(z[m:], 0.0) * scale
        entering = leaving + m if leaving < m else leaving - m
        candidates = np.flatnonzero(table[:, entering] > 1e-12)
        if len(candidates) == 0:
            break
        ratios = table[candidates, -1] / table[candidates, entering]
        least = candidates[ratios <= ratios.min() + 1e-13]
        ending = least[basis[least] == 2 * m]
        row = int(ending[0] if len(ending) else least[0])
    return np.full(m, np.nan)
