"""What a user of the reference engine may choose."""

from __future__ import annotations

from dataclasses import dataclass

from reference_impl.contact_problem import SOLVERS
from reference_impl.effects.impact import LAWS
from reference_impl.effects.phases import HYPOTHESES
from reference_impl.friction_problem import MODELS
from reference_impl.time_of_contact import METHODS


@dataclass(frozen=True)
class Settings:
    """What a user may choose.

    Attributes
    ----------
    impact_law : str
        One of `effects.impact.LAWS`.
    restitution : str
        What the coefficient of restitution means where friction acts: "newton" (of normal velocities), "poisson" (of
        normal impulses) or "energetic" (of the work of the normal impulse, squared; Stronge).  Without friction they
        are the same.  The last two follow one contact at a time through its impact; see `effects.impact.in_turn`.
    friction : str
        Model of the cone of friction, one of `friction_problem.MODELS`; "convex" acts at impacts, and contact that
        lasts has the exact cone, to which its hops tend.
    sides : int
        Of the polygon in place of the circle where friction is "pyramid".
    time_of_contact : str
        One of `time_of_contact.METHODS`: "advancement" (conservative, second order), or "bisection",
        "illinois" or "newton" in a bracket that it opens.
    solver : str
        First solver of contact problems, one of `contact_problem.SOLVERS`.
    tolerance : float
        Relative accuracy of contact times (gap over body size) and of the motion in lasting contact.
    events : int
        Budget: contacts handled in one call of `advance`.
    steps : int
        Budget: steps in lasting contact tried in one call of `advance`.

    Raises
    ------
    ValueError
        For an unknown name or a number out of range.
    """

    impact_law: str = "propagation"
    restitution: str = "newton"
    friction: str = "exact"
    sides: int = 4
    time_of_contact: str = "advancement"
    solver: str = "auto"
    tolerance: float = 1e-12
    events: int = 1_000_000
    steps: int = 1_000_000

    def __post_init__(self) -> None:
        choices = (
            ("impact_law", tuple(LAWS)),
            ("restitution", ("newton", *HYPOTHESES)),
            ("friction", MODELS),
            ("time_of_contact", METHODS),
            ("solver", tuple(SOLVERS)),
        )
        for name, allowed in choices:
            if getattr(self, name) not in allowed:
                raise ValueError(f"{name} = {getattr(self, name)!r}; allowed: {', '.join(allowed)}")
        if not 1e-13 <= self.tolerance <= 1e-2:
            raise ValueError(f"tolerance = {self.tolerance!r}; allowed: a number from 1e-13 to 1e-2")
        if self.sides < 4 or self.sides % 2:
            raise ValueError(f"sides = {self.sides!r}; allowed: an even number from 4 on")
        if self.restitution != "newton" and self.friction != "exact":
            raise ValueError(f"friction = {self.friction!r}; allowed: exact where restitution is {self.restitution!r}")
        for name in ("events", "steps"):
            if getattr(self, name) < 1:
                raise ValueError(f"{name} = {getattr(self, name)!r}; allowed: a whole number > 0")
