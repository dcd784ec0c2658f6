"""Forces that an adapter applies between the steps of an engine that has no such force of its own.

They are evaluated once per step, at the state in which the step begins, and held constant over it.
The velocity of a push-driven body is therefore first order in the step, whatever the engine does.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, Protocol

import numpy as np

from mechanics.arrays import Quat, Vec3
from mechanics.effects import Drag, Effect, Force, Spring
from mechanics.rotation import rotate
from mechanics.scene import Scene

Push = Callable[[float], None]  # called with the time at which the step begins [s]


class Motion(NamedTuple):
    """Motion of one body as the scene describes it: world frame, `q` body to world."""

    x: Vec3  # [m]
    q: Quat
    v: Vec3  # [m/s]
    w: Vec3  # [rad/s]


class Hands(Protocol):
    """How an adapter reaches into its world; bodies are named by their place in the scene."""

    def motion(self, i: int) -> Motion:
        """Motion of body i now."""

    def push(self, i: int, force: Vec3, torque: Vec3) -> None:
        """Add `force` [N] at the centre of mass and `torque` [N m], world frame, for the next step."""


def pusher(scene: Scene, effect: Effect, hands: Hands, dt: float) -> Push:
    """Function that applies a Drag, Force or Spring for one step of `dt` [s].

    Raises
    ------
    TypeError
        For any other effect.
    """
    match effect:
        case Drag():
            return _drag(scene, effect, hands)
        case Force():
            return _force(scene, effect, hands, dt)
        case Spring():
            return _spring(scene, effect, hands)
    raise TypeError(f"{type(effect).__name__} is no force that can be applied between steps")


def _drag(scene: Scene, drag: Drag, hands: Hands) -> Push:
    places = [i for i in scene.moving if not drag.bodies or scene.names[i] in drag.bodies]

    def push(_: float) -> None:
        for i in places:
            motion = hands.motion(i)
            hands.push(i, -drag.linear * motion.v, -drag.angular * motion.w)

    return push


def _force(scene: Scene, force: Force, hands: Hands, dt: float) -> Push:
    i, point = scene.index(force.body), np.array(force.point)
    pull, twist = np.array(force.force), np.array(force.torque)

    def push(t: float) -> None:
        # a window that ends within the step acts for its share, so that the impulse is exact
        share = max(0.0, min(force.end, t + dt) - max(force.start, t)) / dt
        if share:
            arm = rotate(hands.motion(i).q, point)
            hands.push(i, share * pull, share * (twist + np.cross(arm, pull)))

    return push


def _spring(scene: Scene, spring: Spring, hands: Hands) -> Push:
    ends = [(scene.index(spring.a), np.array(spring.anchor_a)), (scene.index(spring.b), np.array(spring.anchor_b))]

    def push(_: float) -> None:
        motions = [hands.motion(i) for i, _ in ends]
        arms = [rotate(m.q, anchor) for m, (_, anchor) in zip(motions, ends, strict=True)]
        (xa, va), (xb, vb) = ((m.x + r, m.v + np.cross(m.w, r)) for m, r in zip(motions, arms, strict=True))
        distance = float(np.linalg.norm(xa - xb))
        if distance == 0.0:
            return  # coincident anchors: the spring has no direction
        along = (xa - xb) / distance
        tension = spring.stiffness * (distance - spring.length) + spring.damping * float(along @ (va - vb))
        for (i, _), r, pull in zip(ends, arms, (-tension * along, tension * along), strict=True):
            if not scene.bodies[i].fixed:
                hands.push(i, pull, np.cross(r, pull))

    return push
