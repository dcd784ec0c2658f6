"""The world in motion: bodies, their segments, who touches whom, and the record of what happened."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from mechanics.effects import PairEffect
from mechanics.scene import Scene
from mechanics.trajectory import State
from reference_impl.audit import Audit, Incident, knows_work
from reference_impl.broad_phase import MANY, keep_apart
from reference_impl.collide.detect import Contacts, Detector, Search
from reference_impl.contact_problem import Kept
from reference_impl.errors import Stalled, Unsupported
from reference_impl.flight import driven_flight, fly_on, free_flight
from reference_impl.links import Links
from reference_impl.parts import Parts
from reference_impl.record import Held, Record
from reference_impl.segments import carry, driven_momentum, spins
from reference_impl.settings import Settings
from reference_impl.state import Bodies, Motion

if TYPE_CHECKING:
    from reference_impl.bounces.flock import Flock
    from reference_impl.course import Course

FLYING, HELD, STILL = 0, 1, 2  # free; under contact forces; at rest for good until something touches it
HORIZON = 10.0  # how far ahead a pair is searched for a contact at once [time scale, or what lies behind]


class Scales(NamedTuple):
    """What large means in this scene; every tolerance is a multiple of one of these."""

    length: float  # size of the smallest moving body, or what rounding of coordinates allows [m]
    speed: float  # of falling through that size, or of the fastest body at the start [m/s]
    time: float  # [s]


@dataclass
class World:
    """A scene on its way.  `reference_impl.simulate` makes it and moves it on."""

    scene: Scene
    settings: Settings
    parts: Parts
    bodies: Bodies  # with the loads that act now
    unloaded: Bodies
    motion: Motion
    scales: Scales
    detector: Detector
    search: Search
    links: Links | None  # joints and springs; None: there are none
    mode: np.ndarray = field(init=False)
    dirty: np.ndarray = field(init=False)  # bodies whose contacts must be looked at now
    clear: np.ndarray = field(init=False)  # (pairs,) until when each pair cannot touch [s]
    hits: np.ndarray = field(init=False)  # (pairs,) whether it does then
    seen: float = -math.inf  # until when `clear` and `hits` know what the flock has seen [s]
    behind: bool = False  # whether bodies in flight have not been brought to time t yet
    moving: bool = field(init=False)  # whether some fixed body moves
    knows_work: bool = field(init=False)  # see `audit.knows_work`
    energy: np.ndarray = field(init=False)  # (n,) when a body's contacts were last looked at [J]; NaN: not known
    rested: np.ndarray = field(init=False)  # bodies that came to proven rest at some time
    foreseen: np.ndarray = field(init=False)  # when each sphere will have bounced for the last time [s]
    changes: np.ndarray = field(init=False)  # how often each body has passed from flight to contact or back
    since: np.ndarray = field(init=False)  # since then [s]
    settled: np.ndarray = field(init=False)  # when the contacts of each body were last looked at [s]
    mu: np.ndarray = field(init=False)  # (pairs,) coefficients of friction
    courses: list[Course] = field(default_factory=list)  # of the islands in lasting contact
    kept: dict[bytes, Kept] = field(default_factory=dict)  # what courses that have just ended leave for the next
    lasts: np.ndarray = field(init=False)  # (pairs,) whether a contact of the pair is part of a course
    pace: np.ndarray = field(init=False)  # (n,) step proposed for each body in lasting contact [s]
    fair: np.ndarray = field(init=False)  # (n,) step that would have had just the error allowed, the last time [s]
    forces: list[Held] = field(default_factory=list)
    pushing: set[tuple[int, int, int, int]] = field(default_factory=set)
    events: Record = field(default_factory=Record)
    incidents: list[Incident] = field(default_factory=list)
    flock: Flock | None = None  # bodies as the loop of bounces sees them, in scenes that suit it
    audit: Audit = field(default_factory=Audit)

    def __post_init__(self) -> None:
        n = len(self.scene.bodies)
        self.mode = np.full(n, FLYING)
        self.dirty = np.ones(n, dtype=bool)
        self.clear = np.zeros(len(self.detector.pairs))
        self.hits = np.zeros(len(self.detector.pairs), dtype=bool)
        self.moving = any(b.fixed and (any(b.velocity) or any(b.acceleration)) for b in self.scene.bodies)
        self.rested = np.zeros(n, dtype=bool)
        self.knows_work = knows_work(self.scene)
        self.energy = np.full(n, math.nan)
        self.foreseen = np.full(n, math.nan)
        self.changes = np.zeros(n, dtype=np.int64)
        self.since = np.zeros(n)
        self.settled = np.full(n, -math.inf)
        self._refuse()
        self.pace = np.full(n, 1e-2 * self.scales.time)
        self.fair = np.full(n, math.inf)
        self.lasts = np.zeros(len(self.detector.pairs), dtype=bool)
        self.mu = np.zeros(len(self.detector.pairs))
        if self.parts.law.friction is not None:
            solid = self.detector.solid
            self.mu[:solid] = _coefficients(self.parts.law.friction, self.scene, self.detector.pairs[:solid])

    def report(self, what: str, *bodies: int) -> None:
        """Put something out of the ordinary on record."""
        self.incidents.append(Incident(self.t, what, self.names(*bodies)))

    def _refuse(self) -> None:
        """Raise `Unsupported` for a law that does not know what the scene calls for."""
        law = self.parts.law
        if self.settings.impact_law == "poisson" and law.friction is not None:
            raise Unsupported("impact_law = 'poisson' is a law of smooth impacts; the scene has Friction")
        if self.settings.impact_law == "reflections" and law.restitution and len(set(law.restitution.values())) > 1:
            raise Unsupported("impact_law = 'reflections' has one coefficient of restitution; the scene has several")

    @property
    def t(self) -> float:
        """Time reached [s]."""
        return self.motion.t

    def names(self, *bodies: int) -> tuple[str, ...]:
        """Names of bodies."""
        return tuple(self.scene.names[i] for i in bodies)

    def restitution(self, contacts: Contacts) -> np.ndarray:
        """Coefficient of restitution of each contact (m,); of a tether its own, zero where none is declared."""
        law, solid, e = self.parts.law.restitution, self.detector.solid, np.zeros(len(contacts.kinds))
        for row, (p, (a, b)) in enumerate(zip(contacts.pairs.tolist(), contacts.kinds[:, :2].tolist(), strict=True)):
            if p >= solid:
                e[row] = self.detector.cords.restitution[p - solid]
            elif law is not None:
                e[row] = law.of(*self.names(a, b))
        return e

    def linked(self, bodies: np.ndarray) -> Links | None:
        """Joints and springs of the moving bodies among `bodies` (boolean); None if there are none."""
        return None if self.links is None else self.links.within(bodies)

    def angular_velocities(self) -> np.ndarray:
        """World angular velocities (n, 3) [rad/s]."""
        self.arrive()
        w = np.empty((len(self.mode), 3))
        spins(self.motion.q, self.bodies.inverse_inertia, self.motion.L, w)
        return w

    def state(self) -> State:
        """State of all bodies now, in scene order."""
        self.arrive()
        m = self.motion
        return State(m.t, m.x.copy(), m.q.copy(), m.v.copy(), self.angular_velocities())

    def static(self, i: int) -> bool:
        """Whether body i does not move at all now."""
        if self.mode[i] == STILL:
            return True
        b = self.bodies
        return b.inverse_mass[i] == 0.0 and not self.motion.v[i].any() and not b.acceleration[i].any()

    def launch(self, i: int) -> None:
        """Let body i fly from now on."""
        m, b = self.motion, self.bodies
        m.begin[i], m.start[i] = m.t, m.L[i]
        acceleration = np.zeros(3) if self.mode[i] == STILL else b.acceleration[i]
        turning = b.quickness[i] > 0.0 and self.mode[i] != STILL and not b.plain[i]
        if turning and b.twisted[i]:
            span = driven_flight(
                m.x[i], m.v[i], m.q[i], m.L[i], acceleration, b.drag[i], b.inverse_inertia[i], b.quickness[i],
                b.torque[i], b.lever[i], b.spin_drag[i], m.x_series[i], m.q_series[i], m.bounds[i],
            )  # fmt: skip
        elif (turning and m.L[i].any()) or (b.drag[i] > 0.0 and self.mode[i] != STILL):
            span = free_flight(
                m.x[i], m.v[i], m.q[i], m.L[i], acceleration, b.drag[i], b.moments[i], b.frame[i], b.quickness[i],
                b.unevenness[i], turning, m.x_series[i], m.q_series[i], m.spin_series[i], m.kept[i], m.bounds[i],
            )  # fmt: skip
        else:
            span = math.inf
            m.x_series[i] = m.q_series[i] = m.bounds[i] = 0.0
            m.x_series[i, 0], m.x_series[i, 1], m.x_series[i, 2] = m.x[i], m.v[i], 0.5 * acceleration
            m.q_series[i, 0] = m.q[i]
            m.bounds[i, :3] = acceleration
        m.end[i] = m.t + span
        if self.flock is not None:
            self.flock.fresh[i] = True

    def forget(self, changed: np.ndarray) -> None:
        """Look anew for contacts of the bodies in `changed` (boolean), whose motion is another now."""
        if len(self.clear):
            touched = changed[self.detector.pairs].any(axis=1)
            self.clear[touched] = self.t
            self.hits[touched] = False

    @property
    def untouchable(self) -> bool:
        """Whether all bodies fly without torques and can touch nothing: they need not be looked at until asked for."""
        return not len(self.clear) and not self.courses and not self.bodies.twisted.any() and not self.mode.any()

    def wait(self, t: float) -> None:
        """Let the time be t; bodies in flight are brought there when someone looks."""
        self.motion.t, self.behind = t, True

    def arrive(self) -> None:
        """Bring bodies in flight to where they are by now."""
        if not self.behind:
            return
        if self.flock is not None:
            self.flock.give(self)
        self.carry(self.t)

    def recall(self) -> None:
        """Let all pairs be clear until now if the flock, which looks for contacts of its own, has seen to it."""
        if self.flock is not None and self.flock.seen > self.seen:
            self.clear[:], self.hits[:], self.seen = self.flock.seen, False, self.flock.seen

    def carry(self, t: float) -> None:
        """Bring the state of every body to time t of its segment."""
        if not len(self.clear):
            self.fly_on(t)
        m, b = self.motion, self.bodies
        carry(t, b.plain, b.inverse_inertia, m.x, m.v, m.q, m.L, m.begin, m.x_series, m.q_series)
        for i in np.flatnonzero(b.twisted):
            if self.mode[i] == FLYING:
                m.L[i] = driven_momentum(t - m.begin[i], b.inertia[i], m.x_series[i], m.q_series[i])
        m.t, self.behind = t, False

    def renew(self) -> None:
        """Continue the flights whose polynomials end now."""
        due = (self.motion.end <= self.t) & (self.mode == FLYING)
        if due.any():
            self.fly_on(self.t)
            for i in np.flatnonzero(due & self.bodies.twisted):
                self.launch(i)

    def fly_on(self, t: float) -> None:
        """Continue the flights without torques that end by t, each at its own time.

        Raises
        ------
        Stalled
            If a body turns so fast that its series last no time at all.
        """
        m, b = self.motion, self.bodies
        free = (self.mode == FLYING) & ~b.twisted
        if not (free & (m.end <= t)).any():
            return
        stuck = fly_on(t, free, m.x, m.v, m.q, m.L, b.acceleration, b.drag, b.moments, b.frame, m.begin, m.end,
                       m.start, m.x_series, m.q_series, m.spin_series, m.kept, m.bounds)  # fmt: skip
        if stuck >= 0:
            raise Stalled(f"flight of {self.names(stuck)}: too fast a turn", float(m.begin[stuck]))

    def horizon(self) -> float:
        """Until when no polynomial ends that all bodies must stop for [s].

        Where nothing can touch, flights without torques are continued each at its own time.
        """
        if len(self.clear):
            return float(self.motion.end.min())
        stops = (self.mode != FLYING) | self.bodies.twisted
        return float(self.motion.end[stops].min(initial=math.inf))

    def first_hit(self, limit: float) -> tuple[float, int]:
        """Time of the first contact before `limit` and its pair, or (limit, -1)."""
        spent = 0
        if len(self.clear) > MANY:
            self._keep_apart(limit)
        while len(self.clear):
            p = int(np.argmin(self.clear))
            if self.clear[p] >= limit:
                break
            if self.hits[p]:
                return float(self.clear[p]), p
            self.look(p)
            spent += 1
            if spent > 1000 + 50 * len(self.clear):
                raise Stalled(f"search for the next contact of {self.names(*self.detector.pairs[p])}", self.t)
        return limit, -1

    def _keep_apart(self, limit: float) -> None:
        """What the bounding spheres of the bodies tell of all pairs before `limit`, in one go."""
        m, b, fixed = self.motion, self.bodies, self.bodies.inverse_mass == 0.0
        static = (self.mode == STILL) | (fixed & ~m.v.any(axis=1) & ~b.acceleration.any(axis=1))
        n = self.detector.solid  # a tether is no matter of bounding spheres
        keep_apart(
            self.detector.pairs[:n], self.clear[:n], self.hits[:n], self.lasts[:n], static, b.shape, b.normal, b.reach,
            m.begin, m.end, m.x_series, m.bounds, limit, HORIZON * self.scales.time,
        )  # fmt: skip

    def look(self, p: int) -> None:
        """Search on for a contact of pair p."""
        a, b = self.detector.pairs[p].tolist()
        if self.static(a) and self.static(b):
            self.clear[p] = math.inf
            return
        # to an end that depends on these two bodies only, so that what others do does not change a bit of the answer
        m, clear = self.motion, float(self.clear[p])
        ahead = HORIZON * max(self.scales.time, clear - max(m.begin[a], m.begin[b]))
        end = float(min(m.end[a], m.end[b], clear + ahead))
        self.clear[p], self.hits[p] = self.detector.meet(p, clear, end, m, bool(self.lasts[p]))


def _coefficients(effect: PairEffect, scene: Scene, pairs: np.ndarray) -> np.ndarray:
    """Coefficients of the pairs (p, 2) of bodies."""
    n, out = len(scene.bodies), np.full(len(pairs), effect.coefficient)
    number = {name: i for i, name in enumerate(scene.names)}
    code = pairs.min(axis=1) * n + pairs.max(axis=1)  # increases, whatever the order within a pair
    for (a, b), value in effect.exceptions.items():
        i, j = sorted((number[a], number[b]))
        at = int(np.searchsorted(code, i * n + j))
        if at < len(code) and code[at] == i * n + j:
            out[at] = value
    return out
