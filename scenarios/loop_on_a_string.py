"""A bob on a string loops the loop, or does not."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from mechanics.effects import Gravity, Tether
from mechanics.scene import Body, Scene
from mechanics.shapes import Sphere
from mechanics.trajectory import Trajectory
from scenarios.motion import Motion, trajectory, vectors
from scenarios.scenario import Scenario, scenario
from scenarios.swing import whirl, whirl_time
from scenarios.tolerance import GRAVITY, STEP, first_order

RADIUS = 0.45  # of the loop [m]


class Slack(NamedTuple):
    """The track, or string, lets go."""

    cosine: float  # of the angle from the lowest point
    speed: float  # [m/s]


def least_height(ratio: float = 0.0) -> float:
    """Height [m] from which the loop is just completed: v² = g ρ at the top.

    `ratio` is the moment of inertia over m r² of a body that rolls on a track, 0 if it slides or hangs on a string.
    """
    return RADIUS * (2.0 + 0.5 * (1.0 + ratio))


def lets_go(height: float, ratio: float = 0.0) -> Slack:
    """Where a body that comes from a height [m] above the lowest point, less than `least_height`, leaves the circle."""
    cosine = -2.0 * (height / RADIUS - 1.0) / (3.0 + ratio)
    return Slack(cosine, math.sqrt(-GRAVITY * RADIUS * cosine))


def pull_at_the_bottom(height: float, ratio: float = 0.0) -> float:
    """Force of the track, or string, at the lowest point over the weight."""
    return 1.0 + 2.0 * height / (RADIUS * (1.0 + ratio))


def times(height: float, rate: float, spin: float) -> tuple[float, float]:
    """When the bob leaves the circle, if it does, and when the string is almost taut again, or one turn is done."""
    if height >= least_height():
        return math.inf, 2.0 * whirl_time(rate, spin, math.pi)
    cosine, speed = lets_go(height)
    leaves = whirl_time(rate, spin, math.acos(cosine))
    # |r| = ρ again when g v_z t³ = g² t⁴/4: the parabola hugs the circle where it begins
    return leaves, leaves + 3.9 * speed * math.sqrt(1.0 - cosine**2) / GRAVITY


@scenario(
    tags=("joint", "tether", "leaving"), suites=(), variants=({}, {"height": 1.2}), ranges={"height": (0.47, 3.0)}
)
def loop_on_a_string(height: float = 0.9) -> Scenario:
    """A bob on a string is sent round a loop with the speed of a fall from 0.9 m: the string goes slack on the way up.

    It is the loop-the-loop with a string for the track: both can only hold one way.  From less than 2.5 radii
    the bob leaves the circle before the top and flies; from more it goes round.  The scene ends before the
    string is taut again, or after one turn.
    """
    spin, rate = math.sqrt(2.0 * GRAVITY * height) / RADIUS, math.sqrt(GRAVITY / RADIUS)
    bob = Body("bob", Sphere(0.03), 1.0, (0.0, 0.0, -RADIUS), velocity=(spin * RADIUS, 0.0, 0.0))
    scene = Scene((Body("post", Sphere(0.02)), bob), (Gravity(), Tether("post", "bob", RADIUS)))
    leaves, ends = times(height, rate, spin)
    duration = math.floor(100.0 * ends) / 100.0

    def truth(t: np.ndarray) -> Trajectory:
        turn, pace = whirl(np.minimum(t, leaves), rate, spin)
        flown = np.maximum(t - leaves, 0.0)
        u, w = RADIUS * pace * np.cos(turn), RADIUS * pace * np.sin(turn)
        x = vectors(
            t, RADIUS * np.sin(turn) + u * flown, 0.0, -RADIUS * np.cos(turn) + w * flown - 0.5 * GRAVITY * flown**2
        )
        return trajectory(scene, t, {"bob": Motion(x, vectors(t, u, 0.0, w - GRAVITY * flown))})

    fast = RADIUS * spin
    return Scenario(
        scene=scene,
        duration=duration,
        sampling=duration / 100.0,
        truth=truth,
        checks=(
            first_order("position error", 2.0 * fast * STEP, "m", "v h, at the start and where the string goes slack"),
            first_order("velocity error", (GRAVITY + fast * spin) * STEP, "m/s", "(g + v²/ρ) h: one step's change"),
        ),
        source="slack at cos θ = -2/3 (H/ρ - 1), round if H >= 5/2 ρ; Kleppner and Kolenkow, Mechanics, ch. 4",
        about=(Gravity, Tether),
        events=(leaves,) if leaves < duration else (),
    )
