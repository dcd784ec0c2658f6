"""A ball bounces down a smooth slope."""

from __future__ import annotations

import math

import numpy as np

from mechanics.effects import Gravity, Restitution
from mechanics.scene import Body, Scene
from mechanics.shapes import HalfSpace, Sphere
from mechanics.trajectory import Trajectory
from scenarios.bouncing_ball import bounce, bounce_checks, delay, impact_times
from scenarios.motion import Motion, trajectory
from scenarios.scenario import Scenario, scenario
from scenarios.tolerance import GRAVITY

RADIUS, CLEARANCE, IMPACTS = 0.1, 0.5, 6  # [m], [m] measured vertically, of the ball as a point


def impacts_down(slope: float, e: float, count: int = IMPACTS) -> tuple[np.ndarray, np.ndarray]:
    """Times of the first `count` impacts [s] and their distances along the slope from the first one [m]."""
    g = GRAVITY * math.cos(slope)
    first = math.sqrt(2.0 * CLEARANCE / GRAVITY)
    times = impact_times(CLEARANCE * math.cos(slope), e, (2.0 * count + 1.0) * first, g)[:count]
    return times, 0.5 * GRAVITY * math.sin(slope) * (times**2 - times[0] ** 2)


@scenario(
    tags=("impact", "oblique"), suites=(), variants=({}, {"e": 0.7}), ranges={"e": (0.5, 1.0), "slope": (1.0, 60.0)}
)
def incline_bounce(e: float = 1.0, slope: float = 20.0) -> Scenario:
    """A ball dropped on a frictionless slope of 20 degrees bounces down it, in hops that get longer and longer.

    Across the slope it is a ball bouncing under g cos α, along the slope a ball sliding under g sin α,
    and neither knows of the other.  For e = 1 the hops are as 1 : 2 : 3 ...
    """
    angle = math.radians(slope)
    normal, down = (
        np.array([math.sin(angle), 0.0, math.cos(angle)]),
        np.array([math.cos(angle), 0.0, -math.sin(angle)]),
    )
    start = RADIUS * normal + np.array([0.0, 0.0, CLEARANCE])
    ball = Body("ball", Sphere(RADIUS), mass=1.0, position=tuple(start.tolist()))
    scene = Scene((Body("slope", HalfSpace(tuple(normal.tolist()))), ball), (Gravity(), Restitution(e)))
    times, _ = impacts_down(angle, e)
    duration = round(float(times[-1]) + 0.1, 2)

    def truth(t: np.ndarray) -> Trajectory:
        clearance, pull = CLEARANCE * math.cos(angle), GRAVITY * math.sin(angle)
        gap, rise = bounce(t, clearance, e, GRAVITY * math.cos(angle))
        origin = start - clearance * normal
        path = origin + gap[:, None] * normal + 0.5 * pull * t[:, None] ** 2 * down
        return trajectory(scene, t, {"ball": Motion(path, rise[:, None] * normal + pull * t[:, None] * down)})

    return Scenario(
        scene=scene,
        duration=duration,
        sampling=0.01,
        truth=truth,
        checks=bounce_checks(CLEARANCE, e, len(times), duration),
        source="4 h sin α n (n + 1) from the first impact on if e = 1; Irodov, Problems in General Physics, 1.23",
        about=(Gravity, Restitution),
        events=tuple(times.tolist()),
        guard=2.0 * len(times) * delay(e),
    )
