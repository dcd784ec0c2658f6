"""pymunk: `pymunk` (fair) and `pymunk:stock`, for planar scenes.

The scene's x-z plane becomes pymunk's x-y plane.  Seen from the side on which x points right and z
up, a positive rotation about y turns clockwise, while pymunk counts angles counter-clockwise: angle
and angular velocity change sign.  Every figure quoted here was measured with pymunk 7.3.1.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from types import ModuleType
from typing import Any

import numpy as np

from adapters.engine import Clock, ContactForce, Refusal, Settings
from adapters.pushes import Motion, Push, pusher
from adapters.translate import TIME_STEPS, anchor_speed, factors, installed_version, world_anchor
from mechanics.arrays import Triple, Vec3
from mechanics.effects import (
    Drag,
    Force,
    Friction,
    Gravity,
    Hinge,
    PairEffect,
    Resting,
    Restitution,
    Rod,
    Rotation,
    Spring,
    Tether,
)
from mechanics.rotation import exponential, matrix, product, rotate
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, Capsule, Cylinder, HalfSpace, Mesh, Sphere
from mechanics.trajectory import State

GROUND = (1000.0, 10.0)  # half length and depth of the rectangle that stands for a half-space [m]
AXIS = np.array([0.0, 1.0, 0.0])  # about which planar bodies turn


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


class Pymunk:
    """pymunk with one set of settings, as an engine.

    Parameters
    ----------
    name : str
    stock : bool
        Iterations, slop and moments of inertia as pymunk has them.
    knobs, defaults, profile, known
        As in `adapters.engine.Engine`; `known`: law of `check_engine` -> why this profile breaks it.
    """

    def __init__(
        self,
        name: str,
        *,
        stock: bool,
        knobs: Mapping[str, tuple[float, ...]],
        defaults: Mapping[str, float],
        profile: Mapping[str, str],
        known: Mapping[str, str] | None = None,
    ) -> None:
        self.name, self.stock = name, stock
        self.knobs, self.defaults, self.profile, self.known = knobs, defaults, profile, known or {}
        self.effects = {
            Gravity: self._gravity,
            Rotation: self._rotation,
            Drag: self._push,
            Force: self._push,
            Spring: self._link,
            Rod: self._link,
            Tether: self._link,
            Hinge: self._link,
            Restitution: self._restitution,
            Friction: self._friction,
            Resting: self._resting,
        }

    @property
    def version(self) -> str:
        """Version of the installed pymunk; ImportError if there is none."""
        return installed_version("pymunk")

    @cached_property
    def _pymunk(self) -> ModuleType:
        import pymunk

        return pymunk

    def lead(self, settings: Settings) -> float:
        """pymunk moves before it kicks: positions lag by half a (sub)step [s]."""
        return -float(settings["dt"]) / (2.0 * _substeps(settings))

    def vacuum(self, scene: Scene) -> Draft:
        """Draft in which nothing acts.

        Raises
        ------
        Refusal
            If the scene is not planar, with the reason.
        """
        reason = scene.out_of_plane() or _off_level(scene)
        if reason:
            raise Refusal(f"pymunk is planar: {reason}")
        for body in scene.bodies:
            if isinstance(body.shape, Mesh):
                raise Refusal(f"pymunk has no cross-section of the mesh {body.name!r}")
        return Draft(scene)

    def _gravity(self, draft: Draft, effect: Gravity) -> None:
        draft.gravity = effect.acceleration

    def _rotation(self, draft: Draft, _: Rotation) -> None:
        for body in draft.scene.bodies:
            if not body.fixed:
                _moment(body)  # refuses what turns out of the plane
        draft.turns = True

    def _restitution(self, draft: Draft, effect: Restitution) -> None:
        draft.restitution = effect

    def _friction(self, draft: Draft, effect: Friction) -> None:
        draft.friction = effect

    def _resting(self, draft: Draft, _: Resting) -> None:
        return None

    def _push(self, draft: Draft, effect: Drag | Force) -> str:
        draft.pushes.append(effect)
        return f"{type(effect).__name__}: its force is computed by the adapter once per step"

    def _link(self, draft: Draft, effect: Spring | Rod | Tether | Hinge) -> None:
        scene = draft.scene
        kind, pair = type(effect).__name__, f"{effect.a!r}-{effect.b!r}"
        if isinstance(effect, Hinge) and Rotation not in scene.needs:
            raise Refusal("a hinge between bodies that may not turn")
        if isinstance(effect, Hinge) and (speed := anchor_speed(scene, effect)) > 1e-9:
            raise Refusal(f"{kind} {pair}: its two sides part at {speed:g} m/s at the start")
        if isinstance(effect, Tether) and effect.restitution > 0.0:
            raise Refusal(f"{kind} {pair}: pymunk's SlideJoint goes taut without rebound")
        if isinstance(effect, Rod) and not _distance(scene, effect):
            raise Refusal(f"{kind} {pair}: a rod of no length has no direction")
        draft.links.append(effect)

    def start(self, draft: Draft, knobs: Settings) -> World:
        """World of the draft."""
        scene, space = draft.scene, self._pymunk.Space()
        space.gravity = draft.gravity[0], draft.gravity[2]
        space.iterations = int(knobs["iterations"])
        if not self.stock:
            space.collision_slop = 0.0
            if Resting not in scene.needs:
                space.collision_bias = 1.0
        world = World(scene, space, Clock(float(knobs["dt"])), _substeps(knobs), [], [])
        for body in scene.bodies:
            self._add(world, draft, body)
        self._set_coefficients(world, draft)
        for link in draft.links:
            self._tie(world, link)
        hands = _Hands(world)
        world.pushes = [pusher(scene, effect, hands, world.clock.dt / world.substeps) for effect in draft.pushes]
        world.driven = [i for i, body in enumerate(scene.bodies) if any(body.acceleration)]
        return world

    def _add(self, world: World, draft: Draft, body: Body) -> None:
        pm = self._pymunk
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
        if self.stock and body.inertia is None and isinstance(body.shape, Sphere):
            return float(self._pymunk.moment_for_circle(body.mass, 0.0, body.shape.radius))
        return _moment(body)

    def _shape(self, world: World, body: Body, native: Any) -> Any:
        pm = self._pymunk
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
        return self._pymunk.Poly(native, [native.world_to_local(tuple(native.position + c)) for c in corners])

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

    def _tie(self, world: World, link: Spring | Rod | Tether | Hinge) -> None:
        """The native joint of a link, without the error bias that would damp it."""
        pm, scene = self._pymunk, world.scene
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
        if not isinstance(link, Spring):
            joint.error_bias = 0.0
        joint.collide_bodies = isinstance(link, (Spring, Tether))
        world.space.add(joint)

    def advance(self, world: World, duration: float) -> None:
        """Whole steps closest to `duration` [s]; a bare loop where no effect needs anything per step."""
        clock, step = world.clock, world.space.step
        h = clock.dt / world.substeps
        steps = clock.steps(duration) * world.substeps
        if not world.pushes and not world.driven:
            for _ in range(steps):
                step(h)
            return
        end = clock.count * world.substeps
        for k in range(end - steps, end):
            for push in world.pushes:
                push(k * h)
            for i in world.driven:
                # the velocity at mid-step carries an accelerated body exactly to its place
                velocity = _prescribed(world.scene.bodies[i], (k + 0.5) * h)
                world.bodies[i].velocity = velocity[0], velocity[2]
            step(h)

    def read(self, world: World) -> State:
        """State in scene order, lifted back into three dimensions."""
        start, t = world.scene.start(), world.clock.time
        x, v, w = start.x.copy(), start.v.copy(), start.w.copy()
        x[:, [0, 2]] = [native.position for native in world.bodies]
        v[:, [0, 2]] = [native.velocity for native in world.bodies]
        w[:, 1] = [-native.angular_velocity for native in world.bodies]
        for i in world.driven:
            v[i] = _prescribed(world.scene.bodies[i], t)
        turned = np.subtract(world.angles, [native.angle for native in world.bodies])
        return State(t, x, product(exponential(turned[:, None] * AXIS), start.q), v, w)

    def contacts(self, world: World) -> list[ContactForce]:
        """Contacts that carried force in the last (sub)step, one per pair, at the mean of their points."""
        places = {body: i for i, body in enumerate(world.bodies)}
        h = world.clock.dt / world.substeps
        found: dict[frozenset[int], ContactForce] = {}

        def note(arbiter: Any) -> None:
            shapes, touch, impulse = arbiter.shapes, arbiter.contact_point_set, arbiter.total_impulse
            a, b = (places[shape.body] for shape in shapes)
            pair = frozenset((a, b))
            if pair in found or not touch.points or not impulse.length:
                return
            points = [(0.5 * (p.point_a + p.point_b)) for p in touch.points]
            centre = sum(points, start=0.0 * points[0]) / len(points)
            level = world.scene.bodies[world.scene.moving[0]].position[1]
            # pymunk's normal points from its first shape to its second, and the impulse acts on the first
            normal, force = -touch.normal, impulse / h
            found[pair] = ContactForce(
                world.clock.time, world.scene.names[a], world.scene.names[b],
                (centre.x, level, centre.y), (normal.x, 0.0, normal.y), (force.x, 0.0, force.y),
            )  # fmt: skip

        for i in world.scene.moving:
            world.bodies[i].each_arbiter(note)
        return list(found.values())


@dataclass(frozen=True)
class _Hands:
    """How pushes and reading reach into a pymunk world."""

    world: World

    def motion(self, i: int) -> Motion:
        native, body = self.world.bodies[i], self.world.scene.bodies[i]
        (x, z), (vx, vz) = native.position, native.velocity
        turned = exponential((self.world.angles[i] - native.angle) * AXIS)
        return Motion(
            np.array([x, body.position[1], z]),
            product(turned, np.array(body.orientation)),
            np.array([vx, 0.0, vz]),
            np.array([0.0, -native.angular_velocity, 0.0]),
        )

    def push(self, i: int, force: Vec3, torque: Vec3) -> None:
        native = self.world.bodies[i]
        native.force += float(force[0]), float(force[2])
        native.torque -= float(torque[1])


def _substeps(settings: Settings) -> int:
    return int(settings.get("substeps", 1))


def _rectangle(length: float, height: float) -> list[tuple[float, float]]:
    return [(sx * length / 2.0, sz * height / 2.0) for sx, sz in ((-1, -1), (1, -1), (1, 1), (-1, 1))]


def _angle(body: Body) -> float:
    """pymunk's angle of a body, counter-clockwise; a sphere, whose attitude nobody sees, starts at 0 [rad]."""
    w, _, y, _ = body.orientation
    return 0.0 if isinstance(body.shape, Sphere) else -2.0 * math.atan2(y, w)


def _moment(body: Body) -> float:
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


def _off_level(scene: Scene) -> str | None:
    """Why a fixed body is not cut by the plane in which the others move through its middle, or None."""
    if not scene.touching or not scene.moving:
        return None
    level = scene.bodies[scene.moving[0]].position[1]
    for body in scene.bodies:
        if body.fixed and not isinstance(body.shape, HalfSpace) and body.position[1] != level:
            return f"fixed body {body.name!r}: y = {body.position[1]:g} m, the others move at {level:g} m"
    return None


def _distance(scene: Scene, rod: Rod) -> float:
    ends = world_anchor(scene, rod.a, rod.anchor_a) - world_anchor(scene, rod.b, rod.anchor_b)
    return float(np.linalg.norm(ends))


def _prescribed(body: Body, t: float) -> Vec3:
    """Velocity of a fixed body with prescribed motion at time t [m/s]."""
    return np.array(body.velocity) + t * np.array(body.acceleration)


ENGINES = {
    engine.name: engine
    for engine in (
        Pymunk(
            "pymunk",
            stock=False,
            knobs={"dt": TIME_STEPS, "iterations": (10.0, 50.0, 200.0), "substeps": (1.0, 2.0, 4.0, 8.0)},
            defaults={"dt": 1e-3, "iterations": 200.0, "substeps": 1.0},
            profile={
                "iterations = 200 (knob)": "as many as PyBullet, which solves by the same method: in a stack of ten at "
                "1 ms 10 leave 3.1 mm of drift, 50 leave 1.4 mm, 200 leave 0.6 mm",
                "collision_slop = 0": "the default lets bodies sink by 0.1 m; with a slop of 1 mm a smooth stack of ten "
                "drifts sixteen times as far",
                "collision_bias = 1": "where no contact lasts (no Resting) there is no overlap to correct, and lifting "
                "a bouncing ball out of the floor is work nobody did",
                "error_bias = 0": "the default corrects joints slowly and damps a pendulum by 1 % in 3 s",
                "moments from the scene": "pymunk's circle is a disc, the scene's sphere a ball",
                "half-space = rectangle 2 km long": "pymunk has no plane; on a thick segment a stack drifts further",
            },
        ),
        Pymunk(
            "pymunk:stock",
            stock=True,
            knobs={"dt": TIME_STEPS, "iterations": (10.0, 50.0, 200.0)},
            defaults={"dt": 1.0 / 60.0, "iterations": 10.0},
            profile={},
        ),
    )
}
