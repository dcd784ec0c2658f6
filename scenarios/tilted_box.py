"""A tall box on a slope: it stays, slides or tips."""

from __future__ import annotations

import math

import numpy as np

from mechanics.effects import Friction, Gravity, Resting, Rotation
from mechanics.rotation import about
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace
from mechanics.trajectory import Trajectory
from scenarios.because import STANDING
from scenarios.motion import Motion, trajectory
from scenarios.scenario import Check, Scenario, Truth, scenario
from scenarios.swing import fall_time
from scenarios.tolerance import GRAVITY, STEP, first_order
from scenarios.toppling_box import (
    ACROSS,
    HEIGHT,
    LEAN,
    MASS,
    RATE,
    WIDTH,
    about_the_edge,
    grip_lost,
    toppling_checks,
)


def thresholds(mu: float) -> tuple[float, float]:
    """Slopes [rad] at which a box on a plane begins to tip, atan (width/height), and to slide, atan µ."""
    return math.atan2(WIDTH, HEIGHT), math.atan(mu)


def sliding_down(scene: Scene, angle: float, mu: float) -> Truth:
    """The box slides, or stays, without turning: g (sin α - µ cos α) along the slope if that is positive."""
    pull = max(0.0, GRAVITY * (math.sin(angle) - mu * math.cos(angle)))
    down = np.array([math.cos(angle), 0.0, -math.sin(angle)])

    def truth(t: np.ndarray) -> Trajectory:
        path = np.array(scene.body("box").position) + 0.5 * pull * t[:, None] ** 2 * down
        return trajectory(scene, t, {"box": Motion(path, pull * t[:, None] * down)})

    return truth


def sliding_checks(angle: float, mu: float, duration: float) -> tuple[Check, ...]:
    """What is demanded of a box that slides or stays and must not turn."""
    push = GRAVITY * (math.sin(angle) + mu * math.cos(angle))
    spin = 2.0 * GRAVITY * STEP / math.hypot(0.5 * WIDTH, 0.5 * HEIGHT)
    return (
        first_order("position error", push * duration * STEP / 2.0, "m", "(g sin α + µ g cos α) t h/2"),
        first_order("velocity error", push * STEP, "m/s", "(g sin α + µ g cos α) h: one step's change"),
        first_order("tilt", 0.5 * spin * duration * STEP, "rad", "g h t/R h: a step's fall at one edge, as a turn"),
        first_order("angular velocity error", spin, "rad/s", "2 g h/R: a step's fall at one edge, as spin"),
    )


@scenario(
    tags=("friction", "resting", "box", "tipping"),
    suites=(),
    variants=({}, {"slope": 18.0}, {"slope": 25.0, "mu": 0.6}),
    ranges={"slope": (0.0, 45.0), "mu": (0.0, 10.0)},
    because=STANDING,
)
def tilted_box(slope: float = 15.0, mu: float = 0.3) -> Scenario:
    """A box of 0.4 m by 1 m stands on a slope: at 15 degrees it stays, at 18 it slides, at 25 on a rougher one it tips.

    It slides where tan α > µ and tips where tan α > width/height = 0.4, whichever comes first.  Sliding
    must not turn it and tipping must not make it slip; the scene ends before the edge it tips about would.
    """
    angle = math.radians(slope)
    tips, slides = thresholds(mu)
    normal = np.array([math.sin(angle), 0.0, math.cos(angle)])
    down = np.array([math.cos(angle), 0.0, -math.sin(angle)])
    place = 0.5 * HEIGHT * normal - 0.5 * WIDTH * down  # the lower edge is at the origin
    box = Body("box", Box((WIDTH, WIDTH, HEIGHT)), MASS, tuple(place.tolist()), tuple(about(ACROSS, angle).tolist()))
    plane = Body("plane", HalfSpace(tuple(normal.tolist())))
    scene = Scene((plane, box), (Gravity(), Friction(mu), Resting(), Rotation()))
    if tips < min(angle, slides):
        start = angle - LEAN
        duration = math.floor(100.0 * fall_time(RATE, start, grip_lost(start, mu, angle))) / 100.0
        truth, checks = about_the_edge(scene, start), toppling_checks(start, duration)
    else:
        duration = 1.0
        truth, checks = sliding_down(scene, angle, mu), sliding_checks(angle, mu, duration)
    return Scenario(
        scene=scene,
        duration=duration,
        sampling=duration / 100.0,
        truth=truth,
        checks=checks,
        source="slides if tan α > µ, tips if tan α > width/height; Meriam and Kraige, Statics",
        about=(Gravity, Friction, Resting, Rotation),
    )
