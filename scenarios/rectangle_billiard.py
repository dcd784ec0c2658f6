"""A ball in a rectangular box without gravity."""

from __future__ import annotations

import math

import numpy as np

from mechanics.effects import Restitution
from mechanics.scene import Body, Scene
from mechanics.shapes import HalfSpace, Sphere
from mechanics.trajectory import Trajectory
from scenarios.motion import Motion, trajectory, vectors
from scenarios.scenario import Scenario, scenario
from scenarios.tolerance import STEP, first_order, rounding

RADIUS = 0.1  # [m]
WIDTH, HEIGHT = 1.7, 1.0  # [m], of the room the centre has
START, VELOCITY = (0.4, 0.3), (1.9, 1.3 * math.sqrt(2.0))  # [m], [m/s]


def back_and_forth(t: np.ndarray, length: float, start: float, speed: float) -> tuple[np.ndarray, np.ndarray]:
    """Place in 0..length and velocity of a point that is reflected at both ends: uniform motion, folded."""
    lap, place = np.divmod(start + speed * t, length)
    back = lap % 2.0 == 1.0
    return np.where(back, length - place, place), np.where(back, -speed, speed)


def turns(length: float, start: float, speed: float, until: float) -> np.ndarray:
    """Times up to `until` [s] at which that point is reflected."""
    laps = np.arange(1, math.floor((start + speed * until) / length) + 1)
    return (laps * length - start) / speed


@scenario(tags=("impact", "walls"), suites=(), variants=({}, {"duration": 97.3}), ranges={"duration": (1.0, 1e4)})
def rectangle_billiard(duration: float = 10.0) -> Scenario:
    """An elastic ball flies about in a box, and nothing else acts: 29 impacts in 10 s, 287 in 97.3 s.

    The two directions know nothing of each other: each is a uniform motion folded into its range.  The
    speed in each must stay what it is for ever, and what an engine gets wrong at an impact adds up.
    """
    walls = (
        Body("left", HalfSpace((1.0, 0.0, 0.0)), position=(-RADIUS, 0.0, 0.0)),
        Body("right", HalfSpace((-1.0, 0.0, 0.0)), position=(WIDTH + RADIUS, 0.0, 0.0)),
        Body("bottom", HalfSpace((0.0, 0.0, 1.0)), position=(0.0, 0.0, -RADIUS)),
        Body("top", HalfSpace((0.0, 0.0, -1.0)), position=(0.0, 0.0, HEIGHT + RADIUS)),
    )
    ball = Body("ball", Sphere(RADIUS), 1.0, (START[0], 0.0, START[1]), velocity=(VELOCITY[0], 0.0, VELOCITY[1]))
    scene = Scene((*walls, ball), (Restitution(1.0),))
    sides = ((WIDTH, START[0], VELOCITY[0]), (HEIGHT, START[1], VELOCITY[1]))

    def truth(t: np.ndarray) -> Trajectory:
        (x, u), (z, w) = (back_and_forth(t, *side) for side in sides)
        return trajectory(scene, t, {"ball": Motion(vectors(t, x=x, z=z), vectors(t, x=u, z=w))})

    times = [turns(*side, duration) for side in sides]
    late = sum(2.0 * len(at) * side[2] for at, side in zip(times, sides, strict=True)) * STEP
    return Scenario(
        scene=scene,
        duration=duration,
        sampling=duration / 500.0,
        truth=truth,
        checks=(
            first_order("position error", late, "m", "Σ 2 v h: every impact is seen up to one step late"),
            rounding("energy error", "an elastic impact with a wall keeps the speed"),
        ),
        source="unfolding; Tabachnikov, Geometry and Billiards, ch. 1-2",
        about=(Restitution,),
        events=tuple(np.sort(np.concatenate(times)).tolist()),
    )
