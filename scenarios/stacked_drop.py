"""A small ball dropped on top of a big one."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from mechanics.effects import Gravity, Restitution
from mechanics.scene import Body, Scene
from mechanics.shapes import HalfSpace, Sphere
from mechanics.trajectory import Trajectory
from scenarios.bouncing_ball import delay
from scenarios.head_on_collision import after_collision
from scenarios.motion import Motion, trajectory, vectors
from scenarios.scenario import Check, Scenario, scenario
from scenarios.tolerance import GRAVITY, STEP, first_order

BIG, SMALL, BIG_RADIUS, SMALL_RADIUS = 1.0, 0.01, 0.2, 0.05  # [kg], [kg], [m], [m]
HEIGHT, FLOOR, BALLS = 1.0, 0.9, 0.8  # clearance of the big ball [m], restitution at the floor and between the balls


class Launch(NamedTuple):
    """What the two balls do."""

    lands: float  # the big one, at this time [s]
    meets: float  # the small one, at this time [s]
    big: float  # velocity just after [m/s]
    small: float


def launched(gap: float) -> Launch:
    """Motion of the balls dropped with `gap` [m] between them: the floor first, then each other."""
    lands, speed = math.sqrt(2.0 * HEIGHT / GRAVITY), math.sqrt(2.0 * GRAVITY * HEIGHT)
    wait = gap / ((1.0 + FLOOR) * speed)  # gravity does not change the speed at which they approach
    up, down = FLOOR * speed - GRAVITY * wait, -speed - GRAVITY * wait
    return Launch(lands, lands + wait, *after_collision(BIG, SMALL, up, down, BALLS))


def falling(t: np.ndarray, height: float, knots: tuple[tuple[float, float], ...]) -> Motion:
    """Fall from rest at `height` [m], with a new velocity (time [s], velocity [m/s]) at each of `knots`."""
    z, v = height - 0.5 * GRAVITY * t**2, -GRAVITY * t
    begin, speed = 0.0, 0.0
    for at, after in knots:
        height += speed * (at - begin) - 0.5 * GRAVITY * (at - begin) ** 2
        begin, speed, since = at, after, t - at
        z = np.where(since >= 0.0, height + speed * since - 0.5 * GRAVITY * since**2, z)
        v = np.where(since >= 0.0, speed - GRAVITY * since, v)
    return Motion(vectors(t, z=z), vectors(t, z=v))


@scenario(tags=("impact", "mass-ratio"), suites=(), variants=({}, {"gap": 0.2}), ranges={"gap": (1e-6, 0.5)})
def stacked_drop(gap: float = 0.05) -> Scenario:
    """A ball of 10 g dropped on top of one of 1 kg is shot up to almost six times the height it came from.

    The big ball bounces first and meets the small one, which is still falling, at nearly twice the speed
    (Galilean cannon).  With a gap of 5 cm between them the two impacts are 6 ms apart.
    """
    resting = BIG_RADIUS + HEIGHT
    big = Body("big", Sphere(BIG_RADIUS), BIG, (0.0, 0.0, resting))
    top = resting + BIG_RADIUS + gap + SMALL_RADIUS
    small = Body("small", Sphere(SMALL_RADIUS), SMALL, (0.0, 0.0, top))
    bounce = Restitution(FLOOR, {("big", "small"): BALLS})
    scene = Scene((Body("floor", HalfSpace()), big, small), (Gravity(), bounce))
    shot = launched(gap)
    speed = math.sqrt(2.0 * GRAVITY * HEIGHT)
    duration = round(shot.meets + 0.7, 3)

    def truth(t: np.ndarray) -> Trajectory:
        bounces = ((shot.lands, FLOOR * speed), (shot.meets, shot.big))
        ball, shell = falling(t, resting, bounces), falling(t, top, ((shot.meets, shot.small),))
        return trajectory(scene, t, {"big": ball, "small": shell})

    return Scenario(
        scene=scene,
        duration=duration,
        sampling=0.01,
        truth=truth,
        checks=_checks(shot.small + speed, duration),
        source="Harter, Am. J. Phys. 39 (1971) 656; Mellen, Am. J. Phys. 36 (1968) 845",
        about=(Gravity, Restitution),
        events=(shot.lands, shot.meets),
        guard=0.01,
    )


def _checks(jump: float, duration: float) -> tuple[Check, ...]:
    """The floor is seen late, and then the other ball; what that changes of a speed, the second impact enlarges."""
    late = delay(FLOOR) + STEP
    change = (1.0 + BALLS) * GRAVITY * late
    return (
        first_order(
            "position error",
            GRAVITY * duration * STEP / 2.0 + jump * late + change * duration,
            "m",
            f"g t h/2, |Δv| times the delay of two impacts by {late / STEP:.2g} h, and the speed that changes, times t",
        ),
        first_order("velocity error", change, "m/s", "(1 + e) g times the delay of the two impacts"),
    )
