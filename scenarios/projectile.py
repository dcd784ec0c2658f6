"""A thrown ball."""

from __future__ import annotations

import math

from mechanics.effects import Gravity
from mechanics.scene import Body, Scene
from mechanics.shapes import Sphere
from scenarios.free_fall import parabola
from scenarios.scenario import Scenario, scenario
from scenarios.tolerance import GRAVITY, STEP, first_order, rounding


@scenario(tags=("flight",), ranges={"speed": (0.0, 1e3), "angle": (-90.0, 90.0), "height": (-1e3, 1e3)})
def projectile(speed: float = 25.0, angle: float = 40.0, height: float = 3.0) -> Scenario:
    """A ball is thrown at 25 m/s, 40 degrees above the horizontal, and flies for 3.4 s.

    Gravity must act on the vertical velocity only; drag that nobody asked for shows in the range.
    """
    slope = math.radians(angle)
    velocity = (speed * math.cos(slope), 0.0, speed * math.sin(slope))
    ball = Body("ball", Sphere(0.1), mass=1.0, position=(0.0, 0.0, height), velocity=velocity)
    scene = Scene((ball,), (Gravity(),))
    duration = 3.4
    return Scenario(
        scene=scene,
        duration=duration,
        sampling=0.01,
        truth=parabola(scene),
        checks=(
            first_order("position error", GRAVITY * duration * STEP / 2.0, "m", "g t h/2 of semi-implicit Euler"),
            rounding("velocity error", "every consistent scheme is exact for constant acceleration", exact=1e-11),
            rounding("energy error, synchronised", "with x and v at one time level no scheme errs on a parabola"),
        ),
        source="z = h + v t sin α - g t²/2; Goldstein, Poole and Safko, Classical Mechanics, 3rd ed., ch. 1",
        about=(Gravity,),
    )
