"""Round bodies roll, or slip, down a slope."""

from __future__ import annotations

import math

import numpy as np

from mechanics.effects import Friction, Gravity, Resting, Rotation
from mechanics.rotation import exponential
from mechanics.scene import Body, Scene
from mechanics.shapes import HalfSpace, Sphere
from mechanics.trajectory import Trajectory
from scenarios.motion import Motion, trajectory, vectors
from scenarios.scenario import Check, Scenario, scenario
from scenarios.tolerance import GRAVITY, STEP, first_order

RADIUS, MASS, DURATION = 0.1, 1.0, 1.0  # [m], [kg], [s]
RATIOS = {"ball": 2.0 / 5.0, "cylinder": 1.0 / 2.0, "shell": 2.0 / 3.0, "hoop": 1.0}  # moment of inertia over m R²


def accelerations(slope: float, mu: float, ratio: float) -> tuple[float, float]:
    """Of the centre down the slope, and of the surface by spin, both [m/s2]: equal if the body rolls.

    `ratio` is the moment of inertia over m R².  It rolls if µ >= k tan α/(1 + k).
    """
    pull, grip = GRAVITY * math.sin(slope), mu * GRAVITY * math.cos(slope)
    if grip >= needed_friction(slope, ratio) * GRAVITY * math.cos(slope):
        return pull / (1.0 + ratio), pull / (1.0 + ratio)
    return pull - grip, grip / ratio


def needed_friction(slope: float, ratio: float) -> float:
    """Least coefficient of friction with which the body rolls."""
    return ratio * math.tan(slope) / (1.0 + ratio)


@scenario(
    tags=("friction", "rotation", "rolling"),
    suites=(),
    variants=({}, {"body": "shell"}, {"mu": 0.1}),
    ranges={"mu": (0.0, 10.0), "slope": (0.0, 80.0), "body": tuple(RATIOS)},
)
def rolling_down(mu: float = 0.5, slope: float = 30.0, body: str = "ball") -> Scenario:
    """A ball, solid or hollow, rolls down a slope of 30 degrees; with little friction it slips as well.

    Rolling it accelerates by g sin α/(1 + k), with k = 2/5 for a solid ball and 2/3 for a shell, whatever
    its size and mass: part of the energy goes into spin.  The moment is given, not taken from the shape.
    """
    angle, ratio = math.radians(slope), RATIOS[body]
    normal, down = np.array([math.sin(angle), 0.0, math.cos(angle)]), np.array([math.cos(angle), 0.0, -math.sin(angle)])
    start, moment = RADIUS * normal, ratio * MASS * RADIUS**2
    ball = Body("ball", Sphere(RADIUS), MASS, tuple(start.tolist()), inertia=(moment, moment, moment))
    effects = (Gravity(), Friction(mu), Resting(), Rotation())
    scene = Scene((Body("slope", HalfSpace(tuple(normal.tolist()))), ball), effects)
    pace, roll = accelerations(angle, mu, ratio)
    spin = roll / RADIUS

    def truth(t: np.ndarray) -> Trajectory:
        path = start + 0.5 * pace * t[:, None] ** 2 * down
        turned = exponential(vectors(t, y=0.5 * spin * t**2))
        return trajectory(scene, t, {"ball": Motion(path, pace * t[:, None] * down, turned, vectors(t, y=spin * t))})

    return Scenario(
        scene=scene,
        duration=DURATION,
        sampling=0.01,
        truth=truth,
        checks=_checks(pace, spin),
        source="a = g sin α/(1 + k) if µ >= k tan α/(1 + k), else g (sin α - µ cos α); Meriam and Kraige, Dynamics",
        about=(Gravity, Friction, Resting, Rotation),
    )


def _checks(pace: float, spin: float) -> tuple[Check, ...]:
    return (
        first_order("position error", GRAVITY * DURATION * STEP / 2.0, "m", "g t h/2 of semi-implicit Euler"),
        first_order("velocity error", pace * STEP, "m/s", "a h: what one step changes"),
        first_order("orientation error", spin * DURATION * STEP, "rad", "α t h: spin sets in up to a step late"),
        first_order("angular velocity error", spin * STEP, "rad/s", "α h: what one step changes"),
    )
