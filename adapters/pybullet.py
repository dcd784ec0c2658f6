"""PyBullet: `pybullet` (fair), `pybullet:multibody` (the other back-end), `pybullet:stock` (nothing changed).

Two different dynamics hide behind one interface: maximal coordinates (btRigidBody) and reduced
coordinates (Featherstone multibody), which is the default.  They differ in damping, clamps,
gyroscopic term and position correction, so both stand trial.  Every figure quoted here was measured
with PyBullet 3.2.7.
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
from adapters.translate import (
    TIME_STEPS,
    anchor_speed,
    factors,
    from_z,
    installed_version,
    joined,
    muted,
    rests_only,
)
from mechanics.arrays import Quat, Triple, Vec3
from mechanics.effects import (
    Drag,
    Effect,
    Force,
    Friction,
    Gravity,
    Hinge,
    Resting,
    Restitution,
    Rotation,
    Spring,
)
from mechanics.inertia import principal
from mechanics.rotation import IDENTITY, conjugate, product, rotate, unrotate
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, Capsule, Cylinder, HalfSpace, Mesh, Sphere, bounding_radius
from mechanics.trajectory import State

GROUND = (500.0, 50.0)  # half width and half height of the box that stands for a half-space [m]
FREE_SPEED = 1e9  # clamp of the multibody solver raised out of reach [m/s, rad/s]
STIFF = 1e12  # largest force of a hinge [N]: none


@dataclass
class Draft:
    """A world that is still a vacuum, and what has been switched on."""

    scene: Scene
    gravity: Triple = (0.0, 0.0, 0.0)
    turns: bool = False
    restitution: tuple[float, ...] = ()
    friction: tuple[float, ...] = ()
    pushes: list[Effect] = field(default_factory=list)
    hinges: list[Hinge] = field(default_factory=list)


@dataclass
class World:
    """A client with its bodies, in scene order; `axes` turn PyBullet's body frames into the scene's."""

    scene: Scene
    client: int
    clock: Clock
    substeps: int
    ids: list[int]
    axes: list[Quat | None]
    pushes: list[Push] = field(default_factory=list)


@dataclass(frozen=True)
class _Hands:
    """How pushes reach into a PyBullet world."""

    bullet: ModuleType
    world: World

    def motion(self, i: int) -> Motion:
        uid, axes = self.world.ids[i], self.world.axes[i]
        x, xyzw = self.bullet.getBasePositionAndOrientation(uid, self.world.client)
        v, w = self.bullet.getBaseVelocity(uid, self.world.client)
        q = _wxyz(xyzw) if axes is None else product(_wxyz(xyzw), conjugate(axes))
        return Motion(np.array(x), q, np.array(v), np.array(w))

    def push(self, i: int, force: Vec3, torque: Vec3) -> None:
        p, uid, client = self.bullet, self.world.ids[i], self.world.client
        centre = p.getBasePositionAndOrientation(uid, client)[0]
        p.applyExternalForce(uid, -1, force.tolist(), centre, p.WORLD_FRAME, client)
        p.applyExternalTorque(uid, -1, torque.tolist(), p.WORLD_FRAME, client)


class PyBullet:
    """PyBullet with one set of settings, as an engine.

    Parameters
    ----------
    name : str
    maximal : bool
        Maximal coordinates (btRigidBody) instead of the multibody solver.
    stock : bool
        Nothing but what the scene says is set.
    knobs, defaults, profile, known
        As in `adapters.engine.Engine`; `known`: law of `check_engine` -> why this profile breaks it.
    """

    def __init__(
        self,
        name: str,
        *,
        maximal: bool,
        stock: bool,
        knobs: Mapping[str, tuple[float, ...]],
        defaults: Mapping[str, float],
        profile: Mapping[str, str],
        known: Mapping[str, str] | None = None,
    ) -> None:
        self.name, self.maximal, self.stock = name, maximal, stock
        self.knobs, self.defaults, self.profile, self.known = knobs, defaults, profile, known or {}
        self.effects = {
            Gravity: self._gravity,
            Rotation: self._rotation,
            Drag: self._push,
            Force: self._push,
            Spring: self._push,
            Restitution: self._restitution,
            Friction: self._friction,
            Resting: self._resting,
            Hinge: self._hinge,
        }

    @property
    def version(self) -> str:
        """Version of the installed pybullet; ImportError if there is none."""
        return installed_version("pybullet")

    @cached_property
    def _bullet(self) -> ModuleType:
        with muted():  # it announces its build time
            import pybullet
        return pybullet

    def lead(self, settings: Settings) -> float:
        """Semi-implicit Euler: positions lead by half a (sub)step [s]."""
        return float(settings["dt"]) / (2.0 * _substeps(settings))

    def vacuum(self, scene: Scene) -> Draft:
        """Draft in which nothing acts.

        Raises
        ------
        Refusal
            For moving fixed bodies and non-convex meshes.
        """
        for body in scene.bodies:
            if body.fixed and any((*body.velocity, *body.acceleration)):
                raise Refusal(f"PyBullet gives static bodies no velocity in contact; {body.name!r} is fixed and moves")
            if isinstance(body.shape, Mesh) and not body.shape.convex:
                raise Refusal(f"PyBullet makes a convex hull of the moving mesh {body.name!r}")
        return Draft(scene)

    def _gravity(self, draft: Draft, effect: Gravity) -> None:
        draft.gravity = effect.acceleration

    def _rotation(self, draft: Draft, _: Rotation) -> None:
        draft.turns = True

    def _restitution(self, draft: Draft, effect: Restitution) -> str | None:
        draft.restitution = factors(draft.scene, effect)
        return _hull_margin(draft.scene)

    def _friction(self, draft: Draft, effect: Friction) -> str | None:
        draft.friction = factors(draft.scene, effect)
        return None if Restitution in draft.scene.needs else _hull_margin(draft.scene)

    def _resting(self, draft: Draft, _: Resting) -> str | None:
        return _hull_margin(draft.scene) if draft.scene.needs.isdisjoint({Restitution, Friction}) else None

    def _push(self, draft: Draft, effect: Drag | Force | Spring) -> str:
        draft.pushes.append(effect)
        return f"{type(effect).__name__}: its force is computed by the adapter once per step"

    def _hinge(self, draft: Draft, effect: Hinge) -> str:
        if not self.maximal:
            raise Refusal(f"{self.name} has hinges only between the links of an articulated body, not between bodies")
        if not draft.scene.needs >= {Rotation}:
            raise Refusal("a hinge between bodies that may not turn")
        speed = anchor_speed(draft.scene, effect)
        if speed > 1e-9:
            raise Refusal(f"Hinge {effect.a!r}-{effect.b!r}: its two sides part at {speed:g} m/s at the start")
        draft.hinges.append(effect)
        return "Hinge: two point-to-point constraints on its axis, because PyBullet has no hinge between free bodies"

    def start(self, draft: Draft, knobs: Settings) -> World:
        """World of the draft, built in a client of its own."""
        p = self._bullet
        client = p.connect(p.DIRECT)
        try:
            return self._build(draft, knobs, client)
        except BaseException:
            p.disconnect(client)
            raise

    def _build(self, draft: Draft, knobs: Settings, client: int) -> World:
        p, scene = self._bullet, draft.scene
        self._configure(client, scene, knobs)
        world = World(scene, client, Clock(float(knobs["dt"])), _substeps(knobs), [], [])
        for i in range(len(scene.bodies)):
            self._add(world, draft, i)
        if self.maximal:
            # btRigidBody keeps the world inertia of the *shape* until it has been carried through a
            # step, so one is made before anything moves (the bodies still stand kilometres apart)
            p.stepSimulation(client)
        for i in scene.moving:
            self._place(world, i)
        p.setGravity(*draft.gravity, physicsClientId=client)
        for a, b in joined(scene):
            p.setCollisionFilterPair(world.ids[scene.index(a)], world.ids[scene.index(b)], -1, -1, 0, client)
        for hinge in draft.hinges:
            self._join(world, hinge)
        hands = _Hands(p, world)
        world.pushes = [pusher(scene, effect, hands, world.clock.dt) for effect in draft.pushes]
        return world

    def _configure(self, client: int, scene: Scene, knobs: Settings) -> None:
        p = self._bullet
        p.setTimeStep(float(knobs["dt"]), physicsClientId=client)
        settings: dict[str, float] = {"numSolverIterations": int(knobs["iterations"])}
        if _substeps(knobs) > 1:
            settings["numSubSteps"] = _substeps(knobs)
        if not self.stock:
            settings |= {"restitutionVelocityThreshold": 0.0, "contactSlop": 0.0, "solverResidualThreshold": 0.0}
            if not rests_only(scene) and self.maximal:
                settings |= {"useSplitImpulse": 1, "splitImpulsePenetrationThreshold": 0.0}
            if Resting not in scene.needs or not (self.maximal or rests_only(scene)):
                settings["contactERP"] = 0.0
        p.setPhysicsEngineParameter(**settings, physicsClientId=client)

    def _add(self, world: World, draft: Draft, i: int) -> None:
        """Create body i; moving ones stand apart until `_place`, so that nothing touches before the start."""
        p, body = self._bullet, world.scene.bodies[i]
        axes = _principal_axes(body, draft.turns and not self.stock)
        position, orientation = _ground_pose(world.scene, body) if self._boxed(body) else (body.position, None)
        if orientation is None:
            orientation = body.orientation if axes is None else product(np.array(body.orientation), axes)
        if not body.fixed:
            position = (0.0, 0.0, 1e4 * (i + 1))
        shape = self._shape(body, axes, world.client) if world.scene.touching or self.stock else -1
        uid = p.createMultiBody(
            body.mass or 0.0, shape, -1, position, _xyzw(orientation),
            useMaximalCoordinates=int(self.maximal), physicsClientId=world.client,
        )  # fmt: skip
        world.ids.append(uid)
        world.axes.append(axes)
        if not world.scene.touching and shape >= 0:
            p.setCollisionFilterGroupMask(uid, -1, 0, 0, physicsClientId=world.client)
        p.changeDynamics(uid, -1, **self._dynamics(draft, i), physicsClientId=world.client)

    def _dynamics(self, draft: Draft, i: int) -> dict[str, Any]:
        """Arguments of changeDynamics for body i."""
        body = draft.scene.bodies[i]
        settings: dict[str, Any] = {
            "restitution": draft.restitution[i] if draft.restitution else 0.0,
            "lateralFriction": draft.friction[i] if draft.friction else 0.0,
        }
        if not body.fixed:
            # mass and inertia in one call: inertia alone makes the mass of a btRigidBody garbage
            if not draft.turns:
                settings |= {"mass": body.mass, "localInertiaDiagonal": (0.0, 0.0, 0.0)}
            elif not self.stock or body.inertia is not None:
                moments = principal(body.inertia_tensor)[0].tolist()
                settings |= {"mass": body.mass, "localInertiaDiagonal": moments}
        if not self.stock:
            settings |= {"linearDamping": 0.0, "angularDamping": 0.0}
            if not rests_only(draft.scene):
                settings["contactProcessingThreshold"] = 0.0
            if not self.maximal:
                settings["maxJointVelocity"] = FREE_SPEED
        return settings

    def _boxed(self, body: Body) -> bool:
        return isinstance(body.shape, HalfSpace) and not self.stock

    def _shape(self, body: Body, axes: Quat | None, client: int) -> int:
        p = self._bullet
        frame: dict[str, Any] = {} if axes is None else {"collisionFrameOrientation": _xyzw(conjugate(axes))}
        match body.shape:
            case Sphere(radius):
                form = {"shapeType": p.GEOM_SPHERE, "radius": radius}
            case Box(size):
                form = {"shapeType": p.GEOM_BOX, "halfExtents": [0.5 * s for s in size]}
            case Capsule(radius, length):
                form = {"shapeType": p.GEOM_CAPSULE, "radius": radius, "height": length}
            case Cylinder(radius, length):
                form = {"shapeType": p.GEOM_CYLINDER, "radius": radius, "height": length}
            case Mesh(vertices):
                form = {"shapeType": p.GEOM_MESH, "vertices": [list(v) for v in vertices]}
            case HalfSpace(normal) if self.stock:
                form = {"shapeType": p.GEOM_PLANE, "planeNormal": normal}
            case HalfSpace():
                form = {"shapeType": p.GEOM_BOX, "halfExtents": [GROUND[0], GROUND[0], GROUND[1]]}
        return p.createCollisionShape(**form, **frame, physicsClientId=client)

    def _place(self, world: World, i: int) -> None:
        p, body, uid, axes = self._bullet, world.scene.bodies[i], world.ids[i], world.axes[i]
        orientation = np.array(body.orientation)
        turned = orientation if axes is None else product(orientation, axes)
        p.resetBasePositionAndOrientation(uid, body.position, _xyzw(turned), physicsClientId=world.client)
        p.resetBaseVelocity(uid, body.velocity, body.angular_velocity, physicsClientId=world.client)

    def _join(self, world: World, hinge: Hinge) -> None:
        """Two point-to-point constraints on the hinge's axis, as far apart as the longer arm is long."""
        p, scene = self._bullet, world.scene
        names = (hinge.a, hinge.b)
        arms = [np.linalg.norm(np.subtract(hinge.point, scene.body(n).position)) for n in names]
        sizes = [r for n in names if math.isfinite(r := bounding_radius(scene.body(n).shape))]
        half = 0.5 * max([*arms, *sizes])
        # a static parent must be of its own kind: PyBullet accepts no constraint with the world here
        for side in (-half, half):
            point = np.add(hinge.point, np.multiply(side, hinge.axis))
            pivots = [self._local(world, scene.index(n), point) for n in names]
            ids = [world.ids[scene.index(n)] for n in names]
            constraint = p.createConstraint(
                ids[0], -1, ids[1], -1, p.JOINT_POINT2POINT, (0, 0, 0), pivots[0], pivots[1],
                physicsClientId=world.client,
            )  # fmt: skip
            p.changeConstraint(constraint, maxForce=STIFF, physicsClientId=world.client)

    def _local(self, world: World, i: int, point: np.ndarray) -> list[float]:
        """World point in the frame PyBullet has for body i."""
        position, xyzw = self._bullet.getBasePositionAndOrientation(world.ids[i], world.client)
        return unrotate(_wxyz(xyzw), point - np.array(position)).tolist()

    def advance(self, world: World, duration: float) -> None:
        """Whole steps closest to `duration` [s]; a bare loop where no effect needs a force per step."""
        step, client, clock = self._bullet.stepSimulation, world.client, world.clock
        steps = clock.steps(duration)
        if not world.pushes:
            for _ in range(steps):
                step(client)
            return
        for k in range(clock.count - steps, clock.count):
            for push in world.pushes:
                push(k * clock.dt)
            step(client)

    def read(self, world: World) -> State:
        """State in scene order, world frame; fixed bodies stand where the scene put them."""
        p, start = self._bullet, world.scene.start()
        x, q, v, w = start.x.copy(), start.q.copy(), start.v.copy(), start.w.copy()
        for i in world.scene.moving:
            x[i], (qx, qy, qz, qw) = p.getBasePositionAndOrientation(world.ids[i], world.client)
            v[i], w[i] = p.getBaseVelocity(world.ids[i], world.client)
            q[i] = qw, qx, qy, qz
            axes = world.axes[i]
            if axes is not None:
                q[i] = product(q[i], conjugate(axes))
        return State(world.clock.time, x, q, v, w)

    def contacts(self, world: World) -> list[ContactForce]:
        """Contacts that carried force in the last step."""
        names = dict(zip(world.ids, world.scene.names, strict=True))
        found = []
        for point in self._bullet.getContactPoints(physicsClientId=world.client):
            a, b, where, normal, pressed = names[point[1]], names[point[2]], point[5], point[7], point[9]
            if pressed > 0.0:
                force = pressed * np.array(normal) + point[10] * np.array(point[11]) + point[12] * np.array(point[13])
                found.append(ContactForce(world.clock.time, a, b, tuple(where), tuple(normal), tuple(force.tolist())))
        return found

    def close(self, world: World) -> None:
        """Free the client (29 MB, 1024 slots in a process)."""
        self._bullet.disconnect(world.client)


def _substeps(settings: Settings) -> int:
    return int(settings.get("substeps", 1))


def _xyzw(q: Any) -> list[float]:
    w, x, y, z = (float(c) for c in q)
    return [x, y, z, w]


def _wxyz(q: Any) -> Quat:
    x, y, z, w = q
    return np.array([w, x, y, z])


def _principal_axes(body: Body, turns: bool) -> Quat | None:
    """What turns principal axes into body axes, or None where they are the same: PyBullet knows moments only."""
    if body.fixed or not turns:
        return None
    axes = principal(body.inertia_tensor)[1]
    return None if tuple(axes) == IDENTITY else axes


def _ground_pose(scene: Scene, body: Body) -> tuple[list[float], Quat]:
    """Pose of the box whose top face lies in the plane of a half-space, under the middle of the moving bodies."""
    assert isinstance(body.shape, HalfSpace)
    normal = rotate(np.array(body.orientation), np.array(body.shape.normal))
    origin = np.array(body.position)
    middle = np.mean([scene.bodies[i].position for i in scene.moving] or [origin], axis=0)
    foot = middle - normal * float(normal @ (middle - origin))
    return (foot - GROUND[1] * normal).tolist(), from_z(normal)


def _hull_margin(scene: Scene) -> str | None:
    hulls = [b.name for b in scene.bodies if isinstance(b.shape, Mesh)]
    return f"convex hulls touch 1 mm early (collision margin): {', '.join(hulls)}" if hulls else None


_STEPS = {"dt": TIME_STEPS, "iterations": (10.0, 50.0, 200.0, 1000.0)}
_EXACT = {
    "restitutionVelocityThreshold = 0": "the default stops every bounce slower than 0.2 m/s",
    "contactSlop = 0": "the default of 1e-5 m costs an impact up to slop/dt of speed",
    "contactProcessingThreshold = 0 (every body, where bodies may collide)": "the default brakes bodies up to 20 mm "
    "before they touch: at dt = 1 ms a ball with e = 0.8 rebounds with 0.002; where they only rest it stays, because "
    "contacts that come and go let a stack of five drift seven times as far",
    "linearDamping = angularDamping = 0": "no drag unless the scene has Drag",
    "solverResidualThreshold = 0": "the solver may not stop early",
    "numSolverIterations = 200 (knob)": "50 let resting boxes creep by 0.03 to 0.5 mm/s",
    "inertia from the scene": "a capsule's own inertia is that of its bounding box, hulls are 1 to 3 % off",
    "half-space = static box 1 km wide": "on GEOM_PLANE a box gains one contact per step and spins up to 9 rad/s",
}

_DAMPED = "the default linear and angular damping of 0.04 per second slows every body"

ENGINES = {
    engine.name: engine
    for engine in (
        PyBullet(
            "pybullet",
            maximal=True,
            stock=False,
            knobs={**_STEPS, "substeps": (1.0, 2.0, 4.0, 8.0)},
            defaults={"dt": 1e-3, "iterations": 200.0, "substeps": 1.0},
            profile={
                "useMaximalCoordinates = 1": "split impulse works for btRigidBody only; no velocity clamp",
                **_EXACT,
                "useSplitImpulse = 1, splitImpulsePenetrationThreshold = 0": "where bodies may collide (Restitution): "
                "position correction then adds nothing to the rebound, which is exact to 1e-15; where they only rest "
                "it stays off, because velocity correction holds a stack ten times better",
                "contactERP = 0": "where no contact lasts (no Resting) there is no position to correct, and lifting a "
                "bouncing ball out of the floor is work nobody did",
                "one step before the start": "btRigidBody uses the shape's inertia until its first step is over",
            },
        ),
        PyBullet(
            "pybullet:multibody",
            maximal=False,
            stock=False,
            knobs=_STEPS,
            defaults={"dt": 1e-3, "iterations": 200.0},
            profile={
                **_EXACT,
                "maxJointVelocity = 1e9": "the default silently clamps every velocity at 100 m/s and 100 rad/s",
                "contactERP = 0": "unless bodies only rest: the default adds up to 0.08 of the speed of approach; the "
                "price is that contacts that last after a collision sink",
            },
        ),
        PyBullet(
            "pybullet:stock",
            maximal=False,
            stock=True,
            knobs={"dt": TIME_STEPS, "iterations": (10.0, 50.0, 200.0, 1000.0)},
            defaults={"dt": 1.0 / 240.0, "iterations": 50.0},
            profile={},
            known={
                "keeps every velocity in a vacuum": "damping 0.04 (1 + |v|) per second, and a clamp at 100 m/s",
                "keeps the order of the bodies": _DAMPED,
                "spins with Rotation": _DAMPED,
                "falls with g": _DAMPED,
                "declares its time levels": _DAMPED,
                "a finer step is no worse": "damping makes the fall too short and a coarse step makes it too long; the "
                "finer step leaves the damping alone to be seen",
                "turns in the scene's frames": _DAMPED,
                "honours explicit inertia": _DAMPED,
            },
        ),
    )
}
