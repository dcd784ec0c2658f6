"""Resting contact: forces that are just large enough.

At every lasting contact the normal force f and the acceleration of the gap obey

    0 <= f,    gap'' = A f + b >= 0,    f·gap'' = 0

(Baraff 1994), where b holds the accelerations without contact forces and what the turning of the
normals and the rotation of the bodies bring (`bias` in `collide.features`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from reference_impl.collide.detect import Contacts, Kinematics
from reference_impl.collide.features import all_kinematics, rows
from reference_impl.contact_problem import Kept, NoSolution, solve
from reference_impl.effects.free_motions import Rows, Space, space
from reference_impl.effects.joint import joint_rows
from reference_impl.effects.spring import pull
from reference_impl.kernels import apply, apply_transposed, cross, dot, kernel, matrix, spin, turned
from reference_impl.state import Bodies, Motion

if TYPE_CHECKING:
    from reference_impl.links import Links


STUCK = 1e-8  # part of a contact row that joints leave free, below which the contact is theirs
# singular value of rows of unit length below which what tells them apart is no direction to move in: normals of faces
# that lie on each other differ by their tilt (1e-9 where they touch) over the sine between edges, and masses that press
# on one that is lighter by the factor r by 1/√r
SAME = 1e-7
SWEEPS = 5  # of Newton's method on the gaps of joints; quadratic, from what one step leaves of them


class Pose(NamedTuple):
    """State of all n bodies, with what follows from it."""

    x: np.ndarray  # (n, 3) [m]
    rotation: np.ndarray  # (n, 3, 3)
    v: np.ndarray  # (n, 3) [m/s]
    w: np.ndarray  # (n, 3) [rad/s]
    L: np.ndarray  # (n, 3) [kg m2/s]

    @staticmethod
    def of(x: np.ndarray, q: np.ndarray, v: np.ndarray, momentum: np.ndarray, b: Bodies) -> Pose:
        """From positions, quaternions, velocities and angular momenta."""
        rotation, w = np.empty((len(x), 3, 3)), np.empty((len(x), 3))
        _poses(q, momentum, b.inverse_inertia, rotation, w)
        return Pose(x, rotation, v, w, momentum)

    @staticmethod
    def now(m: Motion, b: Bodies) -> Pose:
        """Of a motion as it stands."""
        return Pose.of(m.x, m.q, m.v, m.L, b)


class Problem(NamedTuple):
    """Contacts of an island in scaled coordinates, in which a motion is (√m v, Bᵀ Rᵀ L), B Bᵀ = I⁻¹.

    Where joints hold the bodies, G, `free` and `least` are those of the motions that the joints leave free.
    """

    k: Kinematics
    g: np.ndarray  # (m, 6 bodies) contact rows G = J M^-1/2
    free: np.ndarray  # (6 bodies,) scaled acceleration without contact forces
    least: np.ndarray  # (m,) value of G times acceleration at which gap'' is zero [m/s2]
    motion: np.ndarray  # (6 bodies,) scaled velocity
    space: Space | None = None  # what joints leave free; None: everything
    whole: np.ndarray | None = None  # (m, 6 bodies) contact rows before the joints took their part
    pulled: np.ndarray | None = None  # (6 bodies,) scaled acceleration without contact and joint forces

    def closing(self, standing: np.ndarray) -> np.ndarray:
        """Acceleration with which each gap would close if its contact did not push, -gap'' [m/s2].

        Contacts that are `standing` (m,) push for the others: what lies on a floor does not fall along with what is
        about to land on it.
        """
        free = self.least - self.g @ self.free
        if not standing.any() or standing.all():
            return free
        try:
            borne = solve(self.g[standing], self.free, self.least[standing]).x
        except NoSolution:  # they will be refused as forces; here nothing but an estimate is lost
            return free
        return np.where(standing, free, self.least - self.g @ borne)

    def stuck(self) -> np.ndarray:
        """Which contacts (m,) the joints hold already: no motion they leave free opens or closes them."""
        if self.whole is None:
            return np.zeros(len(self.g), dtype=bool)
        return (self.g**2).sum(axis=1) <= STUCK**2 * (self.whole**2).sum(axis=1)

    def confined(self, rows: Rows) -> Problem:
        """The same contacts where joints with these rows hold the bodies."""
        s = space(rows.j, rows.target)
        return self._replace(
            g=s.within(self.g) if len(self.g) else self.g,
            free=s.given + s.within(self.free),
            least=self.least - self.g @ s.given,
            space=s,
            whole=self.g,
            pulled=self.free,
        )


class Push(NamedTuple):
    """Contact forces of one island and the accelerations under them."""

    force: np.ndarray  # (m,) [N]
    acceleration: np.ndarray  # (bodies, 3) [m/s2]
    torque: np.ndarray  # (bodies, 3) rate of the angular momentum [N m]
    residual: float
    kept: Kept | None = None  # for the same contacts a moment later


@dataclass(frozen=True)
class Island:
    """Contacts that act on each other through moving bodies.

    Attributes
    ----------
    bodies : (k,) array of int
        The moving bodies, in scene order.
    contacts : Contacts
    place : (n,) array of int
        Number of each body of the scene among `bodies`, or -1.
    links : Links or None
        Joints and springs of these bodies; None: there are none.
    """

    bodies: np.ndarray
    contacts: Contacts
    place: np.ndarray
    links: Links | None = None

    @staticmethod
    def of(contacts: Contacts, b: Bodies, links: Links | None = None) -> Island:
        """All of these contacts and links together."""
        ends = np.unique(contacts.kinds[:, :2])
        if links is not None:
            ends = np.union1d(ends, links.ends)
        bodies = ends[b.inverse_mass[ends] > 0.0]
        place = np.full(len(b.inverse_mass), -1)
        place[bodies] = np.arange(len(bodies))
        return Island(bodies, contacts, place, links)

    def part(self, which: np.ndarray) -> Island:
        """The same bodies with some of the contacts."""
        return replace(self, contacts=self.contacts.chosen(which))

    def carriers(self, b: Bodies) -> list[int]:
        """The fixed bodies that contacts and links of this island end on, in scene order."""
        ends = np.unique(self.contacts.kinds[:, :2])
        if self.links is not None:
            ends = np.union1d(ends, self.links.ends)
        return ends[b.inverse_mass[ends] == 0.0].tolist()

    @property
    def jointed(self) -> bool:
        """Whether joints hold some of the bodies."""
        return self.links is not None and len(self.links.joints.kinds) > 0

    def rows(self, pose: Pose, b: Bodies) -> Rows:
        """The rows of the joints."""
        assert self.links is not None
        joints = self.links.joints
        count = len(joints.kinds)
        rows = Rows(np.empty((count, 6 * len(self.bodies))), np.empty(count), np.empty(count), np.empty(count))
        joint_rows(joints.kinds, joints.reals, pose.x, pose.rotation, pose.v, pose.w, b.root, b.inverse_mass,
                   b.acceleration, self.place, *rows)  # fmt: skip
        return rows

    def problem(self, pose: Pose, b: Bodies) -> Problem:
        """The contact problem of these contacts."""
        m, width = len(self.contacts.kinds), 6 * len(self.bodies)
        k = Kinematics(np.empty((m, 3)), np.empty((m, 3)), np.empty(m), np.empty(m), np.empty(m))
        p = Problem(k, np.empty((m, width)), np.empty(width), np.empty(m), np.empty(width))
        all_kinematics(self.contacts.kinds, self.contacts.reals, pose.x, pose.rotation, pose.v, pose.w, *k)
        rows(
            self.contacts.kinds,
            k.normal,
            k.point,
            pose.x,
            pose.rotation,
            b.root,
            b.inverse_mass,
            b.radius,
            self.place,
            p.g,
        )
        _scaled(self.bodies, pose.rotation, pose.v, pose.w, pose.L, b.inverse_mass, b.root, b.acceleration, b.drag,
                b.torque, b.lever, b.spin_drag, p.motion, p.free)  # fmt: skip
        _least(self.contacts.kinds, k.normal, k.bias, b.inverse_mass, b.acceleration, p.least)
        if self.links is not None and len(self.links.springs.ends):
            pull(*self.links.springs, pose.x, pose.rotation, pose.v, pose.w, b.root, b.inverse_mass, self.place, p.free)
        return p.confined(self.rows(pose, b)) if self.jointed else p

    def change(self, motion: Motion, b: Bodies, pose: Pose, scaled: np.ndarray) -> None:
        """Add a scaled velocity to the bodies."""
        for at, i in enumerate(self.bodies.tolist()):
            y = scaled[6 * at : 6 * at + 6]
            motion.v[i] += y[:3] * math.sqrt(b.inverse_mass[i])
            motion.L[i] += pose.rotation[i] @ (b.inertia[i] @ (b.root[i] @ y[3:]))

    def shift(self, motion: Motion, b: Bodies, gap: np.ndarray) -> None:
        """Move the bodies, as little as possible in the metric of their masses, to these gaps [m]."""
        pose = Pose.now(motion, b)
        p = self.problem(pose, b)
        excess = p.k.gap - gap
        if excess.any():
            self.move(motion, b, pose, nearest(p.g, -excess))

    def hold(self, motion: Motion, b: Bodies) -> float:
        """Take out what integration and impulses have left of gaps and rates at the joints.

        Positions by Newton's method and velocities at once, both as little as possible in the metric of the masses.
        Returns the worst gap that remains, relative to the size of its joint.
        """
        if not self.jointed:
            return 0.0
        assert self.links is not None
        size, worst = self.links.joints.size, math.inf
        for _ in range(SWEEPS):
            pose = Pose.now(motion, b)
            rows = self.rows(pose, b)
            left = float(np.abs(rows.gap / size).max())
            if not left < 0.5 * worst:
                break
            worst = left
            self.move(motion, b, pose, space(rows.j, -rows.gap).given)
        self.change(motion, b, pose, space(rows.j, -rows.rate).given)
        return left

    def move(self, motion: Motion, b: Bodies, pose: Pose, y: np.ndarray) -> None:
        """Add a scaled displacement to the bodies."""
        for at, i in enumerate(self.bodies.tolist()):
            motion.x[i] += y[6 * at : 6 * at + 3] * math.sqrt(b.inverse_mass[i])
            if b.quickness[i] > 0.0:
                motion.q[i] = turned(motion.q[i], pose.rotation[i] @ (b.root[i] @ y[6 * at + 3 : 6 * at + 6]))


def nearest(g: np.ndarray, target: np.ndarray) -> np.ndarray:
    """The smallest y with G y = target; the best there is if the rows contradict each other, to within SAME."""
    length = np.sqrt(np.einsum("ij,ij->i", g, g))
    return np.linalg.lstsq(g / length[:, None], target / length, rcond=SAME)[0]


def rounding(b: Bodies, bodies: np.ndarray) -> float:
    """Relative rounding of accelerations under contact forces: eps times the ratio of the masses that press."""
    inverse = b.inverse_mass[bodies]
    return float(np.finfo(np.float64).eps * inverse.max() / inverse.min())


def islands(contacts: Contacts, b: Bodies, links: Links | None = None) -> list[Island]:
    """Contacts and links grouped so that no moving body is in two groups."""
    leader = list(range(len(b.inverse_mass)))

    def find(i: int) -> int:
        while leader[i] != i:
            leader[i] = leader[leader[i]]
            i = leader[i]
        return i

    ends = contacts.kinds[:, :2].tolist()
    tied = [] if links is None else links.ends.tolist()
    free = (b.inverse_mass > 0.0).tolist()
    for i, j in ends + tied:
        if free[i] and free[j]:
            leader[find(j)] = find(i)
    groups: dict[int, list[int]] = {}
    for k, (i, j) in enumerate(ends + tied):
        groups.setdefault(find(i if free[i] else j), []).append(k)
    out, count = [], len(ends)
    for members in groups.values():
        own = None
        if links is not None:
            which = np.zeros(len(tied), dtype=bool)
            which[[k - count for k in members if k >= count]] = True
            own = links.chosen(which)
        out.append(Island.of(contacts.chosen(np.array([k for k in members if k < count], dtype=np.int64)), b, own))
    return out


def push(
    island: Island,
    problem: Problem,
    pose: Pose,
    b: Bodies,
    solver: str,
    guess: np.ndarray | None = None,
    kept: Kept | None = None,
) -> Push:
    """Contact forces of an island and the motion they cause.

    Raises
    ------
    NoSolution
        If no forces keep the bodies apart.
    """
    if not len(problem.g):
        return Push(np.zeros(0), *accelerations(island, problem.free, pose, b), 0.0)
    answer = solve(problem.g, problem.free, problem.least, solver, guess, kept)
    return Push(answer.f, *accelerations(island, answer.x, pose, b), answer.residual, answer.kept)


def accelerations(island: Island, scaled: np.ndarray, pose: Pose, b: Bodies) -> tuple[np.ndarray, np.ndarray]:
    """Accelerations [m/s2] and rates of the angular momenta [N m], both (bodies, 3), of a scaled acceleration."""
    acceleration, torque = np.empty((len(island.bodies), 3)), np.empty((len(island.bodies), 3))
    _unscaled(island.bodies, scaled, pose.rotation, pose.w, pose.L, b.inverse_mass, b.inertia, b.root,
              acceleration, torque)  # fmt: skip
    return acceleration, torque


@kernel
def _poses(q, momentum, inverse_inertia, rotation, w):
    for i in range(len(q)):
        m = matrix(q[i])
        turn = spin(m, inverse_inertia[i], momentum[i])
        for c in range(3):
            w[i, c] = turn[c]
            for d in range(3):
                rotation[i, c, d] = m[c, d]


@kernel
def _scaled(
    members, rotation, v, w, momentum, inverse_mass, root, acceleration, drag, torque, lever, spin_drag, motion, free
):
    """Scaled velocity and scaled acceleration by the loads alone."""
    for at in range(len(members)):
        i = members[at]
        r = rotation[i]
        # what turns the body beyond steady rotation: load torque - ω × L
        t = cross(momentum[i], w[i])
        # torque of world forces F at body points p: the axial vector of R Σ p Fᵀ
        m = np.zeros((3, 3))
        for c in range(3):
            for d in range(3):
                for e in range(3):
                    m[c, d] += r[c, e] * lever[i, e, d]
        t[0] += torque[i, 0] + m[1, 2] - m[2, 1] - spin_drag[i] * w[i, 0]
        t[1] += torque[i, 1] + m[2, 0] - m[0, 2] - spin_drag[i] * w[i, 1]
        t[2] += torque[i, 2] + m[0, 1] - m[1, 0] - spin_drag[i] * w[i, 2]
        turn = apply_transposed(root[i], apply_transposed(r, t))
        angular = apply_transposed(root[i], apply_transposed(r, momentum[i]))
        heavy = math.sqrt(1.0 / inverse_mass[i])
        for c in range(3):
            motion[6 * at + c] = heavy * v[i, c]
            motion[6 * at + 3 + c] = angular[c]
            free[6 * at + c] = heavy * (acceleration[i, c] - drag[i] * v[i, c])
            free[6 * at + 3 + c] = turn[c]


@kernel
def _least(kinds, normal, bias, inverse_mass, acceleration, least):
    """Right-hand side of the acceleration problem: the velocities' part of gap'', and fixed bodies that accelerate."""
    for k in range(len(kinds)):
        a, b = kinds[k, 0], kinds[k, 1]
        least[k] = -bias[k]
        if inverse_mass[a] == 0.0:
            least[k] -= dot(normal[k], acceleration[a])
        if inverse_mass[b] == 0.0:
            least[k] += dot(normal[k], acceleration[b])


@kernel
def _unscaled(members, scaled, rotation, w, momentum, inverse_mass, inertia, root, acceleration, torque):
    """Accelerations and rates of angular momentum of a scaled acceleration.

    I B y is the body torque whose angular acceleration is R B y; L' = I α + ω × L adds the rest.
    """
    for at in range(len(members)):
        i = members[at]
        gyroscopic = cross(w[i], momentum[i])
        body = apply(rotation[i], apply(inertia[i], apply(root[i], scaled[6 * at + 3 : 6 * at + 6])))
        for c in range(3):
            acceleration[at, c] = scaled[6 * at + c] * math.sqrt(inverse_mass[i])
            torque[at, c] = body[c] + gyroscopic[c]
