"""A ball strikes a rod that floats freely, off its middle."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mechanics.effects import Restitution, Rotation
from mechanics.rotation import exponential
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, Sphere
from mechanics.trajectory import Trajectory
from scenarios.because import UNTURNED
from scenarios.motion import Motion, trajectory, vectors
from scenarios.scenario import Scenario, Truth, scenario
from scenarios.tolerance import STEP, converged, first_order, rounding

LENGTH, THICK, ROD, BALL, RADIUS = 1.2, 0.1, 3.0, 0.5, 0.1  # [m], [m], [kg], [kg], [m]
MOMENT = ROD * LENGTH**2 / 12.0  # of a thin rod [kg m2]
SPEED, MEETING, DURATION = 4.0, 0.10037, 0.4  # [m/s], [s], [s]


class Struck(NamedTuple):
    """After the blow."""

    impulse: float  # [N s]
    rod: float  # [m/s]
    spin: float  # of the rod, about y [rad/s]
    ball: float  # [m/s]


def struck(e: float, offset: float) -> Struck:
    """Velocities after the ball has struck `offset` [m] above the middle of the rod."""
    impulse = (1.0 + e) * SPEED / (1.0 / BALL + 1.0 / ROD + offset**2 / MOMENT)
    return Struck(impulse, impulse / ROD, offset * impulse / MOMENT, SPEED - impulse / BALL)


def after_the_blow(scene: Scene, after: Struck) -> Truth:
    """Uniform motion before and after the blow."""
    start, _, offset = scene.body("ball").position

    def truth(t: np.ndarray) -> Trajectory:
        before, since, hit = np.minimum(t, MEETING), np.maximum(t - MEETING, 0.0), t >= MEETING
        x = vectors(t, x=after.rod * since), vectors(t, x=start + SPEED * before + after.ball * since, z=offset)
        v = (np.where(hit, after.rod, 0.0), np.where(hit, after.ball, SPEED))
        q, w = exponential(vectors(t, y=after.spin * since)), vectors(t, y=np.where(hit, after.spin, 0.0))
        return trajectory(
            scene, t, {"rod": Motion(x[0], vectors(t, x=v[0]), q, w), "ball": Motion(x[1], vectors(t, x=v[1]))}
        )

    return truth


@scenario(
    tags=("impact", "rotation", "box"),
    suites=(),
    variants=({}, {"offset": 0.0, "e": 1.0}),
    ranges={"e": (0.0, 1.0), "offset": (-0.55, 0.55)},
    because=UNTURNED,
)
def struck_rod(e: float = 0.7, offset: float = 0.4) -> Scenario:
    """A ball strikes an upright rod 0.4 m above its middle; the rod flies off and spins.

    The further from the middle, the less of the rod's mass the ball feels.  The rod begins to turn about
    a point 0.3 m below its middle, which stays at rest for an instant.  Momentum and angular momentum of
    both together are kept.  No gravity.
    """
    away = 0.5 * THICK + RADIUS
    rod = Body("rod", Box((THICK, THICK, LENGTH)), ROD, inertia=(MOMENT, MOMENT, MOMENT))
    start = (-away - SPEED * MEETING, 0.0, offset)
    ball = Body("ball", Sphere(RADIUS), BALL, start, velocity=(SPEED, 0.0, 0.0))
    scene = Scene((rod, ball), (Restitution(e), Rotation()))
    after = struck(e, offset)

    jump = SPEED - after.ball
    return Scenario(
        scene=scene,
        duration=DURATION,
        sampling=5e-3,
        truth=after_the_blow(scene, after),
        checks=(
            first_order("position error", jump * STEP, "m", "|Δv| h: the rod is seen up to one step late"),
            converged("velocity error", SPEED, "the approach speed in m/s"),
            first_order("orientation error", SPEED / LENGTH * STEP, "rad", "v h over the length: seen a step late"),
            converged("angular velocity error", SPEED / (0.5 * LENGTH), "the approach speed over half the length"),
            rounding("linear momentum error", "an impulse acts on both bodies alike"),
        ),
        source="Baraff, SIGGRAPH course notes (1997), §8; Kleppner and Kolenkow, Mechanics, ch. 6",
        about=(Restitution, Rotation),
        events=(MEETING,),
    )
