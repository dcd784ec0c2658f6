"""A ball strikes a rod that hangs from a hinge."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mechanics.effects import Hinge, Restitution, Rotation
from mechanics.rotation import exponential
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, Sphere
from mechanics.trajectory import Trajectory
from scenarios.motion import Motion, trajectory, vectors
from scenarios.scenario import Scenario, Truth, scenario
from scenarios.tolerance import STEP, converged, first_order

LENGTH, THICK, ROD, BALL, RADIUS = 1.2, 0.1, 3.0, 0.2, 0.05  # [m], [m], [kg], [kg], [m]
ABOUT_HINGE = ROD * LENGTH**2 / 3.0  # moment of a thin rod about its end [kg m2]
SPEED, MEETING, DURATION = 10.0, 0.0503, 0.2  # [m/s], [s], [s]


class Struck(NamedTuple):
    """After the blow."""

    impulse: float  # on the rod [N s]
    spin: float  # of the rod, forwards [rad/s]
    ball: float  # [m/s]
    hinge: float  # impulse of the hinge on the rod, forwards [N s]


def struck(e: float, depth: float) -> Struck:
    """Velocities after the ball has struck `depth` [m] below the hinge; no hinge is needed at two thirds of the rod."""
    impulse = (1.0 + e) * SPEED / (1.0 / BALL + depth**2 / ABOUT_HINGE)
    spin = depth * impulse / ABOUT_HINGE
    return Struck(impulse, spin, SPEED - impulse / BALL, 0.5 * ROD * LENGTH * spin - impulse)


def after_the_blow(scene: Scene, after: Struck) -> Truth:
    """Uniform motion before and after the blow, of the rod about its hinge at the origin."""
    start, _, height = scene.body("ball").position

    def truth(t: np.ndarray) -> Trajectory:
        before, since, hit = np.minimum(t, MEETING), np.maximum(t - MEETING, 0.0), t >= MEETING
        turn, rate = after.spin * since, np.where(hit, after.spin, 0.0)
        sine, cosine = 0.5 * LENGTH * np.sin(turn), 0.5 * LENGTH * np.cos(turn)
        x, v = vectors(t, x=sine, z=-cosine), vectors(t, x=rate * cosine, z=rate * sine)
        motion = Motion(x, v, exponential(vectors(t, y=-turn)), vectors(t, y=-rate))
        place = vectors(t, x=start + SPEED * before + after.ball * since, z=height)
        flight = Motion(place, vectors(t, x=np.where(hit, after.ball, SPEED)))
        return trajectory(scene, t, {"rod": motion, "ball": flight})

    return truth


@scenario(
    tags=("impact", "joint", "rotation"),
    suites=(),
    variants=({}, {"depth": 0.8}),
    ranges={"e": (0.1, 1.0), "depth": (0.2, 1.1)},
)
def struck_pendulum(e: float = 0.5, depth: float = 0.9) -> Scenario:
    """A ball strikes a rod that hangs from a hinge, 0.9 m below it, and the rod swings away.

    The hinge must answer the blow at the same instant, or the rod flies off.  Struck at two thirds of its
    length, the centre of percussion, the rod would turn about its end by itself and the hinge feels nothing;
    struck below, the hinge pushes forwards.  No gravity.
    """
    moment = ROD * LENGTH**2 / 12.0
    rod = Body("rod", Box((THICK, THICK, LENGTH)), ROD, (0.0, 0.0, -0.5 * LENGTH), inertia=(moment, moment, moment))
    start = -0.5 * THICK - RADIUS - SPEED * MEETING
    ball = Body("ball", Sphere(RADIUS), BALL, (start, 0.0, -depth), velocity=(SPEED, 0.0, 0.0))
    scene = Scene((Body("pivot", Sphere(0.02)), rod, ball), (Restitution(e), Rotation(), Hinge("pivot", "rod")))
    after = struck(e, depth)

    jump = SPEED - after.ball
    return Scenario(
        scene=scene,
        duration=DURATION,
        sampling=2e-3,
        truth=after_the_blow(scene, after),
        checks=(
            first_order("position error", jump * STEP, "m", "|Δv| h: the rod is seen up to one step late"),
            converged("velocity error", SPEED, "the approach speed in m/s"),
            first_order("orientation error", after.spin * STEP, "rad", "ω h: the rod is seen up to one step late"),
            converged("angular velocity error", SPEED / (0.5 * LENGTH), "the approach speed over half the length"),
        ),
        source="ω = (1 + e) m v x/(I + m x²) about the hinge; Meriam and Kraige, Dynamics (centre of percussion)",
        about=(Restitution, Hinge, Rotation),
        events=(MEETING,),
    )
