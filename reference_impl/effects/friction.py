"""Friction: only its absence.  A coefficient above zero is refused by name."""

from __future__ import annotations

from mechanics.effects import Friction
from mechanics.scene import Scene
from reference_impl.errors import Unsupported
from reference_impl.parts import Law, Parts


def parts(scene: Scene, effect: Friction) -> Parts:
    """Smooth contact.

    Raises
    ------
    Unsupported
        If any pair has a coefficient above zero.
    """
    if any(effect.values()):
        raise Unsupported(f"Friction with a coefficient of {max(effect.values()):g}: only 0 (smooth contact)")
    return Parts(law=Law(touching=True))
