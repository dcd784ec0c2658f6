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

from typing import NamedTuple

import numpy as np

from reference_impl.contact_solvers import SOLVERS

GOOD = 1e-10  # certificate a solver must reach before the next one is asked
RANK = 1e-12  # relative singular value below which contacts count as redundant
USABLE = 1e-6  # certificate below which an answer is refused
RESCUERS = ("dantzig", "nnls", "osqp", "lemke")  # asked in this order after the solver that was chosen


class Answer(NamedTuple):
    """Solution of a contact problem."""

    f: np.ndarray  # (m,) multipliers of the rows as given, >= 0
    x: np.ndarray  # (k,) the motion in scaled coordinates
    a: np.ndarray  # (m,) G x - d of the rows as given: what remains along each contact
    residual: float  # natural-map certificate, relative
    solver: str = ""  # whose answer it is; "" for the closed form of one contact, "guess" for the expected contacts


class NoSolution(Exception):
    """The contacts allow no motion at all (a body squeezed by others that move), or every solver failed."""


def residual(g: np.ndarray, c: np.ndarray, d: np.ndarray, f: np.ndarray) -> float:
    """How far f is from solving the problem: max |min(f, A f + b)| over max(|c|, |d|); rows of g of unit length."""
    a = g @ (c + g.T @ f) - d
    scale = max(float(np.sqrt(c @ c)), float(np.abs(d).max()), 1e-300)
    return float(np.abs(np.minimum(f, a)).max()) / scale


def solve(g: np.ndarray, c: np.ndarray, d: np.ndarray, solver: str = "auto", guess: np.ndarray | None = None) -> Answer:
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

    Raises
    ------
    NoSolution
        If no solver reaches a usable certificate.
    """
    length = np.sqrt(np.einsum("ij,ij->i", g, g))
    unit, least = g / length[:, None], d / length
    if len(d) == 1:
        f = np.maximum(least - unit @ c, 0.0)
        x = c + unit[0] * f[0]
        return Answer(f / length, x, np.zeros(1) if f[0] > 0.0 else (unit @ x - least) * length, 0.0)
    best, worth, whose = None, np.inf, "guess"
    if guess is not None:
        best = _held(unit, c, least, guess)
        worth = residual(unit, c, least, best[0])
    if worth > GOOD:
        start = None if best is None else np.maximum(best[0], 0.0)
        for name in (solver, *(s for s in RESCUERS if s != solver)):
            f = _asked(name, unit, c, least, start)
            if f is None:
                continue
            exact = _held(unit, c, least, f > 0.0)
            for candidate in (exact, (f, exact[1])):
                value = residual(unit, c, least, candidate[0])
                if value < worth:
                    best, worth, whose = candidate, value, name
            if worth <= GOOD:
                break
    if best is None or not worth <= USABLE:
        raise NoSolution(f"no solver solves the contact problem of {len(d)} contacts (best certificate {worth:.3g})")
    return Answer(best[0] / length, best[1], (unit @ best[1] - least) * length, worth, whose)


def _asked(name: str, g: np.ndarray, c: np.ndarray, d: np.ndarray, start: np.ndarray | None) -> np.ndarray | None:
    """What a solver answers; None if it gave up, raised, or returned anything but finite forces."""
    try:
        f = np.asarray(SOLVERS[name](g, c, d, start), dtype=np.float64)
    except (ArithmeticError, RuntimeError, ValueError):  # LinAlgError is a ValueError
        return None
    return np.maximum(f, 0.0) if f.shape == d.shape and np.isfinite(f).all() else None


def _held(g: np.ndarray, c: np.ndarray, d: np.ndarray, active: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Forces that hold the active rows at exactly d, and the motion under them; the smallest forces if not unique.

    With G = U S Vᵀ of the active rows, x = c + V (S⁻¹ Uᵀ d - Vᵀ c) and f = U S⁻¹ (S⁻¹ Uᵀ d - Vᵀ c): the
    motion is a projection, so that a held contact is held exactly whatever the masses.
    """
    f = np.zeros(len(d))
    if not active.any():
        return f, c
    u, s, vt = np.linalg.svd(g[active], full_matrices=False)
    rank = int((s > RANK * s[0]).sum())
    u, s, vt = u[:, :rank], s[:rank], vt[:rank]
    change = (u.T @ d[active]) / s - vt @ c
    f[active] = u @ (change / s)
    x = c + vt.T @ change
    # once more, for what the projection of a large c has left
    return f, x + vt.T @ ((u.T @ d[active]) / s - vt @ x)
