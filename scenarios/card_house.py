"""Two cards lean on each other."""

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

LENGTH, RADIUS, MASS = 1.0, 0.02, 0.1  # between the centres of the round ends [m], [m], [kg]


def apex_force(angle: float, radius: float) -> float:
    """Force [N] of one card on the other, `angle` [rad] from upright; their ends have a `radius` [m].

    Moments about the foot on the floor: H (L cos φ + R) = m g (L/2) sin φ.  The floor bears m g and must hold H.
    """
    return 0.5 * MASS * GRAVITY * LENGTH * math.sin(angle) / (LENGTH * math.cos(angle) + radius)


@scenario(
    tags=("resting", "friction", "rod"),
    suites=(),
    variants=({}, {"angle": 10.0, "mu": 0.1}),
    ranges={"angle": (1.0, 60.0), "mu": (0.0, 10.0)},
    because=STANDING,
)
def card_house(angle: float = 25.0, mu: float = 0.24) -> Scenario:
    """Two cards lean on each other at 25 degrees from upright on a rough floor.  Nothing must happen.

    Each holds the other up, and the floor must hold both feet: friction tan φ/2 = 0.233 does it for thin
    cards, 0.228 for these with round edges.  Friction where they meet has nothing to do, by symmetry.
    """
    lean = math.radians(angle)
    needed = apex_force(lean, RADIUS) / (MASS * GRAVITY)
    if mu < needed:
        raise ValueError(f"card-house: mu = {mu:g} does not hold {angle:g} degrees; allowed: {needed:.4f} and more")
    moment, cards = MASS * LENGTH**2 / 12.0, []
    for name, side in (("left", -1.0), ("right", 1.0)):
        place = (side * (RADIUS + 0.5 * LENGTH * math.sin(lean)), 0.0, RADIUS + 0.5 * LENGTH * math.cos(lean))
        turned = tuple(about((0.0, 1.0, 0.0), -side * lean).tolist())
        cards.append(Body(name, Capsule(RADIUS, LENGTH), MASS, place, turned, inertia=(moment, moment, moment)))
    scene = Scene((Body("table", HalfSpace()), *cards), (Gravity(), Friction(mu), Resting(), Rotation()))
    return standing(
        scene, 2, about=(Gravity, Friction, Resting, Rotation),
        source="stands if µ >= ½ tan φ (thin cards); Heyman, The Stone Skeleton (1995)",
    )  # fmt: skip
