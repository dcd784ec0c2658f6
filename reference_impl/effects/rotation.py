"""Rotation: bodies may turn.  Their inertia is given to them when the arrays are built."""

from __future__ import annotations

from mechanics.effects import Rotation
from mechanics.scene import Scene
from reference_impl.parts import Parts


def parts(scene: Scene, effect: Rotation) -> Parts:
    """Nothing: without this effect the inverse inertia of every body is zero, with it that of its mass."""
    return Parts()
