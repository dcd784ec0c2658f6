"""A ball rolls down a big ball."""

from __future__ import annotations

import math

import numpy as np

from mechanics.effects import Friction, Gravity, Resting, Rotation
from mechanics.rotation import exponential
from mechanics.scene import Body, Scene
from mechanics.shapes import Sphere
from mechanics.trajectory import Trajectory
from scenarios.motion import Motion, trajectory, vectors
from scenarios.off_the_sphere import BIG, PATH, SMALL
from scenarios.scenario import Scenario, Truth, scenario
from scenarios.swing import fall, fall_speed, fall_time
from scenarios.tolerance import GRAVITY, STEP, first_order

RATIO = 0.4  # moment of inertia over m r² of a solid ball
RATE = math.sqrt(GRAVITY / ((1.0 + RATIO) * PATH))  # ψ̈ = g sin ψ/(ρ (1 + k)) [rad/s]


def grip_lost(start: float, mu: float) -> float:
    """Angle from the top [rad] at which µ N no longer holds the friction k/(1 + k) m g sin ψ that rolling needs."""
    from scipy.optimize import brentq

    def spare(angle: float) -> float:
        push = math.cos(angle) - PATH / GRAVITY * fall_speed(RATE, start, angle) ** 2
        return mu * push - RATIO / (1.0 + RATIO) * math.sin(angle)

    return float(brentq(spare, start, 0.5 * math.pi, xtol=1e-14))


def rolling(scene: Scene, begin: float) -> Truth:
    """Motion of the small ball, which turns by ρ/r for each radian of its path."""

    def truth(t: np.ndarray) -> Trajectory:
        angle, rate = fall(t, RATE, begin)
        sine, cosine, gear = PATH * np.sin(angle), PATH * np.cos(angle), PATH / SMALL
        q, w = exponential(vectors(t, y=gear * (angle - begin))), vectors(t, y=gear * rate)
        motion = Motion(vectors(t, x=sine, z=cosine), vectors(t, x=rate * cosine, z=-rate * sine), q, w)
        return trajectory(scene, t, {"small": motion})

    return truth


@scenario(
    tags=("friction", "rotation", "rolling"),
    suites=(),
    variants=({}, {"start": 10.0}),
    ranges={"start": (1.0, 30.0), "mu": (0.3, 10.0)},
)
def rolling_off_the_sphere(start: float = 20.0, mu: float = 1.0) -> Scenario:
    """A ball let go on a rough fixed ball, 20 degrees from its top, rolls down without slipping.

    Its spin takes 2/7 of the energy, so it gets on more slowly than one that slides.  The further down,
    the less it presses and the more friction it needs; the scene ends before it begins to slip.
    """
    begin = math.radians(start)
    place = (PATH * math.sin(begin), 0.0, PATH * math.cos(begin))
    bodies = (Body("big", Sphere(BIG)), Body("small", Sphere(SMALL), 1.0, place))
    scene = Scene(bodies, (Gravity(), Friction(mu), Resting(), Rotation()))
    last = grip_lost(begin, mu)
    duration = math.floor(100.0 * fall_time(RATE, begin, last) - 2.0) / 100.0  # at the limit itself a step decides

    speed = PATH * fall_speed(RATE, begin, last)
    pull = GRAVITY / (1.0 + RATIO) + speed**2 / PATH
    return Scenario(
        scene=scene,
        duration=duration,
        sampling=duration / 100.0,
        truth=rolling(scene, begin),
        checks=(
            first_order("position error", speed * STEP, "m", "v h: a first-order scheme is a step early or late"),
            first_order("velocity error", pull * STEP, "m/s", "(g/(1 + k) + v²/ρ) h: one step's change"),
            first_order("orientation error", speed / SMALL * STEP, "rad", "v/r h: a step early or late"),
            first_order("angular velocity error", GRAVITY / (1.4 * SMALL) * STEP, "rad/s", "g/((1 + k) r) h: one step"),
        ),
        source="ψ̈ = g sin ψ/(ρ (1 + k)) while µ N >= k/(1 + k) m g sin ψ; Routh, Rigid Dynamics, Elementary Part",
        about=(Gravity, Friction, Resting, Rotation),
    )
