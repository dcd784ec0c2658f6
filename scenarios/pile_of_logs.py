"""Two logs carry a third."""

from __future__ import annotations

import math

from mechanics.effects import Friction, Gravity, Resting, Rotation
from mechanics.scene import Body, Scene
from mechanics.shapes import HalfSpace, Sphere
from scenarios.because import STANDING
from scenarios.resting import standing
from scenarios.scenario import Scenario, scenario

RADIUS = 0.25  # [m]; a binary fraction: the lower ones touch bit by bit


def thresholds() -> tuple[float, float]:
    """Least friction between the logs, tan 15°, and on the floor, a third of it, with which two carry a third.

    The two forces on a lower log besides its weight act along the line between its contacts, 15 degrees from the
    upright, and the floor bears 3/2 of a weight below each.
    """
    between = math.tan(math.radians(15.0))
    return between, between / 3.0


@scenario(
    tags=("resting", "friction", "stack"),
    suites=(),
    variants=({}, {"between": 0.5, "floor": 0.5}),
    ranges={"between": (0.268, 10.0), "floor": (0.0894, 10.0)},
    because=STANDING,
)
def pile_of_logs(between: float = 0.28, floor: float = 0.095) -> Scenario:
    """Two logs that just touch lie on a floor, and a third lies on top of them.  Nothing must happen.

    The one on top drives the others apart, and friction at all four places must hold: 2 - √3 = 0.268 is
    needed between the logs and a third of it on the floor.  The default is 5 % more.  Seen from the end,
    logs are discs; in space they are balls in a plane.
    """
    lower = [Body(name, Sphere(RADIUS), 1.0, (x, 0.0, RADIUS)) for name, x in (("left", -RADIUS), ("right", RADIUS))]
    top = Body("top", Sphere(RADIUS), 1.0, (0.0, 0.0, RADIUS * (1.0 + math.sqrt(3.0))))
    friction = Friction(between, {("ground", name): floor for name in ("left", "right", "top")})
    scene = Scene((Body("ground", HalfSpace()), *lower, top), (Gravity(), friction, Resting(), Rotation()))
    return standing(
        scene, 2, about=(Gravity, Friction, Resting, Rotation),
        source="stands if µ >= tan 15° between the logs and tan 15°/3 on the floor; Lamb, Statics",
    )  # fmt: skip
