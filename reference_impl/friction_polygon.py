"""Friction within a regular polygon in place of Coulomb's circle (Stewart and Trinkle, 1996).

The friction f_T of a contact with normal force f lies in µ f P, where P is the polygon with its corners at the angles
2πk/N from the first tangent, and of all forces in there it takes the most power from the slip.  So it does not
depend on the direction of slip as long as this stays nearest to one corner, and it is not opposite to it:

    nearest to corner k     f_T = -µ f e_k: slip along e_k is braked by µ f, slip across it not at all
    midway between two      anywhere on the side between them

Slip across is left as it is while slip along decreases, so that every slip turns away from the corners until it is
midway between two.  There it stays, held by the part of the friction along the side, and is braked by
µ f cos(π/N) only: the least a polygon can do, too little by (π/N)²/2.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from reference_impl.friction_cone import OFF, SLIPS
from reference_impl.friction_solvers import pivot, sweep
from reference_impl.kernels import kernel

if TYPE_CHECKING:
    from reference_impl.friction_problem import Rough

RANK = 1e-12  # relative singular value below which contacts count as redundant
GOOD = 1e-12  # certificate at which the search ends
ITERATIONS = 40  # of Newton's method
SWEEPS = 300  # with the circle, for another start


def faces(slip: np.ndarray, sides: int, slow: float) -> tuple[np.ndarray, np.ndarray]:
    """To which part of the polygon slip (m, 2) in the polygon's tangents belongs.

    Returns
    -------
    turn : (m,) array
        Angle of the nearest corner, or of the middle between two from which the slip is no more than `slow` away [rad].
    between : (m,) array of bool
        Whether it is such a middle.
    """
    sector = 2.0 * math.pi / sides
    angle, speed = np.arctan2(slip[:, 1], slip[:, 0]), np.hypot(slip[:, 0], slip[:, 1])
    corner = np.round(angle / sector)
    off = angle - corner * sector
    between = speed * np.sin(0.5 * sector - np.abs(off)) <= slow
    return sector * (corner + np.where(between, np.copysign(0.5, off), 0.0)), between


def within(slip: np.ndarray, between: np.ndarray, sides: int) -> np.ndarray:
    """How far slip (m, 2), along and across the direction of its face, is from the next face [m/s]; negative beyond."""
    half = math.pi / sides
    return np.where(between, slip[:, 0], slip[:, 0] * math.sin(half) - np.abs(slip[:, 1]) * math.cos(half))


@kernel
def nearest(radius, a, b, sides):
    """Nearest point to (a, b) in the regular polygon whose corners have this radius, the first on the first axis.

    Returns
    -------
    x, y : float
        The point.
    reach, c, s : float
        How far it is along its side from the middle, limited to ±1, and the direction to that middle; reach is NaN
        where (a, b) itself is within.
    """
    half = math.pi / sides
    # the side before it is between the corners at ±half from its middle
    middle = (math.floor(math.atan2(b, a) / (2.0 * half)) + 0.5) * 2.0 * half
    c, s = math.cos(middle), math.sin(middle)
    along, deep, wide = b * c - a * s, radius * math.cos(half), radius * math.sin(half)
    if a * c + b * s <= deep:
        return a, b, math.nan, c, s
    reach = min(max(along / wide, -1.0), 1.0) if wide > 0.0 else math.copysign(1.0, along)
    return deep * c - reach * wide * s, deep * s + reach * wide * c, reach, c, s


@kernel
def rate(u, r, mu, slides, across, sides):
    """Greatest component of the natural map of the law at r, as `friction_cone.rate`."""
    worst = 0.0
    for i in range(len(mu)):
        n, a, b = r[3 * i], r[3 * i + 1], r[3 * i + 2]
        worst = max(worst, abs(min(n, u[3 * i])))
        top = max(n, 0.0)
        if slides[i]:
            p = -mu[i] * top
            q = min(max(b - u[3 * i + 2], -across[i] * top), across[i] * top)
        else:
            p, q, _, _, _ = nearest(mu[i] * top, a - u[3 * i + 1], b - u[3 * i + 2], sides)
        worst = max(worst, abs(a - p), abs(b - q))
    return worst


def solve(p: Rough, across: np.ndarray, sides: int, guess: np.ndarray | None) -> tuple[np.ndarray, float, str]:
    """Forces (3 m,), their certificate before it is made relative, and whose they are; NaN where there are none.

    Parameters
    ----------
    p : Rough
        With normal rows of unit length.
    across : (m,) array
        Coefficient of the friction across the direction of contacts that slide.
    guess : (m,) array of int, optional
        As in `friction_problem.solve`, or `facets`.
    """
    scale = max(float(np.sqrt(p.c @ p.c)), float(np.abs(p.d).max()), 1e-300)

    def worth(r: np.ndarray) -> float:
        if not np.isfinite(r).all():
            return math.inf
        return rate(p.g @ (p.c + p.g.T @ r) - p.d, r, p.mu, p.slides, across, sides)

    if guess is not None:
        r = _held(p, across, guess, sides)
        if (value := worth(r)) <= GOOD * scale:
            return r, value, "guess"
    best, least, whose = np.full(len(p.d), math.nan), math.inf, "none"
    circle = np.zeros(len(p.d))
    for name in ("pivots", "newton", "newton from the circle"):
        if name == "pivots":
            r = _pivoted(p, across, sides)
        elif name == "newton":
            r = _newton(p, across, sides, best if whose != "none" else np.zeros(len(p.d)))
        else:
            sweep(p.g, p.c, p.d, p.mu, p.slides, False, circle, SWEEPS)
            r = _newton(p, across, sides, circle)
        if (value := worth(r)) < least:
            best, least, whose = r, value, name
        if least <= GOOD * scale:
            break
    return best, least, whose


def facets(slides: np.ndarray, slip: np.ndarray, states: np.ndarray, sides: int, slow: float) -> np.ndarray:
    """States of contacts (m,) with those that begin to slide told apart: SLIPS + 1 + j where friction is at facet j.

    Facet 2k is corner k, facet 2k + 1 the side that follows it: that which `slip` (m, 2) leaves behind, a side where
    it is no more than `slow` from its normal.  Contacts that slide already remain what they are.
    """
    turn, _ = faces(-slip, sides, slow)
    facet = np.round(turn * sides / math.pi).astype(np.int64) % (2 * sides)
    return np.where((states == SLIPS) & ~slides, SLIPS + 1 + facet, states)


def _held(p: Rough, across: np.ndarray, states: np.ndarray, sides: int) -> np.ndarray:
    """The smallest forces with which contacts that push stay closed, and hold or slide as their states say."""
    rows, columns = [], []
    unit = np.eye(len(p.d))
    for i in np.flatnonzero(states != OFF):
        n, a, b = unit[3 * i : 3 * i + 3]
        if p.slides[i]:
            free = (n, b) if across[i] > 0.0 else (n,)
            rows += free
            columns += (n - p.mu[i] * a, *free[1:])
        elif states[i] <= SLIPS:
            rows += (n, a, b)
            columns += (n, a, b)
        else:
            facet = int(states[i]) - SLIPS - 1
            angle = facet * math.pi / sides
            c, s = math.cos(angle), math.sin(angle)
            side = (c * b - s * a,) if facet % 2 else ()
            reach = math.cos(math.pi / sides) if side else 1.0
            rows += (n, *side)
            columns += (n + p.mu[i] * reach * (c * a + s * b), *side)
    r = np.zeros(len(p.d))
    if not rows:
        return r
    row, column = np.array(rows) @ p.g, np.array(columns)
    least = np.array(rows) @ p.d
    inverse = np.linalg.pinv(row @ (column @ p.g).T, rcond=RANK)
    for _ in range(3):
        r = r + column.T @ (inverse @ (least - row @ (p.c + p.g.T @ r)))
    return r


def _pivoted(p: Rough, across: np.ndarray, sides: int) -> np.ndarray:
    """Stewart and Trinkle's linear complementarity problem by pivots, refined on the unknowns that are not zero.

    Unknowns f (normal), b_j >= 0 along the corners of the polygon and s (slip speed):

        u_n >= 0,    s + e_j·u_T >= 0,    µ f - Σ b_j >= 0,    each complementary to its unknown.

    A contact that slides has friction -µ f along its first tangent already, and b_j along both ways of the other.
    """
    m, width = len(p.mu), p.g.shape[1]
    angle = 2.0 * math.pi * np.arange(sides) / sides
    corners = np.stack([np.zeros(sides), np.cos(angle), np.sin(angle)], axis=1)
    size = 2 + sides
    rows, columns, free = np.zeros((m * size, width)), np.zeros((m * size, width)), np.zeros(m * size)
    extra, parts = np.zeros((m * size, m * size)), np.zeros((m * size, 3))
    for i in range(m):
        at, end = i * size, (i + 1) * size
        ways, limit = corners, p.mu[i]
        if p.slides[i]:
            ways, limit = np.zeros((sides, 3)), across[i]
            if limit > 0.0:
                ways[0, 2], ways[1, 2] = 1.0, -1.0
        parts[at] = (1.0, -p.mu[i] if p.slides[i] else 0.0, 0.0)
        parts[at + 1 : end - 1] = ways
        own = p.g[3 * i : 3 * i + 3]
        columns[at:end] = parts[at:end] @ own
        rows[at], rows[at + 1 : end - 1] = own[0], columns[at + 1 : end - 1]
        free[at] = own[0] @ p.c - p.d[3 * i]
        free[at + 1 : end - 1] = ways @ (own @ p.c - p.d[3 * i : 3 * i + 3])
        idle = np.arange(at + 1, end - 1)[~ways.any(axis=1)]
        extra[idle, idle] = 1.0
        extra[at + 1 : end - 1, end - 1] = 1.0
        extra[end - 1, at], extra[end - 1, at + 1 : end - 1] = limit, -1.0
    matrix = rows @ columns.T + extra
    z = pivot(matrix, free)
    if not np.isfinite(z).all():
        return np.full(len(p.d), np.nan)
    some = z > 0.0
    if some.any():
        z[some] -= np.linalg.lstsq(matrix[np.ix_(some, some)], (matrix @ z + free)[some], rcond=RANK)[0]
    r = np.einsum("ij,ijk->ik", z.reshape(m, size), parts.reshape(m, size, 3))
    r[p.slides, 1] = -(p.mu * r[:, 0])[p.slides]
    return r.ravel()


def _newton(p: Rough, across: np.ndarray, sides: int, start: np.ndarray) -> np.ndarray:
    """Newton's method on the natural map, which is linear by pieces, with steps of least norm; the best iterate."""
    if not np.isfinite(start).all():
        return start
    w, free = p.g @ p.g.T, p.g @ p.c - p.d
    r = start
    best, least = start, math.inf
    for _ in range(ITERATIONS):
        value, jacobian = _linearised(r, w @ r + free, w, p, across, sides)
        size = float(np.abs(value).max())
        if not size < math.inf:
            break
        if size < least:
            best, least = r, size
        step = np.linalg.lstsq(jacobian, -value, rcond=RANK)[0]
        if float(np.abs(step).max()) <= 1e-16 * float(np.abs(r).max()):
            break
        r = r + step
    return best


def _linearised(
    r: np.ndarray, u: np.ndarray, w: np.ndarray, p: Rough, across: np.ndarray, sides: int
) -> tuple[np.ndarray, np.ndarray]:
    """Value and generalised Jacobian of r - P(r - u), with the radius of the polygon that of r_n - u_n."""
    m, half = len(p.mu), math.pi / sides
    one = np.eye(3 * m)
    back = one - w
    value, jacobian = r.copy(), one.copy()
    for i in range(m):
        n, a, b = slice(3 * i, 3 * i + 1), 3 * i + 1, 3 * i + 2
        top = max(float((r - u)[n][0]), 0.0)
        rise = back[n][0] if top > 0.0 else np.zeros(3 * m)
        value[n] -= top
        jacobian[n] -= rise
        if p.slides[i]:
            value[a] += p.mu[i] * r[3 * i]
            jacobian[a] += p.mu[i] * one[3 * i]
            pull = r[b] - u[b]
            inside = abs(pull) <= across[i] * top
            value[b] -= pull if inside else math.copysign(across[i] * top, pull)
            jacobian[b] -= back[b] if inside else math.copysign(across[i], pull) * rise
            continue
        x, y, reach, c, s = nearest(p.mu[i] * top, r[a] - u[a], r[b] - u[b], sides)
        value[a] -= x
        value[b] -= y
        if math.isnan(reach):
            jacobian[a] -= back[a]
            jacobian[b] -= back[b]
            continue
        if abs(reach) < 1.0:  # along the side the point follows, outwards the polygon leads it
            out, along = p.mu[i] * math.cos(half) * rise, c * back[b] - s * back[a]
        else:
            out, along = p.mu[i] * math.cos(half) * rise, p.mu[i] * reach * math.sin(half) * rise
        jacobian[a] -= c * out - s * along
        jacobian[b] -= s * out + c * along
    return value, jacobian
