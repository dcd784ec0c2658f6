"""A body strikes a floor with a corner that is not below its centre."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from mechanics.effects import Friction, Restitution, Rotation
from mechanics.rotation import about, exponential
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace
from mechanics.trajectory import Trajectory
from scenarios.motion import Motion, trajectory, vectors
from scenarios.scenario import Check, Scenario, Truth, scenario
from scenarios.tolerance import STEP, first_order

MASS, SIZE = 2.0, (0.96, 0.96, 0.28)  # [kg], [m]; half a diagonal is 0.5 m: the arm of a rod of 1 m
ANGLE, BEVEL = math.radians(30.0), math.atan2(SIZE[2], SIZE[0])  # of the arm to the floor, and in the box
ARM = (-0.5 * math.cos(ANGLE), -0.5 * math.sin(ANGLE))  # from the centre to the corner, along x and z [m]
VELOCITY, SPIN, MEETING = (0.4, -3.0), -1.5, 0.1003  # [m/s], [rad/s] about y, [s]


class Blow(NamedTuple):
    """What an impact at the corner does."""

    push: float  # along the normal [N s]
    rub: float  # along the floor [N s]
    velocity: tuple[float, float]  # after it [m/s]
    spin: float  # after it, about y [rad/s]


def corner_blow(e: float, moment: float, grips: bool) -> Blow:
    """Impact of a corner of the body whose moment of inertia is `moment` [kg m2]; smooth, or without slip (`grips`).

    Along x and z a unit impulse at the arm (a, c) changes the corner's velocity by the matrix
    (1/m + c²/I, -a c/I; -a c/I, 1/m + a²/I).
    """
    a, c = ARM
    slip, approach = VELOCITY[0] + SPIN * c, VELOCITY[1] - SPIN * a
    if grips:
        w = np.array([[1.0 / MASS + c * c / moment, -a * c / moment], [-a * c / moment, 1.0 / MASS + a * a / moment]])
        rub, push = np.linalg.solve(w, [-slip, -(1.0 + e) * approach])
    else:
        rub, push = 0.0, -(1.0 + e) * approach / (1.0 / MASS + a * a / moment)
    after = (VELOCITY[0] + rub / MASS, VELOCITY[1] + push / MASS)
    return Blow(float(push), float(rub), after, float(SPIN + (c * rub - a * push) / moment))


def struck(scene: Scene, blow: Blow, turned: float) -> Truth:
    """Uniform motion before and after the blow, at which the body is `turned` [rad] about y."""

    def truth(t: np.ndarray) -> Trajectory:
        since, hit = t - MEETING, t >= MEETING
        v = vectors(t, *(np.where(hit, b, a) for a, b in ((VELOCITY[0], blow.velocity[0]), (0.0, 0.0))))
        v[:, 2] = np.where(hit, blow.velocity[1], VELOCITY[1])
        spin = np.where(hit, blow.spin, SPIN)
        x = np.array([0.0, 0.0, -ARM[1]]) + v * since[:, None]
        q = exponential(vectors(t, y=turned + spin * since))
        return trajectory(scene, t, {"plank": Motion(x, v, q, vectors(t, y=spin))})

    return truth


@scenario(
    tags=("impact", "rotation", "box"),
    suites=(),
    variants=({}, {"gyration": 0.25}, {"e": 0.0, "mu": 1.0}),
    ranges={"e": (0.0, 1.0), "gyration": (0.05, 0.25), "mu": (0.0, 10.0)},
)
def eccentric_impact(e: float = 0.6, gyration: float = 1.0 / 12.0, mu: float = 0.0) -> Scenario:
    """A turning plank strikes the floor with one end, bounces there and is thrown into a fast spin.

    The blow acts beside the centre, so it must turn the plank as well as stop it: j = -(1 + e) u/(1/m + a²/I)
    (Baraff).  Without bounce and with friction that grips (e = 0, µ = 1) the end stops dead.  The moment
    of inertia is `gyration` times m 1 m²: 1/12 as of a rod, 1/4 as of a dumb-bell.  No gravity.
    """
    moment = gyration * MASS
    blow = corner_blow(e, moment, mu > 0.0)
    turned = BEVEL - ANGLE  # about y, at the impact; the corner is at the angle ANGLE below the horizontal
    start = (-VELOCITY[0] * MEETING, -ARM[1] - VELOCITY[1] * MEETING)
    plank = Body("plank", Box(SIZE), MASS, (start[0], 0.0, start[1]),
                 tuple(about((0.0, 1.0, 0.0), turned - SPIN * MEETING).tolist()), (VELOCITY[0], 0.0, VELOCITY[1]),
                 (0.0, SPIN, 0.0), (moment, moment, moment))  # fmt: skip
    rough = (Friction(mu),) if mu else ()
    scene = Scene((Body("floor", HalfSpace()), plank), (Restitution(e), *rough, Rotation()))

    return Scenario(
        scene=scene,
        duration=0.14,
        sampling=2e-3,
        truth=struck(scene, blow, turned),
        checks=_checks(blow),
        source="Baraff, SIGGRAPH course notes (1997), §8; Routh, Rigid Dynamics, Elementary Part, ch. IV",
        about=(Restitution, Rotation, *((Friction,) if mu else ())),
        events=(MEETING,),
    )


def _checks(blow: Blow) -> tuple[Check, ...]:
    """A step late the arm has turned by ω h, which changes it, and so what the blow does, by as much."""
    jump = math.hypot(blow.velocity[0] - VELOCITY[0], blow.velocity[1] - VELOCITY[1])
    turn, twist = abs(SPIN) * STEP / math.tan(ANGLE), abs(blow.spin - SPIN)
    return (
        first_order("position error", jump * STEP, "m", "|Δv| h: the floor is seen up to one step late"),
        first_order("velocity error", 2.0 * jump * turn, "m/s", "2 |Δv| ω h/tan θ: meanwhile the arm turns by ω h"),
        first_order("orientation error", twist * STEP, "rad", "|Δω| h: the floor is seen up to one step late"),
        first_order("angular velocity error", 2.0 * twist * turn, "rad/s", "2 |Δω| ω h/tan θ, likewise"),
    )
