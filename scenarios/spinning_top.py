"""A top whose foot stays where it is: it precesses, and it nods."""

from __future__ import annotations

import math

import numpy as np

from mechanics.effects import Gravity, Rod, Rotation
from mechanics.rotation import about
from mechanics.scene import Body, Scene
from mechanics.shapes import Cylinder, Sphere
from mechanics.trajectory import Trajectory
from scenarios.heavy_top import Release, attitude, axis, direction
from scenarios.motion import Motion, trajectory
from scenarios.scenario import Scenario, Truth, scenario
from scenarios.tolerance import GRAVITY, first_order

MASS, ARM = 0.5, 0.04  # [kg], from the foot to the centre of mass [m]
ACROSS, ALONG = 1.2e-3, 2.5e-4  # moments about the foot, across the axis and along it [kg m2]
STAND = 0.05  # length of the three rods that hold the foot [m]
TILT, SPIN, DURATION = math.radians(30.0), 150.0, 0.3  # from upright, along the axis [rad/s], a little over one nod [s]

# Distance from the closed form of linearly implicit Euler about the foot at 1 ms, with exact turns:
# place [m], velocity [m/s], attitude [rad], angular velocity [rad/s].  The tests integrate it anew.
EULER = {"steady": (9.82e-3, 0.0537, 0.264, 35.7), "nutating": (0.0142, 0.182, 0.357, 49.3)}


def released(tilt: float, spin: float, precession: float) -> Release:
    """The top let go at `tilt` from upright [rad], with `spin` along its axis, going round at `precession` [rad/s]."""
    return Release(2.0 * MASS * GRAVITY * ARM / ACROSS, ALONG * spin / ACROSS, tilt, precession, spin)


def steady(tilt: float, spin: float) -> tuple[float, float]:
    """The slow and the fast rate [rad/s] at which the top precesses steadily: I₁ Ω² cos θ - I₃ ω₃ Ω + m g l = 0."""
    momentum, rise = ALONG * spin, ACROSS * math.cos(tilt)
    fast = 0.5 * (momentum + math.sqrt(momentum**2 - 4.0 * rise * MASS * GRAVITY * ARM)) / rise
    return MASS * GRAVITY * ARM / (rise * fast), fast


def sleeping_spin() -> float:
    """Least spin [rad/s] with which an upright top stays upright: I₃² ω₃² = 4 I₁ m g l."""
    return math.sqrt(4.0 * ACROSS * MASS * GRAVITY * ARM) / ALONG


def top_on_its_foot(top: Release) -> Scene:
    """The top, its foot at the origin, held there by three rods at right angles to each other: a ball joint."""
    body = Body(
        "top",
        Cylinder(0.03, 0.05),
        MASS,
        (ARM * math.sin(top.angle), 0.0, ARM * math.cos(top.angle)),
        tuple(about((0.0, 1.0, 0.0), top.angle).tolist()),
        velocity=(0.0, ARM * math.sin(top.angle) * top.round, 0.0),
        angular_velocity=tuple(attitude(axis(top, np.zeros(1)))[1][0].tolist()),
        inertia=(ACROSS - MASS * ARM**2, ACROSS - MASS * ARM**2, ALONG),
    )
    foot = (0.0, 0.0, -ARM)
    legs = [Rod("stand", "top", anchor_a=end, anchor_b=foot) for end in (STAND * np.diag([1.0, 1.0, -1.0])).tolist()]
    return Scene((Body("stand", Sphere(0.01)), body), (Gravity(), Rotation(), *legs))


def round_its_foot(scene: Scene, top: Release) -> Truth:
    """Motion of the top after it was let go."""

    def truth(t: np.ndarray) -> Trajectory:
        way = axis(top, t)
        out, rate = direction(way)
        return trajectory(scene, t, {"top": Motion(ARM * out, ARM * rate, *attitude(way))})

    return truth


def _scenario(top: Release, euler: tuple[float, float, float, float], source: str) -> Scenario:
    scene, why = top_on_its_foot(top), "what linearly implicit Euler errs by here; explicit Euler is unstable"
    place, pace, turn, spin = euler
    return Scenario(
        scene=scene,
        duration=DURATION,
        sampling=2e-3,
        truth=round_its_foot(scene, top),
        checks=(
            first_order("position error", place, "m", why),
            first_order("velocity error", pace, "m/s", why),
            first_order("orientation error", turn, "rad", why),
            first_order("angular velocity error", spin, "rad/s", why),
        ),
        source=source,
        about=(Gravity, Rod, Rotation),
    )


@scenario(tags=("joint", "rotation", "top"), suites=())
def steady_top() -> Scenario:
    """A fast top leans by 30 degrees and does not fall: its axis goes round the vertical, once a second.

    Its weight turns the angular momentum of the spin instead of tipping it over.  Let go at just the right
    rate the axis goes round evenly and stays at its angle.  The foot is held as by a tripod, by three rods,
    which together are a ball joint.
    """
    rate, _ = steady(TILT, SPIN)
    source = "I₁ Ω² cos θ - I₃ ω₃ Ω + m g l = 0; Goldstein, Classical Mechanics, 3rd ed., §5.7"
    return _scenario(released(TILT, SPIN, rate), EULER["steady"], source)


@scenario(tags=("joint", "rotation", "top"), suites=())
def nutating_top() -> Scenario:
    """A fast top is let go with its axis at rest: it falls a little, swerves aside, rises again, and so on.

    The path of its axis is a row of arches with cusps at the top, one in 0.28 s.  An engine that leaves out
    the gyroscopic moment lets it fall over; one that damps makes the arches flat.
    """
    source = "cos θ = u₁ + (u₂ - u₁) sn²; Whittaker, Analytical Dynamics, §71"
    return _scenario(released(TILT, SPIN, 0.0), EULER["nutating"], source)
