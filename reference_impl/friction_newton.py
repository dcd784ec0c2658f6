"""Newton's method for the contact problem with friction."""

from __future__ import annotations

import math

import numpy as np

from reference_impl.friction_cone import project
from reference_impl.kernels import kernel

ITERATIONS = 40


def newton(
    g: np.ndarray, c: np.ndarray, d: np.ndarray, mu: np.ndarray, slides: np.ndarray, convex: bool, start: np.ndarray
) -> np.ndarray:
    """Newton's method on the projections of Alart and Curnier (1991), from `start`; the best iterate.

    Normal: r_n = max(0, r_n - u_n).  Tangent: r_T = the nearest point to r_T - u_T within µ max(0, r_n - u_n).
    For the convex model: r = P_K(r - u).  Steps are those of least norm, so that redundant contacts do no harm.
    """
    m = len(mu)
    w = g @ g.T
    free = g @ c - d
    r = start.copy()
    best, least = r.copy(), math.inf
    value, jacobian = np.empty(3 * m), np.empty((3 * m, 3 * m))
    for _ in range(ITERATIONS):
        linearise(r, w @ r + free, w, mu, slides, convex, value, jacobian)
        size = float(np.abs(value).max())
        if not math.isfinite(size):
            break
        if size < least:
            best, least = r.copy(), size
        try:
            step = np.linalg.lstsq(jacobian, -value, rcond=1e-13)[0]
        except np.linalg.LinAlgError:
            break
        if float(np.abs(step).max()) <= 1e-16 * float(np.abs(r).max()):
            break
        merit, length = float(value @ value), 1.0
        for _ in range(6):
            trial = r + length * step
            linearise(trial, w @ trial + free, w, mu, slides, convex, value, jacobian)
            if float(value @ value) < merit:
                break
            length *= 0.5
        else:
            trial = r + step
        r = trial
    return best


@kernel
def linearise(r, u, w, mu, slides, convex, value, jacobian):
    """Value and generalised Jacobian of the functions whose zero `newton` seeks."""
    m = len(mu)
    for i in range(m):
        k = 3 * i
        n, a, b = r[k] - u[k], r[k + 1] - u[k + 1], r[k + 2] - u[k + 2]
        # value = r - P(y), y = r - u;  jacobian = 1 - P' (1 - w)
        p = np.zeros((3, 3))
        fixed = np.zeros((3, 3))
        t = math.sqrt(a * a + b * b)
        if slides[i]:
            value[k] = r[k] - max(n, 0.0)
            value[k + 1], value[k + 2] = r[k + 1] + mu[i] * r[k], r[k + 2]
            p[0, 0] = 1.0 if n > 0.0 else 0.0
            fixed[1, 0] = mu[i]
        elif convex:
            x, y, z = project(n, a, b, mu[i])
            value[k], value[k + 1], value[k + 2] = r[k] - x, r[k + 1] - y, r[k + 2] - z
            if t <= mu[i] * n:
                p[0, 0] = p[1, 1] = p[2, 2] = 1.0
            elif mu[i] * t > -n:
                s = 1.0 / (1.0 + mu[i] * mu[i])
                ea, eb = a / t, b / t
                p[0, 0] = s
                p[0, 1] = p[1, 0] = s * mu[i] * ea
                p[0, 2] = p[2, 0] = s * mu[i] * eb
                along, across = s * mu[i] * mu[i], s * mu[i] * (n + mu[i] * t) / t
                p[1, 1] = along * ea * ea + across * eb * eb
                p[2, 2] = along * eb * eb + across * ea * ea
                p[1, 2] = p[2, 1] = (along - across) * ea * eb
        else:
            top = max(n, 0.0)
            value[k] = r[k] - top
            radius = mu[i] * top
            if n > 0.0:
                p[0, 0] = 1.0
            if t <= radius:
                value[k + 1], value[k + 2] = r[k + 1] - a, r[k + 2] - b
                p[1, 1] = p[2, 2] = 1.0
            elif n > 0.0:
                ea, eb = a / t, b / t
                value[k + 1], value[k + 2] = r[k + 1] - radius * ea, r[k + 2] - radius * eb
                p[1, 0], p[2, 0] = mu[i] * ea, mu[i] * eb
                s = radius / t
                p[1, 1], p[2, 2] = s * eb * eb, s * ea * ea
                p[1, 2] = p[2, 1] = -s * ea * eb
            else:
                value[k + 1], value[k + 2] = r[k + 1], r[k + 2]
        for e in range(3):
            for j in range(3 * m):
                total = 0.0
                for f in range(3):
                    total += p[e, f] * w[k + f, j]
                jacobian[k + e, j] = total
            for f in range(3):
                jacobian[k + e, k + f] += fixed[e, f] - p[e, f]
            jacobian[k + e, k + e] += 1.0
