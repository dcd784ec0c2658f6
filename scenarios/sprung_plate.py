"""A box is thrown up by a plate that swings on a spring, and caught again."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from mechanics.effects import Gravity, Resting, Restitution, Spring
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, Sphere
from mechanics.trajectory import Trajectory
from scenarios.motion import Motion, trajectory, vectors
from scenarios.scenario import Scenario, Truth, scenario
from scenarios.tolerance import GRAVITY, STEP, first_order

PLATE, BOX = 3.0, 1.0  # masses [kg]
WIDE, THICK, EDGE = 1.0, 0.25, 0.25  # [m]; binary fractions: the box touches the plate bit by bit
RATE, CEILING = 20.0, 2.0  # ω of plate and box together [rad/s], height of the spring's other end [m]


class Thrown(NamedTuple):
    """Heights are those of the plate's top, from where plate and box together would be in balance."""

    leaves: float  # when the box leaves the plate [s]
    height: float  # there [m]
    speed: float  # there [m/s]
    meets: float  # when they meet again [s]
    closing: float  # speed of the box against the plate then [m/s], negative


def alone(t: np.ndarray, leaves: float, height: float, speed: float, rate: float, share: float) -> tuple:
    """Height [m] and velocity [m/s] of the plate after the box has left it.

    It swings about a place higher by m g/k and faster, for `share` = m/(M + m) of what it carried is gone.
    """
    own, middle, since = rate / math.sqrt(1.0 - share), share * GRAVITY / rate**2, t - leaves
    sine, cosine = np.sin(own * since), np.cos(own * since)
    return (
        middle + (height - middle) * cosine + speed / own * sine,
        speed * cosine - own * (height - middle) * sine,
    )


def thrown(amplitude: float, rate: float, share: float) -> Thrown:
    """The first flight of the box on a plate that swings like `amplitude` sin `rate` t as long as it carries it.

    Contact ends where the plate accelerates down by g.  `share` is 0 for a plate that does not mind the box.
    """
    from scipy.optimize import brentq

    sine = GRAVITY / (amplitude * rate**2)
    if not sine < 1.0:
        raise ValueError(f"amplitude = {amplitude:g} m keeps the box; allowed: more than {GRAVITY / rate**2:.4g} m")
    leaves, height = math.asin(sine) / rate, GRAVITY / rate**2
    speed = amplitude * rate * math.sqrt(1.0 - sine**2)

    def gap(t: float) -> float:
        since = t - leaves
        return height + speed * since - 0.5 * GRAVITY * since**2 - alone(t, leaves, height, speed, rate, share)[0]

    # they part as the third power of time: look from a twentieth of a period on
    times = leaves + np.arange(1, 400) * 0.05 * math.pi / rate
    after = next(float(t) for t in times if gap(float(t)) < 0.0)
    meets = float(brentq(gap, after - 0.05 * math.pi / rate, after, xtol=1e-15))
    box = speed - GRAVITY * (meets - leaves)
    return Thrown(leaves, height, speed, meets, box - float(alone(meets, leaves, height, speed, rate, share)[1]))


def up_and_down(scene: Scene, amplitude: float, share: float) -> Truth:
    """Together, apart, and together again."""
    way = thrown(amplitude, RATE, share)
    caught, shared = (float(a) for a in alone(way.meets, *way[:3], RATE, share))
    shared += share * way.closing

    def truth(t: np.ndarray) -> Trajectory:
        flown, since = t - way.leaves, t - way.meets
        swing, again = RATE * np.minimum(t, way.leaves), RATE * np.maximum(since, 0.0)
        first = amplitude * np.sin(swing), amplitude * RATE * np.cos(swing)
        last = (
            caught * np.cos(again) + shared / RATE * np.sin(again),
            shared * np.cos(again) - RATE * caught * np.sin(again),
        )
        own = alone(t, *way[:3], RATE, share)
        free = way.height + way.speed * flown - 0.5 * GRAVITY * flown**2, way.speed - GRAVITY * flown
        phase = np.where(flown < 0.0, 0, np.where(since < 0.0, 1, 2))
        plate, box = ([np.choose(phase, [first[k], one[k], last[k]]) for k in (0, 1)] for one in (own, free))
        motions = {
            name: Motion(vectors(t, z=z + lift), vectors(t, z=w))
            for name, (z, w), lift in (("plate", plate, -0.5 * THICK), ("box", box, 0.5 * EDGE))
        }
        return trajectory(scene, t, motions)

    return truth


@scenario(
    tags=("spring", "resting", "leaving", "moving-support"),
    suites=(),
    variants=({}, {"amplitude": 0.04}),
    ranges={"amplitude": (0.03, 0.06)},
)
def sprung_plate(amplitude: float = 0.05) -> Scenario:
    """A plate on a spring swings up and down with a box on it; the box leaves it on the way up and is caught again.

    They part where the spring is slack: from there on the plate falls faster than the box.  Then both move
    on their own until they meet, without a bounce.  What an engine does a step late shows as height.
    """
    total, natural = PLATE + BOX, GRAVITY / RATE**2
    push = (0.0, 0.0, amplitude * RATE)
    plate = Body("plate", Box((WIDE, WIDE, THICK)), PLATE, (0.0, 0.0, -0.5 * THICK), velocity=push)
    box = Body("box", Box((EDGE, EDGE, EDGE)), BOX, (0.0, 0.0, 0.5 * EDGE), velocity=push)
    spring = Spring("hook", "plate", total * RATE**2, CEILING - natural + 0.5 * THICK)
    effects = (Gravity(), Restitution(0.0), Resting(), spring)
    scene = Scene((Body("hook", Sphere(0.05), position=(0.0, 0.0, CEILING)), plate, box), effects)
    way = thrown(amplitude, RATE, BOX / total)
    late, pull = 4.0 * STEP, RATE**2 * amplitude + GRAVITY
    why = "the start, leaving, meeting and what follows each a step late: 4 "
    return Scenario(
        scene=scene,
        duration=math.floor(100.0 * way.meets + 4.0) / 100.0,
        sampling=2e-3,
        truth=up_and_down(scene, amplitude, BOX / total),
        checks=(
            first_order("position error", RATE * amplitude * late, "m", why + "v h"),
            first_order("velocity error", pull * late, "m/s", why + "(ω² A + g) h"),
        ),
        source="contact ends where the support accelerates below -g; Luck and Mehta, Phys. Rev. E 48 (1993) 3988",
        about=(Gravity, Resting, Spring),
        events=(way.leaves, way.meets),
    )
