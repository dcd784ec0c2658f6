"""A small ball slides off a big one."""

from __future__ import annotations

import math

import numpy as np

from mechanics.effects import Gravity, Resting
from mechanics.scene import Body, Scene
from mechanics.shapes import Sphere
from mechanics.trajectory import Trajectory
from scenarios.motion import Motion, trajectory, vectors
from scenarios.scenario import Scenario, scenario
from scenarios.swing import fall, fall_time
from scenarios.tolerance import GRAVITY, STEP, first_order

BIG, SMALL = 0.875, 0.125  # radii [m]; the centre goes round on a circle of 1 m
PATH = BIG + SMALL


def leaving_cosine(start: float, ratio: float = 0.0) -> float:
    """Cosine of the angle from the top at which a body let go at `start` [rad] loses contact.

    `ratio` is its moment of inertia over m r² if it rolls without slip, 0 if it slides: there the pull of gravity
    towards the centre, g cos ψ, no longer bends the path, v²/ρ with v² (1 + k)/2 = g ρ (cos ψ₀ - cos ψ).
    """
    return 2.0 * math.cos(start) / (3.0 + ratio)


def flight_to_centre(cosine: float) -> tuple[float, float]:
    """Speed [m/s] on leaving at that angle, and where the body comes down to the height of the centre [m]."""
    sine, speed = math.sqrt(1.0 - cosine**2), math.sqrt(GRAVITY * PATH * cosine)
    down = speed * sine
    time = (math.sqrt(down**2 + 2.0 * GRAVITY * PATH * cosine) - down) / GRAVITY
    return speed, PATH * sine + speed * cosine * time


@scenario(tags=("resting", "leaving"), suites=(), variants=({}, {"start": 10.0}), ranges={"start": (1.0, 80.0)})
def off_the_sphere(start: float = 30.0) -> Scenario:
    """A ball let go on a smooth fixed ball, 30 degrees from its top, slides down and flies off at 54.7 degrees.

    Contact must hold while the path presses the ball on, although the ball gets faster and faster, and
    must end by itself where cos ψ is 2/3 of what it was at the start; a contact that pulls carries it further.
    """
    begin, rate = math.radians(start), math.sqrt(GRAVITY / PATH)
    place = (PATH * math.sin(begin), 0.0, PATH * math.cos(begin))
    scene = Scene((Body("big", Sphere(BIG)), Body("small", Sphere(SMALL), 1.0, place)), (Gravity(), Resting()))
    cosine = leaving_cosine(begin)
    leaves, speed = fall_time(rate, begin, math.acos(cosine)), flight_to_centre(cosine)[0]
    duration = round(leaves + 0.2, 2)

    def truth(t: np.ndarray) -> Trajectory:
        on, flown = np.minimum(t, leaves), np.maximum(t - leaves, 0.0)
        angle, turn = fall(on, rate, begin)
        pace = PATH * turn
        x = PATH * np.sin(angle) + pace * np.cos(angle) * flown
        z = PATH * np.cos(angle) - pace * np.sin(angle) * flown - 0.5 * GRAVITY * flown**2
        v = vectors(t, x=pace * np.cos(angle), z=-pace * np.sin(angle) - GRAVITY * flown)
        return trajectory(scene, t, {"small": Motion(vectors(t, x=x, z=z), v)})

    fastest = speed + GRAVITY * (duration - leaves)
    return Scenario(
        scene=scene,
        duration=duration,
        sampling=0.01,
        truth=truth,
        checks=(
            first_order("position error", fastest * STEP, "m", "v h: a first-order scheme is a step early or late"),
            first_order("velocity error", GRAVITY * STEP, "m/s", "g h: what gravity changes in one step"),
        ),
        source="Kleppner and Kolenkow, An Introduction to Mechanics, ch. 4-6; the time by an elliptic integral",
        about=(Gravity, Resting),
        events=(leaves,),
    )
