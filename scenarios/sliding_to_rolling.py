"""A bowling ball slides and begins to roll."""

from __future__ import annotations

import math

import numpy as np

from mechanics.effects import Friction, Gravity, Resting, Rotation
from mechanics.rotation import exponential
from mechanics.scene import Body, Scene
from mechanics.shapes import HalfSpace, Sphere
from mechanics.trajectory import Trajectory
from scenarios.motion import Motion, trajectory, vectors
from scenarios.scenario import Check, Scenario, scenario
from scenarios.tolerance import GRAVITY, STEP, first_order

RADIUS, MASS = 0.108, 6.0  # [m], [kg]
RATIO = 0.4  # moment of inertia over m R²: a solid ball


@scenario(
    tags=("friction", "rotation", "rolling"),
    suites=("smoke", "standard"),
    variants=({}, {"backspin": 50.0}),
    ranges={"speed": (0.01, 100.0), "mu": (0.01, 10.0), "backspin": (-1e3, 1e3)},
)
def sliding_to_rolling(speed: float = 3.0, mu: float = 0.3, backspin: float = 0.0) -> Scenario:
    """A bowling ball set down sliding at 3 m/s ends up rolling at 5/7 of that, whatever the friction.

    While it slips, friction brakes the ball and spins it up; once it rolls, friction must vanish.
    Backspin [rad/s] takes more speed away.
    """
    start = (0.0, 0.0, RADIUS)
    ball = Body("ball", Sphere(RADIUS), MASS, start, velocity=(speed, 0.0, 0.0), angular_velocity=(0.0, -backspin, 0.0))
    effects = (Gravity(), Friction(mu), Resting(), Rotation())
    scene = Scene((Body("floor", HalfSpace()), ball), effects)
    slip = speed + RADIUS * backspin
    brake = math.copysign(mu * GRAVITY, slip)
    rolls = RATIO * abs(slip) / ((1.0 + RATIO) * mu * GRAVITY)
    duration = 1.0 if rolls < 0.8 else round(1.25 * rolls, 2)

    def truth(t: np.ndarray) -> Trajectory:
        s, rest = np.minimum(t, rolls), np.maximum(t - rolls, 0.0)
        v = speed - brake * s
        spin = -backspin + brake * s / (RATIO * RADIUS)
        path = speed * s - 0.5 * brake * s**2 + v * rest
        angle = -backspin * s + 0.5 * brake * s**2 / (RATIO * RADIUS) + spin * rest
        x, w = vectors(t, x=path, z=RADIUS), vectors(t, y=spin)
        return trajectory(scene, t, {"ball": Motion(x, vectors(t, x=v), exponential(vectors(t, y=angle)), w)})

    return Scenario(
        scene=scene,
        duration=duration,
        sampling=0.01,
        truth=truth,
        checks=_checks(abs(brake), duration),
        source="rolls at v = 5/7 v₀ from t = 2 v₀/(7 µ g) on; Hopkins and Patterson, Am. J. Phys. 45 (1977) 263",
        about=(Gravity, Friction, Resting, Rotation),
        events=(rolls,),
    )


def _checks(brake: float, duration: float) -> tuple[Check, ...]:
    """Friction sets in, or ends, up to a step late: `brake` [m/s2] acts for one step too many or too few."""
    pace, spin = brake * STEP, brake * STEP / (RATIO * RADIUS)
    return (
        first_order("position error", pace * duration, "m", "µ g h t: friction sets in, or ends, up to a step late"),
        first_order("velocity error", pace, "m/s", "µ g h: what friction changes in one step"),
        first_order("orientation error", spin * duration, "rad", "5/2 µ g h t/R: the same step, as spin"),
        first_order("angular velocity error", spin, "rad/s", "5/2 µ g h/R: what friction changes in one step"),
    )
