"""A constant world force at a point of a body, and a constant world torque, for a time."""

from __future__ import annotations

import numpy as np

from mechanics.effects import Force
from mechanics.scene import Scene
from reference_impl.parts import Load, Parts


def parts(scene: Scene, effect: Force) -> Parts:
    """The load F / m, the torque, and the lever p Fᵀ of the force at body point p."""
    n, i = len(scene.bodies), scene.index(effect.body)
    acceleration, torque, lever = np.zeros((n, 3)), np.zeros((n, 3)), np.zeros((n, 3, 3))
    acceleration[i] = np.array(effect.force) / scene.bodies[i].mass
    torque[i] = effect.torque
    lever[i] = np.outer(effect.point, effect.force)
    return Parts(loads=(Load(acceleration, torque, lever, start=effect.start, end=effect.end),))
