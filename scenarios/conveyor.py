"""A box set down on a conveyor belt."""

from __future__ import annotations

import numpy as np

from mechanics.effects import Friction, Gravity, Resting
from mechanics.scene import Body, Scene
from mechanics.shapes import Box
from mechanics.trajectory import Trajectory
from scenarios.motion import Motion, trajectory, vectors
from scenarios.scenario import Scenario, scenario
from scenarios.tolerance import GRAVITY, STEP, first_order

SIZE, BELT = (0.25, 0.25, 0.125), (20.0, 1.0, 0.25)  # [m]; binary fractions: the box touches the belt bit by bit


def carried(belt: float, mu: float) -> tuple[float, float]:
    """Time [s] until the box moves with the `belt` [m/s], u/(µ g), and how far it has skidded on it, u²/(2 µ g) [m]."""
    return belt / (mu * GRAVITY), belt**2 / (2.0 * mu * GRAVITY)


@scenario(
    tags=("friction", "resting", "moving-support"),
    suites=(),
    variants=({}, {"belt": -1.0, "mu": 0.5}),
    ranges={"belt": (-10.0, 10.0), "mu": (0.01, 10.0)},
)
def conveyor(belt: float = 2.0, mu: float = 0.3) -> Scenario:
    """A box at rest is set down on a belt that moves at 2 m/s: it skids 0.68 m and then rides along.

    Friction drags it by µ g until both move alike, and vanishes.  The belt is a fixed body with a
    velocity; what matters to friction is the velocity of one surface against the other.
    """
    moving = Body("belt", Box(BELT), velocity=(belt, 0.0, 0.0))
    height = 0.5 * (BELT[2] + SIZE[2])
    box = Body("box", Box(SIZE), 1.0, (0.0, 0.0, height))
    scene = Scene((moving, box), (Gravity(), Friction(mu), Resting()))
    grips = carried(abs(belt), mu)[0]
    drag = np.copysign(mu * GRAVITY, belt)

    def truth(t: np.ndarray) -> Trajectory:
        s, rest = np.minimum(t, grips), np.maximum(t - grips, 0.0)
        x = vectors(t, x=0.5 * drag * s**2 + belt * rest, z=height)
        return trajectory(scene, t, {"box": Motion(x, vectors(t, x=drag * s))})

    brake, duration = mu * GRAVITY * STEP, round(grips + 0.5, 2)
    return Scenario(
        scene=scene,
        duration=duration,
        sampling=0.01,
        truth=truth,
        checks=(
            first_order(
                "position error", brake * duration, "m", "µ g h t: friction sets in, or ends, up to a step late"
            ),
            first_order("velocity error", brake, "m/s", "µ g h: what friction changes in one step"),
        ),
        source="t = u/(µ g), skid u²/(2 µ g): the block of Coulomb friction in the frame of the belt",
        about=(Gravity, Friction, Resting),
        events=(grips,),
    )
