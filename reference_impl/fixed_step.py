"""Motion by Runge-Kutta steps of fixed length: what the penalty method and the lecture's algorithm stand on.

The state is y, one row (x, q, v, L) per body.  Between contacts its rate follows from the loads alone;
contact adds forces and torques.  Fixed bodies are carried along with the acceleration prescribed to them.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from mechanics.scene import Scene
from mechanics.trajectory import State
from reference_impl.assemble import Table, assemble
from reference_impl.collide.overlap import Overlaps
from reference_impl.effects.resting import Pose
from reference_impl.errors import Overlap
from reference_impl.kernels import kernel, spin_rate
from reference_impl.parts import Parts
from reference_impl.record import Collided, Held
from reference_impl.state import Bodies, bodies_of

START = 1e-9  # overlap at the start that is refused [smallest body size]

Rate = Callable[[float, np.ndarray], np.ndarray]


def runge_kutta4(rate: Rate, t: float, y: np.ndarray, h: float) -> np.ndarray:
    """State after one step of the classical Runge-Kutta method of order four; quaternions of unit length."""
    k1 = rate(t, y)
    k2 = rate(t + 0.5 * h, y + 0.5 * h * k1)
    k3 = rate(t + 0.5 * h, y + 0.5 * h * k2)
    k4 = rate(t + h, y + h * k3)
    new = y + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    new[:, 3:7] /= np.sqrt(np.einsum("ij,ij->i", new[:, 3:7], new[:, 3:7]))[:, None]
    return new


@dataclass
class Stepped(ABC):
    """A scene that moves on in steps of `dt` [s]; `move` carries it from its time to the end of a step.

    Attributes
    ----------
    scene : Scene
    parts : Parts
    bodies : Bodies
        With the loads that act now.
    overlaps : Overlaps
        Contact geometry.
    dt : float
    y : (n, 13) array
        Position, quaternion, velocity and angular momentum of each body, world frame, at time `t`.
    events : list of Collided
        Impulses exchanged so far.
    """

    scene: Scene
    parts: Parts
    unloaded: Bodies
    bodies: Bodies
    overlaps: Overlaps
    dt: float
    y: np.ndarray
    t: float = 0.0
    target: float = 0.0
    steps: int = 0
    events: list[Collided] = field(default_factory=list)

    @classmethod
    def of(cls, scene: Scene, table: Table, dt: float) -> Stepped:
        """World of a scene at t = 0.

        Raises
        ------
        Unsupported
            For an effect or a contact of shapes it has no part for.
        Overlap
            If bodies overlap at the start.
        """
        from reference_impl.state import motion_of

        parts = assemble(scene, table)
        unloaded = bodies_of(scene)
        m = motion_of(scene, unloaded)
        world = cls(scene, parts, unloaded, parts.loaded(unloaded, 0.0), Overlaps(scene, unloaded), dt,
                    np.concatenate([m.x, m.q, m.v, m.L], axis=1))  # fmt: skip
        world._refuse_overlap()
        return world

    @abstractmethod
    def move(self, end: float) -> None:
        """Carry the world to time `end` [s], at most one step away and without a load beginning or ending between."""

    def advance(self, duration: float) -> None:
        """Carry the world `duration` [s] on by whole steps, to the step nearest to the sum of all durations."""
        self.target += duration
        for _ in range(round(self.target / self.dt) - self.steps):
            self.steps += 1
            end = self.steps * self.dt
            for switch in self.parts.switches():
                if self.t < switch < end:
                    self._load()
                    self.move(switch)
            self._load()
            self.move(end)

    def pose(self, y: np.ndarray) -> Pose:
        """State y with rotation matrices and angular velocities."""
        x, q, v, momentum = (np.ascontiguousarray(y[:, a:b]) for a, b in ((0, 3), (3, 7), (7, 10), (10, 13)))
        return Pose.of(x, q, v, momentum, self.bodies)

    def flow(self, y: np.ndarray, pose: Pose, force: np.ndarray, torque: np.ndarray) -> np.ndarray:
        """Rate of y under the loads and the contact forces (n, 3) [N] and torques (n, 3) [N m]."""
        out, b = np.empty_like(y), self.bodies
        _flow(y, pose.rotation, pose.w, b.inverse_mass, b.quickness, b.acceleration, b.drag, b.torque, b.lever,
              b.spin_drag, force, torque, out)  # fmt: skip
        return out

    @property
    @abstractmethod
    def forces(self) -> list[Held]:
        """Contacts that push now."""

    def state(self) -> State:
        """State of all bodies now, in scene order."""
        pose = self.pose(self.y)
        return State(self.t, pose.x, self.y[:, 3:7].copy(), pose.v, pose.w)

    def _load(self) -> None:
        if self.parts.switches():
            self.bodies = self.parts.loaded(self.unloaded, self.t)

    def _refuse_overlap(self) -> None:
        touch = self.overlaps.find(self.pose(self.y), 0.0)
        if len(touch.gap):
            worst = int(np.argmin(touch.gap))
            if touch.gap[worst] < -START * size_of(self.bodies):
                a, b = touch.ends[worst].tolist()
                raise Overlap((self.scene.names[a], self.scene.names[b]), -float(touch.gap[worst]), 0.0)


def size_of(b: Bodies) -> float:
    """Radius of the smallest moving body [m]."""
    free = b.inverse_mass > 0.0
    return float(b.reach[free].min()) if free.any() else 1.0


def pull_of(b: Bodies) -> float:
    """Greatest acceleration by constant loads [m/s2]."""
    free = b.inverse_mass > 0.0
    return max((math.sqrt(float(a @ a)) for a in b.acceleration[free]), default=0.0)


@kernel
def _flow(
    y, rotation, w, inverse_mass, quickness, acceleration, drag, torque, lever, spin_drag, force, contact_torque, out
):
    for i in range(len(y)):
        turn = spin_rate(y[i, 3:7], w[i])
        for c in range(4):
            out[i, 3 + c] = turn[c]
        for c in range(3):
            out[i, c] = y[i, 7 + c]
            out[i, 7 + c] = acceleration[i, c] - drag[i] * y[i, 7 + c] + inverse_mass[i] * force[i, c]
            out[i, 10 + c] = 0.0
        if quickness[i] == 0.0:
            continue
        for c in range(3):
            out[i, 10 + c] = torque[i, c] + contact_torque[i, c] - spin_drag[i] * w[i, c]
        for c in range(3):  # forces F constant in the world at body points p: the axial vector of R Σ p Fᵀ
            d, e = (c + 1) % 3, (c + 2) % 3
            for k in range(3):
                out[i, 10 + c] += rotation[i, d, k] * lever[i, k, e] - rotation[i, e, k] * lever[i, k, d]
