"""A hinged rod goes over the top, again and again."""

from __future__ import annotations

import math

import numpy as np

from mechanics.effects import Gravity, Hinge, Rotation
from mechanics.rotation import exponential
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, Sphere
from mechanics.trajectory import Trajectory
from scenarios.motion import Motion, trajectory, vectors
from scenarios.pendulum import ACROSS, ARMS, LENGTH, MASS, RATES
from scenarios.scenario import Check, Scenario, scenario
from scenarios.swing import whirl, whirl_time
from scenarios.tolerance import GRAVITY, STEP, first_order

ARM, RATE = ARMS["rod"], RATES["rod"]  # [m], of small swings [rad/s]


@scenario(
    tags=("joint", "pendulum"),
    suites=(),
    variants=({}, {"spin": 7.7}),
    ranges={"spin": (7.68, 100.0), "duration": (0.5, 100.0)},
)
def whirling_rod(spin: float = 9.0, duration: float = 3.0) -> Scenario:
    """A rod that hangs from a hinge is given 9 rad/s, enough to go over the top: a turn takes 0.94 s.

    At the bottom it turns twice as fast as at the top.  At 7.7 rad/s, hardly more than it needs, it creeps
    over; an engine that loses a little energy lets it fall back, and one that gains some is a turn ahead.
    """
    moment = MASS * LENGTH**2 / 12.0
    rod = Body(
        "rod",
        Box((0.05, 0.05, LENGTH)),
        MASS,
        (0.0, 0.0, -ARM),
        velocity=(spin * ARM, 0.0, 0.0),
        angular_velocity=(0.0, -spin, 0.0),
        inertia=(moment, moment, moment),
    )
    scene = Scene((Body("pivot", Sphere(0.02)), rod), (Gravity(), Rotation(), Hinge("pivot", "rod", axis=ACROSS)))

    def truth(t: np.ndarray) -> Trajectory:
        angle, rate = whirl(t, RATE, spin)
        sine, cosine = ARM * np.sin(angle), ARM * np.cos(angle)
        x, v = vectors(t, x=sine, z=-cosine), vectors(t, x=rate * cosine, z=rate * sine)
        return trajectory(scene, t, {"rod": Motion(x, v, exponential(vectors(t, y=-angle)), vectors(t, y=-rate))})

    return Scenario(
        scene=scene,
        duration=duration,
        sampling=duration / 300.0,
        truth=truth,
        checks=_checks(spin, duration),
        source="θ = 2 am (½ ω₀ t, 4 ω²/ω₀²); Landau and Lifshitz, Mechanics, §11; Abramowitz and Stegun, ch. 16",
        about=(Gravity, Hinge),
    )


def _checks(spin: float, duration: float) -> tuple[Check, ...]:
    """A step early or late in each turn, at the bottom; that is spin/slowest times as much in the angle at the top."""
    slowest = math.sqrt(spin**2 - 4.0 * RATE**2)
    late = (1.0 + duration / (2.0 * whirl_time(RATE, spin, math.pi))) * spin / slowest * STEP
    pull = 1.5 * GRAVITY / LENGTH + spin**2
    why = f"a step early or late in each turn, {spin / slowest:.2g} times as much where it is slowest: "
    return (
        first_order("position error", late * spin * ARM, "m", why + "v h"),
        first_order("velocity error", late * pull * ARM, "m/s", why + "(α + ω²) l h"),
        first_order("orientation error", late * spin, "rad", why + "ω h"),
        first_order("angular velocity error", late * 1.5 * GRAVITY / LENGTH, "rad/s", why + "α h"),
    )
