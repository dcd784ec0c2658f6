"""Moments on bodies that may not turn."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mechanics.effects import Force, Rotation
from reference_impl.collide.detect import rotations
from reference_impl.errors import MissingEffect

if TYPE_CHECKING:
    from reference_impl.world import World


def require_rotation(world: World) -> None:
    """See to it that no load that acts from now on would turn a body that may not turn and touches nothing.

    What a body lies on can balance a moment; in flight nothing does.

    Raises
    ------
    MissingEffect
    """
    scene, t = world.scene, world.t
    acting = [force for force in scene.all(Force) if force.start <= t < force.end and scene.moment(force).any()]
    if Rotation in scene.needs or not acting:
        return
    everything = np.ones(len(scene.bodies), dtype=bool)
    touching = world.detector.contacts(world.motion.x, rotations(world.motion.q), everything).kinds[:, :2]
    for force in acting:
        if scene.index(force.body) not in touching:
            size = float(np.linalg.norm(scene.moment(force)))
            raise MissingEffect("Rotation", (force.body,), t, f"a moment of {size:.4g} N m acts on a body in flight")
