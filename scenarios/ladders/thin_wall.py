"""Balls against a thin wall."""

from __future__ import annotations

import math

import numpy as np

from mechanics.effects import Resting, Restitution
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, Sphere
from mechanics.trajectory import Trajectory
from scenarios.because import STUCK
from scenarios.ladder import STABLE, Ladder
from scenarios.motion import Motion, trajectory, vectors
from scenarios.scenario import Scenario, scenario

RADIUS, THICKNESS = 0.05, 0.02  # [m]
BALLS = 8  # each meets the wall at another fraction of a time step
FLIGHT, SPREAD = 0.1, 1.0 / 60.0  # [s] before the first ball arrives, and until the last one has: the longest step


@scenario(tags=("ladder", "impact", "tunnelling"), suites=(), ranges={"speed": (1e-3, 1e5)}, because=STUCK)
def thin_wall(speed: float = 1.0) -> Scenario:
    """Eight balls of 10 cm fly at a wall 2 cm thick, each arriving at another fraction of a step.  None may pass.

    Whether a ball is seen in the wall is a matter of luck once it flies farther in a step than wall and ball are
    thick; contacts that give way let it through at any step.  Only that is asked, not how the balls come off.
    """
    wait = FLIGHT + SPREAD * (np.arange(BALLS) * 0.5 * (math.sqrt(5.0) - 1.0) % 1.0)
    face = -0.5 * THICKNESS - RADIUS
    place = [(face - speed * float(w), 0.0, 0.25 * k) for k, w in enumerate(wait)]
    balls = [Body(f"ball-{k + 1}", Sphere(RADIUS), 1.0, x, velocity=(speed, 0.0, 0.0)) for k, x in enumerate(place)]
    wall = Body("wall", Box((THICKNESS, 1.0, 4.0)), position=(0.0, 0.0, 1.0))
    scene = Scene((wall, *balls), (Restitution(0.0), Resting()))

    def truth(t: np.ndarray) -> Trajectory:
        motions = {}
        for ball, until in zip(balls, wait, strict=True):
            x, y, z = ball.position
            path = vectors(t, x=x + speed * np.minimum(t, until), y=y, z=z)
            motions[ball.name] = Motion(path, vectors(t, x=np.where(t < until, speed, 0.0)))
        return trajectory(scene, t, motions)

    return Scenario(
        scene=scene,
        duration=2.0 * FLIGHT,
        sampling=0.05 * FLIGHT,
        truth=truth,
        checks=(STABLE,),
        source="impenetrability; walls of Ericson, Real-Time Collision Detection (2005), §5.5",
        about=(Restitution,),
        events=tuple(sorted(wait.tolist())),
    )


LADDERS = (
    Ladder("wall-speed", "speed of a 10 cm ball at a wall of 2 cm", "m/s", "thin-wall",
           (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000), "speed"),
)  # fmt: skip
