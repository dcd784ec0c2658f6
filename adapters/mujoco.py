"""MuJoCo: `mujoco` (fair) and `mujoco:stock` (the defaults of a model file).

MuJoCo has no coefficient of restitution: its contacts are springs and dampers.  A damper that acts
for exactly one step is Newton's law, though: with stiffness 0, damping (1 + e)/h and an impedance d
that does not vary with depth a contact changes the approach u into

    u⁺ = u - d (1 + e) u + (1 - d) g h,    d = 0.9999,

whatever the masses.  The parameters depend on the step h and are written anew for every h.  Every
figure quoted here was measured with MuJoCo 4.0.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cached_property
from types import ModuleType
from typing import Any

import numpy as np

from adapters.configured import Configured
from adapters.engine import Clock, ContactForce, Diverged, Refusal, Settings
from adapters.mujoco_model import Draft, Modeller, smooth, tree
from adapters.mujoco_world import Hands, World
from adapters.pushes import pusher
from adapters.translate import TIME_STEPS, anchor_speed, installed_version
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
from mechanics.rotation import rotate, unrotate
from mechanics.scene import Scene
from mechanics.shapes import Mesh
from mechanics.trajectory import State


class MuJoCo(Configured):
    """MuJoCo with one set of settings, as an engine."""

    @cached_property
    def effects(self) -> dict[type[Effect], Callable[[Draft, Any], str | None]]:
        """How each effect is switched on; see `adapters.engine.Engine`."""
        return {
            Gravity: self._gravity,
            Rotation: self._rotation,
            Drag: self._drag,
            Force: self._force,
            Spring: self._link,
            Rod: self._link,
            Tether: self._link,
            Hinge: self._hinge,
            Restitution: self._restitution,
            Friction: self._friction,
            Resting: self._resting,
        }

    @property
    def all_on(self) -> MuJoCo | None:
        """This engine with every stage of a step on, whatever the scene calls for; None where it is so anyway."""
        return None if self.stock else replace(self, name=f"{self.name}, all on", remedy={"stages": "all"})

    @property
    def version(self) -> str:
        """Version of the installed MuJoCo; ImportError if there is none."""
        return installed_version("mujoco", "mujoco-core")

    @cached_property
    def _mujoco(self) -> ModuleType:
        import mujoco

        return mujoco

    def settle(self, settings: Settings, scene: Scene) -> Settings:
        """Integrator `auto` becomes RK4 where nothing can touch or go taut, and Euler elsewhere.

        A damper that acts for one step is lost between the four stages of RK4.
        """
        if settings["integrator"] != "auto":
            return settings
        return {**settings, "integrator": "RK4" if smooth(scene) else "Euler"}

    def lead(self, settings: Settings) -> float:
        """Half a step for the semi-implicit integrators, none for RK4 [s]."""
        return 0.0 if settings["integrator"] == "RK4" else 0.5 * float(settings["dt"])

    def vacuum(self, scene: Scene) -> Draft:
        """Draft in which nothing acts.

        Raises
        ------
        Refusal
            For moving fixed bodies and non-convex meshes.
        """
        for body in scene.bodies:
            if body.fixed and any((*body.velocity, *body.acceleration)):
                raise Refusal(f"MuJoCo's fixed bodies have no velocity in contact; {body.name!r} is fixed and moves")
            if isinstance(body.shape, Mesh) and not body.shape.convex:
                raise Refusal(f"MuJoCo collides the convex hull of the mesh {body.name!r}, which is not convex")
        return Draft(scene)

    def _gravity(self, draft: Draft, effect: Gravity) -> str | None:
        draft.gravity = effect.acceleration
        return self._integrator_note(draft.scene)

    def _rotation(self, draft: Draft, _: Rotation) -> str | None:
        draft.turns = True
        return None if Gravity in draft.scene.needs else self._integrator_note(draft.scene)

    def _integrator_note(self, scene: Scene) -> str | None:
        if self.stock or not smooth(scene):
            return None
        return "integrator auto is RK4 here: nothing in this scene can touch"

    def _drag(self, draft: Draft, effect: Drag) -> None:
        draft.drags.append(effect)

    def _force(self, draft: Draft, effect: Force) -> str | None:
        draft.forces.append(effect)
        return "Force: its torque is computed by the adapter once per step" if any(effect.point) else None

    def _link(self, draft: Draft, effect: Spring | Rod | Tether) -> str | None:
        if self.stock and isinstance(effect, Tether) and effect.restitution > 0.0:
            raise Refusal("MuJoCo's tendons have no coefficient of restitution")
        draft.links.append(effect)
        return None if isinstance(effect, Spring) else f"{type(effect).__name__}: a soft tendon"

    def _restitution(self, draft: Draft, effect: Restitution) -> str | None:
        if self.stock:
            return "MuJoCo has no coefficient of restitution: with stock contacts a ball rebounds at 0.13 of its speed"
        return None

    def _friction(self, draft: Draft, effect: Friction) -> str | None:
        if self.stock and len(set(effect.values())) > 1:
            raise Refusal(f"{self.name} has one friction coefficient per body and takes the larger of two")
        return "Friction: MuJoCo's convex cone lifts a sliding body, by up to µ v dt b with b the friction damping"

    def _resting(self, draft: Draft, _: Resting) -> str:
        return (
            "Resting: contacts are soft; an overlap decays by 1 % a step"
            if not self.stock
            else "Resting: soft contacts"
        )

    def _hinge(self, draft: Draft, effect: Hinge) -> None:
        scene = draft.scene
        if Rotation not in scene.needs:
            raise Refusal("a hinge between bodies that may not turn")
        speed = anchor_speed(scene, effect)
        if speed > 1e-9:
            raise Refusal(f"Hinge {effect.a!r}-{effect.b!r}: its two sides part at {speed:g} m/s at the start")
        if not draft.hinges:
            draft.hinges.update(tree(scene))

    def start(self, draft: Draft, knobs: Settings) -> World:
        """World compiled from the draft.

        Raises
        ------
        Refusal
            For RK4 in a scene with contacts, rods or tethers.
        """
        mj, scene = self._mujoco, draft.scene
        settings = self.settle(knobs, scene)
        if settings["integrator"] == "RK4" and not smooth(scene) and not self.stock:
            raise Refusal("contacts, rods and tethers that act for one step are lost in RK4; use Euler or auto")
        spec = Modeller(mj, self.departs, self.remedy).spec(draft, settings)
        model = spec.compile()
        data = mj.MjData(model)
        bodies = [self._number(model, "mjOBJ_BODY", f"body{i}") for i in range(len(scene.bodies))]
        joints = [self._number(model, "mjOBJ_JOINT", f"joint{i}") for i in range(len(scene.bodies))]
        clock = Clock(float(settings["dt"]))
        heard = mj.get_mju_user_warning()
        world = World(scene, model, data, clock, draft.turns, bool(draft.hinges), bodies, joints, heard)
        self._set_motion(world, draft)
        self._set_loads(world, draft)
        return world

    def _number(self, model: Any, kind: str, name: str) -> int:
        return int(self._mujoco.mj_name2id(model, getattr(self._mujoco.mjtObj, kind), name))

    def _set_motion(self, world: World, draft: Draft) -> None:
        model, data, scene = world.model, world.data, world.scene
        for i in scene.moving:
            body, joint = scene.bodies[i], world.joints[i]
            at, dof = model.jnt_qposadr[joint], model.jnt_dofadr[joint]
            if i in draft.hinges:
                parent, hinge = draft.hinges[i]
                turning = np.subtract(body.angular_velocity, scene.bodies[parent].angular_velocity)
                data.qvel[dof] = float(np.dot(hinge.axis, turning))
                continue
            data.qvel[dof : dof + 3] = body.velocity
            if world.turns:
                q = np.array(body.orientation)
                data.qpos[at : at + 7] = (*body.position, *body.orientation)
                data.qvel[dof + 3 : dof + 6] = unrotate(q, np.array(body.angular_velocity))

    def _set_loads(self, world: World, draft: Draft) -> None:
        """Drag as joint damping and constant forces once for all; what varies becomes a push per step."""
        hands = Hands(self._mujoco, world)
        for drag in draft.drags:
            if world.hinged:
                world.pushes.append(pusher(world.scene, drag, hands, world.clock.dt))
                continue
            for i in world.scene.moving:
                if not drag.bodies or world.scene.names[i] in drag.bodies:
                    dof = world.model.jnt_dofadr[world.joints[i]]
                    world.model.dof_damping[dof : dof + 3] += drag.linear
                    if world.turns:
                        world.model.dof_damping[dof + 3 : dof + 6] += drag.angular
        varying = any(any(f.point) or f.start > 0.0 or f.end < np.inf for f in draft.forces)
        for force in draft.forces:
            if varying or world.pushes:
                world.pushes.append(pusher(world.scene, force, hands, world.clock.dt))
            else:
                hands.push(world.scene.index(force.body), np.array(force.force), np.array(force.torque))

    def advance(self, world: World, duration: float) -> None:
        """Whole steps closest to `duration` [s], in one call where no force has to be computed per step.

        Raises
        ------
        Diverged
            If MuJoCo warned.
        """
        mj, steps = self._mujoco, world.clock.steps(duration)
        if not steps:
            return
        # the stock handler writes a log file into the working directory; which world hears is one for the process
        if mj.get_mju_user_warning() is not world.hear:
            mj.set_mju_user_warning(world.hear)
        if not world.pushes:
            mj.mj_step(world.model, world.data, nstep=steps)
        else:
            self._step_pushed(world, steps)
        if world.warnings:
            raise Diverged(world.warnings[0])

    def _step_pushed(self, world: World, steps: int) -> None:
        clock = world.clock
        hands = Hands(self._mujoco, world)
        for k in range(clock.count - steps, clock.count):
            hands.refresh()
            world.data.xfrc_applied[:] = 0.0
            for push in world.pushes:
                push(k * clock.dt)
            self._mujoco.mj_step(world.model, world.data)

    def close(self, world: World) -> None:
        """Let warnings go where they went before the world moved."""
        if self._mujoco.get_mju_user_warning() is world.hear:
            self._mujoco.set_mju_user_warning(world.before)

    def read(self, world: World) -> State:
        """State in scene order, world frame; read from qpos and qvel, because MuJoCo's Cartesian data lag a step."""
        start = world.scene.start()
        x, q, v, w = start.x.copy(), start.q.copy(), start.v.copy(), start.w.copy()
        moving = list(world.scene.moving)
        if world.hinged:
            hands = Hands(self._mujoco, world)
            hands.refresh()
            for i in moving:
                x[i], q[i], v[i], w[i] = hands.motion(i)
        elif moving:
            # every moving body has 3 or 7 coordinates and 3 or 6 velocities, in scene order
            qpos, qvel = (a.reshape(len(moving), -1) for a in (world.data.qpos, world.data.qvel))
            v[moving] = qvel[:, :3]
            if world.turns:
                x[moving], q[moving] = qpos[:, :3], qpos[:, 3:]
                w[moving] = rotate(q[moving], qvel[:, 3:])
            else:
                x[moving] += qpos
        return State(world.clock.time, x, q, v, w)

    def contacts(self, world: World) -> list[ContactForce]:
        """Contacts that carried force in the last step (they belong to the state before it)."""
        model, data = world.model, world.data
        scene_place = {number: i for i, number in enumerate(world.bodies)}
        found, wrench = [], np.zeros(6)
        for k in range(data.ncon):
            contact = data.contact[k]
            self._mujoco.mj_contactForce(model, data, k, wrench)
            if wrench[0] > 0.0:
                # MuJoCo's normal points from its first to its second shape, and the force acts on the second
                b, a = (world.scene.names[scene_place[int(model.geom_bodyid[g])]] for g in contact.geom)
                axes = contact.frame.reshape(3, 3)
                force = tuple((axes.T @ wrench[:3]).tolist())
                found.append(
                    ContactForce(world.clock.time, a, b, tuple(contact.pos.tolist()), tuple(axes[0].tolist()), force)
                )
        return found


_ITERATIONS = (5.0, 20.0, 100.0, 500.0)


def _remedied(name: str, why: str, **remedy: Any) -> MuJoCo:
    """The stock profile with one documented remedy, which runs on request only."""
    said = ", ".join(f"{key} = {value}" for key, value in remedy.items())
    return MuJoCo(
        name=f"mujoco:{name}",
        stock=True,
        knobs=_STOCK_KNOBS,
        defaults=_STOCK,
        profile={"autoreset = disable": _NO_RESET, said: why},
        on_request=True,
        remedy=remedy,
    )


_STOCK_KNOBS = {"dt": TIME_STEPS, "integrator": ("Euler", "implicitfast", "RK4"), "iterations": _ITERATIONS}
_STOCK = {"dt": 2e-3, "integrator": "Euler", "iterations": 100.0}
_NO_RESET = "a bad state is a failure, not silently the initial state again"

ENGINES = {
    engine.name: engine
    for engine in (
        MuJoCo(
            name="mujoco",
            stock=False,
            knobs={
                "dt": TIME_STEPS,
                "integrator": ("Euler", "implicitfast", "RK4", "auto"),
                "iterations": _ITERATIONS,
                "tolerance": (1e-4, 1e-6, 1e-8, 1e-10, 1e-12),
            },
            defaults={"dt": 1e-3, "integrator": "auto", "iterations": 100.0, "tolerance": 1e-10},
            profile={
                "solref = 0 -(1+e)/dt": "restitution as a damper of one step, exact to 1e-11; the default rebounds "
                "with 0.13 whatever is wanted",
                "solimp = 0.9999 0.9999": "an impedance that varies with depth changes e by up to 0.11",
                "solref[0] = -0.01/dt^2 (Resting)": "overlap decays by 1 % a step; 10 % makes a stack of 100 explode",
                "solreffriction = 0 -1/dt": "friction impulse within the step of the impact; left alone it bounces too",
                "solreffriction = 0.02 1 (Resting, e = 0)": "friction that acts within one step lifts a sliding body",
                "cone = elliptic": "the pyramid slides 41 % too far at 45 degrees",
                "explicit pairs": "coefficients belong to pairs; the default takes the larger of two; MuJoCo's own "
                "broad phase finds the pairs where more than 3000 are alike and smooth, with the same result",
                "explicit inertia": "comes from the scene, never from shapes",
                "diagexact = enable": "the approximate diagonal gives a hinged cradle 0.2 % energy",
                "tolerance = 1e-10 (knob)": "the solver may not stop early",
                "autoreset = disable": "a bad state is a failure, not silently the initial state again",
                "disableflags = stages without work": "only what the scene calls for is on; the answer is the same to "
                "the last bit, and where nothing can touch a step takes 0.8 of the time",
                "integrator = auto (knob)": "RK4, which MuJoCo recommends for accuracy, where nothing can touch; "
                "Euler, the default, elsewhere, because RK4 loses a damper of one step",
            },
        ),
        MuJoCo(
            name="mujoco:stock",
            stock=True,
            knobs=_STOCK_KNOBS,
            defaults=_STOCK,
            profile={"autoreset = disable": _NO_RESET},
        ),
        _remedied("elliptic", "Coulomb's cone in place of a pyramid", cone="mjCONE_ELLIPTIC"),
        _remedied(
            "noslip",
            "friction that does not give way, and a pass that takes back what does",
            cone="mjCONE_ELLIPTIC",
            impratio=10.0,
            noslip_iterations=10,
        ),
        _remedied("speculative", "contacts are looked for along the path of a step", flags="mjENBL_SPECULATIVE"),
        _remedied("elastic", "contacts are springs without damping", solref=(-1e4, 0.0)),
    )
}
