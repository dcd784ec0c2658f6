"""A MuJoCo model on its way, and how bodies are reached in it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from types import ModuleType
from typing import Any

import numpy as np

from adapters.engine import Clock
from adapters.pushes import Motion, Push
from mechanics.arrays import Vec3
from mechanics.rotation import rotate
from mechanics.scene import Scene


@dataclass
class World:
    """A compiled model with its data; `joints` and `bodies` are MuJoCo's numbers in scene order (-1: none).

    `hear` takes MuJoCo's warnings while the world moves, as `before` did when it was made.
    """

    scene: Scene
    model: Any
    data: Any
    clock: Clock
    turns: bool
    hinged: bool
    bodies: list[int]
    joints: list[int]
    before: Callable[[str], None] | None
    pushes: list[Push] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.hear = self.warnings.append  # one object: MuJoCo says which one listens


@dataclass(frozen=True)
class Hands:
    """How pushes and reading reach into a MuJoCo world."""

    mujoco: ModuleType
    world: World

    def refresh(self) -> None:
        """Bring MuJoCo's Cartesian data, which lag a step, up to qpos and qvel; only hinged bodies need them."""
        if self.world.hinged:
            self.mujoco.mj_kinematics(self.world.model, self.world.data)
            self.mujoco.mj_comPos(self.world.model, self.world.data)
            self.mujoco.mj_comVel(self.world.model, self.world.data)

    def motion(self, i: int) -> Motion:
        model, data, body = self.world.model, self.world.data, self.world.scene.bodies[i]
        if body.fixed:
            return Motion(*(np.array(c) for c in (body.position, body.orientation, body.velocity)), np.zeros(3))
        joint = self.world.joints[i]
        at, dof = model.jnt_qposadr[joint], model.jnt_dofadr[joint]
        if self.world.hinged:
            number, twist = self.world.bodies[i], np.zeros(6)
            self.mujoco.mj_objectVelocity(model, data, self.mujoco.mjtObj.mjOBJ_XBODY, number, twist, 0)
            return Motion(data.xpos[number].copy(), data.xquat[number].copy(), twist[3:], twist[:3])
        velocity = data.qvel[dof : dof + 3].copy()
        if not self.world.turns:
            return Motion(body.position + data.qpos[at : at + 3], np.array(body.orientation), velocity, np.zeros(3))
        q = data.qpos[at + 3 : at + 7].copy()
        return Motion(data.qpos[at : at + 3].copy(), q, velocity, rotate(q, data.qvel[dof + 3 : dof + 6]))

    def push(self, i: int, force: Vec3, torque: Vec3) -> None:
        self.world.data.xfrc_applied[self.world.bodies[i]] += np.concatenate([force, torque])
