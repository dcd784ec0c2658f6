"""A block rocks from edge to edge."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from mechanics.effects import Friction, Gravity, Resting, Restitution, Rotation
from mechanics.rotation import about, exponential
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace
from mechanics.trajectory import Trajectory
from scenarios.motion import Motion, trajectory, vectors
from scenarios.scenario import Check, Scenario, Truth, scenario
from scenarios.swing import fall, fall_speed, fall_time
from scenarios.tolerance import GRAVITY, SAFETY, STEP, first_order

WIDTH, HEIGHT, MASS, MU = 0.2, 1.0, 5.0, 1.0  # [m], [m], [kg]; the friction never slips
REACH, LEAN = 0.5 * math.hypot(WIDTH, HEIGHT), math.atan2(WIDTH, HEIGHT)  # [m], [rad]
RATE = math.sqrt(0.75 * GRAVITY / REACH)  # p of Housner's equation θ̈ = -p² sin (α - θ) [rad/s]
KEPT = 1.0 - 1.5 * math.sin(LEAN) ** 2  # share of the angular velocity that an impact leaves


class Rocking(NamedTuple):
    """Half a cycle: from one impact to the next."""

    tilt: float  # largest, at rest [rad]
    rest: float  # when that is [s]
    impact: float  # when the base comes down after it [s]


def halves(tilt: float, count: int) -> list[Rocking]:
    """The first `count` half-cycles of a block let go at `tilt`; each impact leaves `KEPT` of the angular velocity."""
    found, rest = [], 0.0
    for _ in range(count):
        down = fall_time(RATE, LEAN - tilt, LEAN)
        found.append(Rocking(tilt, rest, rest + down))
        speed = KEPT * fall_speed(RATE, LEAN - tilt, LEAN)
        tilt = LEAN - math.acos(math.cos(LEAN) + 0.5 * (speed / RATE) ** 2)
        rest = found[-1].impact + fall_time(RATE, LEAN - tilt, LEAN)
    return found


def rocking(scene: Scene, cycle: list[Rocking]) -> Truth:
    """Fall and rise about one edge after the other."""

    impacts = [half.impact for half in cycle[:-1]]

    def truth(t: np.ndarray) -> Trajectory:
        n = np.searchsorted(impacts, t, side="right")
        side = np.where(n % 2, -1.0, 1.0)
        pieces = [fall(t - half.rest, RATE, LEAN - half.tilt) for half in cycle]
        angle, rate = (np.choose(n, [piece[k] for piece in pieces]) for k in (0, 1))
        x = side * (0.5 * WIDTH - REACH * np.sin(angle))
        v = vectors(t, x=-side * REACH * rate * np.cos(angle), z=-REACH * rate * np.sin(angle))
        q = exponential(vectors(t, y=side * (LEAN - angle)))
        motion = Motion(vectors(t, x=x, z=REACH * np.cos(angle)), v, q, vectors(t, y=-side * rate))
        return trajectory(scene, t, {"block": motion})

    return truth


@scenario(
    tags=("impact", "resting", "friction", "box"),
    suites=(),
    variants=({}, {"tilt": 0.05}),
    ranges={"tilt": (0.02, 0.18)},
)
def rocking_block(tilt: float = 0.1) -> Scenario:
    """A tall block let go at a tilt of 0.1 rad falls back, lands on its other edge and rocks on: three impacts.

    There is no bounce and no slip, so each impact takes what angular momentum about the new edge demands,
    1 - 3/2 sin² α = 0.942 of the angular velocity stays.  Without anything that is called loss the block
    must lose energy by impacts alone.
    """
    place = (0.5 * WIDTH - REACH * math.sin(LEAN - tilt), 0.0, REACH * math.cos(LEAN - tilt))
    turned = tuple(about((0.0, 1.0, 0.0), tilt).tolist())
    block = Body("block", Box((WIDTH, 0.4, HEIGHT)), MASS, place, turned)
    effects = (Gravity(), Restitution(0.0), Friction(MU), Resting(), Rotation())
    scene = Scene((Body("floor", HalfSpace()), block), effects)
    cycle = halves(tilt, 4)
    impacts = [half.impact for half in cycle[:-1]]

    return Scenario(
        scene=scene,
        duration=round(cycle[-1].rest, 2),
        sampling=0.01,
        truth=rocking(scene, cycle),
        checks=_checks(fall_speed(RATE, LEAN - tilt, LEAN), len(impacts)),
        source="Housner, Bull. Seismol. Soc. Am. 53 (1963) 403",
        about=(Gravity, Restitution, Friction, Resting, Rotation),
        events=tuple(impacts),
        guard=SAFETY * _delay(len(impacts)),
    )


def _delay(impacts: int) -> float:
    """By which the motion of a first-order engine may be late after so many impacts [s].

    Seen h late, an impact leaves an overlap ω h, out of which the block climbs at what is left of ω: (1 + 1/r) h.
    """
    return (1.0 + impacts * (1.0 + 1.0 / KEPT)) * STEP


def _checks(speed: float, impacts: int) -> tuple[Check, ...]:
    late = _delay(impacts)
    spin, turn = RATE**2 * math.sin(LEAN), speed
    why = f"for {late / STEP:.2g} h: the start, and (1 + 1/r) h for each impact"
    return (
        first_order("position error", REACH * turn * late, "m", "R ω " + why),
        first_order("velocity error", REACH * (spin + turn**2) * late, "m/s", "R (p² sin α + ω²) " + why),
        first_order("orientation error", turn * late, "rad", "ω " + why),
        first_order("angular velocity error", spin * late, "rad/s", "p² sin α " + why),
    )
