"""A Runge-Kutta step of order eight for motion under contact forces, and polynomials through its ends."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from reference_impl import dormand_prince
from reference_impl.kernels import kernel
from reference_impl.state import ORDER


@kernel
def hermite(h, p0, d0, s0, p1, d1, s1, series):
    """Polynomials of degree five with value p, first derivative d and second derivative s at both ends of h."""
    for c in range(len(p0)):
        for k in range(6, ORDER + 1):
            series[k, c] = 0.0
        _quintic(h, p0[c], d0[c], s0[c], p1[c], d1[c], s1[c], series[:, c])


@kernel
def _quintic(h, p0, d0, s0, p1, d1, s1, out):
    out[0], out[1], out[2] = p0, d0, 0.5 * s0
    p = p1 - p0 - d0 * h - 0.5 * s0 * h * h
    d = (d1 - d0 - s0 * h) * h
    s = (s1 - s0) * h * h
    out[3] = (10.0 * p - 4.0 * d + 0.5 * s) / h**3
    out[4] = (-15.0 * p + 7.0 * d - s) / h**4
    out[5] = (6.0 * p - 3.0 * d + 0.5 * s) / h**5


class RungeKutta8:
    """Dormand and Prince's explicit method of order 8 with Hairer's error estimate of orders 5 and 3.

    Hairer, Nørsett and Wanner, Solving Ordinary Differential Equations I (1993), section II.10.
    """

    a, b, c = dormand_prince.A, dormand_prince.B, dormand_prince.C
    e3, e5 = dormand_prince.E3, dormand_prince.E5
    exponent = 0.125  # of the error in the step that it allows
    converged = True  # there is nothing to be found

    def step(
        self, rate: Callable[[float, np.ndarray], np.ndarray], t: float, y: np.ndarray, h: float, first: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """State after one step, and the derivatives at all stages (13, len(y)), the last at the new state.

        Parameters
        ----------
        rate : function (t, y) -> y'
        first : array
            y' at (t, y).
        """
        stages = np.empty((13, len(y)))
        stages[0] = first
        for s in range(1, 12):
            stages[s] = rate(t + self.c[s] * h, y + h * (self.a[s, :s] @ stages[:s]))
        new = y + h * (self.b @ stages[:12])
        stages[12] = rate(t + h, new)
        return new, stages

    def error(self, stages: np.ndarray, h: float, scale: np.ndarray) -> float:
        """Estimated error of the step over `scale`, root mean square; a step is good at <= 1."""
        fifth = float(np.sum((self.e5 @ stages / scale) ** 2))
        third = float(np.sum((self.e3 @ stages / scale) ** 2))
        if fifth == 0.0 and third == 0.0:
            return 0.0
        return h * fifth / math.sqrt((fifth + 0.01 * third) * len(scale))
