"""A box on a plate that accelerates up or down."""

from __future__ import annotations

import numpy as np

from mechanics.effects import Gravity, Resting
from mechanics.scene import Body, Scene
from mechanics.shapes import Box
from mechanics.trajectory import Trajectory
from scenarios.because import CARRIED
from scenarios.motion import Motion, trajectory, vectors
from scenarios.scenario import Scenario, scenario
from scenarios.tolerance import GRAVITY, STEP, first_order

SIZE, PLATE = (0.25, 0.25, 0.25), (1.0, 1.0, 0.25)  # [m]; binary fractions: the box touches the plate bit by bit
DURATION = 0.5  # [s]


@scenario(
    tags=("resting", "moving-support", "leaving"),
    suites=(),
    variants=({}, {"acceleration": -15.0}, {"acceleration": 5.0}),
    ranges={"acceleration": (-100.0, 100.0)},
    because=CARRIED,
)
def moving_support(acceleration: float = -5.0) -> Scenario:
    """A box lies on a plate that starts to move downwards by 5 m/s², by 15 m/s², or upwards.

    As long as the plate falls more slowly than gravity would have it, the box goes along; a plate that
    accelerates by more than g drops away, and the box falls freely above it.  The plate's motion is prescribed.
    """
    plate = Body("plate", Box(PLATE), acceleration=(0.0, 0.0, acceleration))
    height = 0.5 * (PLATE[2] + SIZE[2])
    box = Body("box", Box(SIZE), 1.0, (0.0, 0.0, height))
    scene = Scene((plate, box), (Gravity(), Resting()))
    pull = max(acceleration, -GRAVITY)

    def truth(t: np.ndarray) -> Trajectory:
        motion = Motion(vectors(t, z=height + 0.5 * pull * t**2), vectors(t, z=pull * t))
        return trajectory(scene, t, {"box": motion})

    most = max(abs(acceleration), GRAVITY)
    return Scenario(
        scene=scene,
        duration=DURATION,
        sampling=0.01,
        truth=truth,
        checks=(
            first_order("position error", most * DURATION * STEP / 2.0, "m", "a t h/2 of semi-implicit Euler"),
            first_order("velocity error", most * STEP, "m/s", "a h: contact ends, or acts, a step late"),
        ),
        source="contact lasts while the support accelerates above -g; Luck and Mehta, Phys. Rev. E 48 (1993) 3988",
        about=(Gravity, Resting),
    )
