"""Why effects are declared without which a true motion would be the same: said once, for `scenario(because=...)`."""

from __future__ import annotations

from collections.abc import Mapping

from mechanics.effects import Effect, Force, Friction, Gravity, Resting, Rotation

LOAD = "nothing moves with it or without it: it is the load under which things are to stand"
LEAVE = "nothing turns in the true motion: that nothing does, though it may, is what an engine is to show"
GRIP = "nothing slides in the true motion, smooth or rough: an engine is not to slip where it is held, too"
PUSH = "it moves nothing as long as it is balanced: that it is, is what an engine is to show"
PARTS = "the support falls away faster than the body: contact that may last is to end at once"
CAUGHT = "balls that an engine leaves in the wall are to be allowed to stay there: whether they pass is asked"

STANDING: Mapping[type[Effect], str] = {Gravity: LOAD, Rotation: LEAVE}
HELD: Mapping[type[Effect], str] = {Gravity: LOAD}
GRIPPED: Mapping[type[Effect], str] = {Gravity: LOAD, Rotation: LEAVE, Friction: GRIP}
PUSHED: Mapping[type[Effect], str] = {Gravity: LOAD, Rotation: LEAVE, Force: PUSH}
UNTURNED: Mapping[type[Effect], str] = {Rotation: LEAVE}
CARRIED: Mapping[type[Effect], str] = {Gravity: LOAD, Resting: PARTS}
STUCK: Mapping[type[Effect], str] = {Resting: CAUGHT}
