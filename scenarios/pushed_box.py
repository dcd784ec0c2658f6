"""A tall box is pushed, low down or high up."""

from __future__ import annotations

import numpy as np

from mechanics.effects import Force, Friction, Gravity, Resting, Rotation
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace
from mechanics.trajectory import Trajectory
from scenarios.because import PUSHED
from scenarios.motion import Motion, trajectory, vectors
from scenarios.scenario import Scenario, scenario
from scenarios.tilted_box import sliding_checks
from scenarios.tolerance import GRAVITY, STEP, first_order
from scenarios.toppling_box import HEIGHT, MASS, WIDTH

MU, DURATION = 0.3, 1.0


def thresholds(mu: float, at: float) -> tuple[float, float]:
    """Forces [N] at which the box slides, µ m g, and tips, m g b/(2 y), pushed at the height y = `at` [m]."""
    return mu * MASS * GRAVITY, 0.5 * MASS * GRAVITY * WIDTH / at


def height_where_both(mu: float) -> float:
    """Height [m] of a push by which the box begins to slide and to tip at once."""
    return 0.5 * WIDTH / mu


def stands(push: float, mu: float, at: float) -> bool:
    """Whether the pushed box does not tip, be it that it slides: the floor's force stays below its base."""
    grip = min(push, mu * MASS * GRAVITY)
    return push * (at - 0.5 * HEIGHT) + 0.5 * HEIGHT * grip <= 0.5 * WIDTH * MASS * GRAVITY


@scenario(
    tags=("friction", "resting", "box", "tipping"),
    suites=(),
    variants=({}, {"push": 55.0, "at": 0.7}),
    ranges={"push": (0.0, 1e3), "at": (0.01, 1.0)},
    because=PUSHED,
)
def pushed_box(push: float = 80.0, at: float = 0.3) -> Scenario:
    """A box of 0.4 m by 1 m is pushed by 80 N, 0.3 m above the floor, and slides upright; by 55 N higher up it stays.

    Friction 0.3 holds 58.9 N.  Pushed above 0.67 m it would rather tip, at 56 N at a height of 0.7 m.
    The floor's force moves forwards, almost to the edge, and the box must not begin to turn.
    """
    if not stands(push, MU, at):
        raise ValueError(f"pushed-box: push = {push:g} N at {at:g} m tips the box; allowed: less, or lower down")
    box = Body("box", Box((WIDTH, WIDTH, HEIGHT)), MASS, (0.0, 0.0, 0.5 * HEIGHT))
    hand = Force("box", (push, 0.0, 0.0), point=(-0.5 * WIDTH, 0.0, at - 0.5 * HEIGHT))
    scene = Scene((Body("floor", HalfSpace()), box), (Gravity(), Friction(MU), Resting(), Rotation(), hand))
    pull = max(0.0, push / MASS - MU * GRAVITY)

    def truth(t: np.ndarray) -> Trajectory:
        motion = Motion(vectors(t, x=0.5 * pull * t**2, z=0.5 * HEIGHT), vectors(t, x=pull * t))
        return trajectory(scene, t, {"box": motion})

    most = push / MASS + MU * GRAVITY
    return Scenario(
        scene=scene,
        duration=DURATION,
        sampling=0.01,
        truth=truth,
        checks=(
            first_order("position error", most * DURATION * STEP / 2.0, "m", "(F/m + µ g) t h/2"),
            first_order("velocity error", most * STEP, "m/s", "(F/m + µ g) h: one step's change"),
            *sliding_checks(0.0, MU, DURATION)[2:],
        ),
        source="slides if F > µ m g, tips if F > m g b/(2 y); Meriam and Kraige, Statics",
        about=(Gravity, Friction, Resting, Rotation, Force),
    )
