"""A cube lands tilted."""

from __future__ import annotations

import math

from mechanics.effects import Friction, Gravity, Resting, Restitution, Rotation
from mechanics.rotation import about
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace
from scenarios.ladder import STABLE, Ladder
from scenarios.scenario import Scenario, scenario
from scenarios.tolerance import GRAVITY, STEP, first_order

EDGE, CLEARANCE = 0.5, 0.5  # [m]


@scenario(tags=("ladder", "impact", "resting", "box"), suites=(), ranges={"tilt": (0.0, 45.0)})
def tilted_landing(tilt: float = 10.0) -> Scenario:
    """A cube falls half a metre on an edge, tilted by some degrees, bounces a little and must come to rest.

    A tilt near zero is the hardest case for whoever looks for the first contact: two edges strike within
    nanoseconds of each other, again and again.
    """
    angle = math.radians(tilt)
    height = CLEARANCE + 0.5 * EDGE * (math.cos(angle) + math.sin(angle))
    turned = tuple(about((0.0, 1.0, 0.0), angle).tolist())
    box = Body("box", Box((EDGE, EDGE, EDGE)), 1.0, (0.0, 0.0, height), turned)
    effects = (Gravity(), Restitution(0.3), Friction(0.5), Resting(), Rotation())
    rest = first_order(
        "rest speed", 2.0 * GRAVITY * STEP, "m/s", "2 g h: a step's fall of a centre, and as much in spin"
    )
    return Scenario(
        scene=Scene((Body("floor", HalfSpace()), box), effects),
        duration=4.0,
        sampling=0.02,
        checks=(STABLE, rest),
        source="a body that loses energy at every impact comes to rest; Brogliato, Nonsmooth Mechanics, 3rd ed.",
        about=(Restitution, Friction, Resting),
    )


LADDERS = (
    Ladder("landing-tilt", "tilt of a cube that lands on an edge, towards landing flat", "deg", "tilted-landing",
           (40, 20, 10, 3, 1, 0.1, 0.01, 1e-4, 1e-6), "tilt", monotone=False),
    Ladder("tolerance", "tolerance of an engine without time steps, a cube that lands on an edge", "1",
           "tilted-landing", (1e-12, 1e-10, 1e-8, 1e-6, 1e-4, 1e-2), knob="tolerance", lacking="dt"),
)  # fmt: skip
