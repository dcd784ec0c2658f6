"""A ball bounces infinitely often within a finite time and then lies still."""

from __future__ import annotations

import math

import numpy as np

from mechanics.effects import Gravity, Resting, Restitution
from mechanics.scene import Body, Scene
from mechanics.shapes import HalfSpace, Sphere
from mechanics.trajectory import Trajectory
from scenarios.bouncing_ball import RADIUS, bounce, delay, impact_times
from scenarios.motion import Motion, trajectory, vectors
from scenarios.scenario import Scenario, scenario
from scenarios.tolerance import GRAVITY, STEP, first_order

CLEARANCE = 1.0  # [m]


def rest_time(clearance: float, e: float) -> float:
    """When the bounces of a ball dropped from `clearance` [m] have come to their end, √(2h/g) (1 + e)/(1 - e) [s]."""
    return math.sqrt(2.0 * clearance / GRAVITY) * (1.0 + e) / (1.0 - e)


def path_length(clearance: float, e: float) -> float:
    """Way the ball goes up and down until then, h (1 + e²)/(1 - e²) [m]."""
    return clearance * (1.0 + e**2) / (1.0 - e**2)


@scenario(tags=("impact", "resting", "zeno"), suites=(), variants=({}, {"e": 0.5}), ranges={"e": (0.1, 0.95)})
def bouncing_to_rest(e: float = 0.8) -> Scenario:
    """A ball dropped from 1 m bounces lower and lower, infinitely often, and is at rest after 4.06 s.

    The impacts accumulate: their intervals shrink like eⁿ and add up to a finite time (Zeno).  Engines end
    this by a threshold of speed; it must neither come so early that it shows nor leave the ball trembling.
    """
    ball = Body("ball", Sphere(RADIUS), mass=1.0, position=(0.0, 0.0, RADIUS + CLEARANCE))
    scene = Scene((Body("floor", HalfSpace()), ball), (Gravity(), Restitution(e), Resting()))
    speed, end = math.sqrt(2.0 * GRAVITY * CLEARANCE), rest_time(CLEARANCE, e)
    duration = round(1.2 * end, 2)

    def truth(t: np.ndarray) -> Trajectory:
        gap, rise = bounce(t, CLEARANCE, e)
        return trajectory(scene, t, {"ball": Motion(vectors(t, z=RADIUS + gap), vectors(t, z=rise))})

    n = np.arange(1, 200)
    late = float(np.max(n * e**n)) * speed * delay(e)
    flight = float(np.max(np.diff(impact_times(CLEARANCE, e, end)), initial=math.sqrt(2.0 * CLEARANCE / GRAVITY)))
    return Scenario(
        scene=scene,
        duration=duration,
        sampling=0.02,
        truth=truth,
        checks=(
            first_order(
                "position error",
                GRAVITY * flight * STEP / 2.0 + late,
                "m",
                f"g t h/2 of the longest flight, and n eⁿ v, at its largest, times {delay(e) / STEP:.2g} h an impact",
            ),
            first_order("final position error", 10.0 * GRAVITY * STEP**2, "m", "10 g h²: gravity moves g h² in a step"),
            first_order("rest speed", 2.0 * GRAVITY * STEP, "m/s", "2 g h: what gravity adds in two steps"),
        ),
        source="√(2h/g) (1 + e)/(1 - e); Brogliato, Nonsmooth Mechanics, 3rd ed., §1.3",
        about=(Gravity, Restitution, Resting),
    )
