"""A heavy block pushes a light one against a wall: collisions that count the digits of π."""

from __future__ import annotations

import math

import numpy as np

from mechanics.effects import Restitution
from mechanics.scene import Body, Scene
from mechanics.shapes import HalfSpace, Sphere
from mechanics.trajectory import Trajectory
from scenarios.motion import Motion, trajectory, vectors
from scenarios.scenario import Scenario, Truth, scenario
from scenarios.tolerance import STEP, converged, first_order
from scenarios.wedge_billiard import in_wedge, reflections

RADIUS, SPEED, LIGHT, HEAVY = 0.05, 1.0, 1.0, 2.0  # [m], [m/s], distances of the blocks from the wall [m]


def counted(scene: Scene, root: float, wedge: float, start: tuple[float, float]) -> Truth:
    """Motion of both blocks, which scaled by the roots of the masses, 1 and `root`, are one point in a wedge."""

    def truth(t: np.ndarray) -> Trajectory:
        path = in_wedge(t, wedge, start, root * SPEED)
        far, near = path.x.T / [[root], [1.0]]
        away, pace = path.v.T / [[root], [1.0]]
        light = Motion(vectors(t, x=RADIUS + near), vectors(t, x=pace))
        heavy = Motion(vectors(t, x=3.0 * RADIUS + far), vectors(t, x=away))
        return trajectory(scene, t, {"light": light, "heavy": heavy})

    return truth


@scenario(
    tags=("impact", "mass-ratio", "hard"),
    suites=(),
    variants=({}, {"digits": 0}, {"digits": 2}),
    ranges={"digits": (0, 3)},
)
def galperin_blocks(digits: int = 1) -> Scenario:
    """A block of 1, 100 or 10 000 kg slides towards one of 1 kg that stands before a wall: 3, 31 or 314 collisions.

    All impacts are elastic.  Scaled by the roots of the masses, the two positions are one point in a wedge
    of angle atan √(m/M), whose reflections can be counted: the first digits of π.  The last collisions
    follow each other within far less than a time step, and one that is missed or doubled spoils the rest.
    """
    root = 10.0**digits  # √(M/m)
    wall = Body("wall", HalfSpace((1.0, 0.0, 0.0)))
    light = Body("light", Sphere(RADIUS), 1.0, (RADIUS + LIGHT, 0.0, 0.0))
    heavy = Body("heavy", Sphere(RADIUS), root**2, (3.0 * RADIUS + HEAVY, 0.0, 0.0), velocity=(-SPEED, 0.0, 0.0))
    scene = Scene((wall, light, heavy), (Restitution(1.0),))
    wedge, start = math.atan(1.0 / root), (root * HEAVY, LIGHT)
    times = reflections(wedge, start, root * SPEED)

    between = 0.5 * (np.append(0.0, times) + np.append(times, times[-1] + 1.0))
    jumps = float(np.abs(np.diff(in_wedge(between, wedge, start, root * SPEED).v[:, 1])).sum())
    return Scenario(
        scene=scene,
        duration=round(float(times[-1]) + 0.5, 2),
        sampling=0.02,
        truth=counted(scene, root, wedge, start),
        checks=(
            first_order("position error", jumps * STEP, "m", "Σ |Δv| h: every impact a step late"),
            converged("final velocity error", root * SPEED, "the largest speed the light block can reach in m/s"),
            converged("energy error", 1.0, "the energy, as a ratio"),
        ),
        source="Galperin, Regul. Chaotic Dyn. 8 (2003) 375",
        about=(Restitution,),
        events=tuple(times.tolist()),
        guard=0.02,
    )
