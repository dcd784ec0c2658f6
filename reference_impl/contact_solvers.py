"""Solvers of the contact problem, each under its own name.

All find the multipliers f of

    minimise ½ |x - c|²  subject to  G x >= d        <=>        0 <= f,  A f + b >= 0,  f·(A f + b) = 0

with A = G Gᵀ and b = G c - d, rows of G of unit length (`contact_problem` tells where this comes from).
None is believed: what one returns is certified by `contact_problem.solve`, and NaN says that it gave up.
`start` are forces near the answer, for those that can use them.

Every loop has a budget of iterations and of time.  The time is generous, so that it ends what would
hang and never decides between answers.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from reference_impl.kernels import kernel

RANGE = 1e-11  # relative distance at which d counts as reachable, d = G y
MANY = 80  # contacts from which OSQP is faster than non-negative least squares
SECONDS = 10.0  # budget of one solver
ITERATIONS = 20_000  # of OSQP
CLEARLY = -1e-6  # multiplier, relative, of a bound that is active beyond doubt
SWEEPS = 2_000  # of projected Gauss-Seidel

Solver = Callable[[np.ndarray, np.ndarray, np.ndarray, np.ndarray | None], np.ndarray]


def nnls(g: np.ndarray, c: np.ndarray, d: np.ndarray, start: np.ndarray | None = None) -> np.ndarray:
    """Non-negative least squares in the factor form: exact to rounding at every mass ratio, O(m³) and more.

    With d = G y for some y the problem is min |Gᵀ f + (c - y)| over f >= 0; otherwise it is their
    least-distance problem, one row larger (Lawson and Hanson, Solving Least Squares Problems, 1974,
    chapter 23).  Gives up at three iterations per contact.
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


def osqp(g: np.ndarray, c: np.ndarray, d: np.ndarray, start: np.ndarray | None = None) -> np.ndarray:
    """OSQP on the Gauss form, polished: sparse, strictly convex whatever the rank of A, fastest for many contacts.

    Stellato, Banjac, Goulart, Bemporad and Boyd, OSQP: an operator splitting solver for quadratic
    programs (2020).  First order: without polishing it ends at 1e-9, and small stacks under a heavy lid
    may use up its iterations.
    """
    from scipy import sparse

    scale = max(float(np.sqrt(c @ c)), float(np.abs(d).max()))
    if (g @ c >= d).all():
        return np.zeros(len(d))
    problem = _osqp(
        P=sparse.eye(len(c), format="csc"), q=-c / scale, A=sparse.csc_matrix(g), l=d / scale, u=np.full(len(d), np.inf)
    )
    if start is not None:
        problem.warm_start(x=(c + g.T @ start) / scale, y=-start / scale)
    dual = _polished(problem).y
    return np.full(len(d), np.nan) if dual is None else np.maximum(-dual, 0.0) * scale


def osqp_dual(g: np.ndarray, c: np.ndarray, d: np.ndarray, start: np.ndarray | None = None) -> np.ndarray:
    """OSQP on min ½ f·A f + b·f over f >= 0, the quadratic program of Baraff's A f + b (SIGGRAPH 1997, section 9).

    A squares the condition number of G and is singular for redundant contacts: a lid of mass ratio 1e6 on
    a stack ends in "dual infeasible" or in forces that are wrong altogether.
    """
    return SquareProgram(len(d)).solve(g, c, d, start)


class SquareProgram:
    """The quadratic program of A f + b for m contacts, kept: each solve starts where the last one ended."""

    def __init__(self, m: int) -> None:
        self.m = m
        self._upper = np.tril_indices(m)  # of the transposed: the upper triangle by columns, as OSQP keeps it
        self._problem: Any = None

    def solve(self, g: np.ndarray, c: np.ndarray, d: np.ndarray, start: np.ndarray | None = None) -> np.ndarray:
        """Forces (m,), as `osqp_dual`."""
        b = g @ c - d
        if (b >= 0.0).all():
            return np.zeros(self.m)
        scale = float(np.abs(b).max())
        self._pose(g @ g.T, b / scale)
        if start is not None:
            self._problem.warm_start(x=start / scale)
        f = _polished(self._problem).x
        return np.full(self.m, np.nan) if f is None else np.maximum(f, 0.0) * scale

    def _pose(self, a: np.ndarray, b: np.ndarray) -> None:
        if self._problem is not None:
            if self._problem.settings.polishing:
                self._problem.update_settings(polishing=False)
            self._problem.update(Px=a[self._upper], q=b)
            return
        from scipy import sparse

        rows = np.concatenate([np.arange(k + 1) for k in range(self.m)])
        starts = np.concatenate([[0], np.cumsum(np.arange(1, self.m + 1))])
        # zeros are kept: the next matrix may have something there
        upper = sparse.csc_matrix((a[self._upper], rows, starts), shape=(self.m, self.m))
        identity = sparse.eye(self.m, format="csc")
        self._problem = _osqp(P=upper, q=b, A=identity, l=np.zeros(self.m), u=np.full(self.m, np.inf))


def _osqp(**problem: Any) -> Any:
    import osqp as package

    solver = package.OSQP(algebra="builtin")  # the same everywhere, and found without a search
    solver.setup(**problem, eps_abs=1e-9, eps_rel=1e-9, max_iter=ITERATIONS, time_limit=SECONDS, verbose=False)
    return solver


def _polished(problem: Any) -> Any:
    """Result of a problem, polished where a bound is active; without one OSQP would print that there is none."""
    result = problem.solve(raise_error=False)
    if result.y is None or not (result.y < CLEARLY).any():
        return result
    problem.update_settings(polishing=True)
    return problem.solve(raise_error=False)


def dantzig(g: np.ndarray, c: np.ndarray, d: np.ndarray, start: np.ndarray | None = None) -> np.ndarray:
    """Baraff's pivoting: contacts are admitted one by one and their force raised until nothing pulls in.

    At every moment the contacts admitted so far solve their own problem: those in `held` have a = 0,
    those in `free` have f = 0 (Baraff 1994, section 4, frictionless).  Columns of A are formed as they
    are needed; the directions come from least squares on the rows of G, so that redundant contacts do no
    harm.  About m pivots of a dense least-squares problem each: slow beyond a hundred contacts, and in a
    degenerate corner it may go round in circles, which the budget ends.
    """
    m = len(d)
    f = np.zeros(m)
    held: list[int] = []
    free: list[int] = []
    a = g @ c - d
    scale = max(float(np.sqrt(c @ c)), float(np.abs(d).max()), 1e-300)
    deadline = time.perf_counter() + SECONDS
    for new in range(m):
        for _ in range(20 * m + 20):
            # a redundant contact is pulled in by the rounding of all the others
            if a[new] >= -1e-14 * m * max(scale, f.max()):
                break
            if time.perf_counter() > deadline:
                return np.full(m, np.nan)
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


def lemke(g: np.ndarray, c: np.ndarray, d: np.ndarray, start: np.ndarray | None = None) -> np.ndarray:
    """Lemke's complementary pivoting on w - A f - z 1 = b, from z just large enough down to z = 0.

    Lemke, Bimatrix equilibrium points and mathematical programming (1965); Cottle, Pang and Stone, The
    Linear Complementarity Problem (1992), section 4.4.  Fast and exact for similar masses.  It works on A and
    its errors add up from pivot to pivot: in stacks with large mass ratios it ends on a ray or far away.
    """
    m = len(d)
    b = g @ c - d
    scale = float(np.abs(b).max())
    if (b >= 0.0).all():
        return np.zeros(m)
    # columns: w (m), f (m), z, right-hand side
    table = np.hstack([np.eye(m), -g @ g.T, -np.ones((m, 1)), (b / scale)[:, None]])
    basis = np.arange(m)
    entering, row = 2 * m, int(np.argmin(b))
    deadline = time.perf_counter() + SECONDS
    for _ in range(50 * m + 50):
        leaving = int(basis[row])
        table[row] /= table[row, entering]
        others = np.arange(m) != row
        table[others] -= np.outer(table[others, entering], table[row])
        basis[row] = entering
        if leaving == 2 * m:
            f = np.zeros(2 * m)
            f[basis] = table[:, -1]
            return np.maximum(f[m:], 0.0) * scale
        entering = leaving + m if leaving < m else leaving - m
        candidates = np.flatnonzero(table[:, entering] > 1e-12)
        if len(candidates) == 0 or time.perf_counter() > deadline:
            break
        ratios = table[candidates, -1] / table[candidates, entering]
        least = candidates[ratios <= ratios.min() + 1e-13]
        ending = least[basis[least] == 2 * m]  # z leaves as soon as it can
        row = int(ending[0] if len(ending) else least[0])
    return np.full(m, np.nan)


def pgs(g: np.ndarray, c: np.ndarray, d: np.ndarray, start: np.ndarray | None = None) -> np.ndarray:
    """Projected Gauss-Seidel: each force in turn is made right for the others as they are.

    What game engines iterate (Catto, Iterative dynamics with temporal coherence, 2005; there some ten sweeps,
    here 2,000).  Never fails, but its error shrinks by a factor per sweep that goes to one with the height of
    a stack and the mass on top.
    """
    return _sweep(g, c, d, np.zeros(len(d)) if start is None else np.maximum(start, 0.0), SWEEPS)


@kernel
def _sweep(g, c, d, start, sweeps):
    m, k = g.shape
    f = start.copy()
    x = c.copy()
    for i in range(m):
        for j in range(k):
            x[j] += g[i, j] * f[i]
    for _ in range(sweeps):
        change, size = 0.0, 0.0
        for i in range(m):
            a = -d[i]
            for j in range(k):
                a += g[i, j] * x[j]
            step = max(f[i] - a, 0.0) - f[i]
            f[i] += step
            for j in range(k):
                x[j] += g[i, j] * step
            change, size = max(change, abs(step)), max(size, f[i])
        if change <= 1e-16 * size:
            break
    return f


def auto(g: np.ndarray, c: np.ndarray, d: np.ndarray, start: np.ndarray | None = None) -> np.ndarray:
    """`nnls` up to `MANY` contacts, `osqp` beyond: the fastest that is exact, by size."""
    return (nnls if len(d) <= MANY else osqp)(g, c, d, start)


SOLVERS: dict[str, Solver] = {
    "auto": auto,
    "nnls": nnls,
    "osqp": osqp,
    "dantzig": dantzig,
    "lemke": lemke,
    "pgs": pgs,
    "osqp_dual": osqp_dual,
}
