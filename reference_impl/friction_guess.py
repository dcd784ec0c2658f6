"""The answer to a contact problem whose states are known, certified: what nearly every evaluation of a step takes."""

from __future__ import annotations

import math

from reference_impl.friction_cone import HOLDS, OFF, SLIPS, rate
from reference_impl.friction_hold import hold
from reference_impl.kernels import kernel

CLOSED = 1e-9  # relative motion along the normal up to which a contact stays closed
FULL = 1e-9  # part of the friction that a contact may lack to slip


@kernel
def guessed(g, c, d, mu, slides, states, way, unit, level, r, x, u):
    """Forces of contacts in these `states` as they would be right, and their certificate; inf if there are none.

    Parameters
    ----------
    g, c, d, mu, slides : arrays
        Of a `friction_problem.Rough`; g and d as given.
    states : (m,) array of int
        OFF, HOLDS or SLIPS; becomes what the answer says.
    way : (m, 2) array
        Directions of slip in the tangents.
    unit, level : arrays
        Room for g and d with normal rows of unit length.
    r, x, u : (3 m,), (k,), (3 m,) arrays
        Become forces, motion and relative motion, r and u of the rows as given.
    """
    m, k = len(mu), g.shape[1]
    scale = _scaled(g, c, d, unit, level)
    for j in range(k):
        x[j] = c[j]
    r[:] = 0.0
    if not hold(unit, c, level, mu, states, way, r, x):
        return math.inf
    # the certificate is that of the forces, the motion is the one that holds exactly
    moved = c.copy()
    for e in range(3 * m):
        if r[e] != 0.0:
            for j in range(k):
                moved[j] += unit[e, j] * r[e]
    for e in range(3 * m):
        u[e] = -level[e]
        for j in range(k):
            u[e] += unit[e, j] * moved[j]
    worst = rate(u, r, mu, slides, False) / scale
    if not math.isfinite(worst):
        return math.inf
    for i in range(m):
        for e in range(3 * i, 3 * i + 3):
            u[e] = -level[e]
            for j in range(k):
                u[e] += unit[e, j] * x[j]
        slip = math.sqrt(u[3 * i + 1] ** 2 + u[3 * i + 2] ** 2)
        pull = math.sqrt(r[3 * i + 1] ** 2 + r[3 * i + 2] ** 2)
        states[i] = OFF
        if r[3 * i] > 0.0 or u[3 * i] <= CLOSED * scale:
            full = pull >= (1.0 - FULL) * mu[i] * r[3 * i] and slip > CLOSED * scale
            states[i] = SLIPS if slides[i] or full else HOLDS
        length = _length(g[3 * i])
        for e in range(3 * i, 3 * i + 3):
            r[e] /= length
            u[e] *= length
    return worst


@kernel
def _length(row):
    """Euclidean norm."""
    square = 0.0
    for j in range(len(row)):
        square += row[j] * row[j]
    return math.sqrt(square)


@kernel
def _scaled(g, c, d, unit, level):
    """The rows g and d with normal rows of unit length, into `unit` and `level`; returns the size of the motion."""
    scale = 1e-300
    for i in range(len(g) // 3):
        length = _length(g[3 * i])
        for e in range(3 * i, 3 * i + 3):
            level[e] = d[e] / length
            scale = max(scale, abs(level[e]))
            for j in range(g.shape[1]):
                unit[e, j] = g[e, j] / length
    return max(scale, _length(c))
