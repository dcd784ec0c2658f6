"""A box falls flat on a floor: several contacts at once."""

from __future__ import annotations

import math

import numpy as np

from mechanics.effects import Gravity, Restitution, Rotation
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace
from mechanics.trajectory import Trajectory
from scenarios.because import UNTURNED
from scenarios.bouncing_ball import bounce, bounce_checks, delay, impact_times
from scenarios.motion import Motion, trajectory, vectors
from scenarios.scenario import Scenario, scenario
from scenarios.tolerance import GRAVITY, converged

SIZE = (1.0, 0.5, 0.5)  # [m]
CLEARANCE = 0.2  # [m]


@scenario(
    tags=("impact", "simultaneous", "box"),
    variants=({}, {"e": 1.0}, {"e": 0.8}),
    ranges={"e": (0.3, 1.0)},
    because=UNTURNED,
)
def flat_drop(e: float = 0.5) -> Scenario:
    """A box dropped flat from 0.2 m lands on four corners at once and must come back up without turning.

    Nothing in the scene tells left from right, so neither may the answer; an engine that treats one
    corner after the other sets the box spinning at up to 1.8 rad/s.
    """
    floor = Body("floor", HalfSpace())
    half = SIZE[2] / 2.0
    box = Body("box", Box(SIZE), mass=1.0, position=(0.0, 0.0, half + CLEARANCE))
    scene = Scene((floor, box), (Gravity(), Restitution(e), Rotation()))
    speed = math.sqrt(2.0 * GRAVITY * CLEARANCE)
    first = float(impact_times(CLEARANCE, e, 0.0)[0])
    duration = round(first + speed * e / GRAVITY, 3)

    def truth(t: np.ndarray) -> Trajectory:
        gap, rise = bounce(t, CLEARANCE, e)
        return trajectory(scene, t, {"box": Motion(vectors(t, z=half + gap), vectors(t, z=rise))})

    spin = speed / (SIZE[0] / 2.0)
    return Scenario(
        scene=scene,
        duration=duration,
        sampling=0.01,
        truth=truth,
        checks=(
            *bounce_checks(CLEARANCE, e, 1, duration),
            converged("angular velocity error", spin, "the approach speed over half the box's length in rad/s"),
            converged("orientation error", spin * (duration - first), "that spin times the time left, in rad"),
        ),
        source="mirror symmetry and Newton's law; Smith et al., Reflections on simultaneous impact, SIGGRAPH 2012",
        about=(Gravity, Restitution, Rotation),
        events=(first,),
        guard=2.0 * delay(e),
    )
