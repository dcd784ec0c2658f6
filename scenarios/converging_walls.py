"""A ball between a wall and another that closes in."""

from __future__ import annotations

import numpy as np

from mechanics.effects import Restitution
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Sphere
from mechanics.trajectory import Trajectory
from scenarios.motion import Motion, trajectory, vectors
from scenarios.scenario import Scenario, scenario
from scenarios.tolerance import STEP, converged, first_order

RADIUS, THICK, DISTANCE = 0.125, 0.25, 2.0  # [m]; binary fractions: the ball touches the wall bit by bit
APPROACH, SPEED = 0.5, 3.0  # [m/s]


def hits(count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Places [m] and times [s] of the first `count` impacts on the moving wall, and the speeds after them [m/s]."""
    n = np.arange(1, count + 1)
    places = DISTANCE * SPEED / (SPEED + (2 * n - 1) * APPROACH)
    return places, (DISTANCE - places) / APPROACH, SPEED + 2 * n * APPROACH


@scenario(tags=("impact", "walls", "moving-support"), suites=(), ranges={"count": (1, 20)})
def converging_walls(count: int = 5) -> Scenario:
    """An elastic ball goes back and forth between a wall and another that approaches at 0.5 m/s.

    Each impact on the moving wall makes the ball faster by twice the wall's speed: 4, 5, 6, 7, 8 m/s.
    The energy comes from the wall, whose motion is prescribed; an engine that ignores the
    velocity of a driven body in the impact sees an energy that does not change.
    """
    places, times, speeds = hits(count)
    returns = times + places / speeds  # to the wall that stands
    wall = Body("wall", HalfSpace((1.0, 0.0, 0.0)))
    face = 2.0 * RADIUS + DISTANCE + 0.5 * THICK
    piston = Body("piston", Box((THICK, 1.0, 1.0)), position=(face, 0.0, 0.0), velocity=(-APPROACH, 0.0, 0.0))
    ball = Body("ball", Sphere(RADIUS), 1.0, (RADIUS, 0.0, 0.0), velocity=(SPEED, 0.0, 0.0))
    scene = Scene((wall, piston, ball), (Restitution(1.0),))
    knots = np.append(0.0, np.stack([times, returns], axis=1).ravel())
    corners = np.append(0.0, np.stack([places, 0.0 * places], axis=1).ravel())
    pace = np.append(SPEED, np.stack([-speeds, speeds], axis=1).ravel())

    def truth(t: np.ndarray) -> Trajectory:
        n = np.searchsorted(knots, t, side="right") - 1
        x = RADIUS + corners[n] + pace[n] * (t - knots[n])
        return trajectory(scene, t, {"ball": Motion(vectors(t, x=x), vectors(t, x=pace[n]))})

    jumps = float(np.abs(np.diff(pace[:-1])).sum())
    return Scenario(
        scene=scene,
        duration=round(0.5 * float(times[-1] + returns[-1]), 3),
        sampling=0.01,
        truth=truth,
        checks=(
            first_order("position error", jumps * STEP, "m", "Σ |Δv| h: every impact is seen up to one step late"),
            converged("velocity error", SPEED, "the ball's first speed in m/s"),
        ),
        source="x_n = L v/(v + (2n - 1) u), v_n = v + 2 n u; Landau and Lifshitz, Mechanics, §49",
        about=(Restitution,),
        events=tuple(knots[1:-1].tolist()),
        guard=2.0 * len(knots) * STEP,
    )
