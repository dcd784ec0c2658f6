"""Impulses with friction at colliding contacts.

Newton's law holds along the normal, and Coulomb's on the level of impulses along the surface: the tangential
impulse is at most µ times the normal one, stops the slip if it can, and else opposes the slip that is left
(Moreau, 1988).  All contacts that take part at once are one `friction_problem`; which do is up to the law.

With friction Newton's law may create energy where the impact is eccentric and e > 0; the audit tells how much.
The hypotheses of Poisson and Stronge follow a single contact through its impact instead (`phases`).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from reference_impl.contact_problem import NoSolution
from reference_impl.effects.phases import HYPOTHESES, strike
from reference_impl.friction_problem import GOOD, Rough, solve


class RoughCollision(NamedTuple):
    """Contacts of one instant in scaled coordinates, as `impact.Collision`, with two tangents each.

    Impulses are (m, 3) arrays along normal and tangents.
    """

    rows: np.ndarray  # (m, 3, k) G = J M^-1/2
    motion: np.ndarray  # (k,) scaled velocities before
    drift: np.ndarray  # (m, 3) what fixed bodies that move add to the relative velocity [m/s]
    e: Callable[[np.ndarray], np.ndarray]  # u (m,) -> coefficient of restitution of each contact (m,)
    floor: float  # slower approach counts as none [m/s]
    certified: Callable[[float], None]  # is told the certificate of every contact problem
    mu: np.ndarray  # (m,) coefficients of friction
    model: str = "exact"  # of friction, one of `friction_problem.MODELS`
    sides: int = 4  # of the polygon where that is "pyramid"
    restitution: str = "newton"  # or one of `phases.HYPOTHESES`
    enough: float = GOOD  # certificate, see `friction_problem.solve`

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
        answer = solve(problem, self.model, self.sides, enough=self.enough)
        out[chosen] = answer.r
        self.certified(answer.residual)
        return out

    def strike(self, impulses: np.ndarray, which: int, e: float) -> np.ndarray:
        """Impulse (3,) added at the contact `which`, followed through its compression and expansion.

        Raises
        ------
        NoSolution
            If the budget of steps ran out.
        """
        rows = self.rows[which]
        u, impulse = rows @ self.after(impulses) + self.drift[which], np.empty(3)
        if not strike(rows @ rows.T, u, float(self.mu[which]), e, HYPOTHESES[self.restitution], impulse):
            raise NoSolution(f"an impact with friction {self.mu[which]:.6g} does not end")
        return impulse
