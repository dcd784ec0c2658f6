"""What is checked on every run: energy, and momentum at impacts.

The audit never changes a motion; its figures travel with the result (`Audit`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

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
    Tether,
)  # fmt: skip
from reference_impl.kernels import cross, dot, kernel, matrix, norm, spin

if TYPE_CHECKING:
    from mechanics.scene import Scene
    from reference_impl.world import World

CHATTER = 500  # changes of a body's contacts within a time scale that are too many
AGAIN = 1e-6  # lasting contact that changes again within this time may chatter [time scale]

# effects whose work on a body follows from its position and attitude, or which only take energy
KNOWN_WORK: tuple[type[Effect], ...] = (
    Gravity, Rotation, Drag, Force, Restitution, Friction, Resting, Rod, Hinge, Tether,
)  # fmt: skip


class Incident(NamedTuple):
    """Something out of the ordinary, of which the result tells."""

    time: float  # [s]
    what: str  # "painleve", "chatter" or "stopped impact"
    bodies: tuple[str, ...]


@dataclass
class Audit:
    """What the engine knows of its own soundness; every number is a worst case or a count."""

    events: int = 0  # contacts handled
    impacts: int = 0  # impulses exchanged
    passes: int = 0  # most solves of one impact
    stopped: int = 0  # impacts that ran out of solves: what still approached then stopped dead
    steps: int = 0  # integration steps in lasting contact
    rejected: int = 0  # steps that were repeated shorter
    residual: float = 0.0  # certificate of the contact problems, relative
    friction_residual: float = 0.0  # of those with friction, at impacts
    gap: float = 0.0  # deepest overlap found at an event [m], <= 0
    drift: float = 0.0  # worst gap of a joint after a step, relative to its size
    energy_rise: float = 0.0  # of an impact or a return to rest [J]; only where no fixed body moves
    step_rise: float = 0.0  # the same between two of these, with the loads' energy [J]; where their work is known
    # momentum and angular momentum that an impact, or a stretch of them along a line, made or lost, relative to all
    # there is
    imbalance: float = 0.0
    rests: int = 0  # bodies brought to proven rest
    painleve: int = 0  # times that no contact forces existed and an impulse took their place
    chatter: int = 0  # times that bodies whose contacts came and went too often were stopped
    last_bounce: float = math.nan  # when the last accumulating bounce came to its end [s]

    def certified(self, residual: float) -> None:
        """Note the certificate of a contact problem."""
        self.residual = max(self.residual, residual)

    def certified_friction(self, residual: float) -> None:
        """Note the certificate of a contact problem with friction."""
        self.friction_residual = max(self.friction_residual, residual)


def knows_work(scene: Scene) -> bool:
    """Whether the work of everything that acts is known: no fixed body moves, no torque is applied."""
    if any(b.fixed and (any(b.velocity) or any(b.acceleration)) for b in scene.bodies):
        return False
    return all(
        isinstance(effect, KNOWN_WORK) and not (isinstance(effect, Force) and any(effect.torque))
        for effect in scene.effects
    )


def kinetic_energy(world: World) -> float:
    """Kinetic energy of all moving bodies [J]."""
    return float(_energies(world, np.flatnonzero(world.bodies.inverse_mass > 0.0))[:, 0].sum())


def arrival(world: World, cluster: np.ndarray) -> float:
    """Kinetic energy [J] of the bodies in `cluster` (boolean), whose contacts are about to be looked at.

    Bodies act on each other only within a cluster, so that since the last time only loads can have given it energy:
    what it gained beyond their work is noted.
    """
    members = np.flatnonzero(cluster)
    energies = _energies(world, members)
    if world.knows_work:
        rise = float((energies[:, 1] - world.energy[members]).sum())
        world.audit.step_rise = max(world.audit.step_rise, rise)  # NaN at the first time is no rise
    return float(energies[:, 0].sum())


def departure(world: World, cluster: np.ndarray, before: float) -> None:
    """Note what impacts and returns to rest have made of the kinetic energy `before` [J]."""
    members = np.flatnonzero(cluster)
    energies = _energies(world, members)
    if not world.moving:
        world.audit.energy_rise = max(world.audit.energy_rise, float(energies[:, 0].sum()) - before)
    world.energy[members] = energies[:, 1]


def watch(world: World, cluster: np.ndarray, lasted: np.ndarray) -> None:
    """Count what may be chatter of the bodies in `cluster`, of which those in `lasted` were in contact (boolean).

    That is passing from flight to lasting contact or back, and lasting contact that changes again at once.  Impacts
    are no chatter, however many: that is what elastic balls in a narrow gap do.
    """
    lasts = world.mode != 0
    again = lasts & (world.t - world.settled < AGAIN * world.scales.time)
    for i in np.flatnonzero(cluster & ((lasts != lasted) | again)).tolist():
        if world.t > world.since[i] + world.scales.time:
            world.since[i], world.changes[i] = world.t, 0
        world.changes[i] += 1
        if world.changes[i] == CHATTER:
            world.audit.chatter += 1
            world.report("chatter", i)
    world.settled[cluster] = world.t


def chatters(world: World, bodies: np.ndarray) -> bool:
    """Whether contacts of one of these bodies come and go too often to be followed.

    They are then settled without restitution, and what is back within a moment stays, until a time scale has passed.
    """
    if world.audit.chatter == 0:
        return False
    lately = world.t <= world.since[bodies] + world.scales.time
    return bool((lately & (world.changes[bodies] >= CHATTER)).any())


def _energies(world: World, members: np.ndarray) -> np.ndarray:
    """Kinetic energy of each body, and with that of the constant loads that act now, -m a·x - F·p (k, 2) [J]."""
    m, b, out = world.motion, world.bodies, np.empty((len(members), 2))
    _energy(members, m.x, m.q, m.v, m.L, b.inverse_mass, b.inverse_inertia, b.acceleration, b.lever, out)
    return out


def imbalance(
    world: World, members: np.ndarray, kinds: np.ndarray, point: np.ndarray, impulses: np.ndarray, v: np.ndarray,
    momentum: np.ndarray,
) -> float:  # fmt: skip
    """How far an impact is from keeping momentum and angular momentum, relative to what there is of both.

    Parameters
    ----------
    members : (k,) array of int
        The moving bodies that took part.
    kinds, point, impulses : arrays
        Bodies (m, 2 or more), points (m, 3) [m] and impulses on the first of both bodies (m, 3) [N s].
    v, momentum : (n, 3) arrays
        Velocities and angular momenta of all bodies before.  Joints have not taken their part yet.
    """
    m, b = world.motion, world.bodies
    turning = bool((b.quickness[members] > 0.0).all())
    return _imbalance(members, kinds, point, impulses, m.x, v, momentum, m.v, m.L, b.inverse_mass, turning)


@kernel
def _energy(members, x, q, v, momentum, inverse_mass, inverse_inertia, acceleration, lever, out):
    for at in range(len(members)):
        i = members[at]
        rotation = matrix(q[i])
        spinning = 0.5 * dot(spin(rotation, inverse_inertia[i], momentum[i]), momentum[i])
        out[at, 0] = 0.5 * dot(v[i], v[i]) / inverse_mass[i] + spinning
        out[at, 1] = out[at, 0] - dot(acceleration[i], x[i]) / inverse_mass[i]
        for r in range(3):
            for c in range(3):
                out[at, 1] -= rotation[r, c] * lever[i, c, r]


@kernel
def _imbalance(members, kinds, point, impulses, x, v0, momentum0, v1, momentum1, inverse_mass, turning):
    linear, angular = np.zeros(3), np.zeros(3)
    pushed, turned = 0.0, 0.0
    for i in members:
        step = (v1[i] - v0[i]) / inverse_mass[i]
        around = cross(x[i], step)
        linear += step
        angular += around + momentum1[i] - momentum0[i]
        pushed += norm(step) + norm(v0[i]) / inverse_mass[i]
        turned += norm(around) + norm(cross(x[i], v0[i])) / inverse_mass[i] + norm(momentum0[i])
    for k in range(len(kinds)):
        moment = cross(point[k], impulses[k])
        if inverse_mass[kinds[k, 0]] == 0.0:
            linear += impulses[k]
            angular += moment
        if inverse_mass[kinds[k, 1]] == 0.0:
            linear -= impulses[k]
            angular -= moment
        turned += norm(moment)
    worst = norm(linear) / pushed if pushed > 0.0 else 0.0
    if turning and turned > 0.0:
        worst = max(worst, norm(angular) / turned)
    return worst
