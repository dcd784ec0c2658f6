"""Uniform gravity: the same acceleration for every body that has a mass."""

from __future__ import annotations

import numpy as np

from mechanics.effects import Gravity
from mechanics.scene import Scene
from reference_impl.parts import Load, Parts


def parts(scene: Scene, effect: Gravity) -> Parts:
    """The load m g on every body that is not fixed."""
    free = np.array([0.0 if body.fixed else 1.0 for body in scene.bodies])
    return Parts(loads=(Load(acceleration=np.outer(free, effect.acceleration)),))
