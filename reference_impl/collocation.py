"""An implicit step of order nine for motion under friction that is stiff, in place of the explicit one of order eight.

A contact that slides slowly turns its slip towards its course at the rate µ f / |c|, however small the turn.  An
explicit method has to follow that rate; this one does not: Radau's collocation, stable at any step.
Hairer and Wanner, Solving Ordinary Differential Equations II (1996), section IV.5 and IV.8.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.polynomial import Legendre, Polynomial

STAGES = 5
ITERATIONS = 12  # of Newton's method, whose matrix is that of where they begin
DONE = 0.01  # change of the stages, relative to the error allowed, at which they are found
ROUNDED = 0.3  # the same where the changes have ceased to shrink
NUDGE = 1e-4  # part of the slowest slip by which velocities are changed for derivatives

Rate = Callable[[float, np.ndarray], np.ndarray]


class Table(NamedTuple):
    """Coefficients of the method."""

    nodes: np.ndarray  # (s,) in (0, 1], the last one 1
    weights: np.ndarray  # (s, s) integrals from 0 to each node of the Lagrange polynomials
    top: np.ndarray  # (2, s) the two highest Legendre coefficients of a function from its values at the nodes


@functools.cache
def table() -> Table:
    """Radau's right-hand nodes, the zeros of P_s - P_(s-1) on [0, 1], and what belongs to them."""
    s = STAGES
    series = np.zeros(s + 1)
    series[s - 1 :] = -1.0, 1.0
    z = np.sort(Legendre(series).roots().real)
    for _ in range(3):
        z -= Legendre(series)(z) / Legendre(series).deriv()(z)
    z[-1] = 1.0
    c = 0.5 * (1.0 + z)
    weights = np.empty((s, s))
    for j in range(s):
        others = np.delete(c, j)
        lagrange = Polynomial.fromroots(others) / np.prod(c[j] - others)
        weights[:, j] = lagrange.integ()(c)
    values = np.polynomial.legendre.legvander(z, s - 1)
    return Table(c, weights, np.linalg.inv(values)[-2:])


class Collocation:
    """Radau's method of order nine for states that stand body by body as position, quaternion, velocity, momentum.

    Parameters
    ----------
    nudge : (n,) array
        Change of each component of the state for its derivative; zero: the rate is taken not to depend on it.
    scale : (n,) array
        Error allowed in each component.
    """

    exponent = 1.0 / 6.0  # of the error in the step that it allows

    def __init__(self, nudge: np.ndarray, scale: np.ndarray) -> None:
        self.nudge, self.scale = nudge, scale
        self.stiff = np.flatnonzero(nudge)
        self.converged = False

    def step(self, rate: Rate, t: float, y: np.ndarray, h: float, first: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """State after one step and the derivatives (s + 1, len(y)) at its begin and its nodes, as `RungeKutta8.step`.

        Whether the stages were found is told by `error`.
        """
        c, weights, _ = table()
        stages = np.empty((STAGES + 1, len(y)))
        stages[0] = first
        way = h * c[:, None] * first
        matrix: np.ndarray | None = None
        last, self.converged = np.inf, False
        for _ in range(ITERATIONS):
            for i in range(STAGES):
                stages[i + 1] = rate(t + c[i] * h, y + way[i])
            if matrix is None:
                matrix = self._matrix(rate, t, h, y + way, stages[1:])
            change = h * (weights @ stages[1:]) - way
            change[:, self.stiff] = (matrix @ change[:, self.stiff].ravel()).reshape(STAGES, -1)
            way += change
            size = float(np.abs(change / self.scale).max())
            self.converged = size <= DONE or (size <= ROUNDED and size > 0.5 * last)
            if self.converged or size > 2.0 * last:
                break
            last = size
        new = y + way[-1]
        stages[-1] = rate(t + h, new)
        return new, stages

    def error(self, stages: np.ndarray, h: float, scale: np.ndarray) -> float:
        """Estimated error within the step over `scale`, as `RungeKutta8.error`; great if the stages were not found.

        From the two highest Legendre coefficients of the derivatives, as if the next one fell off as these do.
        """
        if not self.converged:
            return 1e9
        before, last = np.sqrt(((table().top @ stages[1:] / scale) ** 2).mean(axis=1))
        return float(h * last * min(1.0, last / before)) if last > 0.0 else 0.0

    def _matrix(self, rate: Rate, t: float, h: float, y: np.ndarray, rates: np.ndarray) -> np.ndarray:
        """Inverse of Newton's matrix at the stages y (s, n), where the rates are known.

        Each stage has its own derivatives: with those of the begin, where a slip that grows is the slowest, changes
        would be small long before the stages are found.
        """
        c, weights, _ = table()
        count = len(self.stiff)
        out = np.eye(STAGES * count)
        for j in range(STAGES):
            derivatives = np.empty((count, count))
            for column, i in enumerate(self.stiff):
                other = y[j].copy()
                other[i] += self.nudge[i]
                gained = rate(t + c[j] * h, other)[self.stiff] - rates[j, self.stiff]
                derivatives[:, column] = gained / (other[i] - y[j, i])
            out[:, j * count : (j + 1) * count] -= h * np.kron(weights[:, j : j + 1], derivatives)
        return np.linalg.inv(out)
