"""How a scene becomes a MuJoCo model: bodies in trees, shapes, pairs and tendons, through MjSpec.

Contact parameters depend on the time step and are written for it.  Every figure quoted here was
measured with MuJoCo 4.0.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from types import ModuleType
from typing import Any

import numpy as np

from adapters.engine import Refusal, Settings
from adapters.translate import joined, shortest
from mechanics.arrays import Quat, Triple
from mechanics.effects import Drag, Force, Friction, Hinge, Resting, Restitution, Rod, Spring, Tether
from mechanics.inertia import principal
from mechanics.rotation import IDENTITY, conjugate, product, rotate, unrotate
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, Capsule, Cylinder, HalfSpace, Mesh, Sphere

INTEGRATORS = {"Euler": "mjINT_EULER", "implicitfast": "mjINT_IMPLICITFAST", "RK4": "mjINT_RK4"}
IMPEDANCE = (0.9999, 0.9999, 0.001, 0.5, 2.0)  # constant in depth; 0.9999 is the largest MuJoCo allows
CORRECTION = 0.01  # share of the overlap undone per step: the largest with which a stack of 100 stands

MANY_PAIRS = 3000  # with more, MuJoCo's broad phase pays: 1.7 times the cost at 1,275 pairs, a quarter at 20,100


@dataclass
class Draft:
    """A world that is still a vacuum, and what has been switched on."""

    scene: Scene
    gravity: Triple = (0.0, 0.0, 0.0)
    turns: bool = False
    drags: list[Drag] = field(default_factory=list)
    forces: list[Force] = field(default_factory=list)
    links: list[Spring | Rod | Tether] = field(default_factory=list)
    hinges: dict[int, tuple[int, Hinge]] = field(default_factory=dict)  # child -> (parent, hinge)


@dataclass(frozen=True)
class Modeller:
    """Makes models of drafts.

    Attributes
    ----------
    mujoco : module
        The imported mujoco.
    departs : function of str
        Whether a setting departs from stock; where none does, only masses, shapes, friction and gravity are set.
    remedy : mapping
        Names of `option` and of `geom` -> values that are set besides; `flags` names flags to be enabled, and
        `stages` = "all" leaves every stage of a step on, wanted or not.
    """

    mujoco: ModuleType
    departs: Callable[[str], bool]
    remedy: Mapping[str, Any] = field(default_factory=dict)

    def spec(self, draft: Draft, settings: Settings) -> Any:
        """MjSpec of the draft, with settings that leave nothing to the scene."""
        mj, scene = self.mujoco, draft.scene
        spec = mj.MjSpec()
        option = spec.option
        option.timestep = float(settings["dt"])
        option.gravity = draft.gravity
        option.integrator = getattr(mj.mjtIntegrator, INTEGRATORS[str(settings["integrator"])])
        option.iterations = int(settings["iterations"])
        # without it a bad state is silently replaced by the initial one
        option.disableflags = int(mj.mjtDisableBit.mjDSBL_AUTORESET)
        if self.departs("cone"):
            option.cone = mj.mjtCone.mjCONE_ELLIPTIC
        if "tolerance" in settings:
            option.tolerance = float(settings["tolerance"])
        if self.departs("diagexact"):
            option.enableflags = int(mj.mjtEnableBit.mjENBL_DIAGEXACT)
            if self.remedy.get("stages") != "all":
                option.disableflags |= _without_work(mj, draft)
        self._remedy(option)
        made: dict[int, Any] = {}
        for i in _parents_first(scene, draft.hinges):
            self._add(spec, draft, i, made)
        for n, link in enumerate(draft.links):
            self._tie(spec, draft, n, link, made)
        self._let_touch(spec, scene, float(settings["dt"]))
        return spec

    def _let_touch(self, spec: Any, scene: Scene, h: float) -> None:
        """Which shapes collide and how: pair by pair, or all alike where there are very many."""
        fair = self.departs("contact")
        pairs = list(scene.pairs()) if fair else []
        alike = alike_and_many(scene, pairs)
        if not fair or alike:
            for a, b in joined(scene):
                spec.add_exclude(bodyname1=f"body{scene.index(a)}", bodyname2=f"body{scene.index(b)}")
        if alike:
            for geom in spec.geoms:
                geom.contype = geom.conaffinity = geom.condim = 1
                geom.solref, geom.solimp = _normal(scene, *pairs[0], h), IMPEDANCE
            return
        for i, j in pairs:
            self._pair(spec, scene, i, j, h)

    def _remedy(self, option: Any) -> None:
        """Set what a remedy changes in the options of the solver."""
        for name, value in self.remedy.items():
            if name == "flags":
                option.enableflags |= int(getattr(self.mujoco.mjtEnableBit, value))
            elif name == "cone":
                option.cone = getattr(self.mujoco.mjtCone, value)
            elif hasattr(option, name):
                setattr(option, name, value)

    def _add(self, spec: Any, draft: Draft, i: int, made: dict[int, Any]) -> None:
        """Body i with its joints and its shape."""
        body = draft.scene.bodies[i]
        parent, hinge = draft.hinges.get(i, (None, None))
        above = None if parent is None or draft.scene.bodies[parent].fixed else draft.scene.bodies[parent]
        frame = _frame(body, draft.turns)
        position, orientation = np.array(body.position), frame
        if above is not None:
            base = np.array(above.orientation)
            position = unrotate(base, position - np.array(above.position))
            orientation = product(conjugate(base), frame)
        holder = spec.worldbody if above is None else made[parent]
        made[i] = child = holder.add_body(name=f"body{i}", pos=position, quat=orientation)
        if not body.fixed:
            self._let_move(child, body, i, draft.turns, hinge)
            self._weigh(child, body)
        if draft.scene.touching or not self.departs("inertia"):
            self._shape(spec, child, draft, i, product(conjugate(frame), np.array(body.orientation)))

    def _let_move(self, child: Any, body: Body, i: int, turns: bool, hinge: Hinge | None) -> None:
        mj = self.mujoco
        if hinge is not None:
            q = np.array(body.orientation)
            point = unrotate(q, np.subtract(hinge.point, body.position))
            axis = unrotate(q, np.array(hinge.axis))
            child.add_joint(name=f"joint{i}", type=mj.mjtJoint.mjJNT_HINGE, pos=point, axis=axis)
        elif turns:
            child.add_freejoint(name=f"joint{i}")
        else:
            for k, axis in enumerate(np.eye(3)):
                child.add_joint(name=f"joint{i}{'' if k == 0 else f'.{k}'}", type=mj.mjtJoint.mjJNT_SLIDE, axis=axis)

    def _weigh(self, child: Any, body: Body) -> None:
        """Mass and inertia of the scene; a stock body gets its inertia from its shape unless the scene names one."""
        if not self.departs("inertia") and body.inertia is None:
            return
        moments, axes = principal(body.inertia_tensor)
        child.mass, child.inertia = body.mass, moments
        # left unset they become the body's pose in its parent
        child.ipos, child.iquat = np.zeros(3), axes
        child.explicitinertial = True

    def _shape(self, spec: Any, child: Any, draft: Draft, i: int, turned: Quat) -> None:
        kind, body = self.mujoco.mjtGeom, draft.scene.bodies[i]
        form: dict[str, Any] = {}
        match body.shape:
            case Sphere(radius):
                form = {"type": kind.mjGEOM_SPHERE, "size": (radius, 0.0, 0.0)}
            case Box(size):
                form = {"type": kind.mjGEOM_BOX, "size": [0.5 * s for s in size]}
            case Capsule(radius, length):
                form = {"type": kind.mjGEOM_CAPSULE, "size": (radius, 0.5 * length, 0.0)}
            case Cylinder(radius, length):
                form = {"type": kind.mjGEOM_CYLINDER, "size": (radius, 0.5 * length, 0.0)}
            case HalfSpace(normal):
                form = {"type": kind.mjGEOM_PLANE, "size": (0.0, 0.0, 1.0)}
                turned = product(turned, shortest(np.array([0.0, 0.0, 1.0]), np.array(normal)))
            case Mesh(vertices, triangles):
                spec.add_mesh(name=f"mesh{i}", uservert=np.ravel(vertices), userface=np.ravel(triangles))
                form = {"type": kind.mjGEOM_MESH, "meshname": f"mesh{i}"}
        # fair: coefficients belong to pairs, so only those that are named collide (see `_let_touch`)
        collide = int(not self.departs("contact") and draft.scene.touching)
        geom = child.add_geom(name=f"shape{i}", quat=turned, contype=collide, conaffinity=collide, **form)
        if not self.departs("inertia") and not body.fixed:
            geom.mass = body.mass
        if not self.departs("contact"):
            effect = draft.scene.effect(Friction)
            geom.friction = [effect.coefficient if effect else 0.0, 0.005, 0.0001]
            if "solref" in self.remedy:
                geom.solref = self.remedy["solref"]

    def _pair(self, spec: Any, scene: Scene, i: int, j: int, h: float) -> None:
        """Contact parameters of one pair for the step h.

        A pair that only rests slides as well: its friction gets 20 ms, because friction that acts
        within one step lifts a sliding body (33 mm at 2 m/s, whatever the step).
        """
        e, mu = scene.restitution(i, j), scene.friction(i, j)
        slow = Resting in scene.needs and e == 0.0
        spec.add_pair(
            geomname1=f"shape{i}",
            geomname2=f"shape{j}",
            condim=3 if mu > 0.0 else 1,  # of three, MuJoCo's least coefficient of 1e-5 would act
            friction=[mu, mu, 0.0, 0.0, 0.0],
            solref=_normal(scene, i, j, h),
            solreffriction=[0.02, 1.0] if slow else [0.0, -1.0 / h],
            solimp=IMPEDANCE,
        )

    def _tie(self, spec: Any, draft: Draft, n: int, link: Spring | Rod | Tether, made: dict[int, Any]) -> None:
        """A tendon between two anchors: elastic (Spring), of constant length (Rod), or limited (Tether)."""
        mj, h = self.mujoco, spec.option.timestep
        ends = []
        for name, anchor in ((link.a, link.anchor_a), (link.b, link.anchor_b)):
            i = draft.scene.index(name)
            body = draft.scene.bodies[i]
            local = rotate(product(conjugate(_frame(body, draft.turns)), np.array(body.orientation)), np.array(anchor))
            ends.append(f"site{n}{len(ends)}")
            made[i].add_site(name=ends[-1], pos=local)
        tendon = spec.add_tendon(name=f"tendon{n}")
        for end in ends:
            tendon.wrap_site(end)
        match link:
            case Spring():
                # both are polynomials in MuJoCo 4; the scene's are linear
                tendon.stiffness, tendon.damping = [link.stiffness, 0.0, 0.0], [link.damping, 0.0, 0.0]
                tendon.springlength = [link.length, link.length]
            case Rod():
                rod = spec.add_equality(type=mj.mjtEq.mjEQ_TENDON, name1=f"tendon{n}")
                if self.departs("links"):
                    # the whole error in one step: no rebound is there to be falsified
                    rod.solref, rod.solimp = [-1.0 / h**2, -1.0 / h], IMPEDANCE
            case Tether():
                tendon.limited, tendon.range = True, [0.0, link.length]
                if self.departs("links"):
                    tendon.solref_limit = [-CORRECTION / h**2, -(1.0 + link.restitution) / h]
                    tendon.solimp_limit = IMPEDANCE


def alike_and_many(scene: Scene, pairs: Sequence[tuple[int, int]]) -> bool:
    """Whether more than `MANY_PAIRS` pairs touch in the same way and without friction.

    Pairs that are named one by one are tried one by one in every step.  Where all are alike, shapes can have the
    parameters and MuJoCo finds the pairs; those of friction (`solreffriction`) a shape cannot have.
    """
    contact = [effect for kind in (Restitution, Friction) if (effect := scene.effect(kind)) is not None]
    return len(pairs) > MANY_PAIRS and not any(e.between for e in contact) and not scene.friction(*pairs[0])


def _normal(scene: Scene, i: int, j: int, h: float) -> list[float]:
    """Stiffness and damping, negated, of a contact for the step h: see `adapters.mujoco`."""
    stiffness = CORRECTION / h**2 if Resting in scene.needs else 0.0
    return [-stiffness, -(1.0 + scene.restitution(i, j)) / h]


def _without_work(mj: ModuleType, draft: Draft) -> int:
    """Flags that switch off the stages of a step in which nothing happens in this scene; no answer changes by a bit."""
    bit, scene, links = mj.mjtDisableBit, draft.scene, {type(link) for link in draft.links}
    idle = {
        bit.mjDSBL_ACTUATION: True,
        bit.mjDSBL_CLAMPCTRL: True,
        bit.mjDSBL_SENSOR: True,
        bit.mjDSBL_FRICTIONLOSS: True,
        bit.mjDSBL_GRAVITY: not any(draft.gravity),
        bit.mjDSBL_SPRING: Spring not in links,
        bit.mjDSBL_DAMPER: Spring not in links and not draft.drags,
        bit.mjDSBL_CONTACT: not scene.touching,
        bit.mjDSBL_EQUALITY: Rod not in links,
        bit.mjDSBL_LIMIT: Tether not in links,
        bit.mjDSBL_CONSTRAINT: smooth(scene),
    }
    return sum(int(flag) for flag, off in idle.items() if off)


def smooth(scene: Scene) -> bool:
    """Whether nothing in the scene acts within one step: no contacts, rods or tethers."""
    return not scene.touching and scene.needs.isdisjoint({Rod, Tether})


def _frame(body: Body, turns: bool) -> Quat:
    """Orientation of the frame MuJoCo has for a body: the world's if the body slides without turning."""
    return np.array(body.orientation if turns or body.fixed else IDENTITY)


def tree(scene: Scene) -> dict[int, tuple[int, Hinge]]:
    """Child -> (parent, hinge) of the trees that the hinges form, grown from the fixed bodies first.

    Raises
    ------
    Refusal
        If hinges close a loop.
    """
    edges: dict[int, list[tuple[int, Hinge]]] = {}
    for hinge in scene.all(Hinge):
        a, b = scene.index(hinge.a), scene.index(hinge.b)
        edges.setdefault(a, []).append((b, hinge))
        edges.setdefault(b, []).append((a, hinge))
    found: dict[int, tuple[int, Hinge]] = {}
    reached: set[int] = set()
    for root in sorted(edges, key=lambda i: not scene.bodies[i].fixed):
        front = [] if root in reached else [root]
        reached.add(root)
        while front:
            parent = front.pop(0)
            for child, hinge in edges[parent]:
                if scene.bodies[child].fixed or found.get(parent, (None, None))[1] is hinge:
                    continue
                if child in reached:
                    raise Refusal(f"the hinges of {scene.names[child]!r} close a loop: MuJoCo's bodies form trees")
                reached.add(child)
                found[child] = parent, hinge
                front.append(child)
    return found


def _parents_first(scene: Scene, hinges: Mapping[int, tuple[int, Hinge]]) -> list[int]:
    order = [i for i in range(len(scene.bodies)) if i not in hinges]
    return order + list(hinges)  # a tree is grown from its root: parents stand before their children
