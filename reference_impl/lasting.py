"""Motion in lasting contact: accelerations under contact forces, carried on by Runge-Kutta steps.

A step ends early where a new feature touches, where a contact slides off the edge of its feature, or
where another body arrives.  Within the step the bodies are followed on polynomials of degree five.
"""

from __future__ import annotations

import math

import numpy as np

from reference_impl.collide.detect import Contacts, kinematics, rotations
from reference_impl.collide.features import margin
from reference_impl.contact_problem import NoSolution
from reference_impl.effects.resting import Island, Pose, Push, islands, push, rounding
from reference_impl.effects.sliding import Grip, grip_of, reversing, rough_push
from reference_impl.errors import Stalled
from reference_impl.integrators import RungeKutta8, hermite, where
from reference_impl.kernels import spin, spin_rate
from reference_impl.rough import jam, limits
from reference_impl.world import HELD, World

DEEP = 1e-11  # overlap that sends a step back [smallest body size]
SHORTEST = 1e-13  # step below which the motion is stuck [time scale]
LONGEST = 1.0  # [time scale]
BRINK = 1e-7  # time before forces cease to exist at which impulses take over [time scale]
STANDING = 1e-15  # slip at which a contact has stopped [speed scale]
SAFETY = 1.5  # on bounds of the accelerations within a step, which are sampled at its stages


class _Flow:
    """Rate of change of the held bodies' state y = (x, q, v, L) one body after the other."""

    def __init__(self, world: World) -> None:
        self.world = world
        self.groups: list[Island] = islands(world.contacts, world.bodies)
        self.bodies = sorted(i for group in self.groups for i in group.bodies.tolist())
        self.at = {i: 13 * k for k, i in enumerate(self.bodies)}
        self.active: list[np.ndarray | None] = [None] * len(self.groups)
        self.pushes: list[Push] = []
        pose = Pose.now(world.motion, world.bodies)
        self.gaps: list[np.ndarray] = []
        self.limits = limits(world)
        self.grips: list[Grip | None] = []
        for group in self.groups:
            problem, mu = group.problem(pose, world.bodies), world.mu[group.contacts.pairs]
            self.gaps.append(problem.k.gap)
            rough = mu.any()
            self.grips.append(grip_of(group, problem, pose, world.bodies, mu, self.limits) if rough else None)

    def pack(self) -> np.ndarray:
        m = self.world.motion
        return np.concatenate([np.concatenate([m.x[i], m.q[i], m.v[i], m.L[i]]) for i in self.bodies])

    def pose(self, t: float, y: np.ndarray) -> tuple[Pose, np.ndarray]:
        """All bodies at time t, the held ones as y says; and the quaternions."""
        m = self.world.motion
        x, q, v, momentum = m.x.copy(), m.q.copy(), m.v.copy(), m.L.copy()
        if self.world.moving:
            rate = np.empty(4)
            for i in np.flatnonzero(self.world.bodies.inverse_mass == 0.0):
                where(t - m.begin[i], m.x_series[i], m.q_series[i], x[i], v[i], q[i].copy(), rate)
        for i, at in self.at.items():
            x[i], q[i], v[i], momentum[i] = (
                y[at : at + 3],
                y[at + 3 : at + 7],
                y[at + 7 : at + 10],
                y[at + 10 : at + 13],
            )
        return Pose.of(x, q, v, momentum, self.world.bodies), q

    def __call__(self, t: float, y: np.ndarray) -> np.ndarray:
        world = self.world
        pose, q = self.pose(t, y)
        out = np.empty_like(y)
        self.pushes = []
        for number, group in enumerate(self.groups):
            problem = group.problem(pose, world.bodies)
            grip = self.grips[number]
            if grip is None:
                p = push(group, problem, pose, world.bodies, world.settings.solver, self.active[number])
                self.active[number] = p.force > 0.0
            else:
                p, _, self.active[number] = rough_push(
                    group, problem, pose, world.bodies, grip, self.limits.slow, self.active[number]
                )
            self.pushes.append(p)
            world.audit.residual = max(world.audit.residual, p.residual)
            for k, i in enumerate(group.bodies.tolist()):
                at = self.at[i]
                out[at : at + 3] = pose.v[i]
                out[at + 3 : at + 7] = spin_rate(q[i], pose.w[i])
                out[at + 7 : at + 10] = p.acceleration[k]
                out[at + 10 : at + 13] = p.torque[k]
        return out

    def slip(self, t: float, y: np.ndarray) -> float:
        """Least slip of the contacts that slide, along their direction at the start; negative past a reversal [m/s]."""
        least = math.inf
        pose, _ = self.pose(t, y)
        for group, grip, p in zip(self.groups, self.grips, self.pushes, strict=True):
            if grip is not None and grip.slides.any():
                problem = group.problem(pose, self.world.bodies)
                least = min(least, reversing(group, problem, pose, self.world.bodies, grip, p.force > 0.0))
        return least

    def scale(self) -> np.ndarray:
        """Error allowed in each component of y."""
        world = self.world
        s, b = world.scales, world.bodies
        out = np.empty(13 * len(self.bodies))
        for i, at in self.at.items():
            momentum = s.speed * s.length / b.inverse_mass[i]
            out[at : at + 13] = np.repeat([s.length, 1.0, s.speed, momentum], [3, 4, 3, 3])
        return max(world.settings.tolerance, 100.0 * rounding(b, np.array(self.bodies))) * out


def step(world: World, limit: float) -> None:
    """Carry all bodies on, at most to `limit` [s], while some are in lasting contact.

    Raises
    ------
    Stalled
        If no step is short enough, or the contacts allow no motion.
    """
    try:
        _step(world, limit)
    except NoSolution as error:
        raise Stalled(f"resting contact: {error}", world.t) from None


def _step(world: World, limit: float) -> None:
    flow, method, start = _Flow(world), RungeKutta8(), world.t
    scale = flow.scale()
    y = flow.pack()
    first = flow(start, y)
    rough = any(grip is not None for grip in flow.grips)
    h = min(world.step, LONGEST * world.scales.time)
    while True:
        if h < SHORTEST * world.scales.time:
            raise Stalled(f"lasting contact of {', '.join(world.names(*flow.bodies))}: step below {h:.3g} s", start)
        end = min(start + h, limit)
        try:
            new, stages = method.step(flow, start, y, end - start, first)
        except NoSolution:
            if not rough:
                raise
            world.audit.rejected += 1
            h = 0.25 * (end - start)
            if h < BRINK * world.scales.time:
                _jammed(world, flow)
                return
            continue
        error = method.error(stages, end - start, scale)
        if error > 1.0:
            world.audit.rejected += 1
            h = (end - start) * max(0.2, 0.9 * error**-0.125)
            continue
        _segments(world, flow, start, end, y, new, stages)
        stop, pair = _interrupted(world, flow, start, end)
        if stop < end:
            # the motion itself, not its polynomial, is carried to the interruption
            new, stages = method.step(flow, start, y, stop - start, first)
        if rough and flow.slip(stop, new) < 0.0:
            stop, new, pair = *_reversal(world, flow, method, y, start, stop, new, first), -1
        if _overlap(world, flow, stop, new) < -DEEP * world.scales.length:
            world.audit.rejected += 1
            h = 0.5 * (stop - start)
            continue
        break
    world.audit.steps += 1
    world.step = max(h if stop < end else end - start, 0.0) * (5.0 if error == 0.0 else min(5.0, 0.9 * error**-0.125))
    if end == limit and stop == end:
        world.step = max(world.step, h)
    _arrive(world, flow, stop, new)
    if pair >= 0:
        world.dirty[world.detector.pairs[pair]] = True
        world.clear[pair], world.hits[pair] = stop, False


def _reversal(
    world: World, flow: _Flow, method: RungeKutta8, y: np.ndarray, start: float, stop: float, new: np.ndarray,
    first: np.ndarray,
) -> tuple[float, np.ndarray]:  # fmt: skip
    """When the first contact ceases to slide, and the state then.

    The Illinois method on the slip of the motion itself, which is a straight line in time where friction is constant.
    """
    low, high = start, stop
    above, below = flow.slip(start, y), flow.slip(stop, new)
    side = 0
    for _ in range(80):
        t = (low * below - high * above) / (below - above)
        if not low < t < high:
            t = 0.5 * (low + high)
        if t in (low, high):
            break
        new, _ = method.step(flow, start, y, t - start, first)
        stop, value = t, flow.slip(t, new)
        if abs(value) <= STANDING * world.scales.speed:
            break
        if value > 0.0:
            low, above = t, value
            below = 0.5 * below if side == 1 else below
            side = 1
        else:
            high, below = t, value
            above = 0.5 * above if side == -1 else above
            side = -1
    return stop, new


def _jammed(world: World, flow: _Flow) -> None:
    """No contact forces exist a moment from now: impulses take their place."""
    for group, grip in zip(flow.groups, flow.grips, strict=True):
        if grip is not None:
            jam(world, group)
    world.dirty[flow.bodies] = True


def _segments(
    world: World, flow: _Flow, start: float, end: float, y: np.ndarray, new: np.ndarray, stages: np.ndarray
) -> None:
    """Give the held bodies polynomials for this step, with bounds from its stages."""
    m, b, h = world.motion, world.bodies, end - start
    held = np.zeros(len(world.mode), dtype=bool)
    for i, at in flow.at.items():
        held[i] = True
        ends = []
        for state, rate in ((y, stages[0]), (new, stages[12])):
            q, momentum = state[at + 3 : at + 7], state[at + 10 : at + 13]
            rotation = rotations(q[None])[0]
            w = spin(rotation, b.inverse_inertia[i], momentum)
            alpha = spin(rotation, b.inverse_inertia[i], rate[at + 10 : at + 13] - np.cross(w, momentum))
            bend = spin_rate(q, alpha) + spin_rate(rate[at + 3 : at + 7].copy(), w)
            ends.append((q, rate[at + 3 : at + 7], bend, w, alpha))
        (q0, dq0, ddq0, w0, alpha0), (q1, dq1, ddq1, w1, alpha1) = ends
        place, pace = slice(at, at + 3), slice(at + 7, at + 10)
        hermite(h, y[place], y[pace], stages[0, pace], new[place], new[pace], stages[12, pace], m.x_series[i])
        hermite(h, q0, dq0, ddq0, q1, dq1, ddq1, m.q_series[i])
        m.begin[i], m.end[i], m.start[i] = start, math.inf, m.L[i]
        pulls = stages[:, pace]
        mean = pulls.mean(axis=0)
        twist = SAFETY * max(np.linalg.norm(alpha0), np.linalg.norm(alpha1))
        m.bounds[i, :3] = mean
        m.bounds[i, 3] = SAFETY * float(np.sqrt(((pulls - mean) ** 2).sum(axis=1).max()))
        m.bounds[i, 4] = max(np.linalg.norm(w0), np.linalg.norm(w1)) + twist * h
        m.bounds[i, 5] = twist
    world.forget(held)


def _interrupted(world: World, flow: _Flow, start: float, end: float) -> tuple[float, int]:
    """Where the step must stop, and the pair that meets then (-1: none)."""
    stop, pair = world.first_hit(end)
    slide = _slides_off(world, start, stop)
    return (slide, -1) if slide < stop else (stop, pair)


def _margins(world: World, contacts: Contacts, t: float) -> float:
    """Least margin of the contacts at time t of the segments [m]."""
    m, b = world.motion, world.bodies
    x, v, q, rate = np.empty(3), np.empty(3), np.empty(4), np.empty(4)
    places = {}
    for i in set(contacts.kinds[:, :2].ravel().tolist()):
        where(t - m.begin[i], m.x_series[i], m.q_series[i], x, v, q, rate)
        places[i] = (x.copy(), rotations(q[None])[0])
    least = math.inf
    for kinds, reals in zip(contacts.kinds, contacts.reals, strict=True):
        i, j = kinds[:2].tolist()
        least = min(least, margin(kinds, reals, *places[i], *places[j], b.half[i], b.half[j]))
    return least


def _slides_off(world: World, start: float, end: float) -> float:
    """First time at which a contact has left its feature by a little more than the lateral tolerance, or `end`."""
    contacts = world.contacts
    bounded = world.bodies.half[contacts.kinds[:, 1], 0] > 0.0
    if not bounded.any():
        return end
    contacts = contacts.chosen(bounded)
    out = world.detector.lateral
    if _margins(world, contacts, end) >= -out:
        return end
    low, high = start, end
    for _ in range(100):
        middle = 0.5 * (low + high)
        least = _margins(world, contacts, middle)
        if -3.0 * out <= least < -out or middle in (low, high):
            return middle if least < -out else high
        if least < -out:
            high = middle
        else:
            low = middle
    return high


def _overlap(world: World, flow: _Flow, t: float, y: np.ndarray) -> float:
    """Deepest overlap of a held body with anything at time t [m], negative or zero."""
    pose, _ = flow.pose(t, y)
    dirty = np.zeros(len(world.mode), dtype=bool)
    dirty[flow.bodies] = True
    x, rotation = pose.x.copy(), pose.rotation.copy()
    m, rate = world.motion, np.empty(4)
    for i in np.flatnonzero(world.mode != HELD):
        q = np.empty(4)
        where(t - m.begin[i], m.x_series[i], m.q_series[i], x[i], np.empty(3), q, rate)
        rotation[i] = rotations(q[None])[0]
    found = world.detector.contacts(x, rotation, dirty)
    if len(found.kinds) == 0:
        return 0.0
    return min(0.0, float(kinematics(found, x, rotation, pose.v, pose.w).gap.min()))


def _arrive(world: World, flow: _Flow, t: float, y: np.ndarray) -> None:
    """Set the state of all bodies at the end of a step; held contacts keep their gap."""
    m = world.motion
    world.carry(t)
    for i, at in flow.at.items():
        m.x[i], m.v[i], m.L[i] = y[at : at + 3], y[at + 7 : at + 10], y[at + 10 : at + 13]
        q = y[at + 3 : at + 7]
        m.q[i] = q / math.sqrt(float(q @ q))
    _restore(world, flow)
    world.dirty[flow.bodies] = True


def _restore(world: World, flow: _Flow) -> None:
    """Take out what the integration changed of the gaps at the contacts that push.

    They keep the gap they had: to close it would push a neighbour that has just arrived into overlap.
    """
    for group, p, gap in zip(flow.groups, flow.pushes, flow.gaps, strict=True):
        loaded = p.force > 0.0
        if loaded.any():
            part = Island(group.bodies, group.contacts.chosen(loaded), group.place)
            part.shift(world.motion, world.bodies, gap[loaded])
