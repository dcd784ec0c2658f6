"""A wheel without a rim walks down a slope."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from mechanics.effects import Friction, Gravity, Resting, Restitution, Rotation
from mechanics.rotation import exponential
from mechanics.scene import Body, Scene
from mechanics.shapes import HalfSpace, Mesh
from mechanics.trajectory import Trajectory
from scenarios.motion import Motion, trajectory, vectors
from scenarios.scenario import Scenario, Truth, scenario
from scenarios.swing import passing, passing_time
from scenarios.tolerance import GRAVITY, STEP, first_order

SPOKES, LENGTH, WIDTH, MASS = 8, 1.0, 0.5, 1.0  # length of a spoke [m], of the feet across [m], [kg]
STEP_ANGLE = math.pi / SPOKES  # half the angle between two spokes [rad]
RATIO = 0.5  # moment about the hub over m l²


class Walk(NamedTuple):
    """The steady walk."""

    kept: float  # share of the angular velocity that an impact leaves
    before: float  # angular velocity before an impact [rad/s]
    after: float  # and after it
    slowest: float  # with the spoke upright
    period: float  # from impact to impact [s]


def pace(ratio: float) -> float:
    """ω of ψ̈ = ω² sin ψ about a foot [rad/s]; `ratio` is the moment about the hub over m l²."""
    return math.sqrt(GRAVITY / ((1.0 + ratio) * LENGTH))


def walk(slope: float, ratio: float) -> Walk:
    """The walk that repeats itself: an impact takes as much energy as the slope gives in a step.

    Raises
    ------
    ValueError
        If it does not get over the upright spoke.
    """
    kept = (ratio + math.cos(2.0 * STEP_ANGLE)) / (ratio + 1.0)
    rate = pace(ratio)
    before = 2.0 * rate * math.sqrt(math.sin(STEP_ANGLE) * math.sin(slope) / (1.0 - kept**2))
    left = (kept * before) ** 2 - 2.0 * rate**2 * (1.0 - math.cos(STEP_ANGLE - slope))
    if left <= 0.0:
        raise ValueError(f"slope = {slope:g} rad is too little to walk; allowed: more")
    slowest = math.sqrt(left)
    times = [passing_time(rate, slowest, angle) for angle in (slope - STEP_ANGLE, slope + STEP_ANGLE)]
    return Walk(kept, before, kept * before, slowest, times[1] - times[0])


def prism() -> Mesh:
    """The feet joined: a prism with one foot straight down."""
    rim = [(LENGTH * math.sin(2 * STEP_ANGLE * k), -LENGTH * math.cos(2 * STEP_ANGLE * k)) for k in range(SPOKES)]
    corners = tuple((x, y, z) for y in (-0.5 * WIDTH, 0.5 * WIDTH) for x, z in rim)
    caps = [(0, k, k + 1) for k in range(1, SPOKES - 1)] + [
        (SPOKES, SPOKES + k + 1, SPOKES + k) for k in range(1, SPOKES - 1)
    ]
    sides = []
    for k in range(SPOKES):
        after = (k + 1) % SPOKES
        sides += [(k, SPOKES + k, SPOKES + after), (k, SPOKES + after, after)]
    return Mesh(corners, (*caps, *sides))


def walking(scene: Scene, slope: float, cycle: Walk) -> Truth:
    """About one foot after the other; the first stands below the hub square to the slope at t = 0."""
    rate, along = pace(RATIO), 2.0 * LENGTH * math.sin(STEP_ANGLE)
    first = passing_time(rate, cycle.slowest, slope + STEP_ANGLE) - passing_time(rate, cycle.slowest, slope)
    begin = passing_time(rate, cycle.slowest, slope - STEP_ANGLE)

    def truth(t: np.ndarray) -> Trajectory:
        n = np.maximum(0, np.floor((t - first) / cycle.period) + 1.0)
        since = np.where(n > 0, t - first - (n - 1.0) * cycle.period + begin,
                         t + passing_time(rate, cycle.slowest, slope))  # fmt: skip
        angle, spin = passing(since, rate, cycle.slowest)
        x = along * n * math.cos(slope) + LENGTH * np.sin(angle)
        z = -along * n * math.sin(slope) + LENGTH * np.cos(angle)
        v = vectors(t, x=LENGTH * spin * np.cos(angle), z=-LENGTH * spin * np.sin(angle))
        q = exponential(vectors(t, y=angle + 2.0 * STEP_ANGLE * n))
        return trajectory(scene, t, {"wheel": Motion(vectors(t, x=x, z=z), v, q, vectors(t, y=spin))})

    return truth


@scenario(
    tags=("impact", "friction", "mesh", "rotation"),
    suites=(),
    ranges={"slope": (0.06, 0.2), "steps": (1, 20)},
)
def rimless_wheel(slope: float = 0.08, steps: int = 3) -> Scenario:
    """Eight spokes without a rim walk down a slope of 0.08 rad, foot after foot, at a steady pace.

    Each foot comes down without a bounce and holds; the impact takes just what the slope gave, and keeps 0.80 of
    the angular velocity.  The foot behind must leave at that instant: an engine that holds it stops the walk.
    """
    normal, cycle = (math.sin(slope), 0.0, math.cos(slope)), walk(slope, RATIO)
    spin = passing(np.array([passing_time(pace(RATIO), cycle.slowest, slope)]), pace(RATIO), cycle.slowest)[1][0]
    place, moment = tuple(LENGTH * c for c in normal), RATIO * MASS * LENGTH**2
    wheel = Body(
        "wheel", prism(), MASS, place, (math.cos(0.5 * slope), 0.0, math.sin(0.5 * slope), 0.0),
        (LENGTH * spin * normal[2], 0.0, -LENGTH * spin * normal[0]), (0.0, spin, 0.0), (moment, moment, moment),
    )  # fmt: skip
    effects = (Gravity(), Restitution(0.0), Friction(2.0), Resting(), Rotation())
    scene = Scene((Body("slope", HalfSpace(normal)), wheel), effects)
    first = passing_time(pace(RATIO), cycle.slowest, slope + STEP_ANGLE)
    first -= passing_time(pace(RATIO), cycle.slowest, slope)
    late, fast = (1.0 + 2.0 * steps / cycle.kept) * STEP, cycle.before
    why = f"for {late / STEP:.2g} h: the start, and (1 + 1/η) h for each impact seen a step late"
    return Scenario(
        scene=scene,
        duration=round(first + (steps - 0.5) * cycle.period, 2),
        sampling=0.01,
        truth=walking(scene, slope, cycle),
        checks=(
            first_order("position error", fast * LENGTH * late, "m", "l ω " + why),
            first_order("velocity error", (GRAVITY + fast**2 * LENGTH) * late, "m/s", "(g + l ω²) " + why),
            first_order("orientation error", fast * late, "rad", "ω " + why),
            first_order("angular velocity error", pace(RATIO) ** 2 * late, "rad/s", "g/((1 + k) l) " + why),
        ),
        source="η = (k + cos 2α)/(k + 1); McGeer, Int. J. Robot. Res. 9 (1990) 62",
        about=(Gravity, Restitution, Friction, Resting, Rotation),
        events=tuple(first + k * cycle.period for k in range(steps)),
        guard=2.0 * steps * STEP,
    )
