"""A rod whose foot slips on a rough floor."""

from __future__ import annotations

import math

import numpy as np

from mechanics.effects import Friction, Gravity, Resting, Rotation
from mechanics.rotation import about, exponential
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace
from mechanics.trajectory import Trajectory
from scenarios.motion import Motion, trajectory, vectors
from scenarios.scenario import Check, Scenario, Truth, scenario
from scenarios.swing import fall, fall_speed, fall_time
from scenarios.tolerance import GRAVITY, STEP, first_order

THICK, MASS = 0.05, 1.0  # [m], [kg]
HALF = 0.5  # from the foot, which is an edge of the rod, to the centre [m]
TALL = math.sqrt(4.0 * HALF**2 - THICK**2)  # [m]
LEAN = math.asin(0.5 * THICK / HALF)  # of the line from foot to centre in the rod [rad]
MOMENT = MASS * HALF**2 / 3.0  # of a thin rod [kg m2]
RATE = math.sqrt(0.75 * GRAVITY / HALF)  # θ̈ = 3g/(4l) sin θ while the foot stays [rad/s]
ACROSS = (0.0, 1.0, 0.0)


def contact_mobility(angle: float, drag: float) -> float:
    """How fast a unit force of the floor, with the friction it brings, lifts the foot [m/s2 per N]: Painlevé's p.

    The rod is at `angle` from upright [rad]; `drag` is µ with the sign of the foot's velocity, where the centre is
    on its positive side.
    """
    return (1.0 + 3.0 * math.sin(angle) * (math.sin(angle) + drag * math.cos(angle))) / MASS


def unsupported(angle: float, rate: float) -> float:
    """Acceleration of the foot away from the floor without a force of the floor [m/s2]: Painlevé's b."""
    return HALF * rate**2 * math.cos(angle) - GRAVITY


def push(angle: float, rate: float, drag: float) -> float:
    """Force [N] of the floor on the sliding foot of a rod that turns at `rate` [rad/s]; see `contact_mobility`.

    Raises
    ------
    ValueError
        Where friction pulls the foot into the floor, so that no force or more than one would do (Painlevé 1895).
    """
    mobility = contact_mobility(angle, drag)
    if mobility <= 0.0:
        raise ValueError(f"drag = {drag:g} at {angle:g} rad has no single answer: the floor's force would not lift")
    return -unsupported(angle, rate) / mobility


def least_paradox(angle: float) -> float:
    """Least friction for which the foot of a pushed rod at `angle` from upright jams: p = 0; never below 4/3."""
    return (1.0 + 3.0 * math.sin(angle) ** 2) / (3.0 * math.sin(angle) * math.cos(angle))


def paradox(mu: float) -> tuple[float, float]:
    """Angles to the floor [rad] between which a rod pushed over a floor with friction µ >= 4/3 may jam: p <= 0."""
    root = math.sqrt(9.0 * mu**2 - 16.0)
    return math.atan(0.5 * (3.0 * mu - root)), math.atan(0.5 * (3.0 * mu + root))


def foot_forces(angle: float, start: float) -> tuple[float, float]:
    """Push of the floor and friction, over the weight, on the foot that stays, after a fall from rest at `start`."""
    spin, pull = fall_speed(RATE, start, angle) ** 2 * HALF / GRAVITY, 0.75 * math.sin(angle)
    return 1.0 - pull * math.sin(angle) - spin * math.cos(angle), pull * math.cos(angle) - spin * math.sin(angle)


def slips(start: float, mu: float) -> float:
    """Angle [rad] at which the foot of a rod let go at rest at `start` begins to slip, backwards or forwards."""
    from scipy.optimize import brentq

    def spare(angle: float) -> float:
        normal, along = foot_forces(angle, start)
        return mu * normal - abs(along)

    angles = np.linspace(start, 0.5 * math.pi, 2000)[1:]
    last = next(k for k, angle in enumerate(angles) if spare(float(angle)) < 0.0)
    return float(brentq(spare, angles[last - 1], angles[last], xtol=1e-15))


def least_forward() -> float:
    """Friction above which the foot of a rod let go upright slips forwards and not back: 15 √10/128."""
    return 15.0 * math.sqrt(10.0) / 128.0


def sliding(t: np.ndarray, angle: float, rate: float, foot: float, drag: float) -> np.ndarray:
    """Angle, rate, place and velocity of the foot, (4, T), of a rod that slides from t = 0; Runge-Kutta of order 8."""
    from scipy.integrate import solve_ivp

    def pace(_: float, y: np.ndarray) -> list[float]:
        sine, cosine = math.sin(y[0]), math.cos(y[0])
        force = push(y[0], y[1], drag)
        turn = force * HALF * (sine + drag * cosine) / MOMENT
        return [y[1], turn, y[3], -drag * force / MASS - HALF * (turn * cosine - y[1] ** 2 * sine)]

    wanted = np.unique(np.append(0.0, t))
    if len(wanted) == 1:
        return np.repeat(np.array([[angle], [rate], [0.0], [foot]]), len(t), axis=1)
    start = [angle, rate, 0.0, foot]
    flow = solve_ivp(pace, (0.0, wanted[-1]), start, "DOP853", wanted, rtol=1e-13, atol=1e-14).y
    return flow[:, np.searchsorted(wanted, t)]


def on_its_foot(scene: Scene, motion: np.ndarray, t: np.ndarray) -> Trajectory:
    """Trajectory of the rod from angle, rate, place and velocity of its foot."""
    angle, rate, place, foot = motion
    sine, cosine = HALF * np.sin(angle), HALF * np.cos(angle)
    x, v = vectors(t, x=place + sine, z=cosine), vectors(t, x=foot + rate * cosine, z=-rate * sine)
    q = exponential(vectors(t, y=angle + LEAN))
    return trajectory(scene, t, {"rod": Motion(x, v, q, vectors(t, y=rate))})


def rod_on_floor(angle: float, foot: float, mu: float) -> Scene:
    """A rod that leans by `angle` to the side of +x, its foot at the origin, sliding at `foot` [m/s]."""
    place = (HALF * math.sin(angle), 0.0, HALF * math.cos(angle))
    turned = tuple(about(ACROSS, angle + LEAN).tolist())
    size = (THICK, THICK, TALL)
    rod = Body("rod", Box(size), MASS, place, turned, (foot, 0.0, 0.0), inertia=(MOMENT, MOMENT, MOMENT))
    return Scene((Body("floor", HalfSpace()), rod), (Gravity(), Friction(mu), Resting(), Rotation()))


def _checks(fast: float, turn: float) -> tuple[Check, ...]:
    """What is demanded of a rod whose foot moves at up to `fast` [m/s] and which turns at up to `turn` [rad/s]."""
    pull = 1.5 * GRAVITY / HALF + turn**2
    why = "start and slip a step early or late: 2 "
    return (
        first_order("position error", 2.0 * (fast + turn * HALF) * STEP, "m", why + "v h"),
        first_order("velocity error", 2.0 * (pull * HALF + GRAVITY) * STEP, "m/s", why + "((α + ω²) l + g) h"),
        first_order("orientation error", 2.0 * turn * STEP, "rad", why + "ω h"),
        first_order("angular velocity error", 2.0 * pull * STEP, "rad/s", why + "(α + ω²) h"),
    )


@scenario(
    tags=("friction", "resting", "rod", "slip"),
    suites=(),
    variants=({}, {"mu": 0.6}),
    ranges={"start": (2.0, 15.0), "mu": (0.1, 1.0)},
)
def slipping_rod(start: float = 10.0, mu: float = 0.3) -> Scenario:
    """A rod stands on a rough floor, 10 degrees from upright, and falls: its foot holds at first and then slips.

    With friction 0.3 it slips backwards, away from the falling head, at about 24 degrees; with more than 0.37
    it holds past that and slips forwards later, pushed by the turning rod.  The scene goes on for 0.1 s.
    """
    begin = math.radians(start)
    at = slips(begin, mu)
    rate, leaves = fall_speed(RATE, begin, at), fall_time(RATE, begin, at)
    scene, drag = rod_on_floor(begin, 0.0, mu), -math.copysign(mu, foot_forces(at, begin)[1])
    duration = math.floor(100.0 * leaves + 10.0) / 100.0

    def truth(t: np.ndarray) -> Trajectory:
        on = np.minimum(t, leaves)
        first = np.stack([*fall(on, RATE, begin), 0.0 * t, 0.0 * t])
        last = sliding(np.maximum(t - leaves, 0.0), at, rate, 0.0, drag)
        return on_its_foot(scene, np.where(t < leaves, first, last), t)

    _, turn, _, foot = sliding(np.array([duration - leaves]), at, rate, 0.0, drag)[:, 0].tolist()
    return Scenario(
        scene=scene,
        duration=duration,
        sampling=0.01,
        truth=truth,
        checks=_checks(abs(foot), turn),
        source="N = m g (3 cos θ - 1)²/4, F = 3/4 m g sin θ (3 cos θ - 2); Turner and Pratt, Quantum, March 1998",
        about=(Gravity, Friction, Resting, Rotation),
        events=(leaves,),
    )


def pushed(scene: Scene, angle: float, foot: float, mu: float) -> Truth:
    """Motion of a rod whose foot slides away from the side to which it leans, from no turning."""
    return lambda t: on_its_foot(scene, sliding(t, angle, 0.0, foot, -mu), t)


@scenario(
    tags=("friction", "resting", "rod", "painleve", "hard"),
    suites=(),
    variants=({}, {"mu": 0.5}),
    ranges={"angle": (10.0, 40.0), "mu": (0.1, 1.6)},
)
def painleve_rod(angle: float = 30.0, mu: float = 1.6) -> Scenario:
    """A rod leans over its foot at 30 degrees to the floor and is pushed along it, foot first, like chalk on a board.

    Friction 1.6 tries to turn the rod into the floor and presses it on: 8.4 N where it would be 3.0 without.
    Near 63 degrees it would jam beyond 4/3, and rigid bodies with friction would have no answer, or two (Painlevé);
    here they have one, and an engine must find it.
    """
    tilt = 0.5 * math.pi - math.radians(angle)
    scene = rod_on_floor(tilt, -2.0, mu)
    _, turn, _, _ = sliding(np.array([0.1]), tilt, 0.0, -2.0, -mu)[:, 0].tolist()
    return Scenario(
        scene=scene,
        duration=0.1,
        sampling=2e-3,
        truth=pushed(scene, tilt, -2.0, mu),
        checks=_checks(2.0, abs(turn)),
        source="N = -b/p, p = (1 + 3 cos φ (cos φ - µ sin φ))/m; Génot and Brogliato, Eur. J. Mech. A 18 (1999) 653",
        about=(Gravity, Friction, Resting, Rotation),
    )
