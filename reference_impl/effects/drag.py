"""Linear drag: force -c v and torque -d ω.  Exact to the order of the flight series."""

from __future__ import annotations

import numpy as np

from mechanics.effects import Drag
from mechanics.scene import Scene
from reference_impl.parts import Load, Parts


def parts(scene: Scene, effect: Drag) -> Parts:
    """The load of the drag on the bodies named, or on all."""
    n = len(scene.bodies)
    drag, spin_drag = np.zeros(n), np.zeros(n)
    for i, body in enumerate(scene.bodies):
        if not body.fixed and (not effect.bodies or body.name in effect.bodies):
            drag[i] = effect.linear / body.mass
            spin_drag[i] = effect.angular
    return Parts(loads=(Load(drag=drag, spin_drag=spin_drag),))
