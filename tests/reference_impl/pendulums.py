"""Pendulums: bobs, where they hang, how they swing and what energy they have."""

import math

import numpy as np
from scipy.special import ellipj, ellipk

from mechanics.rotation import unrotate
from mechanics.scene import Body
from mechanics.shapes import Sphere

G = 9.81  # [m/s2]
PIVOT = Body("pivot", Sphere(0.01))
UP = (0.0, 0.0, 1.0)
STEP = 1e-13  # error allowed in one step of bodies that swing, a tenth of the tolerance of all others


def bob(name, place, velocity=(0.0, 0.0, 0.0), mass=1.0, radius=0.05):
    return Body(name, Sphere(radius), mass, tuple(float(c) for c in place), velocity=tuple(float(c) for c in velocity))


def down(angle, length=1.0):
    """Place at this angle from straight down, towards x."""
    return np.array((length * math.sin(angle), 0.0, -length * math.cos(angle)))


def swing(amplitude, rate, t):
    """Angle of a pendulum of small-amplitude frequency `rate`, released from rest at `amplitude`: 2 asin(k cd(ω t))."""
    k = math.sin(0.5 * amplitude)
    sn = ellipj(ellipk(k * k) - rate * t, k * k)[0]
    return 2.0 * math.asin(k * sn)


def energy(scene, state):
    """Kinetic energy and that in gravity [J]."""
    total = 0.0
    for i in scene.moving:
        body = scene.bodies[i]
        total += 0.5 * body.mass * state.v[i] @ state.v[i] + body.mass * G * state.x[i, 2]
        w = unrotate(state.q[i], state.w[i])
        total += 0.5 * w @ body.inertia_tensor @ w
    return total


def allowed(world, length):
    """What may be the error of a place [m], `length` [m] from the pivot.

    Each step errs by a part `STEP` in the attitude and in the speed, which carries on with time; errors of either sign
    add up as the root of their number.
    """
    speed = max(float(np.sqrt((world.motion.v**2).sum(axis=1)).max()), math.sqrt(2.0 * G * length))
    return STEP * math.sqrt(world.audit.steps) * (length + speed * world.t)
