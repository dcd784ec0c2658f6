"""A rod falls over on a smooth floor, and a ladder slides down a smooth wall."""

from __future__ import annotations

import math

import numpy as np

from mechanics.effects import Gravity, Resting, Rotation
from mechanics.rotation import about, exponential
from mechanics.scene import Body, Scene
from mechanics.shapes import Capsule, HalfSpace
from mechanics.trajectory import Trajectory
from scenarios.motion import Motion, trajectory, vectors
from scenarios.scenario import Check, Scenario, Truth, scenario
from scenarios.swing import fall, fall_speed, fall_time
from scenarios.tolerance import GRAVITY, STEP, first_order

LENGTH, RADIUS, MASS = 1.0, 0.02, 1.0  # between the centres of the round ends [m], [m], [kg]
MOMENT = MASS * LENGTH**2 / 12.0  # of a thin rod [kg m2]
ACROSS = (0.0, 1.0, 0.0)
LADDER = math.sqrt(1.5 * GRAVITY / LENGTH)  # θ̈ = 3g/(2L) sin θ while both ends touch [rad/s]


def floor_rate(start: float, spin: float, angle: float) -> float:
    """θ̇ [rad/s] at `angle` from the vertical of a rod whose foot slides on a smooth floor; it had `spin` at `start`.

    The centre moves straight down, so the energy is m L²/24 (1 + 3 sin² θ) θ̇² + m g L/2 cos θ.
    """
    twice = spin**2 * (1.0 + 3.0 * math.sin(start) ** 2) + 12.0 * GRAVITY / LENGTH * (math.cos(start) - math.cos(angle))
    return math.sqrt(twice / (1.0 + 3.0 * math.sin(angle) ** 2))


def on_the_floor(t: np.ndarray, start: float, spin: float) -> tuple[np.ndarray, np.ndarray]:
    """Angle from the vertical [rad] and its rate [rad/s] at times `t` >= 0 of that rod, by Runge-Kutta of order 8."""
    from scipy.integrate import solve_ivp

    def rate(_: float, y: np.ndarray) -> list[float]:
        sine, cosine = math.sin(y[0]), math.cos(y[0])
        return [y[1], sine * (6.0 * GRAVITY / LENGTH - 3.0 * y[1] ** 2 * cosine) / (1.0 + 3.0 * sine**2)]

    wanted = np.unique(np.append(0.0, t))
    if len(wanted) == 1:
        return np.full(len(t), start), np.full(len(t), spin)
    flow = solve_ivp(rate, (0.0, wanted[-1]), [start, spin], "DOP853", wanted, rtol=1e-13, atol=1e-14).y
    place = np.searchsorted(wanted, t)
    return flow[0, place], flow[1, place]


def floor_time(start: float, angle: float) -> float:
    """Time [s] from rest at `start` to `angle` on the floor: ∫ dθ/θ̇ with θ = start + s², which is regular, by Gauss."""
    nodes, weights = np.polynomial.legendre.leggauss(60)
    end = math.sqrt(angle - start)
    s = 0.5 * end * (nodes + 1.0)
    at = start + s * s
    # cos θ₀ - cos θ = 2 sin((θ + θ₀)/2) sin(s²/2), here over s²
    drop = np.sin(0.5 * (at + start)) * np.sinc(0.5 * s * s / math.pi)
    slowness = 2.0 * np.sqrt((1.0 + 3.0 * np.sin(at) ** 2) * LENGTH / (12.0 * GRAVITY * drop))
    return float(0.5 * end * (weights @ slowness))


def rod(x: float, z: float, angle: float) -> Body:
    """The rod at rest, turned by `angle` [rad] about y from upright."""
    turned = tuple(about(ACROSS, angle).tolist())
    return Body("rod", Capsule(RADIUS, LENGTH), MASS, (x, 0.0, z), turned, inertia=(MOMENT, MOMENT, MOMENT))


def rod_checks(rate: float, start: float) -> tuple[Check, ...]:
    """What is demanded of a rod whose ends slide without friction and which ends up turning at `rate` [rad/s]."""
    pull = (12.0 * GRAVITY / LENGTH + rate**2) * STEP
    return (
        first_order("position error", rate * LENGTH * STEP, "m", "v h, with v = ω L: a step early or late"),
        first_order("velocity error", 0.5 * pull * LENGTH, "m/s", "(α + ω²) L/2 h: one step's change"),
        first_order("orientation error", rate * STEP, "rad", "ω h: a first-order scheme is a step early or late"),
        first_order("angular velocity error", pull, "rad/s", "(12 g/L + ω²) h: one step's change, at most"),
    )


@scenario(tags=("resting", "rod"), suites=(), variants=({}, {"start": 45.0}), ranges={"start": (2.0, 70.0)})
def falling_rod(start: float = 20.0) -> Scenario:
    """A rod is let go 20 degrees from upright on a floor without friction; its foot slides away as it falls.

    Nothing pushes it sideways, so its middle goes straight down, and the foot goes back by as much as the
    head comes forward.  The contact slides all the time; its force falls to a quarter of the weight and
    below and must not stick.  The scene ends at 80 degrees, before the rod lies flat.
    """
    begin = math.radians(start)
    body = rod(0.0, RADIUS + 0.5 * LENGTH * math.cos(begin), begin)
    scene = Scene((Body("floor", HalfSpace()), body), (Gravity(), Resting(), Rotation()))
    end = math.radians(80.0)

    def truth(t: np.ndarray) -> Trajectory:
        angle, rate = on_the_floor(t, begin, 0.0)
        x = vectors(t, z=RADIUS + 0.5 * LENGTH * np.cos(angle))
        v = vectors(t, z=-0.5 * LENGTH * rate * np.sin(angle))
        return trajectory(scene, t, {"rod": Motion(x, v, exponential(vectors(t, y=angle)), vectors(t, y=rate))})

    duration = math.floor(100.0 * floor_time(begin, end)) / 100.0
    return Scenario(
        scene=scene,
        duration=duration,
        sampling=0.01,
        truth=truth,
        checks=rod_checks(floor_rate(begin, 0.0, end), begin),
        source="θ̇² = 12 g (cos θ₀ - cos θ)/(L (1 + 3 sin² θ)); Cross, Am. J. Phys. 74 (2006) 26",
        about=(Gravity, Resting, Rotation),
    )


def leaves_wall(start: float) -> tuple[float, float, float]:
    """Angle from the wall [rad], rate [rad/s] and sideways speed [m/s] with which the ladder leaves the wall."""
    angle = math.acos(2.0 / 3.0 * math.cos(start))
    rate = fall_speed(LADDER, start, angle)
    return angle, rate, 0.5 * LENGTH * rate * math.cos(angle)


def sliding(scene: Scene, start: float) -> Truth:
    """Both ends on wall and floor at first, then the foot alone, the middle going on sideways as it was."""
    angle, rate, speed = leaves_wall(start)
    parts = fall_time(LADDER, start, angle)

    def truth(t: np.ndarray) -> Trajectory:
        on, off = t <= parts, np.maximum(t - parts, 0.0)
        first, second = fall(np.minimum(t, parts), LADDER, start), on_the_floor(off, angle, rate)
        turn, spin = (np.where(on, a, b) for a, b in zip(first, second, strict=True))
        x = np.where(on, 0.5 * LENGTH * np.sin(turn), 0.5 * LENGTH * math.sin(angle) + speed * off)
        v = vectors(t, x=np.where(on, 0.5 * LENGTH * spin * np.cos(turn), speed), z=-0.5 * LENGTH * spin * np.sin(turn))
        place = vectors(t, x=RADIUS + x, z=RADIUS + 0.5 * LENGTH * np.cos(turn))
        q = exponential(vectors(t, y=-turn))
        return trajectory(scene, t, {"rod": Motion(place, v, q, vectors(t, y=-spin))})

    return truth


@scenario(tags=("resting", "rod", "leaving"), suites=(), variants=({}, {"start": 40.0}), ranges={"start": (2.0, 60.0)})
def sliding_ladder(start: float = 20.0) -> Scenario:
    """A ladder leans on a smooth wall, 20 degrees from it, on a smooth floor, and slides down.

    Its head leaves the wall long before it is down, where cos θ is 2/3 of what it was at the start: from
    there on nothing pushes it sideways.  A wall that held the head back, or pushed it further, would show
    in the speed sideways, which stays as it is.
    """
    begin, half = math.radians(start), 0.5 * LENGTH
    body = rod(RADIUS + half * math.sin(begin), RADIUS + half * math.cos(begin), -begin)
    surfaces = (Body("floor", HalfSpace()), Body("wall", HalfSpace((1.0, 0.0, 0.0))))
    scene = Scene((*surfaces, body), (Gravity(), Resting(), Rotation()))
    angle, rate, _ = leaves_wall(begin)
    parts = fall_time(LADDER, begin, angle)
    return Scenario(
        scene=scene,
        duration=round(parts + 0.08, 2),
        sampling=0.01,
        truth=sliding(scene, begin),
        checks=rod_checks(floor_rate(angle, rate, math.radians(80.0)), begin),
        source="leaves the wall at cos θ = 2/3 cos θ₀; Routh, Rigid Dynamics, Elementary Part",
        about=(Gravity, Resting, Rotation),
        events=(parts,),
    )
