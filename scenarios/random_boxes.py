"""Ten boxes dropped at random."""

from __future__ import annotations

import math
from random import Random

from mechanics.effects import Friction, Gravity, Resting, Restitution, Rotation
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace
from scenarios.scenario import Scenario, scenario
from scenarios.tolerance import GRAVITY, STEP, first_order

COUNT, PITCH, CLEARANCE = 10, 0.6, 0.3  # boxes, [m], [m] above the floor for the lowest possible corner
MU, DURATION = 0.5, 4.0


def _attitude(random: Random, planar: bool) -> tuple[float, float, float, float]:
    """Unit quaternion, uniform over all rotations (Shoemake 1992) or over those about y."""
    if planar:
        half = math.pi * random.random()
        return math.cos(half), 0.0, math.sin(half), 0.0
    u, a, b = random.random(), math.tau * random.random(), math.tau * random.random()
    inner, outer = math.sqrt(1.0 - u), math.sqrt(u)
    return outer * math.cos(b), inner * math.sin(a), inner * math.cos(a), outer * math.sin(b)


def random_box(random: Random, place: int, planar: bool) -> Body:
    """Box number `place` with random edges of 0.1 to 0.3 m, attitude and height, density 1000 kg/m3."""
    size = tuple(0.1 + 0.2 * random.random() for _ in range(3))
    reach = 0.5 * math.sqrt(sum(s * s for s in size))
    x, y = (place * PITCH, 0.0) if planar else (place % 5 * PITCH, place // 5 * PITCH)
    return Body(
        f"box-{place + 1}",
        Box(size),
        mass=1000.0 * math.prod(size),
        position=(x, y, reach + CLEARANCE * (1.0 + random.random())),
        orientation=_attitude(random, planar),
    )


@scenario(
    tags=("impact", "resting", "friction", "box"),
    variants=({}, {"layout": "planar"}, {"seed": 2}),
    ranges={"seed": (0, 10**9), "layout": ("spatial", "planar")},
)
def random_boxes(seed: int = 1, layout: str = "spatial") -> Scenario:
    """Ten boxes of random size, attitude and height drop on a rough floor without bounce, topple and come to rest.

    Nobody knows the exact motion.  What is known: energy may only fall, no box may sink into the
    floor by more than it falls in a step, and after four seconds everything lies still.
    """
    random = Random(seed)
    boxes = [random_box(random, k, layout == "planar") for k in range(COUNT)]
    effects = (Gravity(), Restitution(0.0), Friction(MU), Resting(), Rotation())
    scene = Scene((Body("floor", HalfSpace()), *boxes), effects)

    fall = max(b.position[2] for b in boxes)
    speed = math.sqrt(2.0 * GRAVITY * fall)
    return Scenario(
        scene=scene,
        duration=DURATION,
        sampling=0.02,
        checks=(
            first_order("energy rise, synchronised", speed * STEP / CLEARANCE, "1", "m g v h over m g times the fall"),
            first_order("penetration", speed * STEP, "m", f"v h at {speed:.2g} m/s, the fall from the highest centre"),
            first_order(
                "rest speed", 2.0 * GRAVITY * STEP, "m/s", "2 g h: a step's fall of the centre, and as much in spin"
            ),
        ),
        source="conservation laws only; attitudes after Shoemake, Graphics Gems III (1992)",
        about=(Gravity, Restitution, Friction, Resting, Rotation),
    )
