"""What the time stepping alone must cost, from the textbook: it tells the integrator's error from that of contacts.

A scheme whose positions run ahead of its velocities by `lead` (see `adapters.engine.lead`) has, with
exact velocities, a position in a uniform field that is off by g t lead: after the time t, g t h/2 for
semi-implicit Euler with the step h (Hairer, Lubich, Wanner, Geometric Numerical Integration, 2nd ed., §I.1).
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from comparisons.measurement import Case, Quantity
from mechanics.effects import Gravity, Rotation

QUANTITIES = {
    "predicted position error": (
        "m",
        "position error that the engine's time stepping must make in free flight, g t |lead|",
    ),
}


def measure(case: Case) -> Iterator[Quantity]:
    """The predicted error of scenes with gravity alone, for engines whose time levels differ."""
    if Gravity in case.scene.needs and case.scene.needs <= {Gravity, Rotation} and case.run.lead:
        t = case.trajectory.t - case.trajectory.t[0]
        fall = np.linalg.norm(case.scene.gravity) * t * abs(case.run.lead)
        yield Quantity.worst("predicted position error", fall, "m", case.trajectory.t)
