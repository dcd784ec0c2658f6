"""A ball bounces on a floor."""

from __future__ import annotations

import math

import numpy as np

from mechanics.effects import Gravity, Restitution
from mechanics.scene import Body, Scene
from mechanics.shapes import HalfSpace, Sphere
from mechanics.trajectory import Trajectory
from scenarios.motion import Motion, trajectory, vectors
from scenarios.scenario import Check, Scenario, scenario
from scenarios.tolerance import GRAVITY, STEP, first_order

SOURCE = (
    "z = eⁿ v τ - g τ²/2 after the n-th impact at √(2h/g) (1 + 2 (e + e² + ...)); "
    "Brogliato, Nonsmooth Mechanics, 3rd ed., §1.3"
)
RADIUS = 0.1  # [m]


def impact_times(clearance: float, e: float, until: float, g: float = GRAVITY) -> np.ndarray:
    """Times up to `until` at which a body dropped from `clearance` [m] strikes the floor [s].

    For e < 1 they accumulate at √(2h/g) (1 + e)/(1 - e); the list ends where rounding cannot part them.
    """
    first = math.sqrt(2.0 * clearance / g)
    times, interval = [first], 2.0 * first * e
    while times[-1] + interval <= until and times[-1] + interval > times[-1]:
        times.append(times[-1] + interval)
        interval *= e
    return np.array(times)


def bounce(t: np.ndarray, clearance: float, e: float, g: float = GRAVITY) -> tuple[np.ndarray, np.ndarray]:
    """Gap [m] and upward velocity [m/s] at times `t` of a body dropped from `clearance` onto a floor."""
    times = impact_times(clearance, e, float(np.max(t, initial=0.0)), g)
    n = np.searchsorted(times, t, side="right")
    since = t - np.append(0.0, times)[n]
    launch = np.where(n > 0, math.sqrt(2.0 * g * clearance) * e**n, 0.0)
    gap = np.where(n > 0, 0.0, clearance) + launch * since - 0.5 * g * since**2
    # beyond the last impact that rounding can part from the next one the body lies still
    ended = (n == len(times)) & (since > 2.0 * launch / g) & (n > 0)
    return np.where(ended, 0.0, gap), np.where(ended, 0.0, launch - g * since)


def delay(e: float) -> float:
    """Time [s] by which one bounce of a first-order engine at a step of 1 ms can be late.

    Seen up to h late, the ball strikes g h too fast and flies 2 e h longer: (1 + 2e) h, if it is put back
    on the surface at once.  If it has to climb out of the overlap instead, that costs the speed g h/e; if
    gravity is added before the impact is looked at, it strikes another g h faster: (1 + 4e - 1/e) h.
    """
    return max(1.0 + 2.0 * e, 1.0 + 4.0 * e - 1.0 / e) * STEP


def bounce_checks(clearance: float, e: float, impacts: int, duration: float) -> tuple[Check, ...]:
    """What is demanded of a drop from `clearance` that sees `impacts` bounces in `duration` [s]."""
    speed = math.sqrt(2.0 * GRAVITY * clearance)
    late = impacts * delay(e)
    slowest = speed * e ** (impacts - 1)
    return (
        first_order(
            "position error",
            GRAVITY * duration * STEP / 2.0 + speed * late,
            "m",
            f"g t h/2, and v times the delay of {impacts} impact(s) by at most {delay(e) / STEP:.2g} h each",
        ),
        first_order("velocity error", GRAVITY * late, "m/s", f"g times that delay of {impacts} impact(s)"),
        first_order(
            "restitution error",
            (1.0 + e) * GRAVITY * STEP / (2.0 * slowest),
            "1",
            f"(1 + e) g h/2v: approach and rebound are known to g h/2; the slowest impact has {slowest:.2g} m/s",
        ),
    )


@scenario(
    tags=("impact",),
    suites=("smoke", "standard"),
    variants=({}, {"e": 0.3}, {"e": 0.5}, {"e": 0.7}, {"e": 0.9}, {"e": 1.0}),
    ranges={"e": (0.1, 1.0), "clearance": (0.1, 1e3)},
)
def bouncing_ball(e: float = 0.8, clearance: float = 1.0) -> Scenario:
    """A ball dropped from 1 m bounces up to three times, coming back to e² of its height each time.

    Restitution e is what users ask for and what engines most often get wrong: a loss that depends on
    the step size, a threshold below which nothing bounces, energy from nowhere at e = 1.  Impacts
    slower than 1 m/s are left to other scenarios.
    """
    floor = Body("floor", HalfSpace())
    ball = Body("ball", Sphere(RADIUS), mass=1.0, position=(0.0, 0.0, RADIUS + clearance))
    scene = Scene((floor, ball), (Gravity(), Restitution(e)))
    speed = math.sqrt(2.0 * GRAVITY * clearance)
    impacts = max(1, sum(speed * e**n > 1.0 for n in range(3)))
    times = impact_times(clearance, e, math.inf if e < 1.0 else 6.0 * speed / GRAVITY)[:impacts]
    duration = round(float(times[-1]) + speed * e**impacts / GRAVITY, 3)

    def truth(t: np.ndarray) -> Trajectory:
        gap, rise = bounce(t, clearance, e)
        return trajectory(scene, t, {"ball": Motion(vectors(t, z=RADIUS + gap), vectors(t, z=rise))})

    return Scenario(
        scene=scene,
        duration=duration,
        sampling=0.01,
        truth=truth,
        checks=bounce_checks(clearance, e, impacts, duration),
        source=SOURCE,
        about=(Gravity, Restitution),
        events=tuple(times.tolist()),
        guard=2.0 * impacts * delay(e),
    )
