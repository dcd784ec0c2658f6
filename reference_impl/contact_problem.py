"""The contact problem, its solvers and its certificate.

Gauss's principle of least constraint: of all motions x that the contacts allow, the true one is
nearest to the motion c that would happen without them,

    minimise ½ |x - c|²   subject to   G x >= d,

in coordinates scaled by the square root of the mass matrix, G = J M^-1/2.  Its multipliers f are the
contact forces (or impulses): with A = G Gᵀ and b = G c - d

    x = c + Gᵀ f,    f >= 0,    a = A f + b >= 0,    f·a = 0,

Baraff's linear complementarity problem (Fast contact force computation for nonpenetrating rigid
bodies, SIGGRAPH 1994).  The factor form is solved and never A itself: that would square the condition
number, and a heavy body on light ones would be lost.  Rows of G are brought to unit length.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

GOOD = 1e-10  # certificate a solver must reach before the next one is asked
RANGE = 1e-11  # relative distance at which d counts as reachable, d = G y
USABLE = 1e-6  # certificate below which an answer is refused


class Answer(NamedTuple):
    """Solution of a contact problem."""

    f: np.ndarray  # (m,) multipliers of the rows as given, >= 0
    x: np.ndarray  # (k,) the motion in scaled coordinates
    a: np.ndarray  # (m,) G x - d of the rows as given: what remains along each contact
    residual: float  # natural-map certificate, relative


class NoSolution(Exception):
    """The contacts allow no motion at all (a body squeezed by others that move), or every solver failed."""


def residual(g: np.ndarray, c: np.ndarray, d: np.ndarray, f: np.ndarray) -> float:
    """How far f is from solving the problem: max |min(f, A f + b)| over max(|c|, |d|); rows of g of unit length."""
    a = g @ (c + g.T @ f) - d
    scale = max(float(np.sqrt(c @ c)), float(np.abs(d).max()), 1e-300)
    return float(np.abs(np.minimum(f, a)).max()) / scale


def solve(g: np.ndarray, c: np.ndarray, d: np.ndarray, solver: str = "nnls", guess: np.ndarray | None = None) -> Answer:
    """Solution of the contact problem with its certificate.

    Parameters
    ----------
    g : (m, k) array
        Scaled contact rows; none may be zero.
    c : (k,) array
        Scaled motion without contacts.
    d : (m,) array
        Least admissible value of each row.
    solver : str
        One of `SOLVERS`, asked first; the others follow if its certificate is not good.
    guess : (m,) array of bool, optional
        Contacts expected to push; tried before any solver.

    Raises
    ------
    NoSolution
        If no solver reaches a usable certificate.
    """
    length = np.sqrt(np.einsum("ij,ij->i", g, g))
    unit, least = g / length[:, None], d / length
    if len(d) == 1:
        best = np.maximum(least - unit @ c, 0.0)
        x = c + unit[0] * best[0]
        return Answer(best / length, x, np.zeros(1) if best[0] > 0.0 else unit @ x * length - d, 0.0)
    best, worth = np.zeros(len(d)), np.inf
    if guess is not None and guess.any():
        best = _refined(unit, c, least, guess)
        worth = residual(unit, c, least, best)
    if worth > GOOD:
        for name in (solver, *(s for s in SOLVERS if s != solver)):
            f = SOLVERS[name](unit, c, least)
            if not np.isfinite(f).all():
                continue
            for candidate in (f, _refined(unit, c, least, f > 0.0)):
                value = residual(unit, c, least, candidate)
                if value < worth:
                    best, worth = candidate, value
            if worth <= GOOD:
                break
    if not worth <= USABLE:
        raise NoSolution(f"no solver solves the contact problem of {len(d)} contacts (best certificate {worth:.3g})")
    x = c + unit.T @ best
    x = _projected(unit, least, best > 0.0, x)
    return Answer(best / length, x, (unit @ x - least) * length, worth)


def _refined(g: np.ndarray, c: np.ndarray, d: np.ndarray, active: np.ndarray) -> np.ndarray:
    """Forces that hold the active rows at exactly d, the others zero; the smallest such forces if they are not unique."""
    f = np.zeros(len(d))
    if active.any():
        rows = g[active]
        if d[active].any():
            c = c - np.linalg.lstsq(rows, d[active], rcond=1e-12)[0]
        f[active] = np.linalg.lstsq(rows.T, -c, rcond=1e-12)[0]
    return f


def _projected(g: np.ndarray, d: np.ndarray, active: np.ndarray, x: np.ndarray) -> np.ndarray:
    """The motion with the rounding of the active rows taken out, so that a held contact is held exactly."""
    if not active.any():
        return x
    rows = g[active]
    return x - np.linalg.lstsq(rows, rows @ x - d[active], rcond=1e-12)[0]


def nnls(g: np.ndarray, c: np.ndarray, d: np.ndarray) -> np.ndarray:
    """Non-negative least squares in the factor form (Lawson and Hanson, Solving Least Squares Problems, 1974).

    With d = G y for some y the problem is min |Gᵀ f + (c - y)| over f >= 0; otherwise it is their
    least-distance problem, one row larger.
    """
    from scipy.optimize import nnls as lawson_hanson

    shifted = c
    if d.any():
        y = np.linalg.lstsq(g, d, rcond=1e-12)[0]
        if np.abs(g @ y - d).max() > RANGE * np.abs(d).max():
            return _least_distance(g, d - g @ c)
        shifted = c - y
    scale = float(np.sqrt(shifted @ shifted))
    if scale == 0.0:
        return np.zeros(len(d))
    try:
        return lawson_hanson(g.T, -shifted / scale)[0] * scale
    except RuntimeError:  # its iteration limit
        return np.full(len(d), np.nan)


def _least_distance(g: np.ndarray, h: np.ndarray) -> np.ndarray:
    """Multipliers of min ½|y|² subject to G y >= h; NaN where no y exists."""
    from scipy.optimize import nnls as lawson_hanson

    scale = float(np.abs(h).max())
    if scale == 0.0 or not (h > 0.0).any():
        return np.zeros(len(h))
    target = np.zeros(g.shape[1] + 1)
    target[-1] = 1.0
    try:
        u = lawson_hanson(np.vstack([g.T, h / scale]), target)[0]
    except RuntimeError:
        return np.full(len(h), np.nan)
    rest = 1.0 - float(h @ u) / scale
    return scale * u / rest if rest > 1e-14 else np.full(len(h), np.nan)


def osqp(g: np.ndarray, c: np.ndarray, d: np.ndarray) -> np.ndarray:
    """OSQP on the Gauss form, polished (Stellato et al., OSQP: an operator splitting solver, 2020)."""
    import osqp as package
    from scipy import sparse

    scale = max(float(np.sqrt(c @ c)), float(np.abs(d).max()))
    if (g @ c >= d).all():  # nothing pushes; OSQP would print that there is nothing to polish
        return np.zeros(len(d))
    problem = package.OSQP()
    problem.setup(
        P=sparse.eye(len(c), format="csc"), q=-c / scale, A=sparse.csc_matrix(g), l=d / scale,
        u=np.full(len(d), np.inf), eps_abs=1e-9, eps_rel=1e-9, polishing=True, max_iter=20000, verbose=False,
    )  # fmt: skip
    dual = problem.solve(raise_error=False).y
    return np.full(len(d), np.nan) if dual is None else np.maximum(-dual, 0.0) * scale


def dantzig(g: np.ndarray, c: np.ndarray, d: np.ndarray) -> np.ndarray:
    """Baraff's pivoting: contacts are admitted one by one and their force raised until nothing pulls in.

    At every moment the contacts admitted so far solve their own problem: those in `held` have a = 0,
    those in `free` have f = 0 (Baraff 1994, section 4, frictionless).  Columns of A are formed as they
    are needed; the directions come from least squares on the rows of G, so that redundant contacts do no harm.
    """
    m = len(d)
    f = np.zeros(m)
    held: list[int] = []
    free: list[int] = []
    a = g @ c - d
    tiny = 1e-14 * max(float(np.sqrt(c @ c)), float(np.abs(d).max()), 1e-300)
    for new in range(m):
        for _ in range(20 * m + 20):
            if a[new] >= -tiny:
                break
            step = np.zeros(m)
            step[new] = 1.0
            if held:
                step[held] = -np.linalg.lstsq(g[held].T, g[new], rcond=1e-12)[0]
            gain = g @ (g.T @ step)
            reach, event = (-a[new] / gain[new], new) if gain[new] > 1e-13 else (np.inf, -1)
            for i in held:
                if step[i] < -1e-14 and -f[i] / step[i] < reach:
                    reach, event = max(-f[i] / step[i], 0.0), i
            for i in free:
                if gain[i] < -1e-14 and -a[i] / gain[i] < reach:
                    reach, event = max(-a[i] / gain[i], 0.0), i
            if event < 0:
                return np.full(m, np.nan)
            f += reach * step
            a = a + reach * gain
            if event == new:
                break
            if event in held:
                held.remove(event)
                free.append(event)
                f[event] = 0.0
            else:
                free.remove(event)
                held.append(event)
                a[event] = 0.0
        else:
            return np.full(m, np.nan)
        (held if f[new] > 0.0 else free).append(new)
    return np.maximum(f, 0.0)


SOLVERS: dict[str, Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]] = {
    "nnls": nnls,
    "dantzig": dantzig,
    "osqp": osqp,
}
