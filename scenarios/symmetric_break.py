"""A ball strikes two touching balls at the same instant."""

from __future__ import annotations

import math
from dataclasses import replace

from mechanics.effects import Restitution
from mechanics.scene import Body, Scene
from mechanics.shapes import Sphere
from scenarios.impact_laws import outcomes
from scenarios.scenario import Scenario, scenario
from scenarios.tolerance import converged, rounding

RADIUS, SPEED, RUN_UP = 0.0625, 1.0, 0.20037  # [m], [m/s], [m]; strikes within a step, not between two
PAIRS = (("cue", "upper"), ("cue", "lower"), ("upper", "lower"))
ORDERS = {"sequential, upper first": (0, 1, 2), "sequential, lower first": (1, 0, 2)}


@scenario(tags=("impact", "simultaneous", "oblique"), suites=(), variants=({}, {"e": 0.5}), ranges={"e": (0.0, 1.0)})
def symmetric_break(e: float = 1.0) -> Scenario:
    """A cue ball strikes two touching balls squarely between them: both contacts close at the same instant.

    Solved at once, the answer is as symmetric as the scene: the cue comes back at 1/5 and the others leave
    at 0.69.  Solved one contact after the other, one of them gets 0.87, the other 0.43, and the smallest
    change of aim decides which.  The law is named, not marked; momentum and energy are marked.
    """
    meeting = -RADIUS * math.sqrt(3.0)
    cue = Body("cue", Sphere(RADIUS), 1.0, (meeting - RUN_UP, 0.0, 0.0), velocity=(SPEED, 0.0, 0.0))
    upper = Body("upper", Sphere(RADIUS), 1.0, (0.0, 0.0, RADIUS))
    lower = Body("lower", Sphere(RADIUS), 1.0, (0.0, 0.0, -RADIUS))
    scene = Scene((cue, upper, lower), (Restitution(e),))
    touching = replace(scene, bodies=(replace(cue, position=(meeting, 0.0, 0.0)), upper, lower))
    energy = "energy error" if e == 1.0 else "energy rise"
    return Scenario(
        scene=scene,
        duration=1.0,
        sampling=0.01,
        checks=(
            rounding("linear momentum error", "an impulse acts on both balls alike"),
            converged(energy, 1.0, "the energy, as a ratio"),
        ),
        source="Ivanov, J. Appl. Math. Mech. 59 (1995) 887: the outcome does not depend continuously on the aim",
        about=(Restitution,),
        events=(RUN_UP / SPEED,),
        laws=outcomes(touching, PAIRS, e, ORDERS),
    )
