"""A ball flies until its string is taut."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from mechanics.effects import Tether
from mechanics.scene import Body, Scene
from mechanics.shapes import Sphere
from mechanics.trajectory import Trajectory
from scenarios.motion import Motion, trajectory, vectors
from scenarios.scenario import Scenario, Truth, scenario
from scenarios.tolerance import STEP, first_order

LENGTH, MASS = 2.0, 1.0  # [m], [kg]
START, VELOCITY = np.array([1.2, 0.0]), np.array([0.5, 1.5])  # along x and z [m], [m/s]


class Taut(NamedTuple):
    """The string goes taut."""

    time: float  # [s]
    place: np.ndarray  # (2,) [m]
    velocity: np.ndarray  # (2,) just after [m/s]
    impulse: float  # [N s]


def taut(e: float) -> Taut:
    """When and where the string goes taut; there the velocity along it, v_r, turns to -e v_r."""
    inward, square = float(START @ VELOCITY), float(VELOCITY @ VELOCITY)
    time = (-inward + math.sqrt(inward**2 + square * (LENGTH**2 - float(START @ START)))) / square
    place = START + time * VELOCITY
    out = place / LENGTH
    pull = (1.0 + e) * MASS * float(out @ VELOCITY)
    return Taut(time, place, VELOCITY - pull / MASS * out, pull)


def held(scene: Scene, e: float) -> Truth:
    """Straight up to the jerk; then round in a circle if e = 0, else straight on."""
    jerk = taut(e)

    def truth(t: np.ndarray) -> Trajectory:
        flown, after, hit = np.minimum(t, jerk.time), np.maximum(t - jerk.time, 0.0)[:, None], t >= jerk.time
        x = START + flown[:, None] * VELOCITY + after * jerk.velocity
        v = np.where(hit[:, None], jerk.velocity, VELOCITY)
        if e == 0.0:
            ahead = np.array([-jerk.place[1], jerk.place[0]]) / LENGTH  # a quarter turn on
            speed = float(ahead @ jerk.velocity)
            turn = speed / LENGTH * after
            x = np.where(hit[:, None], np.cos(turn) * jerk.place + LENGTH * np.sin(turn) * ahead, x)
            v = np.where(hit[:, None], speed * (np.cos(turn) * ahead - np.sin(turn) * jerk.place / LENGTH), v)
        return trajectory(
            scene, t, {"ball": Motion(vectors(t, x[:, 0], 0.0, x[:, 1]), vectors(t, v[:, 0], 0.0, v[:, 1]))}
        )

    return truth


@scenario(tags=("joint", "tether"), suites=(), variants=({}, {"e": 0.5}), ranges={"e": (0.0, 1.0)})
def tethered_ball(e: float = 0.0) -> Scenario:
    """A ball on a slack string flies straight until the string is taut, and then round in a circle.

    A string can pull and not push.  The jerk takes the velocity along it, or turns it round where the string has
    restitution, and leaves the rest.  No gravity: the circle is uniform and the string stays taut by itself.
    """
    post = Body("post", Sphere(0.02))
    ball = Body("ball", Sphere(0.05), MASS, (START[0], 0.0, START[1]), velocity=(VELOCITY[0], 0.0, VELOCITY[1]))
    scene = Scene((post, ball), (Tether("post", "ball", LENGTH, restitution=e),))
    jerk = taut(e)
    jump, speed = jerk.impulse / MASS, float(np.linalg.norm(VELOCITY))
    duration = 3.0 if e == 0.0 else 1.5
    return Scenario(
        scene=scene,
        duration=duration,
        sampling=0.01,
        truth=held(scene, e),
        checks=(
            first_order("position error", (jump + speed) * STEP, "m", "|Δv| h + v h: the jerk comes up to a step late"),
            first_order(
                "velocity error", 2.0 * speed**2 / LENGTH * STEP, "m/s", "2 v²/l h: meanwhile the string turns"
            ),
        ),
        source="t from |r + v t| = l, impulse (1 + e) m v_r; Goldsmith, Impact, ch. 2",
        about=(Tether,),
        events=(jerk.time,),
    )
