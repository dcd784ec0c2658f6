"""Effects to parts: a table, effect type to function, both implements and declares what an engine can do."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from mechanics.effects import (
    Drag,
    Effect,
    Force,
    Friction,
    Gravity,
    Hinge,
    Resting,
    Restitution,
    Rod,
    Rotation,
    Spring,
    Tether,
)  # fmt: skip
from mechanics.scene import Scene
from reference_impl.effects import drag, force, friction, gravity, joint, penalty, rotation, spring, tether
from reference_impl.errors import Unsupported
from reference_impl.parts import Law, Parts

Table = Mapping[type[Effect], Callable[[Scene, Any], Parts]]

IMPULSES: Table = {
    Gravity: gravity.parts,
    Rotation: rotation.parts,
    Drag: drag.parts,
    Force: force.parts,
    Restitution: lambda scene, effect: Parts(law=Law(touching=True, restitution=effect)),
    Friction: friction.parts,
    Resting: lambda scene, effect: Parts(law=Law(touching=True, resting=True)),
    Rod: joint.rod,
    Hinge: joint.hinge,
    Spring: spring.parts,
    Tether: tether.parts,
}

# with contact as a load, and as the lecture has it: listed one by one, because what the events of `simulate` learn
# these do not
PENALTIES: Table = {
    Gravity: gravity.parts,
    Rotation: rotation.parts,
    Drag: drag.parts,
    Force: force.parts,
    Restitution: penalty.restitution,
    Friction: penalty.frictionless,
    Resting: penalty.resting,
}

LECTURE: Table = {
    Gravity: gravity.parts,
    Rotation: rotation.parts,
    Drag: drag.parts,
    Force: force.parts,
    Restitution: lambda scene, effect: Parts(law=Law(touching=True, restitution=effect)),
    Friction: penalty.frictionless,
    Resting: lambda scene, effect: Parts(law=Law(touching=True, resting=True)),
}


def assemble(scene: Scene, table: Table = IMPULSES) -> Parts:
    """The sum of the parts of all effects of the scene.

    Raises
    ------
    Unsupported
        For an effect that the table does not list or cannot do with these values.
    """
    total = Parts()
    for effect in scene.effects:
        if type(effect) not in table:
            known = ", ".join(sorted(kind.__name__ for kind in table))
            raise Unsupported(f"{type(effect).__name__}: not among {known}")
        total = total + table[type(effect)](scene, effect)
    return total
