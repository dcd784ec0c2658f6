"""A ball falls from rest: gravity alone."""

from __future__ import annotations

import numpy as np

from mechanics.effects import Gravity
from mechanics.scene import Body, Scene
from mechanics.shapes import Sphere
from mechanics.trajectory import Trajectory
from scenarios.motion import Motion, trajectory
from scenarios.scenario import Scenario, Truth, scenario
from scenarios.tolerance import GRAVITY, STEP, first_order, rounding

SOURCE = "z = h - g t²/2; Goldstein, Poole and Safko, Classical Mechanics, 3rd ed., ch. 1"


def parabola(scene: Scene) -> Truth:
    """Motion of bodies on which nothing acts but gravity, and which do not turn."""

    def truth(t: np.ndarray) -> Trajectory:
        s, g = t[:, None], scene.gravity
        motions = {}
        for i in scene.moving:
            x, v = scene.start().x[i], scene.start().v[i]
            motions[scene.names[i]] = Motion(x + v * s + 0.5 * g * s**2, v + g * s)
        return trajectory(scene, t, motions)

    return truth


def flight(scene: Scene, duration: float, source: str) -> Scenario:
    """Free flight of the bodies of a scene for `duration` [s]."""
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
        source=source,
        about=(Gravity,),
    )


@scenario(
    tags=("flight",),
    suites=("smoke", "standard"),
    variants=({}, {"mass": 1e6}),
    ranges={"mass": (1e-6, 1e9), "height": (1e-3, 1e6)},
)
def free_fall(height: float = 20.0, mass: float = 1.0) -> Scenario:
    """A ball is let go 20 m up and falls for 1.5 s through empty space.

    The simplest question there is: does the engine know what gravity does, and nothing else?  Hidden
    damping shows at once, and the offset g t h/2 tells which integrator is at work.  Mass drops out.
    """
    ball = Body("ball", Sphere(0.1), mass=mass, position=(0.0, 0.0, height))
    return flight(Scene((ball,), (Gravity(),)), 1.5, SOURCE)
