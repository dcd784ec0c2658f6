"""A spinning ball strikes a rough floor."""

from __future__ import annotations

import math

import numpy as np

from mechanics.effects import Friction, Restitution, Rotation
from mechanics.rotation import exponential
from mechanics.scene import Body, Scene
from mechanics.shapes import HalfSpace, Sphere
from mechanics.trajectory import Trajectory
from scenarios.motion import Motion, trajectory, vectors
from scenarios.scenario import Scenario, scenario
from scenarios.tolerance import STEP, converged, first_order

RADIUS, MASS, RATIO = 0.1, 0.5, 0.4  # [m], [kg], moment of inertia over m R²
VELOCITY, CLEARANCE, DURATION = (2.0, 0.0, -3.0), 0.60011, 0.5  # [m/s], [m], [s]; strikes within a step
TOP = RADIUS + CLEARANCE  # [m]


def rough_impulse(
    approach: float, slip: float, e: float, mu: float, normal: float, tangential: float
) -> tuple[float, float]:
    """Impulses along the normal and against the slip of a central impact with Coulomb friction [N s].

    Parameters
    ----------
    approach : speed of approach [m/s]
    slip : tangential velocity of one surface against the other [m/s]
    normal, tangential : what a unit impulse changes of these [1/kg]; they do not act on each other

    The slip either comes to an end and stays at zero (it cannot turn round), or friction is µ times the
    normal impulse throughout.
    """
    push = (1.0 + e) * approach / normal
    return push, -math.copysign(min(mu * push, abs(slip) / tangential), slip)


def after_bounce(mu: float, e: float, v: tuple[float, float], spin: float, ratio: float) -> tuple[float, float, float]:
    """Velocities (along, up) [m/s] and spin about y [rad/s] of the ball after it came down with `v`, `spin`."""
    push, rub = rough_impulse(-v[1], v[0] - RADIUS * spin, e, mu, 1.0 / MASS, (1.0 + 1.0 / ratio) / MASS)
    return v[0] + rub / MASS, v[1] + push / MASS, spin - rub / (ratio * MASS * RADIUS)


@scenario(
    tags=("impact", "friction", "rotation"),
    suites=(),
    variants=({}, {"mu": 0.6}, {"mu": 0.6, "e": 0.0}),
    ranges={"mu": (0.0, 10.0), "e": (0.0, 1.0), "spin": (-1e3, 1e3)},
)
def rough_bounce(mu: float = 0.1, e: float = 0.8, spin: float = -10.0) -> Scenario:
    """A ball with backspin strikes a rough floor obliquely: with friction 0.1 it slips, with 0.6 it grips.

    Below µ = k s/((1 + k)(1 + e) v) = 0.159 the ball slips throughout and friction is µ times the blow;
    above, the contact point stops and µ drops out.  No gravity.
    """
    ball = Body("ball", Sphere(RADIUS), MASS, (0.0, 0.0, TOP), velocity=VELOCITY, angular_velocity=(0.0, spin, 0.0))
    scene = Scene((Body("floor", HalfSpace()), ball), (Restitution(e), Friction(mu), Rotation()))
    meeting = CLEARANCE / -VELOCITY[2]
    along, up, turn = after_bounce(mu, e, (VELOCITY[0], VELOCITY[2]), spin, RATIO)

    def truth(t: np.ndarray) -> Trajectory:
        before, after, hit = np.minimum(t, meeting), np.maximum(t - meeting, 0.0), t >= meeting
        x = vectors(t, x=VELOCITY[0] * before + along * after, z=TOP + VELOCITY[2] * before + up * after)
        v = vectors(t, x=np.where(hit, along, VELOCITY[0]), z=np.where(hit, up, VELOCITY[2]))
        q = exponential(vectors(t, y=spin * before + turn * after))
        return trajectory(scene, t, {"ball": Motion(x, v, q, vectors(t, y=np.where(hit, turn, spin)))})

    jump, twist = math.hypot(along - VELOCITY[0], up - VELOCITY[2]), abs(turn - spin)
    return Scenario(
        scene=scene,
        duration=DURATION,
        sampling=0.01,
        truth=truth,
        checks=(
            first_order("position error", jump * STEP, "m", "|Δv| h: the floor is seen up to one step late"),
            converged("velocity error", -VELOCITY[2], "the approach speed in m/s"),
            first_order("orientation error", twist * STEP, "rad", "|Δω| h: the floor is seen up to one step late"),
            converged("angular velocity error", -VELOCITY[2] / RADIUS, "the approach speed over the radius in rad/s"),
        ),
        source="Garwin, Am. J. Phys. 37 (1969) 88; Stronge, Impact Mechanics, ch. 5",
        about=(Restitution, Friction, Rotation),
        events=(meeting,),
    )
