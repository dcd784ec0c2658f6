"""A wheel rolls against a step and climbs it."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from mechanics.effects import Friction, Gravity, Resting, Restitution, Rotation
from mechanics.rotation import exponential
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Sphere
from mechanics.trajectory import Trajectory
from scenarios.motion import Motion, trajectory, vectors
from scenarios.scenario import Check, Scenario, Truth, scenario
from scenarios.swing import passing, passing_time
from scenarios.tolerance import GRAVITY, STEP, first_order

RADIUS, MASS, RATIO, MU = 0.3, 2.0, 0.5, 1.0  # [m], [kg], moment over m r² of a disc, friction that never slips
RATE = math.sqrt(GRAVITY / ((1.0 + RATIO) * RADIUS))  # ψ̈ = ω² sin ψ about the step's edge [rad/s]
AWAY = 0.1  # how far from the step it starts [m]


def bumped(speed: float, height: float) -> float:
    """Angular velocity [rad/s] after a plastic impact on the step's edge, about which angular momentum is kept."""
    return speed / RADIUS * (RATIO + 1.0 - height / RADIUS) / (1.0 + RATIO)


def on_top(speed: float, height: float) -> float:
    """Square of the speed [m2/s2] with which the wheel arrives on the step; negative if it rolls back."""
    return (bumped(speed, height) * RADIUS) ** 2 - 2.0 * GRAVITY * height / (1.0 + RATIO)


def least_speed(height: float) -> float:
    """Speed [m/s] with which the wheel just climbs the step."""
    kept = bumped(1.0, height) * RADIUS
    return math.sqrt(2.0 * GRAVITY * height / (1.0 + RATIO)) / kept


class Climb(NamedTuple):
    """When and how."""

    meets: float  # [s]
    arrives: float  # [s]
    angle: float  # from above the edge when it meets it [rad]
    slowest: float  # turning when it is above the edge [rad/s]


def climb(speed: float, height: float) -> Climb:
    """The way of a wheel that climbs."""
    slowest = math.sqrt(on_top(speed, height)) / RADIUS
    meets, angle = AWAY / speed, math.acos(1.0 - height / RADIUS)
    return Climb(meets, meets + passing_time(RATE, slowest, angle), angle, slowest)


def climbing(scene: Scene, speed: float, height: float) -> Truth:
    """Along the floor, about the edge at x = 0, and on along the step."""
    way = climb(speed, height)

    def truth(t: np.ndarray) -> Trajectory:
        phase = np.where(t < way.meets, 0, np.where(t < way.arrives, 1, 2))
        turn, rate = passing(np.clip(t, way.meets, way.arrives) - way.arrives, RATE, way.slowest)
        before, after = np.minimum(t - way.meets, 0.0), np.maximum(t - way.arrives, 0.0)
        x = RADIUS * np.sin(turn) + speed * before + RADIUS * way.slowest * after
        z = np.choose(phase, [0.0 * t + RADIUS, height + RADIUS * np.cos(turn), 0.0 * t + height + RADIUS])
        u = np.choose(phase, [0.0 * t + speed, RADIUS * rate * np.cos(turn), 0.0 * t + RADIUS * way.slowest])
        w = np.choose(phase, [0.0 * t, -RADIUS * rate * np.sin(turn), 0.0 * t])
        spin = np.choose(phase, [0.0 * t + speed / RADIUS, rate, 0.0 * t + way.slowest])
        angle = speed / RADIUS * np.minimum(t, way.meets) + turn + way.angle + way.slowest * after
        motion = Motion(
            vectors(t, x=x, z=z), vectors(t, x=u, z=w), exponential(vectors(t, y=angle)), vectors(t, y=spin)
        )
        return trajectory(scene, t, {"wheel": motion})

    return truth


@scenario(
    tags=("impact", "friction", "rotation", "rolling"),
    suites=(),
    variants=({}, {"speed": 1.1}),
    ranges={"speed": (1.05, 1.5), "height": (0.03, 0.06)},
)
def wheel_and_step(speed: float = 1.4, height: float = 0.06) -> Scenario:
    """A wheel rolls at 1.4 m/s against a step of 6 cm, is slowed by the bump, climbs it and rolls on.

    At the bump the edge of the step grips: what is left is the angular momentum about it, 0.87 of the speed.
    From 1.02 m/s on it climbs; over the edge it must neither slip nor fly, and arrive without a second bump.
    """
    if on_top(speed, height) <= 0.0:
        raise ValueError(f"wheel-and-step: speed = {speed:g} m/s; allowed: more than {least_speed(height):.4g}")
    moment, start = RATIO * MASS * RADIUS**2, -RADIUS * math.sin(math.acos(1.0 - height / RADIUS)) - AWAY
    wheel = Body(
        "wheel", Sphere(RADIUS), MASS, (start, 0.0, RADIUS), velocity=(speed, 0.0, 0.0),
        angular_velocity=(0.0, speed / RADIUS, 0.0), inertia=(moment, moment, moment),
    )  # fmt: skip
    step = Body("step", Box((4.0, 1.0, 1.0)), position=(2.0, 0.0, height - 0.5))
    effects = (Gravity(), Restitution(0.0), Friction(MU), Resting(), Rotation())
    scene = Scene((Body("floor", HalfSpace()), step, wheel), effects)
    way = climb(speed, height)
    return Scenario(
        scene=scene,
        duration=round(way.arrives + 0.1, 2),
        sampling=0.01,
        truth=climbing(scene, speed, height),
        checks=_checks(speed, way),
        source="w' = (v/R)(k + 1 - h/R)/(1 + k), climbs if (1 + k) R² w'²/2 > g h; Meriam and Kraige, Dynamics",
        about=(Gravity, Restitution, Friction, Resting, Rotation),
        events=(way.meets, way.arrives),
    )


def _checks(speed: float, way: Climb) -> tuple[Check, ...]:
    """Late by a step at the bump, a wheel that hardly climbs is speed/slowest times as late on top."""
    late = (1.0 + speed / (RADIUS * way.slowest)) * STEP
    pull = RATE**2 * math.sin(way.angle) + (speed / RADIUS) ** 2
    why = f"for {late / STEP:.2g} h, late at the bump and as much more as it is slower on top"
    return (
        first_order("position error", speed * late, "m", "v " + why),
        first_order("velocity error", pull * RADIUS * late, "m/s", "(α + ω²) R " + why),
        first_order("orientation error", speed / RADIUS * late, "rad", "ω " + why),
        first_order("angular velocity error", pull * late, "rad/s", "(α + ω²) " + why),
    )
