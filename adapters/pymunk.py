"""pymunk: `pymunk` (fair) and `pymunk:stock`, for planar scenes.

The scene's x-z plane becomes pymunk's x-y plane.  Seen from the side on which x points right and z
up, a positive rotation about y turns clockwise, while pymunk counts angles counter-clockwise: angle
and angular velocity change sign.  Every figure quoted here was measured with pymunk 7.3.1.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from types import ModuleType
from typing import Any

import numpy as np

from adapters.configured import Configured
from adapters.engine import ContactForce, Refusal, Settings
from adapters.pushes import Motion, pusher
from adapters.pymunk_world import Builder, Draft, World, moment, substeps
from adapters.translate import TIME_STEPS, anchor_speed, installed_version, world_anchor
from mechanics.arrays import Vec3
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
)
from mechanics.rotation import exponential, product
from mechanics.scene import Body, Scene
from mechanics.shapes import HalfSpace, Mesh
from mechanics.trajectory import State

AXIS = np.array([0.0, 1.0, 0.0])  # about which planar bodies turn


class Pymunk(Configured):
    """pymunk with one set of settings, as an engine."""

    @cached_property
    def effects(self) -> dict[type[Effect], Callable[[Draft, Any], str | None]]:
        """How each effect is switched on; see `adapters.engine.Engine`."""
        return {
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
        return -float(settings["dt"]) / (2.0 * substeps(settings))

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
                moment(body)  # refuses what turns out of the plane
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
        world = Builder(self._pymunk, self.departs).build(draft, knobs)
        hands, h = _Hands(world), world.clock.dt / world.substeps
        world.pushes = [pusher(draft.scene, effect, hands, h) for effect in draft.pushes]
        return world

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
            name="pymunk",
            stock=False,
            knobs={"dt": TIME_STEPS, "iterations": (10.0, 50.0, 200.0), "substeps": (1.0, 2.0, 4.0, 8.0)},
            defaults={"dt": 1e-3, "iterations": 200.0, "substeps": 1.0},
            profile={
                "iterations = 200 (knob)": "as many as PyBullet, which solves by the same method: in a stack of ten at "
                "1 ms 10 leave 3.1 mm of drift, 50 leave 1.4 mm, 200 leave 0.6 mm",
                "collision_slop = 0": "the default lets bodies sink by 0.1 m; with 1 mm a smooth stack of ten drifts "
                "sixteen times as far",
                "collision_bias = 1": "where no contact lasts (no Resting) there is no overlap to correct, and lifting "
                "a bouncing ball out of the floor is work nobody did",
                "error_bias = 0 of a joint alone": "one iteration solves a rod, a hinge or a taut string exactly where "
                "no other link holds its bodies and no contact lasts, and each step can make good all of its error: a "
                "hinged rod let go at 120 degrees keeps its energy to 1e-5 in 3 s at 1 ms; by default it loses 1.8 %. "
                "Joints that share a body keep the default (1 - 0.1)**60: more lets chains blow up that hold a load. "
                "Per step of 1 ms the default corrects 0.6 % and holds 100 links of 1 kg under 100 kg; 2 % holds 50, "
                "5 % 20, 10 % 10, all of it 2; a double pendulum loses 1.3 % of its energy in 2 s for that. A string "
                "that goes taut later keeps it, too: corrected at once it rebounds, and is off by 1.9 m/s",
                "moments from the scene": "pymunk's circle is a disc, the scene's sphere a ball",
                "half-space = rectangle 2 km long": "pymunk has no plane; on a thick segment a stack drifts further",
            },
        ),
        Pymunk(
            name="pymunk:stock",
            stock=True,
            knobs={"dt": TIME_STEPS, "iterations": (10.0, 50.0, 200.0)},
            defaults={"dt": 1.0 / 60.0, "iterations": 10.0},
            profile={},
        ),
    )
}
