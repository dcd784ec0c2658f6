"""A tall box falls over its lower edge."""

from __future__ import annotations

import math

import numpy as np

from mechanics.effects import Friction, Gravity, Resting, Rotation
from mechanics.rotation import about
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace
from mechanics.trajectory import Trajectory
from scenarios.motion import Motion, trajectory, vectors
from scenarios.scenario import Check, Scenario, Truth, scenario
from scenarios.swing import fall, fall_speed, fall_time
from scenarios.tolerance import GRAVITY, STEP, first_order

WIDTH, HEIGHT, MASS = 0.4, 1.0, 20.0  # [m], [m], [kg]
REACH = 0.5 * math.hypot(WIDTH, HEIGHT)  # from the edge to the centre [m]
LEAN = math.atan2(WIDTH, HEIGHT)  # of that line in the box, and so the tilt of the box in balance
RATE = math.sqrt(0.75 * GRAVITY / REACH)  # ψ̈ = 3g/(4R) sin ψ about the edge [rad/s]
ACROSS = (0.0, 1.0, 0.0)


def forces(angle: float, start: float, slope: float = 0.0) -> tuple[float, float]:
    """Push of the ground and drag along it, over the weight, when the centre is at `angle` from above the edge.

    The box fell from rest at `start` [rad]; the drag counts down the `slope` [rad] of the ground.
    """
    spin, pull = fall_speed(RATE, start, angle) ** 2 * REACH / GRAVITY, 0.75 * math.sin(angle)
    x = pull * math.cos(angle) - spin * math.sin(angle)
    z = 1.0 - pull * math.sin(angle) - spin * math.cos(angle)
    return x * math.sin(slope) + z * math.cos(slope), x * math.cos(slope) - z * math.sin(slope)


def grip_lost(start: float, mu: float, slope: float = 0.0) -> float:
    """Angle [rad] from above the edge at which the edge begins to slip, or ψ = π/2 if it does not before."""
    for angle in np.linspace(start, 0.5 * math.pi, 2000):
        push, drag = forces(float(angle), start, slope)
        if not mu * push > abs(drag):
            return float(angle)
    return 0.5 * math.pi


def about_the_edge(scene: Scene, start: float) -> Truth:
    """Motion of the box about its right lower edge, which is at the origin, from rest at `start` past balance."""

    def truth(t: np.ndarray) -> Trajectory:
        angle, rate = fall(t, RATE, start)
        sine, cosine = REACH * np.sin(angle), REACH * np.cos(angle)
        half = 0.5 * (angle + LEAN)
        q = np.stack([np.cos(half), 0.0 * half, np.sin(half), 0.0 * half], axis=-1)
        x, v = vectors(t, x=sine, z=cosine), vectors(t, x=rate * cosine, z=-rate * sine)
        return trajectory(scene, t, {"box": Motion(x, v, q, vectors(t, y=rate))})

    return truth


def box_on_edge(start: float) -> Body:
    """The box at rest, its right lower edge at the origin and its centre `start` [rad] past it."""
    place = (REACH * math.sin(start), 0.0, REACH * math.cos(start))
    turned = tuple(about(ACROSS, start + LEAN).tolist())
    return Body("box", Box((WIDTH, WIDTH, HEIGHT)), MASS, place, turned)


def toppling_checks(start: float, duration: float) -> tuple[Check, ...]:
    """What is demanded of a fall about an edge: first-order schemes are a step early or late."""
    angle, rate = (float(a[0]) for a in fall(np.array([duration]), RATE, start))
    jerk = RATE**2 * math.sin(angle) * STEP
    pace = (RATE**2 * math.sin(angle) + rate**2) * REACH * STEP
    return (
        first_order("position error", rate * REACH * STEP, "m", "v h: a first-order scheme is a step early or late"),
        first_order("velocity error", pace, "m/s", "(α + ω²) R h: a step's change of velocity"),
        first_order("orientation error", rate * STEP, "rad", "ω h: a first-order scheme is a step early or late"),
        first_order("angular velocity error", jerk, "rad/s", "α h: a step's change of angular velocity"),
    )


@scenario(
    tags=("resting", "friction", "box", "tipping"),
    suites=(),
    variants=({}, {"beyond": 10.0}),
    ranges={"beyond": (0.1, 60.0), "mu": (0.3, 10.0)},
)
def toppling_box(beyond: float = 2.0, mu: float = 1.0) -> Scenario:
    """A tall box stands on its lower edge, 2 degrees past balance, and falls over.

    The edge must stay where it is, so the box turns about it like a pendulum let go near its top, slowly
    at first.  The scene ends before friction can no longer hold the edge: near the ground the turning
    box presses on it hardly at all.
    """
    start = math.radians(beyond)
    scene = Scene((Body("floor", HalfSpace()), box_on_edge(start)), (Gravity(), Friction(mu), Resting(), Rotation()))
    duration = math.floor(100.0 * fall_time(RATE, start, grip_lost(start, mu))) / 100.0
    return Scenario(
        scene=scene,
        duration=duration,
        sampling=duration / 100.0,
        truth=about_the_edge(scene, start),
        checks=toppling_checks(start, duration),
        source="ψ̈ = 3g/(4R) sin ψ about the edge; Housner, Bull. Seismol. Soc. Am. 53 (1963) 403",
        about=(Gravity, Friction, Resting, Rotation),
    )
