"""PyBullet: `pybullet` (fair), `pybullet:multibody` (the other back-end), `pybullet:stock` (nothing changed).

Two different dynamics hide behind one interface: maximal coordinates (btRigidBody) and reduced
coordinates (Featherstone multibody), which is the default.  They differ in damping, clamps,
gyroscopic term and position correction, so both stand trial.  Every figure quoted here was measured
with PyBullet 3.2.7.
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
from adapters.pybullet_world import HULL_MARGIN, STOCK_HULL_MARGIN, Builder, Draft, World, substeps, wxyz
from adapters.translate import TIME_STEPS, anchor_speed, factors, installed_version, muted
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
    Rotation,
    Spring,
)
from mechanics.rotation import conjugate, product
from mechanics.scene import Scene
from mechanics.shapes import Mesh
from mechanics.trajectory import State


@dataclass(frozen=True)
class _Hands:
    """How pushes reach into a PyBullet world."""

    bullet: ModuleType
    world: World

    def motion(self, i: int) -> Motion:
        uid, axes, body = self.world.ids[i], self.world.axes[i], self.world.scene.bodies[i]
        if body.fixed:  # a half-space is a box somewhere below
            return Motion(np.array(body.position), np.array(body.orientation), np.zeros(3), np.zeros(3))
        x, native = self.bullet.getBasePositionAndOrientation(uid, self.world.client)
        v, w = self.bullet.getBaseVelocity(uid, self.world.client)
        q = wxyz(native) if axes is None else product(wxyz(native), conjugate(axes))
        return Motion(np.array(x), q, np.array(v), np.array(w))

    def push(self, i: int, force: Vec3, torque: Vec3) -> None:
        p, uid, client = self.bullet, self.world.ids[i], self.world.client
        centre = p.getBasePositionAndOrientation(uid, client)[0]
        p.applyExternalForce(uid, -1, force.tolist(), centre, p.WORLD_FRAME, client)
        p.applyExternalTorque(uid, -1, torque.tolist(), p.WORLD_FRAME, client)


@dataclass(kw_only=True)
class PyBullet(Configured):
    """PyBullet with one set of settings, as an engine.

    Attributes
    ----------
    maximal : bool
        Maximal coordinates (btRigidBody) instead of the multibody solver.
    """

    maximal: bool

    @cached_property
    def effects(self) -> dict[type[Effect], Callable[[Draft, Any], str | None]]:
        """How each effect is switched on; see `adapters.engine.Engine`."""
        return {
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
        return float(settings["dt"]) / (2.0 * substeps(settings))

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
        return self._hull_margin(draft.scene)

    def _friction(self, draft: Draft, effect: Friction) -> str | None:
        draft.friction = factors(draft.scene, effect)
        return None if Restitution in draft.scene.needs else self._hull_margin(draft.scene)

    def _resting(self, draft: Draft, _: Resting) -> str | None:
        return self._hull_margin(draft.scene) if draft.scene.needs.isdisjoint({Restitution, Friction}) else None

    def _hull_margin(self, scene: Scene) -> str | None:
        hulls = [b.name for b in scene.bodies if isinstance(b.shape, Mesh)]
        margin = 1e3 * (HULL_MARGIN if self.departs("collisionMargin") else STOCK_HULL_MARGIN)
        return f"convex hulls touch {margin:g} mm early (collision margin): {', '.join(hulls)}" if hulls else None

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
            world = Builder(p, self.maximal, self.departs, self.remedy).build(draft, knobs, client)
            hands = _Hands(p, world)
            world.pushes = [pusher(world.scene, effect, hands, world.clock.dt) for effect in draft.pushes]
            return world
        except BaseException:
            p.disconnect(client)
            raise

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
    "collisionMargin = 1e-5 m (convex hulls)": "the default makes them 1 mm larger: hulls placed face to face begin in "
    "overlap and are driven apart at 0.07 m/s",
    "half-space = static box 1 km wide": "on GEOM_PLANE a box gains one contact per step and spins up to 9 rad/s",
}

_STOCK = {"dt": 1.0 / 240.0, "iterations": 50.0}
_DAMPED = "the default linear and angular damping of 0.04 per second slows every body"

ENGINES = {
    engine.name: engine
    for engine in (
        PyBullet(
            name="pybullet",
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
            name="pybullet:multibody",
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
            name="pybullet:stock",
            maximal=False,
            stock=True,
            knobs=_STEPS,
            defaults=_STOCK,
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
        PyBullet(
            name="pybullet:undamped",
            maximal=False,
            stock=True,
            knobs=_STEPS,
            defaults=_STOCK,
            profile={"linearDamping = angularDamping = 0": "the remedy for drag that nobody asked for"},
            on_request=True,
            remedy={"linearDamping": 0.0, "angularDamping": 0.0},
            known={"keeps every velocity in a vacuum": "a clamp at 100 m/s"},
        ),
        PyBullet(
            name="pybullet:ccd",
            maximal=True,
            stock=True,
            knobs=_STEPS,
            defaults=_STOCK,
            profile={
                "ccdSweptSphereRadius = half the bounding radius": "bodies are swept along their path in a step",
                "useMaximalCoordinates = 1": "on the default multibody the radius has no effect",
            },
            on_request=True,
            remedy={"ccdSweptSphereRadius": 0.5},
        ),
    )
}
