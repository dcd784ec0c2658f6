"""Exhibit 1: bodies that fall in a vacuum and stop getting faster."""

from __future__ import annotations

import numpy as np

from mechanics.effects import Gravity
from mechanics.scene import Body, Scene
from mechanics.shapes import Sphere
from mechanics.trajectory import Trajectory
from scenarios.exhibit import Exhibit, Remedy
from scenarios.motion import Motion, trajectory, vectors
from scenarios.scenario import Check, Scenario, scenario
from scenarios.tolerance import GRAVITY

DURATION = 8.0  # [s]
EXHIBIT = Exhibit(
    number=1,
    title="The vacuum with a speed limit",
    shown="A ball falls, and nothing else acts.  An engine with damping on by default has a terminal speed; users met "
    "it as a reduced-coordinate solver that disagrees with theory, and as robots that float as if in water.",
    truth="Without air v = g t, whatever the body.",
    figures={"final speed": GRAVITY * DURATION},
    origin=(
        "https://github.com/bulletphysics/bullet3/issues/4636",
        "https://github.com/bulletphysics/bullet3/issues/1460",
        "https://github.com/bulletphysics/bullet3/issues/1459",
    ),
    remedies=(
        Remedy("pybullet:undamped", "linearDamping = angularDamping = 0", "PyBullet Quickstart Guide, changeDynamics"),
    ),
)


@scenario(tags=("museum", "flight"), suites=("museum",))
def vacuum_with_a_speed_limit() -> Scenario:
    """A ball falls for eight seconds in a vacuum and must be as fast as gravity makes it.

    Many engines damp velocities unless they are told not to: harmless in a game, fatal to a comparison with
    theory, and easily mistaken for an error of the solver.
    """
    scene = Scene((Body("ball", Sphere(0.1), 1.0),), (Gravity(),))

    def truth(t: np.ndarray) -> Trajectory:
        fall = Motion(vectors(t, z=-0.5 * GRAVITY * t**2), vectors(t, z=-GRAVITY * t))
        return trajectory(scene, t, {"ball": fall})

    return Scenario(
        scene=scene,
        duration=DURATION,
        sampling=0.1,
        truth=truth,
        checks=(
            Check("final velocity error", 1e-3 * GRAVITY * DURATION, "0.1 % of the speed, which no stepping takes"),
        ),
        source="Galilei, Discorsi (1638): v = g t",
        about=(Gravity,),
        exhibit=EXHIBIT,
    )
