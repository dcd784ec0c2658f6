"""A thrown ball."""

from __future__ import annotations

import math

from mechanics.effects import Gravity
from mechanics.scene import Body, Scene
from mechanics.shapes import Sphere
from scenarios.free_fall import flight
from scenarios.scenario import Scenario, scenario

SOURCE = "z = h + v t sin α - g t²/2; Goldstein, Poole and Safko, Classical Mechanics, 3rd ed., ch. 1"


@scenario(tags=("flight",), ranges={"speed": (0.0, 1e3), "angle": (-90.0, 90.0), "height": (-1e3, 1e3)})
def projectile(speed: float = 25.0, angle: float = 40.0, height: float = 3.0) -> Scenario:
    """A ball is thrown at 25 m/s, 40 degrees above the horizontal, and flies for 3.4 s.

    Gravity must act on the vertical velocity only; drag that nobody asked for shows in the range.
    """
    slope = math.radians(angle)
    velocity = (speed * math.cos(slope), 0.0, speed * math.sin(slope))
    ball = Body("ball", Sphere(0.1), mass=1.0, position=(0.0, 0.0, height), velocity=velocity)
    return flight(Scene((ball,), (Gravity(),)), 3.4, SOURCE)
