"""How a scene becomes a PyBullet world: settings, bodies, shapes and hinges.

Every figure quoted here was measured with PyBullet 3.2.7.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import ModuleType
from typing import Any

import numpy as np

from adapters.engine import Clock, Settings
from adapters.pushes import Push
from adapters.translate import joined, rests_only, shortest
from mechanics.arrays import Quat, Triple, Vec3
from mechanics.effects import Effect, Hinge, Resting
from mechanics.inertia import principal
from mechanics.rotation import IDENTITY, conjugate, product, rotate, unrotate
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, Capsule, Cylinder, HalfSpace, Mesh, Sphere, bounding_radius

GROUND = (500.0, 50.0)  # half width and half height of the box that stands for a half-space [m]
FREE_SPEED = 1e9  # clamp of the multibody solver raised out of reach [m/s, rad/s]
THRESHOLDS = ("restitutionVelocityThreshold", "contactSlop", "solverResidualThreshold")  # made zero
STIFF = 1e12  # largest force of a hinge [N]: none
HULL_MARGIN = 1e-5  # by which convex hulls are made larger [m]; without any, shallow contacts count as deep ones
STOCK_HULL_MARGIN = 1e-3  # what PyBullet makes it [m]


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
class Builder:
    """Makes worlds of drafts.

    Attributes
    ----------
    bullet : module
        The imported pybullet.
    maximal : bool
        Maximal coordinates (btRigidBody) instead of the multibody solver.
    departs : function of str
        Whether a setting departs from stock; where none does, nothing but what the scene says is set.
    remedy : mapping
        Arguments of changeDynamics for moving bodies, besides; ccdSweptSphereRadius is a share of the bounding ball's.
    """

    bullet: ModuleType
    maximal: bool
    departs: Callable[[str], bool]
    remedy: Mapping[str, Any] = field(default_factory=dict)

    def build(self, draft: Draft, knobs: Settings, client: int) -> World:
        """World of the draft in the empty client."""
        p, scene = self.bullet, draft.scene
        self._configure(client, scene, knobs)
        world = World(scene, client, Clock(float(knobs["dt"])), substeps(knobs), [], [])
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
        return world

    def _configure(self, client: int, scene: Scene, knobs: Settings) -> None:
        p = self.bullet
        p.setTimeStep(float(knobs["dt"]), physicsClientId=client)
        settings: dict[str, float] = {"numSolverIterations": int(knobs["iterations"])}
        if substeps(knobs) > 1:
            settings["numSubSteps"] = substeps(knobs)
        settings |= {name: 0.0 for name in THRESHOLDS if self.departs(name)}
        if self.departs("useSplitImpulse") and not rests_only(scene) and self.maximal:
            settings |= {"useSplitImpulse": 1, "splitImpulsePenetrationThreshold": 0.0}
        if self.departs("contactERP") and (Resting not in scene.needs or not (self.maximal or rests_only(scene))):
            settings["contactERP"] = 0.0
        p.setPhysicsEngineParameter(**settings, physicsClientId=client)

    def _add(self, world: World, draft: Draft, i: int) -> None:
        """Create body i; moving ones stand apart until `_place`, so that nothing touches before the start."""
        p, body = self.bullet, world.scene.bodies[i]
        axes = _principal_axes(body, draft.turns and (self.departs("inertia") or body.inertia is not None))
        position, orientation = _ground_pose(world.scene, body) if self._boxed(body) else (body.position, None)
        if orientation is None:
            orientation = body.orientation if axes is None else product(np.array(body.orientation), axes)
        if not body.fixed:
            position = (0.0, 0.0, 1e4 * (i + 1))
        shape = self._shape(body, axes, world.client) if world.scene.touching or not self.departs("inertia") else -1
        uid = p.createMultiBody(
            body.mass or 0.0, shape, -1, position, xyzw(orientation),
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
            elif self.departs("inertia") or body.inertia is not None:
                moments = principal(body.inertia_tensor)[0].tolist()
                settings |= {"mass": body.mass, "localInertiaDiagonal": moments}
        if self.departs("damping"):
            settings |= {"linearDamping": 0.0, "angularDamping": 0.0}
        if self.departs("contactProcessingThreshold") and not rests_only(draft.scene):
            settings["contactProcessingThreshold"] = 0.0
        if self.departs("maxJointVelocity") and not self.maximal:
            settings["maxJointVelocity"] = FREE_SPEED
        if self.departs("collisionMargin") and isinstance(body.shape, Mesh):
            settings["collisionMargin"] = HULL_MARGIN
        if not body.fixed:
            settings |= self.remedy
            if "ccdSweptSphereRadius" in self.remedy:
                settings["ccdSweptSphereRadius"] *= bounding_radius(body.shape)
        return settings

    def _boxed(self, body: Body) -> bool:
        return isinstance(body.shape, HalfSpace) and self.departs("half-space")

    def _shape(self, body: Body, axes: Quat | None, client: int) -> int:
        p = self.bullet
        frame: dict[str, Any] = {} if axes is None else {"collisionFrameOrientation": xyzw(conjugate(axes))}
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
                # a shape with a frame of its own is a compound, whose margin does not reach the hull inside
                turned = np.array(vertices) if axes is None else unrotate(axes, np.array(vertices))
                form, frame = {"shapeType": p.GEOM_MESH, "vertices": turned.tolist()}, {}
            case HalfSpace(normal) if not self._boxed(body):
                form = {"shapeType": p.GEOM_PLANE, "planeNormal": normal}
            case HalfSpace():
                depth = abs(_face(_upward(body)))
                form = {"shapeType": p.GEOM_BOX, "halfExtents": np.where(depth, GROUND[1], GROUND[0]).tolist()}
        return p.createCollisionShape(**form, **frame, physicsClientId=client)

    def _place(self, world: World, i: int) -> None:
        p, body, uid, axes = self.bullet, world.scene.bodies[i], world.ids[i], world.axes[i]
        orientation = np.array(body.orientation)
        turned = orientation if axes is None else product(orientation, axes)
        p.resetBasePositionAndOrientation(uid, body.position, xyzw(turned), physicsClientId=world.client)
        p.resetBaseVelocity(uid, body.velocity, body.angular_velocity, physicsClientId=world.client)

    def _join(self, world: World, hinge: Hinge) -> None:
        """Two point-to-point constraints on the hinge's axis, as far apart as the longer arm is long."""
        p, scene = self.bullet, world.scene
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
        position, native = self.bullet.getBasePositionAndOrientation(world.ids[i], world.client)
        return unrotate(wxyz(native), point - np.array(position)).tolist()


def substeps(settings: Settings) -> int:
    """How many steps of its own PyBullet takes in one step of the clock."""
    return int(settings.get("substeps", 1))


def xyzw(q: Any) -> list[float]:
    """PyBullet's order of a quaternion (w, x, y, z)."""
    w, x, y, z = (float(c) for c in q)
    return [x, y, z, w]


def wxyz(q: Any) -> Quat:
    """The house's order of a quaternion (x, y, z, w)."""
    x, y, z, w = q
    return np.array([w, x, y, z])


def _principal_axes(body: Body, turns: bool) -> Quat | None:
    """What turns principal axes into body axes, or None where they are the same: PyBullet knows moments only."""
    if body.fixed or not turns:
        return None
    axes = principal(body.inertia_tensor)[1]
    return None if tuple(axes) == IDENTITY else axes


def _ground_pose(scene: Scene, body: Body) -> tuple[list[float], Quat]:
    """Pose of the box one face of which lies in the plane of a half-space, under the middle of the moving bodies."""
    normal, origin = _upward(body), np.array(body.position)
    middle = np.mean([scene.bodies[i].position for i in scene.moving] or [origin], axis=0)
    foot = middle - normal * float(normal @ (middle - origin))
    return (foot - GROUND[1] * normal).tolist(), shortest(_face(normal), normal)


def _upward(body: Body) -> Vec3:
    """Normal of a half-space in the world frame."""
    assert isinstance(body.shape, HalfSpace)
    return rotate(np.array(body.orientation), np.array(body.shape.normal))


def _face(normal: Vec3) -> Vec3:
    """The axis, up or down, closest to `normal`: the face that needs least turning, none at all for walls.

    Bullet's matrix of a turned box is rounded, and balls that strike it squarely leave their line.
    """
    axis = int(np.argmax(np.abs(normal)))
    return np.sign(normal[axis]) * np.eye(3)[axis]
