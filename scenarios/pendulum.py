"""A pendulum swings, wide."""

from __future__ import annotations

import math

import numpy as np

from mechanics.effects import Gravity, Hinge, Rod, Rotation
from mechanics.rotation import about, exponential
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, Sphere
from mechanics.trajectory import Trajectory
from scenarios.motion import Motion, trajectory, vectors
from scenarios.scenario import Check, Scenario, Truth, scenario
from scenarios.swing import quarter, swing
from scenarios.tolerance import GRAVITY, STEP, first_order

LENGTH, MASS = 1.0, 1.0  # [m], [kg]
ACROSS = (0.0, 1.0, 0.0)
ARMS = {"bob": LENGTH, "rod": 0.5 * LENGTH}  # from the pivot to the centre of mass [m]
RATES = {"bob": math.sqrt(GRAVITY / LENGTH), "rod": math.sqrt(1.5 * GRAVITY / LENGTH)}  # of small swings [rad/s]


def hung(kind: str, angle: float) -> tuple[tuple[Body, ...], tuple]:
    """Pivot and body at rest at `angle` [rad] from straight down, and the joint between them.

    A "bob" is a point on a massless rod, a "rod" a thin uniform rod hinged at its end.
    """
    place = (ARMS[kind] * math.sin(angle), 0.0, -ARMS[kind] * math.cos(angle))
    pivot = Body("pivot", Sphere(0.02))
    if kind == "bob":
        return (pivot, Body("bob", Sphere(0.05), MASS, place)), (Rod("pivot", "bob"),)
    moment, turned = MASS * LENGTH**2 / 12.0, tuple(about(ACROSS, -angle).tolist())
    rod = Body("rod", Box((0.05, 0.05, LENGTH)), MASS, place, turned, inertia=(moment, moment, moment))
    return (pivot, rod), (Rotation(), Hinge("pivot", "rod", axis=ACROSS))


def swinging(scene: Scene, kind: str, amplitude: float) -> Truth:
    """Motion after release from rest at `amplitude` [rad]."""

    def truth(t: np.ndarray) -> Trajectory:
        angle, rate = swing(t, RATES[kind], amplitude)
        sine, cosine = ARMS[kind] * np.sin(angle), ARMS[kind] * np.cos(angle)
        x, v = vectors(t, x=sine, z=-cosine), vectors(t, x=rate * cosine, z=rate * sine)
        turn = (exponential(vectors(t, y=-angle)), vectors(t, y=-rate)) if kind == "rod" else ()
        return trajectory(scene, t, {kind: Motion(x, v, *turn)})

    return truth


@scenario(
    tags=("joint", "pendulum"),
    suites=(),
    variants=({}, {"kind": "rod"}, {"kind": "rod", "amplitude": 175.0}, {"amplitude": 90.0, "duration": 10.0}),
    ranges={"kind": ("bob", "rod"), "amplitude": (0.1, 179.0), "duration": (0.5, 100.0)},
)
def pendulum(kind: str = "bob", amplitude: float = 120.0, duration: float = 3.0) -> Scenario:
    """A pendulum, a point on a massless rod or a uniform rod on a hinge, swings out to 120 degrees and back.

    So far out it is no harmonic oscillator: its period is 37 % longer than that of small swings, and an elliptic
    function says where it is.  The joint must hold its length, and no energy may leak out of it.
    """
    angle = math.radians(amplitude)
    bodies, joint = hung(kind, angle)
    scene = Scene(bodies, (Gravity(), *joint))
    return Scenario(
        scene=scene,
        duration=duration,
        sampling=duration / 300.0,
        truth=swinging(scene, kind, angle),
        checks=_checks(kind, angle, duration),
        source="θ = 2 asin (k cd (ω t, k²)), k = sin (θ₀/2); Landau and Lifshitz, Mechanics, §11",
        about=(Gravity, Rod if kind == "bob" else Hinge),
    )


def _checks(kind: str, amplitude: float, duration: float) -> tuple[Check, ...]:
    """A first-order scheme is a step early or late, and errs in the period by as much each time it turns round."""
    turns = 1.0 + duration / (2.0 * quarter(RATES[kind], amplitude))
    spin = 2.0 * RATES[kind] * math.sin(0.5 * amplitude)
    pull = RATES[kind] ** 2 * math.sin(min(amplitude, 0.5 * math.pi)) + spin**2
    why = f"each of {turns:.2g} half swings a step early or late: "
    checks = (
        first_order("position error", turns * spin * ARMS[kind] * STEP, "m", why + "v h"),
        first_order("velocity error", turns * pull * ARMS[kind] * STEP, "m/s", why + "(α + ω²) l h"),
    )
    if kind == "bob":
        return checks
    return (
        *checks,
        first_order("orientation error", turns * spin * STEP, "rad", why + "ω h"),
        first_order("angular velocity error", turns * pull * STEP, "rad/s", why + "(α + ω²) h"),
    )
