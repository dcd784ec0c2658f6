"""A block on an inclined plane."""

from __future__ import annotations

import math

import numpy as np

from mechanics.effects import Friction, Gravity, Resting
from mechanics.rotation import about
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace
from mechanics.trajectory import Trajectory
from scenarios.because import HELD
from scenarios.motion import Motion, trajectory
from scenarios.scenario import Scenario, scenario
from scenarios.tolerance import GRAVITY, STEP, first_order

SIZE = (0.4, 0.4, 0.1)  # [m]
ACROSS = (0.0, 1.0, 0.0)
DURATION = 2.0  # [s]


def slide(t: np.ndarray, slope: float, mu: float, speed: float) -> tuple[np.ndarray, np.ndarray, float]:
    """Way and speed down a plane inclined by `slope` [rad] after a start at `speed` [m/s] (upwards if negative).

    Returns
    -------
    way (T,) [m], speed (T,) [m/s], and the time at which sliding first stops [s] (infinite if never).
    """
    pull, brake = GRAVITY * math.sin(slope), mu * GRAVITY * math.cos(slope)
    holds = brake >= pull
    if speed == 0.0:
        first, stop = 0.0, 0.0
    else:
        first = pull - math.copysign(brake, speed)
        stop = -speed / first if first * speed < 0.0 else math.inf
    s, rest = np.minimum(t, stop), np.maximum(t - stop, 0.0)
    again = 0.0 if holds else pull - brake
    way = speed * s + 0.5 * first * s**2 + 0.5 * again * rest**2
    return way, speed + first * s + again * rest, stop


@scenario(
    tags=("friction", "resting", "box"),
    variants=({}, {"mu": 0.6}, {"mu": 0.6, "speed": 2.0}, {"speed": -4.0}),
    ranges={"slope": (1.0, 80.0), "mu": (0.0, 10.0), "speed": (-100.0, 100.0)},
    because=HELD,
)
def incline(mu: float = 0.3, slope: float = 25.0, speed: float = 0.0) -> Scenario:
    """A block on a plane inclined by 25 degrees: with friction 0.3 it slides, with 0.6 it must stay.

    The threshold is µ = tan 25° = 0.466.  Given a push downwards at µ = 0.6 the block must come to
    rest and stay; thrown up the plane at µ = 0.3 it must turn round and come back slower.  The block is not
    allowed to turn, so that friction alone is tested.
    """
    angle = math.radians(slope)
    normal = np.array([math.sin(angle), 0.0, math.cos(angle)])
    down = np.array([math.cos(angle), 0.0, -math.sin(angle)])
    plane = Body("plane", HalfSpace(tuple(normal.tolist())))
    start, turn, velocity = (tuple(a.tolist()) for a in (SIZE[2] / 2.0 * normal, about(ACROSS, angle), speed * down))
    block = Body("block", Box(SIZE), mass=2.0, position=start, orientation=turn, velocity=velocity)
    scene = Scene((plane, block), (Gravity(), Friction(mu), Resting()))

    def truth(t: np.ndarray) -> Trajectory:
        way, pace, _ = slide(t, angle, mu, speed)
        return trajectory(scene, t, {"block": Motion(np.array(start) + way[:, None] * down, pace[:, None] * down)})

    fastest = max(abs(float(slide(np.array([at]), angle, mu, speed)[1][0])) for at in (0.0, DURATION))
    stop = slide(np.zeros(1), angle, mu, speed)[2]
    return Scenario(
        scene=scene,
        duration=DURATION,
        sampling=0.01,
        truth=truth,
        checks=_checks(fastest, angle, mu),
        source="stays if µ >= tan α, else slides at g (sin α - µ cos α); Meriam and Kraige, Dynamics",
        about=(Gravity, Friction, Resting),
        events=(stop,) if 0.0 < stop < DURATION else (),
    )


def _checks(fastest: float, angle: float, mu: float) -> tuple:
    pull, brake = GRAVITY * math.sin(angle), mu * GRAVITY * math.cos(angle)
    if fastest == 0.0:
        sink = 10.0 * GRAVITY * STEP**2
        return (
            first_order("drift", sink, "m", "10 g h²: ten times what gravity moves in a step before contact answers"),
            first_order("velocity error", GRAVITY * STEP, "m/s", "g h: what gravity adds in one step"),
        )
    return (
        first_order("position error", (pull + brake) * DURATION * STEP / 2.0, "m", "(g sin α + µ g cos α) t h/2"),
        first_order("velocity error", (pull + brake) * STEP, "m/s", "(g sin α + µ g cos α) h: one step's change"),
    )
