"""Smooth impacts at several contacts at once, by the laws people use: mechanics does not decide between them.

Contacts are rows of J: u = J v are the relative normal velocities, negative where bodies approach.
Impulses p >= 0 change v by M⁻¹ Jᵀ p, and so u by W p with W = J M⁻¹ Jᵀ.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np

from mechanics.scene import Scene


def simultaneous(w: np.ndarray, u: np.ndarray, e: float) -> np.ndarray:
    """Impulses of all contacts at once: 0 <= p, u⁺ + e u >= 0, and p · (u⁺ + e u) = 0, by trying every active set.

    Baraff, SIGGRAPH 1989; Moreau, Unilateral contact and dry friction in finite freedom dynamics (1988).

    Raises
    ------
    ValueError
        If no active set answers, which a matrix that is not positive semidefinite can do.
    """
    wanted = (1.0 + e) * u
    for chosen in product((False, True), repeat=len(u)):
        on = np.array(chosen)
        p = np.zeros(len(u))
        if on.any():
            p[on] = np.linalg.lstsq(w[np.ix_(on, on)], -wanted[on], rcond=None)[0]
        left = w @ p + wanted
        small = 1e-12 * (1.0 + np.abs(u).max())
        if (p >= -small).all() and (left >= -small).all() and np.abs(left[on]).max(initial=0.0) <= small:
            return p
    raise ValueError(f"no impulses solve this impact: u = {u}")


def sequential(
    w: np.ndarray, u: np.ndarray, e: float, order: Sequence[int], most: int = 1000
) -> tuple[np.ndarray, int]:
    """Impulses of one contact after the other, each time the first in `order` that approaches, and their number.

    Raises
    ------
    ValueError
        If after `most` impacts bodies still approach, as they do for ever where e = 0.
    """
    p, now = np.zeros(len(u)), np.array(u, dtype=np.float64)
    for count in range(most):
        due = [k for k in order if now[k] < -1e-14 * np.abs(u).max()]
        if not due:
            return p, count
        step = -(1.0 + e) * now[due[0]] / w[due[0], due[0]]
        p[due[0]] += step
        now += w[:, due[0]] * step
    raise ValueError(f"bodies still approach after {most} impacts")


def smooth_contacts(scene: Scene, pairs: Sequence[tuple[str, str]]) -> tuple[np.ndarray, np.ndarray]:
    """J (k, 3n) of touching balls, its normals from the second body of each pair to the first, and M⁻¹ (3n,)."""
    start, rows = scene.start(), []
    for a, b in pairs:
        i, j = scene.index(a), scene.index(b)
        normal = (start.x[i] - start.x[j]) / np.linalg.norm(start.x[i] - start.x[j])
        row = np.zeros((len(scene.bodies), 3))
        row[i], row[j] = normal, -normal
        rows.append(row.ravel())
    inverse = [0.0 if b.mass is None else 1.0 / b.mass for b in scene.bodies]
    return np.array(rows), np.repeat(inverse, 3)


def outcomes(
    scene: Scene, pairs: Sequence[tuple[str, str]], e: float, orders: dict[str, Sequence[int]]
) -> dict[str, tuple[tuple[float, float, float], ...]]:
    """Velocities of all bodies [m/s] after the impact of balls that touch at the start, by law.

    Parameters
    ----------
    scene : Scene
        At the instant of the impact.
    pairs : names of the bodies that touch
    e : restitution
    orders : name of a law -> the order in which it looks at the pairs, one after the other
    """
    j, inverse = smooth_contacts(scene, pairs)
    v = scene.start().v.ravel()
    w, u = (j * inverse) @ j.T, j @ v
    impulses = {name: sequential(w, u, e, order)[0] for name, order in orders.items()}
    impulses["simultaneous"] = simultaneous(w, u, e)
    after = {name: (v + inverse * (j.T @ p)).reshape(-1, 3) for name, p in impulses.items()}
    return {name: tuple(map(tuple, velocities.tolist())) for name, velocities in after.items()}
