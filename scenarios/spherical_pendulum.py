"""A pendulum that swings round as well as to and fro."""

from __future__ import annotations

import math

import numpy as np

from mechanics.effects import Gravity, Rod
from mechanics.scene import Body, Scene
from mechanics.shapes import Sphere
from mechanics.trajectory import Trajectory
from scenarios.heavy_top import Release, axis, direction
from scenarios.motion import Motion, trajectory
from scenarios.scenario import Scenario, scenario
from scenarios.tolerance import GRAVITY, STEP, first_order

LENGTH, MASS, DURATION = 1.0, 1.0, 3.0  # [m], [kg], [s]


def hung(angle: float, speed: float) -> Release:
    """A bob at `angle` from straight down [rad], thrown sideways at `speed` [m/s]; a top counts angles from above."""
    return Release(2.0 * GRAVITY / LENGTH, 0.0, math.pi - angle, speed / (LENGTH * math.sin(angle)))


def _scenario(pendulum: Release, source: str) -> Scenario:
    out, rate = (LENGTH * a[0] for a in direction(axis(pendulum, np.zeros(1))))
    bob = Body("bob", Sphere(0.05), MASS, tuple(out.tolist()), velocity=tuple(rate.tolist()))
    scene = Scene((Body("pivot", Sphere(0.02)), bob), (Gravity(), Rod("pivot", "bob")))

    def truth(t: np.ndarray) -> Trajectory:
        return trajectory(scene, t, {"bob": Motion(*(LENGTH * a for a in direction(axis(pendulum, t))))})

    fast = math.sqrt(float(rate @ rate) + 2.0 * GRAVITY * (out[2] + LENGTH))
    swings = 1.0 + DURATION * math.sqrt(GRAVITY / LENGTH) / math.pi
    why = f"each of {swings:.2g} half swings a step early or late: "
    return Scenario(
        scene=scene,
        duration=DURATION,
        sampling=0.01,
        truth=truth,
        checks=(
            first_order("position error", swings * fast * STEP, "m", why + "v h"),
            first_order("velocity error", swings * (GRAVITY + fast**2 / LENGTH) * STEP, "m/s", why + "(g + v²/l) h"),
        ),
        source=source,
        about=(Gravity, Rod),
    )


@scenario(tags=("joint", "pendulum"), suites=(), variants=({}, {"angle": 70.0}), ranges={"angle": (1.0, 89.0)})
def conical_pendulum(angle: float = 40.0) -> Scenario:
    """A bob on a rod goes round in a level circle, 40 degrees from straight down.

    At Ω² = g/(l cos θ) the pull of the rod bears the weight and bends the path as well, and nothing but
    the direction changes.  A rod that gives way, or a step that runs off along the tangent, shows as height.
    """
    turn = math.radians(angle)
    speed = LENGTH * math.sin(turn) * math.sqrt(GRAVITY / (LENGTH * math.cos(turn)))
    return _scenario(hung(turn, speed), "Ω² = g/(l cos θ); Huygens, Horologium Oscillatorium (1673)")


@scenario(
    tags=("joint", "pendulum"),
    suites=(),
    variants=({}, {"angle": 120.0, "speed": 2.0}),
    ranges={"angle": (5.0, 170.0), "speed": (0.2, 5.0)},
)
def spherical_pendulum(angle: float = 60.0, speed: float = 1.0) -> Scenario:
    """A bob on a rod is let go at 60 degrees with a push sideways: it rises and falls and goes round.

    Its path is a rosette; from one highest place to the next it goes 203 degrees round, not the 180 of small
    swings.  The angular momentum about the vertical must not change.
    """
    return _scenario(hung(math.radians(angle), speed), "Landau and Lifshitz, Mechanics, §14; Whittaker, §55")
