"""The bodies of a world as the compiled loop sees them, kept from one call to the next."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from mechanics.effects import Drag, Force, Friction, Gravity, PairEffect, Resting, Restitution, Rotation
from reference_impl.bounces import loop, queue
from reference_impl.bounces.line import DEEP, GAIN, LOST, PACE, PLACE, TIME, Line, bounce_in_line, line_of
from reference_impl.collisions import LAST_ALONE
from reference_impl.errors import Stalled
from reference_impl.parts import Load
from reference_impl.settle import RETURN_ALONE
from reference_impl.state import PLANE, SPHERE
from reference_impl.world import STILL

if TYPE_CHECKING:
    from reference_impl.world import World

EFFECTS = {Gravity, Rotation, Drag, Force, Restitution, Friction, Resting}  # with others a bounce is not one formula
FEW = 24  # bodies up to which everyone looks at everyone, without cells
ROOMY = 0.7  # edge of a cell, in units of the room that a body has on average
LARGER = 2.0  # spheres by this factor larger than most others belong to no cell
FEWEST, CELLS = 4, 8  # cells along an edge of the grid (three in a row are not to be one), and for each body
TURNS = 500_000  # turns of the loop between two looks at the keyboard
CROSSINGS = 100  # turns allowed for each event that is allowed


def suits(world: World) -> bool:
    """Whether all that this scene's bodies can do in flight is to bounce as smooth or rough spheres.

    They are spheres on parabolas which turn steadily or not at all, among half-spaces and fixed spheres.
    """
    b, free = world.bodies, world.bodies.inverse_mass > 0.0
    return (
        world.parts.law.restitution is not None
        and world.settings.time_of_contact == "advancement"
        and world.settings.friction == "exact"
        and world.scene.needs <= EFFECTS
        and bool(((b.shape == SPHERE) | ((b.shape == PLANE) & ~free)).all())
        and not any(_more_than_pulls(load) for load in world.parts.loads)
        and bool((b.plain | (b.quickness == 0.0)).all())
    )


class Flock:
    """Spheres in flight.

    Parameters
    ----------
    world : World
        One that `suits`.
    """

    def __init__(self, world: World) -> None:
        b, n = world.bodies, len(world.mode)
        self.seen = -math.inf  # until when no two met without its knowing [s]
        self.time = math.nan  # up to which everything here is as in the world [s]
        self.fresh = np.ones(n, dtype=bool)  # bodies that were launched since
        self.real, self.whole = np.zeros((n, queue.REALS)), np.zeros((n, queue.WHOLES), dtype=np.int64)
        self.real[:, queue.RADIUS], self.real[:, queue.LIGHT] = b.radius, b.inverse_mass
        self.real[:, queue.TURN] = b.inverse_inertia[:, 0, 0]
        self.real[:, queue.NORMAL : queue.NORMAL + 3] = b.normal
        for column in (queue.HIT, queue.CROSS, queue.DUE):
            self.real[:, column] = math.inf
        self.whole[:, queue.WALL] = b.shape == PLANE
        self.whole[:, queue.PARTNER] = queue.NOBODY
        self.real[:, queue.FORESEEN] = world.foreseen
        world.foreseen = self.real[:, queue.FORESEEN]
        self._grid(world)
        self._tree(n)
        self._laws(world)
        s = world.search
        self.figures, self.counts = np.zeros(queue.FIGURES), np.zeros(queue.COUNTS, dtype=np.int64)
        self.figures[queue.CELL_SIZE], self.figures[queue.QUIET] = self.cell, s.speed
        self.figures[queue.TOLERANCE], self.figures[queue.PARTING] = s.tolerance, s.parting
        self.figures[queue.MOMENT] = RETURN_ALONE * world.scales.time
        self.figures[queue.LAST] = LAST_ALONE * world.scales.time
        self.figures[queue.SCALE] = world.scales.time
        self.near, self.also = np.empty(n, dtype=np.int64), np.empty(n, dtype=np.int64)
        self.desk, self.beside = np.empty((n + 1, 6)), np.empty((n + 1, 6))
        self.work, self.normal = np.empty((5, 6)), np.empty(3)
        rough = bool(self.friction.any())
        self.kernel = loop.bounces(rough or Rotation in world.scene.needs, rough)

    def _grid(self, world: World) -> None:
        """Cells as large as the largest sphere in them or the room a body has; the few much larger belong to none."""
        b, n = world.bodies, len(world.mode)
        spheres = np.flatnonzero(b.shape == SPHERE)
        outside = b.shape == PLANE
        if len(spheres) > FEW:
            sizes = np.sort(b.radius[spheres])
            usual = sizes[max(len(sizes) - 1 - int(math.sqrt(len(sizes))), 0)]
            outside = outside | (b.radius > LARGER * usual)
            inside = ~outside
            widest = 2.0 * float(b.radius[inside].max())
            extent = np.maximum(np.ptp(world.motion.x[inside], axis=0), widest)
            # rounding must not let two that touch be two cells apart
            self.cell = max(1.0001 * widest, ROOMY * float(np.prod(extent) / inside.sum()) ** (1.0 / 3.0))
            edges = 2 ** np.ceil(np.log2(np.maximum(extent / self.cell, FEWEST))).astype(np.int64)
            while edges.prod() > CELLS * n and edges.max() > FEWEST:
                edges[np.argmax(edges)] //= 2
        else:
            outside, self.cell, edges = np.ones(n, dtype=bool), 1.0, np.full(3, FEWEST)
        self.whole[:, queue.EVERYWHERE] = outside
        lasting = (b.shape == PLANE) & ~world.motion.v.any(axis=1) & ~b.acceleration.any(axis=1)
        self.walls = np.flatnonzero(lasting)[: queue.BITS]  # looked at only from cells that come near to them
        self.everywhere = np.setdiff1d(np.flatnonzero(outside), self.walls)
        self.head = np.full(tuple(edges.tolist()), queue.NOBODY)

    def _tree(self, n: int) -> None:
        leaves = 1 << max(1, (n - 1).bit_length())
        self.tree = np.full(2 * leaves, queue.NOBODY)
        self.tree[leaves : leaves + n] = np.arange(n)
        for node in range(leaves - 1, 0, -1):
            self.tree[node] = self.tree[2 * node]

    def _laws(self, world: World) -> None:
        """Coefficients as tables over groups of bodies: those that an exception names, and all others."""
        law, names = world.parts.law, world.scene.names
        effects = [effect for effect in (law.restitution, law.friction) if effect is not None]
        named = sorted({name for effect in effects for name in effect.names()})
        group = {name: 1 + k for k, name in enumerate(named)}
        self.whole[:, queue.GROUP] = [group.get(name, 0) for name in names]
        self.restitution, self.friction = _table(law.restitution, group), _table(law.friction, group)

    def _take(self, world: World) -> None:
        """Bodies that were launched outside, as the world has them."""
        m, real, which = world.motion, self.real, np.flatnonzero(self.fresh)
        series = m.x_series[which]
        real[which, queue.X : queue.X + 3], real[which, queue.V : queue.V + 3] = series[:, 0], series[:, 1]
        real[which, queue.A : queue.A + 3] = 2.0 * series[:, 2]
        real[which, queue.Q : queue.Q + 4], real[which, queue.L : queue.L + 3] = m.q_series[which, 0], m.L[which]
        real[which, queue.BEGIN], real[which, queue.BEGIN_REST] = m.begin[which], 0.0
        self.whole[which, queue.STILL] = world.mode[which] == STILL
        self.whole[which, queue.COUNT] += 1
        loop.refresh(real, self.whole, self.head, self.tree, self.everywhere, self.walls, self.near, self.desk,
                     self.work, which, self.figures, self.counts)  # fmt: skip
        self.fresh[:] = False

    def give(self, world: World) -> None:
        """Let the world know the segments of the bodies that have bounced."""
        m = world.motion
        loop.hand_over(self.real, self.whole, m.x_series, m.q_series, m.L, m.start, m.begin, world.energy)

    def run(self, world: World, limit: float, events: int) -> tuple[float, tuple[int, ...]]:
        """Carry the segments on until `limit` [s], or to a meeting that is not an isolated bounce.

        Parameters
        ----------
        events : int
            Budget.

        Returns
        -------
        time [s], the two bodies that meet then (none at the limit)

        Raises
        ------
        Stalled
            If bodies change cells for ever.
        """
        line = line_of(world, bool(self.friction.any()))
        if line is not None:
            return self._run_line(world, line, limit, events)
        f, audit, record = self.figures, world.audit, world.events
        if self.time != world.t:
            self.fresh[:] = True
        f[queue.NOW], f[queue.NOW_REST], f[queue.DEEPEST], f[queue.RISE] = world.t, 0.0, audit.gap, audit.energy_rise
        f[queue.IMBALANCE] = audit.imbalance
        self.counts[:] = 0
        if self.fresh.any():
            self._take(world)
        self.counts[queue.RECORDED] = len(record)
        end, turns = loop.PAUSED, 0
        while end == loop.FULL or (end == loop.PAUSED and self.counts[queue.EVENTS] < events):
            if end == loop.FULL:
                record.grow()
            end = self.kernel(
                self.real, self.whole, self.head, self.tree, self.everywhere, self.walls, self.restitution,
                self.friction, self.near, self.also, self.desk, self.beside, self.work, self.normal, record.ends,
                record.numbers, f, self.counts, limit, events, TURNS,
            )  # fmt: skip
            turns += TURNS
            if turns > CROSSINGS * (world.settings.events + TURNS):
                raise Stalled("bodies in flight change cells for ever", float(f[queue.NOW]))
        self._report(world, *self.counts[:2].tolist(), *f[[queue.DEEPEST, queue.RISE, queue.IMBALANCE]].tolist())
        world.search.evaluations += int(self.counts[queue.SEARCHES])
        met = () if end != loop.MEETING else (int(self.counts[queue.FIRST]), int(self.counts[queue.SECOND]))
        self.time = self.seen = float(f[queue.NOW])
        return self.time, met

    def _run_line(self, world: World, line: Line, limit: float, events: int) -> tuple[float, tuple[int, ...]]:
        """`run` where all bodies are on one line."""
        audit, record, m = world.audit, world.events, world.motion
        group = self.whole[line.who, queue.GROUP]
        e, search = self.restitution[group[:-1], group[1:]], world.search
        clock = np.array([world.t, 0.0, search.speed, line.coarse, search.parting, audit.gap, audit.energy_rise,
                          audit.imbalance])  # fmt: skip
        counts, end = np.array([0, len(record), 0]), loop.PAUSED
        while end == loop.FULL or (end == loop.PAUSED and counts[0] < events):
            if end == loop.FULL:
                record.grow()
            end = bounce_in_line(
                line.row, line.gaps, e, line.who, line.axis, line.across, record.ends, record.numbers, clock, counts,
                limit, events, TURNS,
            )  # fmt: skip
        self._report(world, int(counts[0]), int(counts[1]), *clock[[DEEP, GAIN, LOST]].tolist())
        met = () if end != loop.MEETING else tuple(line.who[counts[2] : counts[2] + 2].tolist())
        if counts[0]:
            world.carry(float(clock[TIME]))
            m.x[line.who, line.axis], m.v[line.who, line.axis] = line.row[:, PLACE], line.row[:, PACE]
            world.energy[line.who] = math.nan  # they have exchanged it
            for i in line.who.tolist():
                world.launch(i)
            self.seen = world.t
        return float(clock[TIME]), met

    def _report(self, world: World, events: int, recorded: int, deepest: float, rise: float, imbalance: float) -> None:
        """What was done, on record and in the audit."""
        audit = world.audit
        world.events.filled(recorded)
        audit.events += events
        audit.impacts += events
        audit.gap, audit.imbalance = deepest, imbalance
        if events:
            audit.passes = max(audit.passes, 1)
        if not world.moving:
            audit.energy_rise = rise


def _more_than_pulls(load: Load) -> bool:
    """Whether a load does anything but accelerate."""
    return any(part is not None and part.any() for part in (load.torque, load.lever, load.drag, load.spin_drag))


def _table(effect: PairEffect | None, group: dict[str, int]) -> np.ndarray:
    """Coefficients (groups, groups) of an effect; zero where it is not declared."""
    out = np.full((len(group) + 1, len(group) + 1), 0.0 if effect is None else effect.coefficient)
    if effect is not None:
        for (a, b), value in effect.exceptions.items():
            out[group[a], group[b]] = out[group[b], group[a]] = value
    return out
