"""A slab with balls on it is pulled over a rough floor."""

from __future__ import annotations

import math

import numpy as np

from mechanics.effects import Force, Friction, Gravity, Resting, Rotation
from mechanics.rotation import exponential
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Sphere
from mechanics.trajectory import Trajectory
from scenarios.motion import Motion, trajectory
from scenarios.scenario import Check, Scenario, Truth, scenario
from scenarios.tolerance import GRAVITY, STEP, first_order

SLAB, THICK, BALL, RADIUS = 10.0, 0.5, 1.0, 0.25  # [kg], [m], [kg], [m]; binary fractions: they touch bit by bit
PITCH, FLOOR, DURATION = 1.0, 0.4, 1.0  # [m], friction of the floor, [s]


def accelerations(force: float, count: int) -> tuple[float, float]:
    """Of the slab and of the balls [m/s2] under `force` [N]: a solid ball that rolls takes 2/7 of what is below it."""
    balls = (force - FLOOR * (SLAB + count * BALL) * GRAVITY) / (3.5 * SLAB + count * BALL)
    return 3.5 * balls, balls


def rolling(scene: Scene, along: np.ndarray, fast: float, slow: float) -> Truth:
    """The slab accelerates `along` by `fast`, the balls by `slow` [m/s2], which makes them turn backwards."""
    axis = np.array([-along[1], along[0], 0.0]) * (slow - fast) / RADIUS  # of their angular acceleration

    def truth(t: np.ndarray) -> Trajectory:
        s, motions = t[:, None], {}
        turned, spin = exponential(0.5 * s**2 * axis), s * axis
        for body in (scene.bodies[i] for i in scene.moving):
            slides = isinstance(body.shape, Box)
            a = (fast if slides else slow) * along
            x = np.array(body.position) + 0.5 * a * s**2
            motions[body.name] = Motion(x, a * s) if slides else Motion(x, a * s, turned, spin)
        return trajectory(scene, t, motions)

    return truth


@scenario(
    tags=("friction", "rotation", "rolling", "many-contacts"),
    suites=(),
    variants=({}, {"heading": 45.0}),
    ranges={"heading": (-180.0, 180.0), "side": (1, 5), "mu": (0.1, 10.0)},
)
def slab_with_balls(heading: float = 0.0, side: int = 3, mu: float = 0.8) -> Scenario:
    """A slab that carries nine balls is pulled over a rough floor; the balls roll on it and are left behind.

    The floor brakes the slab by µ times the whole weight, and each ball that rolls without slip takes 2/7 of
    the slab's acceleration.  Pulled at 45 degrees nothing changes, unless friction is a pyramid.
    """
    count, along = side**2, np.array([math.cos(math.radians(heading)), math.sin(math.radians(heading)), 0.0])
    along = np.where(np.abs(along) < 1e-15, 0.0, along)
    force = 1.3 * FLOOR * (SLAB + count * BALL) * GRAVITY
    slab = Body("slab", Box((PITCH * (side + 1), PITCH * (side + 1), THICK)), SLAB, (0.0, 0.0, 0.5 * THICK))
    places = [
        ((i - 0.5 * (side - 1)) * PITCH, (j - 0.5 * (side - 1)) * PITCH) for i in range(side) for j in range(side)
    ]
    balls = [Body(f"ball-{k + 1}", Sphere(RADIUS), BALL, (x, y, THICK + RADIUS)) for k, (x, y) in enumerate(places)]
    pull = Force("slab", tuple((force * along).tolist()), point=(0.0, 0.0, -0.5 * THICK))
    rough = Friction(mu, {("floor", body.name): FLOOR for body in (slab, *balls)})
    scene = Scene((Body("floor", HalfSpace()), slab, *balls), (Gravity(), rough, Resting(), Rotation(), pull))
    fast, slow = accelerations(force, count)

    return Scenario(
        scene=scene,
        duration=DURATION,
        sampling=0.02,
        truth=rolling(scene, along, fast, slow),
        checks=_checks(force / SLAB, fast),
        source="Kang and Hwangbo, SimBenchmark (2018), test 'rolling'; a = 2/7 of the board's for a solid ball",
        about=(Gravity, Friction, Resting, Rotation, Force),
    )


def _checks(push: float, pace: float) -> tuple[Check, ...]:
    spin = pace / RADIUS
    return (
        first_order("position error", push * DURATION * STEP, "m", "F/M h t: friction sets in up to a step late"),
        first_order("velocity error", push * STEP, "m/s", "F/M h: what the pull changes before friction answers"),
        first_order("orientation error", spin * DURATION * STEP, "rad", "a/R h t: rolling sets in up to a step late"),
        first_order("angular velocity error", spin * STEP, "rad/s", "a/R h: what one step changes"),
    )
