"""Two spinning balls collide with friction."""

from __future__ import annotations

import math

import numpy as np

from mechanics.effects import Friction, Restitution, Rotation
from mechanics.rotation import exponential
from mechanics.scene import Body, Scene
from mechanics.shapes import Sphere
from mechanics.trajectory import Trajectory
from scenarios.motion import Motion, trajectory, vectors
from scenarios.rough_bounce import rough_impulse
from scenarios.scenario import Scenario, scenario
from scenarios.tolerance import STEP, converged, first_order, rounding

M, R = (1.0, 3.0), (0.2, 0.3)  # [kg], [m]
RATIO = 0.5  # moment of inertia over m R²: as of discs, so that the scene is the same in the plane and in space
SPEED, SPINS, MEETING, DURATION = 4.0, (-30.0, 5.0), 0.10037, 0.5  # [m/s], [rad/s] about y, [s], [s]


def after_contact(e: float, mu: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Velocities along x and z [m/s] and spins about y [rad/s] of both balls after they met, each (2,)."""
    m, r, w = np.array(M), np.array(R), np.array(SPINS)
    slip = float(-(r * w).sum())  # of the first surface against the second, along z
    push, rub = rough_impulse(SPEED, slip, e, mu, (1.0 / m).sum(), ((1.0 + 1.0 / RATIO) / m).sum())
    sign = np.array([1.0, -1.0])
    return np.array([SPEED, 0.0]) - sign * push / m, sign * rub / m, w - rub / (RATIO * m * r)


@scenario(
    tags=("impact", "friction", "rotation"),
    suites=(),
    variants=({}, {"mu": 1.0}),
    ranges={"mu": (0.0, 10.0), "e": (0.0, 1.0)},
)
def rough_collision(mu: float = 0.15, e: float = 0.7) -> Scenario:
    """Two balls that spin against each other collide head-on and rub: with friction 0.15 they slip, with 1 they grip.

    The blow sets both moving sideways and brakes both spins.  Momentum is kept, and so is angular
    momentum, which travels from spin to flight; friction may only take energy.  No gravity.
    """
    first = Body("first", Sphere(R[0]), M[0], (-(R[0] + R[1]) - SPEED * MEETING, 0.0, 0.0), velocity=(SPEED, 0.0, 0.0),
                 angular_velocity=(0.0, SPINS[0], 0.0), inertia=(RATIO * M[0] * R[0] ** 2,) * 3)  # fmt: skip
    second = Body("second", Sphere(R[1]), M[1], angular_velocity=(0.0, SPINS[1], 0.0),
                  inertia=(RATIO * M[1] * R[1] ** 2,) * 3)  # fmt: skip
    scene = Scene((first, second), (Restitution(e), Friction(mu), Rotation()))
    along, across, spins = after_contact(e, mu)

    def truth(t: np.ndarray) -> Trajectory:
        before, after, hit = np.minimum(t, MEETING), np.maximum(t - MEETING, 0.0), t >= MEETING
        motions = {}
        for k, (body, v) in enumerate(zip(scene.bodies, (SPEED, 0.0), strict=True)):
            x = vectors(t, x=body.position[0] + v * before + along[k] * after, z=across[k] * after)
            pace = vectors(t, x=np.where(hit, along[k], v), z=np.where(hit, across[k], 0.0))
            q = exponential(vectors(t, y=SPINS[k] * before + spins[k] * after))
            motions[body.name] = Motion(x, pace, q, vectors(t, y=np.where(hit, spins[k], SPINS[k])))
        return trajectory(scene, t, motions)

    return Scenario(
        scene=scene,
        duration=DURATION,
        sampling=0.01,
        truth=truth,
        checks=_checks(math.hypot(along[0] - SPEED, across[0]), float(np.abs(spins - SPINS).max())),
        source="Stronge, Impact Mechanics, ch. 5: µ times the normal impulse, at most what ends the slip",
        about=(Restitution, Friction, Rotation),
        events=(MEETING,),
    )


def _checks(jump: float, twist: float) -> tuple:
    return (
        first_order("position error", jump * STEP, "m", "|Δv| h: the collision is seen up to one step late"),
        converged("velocity error", SPEED, "the approach speed in m/s"),
        first_order("orientation error", twist * STEP, "rad", "|Δω| h: the collision is seen up to one step late"),
        converged("angular velocity error", SPEED / R[0], "the approach speed over the smaller radius in rad/s"),
        rounding("linear momentum error", "an impulse acts on both balls alike"),
    )
