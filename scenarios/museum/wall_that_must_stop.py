"""Exhibit 9: a ball and a thin wall."""

from __future__ import annotations

import numpy as np

from mechanics.effects import Restitution
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, Sphere
from mechanics.trajectory import Trajectory
from scenarios.exhibit import Exhibit, Remedy
from scenarios.motion import Motion, trajectory, vectors
from scenarios.scenario import Check, Scenario, scenario

RADIUS, THICK, WAY = 0.05, 0.02, 0.5  # [m]; WAY from the ball's surface to the wall's
EXHIBIT = Exhibit(
    number=9,
    title="The wall that refinement cannot save",
    shown="A ball flies at a wall of 2 cm, at eight phases of a step.  Where it passes between two steps, smaller "
    "steps help; where it pushes through a contact that is soft, they do not.  Both have a documented switch.",
    truth="The ball does not get to the other side.",
    figures={"passed through": 0.0},
    origin=("https://github.com/google-deepmind/mujoco/issues/441", "https://github.com/bulletphysics/bullet3/issues/2228"),
    remedies=(
        *(Remedy("mujoco:stock", f"a time step of {dt * 1e3:g} ms", "MuJoCo documentation, Modeling", {"dt": dt})
          for dt in (5e-4, 1e-4)),
        Remedy("mujoco:speculative", "flag speculative = enable", "MuJoCo documentation, XML reference: option/flag"),
        Remedy("pybullet:ccd", "ccdSweptSphereRadius, in maximal coordinates",
               "PyBullet Quickstart Guide, changeDynamics"),
        Remedy("pymunk:stock", "a time step of 1 ms", "pymunk documentation, Space.step", {"dt": 1e-3}),
    ),
)  # fmt: skip


@scenario(
    tags=("museum", "impact", "tunnelling"),
    suites=("museum",),
    variants=({}, {"speed": 100.0}),
    ranges={"speed": (1.0, 1000.0)},
)
def wall_that_must_stop(speed: float = 10.0) -> Scenario:
    """A ball of 10 cm flies at 10 or 100 m/s (`speed`) at a wall of 2 cm and must stop there.

    There is no gravity and no rebound (e = 0).  In a step of 1/60 s the ball moves seventeen times the thickness of
    the wall, so whether it is seen to touch it is luck, unless the engine looks along the path.
    """
    wall = Body("wall", Box((THICK, 2.0, 2.0)), None, (RADIUS + WAY + 0.5 * THICK, 0.0, 0.0))
    scene = Scene((wall, Body("ball", Sphere(RADIUS), 1.0, velocity=(speed, 0.0, 0.0))), (Restitution(0.0),))
    stop = WAY / speed

    def truth(t: np.ndarray) -> Trajectory:
        flown = Motion(vectors(t, x=np.minimum(speed * t, WAY)), vectors(t, x=np.where(t < stop, speed, 0.0)))
        return trajectory(scene, t, {"ball": flown})

    return Scenario(
        scene=scene,
        duration=round(4.0 * stop, 6),
        sampling=round(0.1 * stop, 6),
        truth=truth,
        checks=(Check("passed through", 0.5, "none may pass; how far it rebounds is another question"),),
        source="a rigid wall: u⁺ = -e u⁻ with e = 0 (Newton)",
        about=(Restitution,),
        events=(stop,),
        exhibit=EXHIBIT,
    )
