"""A block that is about to slip."""

from __future__ import annotations

import math

from mechanics.effects import Friction, Gravity, Resting
from mechanics.rotation import about
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace
from scenarios.because import HELD
from scenarios.ladder import STABLE, Ladder
from scenarios.resting import at_rest
from scenarios.scenario import Check, Scenario, scenario

SIZE, SLOPE = (0.4, 0.4, 0.1), math.radians(20.0)  # [m], [rad]
CREPT = "a hundredth of its length: it is not held but slides slowly"


@scenario(tags=("ladder", "friction", "resting", "box"), suites=(), ranges={"margin": (0.0, 100.0)}, because=HELD)
def near_slipping(margin: float = 1.0) -> Scenario:
    """A block lies on a slope of 20 degrees for two seconds, with a little more friction than it needs.

    It is held by µ = tan 20° (1 + margin).  Whoever softens friction, or cuts its cone, lets it creep or slip.
    """
    normal = (math.sin(SLOPE), 0.0, math.cos(SLOPE))
    place = tuple(0.5 * SIZE[2] * c for c in normal)
    block = Body("block", Box(SIZE), 2.0, place, tuple(about((0.0, 1.0, 0.0), SLOPE).tolist()))
    friction = Friction(math.tan(SLOPE) * (1.0 + margin))
    scene = Scene((Body("plane", HalfSpace(normal)), block), (Gravity(), friction, Resting()))
    return at_rest(
        scene,
        (STABLE, Check("drift", 0.01 * SIZE[0], CREPT)),
        about=(Friction, Resting),
        source="Coulomb: a block stays on a slope as long as tan α <= µ",
    )


LADDERS = (
    Ladder("friction-margin", "friction beyond what holds a block on a slope of 20°", "1", "near-slipping",
           (1.0, 0.3, 0.1, 0.03, 0.01, 1e-3, 1e-4, 1e-6, 1e-9), "margin"),
)  # fmt: skip
