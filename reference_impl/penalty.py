"""The penalty method: one ODE for everything, contact included, by Runge-Kutta steps of fixed length.

There are no events.  What is gained in simplicity is paid in overlap and in steps: see `effects.penalty`.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from mechanics.scene import Scene
from reference_impl.assemble import PENALTIES
from reference_impl.effects.penalty import GRAVITY, damping_ratios, push
from reference_impl.errors import Stalled
from reference_impl.fixed_step import Stepped, pull_of, runge_kutta4
from reference_impl.record import Held


@dataclass
class Audit:
    """What the penalty method knows of its own soundness."""

    evaluations: int = 0  # of the rate of the state
    gap: float = 0.0  # deepest overlap met [m], <= 0
    resolution: float = 0.0  # greatest frequency of a contact times the step [rad]; beyond 2.8 it is unstable


@dataclass
class PenaltyWorld(Stepped):
    """A scene whose contacts are springs and dampers."""

    omega: float = 0.0  # [rad/s]
    zeta: np.ndarray = field(default_factory=lambda: np.zeros((0, 0)))
    audit: Audit = field(default_factory=Audit)

    def rate(self, t: float, y: np.ndarray) -> np.ndarray:
        """Rate of the state y: loads, and the contacts as a load."""
        self.audit.evaluations += 1
        pose = self.pose(y)
        if not self.parts.law.touching:
            none = np.zeros_like(pose.x)
            return self.flow(y, pose, none, none)
        touch = self.overlaps.find(pose, 0.0)
        p = push(touch, pose, self.bodies, self.omega, self.zeta)
        self.audit.gap = min(self.audit.gap, float(touch.gap.min(initial=0.0)))
        self.audit.resolution = max(self.audit.resolution, p.fastest * self.dt)
        return self.flow(y, pose, p.force, p.torque)

    def move(self, end: float) -> None:
        """One step.

        Raises
        ------
        Stalled
            If the state is no longer finite: the step was too long for the stiffness.
        """
        with np.errstate(over="ignore", invalid="ignore"):
            y = runge_kutta4(self.rate, self.t, self.y, end - self.t)
        if not np.isfinite(y).all():
            ratio = self.audit.resolution
            raise Stalled(f"penalty forces blew up: a step is {ratio:.3g} of the contact's radian, beyond 2.8", self.t)
        self.y, self.t = y, end

    @property
    def forces(self) -> list[Held]:
        """Contacts that push now."""
        if not self.parts.law.touching:
            return []
        pose = self.pose(self.y)
        touch = self.overlaps.find(pose, 0.0)
        along = push(touch, pose, self.bodies, self.omega, self.zeta).along
        return [
            Held(a, b, tuple(point), tuple(normal), f)
            for (a, b), point, normal, f in zip(
                touch.ends.tolist(), touch.point.tolist(), touch.normal.tolist(), along.tolist(), strict=True
            )
            if f > 0.0
        ]


def begin(scene: Scene, dt: float, depth: float) -> PenaltyWorld:
    """World of a scene at t = 0.

    Parameters
    ----------
    dt : float
        Time step [s].
    depth : float
        How deep a body sinks in under its own weight [m].

    Raises
    ------
    Unsupported, Overlap
        As `fixed_step.Stepped.of`.
    """
    world = PenaltyWorld.of(scene, PENALTIES, dt)
    assert isinstance(world, PenaltyWorld)
    world.omega = ((pull_of(world.bodies) or GRAVITY) / depth) ** 0.5
    world.zeta = damping_ratios(scene, world.parts.law)
    return world
