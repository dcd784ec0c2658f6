"""A ladder leans on a smooth wall."""

from __future__ import annotations

import math

from mechanics.effects import Friction, Gravity, Resting, Rotation
from mechanics.rotation import about
from mechanics.scene import Body, Scene
from mechanics.shapes import Capsule, HalfSpace
from scenarios.because import STANDING
from scenarios.resting import standing
from scenarios.scenario import Scenario, scenario
from scenarios.tolerance import GRAVITY

LENGTH, RADIUS, MASS = 4.0, 0.05, 10.0  # between the centres of the round ends [m], [m], [kg]


def wall_force(angle: float, radius: float) -> float:
    """Force of the smooth wall on the ladder [N], inclined by `angle` [rad] to the floor; its ends have a `radius` [m].

    Moments about the lower end's centre: m g (L/2) cos θ = H (L sin θ + R), for friction H acts at the floor, R below.
    """
    return 0.5 * MASS * GRAVITY * LENGTH * math.cos(angle) / (LENGTH * math.sin(angle) + radius)


def least_angle(mu_floor: float, mu_wall: float = 0.0) -> float:
    """Least angle to the floor [rad] at which a thin ladder stands: tan θ = (1 - µ_f µ_w)/(2 µ_f)."""
    return math.atan2(1.0 - mu_floor * mu_wall, 2.0 * mu_floor)


@scenario(
    tags=("resting", "friction", "rod"),
    suites=(),
    variants=({}, {"angle": 65.0}),
    ranges={"angle": (52.0, 89.0), "mu": (0.4, 10.0)},
    because=STANDING,
)
def leaning_ladder(angle: float = 52.0, mu: float = 0.4) -> Scenario:
    """A ladder leans on a smooth wall at 52 degrees to a rough floor.  Nothing must happen.

    Friction 0.4 holds it down to 51.3 degrees; just above, the foot's friction is nearly used up.  Both
    forces are unique here, since the wall can only push.
    """
    slope = math.radians(angle)
    place = (RADIUS + 0.5 * LENGTH * math.cos(slope), 0.0, RADIUS + 0.5 * LENGTH * math.sin(slope))
    turned = tuple(about((0.0, 1.0, 0.0), slope - 0.5 * math.pi).tolist())
    moment = MASS * LENGTH**2 / 12.0
    ladder = Body("ladder", Capsule(RADIUS, LENGTH), MASS, place, turned, inertia=(moment, moment, moment))
    surfaces = (Body("floor", HalfSpace()), Body("wall", HalfSpace((1.0, 0.0, 0.0))))
    friction = Friction(mu, {("ladder", "wall"): 0.0})
    scene = Scene((*surfaces, ladder), (Gravity(), friction, Resting(), Rotation()))
    return standing(
        scene, 1, about=(Gravity, Friction, Resting, Rotation),
        source="stands if tan θ >= 1/(2 µ) on a smooth wall; Meriam and Kraige, Statics",
    )  # fmt: skip
