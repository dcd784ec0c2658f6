"""How a planar scene becomes a pymunk space: bodies, shapes, coefficients and joints.

Every figure quoted here was measured with pymunk 7.3.1.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import ModuleType
from typing import Any

import numpy as np

from adapters.engine import Clock, Refusal, Settings
from adapters.pushes import Push
from adapters.translate import factors, world_anchor
from mechanics.arrays import Triple
from mechanics.effects import Drag, Force, Hinge, PairEffect, Resting, Rod, Spring, Tether
from mechanics.rotation import matrix, rotate
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, Capsule, Cylinder, HalfSpace, Sphere

GROUND = (1000.0, 10.0)  # half length and depth of the rectangle that stands for a half-space [m]
TAUT = 1e-9  # a string shorter by less than this part of its length is taut


@dataclass
class Draft:
    """A world that is still a vacuum, and what has been switched on."""

    scene: Scene
    gravity: Triple = (0.0, 0.0, 0.0)
    turns: bool = False
    restitution: PairEffect | None = None
    friction: PairEffect | None = None
    pushes: list[Drag | Force] = field(default_factory=list)
    links: list[Spring | Rod | Tether | Hinge] = field(default_factory=list)


@dataclass
class World:
    """A space with its bodies, in scene order."""

    scene: Scene
    space: Any
    clock: Clock
    substeps: int
    bodies: list[Any]
    angles: list[float]  # of each body at the start [rad]
    pushes: list[Push] = field(default_factory=list)
    driven: list[int] = field(default_factory=list)  # fixed bodies that accelerate


@dataclass(frozen=True)
class Builder:
    """Makes worlds of drafts.

    Attributes
    ----------
    pymunk : module
        The imported pymunk.
    departs : function of str
        Whether a setting departs from stock; where none does, slop, bias and moments of inertia are pymunk's.
    """

    pymunk: ModuleType
    departs: Callable[[str], bool]

    def build(self, draft: Draft, knobs: Settings) -> World:
        """World of the draft, without its pushes."""
        scene, space = draft.scene, self.pymunk.Space()
        space.gravity = draft.gravity[0], draft.gravity[2]
        space.iterations = int(knobs["iterations"])
        if self.departs("collision_slop"):
            space.collision_slop = 0.0
        if self.departs("collision_bias") and Resting not in scene.needs:
            space.collision_bias = 1.0
        world = World(scene, space, Clock(float(knobs["dt"])), substeps(knobs), [], [])
        for body in scene.bodies:
            self._add(world, draft, body)
        self._set_coefficients(world, draft)
        alone = [False] * len(draft.links) if Resting in scene.needs else _alone(scene, draft.links)
        for link, one in zip(draft.links, alone, strict=True):
            self._tie(world, link, one)
        world.driven = [i for i, body in enumerate(scene.bodies) if any(body.acceleration)]
        return world

    def _add(self, world: World, draft: Draft, body: Body) -> None:
        pm = self.pymunk
        if body.fixed:
            moves = any((*body.velocity, *body.acceleration))
            native = pm.Body(body_type=pm.Body.KINEMATIC if moves else pm.Body.STATIC)
        else:
            native = pm.Body(body.mass, self._moment(body) if draft.turns else math.inf)
        native.position = body.position[0], body.position[2]
        native.velocity = body.velocity[0], body.velocity[2]
        native.angle = angle = _angle(body)
        native.angular_velocity = -body.angular_velocity[1]
        world.space.add(native)
        world.bodies.append(native)
        world.angles.append(angle)
        if draft.scene.touching:
            shape = self._shape(world, body, native)
            # fixed bodies do not collide with each other: their contact has no mass to act on
            shape.filter = pm.ShapeFilter(categories=1, mask=2) if body.fixed else pm.ShapeFilter(categories=2)
            world.space.add(shape)

    def _moment(self, body: Body) -> float:
        """Moment about y of the scene; a stock body gets that of its flat outline unless the scene names one."""
        if not self.departs("moments") and body.inertia is None and isinstance(body.shape, Sphere):
            return float(self.pymunk.moment_for_circle(body.mass, 0.0, body.shape.radius))
        return moment(body)

    def _shape(self, world: World, body: Body, native: Any) -> Any:
        pm = self.pymunk
        match body.shape:
            case Sphere(radius):
                return pm.Circle(native, radius)
            case Box((length, _, height)):
                return pm.Poly(native, _rectangle(length, height))
            case Cylinder(radius, height):
                return pm.Poly(native, _rectangle(2.0 * radius, height))
            case Capsule(radius, length):
                return pm.Segment(native, (0.0, -0.5 * length), (0.0, 0.5 * length), radius)
        return self._ground(world.scene, body, native)

    def _ground(self, scene: Scene, body: Body, native: Any) -> Any:
        """Rectangle whose upper side lies in the plane of a half-space, under the middle of the moving bodies."""
        assert isinstance(body.shape, HalfSpace)
        normal = rotate(np.array(body.orientation), np.array(body.shape.normal))[[0, 2]]
        along = np.array([normal[1], -normal[0]])
        middle = np.mean([scene.bodies[i].position for i in scene.moving] or [body.position], axis=0)
        shift = float(along @ (middle - body.position)[[0, 2]])
        corners = [
            (shift + s * GROUND[0]) * along - d * GROUND[1] * normal for s, d in ((-1, 1), (1, 1), (1, 0), (-1, 0))
        ]
        return self.pymunk.Poly(native, [native.world_to_local(tuple(native.position + c)) for c in corners])

    def _set_coefficients(self, world: World, draft: Draft) -> None:
        """Coefficients as factors per shape where pymunk's product gives every pair its own, else pair by pair."""
        pairwise: dict[str, PairEffect] = {}
        for name, effect in (("restitution", draft.restitution), ("friction", draft.friction)):
            if effect is None:
                continue
            try:
                values = factors(world.scene, effect)
            except Refusal:
                pairwise[name] = effect
                continue
            for body, value in zip(world.bodies, values, strict=True):
                for shape in body.shapes:
                    setattr(shape, "elasticity" if name == "restitution" else name, value)
        if pairwise:
            self._watch_pairs(world, pairwise)

    def _watch_pairs(self, world: World, pairwise: Mapping[str, PairEffect]) -> None:
        """Give each pair its own coefficients when it touches: exact, but a call into Python per contact and step."""
        names = dict(zip(world.bodies, world.scene.names, strict=True))

        def pre_solve(arbiter: Any, *_: Any) -> None:
            a, b = (names[shape.body] for shape in arbiter.shapes)
            for attribute, effect in pairwise.items():
                setattr(arbiter, attribute, effect.of(a, b))

        world.space.on_collision(pre_solve=pre_solve)

    def _tie(self, world: World, link: Spring | Rod | Tether | Hinge, alone: bool) -> None:
        """The native joint of a link; a fair one that is `alone` makes good its whole error in each step.

        `error_bias` is the part of an error that is left after a second.  One joint is solved exactly by one
        iteration, and to correct it at once is stable whatever the masses.  Joints that share a body are solved one
        after the other: what is left of that grows where it is fed back as a correction, so these keep the default.
        So does a string that is slack at the start: taut, it has been overstretched by the way of a step, and what
        brings it back at once is speed of the body, which makes it rebound.
        """
        pm, scene = self.pymunk, world.scene
        a, b = (world.bodies[scene.index(name)] for name in (link.a, link.b))
        if scene.body(link.a).fixed and scene.body(link.b).fixed:
            return
        if isinstance(link, Hinge):
            ends = [body.world_to_local((link.point[0], link.point[2])) for body in (a, b)]
        else:
            anchors = ((link.a, link.anchor_a), (link.b, link.anchor_b))
            ends = [body.world_to_local(tuple(world_anchor(scene, name, anchor)[[0, 2]]))
                    for body, (name, anchor) in zip((a, b), anchors, strict=True)]  # fmt: skip
        match link:
            case Spring():
                joint = pm.DampedSpring(a, b, *ends, link.length, link.stiffness, link.damping)
            case Rod():
                joint = pm.PinJoint(a, b, *ends)
            case Tether():
                joint = pm.SlideJoint(a, b, *ends, 0.0, link.length)
            case Hinge():
                joint = pm.PivotJoint(a, b, *ends)
        if alone and self.departs("error_bias") and not isinstance(link, Spring) and not _slack(joint):
            joint.error_bias = 0.0
        joint.collide_bodies = isinstance(link, (Spring, Tether))
        world.space.add(joint)


def _alone(scene: Scene, links: list[Spring | Rod | Tether | Hinge]) -> list[bool]:
    """Which links share none of their moving bodies with another link."""
    moving = [{name for name in (link.a, link.b) if not scene.body(name).fixed} for link in links]
    held = Counter(name for names in moving for name in names)
    return [all(held[name] == 1 for name in names) for names in moving]


def _slack(joint: Any) -> bool:
    """Whether a joint is a string with some length to go."""
    a, b = (body.local_to_world(end) for body, end in ((joint.a, joint.anchor_a), (joint.b, joint.anchor_b)))
    return hasattr(joint, "max") and a.get_distance(b) < joint.max * (1.0 - TAUT)


def substeps(settings: Settings) -> int:
    """How many steps pymunk takes in one step of the clock."""
    return int(settings.get("substeps", 1))


def _rectangle(length: float, height: float) -> list[tuple[float, float]]:
    return [(sx * length / 2.0, sz * height / 2.0) for sx, sz in ((-1, -1), (1, -1), (1, 1), (-1, 1))]


def _angle(body: Body) -> float:
    """pymunk's angle of a body, counter-clockwise; a sphere, whose attitude nobody sees, starts at 0 [rad]."""
    w, _, y, _ = body.orientation
    return 0.0 if isinstance(body.shape, Sphere) else -2.0 * math.atan2(y, w)


def moment(body: Body) -> float:
    """Moment of inertia about y [kg m2].

    Raises
    ------
    Refusal
        If y is no principal axis, so that turning about y would make the body leave the plane.
    """
    turn = matrix(np.array(body.orientation))
    tensor = turn @ body.inertia_tensor @ turn.T
    if max(abs(tensor[0, 1]), abs(tensor[1, 2])) > 1e-12 * np.abs(tensor).max():
        raise Refusal(f"pymunk is planar: y is no principal axis of {body.name!r}")
    return float(tensor[1, 1])
