"""A block slides on a level floor until friction stops it."""

from __future__ import annotations

import math

import numpy as np

from mechanics.effects import Friction, Gravity, Resting
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace
from mechanics.trajectory import Trajectory
from scenarios.motion import Motion, trajectory
from scenarios.scenario import Scenario, scenario
from scenarios.tolerance import GRAVITY, STEP, first_order

SIZE = (0.4, 0.4, 0.1)  # [m]


@scenario(
    tags=("friction", "resting", "box"),
    suites=("smoke", "standard"),
    variants=({}, {"heading": 45.0}, {"heading": 30.0}, {"mu": 0.7}),
    ranges={"heading": (-180.0, 180.0), "mu": (0.01, 10.0), "speed": (0.01, 100.0)},
)
def sliding_block(heading: float = 0.0, mu: float = 0.35, speed: float = 5.0) -> Scenario:
    """A block sliding at 5 m/s on a level floor stops after v²/(2 µ g) = 3.6 m, in a straight line.

    Coulomb friction is the same in every direction; an engine that replaces its cone by a pyramid
    stops too early or veers off, most at 45 degrees to its axes.  The block is not allowed to turn,
    so that friction alone is tested: whether it would tip is another question.
    """
    along = np.array([math.cos(math.radians(heading)), math.sin(math.radians(heading)) if heading else 0.0, 0.0])
    start = (0.0, 0.0, SIZE[2] / 2.0)
    block = Body("block", Box(SIZE), mass=2.0, position=start, velocity=tuple((speed * along).tolist()))
    scene = Scene((Body("floor", HalfSpace()), block), (Gravity(), Friction(mu), Resting()))
    stop = speed / (mu * GRAVITY)

    def truth(t: np.ndarray) -> Trajectory:
        s = np.minimum(t, stop)[:, None]
        path = np.array(start) + along * (speed * s - 0.5 * mu * GRAVITY * s**2)
        return trajectory(scene, t, {"block": Motion(path, along * (speed - mu * GRAVITY * s))})

    brake = mu * GRAVITY * STEP
    return Scenario(
        scene=scene,
        duration=round(1.2 * stop, 2),
        sampling=0.01,
        truth=truth,
        checks=(
            first_order("position error", speed * STEP / 2.0, "m", "v h/2: the stop comes half a step early or late"),
            first_order("velocity error", brake, "m/s", "µ g h: friction sets in, or ends, up to a step late"),
            first_order("final velocity error", brake, "m/s", "µ g h: what friction changes in one step"),
        ),
        source="t = v/(µ g), d = v²/(2 µ g), straight; pyramids: Drumwright and Shell, WAFR 2010",
        about=(Gravity, Friction, Resting),
        events=(stop,),
    )
