"""The contact problem with Coulomb friction, its solvers and its certificate.

Contact i has a normal row and two tangent rows in G, scaled by the square root of the mass matrix, so that its
relative motion is u_i = G_i x - d_i for x = c + Gᵀ r.  Signorini's condition, Coulomb's law and the rule that
friction opposes the slip are together one complementarity of cones (de Saxcé and Feng, The bipotential method,
1998):

    r_i in K_i = {|r_T| <= µ_i r_n},    u_i + µ_i |u_T| n in K_i*,    r_i · (u_i + µ_i |u_T| n) = 0.

It serves impulses and velocities as well as forces and accelerations.  A contact that slides already has the
force f (n - µ s) along its slip direction s, and only its normal part is open.

Three models of the cone can be chosen:

    exact     the law above
    pyramid   the circle of friction replaced by a regular polygon, see `friction_polygon`: slip turns to its sides
    convex    without the term µ |u_T| n (Anitescu, 2006): what slides also lifts off, so it serves impacts only

No solver is believed: every answer carries the natural-map residual of its own model.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from reference_impl import friction_polygon
from reference_impl.contact_problem import NoSolution
from reference_impl.friction_cone import HOLDS, OFF, SLIPS, rate
from reference_impl.friction_guess import CLOSED, FULL, guessed
from reference_impl.friction_hold import hold
from reference_impl.friction_newton import newton
from reference_impl.friction_solvers import pivot, relax, sweep

GOOD = 1e-12  # certificate at which the search ends
USABLE = 1e-9  # certificate above which an answer is refused, unless a coarser one is asked for
QUICK = 300  # sweeps up to which solvers go on for a good certificate even if a coarser one is enough
SWEEPS = (30, 300, 3_000, 20_000)  # of non-smooth Gauss-Seidel, each followed by Newton's method
TURNS = 40  # of the directions of slip that follow from the most even split of the load, until they agree with it
MODELS = ("exact", "pyramid", "convex")


class Answer(NamedTuple):
    """Solution of a contact problem with friction."""

    r: np.ndarray  # (m, 3) force or impulse along normal and both tangents
    x: np.ndarray  # (k,) the motion in scaled coordinates
    u: np.ndarray  # (m, 3) relative motion of the contacts
    residual: float  # natural-map certificate, relative
    solver: str  # whose answer it is
    states: np.ndarray  # (m,) OFF, HOLDS or SLIPS, or above `friction_polygon.facets`; the guess a moment later


class Rough(NamedTuple):
    """A contact problem with friction; three rows per contact: normal and two tangents."""

    g: np.ndarray  # (3 m, k) scaled contact rows
    c: np.ndarray  # (k,) scaled motion without contacts
    d: np.ndarray  # (3 m,) values of the rows at which the relative motion is zero
    mu: np.ndarray  # (m,) coefficients of friction
    slides: np.ndarray  # (m,) bool: slides along its first tangent already
    # (m,) coefficient of the friction across that, where contacts slide midway between two corners of a polygon
    across: np.ndarray | None = None


def solve(
    problem: Rough, model: str = "exact", sides: int = 4, guess: np.ndarray | None = None, enough: float = GOOD
) -> Answer:
    """Solution of a contact problem with friction, with its certificate.

    Parameters
    ----------
    model : str
        One of `MODELS`.
    sides : int
        Of the polygon of `pyramid`, from 4 on and even; its corners begin at the first tangent.
    guess : (m,) array of int, optional
        Expected state of each contact: OFF, HOLDS or SLIPS (along its first tangent); accepted if certified good.
    enough : float
        Certificate that is as good as what the problem is known by.  Points of contact at heights that differ by
        what touches cannot all keep to one plane, and leave a slip as small as that, which no force stops.

    Raises
    ------
    NoSolution
        If no solver reaches a usable certificate; for contacts that slide there may be no solution at all.
    ValueError
        For an unknown model or a polygon with too few or an odd number of sides.
    """
    if model not in MODELS:
        raise ValueError(f"friction model = {model!r}; allowed: {', '.join(MODELS)}")
    if sides < 4 or sides % 2:
        raise ValueError(f"sides = {sides!r}; allowed: an even number from 4 on")
    if guess is not None and model == "exact":
        answer = _expected(problem, guess)
        if answer is not None:
            return answer
    unit, length = _unit(problem)
    if model == "pyramid":
        across = np.zeros(len(length)) if problem.across is None else problem.across
        r, worth, solver = friction_polygon.solve(unit, across, sides, guess)
        x, residual = unit.c + unit.g.T @ r, worth / _scale(unit)
    else:
        r, x, residual, solver = _searched(unit, model == "convex", guess, enough)
    if not residual <= max(USABLE, enough):
        raise NoSolution(f"no solver solves the friction of {len(length)} contacts (best certificate {residual:.3g})")
    u = (unit.g @ x - unit.d).reshape(-1, 3)
    pressed = (r[::3] > 0.0) | (u[:, 0] <= CLOSED * _scale(unit))
    t = np.hypot(r[1::3], r[2::3])
    full = (1.0 - FULL) * unit.mu * r[::3] * (np.cos(np.pi / sides) if model == "pyramid" else 1.0)
    slip = unit.slides | ((t >= full) & (np.hypot(u[:, 1], u[:, 2]) > CLOSED * _scale(unit)))
    states = np.where(pressed, np.where(slip, SLIPS, HOLDS), OFF)
    if model == "pyramid":
        states = friction_polygon.facets(unit.slides, u[:, 1:], states, sides, CLOSED * _scale(unit))
    return Answer(r.reshape(-1, 3) / length[:, None], x, u * length[:, None], residual, solver, states)


def _expected(p: Rough, guess: np.ndarray) -> Answer | None:
    """The answer if the contacts are in the states of the guess; None if they are not."""
    m = len(p.mu)
    r, u, x, way = np.empty(3 * m), np.empty(3 * m), np.empty(len(p.c)), np.zeros((m, 2))
    states, way[:, 0] = np.array(guess, dtype=np.int64), 1.0
    unit, level = np.empty(p.g.shape), np.empty(3 * m)
    worth = guessed(p.g, p.c, p.d, p.mu, p.slides, states, way, unit, level, r, x, u)
    return Answer(r.reshape(m, 3), x, u.reshape(m, 3), worth, "guess", states) if worth <= GOOD else None


def _scale(p: Rough) -> float:
    return max(float(np.sqrt(p.c @ p.c)), float(np.abs(p.d).max()), 1e-300)


def residual(problem: Rough, r: np.ndarray, convex: bool = False) -> float:
    """How far r (3 m,) is from a solution: max |r - P_K(r - u - µ|u_T| n)| over max(|c|, |d|); unit normal rows."""
    x = problem.c + problem.g.T @ r
    return rate(problem.g @ x - problem.d, r, problem.mu, problem.slides, convex) / _scale(problem)


def _unit(problem: Rough) -> tuple[Rough, np.ndarray]:
    """The same problem with normal rows of unit length, and the lengths they had."""
    normals = problem.g[::3]
    length = np.sqrt(np.einsum("ij,ij->i", normals, normals))
    scale = np.repeat(length, 3)
    return problem._replace(g=np.ascontiguousarray(problem.g / scale[:, None]), d=problem.d / scale), length


def _searched(
    p: Rough, convex: bool, guess: np.ndarray | None, enough: float
) -> tuple[np.ndarray, np.ndarray, float, str]:
    """The best answer; where contacts slide, with the most even split of the load (see `friction_hold.hold`)."""
    best = _portfolio(p, convex, guess, enough)
    if p.slides.any() and best[3] != "guess" and best[2] <= USABLE:
        r = best[0]
        for _ in range(TURNS):  # a contact that begins to slide takes its direction from the split
            even = _held(p, *_modes(p, r))
            if even is None:
                break
            r, value = even[0], residual(p, even[0], convex)
            if value <= GOOD:
                return (*even, value, best[3])
    return best


def _portfolio(
    p: Rough, convex: bool, guess: np.ndarray | None, enough: float
) -> tuple[np.ndarray, np.ndarray, float, str]:
    """The best answer of all solvers: (r, x, residual, solver)."""
    best = (np.zeros(len(p.d)), p.c, np.inf, "none")

    def offer(r: np.ndarray, x: np.ndarray | None, name: str) -> bool:
        nonlocal best
        if np.isfinite(r).all():
            value = residual(p, r, convex)
            if value < best[2]:
                best = (r, p.c + p.g.T @ r if x is None else x, value, name)
        return best[2] <= GOOD

    if guess is not None:
        held = _held(p, guess, None)
        if held is not None and offer(*held, "guess"):
            return best
    r = best[0].copy()
    for sweeps in SWEEPS:
        sweep(p.g, p.c, p.d, p.mu, p.slides, convex, r, sweeps)
        for name in ("sweeps", "newton"):
            if name == "newton":
                r = newton(p.g, p.c, p.d, p.mu, p.slides, convex, best[0])
            offer(r, None, name)
            for modes in (_modes, _torn) if not convex and np.isfinite(r).all() else ():
                held = _held(p, *modes(p, r)) if best[2] > GOOD else None
                if held is not None:
                    offer(*held, name)
            if best[2] <= GOOD:
                return best
        if sweeps == SWEEPS[0] and p.slides.all() and offer(_sliding(p), None, "pivots"):
            return best
        if sweeps >= QUICK and best[2] <= enough:
            return best
        r = best[0].copy() if np.isfinite(best[2]) else np.zeros(len(p.d))
    for weight in (1.0, 0.1, 10.0):
        r = relax(p.g, p.c, p.d, p.mu, p.slides, convex, best[0] if np.isfinite(best[2]) else r, weight)
        if offer(r, None, "relaxation"):
            return best
        if offer(newton(p.g, p.c, p.d, p.mu, p.slides, convex, r), None, "newton"):
            return best
    return best


def _modes(p: Rough, r: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """State of each contact under the forces r, and the direction its friction acts against (m, 2)."""
    f = r.reshape(-1, 3)
    size = np.sqrt(f[:, 1] ** 2 + f[:, 2] ** 2)
    u = (p.g @ (p.c + p.g.T @ r) - p.d).reshape(-1, 3)
    slip = np.sqrt(u[:, 1] ** 2 + u[:, 2] ** 2)
    scale = _scale(p)
    push = f[:, 0] > 1e-13 * scale
    edge = push & (size >= (1.0 - 1e-6) * p.mu * f[:, 0]) & (slip > 1e-9 * scale)
    push |= p.slides & (u[:, 0] <= CLOSED * scale)
    modes = np.where(push, np.where(edge | (p.mu == 0.0) | p.slides, SLIPS, HOLDS), OFF)
    way = np.zeros((len(f), 2))
    way[edge] = u[edge, 1:] / slip[edge, None]
    way[p.slides] = (1.0, 0.0)
    return modes, way


def _torn(p: Rough, r: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """As `_modes`, where of contacts that seem to hold those slip whose rest of slip is against their friction.

    Contacts at almost one height that cannot all hold: a body that turns by little more than rounding slides at one
    of them with hardly any slip.  Solvers share that slip out, half of it the wrong way.
    """
    modes, way = _modes(p, r)
    friction, slip = r.reshape(-1, 3)[:, 1:], (p.g @ (p.c + p.g.T @ r) - p.d).reshape(-1, 3)[:, 1:]
    size = np.sqrt((slip**2).sum(axis=1))
    torn = (modes == HOLDS) & ((friction * slip).sum(axis=1) < 0.0) & (size > GOOD * _scale(p))
    modes[torn] = SLIPS
    way[torn] = slip[torn] / size[torn, None]
    return modes, way


def _held(p: Rough, modes: np.ndarray, way: np.ndarray | None) -> tuple[np.ndarray, np.ndarray] | None:
    """Forces (3 m,) that hold what the modes say at exactly zero, the smallest ones, and the motion under them.

    A contact that holds has all three relative motions zero; one that slips has its friction fixed to µ times
    its normal force, against `way`.
    """
    if way is None:
        way = np.tile((1.0, 0.0), (len(p.mu), 1))
    r, x = np.zeros(len(p.d)), p.c.copy()
    return (r, x) if hold(p.g, p.c, p.d, p.mu, modes, way, r, x) else None


def _sliding(p: Rough) -> np.ndarray:
    """Forces of contacts that all slide: a linear complementarity problem that is not symmetric."""
    normal, along = p.g[::3], p.g[1::3]
    pushed = normal - p.mu[:, None] * along
    f = pivot(normal @ pushed.T, normal @ p.c - p.d[::3])
    r = np.zeros((len(p.mu), 3))
    r[:, 0] = f
    r[:, 1] = -p.mu * f
    return r.ravel()
