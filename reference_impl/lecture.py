"""The algorithm of the lecture notes, as a student would write it from them.

Baraff, Physically Based Modeling: Rigid Body Simulation, SIGGRAPH course notes (1997); sections are quoted.
In every step of fixed length

    ode           carry the state Y = (x, q, v, L) on by Runge-Kutta                          part I
    penetration?  look at the end of the step whether any bodies overlap                       7
    bisection     if so, halve the step until they are just in contact, and stop there         7
    collisions    contacts that approach get impulses, one contact at a time                   8
    resting       contacts that do not get forces f with 0 <= f, A f + b >= 0, f·(A f + b) = 0 9

State, shapes, impulse formula and quadratic program are the house's; the algorithm is the notes'.  It is
kept to be compared with `simulate`, and has the faults of its kind:

- a contact that comes and goes within a step is never seen;
- a contact is found when it overlaps by the tolerance, and late by that over its speed; what a step leaves of a gap
  stays there;
- contacts met at once get impulses in turn, so that a flat landing depends on the order of the corners;
- approach slower than a step of free fall does not bounce (the threshold between collision and rest);
- A squares the condition number: under a heavy lid OSQP's answer is none, and the certificate says so.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from mechanics.scene import Scene
from mechanics.shapes import Box, HalfSpace, Sphere
from reference_impl.assemble import LECTURE
from reference_impl.collide.detect import Contacts
from reference_impl.contact_problem import USABLE, residual
from reference_impl.contact_solvers import SquareProgram
from reference_impl.effects.impact import Collision, sequential
from reference_impl.effects.resting import Island, Problem, islands
from reference_impl.errors import MissingEffect, Stalled, Unsupported
from reference_impl.fixed_step import Stepped, pull_of, runge_kutta4, size_of
from reference_impl.kernels import cross, kernel
from reference_impl.record import Collided, Held

TOLERANCE = 1e-12  # overlap that counts as penetration [size of the smallest body]
TOUCH = 2e-6  # gap up to which bodies rest on each other [size of the smallest body]
FAR = 1e-3  # the same beside the rounding of coordinates, which bodies far from the origin have [distance]
QUIET = 1e-9  # slower approach is none [speed scale]
HALVINGS = 60  # of a step, then its length is at the end of double precision
CONTACTS = 1000  # times of contact in one step


@dataclass
class Audit:
    """What the lecture's algorithm knows of its own soundness."""

    evaluations: int = 0  # of the rate of the state
    halvings: int = 0  # integrations of part of a step, in search of a time of contact
    contacts: int = 0  # times of contact found
    impacts: int = 0  # impulses exchanged
    gap: float = 0.0  # deepest overlap at the end of a step [m], <= 0
    residual: float = 0.0  # certificate of the quadratic programs, relative


@dataclass
class LectureWorld(Stepped):
    """A scene on its way by the lecture's algorithm."""

    tolerance: float = 0.0  # [m]
    touch: float = 0.0  # [m]
    floor: float = 0.0  # slower approach is none [m/s]
    audit: Audit = field(default_factory=Audit)
    programs: dict[int, SquareProgram] = field(default_factory=dict)
    pushing: list[tuple[Island, Problem, np.ndarray]] = field(default_factory=list)

    def move(self, end: float) -> None:
        """Carry the world to time `end`, stopping at every contact found on the way.

        Raises
        ------
        MissingEffect
            If the motion needs an effect that is not declared.
        Stalled
            If contacts without end are found within the step, or OSQP has no answer.
        """
        for _ in range(CONTACTS):
            contacts = self.contacts()
            self.collide(contacts)
            resting = self.resting(contacts)
            known = self.penetrations(self.y)
            after = self.ode(resting, end)
            overlaps, met = self.penetrations(after), known.keys() | self.pressed()
            if not overlaps.keys() - met:
                self.y, self.t = after, end
                self.audit.gap = min(self.audit.gap, *overlaps.values(), 0.0)
                return
            self.bisect(resting, met, end, after)
            if self.t == end:
                return
        raise Stalled(f"{CONTACTS} times of contact in a step of {self.dt:.3g} s", self.t)

    # ode

    def ode(self, resting: list[Island], end: float) -> np.ndarray:
        """State at time `end` if nothing new touches until then."""
        return runge_kutta4(lambda t, y: self.dydt(resting, y), self.t, self.y, end - self.t)

    def dydt(self, resting: list[Island], y: np.ndarray) -> np.ndarray:
        """Rate of the state: loads, and the contact forces that hold the resting contacts."""
        self.audit.evaluations += 1
        pose = self.pose(y)
        force, torque = np.zeros_like(pose.x), np.zeros_like(pose.x)
        self.pushing = []
        for island in resting:
            problem = island.problem(pose, self.bodies)
            f = self.contact_forces(problem)
            self.require_resting(island, f)
            self.pushing.append((island, problem, f))
            _press(island.contacts.kinds, problem.k.normal, problem.k.point, f, pose.x, force, torque)
        return self.flow(y, pose, force, torque)

    # time of contact

    def contacts(self) -> Contacts:
        """The features that overlap now, or are so close that bodies rest on them."""
        kinds, reals = self.overlaps.features(self.pose(self.y), self.touch)
        return Contacts(kinds, reals, np.zeros(len(kinds), dtype=np.int64))

    def penetrations(self, y: np.ndarray) -> dict[tuple[int, ...], float]:
        """Features that overlap by more than the tolerance in state y, with their gaps [m]."""
        pose = self.pose(y)
        kinds, reals = self.overlaps.features(pose, -self.tolerance)
        if len(kinds) == 0:
            return {}
        island = Island.of(Contacts(kinds, reals, np.zeros(len(kinds), dtype=np.int64)), self.bodies)
        gap = island.problem(pose, self.bodies).k.gap
        return {tuple(row): value for row, value in zip(kinds.tolist(), gap.tolist(), strict=True)}

    def pressed(self) -> set[tuple[int, ...]]:
        """Features that push at the end of the step: what a step changes of their gaps is no collision."""
        return {
            tuple(row)
            for island, _, f in self.pushing
            for row, push in zip(island.contacts.kinds.tolist(), f.tolist(), strict=True)
            if push > 0.0
        }

    def bisect(self, resting: list[Island], known: set[tuple[int, ...]], end: float, after: np.ndarray) -> None:
        """Go to the time at which a feature that is not `known` overlaps by the tolerance, and at most by twice that.

        `after` is the state at `end`, in which some do.  Every trial integrates anew from the start of the step.
        """
        low, high = self.t, end
        for _ in range(HALVINGS):
            deepest = min(gap for key, gap in self.penetrations(after).items() if key not in known)
            middle = 0.5 * (low + high)
            if deepest >= -2.0 * self.tolerance or middle in (low, high):
                break
            y = self.ode(resting, middle)
            self.audit.halvings += 1
            if self.penetrations(y).keys() - known:
                high, after = middle, y
            else:
                low = middle
        self.audit.contacts += 1
        self.y, self.t = after, high

    # collisions

    def collide(self, contacts: Contacts) -> None:
        """Exchange impulses at the contacts that approach, one at a time, until none does."""
        if len(contacts.kinds) == 0:
            return
        island = Island.of(contacts, self.bodies)
        pose = self.pose(self.y)
        problem = island.problem(pose, self.bodies)
        there = (problem.k.gap <= 2.0 * self.tolerance) | (problem.k.rate >= -self.threshold)
        if not there.all():  # what is still on its way collides when it arrives
            contacts = contacts.chosen(there)
            island = Island.of(contacts, self.bodies)
            problem = island.problem(pose, self.bodies)
        if problem.k.rate.min(initial=0.0) >= -self.floor:
            return
        law, ends = self.parts.law, contacts.kinds[:, :2].tolist()
        names = [(self.scene.names[a], self.scene.names[b]) for a, b in ends]
        worst = int(np.argmin(problem.k.rate))
        if law.restitution is None and problem.k.rate[worst] < -self.threshold:
            why = f"bodies collide at {-problem.k.rate[worst]:.6g} m/s"
            raise MissingEffect("Restitution", names[worst], self.t, why)
        e = np.array([law.restitution.of(*pair) if law.restitution else 0.0 for pair in names])
        drift = problem.k.rate - problem.g @ problem.motion
        outcome = sequential(
            Collision(problem.g, problem.motion, drift, lambda u: np.where(u < -self.threshold, e, 0.0), self.floor)
        )
        for (a, b), n, p, j in zip(ends, problem.k.normal, problem.k.point, outcome.impulses.tolist(), strict=True):
            if j == 0.0:
                continue
            for i, impulse in ((a, j * n), (b, -j * n)):
                self.y[i, 7:10] += self.bodies.inverse_mass[i] * impulse
                if self.bodies.quickness[i] > 0.0:
                    self.y[i, 10:13] += np.cross(p - pose.x[i], impulse)
            self.audit.impacts += 1
            self.events.append(Collided(self.t, a, b, tuple(p.tolist()), tuple(n.tolist()), j))

    @property
    def threshold(self) -> float:
        """Slower contacts rest [m/s]: what a step of free fall adds."""
        return max(pull_of(self.bodies) * self.dt, self.floor)

    # resting contact

    def resting(self, contacts: Contacts) -> list[Island]:
        """The contacts that neither collide nor separate, in groups that do not act on each other."""
        if len(contacts.kinds) == 0:
            return []
        problem = Island.of(contacts, self.bodies).problem(self.pose(self.y), self.bodies)
        slow = np.abs(problem.k.rate) <= self.threshold
        return islands(contacts.chosen(slow), self.bodies) if slow.any() else []

    def contact_forces(self, problem: Problem) -> np.ndarray:
        """Forces f of the quadratic program A f + b [N], as OSQP finds them.

        A f + b are the accelerations of the gaps: A = G Gᵀ, and b = G a - least holds what the loads and the
        velocities bring.  Rows are brought to unit length, which scales f and gaps alike.

        Raises
        ------
        Stalled
            If OSQP returns none, or one whose certificate is not usable.
        """
        length = np.sqrt(np.einsum("ij,ij->i", problem.g, problem.g))
        g, least = problem.g / length[:, None], problem.least / length
        m = len(least)
        if m not in self.programs:
            self.programs[m] = SquareProgram(m)
        f = self.programs[m].solve(g, problem.free, least)
        certificate = residual(g, problem.free, least, f) if np.isfinite(f).all() else np.inf
        if certificate > USABLE:
            raise Stalled(f"OSQP has no answer to A f + b of {len(f)} contacts (certificate {certificate:.3g})", self.t)
        self.audit.residual = max(self.audit.residual, certificate)
        return f / length

    def require_resting(self, island: Island, f: np.ndarray) -> None:
        """Raise MissingEffect if contact forces are needed and the scene declares no Resting."""
        if self.parts.law.resting:
            return
        b = self.bodies
        weight = max(float(np.linalg.norm(b.acceleration[i])) / b.inverse_mass[i] for i in island.bodies.tolist())
        if f.max() > 1e-9 * weight:
            a, b = island.contacts.kinds[int(np.argmax(f)), :2].tolist()
            raise MissingEffect("Resting", (self.scene.names[a], self.scene.names[b]), self.t, "bodies stay in contact")

    @property
    def forces(self) -> list[Held]:
        """Contacts that pushed when the rate of the state was last computed."""
        return [
            Held(a, b, tuple(p), tuple(n), push)
            for island, problem, f in self.pushing
            for (a, b), p, n, push in zip(
                island.contacts.kinds[:, :2].tolist(),
                problem.k.point.tolist(),
                problem.k.normal.tolist(),
                f.tolist(),
                strict=True,
            )
            if push > 0.0
        ]


@kernel
def _press(kinds, normal, point, f, x, force, torque):
    """Add the forces f along the normals of the contacts, and their torques, to the bodies a; against them to b."""
    for k in range(len(f)):
        for side in range(2):
            i = kinds[k, side]
            arm, push = np.empty(3), np.empty(3)
            for c in range(3):
                arm[c] = point[k, c] - x[i, c]
                push[c] = f[k] * normal[k, c] if side == 0 else -f[k] * normal[k, c]
                force[i, c] += push[c]
            turn = cross(arm, push)
            for c in range(3):
                torque[i, c] += turn[c]


def begin(scene: Scene, dt: float, tolerance: float = TOLERANCE) -> LectureWorld:
    """World of a scene at t = 0.

    Parameters
    ----------
    dt : float
        Time step [s].
    tolerance : float
        Overlap at which a contact is found, relative to the smallest body; bisection stops at once to twice that.

    Raises
    ------
    Unsupported, Overlap
        As `fixed_step.Stepped.of`; spheres, boxes and half-spaces touch here.
    ValueError
        If the tolerance is out of range.
    """
    if not 1e-13 <= tolerance <= 1e-2:
        raise ValueError(f"tolerance = {tolerance!r}; allowed: a number from 1e-13 to 1e-2")
    for body in (scene.bodies[i] for pair in scene.pairs() for i in pair):
        if not isinstance(body.shape, (Sphere, Box, HalfSpace)):
            kind = type(body.shape).__name__
            raise Unsupported(f"contact of body {body.name!r}, a {kind}: only Sphere, Box and HalfSpace touch")
    world = LectureWorld.of(scene, LECTURE, dt)
    assert isinstance(world, LectureWorld)
    size, start = size_of(world.bodies), scene.start()
    grain = max(size, FAR * float(np.abs(start.x).max()))
    world.tolerance, world.touch = tolerance * grain, max(TOUCH, 2.0 * tolerance) * grain
    fastest = float(np.linalg.norm(start.v, axis=1).max() + size * np.linalg.norm(start.w, axis=1).max())
    world.floor = QUIET * max(fastest, (pull_of(world.bodies) * size) ** 0.5)
    return world
