"""A scene with one effect more, or one less: what `effects` compares it with.

An effect more is switched on so that it does nothing.  Most have a value for that: no force, a spring without
stiffness, a cord that never goes taut, a coefficient below rounding.  Rods and hinges hold whatever they name, so
they are given two fixed bodies out of everybody's way.  Rotation, Resting and Restitution have no such value: bodies
that may turn, lie or bounce do so only where something makes them, and whether it does is what is to be found out.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from mechanics.effects import (
    CONTACT_EFFECTS,
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
)
from mechanics.scene import Body, Scene
from mechanics.shapes import Sphere, bounding_radius
from mechanics.trajectory import Trajectory

TINY = 1e-17  # a share that rounding takes no notice of
POSTS = ("post near", "post far")  # fixed bodies that bear what no body of the scene can


@dataclass(frozen=True)
class Room:
    """Where the bodies of a scene have been.

    Attributes
    ----------
    edge : float
        Largest x that a moving body reaches [m].
    width : float
        Distance farther than which no two bodies get from each other, with a margin [m].
    size : float
        Bounding radius of the smallest moving body [m].
    level : (2,) tuple
        y and z of the first moving body at the start [m].
    duration : float
        [s]
    """

    edge: float
    width: float
    size: float
    level: tuple[float, float]
    duration: float

    @staticmethod
    def of(scene: Scene, motion: Trajectory) -> Room:
        """The room that the bodies of `scene` take in `motion`.

        Raises
        ------
        ValueError
            If no body has a mass.
        """
        moving = list(scene.moving)
        if not moving:
            raise ValueError("nothing in the scene has a mass: no effect can change its motion")
        radius = np.array([bounding_radius(scene.bodies[i].shape) for i in moving])
        x = motion.x[:, moving]
        reach = [float(np.abs(motion.x[:, i]).max()) for i in range(len(scene.bodies))]
        edge = float((x[:, :, 0] + radius).max())
        _, y, z = (float(c) for c in x[0, 0])
        return Room(edge, 4.0 * (max(reach) + float(radius.max())), float(radius.min()), (y, z), float(motion.t[-1]))


def idle(scene: Scene, kind: type[Effect], room: Room) -> Scene:
    """`scene` with an effect of type `kind`, which it does not declare, switched on so that it does nothing.

    Raises
    ------
    ValueError
        If the scene declares it.
    """
    if kind in scene.needs:
        raise ValueError(f"the scene declares {kind.__name__}")
    if kind in _ON_POSTS:
        scene = replace(scene, bodies=scene.bodies + _posts(scene, room))
    return replace(scene, effects=(*scene.effects, _IDLE[kind](scene, room)))


def idle_in(scene: Scene, kinds: tuple[type[Effect], ...], room: Room) -> Scene:
    """`scene` with all of `kinds` switched on at once; those that would make it ill-posed together are the caller's."""
    for kind in kinds:
        scene = idle(scene, kind, room)
    return scene


def without(scene: Scene, kind: type[Effect]) -> Scene:
    """`scene` without its effects of type `kind`.

    Raises
    ------
    SceneError
        If what is left is no scene: bodies that turn without Rotation.
    """
    return replace(scene, effects=tuple(e for e in scene.effects if not isinstance(e, kind)))


def shaken(scene: Scene, room: Room) -> Scene:
    """`scene` with every moving body shifted by the rounding of its place, along x: what becomes of it is rounding."""
    shift = 4.0 * np.finfo(float).eps * max(room.size, abs(room.edge))
    return replace(scene, bodies=tuple(_shifted(b, shift * (-1) ** i) for i, b in enumerate(scene.bodies)))


def _shifted(body: Body, shift: float) -> Body:
    return body if body.fixed else replace(body, position=(body.position[0] + shift, *body.position[1:]))


def _posts(scene: Scene, room: Room) -> tuple[Body, ...]:
    """Two fixed balls in nobody's way, unless they stand there already."""
    if POSTS[0] in scene.names:
        return ()
    radius = 0.5 * room.size
    places = (room.edge + 4.0 * room.size, room.edge + 8.0 * room.size)
    return tuple(Body(name, Sphere(radius), position=(x, *room.level)) for name, x in zip(POSTS, places, strict=True))


def _drag(scene: Scene, room: Room) -> Drag:
    """What takes a share of the speed, in all the time there is, of which rounding takes no notice."""
    mass = min(scene.bodies[i].mass or math.inf for i in scene.moving)
    return Drag(TINY * mass / room.duration)


def _spring(scene: Scene, room: Room) -> Spring:
    return Spring(POSTS[0], scene.names[scene.moving[0]], stiffness=0.0, length=room.width)


def _tether(scene: Scene, room: Room) -> Tether:
    return Tether(POSTS[0], scene.names[scene.moving[0]], length=4.0 * room.width)


def _hinge(scene: Scene, room: Room) -> Hinge:
    return Hinge(*POSTS, point=scene.body(POSTS[0]).position)


_ON_POSTS = (Spring, Tether, Rod, Hinge)
_IDLE: Mapping[type[Effect], Callable[[Scene, Room], Any]] = {
    Gravity: lambda scene, room: Gravity((0.0, 0.0, 0.0)),
    Rotation: lambda scene, room: Rotation(),
    Drag: _drag,
    Force: lambda scene, room: Force(scene.names[scene.moving[0]]),
    Spring: _spring,
    Restitution: lambda scene, room: Restitution(0.0),
    Friction: lambda scene, room: Friction(TINY),
    Resting: lambda scene, room: Resting(),
    Rod: lambda scene, room: Rod(*POSTS),
    Tether: _tether,
    Hinge: _hinge,
}
HOW: Mapping[type[Effect], str] = {
    Gravity: "an acceleration of zero",
    Rotation: "bodies may turn",
    Drag: f"a drag that takes {TINY:g} of the speed",
    Force: "a force of zero",
    Spring: "a spring without stiffness from the first body to a fixed ball out of the way",
    Restitution: "every pair is looked at, and would part at no speed",
    Friction: f"a coefficient of {TINY:g}",
    Resting: "contact may last",
    Rod: "a rod between two fixed balls out of the way",
    Tether: "a cord from the first body to a fixed ball out of the way, which never goes taut",
    Hinge: "a hinge between two fixed balls out of the way",
}
VALUED = tuple(kind for kind in _IDLE if kind is not Rotation and kind not in CONTACT_EFFECTS)  # idle by their value
