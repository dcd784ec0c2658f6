"""Balls at rest between slopes and on each other."""

from __future__ import annotations

import math

from mechanics.effects import Friction, Gravity, Resting, Rotation
from mechanics.scene import Body, Scene
from mechanics.shapes import HalfSpace, Sphere
from scenarios.because import HELD, STANDING
from scenarios.resting import standing
from scenarios.scenario import Scenario, scenario
from scenarios.tolerance import GRAVITY

RADIUS = 0.1  # [m]


def groove_forces(mass: float, left: float, right: float) -> tuple[float, float]:
    """Forces [N] of two smooth sides, inclined by `left` and `right` [rad], on a ball between them."""
    return (
        mass * GRAVITY * math.sin(right) / math.sin(left + right),
        mass * GRAVITY * math.sin(left) / math.sin(left + right),
    )


@scenario(
    tags=("resting",),
    suites=(),
    variants=({}, {"left": 5.0, "right": 85.0}),
    ranges={"left": (1.0, 89.0), "right": (1.0, 89.0)},
    because=HELD,
)
def v_groove(left: float = 35.0, right: float = 60.0) -> Scenario:
    """A ball of 4 kg lies in a smooth groove with sides of 35 and 60 degrees.  Nothing must happen.

    Two forces hold it, and unlike under a box they are unique: 34.1 N and 22.6 N.
    """
    a, b = math.radians(left), math.radians(right)
    sides = (
        Body("left", HalfSpace((math.sin(a), 0.0, math.cos(a)))),
        Body("right", HalfSpace((-math.sin(b), 0.0, math.cos(b)))),
    )
    # the centre is RADIUS away from both: n · c = R
    turn = math.sin(a + b)
    place = (RADIUS * (math.cos(b) - math.cos(a)) / turn, 0.0, RADIUS * (math.sin(a) + math.sin(b)) / turn)
    scene = Scene((*sides, Body("ball", Sphere(RADIUS), 4.0, place)), (Gravity(), Resting()))
    return standing(
        scene, 1, about=(Gravity, Resting),
        source="statics: N = m g sin β/sin (α + β) on the side inclined by α",
    )  # fmt: skip


def pile_thresholds() -> tuple[float, float]:
    """Least friction between the balls, and on the floor, with which three balls carry a fourth."""
    between = math.sqrt(3.0) - math.sqrt(2.0)
    return between, between / 4.0


@scenario(
    tags=("resting", "friction", "stack"),
    suites=(),
    variants=({}, {"between": 0.5, "floor": 0.5}),
    ranges={"between": (0.32, 10.0), "floor": (0.08, 10.0)},
    because=STANDING,
)
def pile_of_balls(between: float = 0.34, floor: float = 0.09) -> Scenario:
    """Three balls that just touch lie on a floor, and a fourth lies on top of them.  Nothing must happen.

    The one on top drives the others apart, and only friction holds them: √3 - √2 = 0.318 is needed
    between the balls and a quarter of it on the floor.  The default is 7 % more than that.
    """
    out = 2.0 * RADIUS / math.sqrt(3.0)  # of the centres from the axis
    balls = [
        Body(f"ball-{k + 1}", Sphere(RADIUS), 1.0, (out * math.cos(turn), out * math.sin(turn), RADIUS))
        for k, turn in enumerate(math.radians(120.0 * k) for k in range(3))
    ]
    top = Body("top", Sphere(RADIUS), 1.0, (0.0, 0.0, RADIUS + 2.0 * RADIUS * math.sqrt(2.0 / 3.0)))
    friction = Friction(between, {("ground", b.name): floor for b in (*balls, top)})
    scene = Scene((Body("ground", HalfSpace()), *balls, top), (Gravity(), friction, Resting(), Rotation()))
    return standing(
        scene, 2, about=(Gravity, Friction, Resting, Rotation),
        source="statics: each contact's force lies in its cone of friction; Lamb, Statics",
    )  # fmt: skip
