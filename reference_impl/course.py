"""An island in lasting contact on its way: its state, its forces, and the step it is on.

Every island has a clock of its own.  It starts a step when its contacts have been looked at, and nothing that
happens elsewhere touches it; within the step its bodies are followed on polynomials of degree five.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from reference_impl.collocation import NUDGE, Collocation, table
from reference_impl.effects.resting import Island, Pose, Push, push, rounding
from reference_impl.effects.sliding import Grip, grip_of, reversing, rough_push, slip_of, stiffness
from reference_impl.integrators import RungeKutta8, hermite
from reference_impl.kernels import kernel, matrix, spin, spin_rate
from reference_impl.rough import limits
from reference_impl.segments import driven_momentum, where

if TYPE_CHECKING:
    from reference_impl.world import World

EVEN = 1e-15  # distance from its polynomials at which a motion is theirs [size of the coordinates; 1 for attitudes]
EVENLY = 1e-13  # the same for velocities and angular momenta, which their derivatives have with less digits
PROBE = 0.3  # where the two are compared, close to where their derivatives differ most [step]
SAFETY = 1.5  # on bounds of the accelerations within a step, which are sampled at its stages
SWING = 0.1  # part of the tolerance for bodies that swing, whose errors add up with nothing that takes them out again
HALVINGS = 5  # of a part of a step on which an implicit one is not found
SLOWED = 0.01  # part of the slip at the begin of a step at which it has almost stopped
STIFF = 3.0  # rate of friction times step from which on steps are implicit; explicit ones may not exceed 6
STRAIGHT = 1e-8  # turn of a slip that has not turned: half its square is lost of the friction at the stop
EPS = float(np.finfo(np.float64).eps)
WIDTH = 13  # numbers of one body in a state: position, quaternion, velocity, angular momentum


class Course:
    """The motion of one island under contact forces, from now on.

    Attributes
    ----------
    island : Island
    begin, end : float
        Of the step it is on [s]; `end` is -inf before the first one.
    y, new : (13 k,) arrays
        State (x, q, v, L) of its k bodies, one after the other, at the begin and the end of the step.
    stages : (s, 13 k) array
        Rates of the state within the step, the first at its begin and the last at its end.
    grip : Grip or None
        Which contacts slide; None where all are smooth.
    pairs : array of int
        Pairs of bodies within the island, and of one of them with a fixed body.
    gap : (m,) array
        Gaps to be kept [m].
    loaded : (m,) array of bool
        Which contacts push at the end of the step.
    cuts : int
        How often the step was cut short by something that met it.
    arrived : bool
        Whether the world has the state at its end.
    """

    def __init__(self, world: World, island: Island, p: Push) -> None:
        self.world, self.island, self.bodies = world, island, world.bodies
        m = world.motion
        self.begin, self.end = world.t, -math.inf
        self.members = island.bodies
        self.y = np.concatenate([m.x[self.members], m.q[self.members], m.v[self.members], m.L[self.members]], 1).ravel()
        self.new, self.stages = self.y, np.empty((WIDTH, 0))
        self.q = m.q.copy()
        self.pose = Pose.of(m.x.copy(), m.q, m.v.copy(), m.L.copy(), self.bodies)
        own = self.bodies.inverse_mass == 0.0
        own[self.members] = True
        pairs = world.detector.pairs
        self.pairs = np.flatnonzero(own[pairs].all(axis=1) & np.isin(pairs, self.members).any(axis=1))
        self.carriers = island.carriers(self.bodies) if world.moving else []
        self.push, self.kept = p, p.kept
        # states of the contacts at the last evaluation, the guess for the next
        self.states: np.ndarray | None = None
        self.friction: np.ndarray | None = None
        problem, mu = island.problem(self.pose, self.bodies), world.mu[island.contacts.pairs]
        self.gap, self.limits = problem.k.gap, limits(world)
        self.grip: Grip | None = None
        if not mu.any():
            self.states = p.force > 0.0
        else:
            self.grip = grip_of(island, problem, self.pose, self.bodies, mu, self.limits)
        self.method: RungeKutta8 | Collocation = RungeKutta8()
        self.loaded = np.zeros(len(self.gap), dtype=bool)
        self.cuts = 0
        self.arrived = False

    def place(self, t: float, y: np.ndarray) -> Pose:
        """Pose of all bodies with those of the island as y says and those that carry it as they are at time t."""
        m, rate, q = self.world.motion, np.empty(4), np.empty(4)
        for i in self.carriers:
            where(t - m.begin[i], m.x_series[i], m.q_series[i], self.pose.x[i], self.pose.v[i], q, rate)
        _place(self.members, y, self.bodies.inverse_inertia, self.q, *self.pose)
        return self.pose

    def __call__(self, t: float, y: np.ndarray) -> np.ndarray:
        """Rate of the state y at time t.

        Raises
        ------
        NoSolution
            If there are no contact forces.
        """
        pose, b, island = self.place(t, y), self.bodies, self.island
        problem = island.problem(pose, b)
        if self.grip is None:
            p = push(island, problem, pose, b, self.world.settings.solver, self.states, self.kept)
            self.states, self.kept = p.force > 0.0, p.kept
        else:
            p, self.friction, self.states = rough_push(
                island, problem, pose, b, self.grip, self.limits.slow, self.states
            )
        self.push = p
        self.world.audit.residual = max(self.world.audit.residual, p.residual)
        out = np.empty_like(y)
        _rates(self.members, self.q, pose.v, pose.w, p.acceleration, p.torque, out)
        return out

    def carried(self, t: float) -> tuple[np.ndarray, np.ndarray]:
        """State at time t of the step, by the motion itself and not by its polynomials, and the rates on the way."""
        return self._carried(self.begin, self.y, self.stages[0], t, HALVINGS)

    def tried(self, t: float) -> tuple[np.ndarray, np.ndarray] | None:
        """As `carried`, in one step; None if that is not found."""
        out = self._carried(self.begin, self.y, self.stages[0], t, 0)
        return out if self.method.converged else None

    def _carried(
        self, begin: float, y: np.ndarray, first: np.ndarray, t: float, halvings: int
    ) -> tuple[np.ndarray, np.ndarray]:
        new, stages = self.method.step(self, begin, y, t - begin, first)
        if self.method.converged or not halvings:
            return new, stages
        middle = 0.5 * (begin + t)
        half, one = self._carried(begin, y, first, middle, halvings - 1)
        new, two = self._carried(middle, half, one[-1], t, halvings - 1)
        return new, np.concatenate([one, two])

    def halved(self, end: float, new: np.ndarray, first: np.ndarray, scale: np.ndarray) -> float:
        """Distance of the state `new` at `end` from what two steps of half the length come to, over `scale`."""
        kept = self.states, self.friction, self.kept, self.push
        middle = 0.5 * (self.begin + end)
        half, stages = self._carried(self.begin, self.y, first, middle, 0)
        twice, _ = self._carried(middle, half, stages[-1], end, 0)
        self.states, self.friction, self.kept, self.push = kept
        return float((np.abs(new - twice) / scale).max())

    def choose(self, h: float, first: np.ndarray, force: np.ndarray) -> None:
        """Take the method that suits a step of h [s], from the rates `first` and the contact forces at its begin."""
        if self.grip is None:
            return
        self.method = RungeKutta8()
        grip, island, b = self.grip, self.island, self.bodies

        def slips(ahead: float) -> np.ndarray:
            return slip_of(island, self.place(self.begin + ahead, self.y + ahead * first), b)

        later, ahead = slips(float(table().nodes[0]) * h), slips(grip.lag)
        rate = stiffness(island, self.place(self.begin, self.y), b, grip, force, ahead)
        speed = np.sqrt((later**2).sum(axis=1))[(grip.slides | grip.creeps) & (grip.mu > 0.0)]
        slowest = float(speed.min(initial=math.inf))
        if h * rate > STIFF and slowest > 0.0:
            nudge = np.zeros((len(self.members), WIDTH))
            turns = b.quickness[self.members] > 0.0
            nudge[:, 7:10] = NUDGE * slowest
            moment = b.reach[self.members[turns]] * b.quickness[self.members[turns]]
            nudge[turns, 10:] = (NUDGE * slowest / moment)[:, None]
            self.method = Collocation(nudge.ravel(), self.scale())

    def slip(self, t: float, y: np.ndarray) -> float:
        """Least slip of the contacts that slide, along their direction at the start; negative past a reversal [m/s]."""
        if self.grip is None or not self.grip.slides.any():
            return math.inf
        pose = self.place(t, y)
        problem = self.island.problem(pose, self.bodies)
        return reversing(self.island, problem, pose, self.bodies, self.grip, self.push.force > 0.0)

    def turns(self, t: float, y: np.ndarray) -> bool:
        """Whether a contact slides another way than at the begin of the step, where it has almost stopped by time t."""
        assert self.grip is not None
        first = slip_of(self.island, self.place(self.begin, self.y), self.bodies)
        slip = slip_of(self.island, self.place(t, y), self.bodies)
        size = np.sqrt((slip**2).sum(axis=1))
        ends = self.grip.slides & (self.grip.mu > 0.0) & (size < SLOWED * np.sqrt((first**2).sum(axis=1)))
        aside = slip - (slip * self.grip.way).sum(axis=1)[:, None] * self.grip.way
        return bool((np.sqrt((aside**2).sum(axis=1)) > STRAIGHT * size)[ends & (size > self.limits.slow)].any())

    def units(self) -> np.ndarray:
        """What is large in each component of the state."""
        s, b = self.world.scales, self.bodies
        momentum = s.speed * s.length / b.inverse_mass[self.members]
        out = np.empty((len(self.members), WIDTH))
        out[:, :3], out[:, 3:7], out[:, 7:10], out[:, 10:] = s.length, 1.0, s.speed, momentum[:, None]
        return out.ravel()

    def scale(self) -> np.ndarray:
        """Error allowed in each component of the state."""
        b = self.bodies
        tolerance, least = self.world.settings.tolerance, 100.0 * rounding(b, self.members)
        if self.island.links is not None:
            tolerance *= SWING
            if not len(self.gap):  # forces of joints come from the factors alone: the root of the ratio
                least = 10.0 * math.sqrt(EPS * rounding(b, self.members))
        return max(tolerance, least) * self.units()

    def lay(self, end: float, new: np.ndarray, stages: np.ndarray) -> None:
        """Take this as the step, and give the bodies polynomials for it with bounds from its stages."""
        self.end, self.new, self.stages = end, new, stages
        self.loaded = self.push.force > 0.0
        self._even: bool | None = None
        m, b, h = self.world.motion, self.bodies, end - self.begin
        m.begin[self.members], m.end[self.members] = self.begin, end
        if h > 0.0:
            _lay(self.members, h, self.y, new, stages, b.inverse_inertia, m.x_series, m.q_series, m.bounds)
        changed = np.zeros(len(m.x), dtype=bool)
        changed[self.members] = True
        self.world.forget(changed)

    def deviation(self, t: float, y: np.ndarray) -> float:
        """Greatest distance of any point of a body from where its polynomials have it at time t [m]."""
        m, worst = self.world.motion, 0.0
        x, v, q, rate = np.empty(3), np.empty(3), np.empty(4), np.empty(4)
        for i, one in zip(self.members.tolist(), y.reshape(-1, WIDTH), strict=True):
            where(t - m.begin[i], m.x_series[i], m.q_series[i], x, v, q, rate)
            turn = np.abs(matrix(q) - matrix(one[3:7])).max() * self.bodies.reach[i]
            worst = max(worst, float(np.abs(x - one[:3]).max() + turn))
        return worst

    def look(self, t: float) -> None:
        """Set the world's motion of these bodies to what it is at time t of the step, which goes on undisturbed.

        To the polynomials where they are the motion to rounding, as under constant accelerations; else the motion
        itself is carried there.
        """
        kept = self.states, self.kept, self.push
        if self._even is None:
            self._even = self._follows(self.begin + PROBE * (self.end - self.begin))
        m = self.world.motion
        if not self._even:
            self.show(self.carried(t)[0])
            self.island.hold(m, self.bodies)
        else:
            _momenta(self.members, t, self.bodies.inertia, m.begin, m.x_series, m.q_series, m.L)
        self.states, self.kept, self.push = kept

    def _follows(self, t: float) -> bool:
        """Whether the motion at time t is that of the polynomials in all its parts.

        The attitude has a limit of its own: where coordinates are large their rounding is no measure for it, and a
        turn that is off by little is off by much more in its rate.
        """
        m, each = self.world.motion, self.carried(t)[0].reshape(-1, WIDTH)
        x, v, q, rate = (np.empty((len(each), width)) for width in (3, 3, 4, 4))
        momentum = m.L.copy()
        for at, i in enumerate(self.members.tolist()):
            where(t - m.begin[i], m.x_series[i], m.q_series[i], x[at], v[at], q[at], rate[at])
        _momenta(self.members, t, self.bodies.inertia, m.begin, m.x_series, m.q_series, momentum)
        size = np.abs(each[:, :3]).max() + self.bodies.reach[self.members].max()
        near = np.abs(x - each[:, :3]).max() <= EVEN * size
        turned = np.abs(q - each[:, 3:7] / np.sqrt((each[:, 3:7] ** 2).sum(axis=1))[:, None]).max() <= EVEN
        least = EVEN * self.units().reshape(-1, WIDTH)
        parts = ((v, slice(7, 10)), (momentum[self.members], slice(10, 13)))
        return bool(near and turned) and all(
            (np.abs(a - each[:, part]) <= EVENLY * np.abs(each[:, part]).max() + least[:, part]).all()
            for a, part in parts
        )

    def show(self, y: np.ndarray) -> None:
        """Set the world's motion of these bodies to the state y."""
        m, each = self.world.motion, y.reshape(-1, WIDTH)
        q = each[:, 3:7]
        m.x[self.members], m.v[self.members], m.L[self.members] = each[:, :3], each[:, 7:10], each[:, 10:]
        m.q[self.members] = q / np.sqrt((q * q).sum(axis=1))[:, None]


@kernel
def _place(members, y, inverse_inertia, q, x, rotation, v, w, momentum):
    for at in range(len(members)):
        i, k = members[at], 13 * at
        for c in range(3):
            x[i, c], v[i, c], momentum[i, c] = y[k + c], y[k + 7 + c], y[k + 10 + c]
        for c in range(4):
            q[i, c] = y[k + 3 + c]
        m = matrix(q[i])
        turn = spin(m, inverse_inertia[i], momentum[i])
        for c in range(3):
            w[i, c] = turn[c]
            for d in range(3):
                rotation[i, c, d] = m[c, d]


@kernel
def _rates(members, q, v, w, acceleration, torque, out):
    for at in range(len(members)):
        i, k = members[at], 13 * at
        turn = spin_rate(q[i], w[i])
        for c in range(3):
            out[k + c], out[k + 7 + c], out[k + 10 + c] = v[i, c], acceleration[at, c], torque[at, c]
        for c in range(4):
            out[k + 3 + c] = turn[c]


@kernel
def _momenta(members, t, inertia, begin, x_series, q_series, momentum):
    """Angular momenta at time t of polynomials."""
    for i in members:
        momentum[i] = driven_momentum(t - begin[i], inertia[i], x_series[i], q_series[i])


@kernel
def _bend(q, rate, momentum, torque, inverse_inertia, w, alpha):
    """Second derivative of a quaternion; writes angular velocity and acceleration."""
    rotation = matrix(q)
    turn = spin(rotation, inverse_inertia, momentum)
    net = np.empty(3)
    net[0] = torque[0] - (turn[1] * momentum[2] - turn[2] * momentum[1])
    net[1] = torque[1] - (turn[2] * momentum[0] - turn[0] * momentum[2])
    net[2] = torque[2] - (turn[0] * momentum[1] - turn[1] * momentum[0])
    bent = spin(rotation, inverse_inertia, net)
    for c in range(3):
        w[c], alpha[c] = turn[c], bent[c]
    return spin_rate(q, alpha) + spin_rate(rate, w)


@kernel
def _lay(members, h, y, new, stages, inverse_inertia, x_series, q_series, bounds):
    """Polynomials of degree five over a step, and bounds of the accelerations from its stages."""
    w, alpha, mean, count = np.empty((2, 3)), np.empty((2, 3)), np.empty(3), len(stages)
    for at in range(len(members)):
        i, k = members[at], 13 * at
        first, last = stages[0, k : k + 13], stages[count - 1, k : k + 13]
        p, e = y[k : k + 13], new[k : k + 13]
        bend = _bend(p[3:7], first[3:7], p[10:13], first[10:13], inverse_inertia[i], w[0], alpha[0])
        bent = _bend(e[3:7], last[3:7], e[10:13], last[10:13], inverse_inertia[i], w[1], alpha[1])
        hermite(h, p[:3], p[7:10], first[7:10], e[:3], e[7:10], last[7:10], x_series[i])
        hermite(h, p[3:7], first[3:7], bend, e[3:7], last[3:7], bent, q_series[i])
        for c in range(3):
            mean[c] = 0.0
            for s in range(count):
                mean[c] += stages[s, k + 7 + c] / count
            bounds[i, c] = mean[c]
        square, fastest, twist = 0.0, 0.0, 0.0
        for s in range(count):
            away = 0.0
            for c in range(3):
                away += (stages[s, k + 7 + c] - mean[c]) ** 2
            square = max(square, away)
        for side in range(2):
            fastest = max(fastest, math.sqrt(w[side, 0] ** 2 + w[side, 1] ** 2 + w[side, 2] ** 2))
            twist = max(twist, math.sqrt(alpha[side, 0] ** 2 + alpha[side, 1] ** 2 + alpha[side, 2] ** 2))
        bounds[i, 3] = SAFETY * math.sqrt(square)
        bounds[i, 4] = fastest + SAFETY * twist * h
        bounds[i, 5] = SAFETY * twist
