"""Impulses with friction at colliding contacts.

Newton's law holds along the normal, and Coulomb's on the level of impulses along the surface: the tangential
impulse is at most µ times the normal one, stops the slip if it can, and else opposes the slip that is left
(Moreau, 1988).  All contacts that take part at once are one `friction_problem`; which do is up to the law.

With friction Newton's law may create energy where the impact is eccentric and e > 0; the audit tells how much.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from reference_impl.friction_problem import Rough, solve


class RoughCollision(NamedTuple):
    """Contacts of one instant in scaled coordinates, as `impact.Collision`, with two tangents each.

    Impulses are (m, 3) arrays along normal and tangents.
    """

    rows: np.ndarray  # (m, 3, k) G = J M^-1/2
    motion: np.ndarray  # (k,) scaled velocities before
    drift: np.ndarray  # (m, 3) what fixed bodies that move add to the relative velocity [m/s]
    e: Callable[[np.ndarray], np.ndarray]  # u (m,) -> coefficient of restitution of each contact (m,)
    floor: float  # slower approach counts as none [m/s]
    mu: np.ndarray  # (m,) coefficients of friction

    def nothing(self) -> np.ndarray:
        """No impulses."""
        return np.zeros(self.drift.shape)

    def after(self, impulses: np.ndarray) -> np.ndarray:
        """Scaled velocities after `impulses`."""
        return self.motion + np.einsum("ij,ijk->k", impulses, self.rows)

    def speeds(self, impulses: np.ndarray) -> np.ndarray:
        """Normal relative velocities u (m,) after `impulses` [m/s]."""
        return self.rows[:, 0] @ self.after(impulses) + self.drift[:, 0]

    def bounce(self, impulses: np.ndarray, chosen: np.ndarray, e: np.ndarray) -> np.ndarray:
        """Impulses added at once at the `chosen` contacts: u_n⁺ = -e u_n⁻ where they push, and Coulomb's law."""
        out = self.nothing()
        motion, rows = self.after(impulses), self.rows[chosen]
        least = -self.drift[chosen]
        least[:, 0] -= (e * self.speeds(impulses))[chosen]
        count = len(rows)
        problem = Rough(
            rows.reshape(3 * count, -1), motion, least.ravel(), self.mu[chosen], np.zeros(count, dtype=np.bool_)
        )
        out[chosen] = solve(problem).r
        return out
