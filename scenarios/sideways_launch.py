"""A block launched across a slope on which it can hardly slide."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from mechanics.effects import Friction, Gravity, Resting
from mechanics.rotation import about
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace
from mechanics.trajectory import Trajectory
from scenarios.motion import Motion, trajectory
from scenarios.scenario import Scenario, Truth, scenario
from scenarios.tolerance import GRAVITY, STEP, first_order

SIZE, SLOPE, DURATION = (0.4, 0.4, 0.1), math.radians(20.0), 2.0  # [m], [rad], [s]

NORMAL, ACROSS = np.array([math.sin(SLOPE), 0.0, math.cos(SLOPE)]), np.array([0.0, 1.0, 0.0])
DOWN = np.array([math.cos(SLOPE), 0.0, -math.sin(SLOPE)])


class Path(NamedTuple):
    """Sliding on the slope when the velocity is at the angle φ from the fall line."""

    time: np.ndarray  # [s]
    speed: np.ndarray  # [m/s]
    across: np.ndarray  # [m]
    down: np.ndarray  # [m]


def along_the_path(tau: np.ndarray, speed: float, ratio: float) -> Path:
    """The path in terms of τ = tan (φ/2), from τ = 1 on; `ratio` r = µ/tan α is at most 1.

    Gravity pulls by g sin α down the slope, friction by r g sin α against the velocity, so
    v' = g sin α (cos φ - r), v φ' = -g sin α sin φ, and v = v₀ τʳ/sin φ; the rest are integrals of powers of τ.
    """
    pull, r = GRAVITY * math.sin(SLOPE), ratio

    def power(n: float) -> np.ndarray:
        """∫ τⁿ⁻¹ dτ from τ to 1, (1 - τⁿ)/n; -ln τ for n = 0."""
        return -np.expm1(n * np.log(tau)) / n if n else -np.log(tau)

    return Path(
        speed / (2.0 * pull) * (power(r - 1.0) + power(r + 1.0)),
        0.5 * speed * tau ** (r - 1.0) * (1.0 + tau**2),
        speed**2 / (2.0 * pull) * (power(2.0 * r - 1.0) + power(2.0 * r + 1.0)),
        speed**2 / (4.0 * pull) * (power(2.0 * r - 2.0) - power(2.0 * r + 2.0)),
    )


def heading(t: np.ndarray, speed: float, ratio: float) -> np.ndarray:
    """τ = tan (φ/2) at times `t` [s], by Newton's method in ln τ, where the time is convex."""
    log = np.zeros_like(t)
    for _ in range(60):
        path = along_the_path(np.exp(log), speed, ratio)
        log += (path.time - t) * GRAVITY * math.sin(SLOPE) / path.speed
    return np.exp(log)


def curved(scene: Scene, speed: float, ratio: float) -> Truth:
    """Sliding from across the slope to down it."""
    start = np.array(scene.body("block").position)

    def truth(t: np.ndarray) -> Trajectory:
        tau = heading(t, speed, ratio)
        path, angle = along_the_path(tau, speed, ratio), 2.0 * np.arctan(tau)[:, None]
        x = start + path.down[:, None] * DOWN + path.across[:, None] * ACROSS
        v = path.speed[:, None] * (np.cos(angle) * DOWN + np.sin(angle) * ACROSS)
        return trajectory(scene, t, {"block": Motion(x, v)})

    return truth


@scenario(
    tags=("friction", "resting", "box"),
    suites=(),
    variants=({}, {"ratio": 0.8}),
    ranges={"ratio": (0.1, 1.0), "speed": (0.1, 10.0)},
)
def sideways_launch(ratio: float = 1.0, speed: float = 2.0) -> Scenario:
    """A block is pushed across a slope of 20 degrees whose friction would just hold it: it curves downhill.

    Friction acts against the velocity, not against the pull of gravity, so the block cannot keep
    its course; with µ = tan α it ends up sliding straight down at half its first speed.  A friction
    pyramid in place of the cone bends the path wrongly.  The block is not allowed to turn.
    """
    start = 0.5 * SIZE[2] * NORMAL
    turned = tuple(about(tuple(ACROSS.tolist()), SLOPE).tolist())
    block = Body("block", Box(SIZE), 2.0, tuple(start.tolist()), turned, velocity=(0.0, speed, 0.0))
    plane = Body("plane", HalfSpace(tuple(NORMAL.tolist())))
    scene = Scene((plane, block), (Gravity(), Friction(ratio * math.tan(SLOPE)), Resting()))

    change = (1.0 + ratio * math.sin(SLOPE)) * GRAVITY * STEP
    return Scenario(
        scene=scene,
        duration=DURATION,
        sampling=0.01,
        truth=curved(scene, speed, ratio),
        checks=(
            first_order("position error", change * DURATION / 2.0, "m", "(g + µ g cos α) t h/2"),
            first_order(
                "velocity error", change, "m/s", "(g + µ g cos α) h: what gravity and friction change in a step"
            ),
        ),
        source="v = v₀ tanʳ(φ/2)/sin φ, r = µ/tan α; after Irodov, Problems in General Physics, dynamics",
        about=(Gravity, Friction, Resting),
    )
