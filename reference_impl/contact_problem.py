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

import math
from typing import NamedTuple

import numpy as np

from reference_impl.contact_solvers import SOLVERS

GOOD = 1e-10  # certificate a solver must reach before the next one is asked
FINE = 1e-12  # certificate of expected contacts; with a worse one those that should push creep into overlap
RANK = 1e-12  # relative singular value below which contacts count as redundant
ROUNDING = 1e-13  # what may be left of the rows that are held, relative to |c| or |d|
REFINEMENTS = 12  # with a kept factor; they end as soon as they gain less than a factor of two
DOUBTFUL = (1e-13, 1e-9)  # relative eigenvalues of A that are neither zero nor trustworthy
USABLE = 1e-6  # certificate below which an answer is refused
MOST = 200_000_000  # numbers in the tables of one problem, 1.6 GB
RESCUERS = ("dantzig", "nnls", "osqp", "lemke")  # asked in this order after the solver that was chosen


class Kept(NamedTuple):
    """What one answer leaves for the next one of contacts that have moved on a little."""

    f: np.ndarray  # (m,) multipliers of the rows of unit length
    inverse: np.ndarray  # (m, m) pseudo-inverse of A of the rows that push, zero for the others


class Answer(NamedTuple):
    """Solution of a contact problem."""

    f: np.ndarray  # (m,) multipliers of the rows as given, >= 0
    x: np.ndarray  # (k,) the motion in scaled coordinates
    a: np.ndarray  # (m,) G x - d of the rows as given: what remains along each contact
    residual: float  # natural-map certificate, relative
    solver: str = ""  # whose answer it is; "" for the closed form of one contact, "guess" for the expected contacts
    kept: Kept | None = None


class NoSolution(Exception):
    """The contacts allow no motion at all (a body squeezed by others that move), or every solver failed."""


def residual(g: np.ndarray, c: np.ndarray, d: np.ndarray, f: np.ndarray) -> float:
    """How far f is from solving the problem: max |min(f, A f + b)| over max(|c|, |d|); rows of g of unit length."""
    a = g @ (c + g.T @ f) - d
    scale = max(float(np.sqrt(c @ c)), float(np.abs(d).max()), 1e-300)
    return float(np.abs(np.minimum(f, a)).max()) / scale


def solve(
    g: np.ndarray,
    c: np.ndarray,
    d: np.ndarray,
    solver: str = "auto",
    guess: np.ndarray | None = None,
    kept: Kept | None = None,
) -> Answer:
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
        Contacts expected to push; tried before any solver, and accepted only with a good certificate.
    kept : Kept, optional
        From the answer to the same contacts a moment ago; its factor is tried before anything else.

    Raises
    ------
    NoSolution
        If no solver reaches a usable certificate, or the problem is too large for any.
    ValueError
        For a row of zeros: neither of its bodies can move.
    """
    if len(g) * (len(g) + g.shape[1]) > MOST:
        raise NoSolution(f"{len(g)} contacts in one problem; allowed: as many as make {MOST} numbers with the motions")
    length = np.sqrt(np.einsum("ij,ij->i", g, g))
    if not length.all():
        raise ValueError(f"contact row {int(np.argmin(length))} is zero: neither of its bodies can move")
    unit, least = g / length[:, None], d / length
    if len(d) == 1:
        f = np.maximum(least - unit @ c, 0.0)
        x = c + unit[0] * f[0]
        return Answer(f / length, x, np.zeros(1) if f[0] > 0.0 else (unit @ x - least) * length, 0.0)
    if kept is not None:
        f, x = kept.f.copy(), np.empty_like(c)
        worth = _refine(unit, c, least, kept.inverse, f, x)
        if worth <= FINE:
            return Answer(f / length, x, (unit @ x - least) * length, worth, "guess", Kept(f, kept.inverse))
    best, worth, whose, kept = None, np.inf, "guess", None
    if guess is not None:
        best, kept = _held(unit, c, least, guess)
        worth = residual(unit, c, least, best[0])
    if worth > FINE:
        best, worth, whose, kept = _sought(unit, c, least, solver, best, worth)
    if best is None or not worth <= USABLE:
        raise NoSolution(f"no solver solves the contact problem of {len(d)} contacts (best certificate {worth:.3g})")
    f, x = best
    return Answer(f / length, x, (unit @ x - least) * length, worth, whose, kept)


Motion = tuple[np.ndarray, np.ndarray]  # forces and the motion under them


def _sought(
    g: np.ndarray, c: np.ndarray, d: np.ndarray, solver: str, best: Motion | None, worth: float
) -> tuple[Motion | None, float, str, Kept | None]:
    """The best answer of the solvers, asked until a certificate is good, its certificate, and whose it is."""
    start, whose, kept = None if best is None else np.maximum(best[0], 0.0), "guess", None
    for name in (solver, *(s for s in RESCUERS if s != solver)):
        f = _asked(name, g, c, d, start)
        if f is None:
            continue
        exact, factor = _held(g, c, d, f > 0.0)
        for candidate in (exact, (f, exact[1])):
            value = residual(g, c, d, candidate[0])
            if value < worth:
                best, worth, whose = candidate, value, name
                # of redundant contacts the split that nowhere pulls, which need not be the smallest
                kept = None if factor is None else Kept(candidate[0], factor.inverse)
        if worth <= GOOD:
            break
    return best, worth, whose, kept


def _asked(name: str, g: np.ndarray, c: np.ndarray, d: np.ndarray, start: np.ndarray | None) -> np.ndarray | None:
    """What a solver answers; None if it gave up, raised, or returned anything but finite forces."""
    try:
        f = np.asarray(SOLVERS[name](g, c, d, start), dtype=np.float64)
    except Exception:  # whatever a library raises, it is no answer
        return None
    return np.maximum(f, 0.0) if f.shape == d.shape and np.isfinite(f).all() else None


def _held(g: np.ndarray, c: np.ndarray, d: np.ndarray, active: np.ndarray) -> tuple[Motion, Kept | None]:
    """Forces that hold the active rows at exactly d, and the motion under them; the smallest forces if not unique.

    And what to keep of it, unless the rows are so ill-conditioned that refining does not end: then, with
    G = U S Vᵀ of the active rows, x = c + V (S⁻¹ Uᵀ d - Vᵀ c) and f = U S⁻¹ (S⁻¹ Uᵀ d - Vᵀ c).  Either way the
    motion is a projection, so that a held contact is held exactly whatever the masses.
    """
    f, x = np.zeros(len(d)), c.copy()
    if not active.any():
        return (f, x), None
    inverse = _inverse(g, active)
    if _refine(g, c, d, inverse, f, x) < np.inf:
        return (f, x), Kept(f, inverse)
    f = np.zeros(len(d))
    u, s, vt = np.linalg.svd(g[active], full_matrices=False)
    rank = int((s > RANK * s[0]).sum())
    u, s, vt = u[:, :rank], s[:rank], vt[:rank]
    change = (u.T @ d[active]) / s - vt @ c
    f[active] = u @ (change / s)
    x = c + vt.T @ change
    # once more, for what the projection of a large c has left
    return (f, x + vt.T @ ((u.T @ d[active]) / s - vt @ x)), None


def _inverse(g: np.ndarray, active: np.ndarray) -> np.ndarray:
    """Pseudo-inverse (m, m) of A of the active rows, zero elsewhere.

    From the eigenvalues of A, unless some are lost in the square of the condition number: then from the factor G.
    It serves to refine, and what it lacks in digits costs another refinement.
    """
    out = np.zeros((len(g), len(g)))
    if not active.any():
        return out
    rows = g[active]
    values, vectors = np.linalg.eigh(rows @ rows.T)
    low, high = DOUBTFUL[0] * values[-1], DOUBTFUL[1] * values[-1]
    if ((values > low) & (values < high)).any():
        vectors, s, _ = np.linalg.svd(rows, full_matrices=False)
        values, high = s * s, (RANK * s[0]) ** 2
    good = values > high
    out[np.ix_(active, active)] = (vectors[:, good] / values[good]) @ vectors[:, good].T
    return out


def _refine(g: np.ndarray, c: np.ndarray, d: np.ndarray, inverse: np.ndarray, f: np.ndarray, x: np.ndarray) -> float:
    """Refine forces `f` until the rows known to `inverse` are held at exactly d; the certificate, inf if they are not.

    Every refinement works on what is left of the rows in the motion `x` itself, which is so held to rounding
    whatever the masses and whatever the inverse lacks.
    """
    known = inverse.diagonal() > 0.0
    x[:] = c + f @ g
    scale = max(math.sqrt(c @ c), float(np.abs(d).max()), 1e-300)
    last = math.inf
    for _ in range(REFINEMENTS):
        left = (d - g @ x) * known
        size = float(np.abs(left).max())
        if size > 0.5 * last or size == 0.0:
            last = min(size, last)
            break
        last = size
        step = inverse @ left
        f += step
        x += step @ g
    return residual(g, c, d, f) if last <= ROUNDING * scale else math.inf
