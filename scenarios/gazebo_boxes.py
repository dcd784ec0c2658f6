"""The boxes scenes of the Gazebo benchmark, as published."""

from __future__ import annotations

import numpy as np

from mechanics.effects import Gravity, Rotation
from mechanics.scene import Body, Scene
from mechanics.shapes import Box
from mechanics.trajectory import Trajectory
from scenarios.free_rotation import free_rotation
from scenarios.motion import Motion, trajectory
from scenarios.scenario import Check, Scenario, scenario
from scenarios.tolerance import SAFETY, rounding

SIZE, MASS = (0.1, 0.4, 0.9), 10.0  # [m], [kg]
G = 9.8  # [m/s2], as published
DURATION = 10.0  # [s]
# Worse of explicit and linearly implicit Euler over the ten seconds, per second of step, relative; the
# tests integrate both schemes anew.
ENERGY_PER_STEP, MOMENTUM_PER_STEP = 13.5771, 13.0708


@scenario(
    tags=("published", "flight", "rotation"),
    suites=("published",),
    variants=({}, {"motion": "simple"}),
    ranges={"dt": (1e-6, 0.01), "motion": ("complex", "simple")},
)
def gazebo_boxes(motion: str = "complex", dt: float = 0.001) -> Scenario:
    """A box flies for 10 s: drifting in empty space (simple), or tumbling under gravity (complex).

    The Gazebo benchmark publishes the largest error of position, and those of energy and angular
    momentum relative to their start, at every step size.  The state is recorded at every step.
    """
    complex_motion = motion == "complex"
    velocity, spin = ((-2.0, 2.0, 8.0), (0.1, 5.0, 0.1)) if complex_motion else ((-0.9, 0.4, 0.1), (0.5, 0.0, 0.0))
    box = Body("box", Box(SIZE), mass=MASS, velocity=velocity, angular_velocity=spin)
    effects = (Gravity((0.0, 0.0, -G)), Rotation()) if complex_motion else (Rotation(),)
    scene = Scene((box,), effects)

    def truth(t: np.ndarray) -> Trajectory:
        s, g = t[:, None], scene.gravity
        q, w = free_rotation(np.diag(box.inertia_tensor), np.array(box.orientation), np.array(spin), t)
        path = np.array(velocity) * s + 0.5 * g * s**2
        return trajectory(scene, t, {"box": Motion(path, np.array(velocity) + g * s, q, w)})

    return Scenario(
        scene=scene,
        duration=DURATION,
        sampling=dt,
        truth=truth,
        checks=_checks(dt) if complex_motion else _simple_checks(),
        source="Peters and Hsu, ROSCon 2014 and Multibody Dynamics 2015, github.com/scpeters/benchmark, test 'boxes'",
        about=(Gravity, Rotation) if complex_motion else (Rotation,),
    )


def position_theory(dt: float) -> float:
    """Position error of semi-implicit Euler after the whole flight, g T h/2 [m]."""
    return G * DURATION * dt / 2.0


def _checks(dt: float) -> tuple[Check, ...]:
    """Of the complex scene: position falls behind by g T h/2, rotation errs like a first-order scheme at this step."""
    terms = (
        ("position error", position_theory(dt), "m", "g T h/2 of semi-implicit Euler"),
        (
            "relative energy error",
            ENERGY_PER_STEP * dt,
            "",
            "what Euler's method, explicit or linearly implicit, errs by",
        ),
        ("relative angular momentum error", MOMENTUM_PER_STEP * dt, "", "what Euler's method errs by"),
    )
    return tuple(
        Check(
            name,
            SAFETY * error,
            f"{formula} = {error:.3g} {unit}".strip() + f" at this step, times {SAFETY:g} for safety",
        )
        for name, error, unit, formula in terms
    )


def _simple_checks() -> tuple[Check, ...]:
    why = "uniform motion and uniform rotation about a principal axis: every scheme is exact"
    return (
        rounding("position error", why, exact=1e-11),
        rounding("orientation error", why, exact=1e-11),
        rounding("relative energy error", why),
        rounding("relative angular momentum error", why),
    )
