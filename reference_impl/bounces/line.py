"""Bodies that move along one line without loads: between neighbours there is nothing but a gap that closes steadily.

Spheres in a row, and walls at its ends.  All gaps are carried on from event to event by the time between,
which is known to its own rounding however small it is: nothing is subtracted from the time since the start.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from reference_impl.bounces.loop import DONE, FULL, MEETING, PAUSED
from reference_impl.bounces.meetings import ROUNDING
from reference_impl.kernels import inlined, kernel
from reference_impl.state import PLANE
from reference_impl.world import STILL

if TYPE_CHECKING:
    from reference_impl.world import World

LONGEST = 500  # bodies in a line; of longer ones the general loop, whose cost does not grow with n, is faster

# columns of `row`, one for each body in the order of the line
PLACE, PACE, MASS, SIZE = 0, 1, 2, 3  # coordinate, velocity, inverse mass, radius
ROW = 4
# columns of `clock`
TIME, REST, NEED, CLOSE, PARTING, DEEP, GAIN, LOST = range(8)  # time reached in two parts; see `flock`
CLOCK = 8


@dataclass
class Line:
    """Bodies in a line, in its order.

    Attributes
    ----------
    who : (n,) array of int
        Their numbers in the scene.
    axis : int
        Coordinate axis they move along.
    across : (3,) array
        A point of the line [m].
    row, gaps : arrays
        As `bounce_in_line` takes them.
    """

    who: np.ndarray
    axis: int
    across: np.ndarray
    row: np.ndarray
    gaps: np.ndarray

    @property
    def coarse(self) -> float:
        """What the rounding of the coordinates makes of a gap [m]."""
        return float(ROUNDING * (np.abs(self.row[:, PLACE]) + self.row[:, SIZE]).max() * 2.0)


def line_of(world: World, rough: bool) -> Line | None:
    """The bodies of the world as a line, if that is what they are: no loads, and all motion along one axis."""
    m, b = world.motion, world.bodies
    if b.acceleration.any() or (world.mode == STILL).any():
        return None
    world.arrive()
    spheres = b.shape != PLANE
    free = np.flatnonzero(spheres)
    if not 0 < len(free) <= LONGEST:
        return None
    if rough and m.L.any():  # spin would push them off the line
        return None
    moves = np.flatnonzero(m.v[free].any(axis=0))
    others = np.flatnonzero(~(m.x[free] == m.x[free[0]]).all(axis=0))
    axes = np.union1d(moves, others)
    if len(axes) != 1:
        return None
    axis = int(axes[0])
    normal = b.normal[~spheres]
    along = np.abs(normal[:, axis]) == 1.0
    if not (along | (normal[:, axis] == 0.0)).all():
        return None
    walls = np.flatnonzero(~spheres)[along]
    facing = b.normal[walls, axis]
    low, high = walls[facing > 0.0], walls[facing < 0.0]
    ends = [
        low[[np.argmax(m.x[low, axis])]] if len(low) else low,
        high[[np.argmin(m.x[high, axis])]] if len(high) else high,
    ]
    who = np.concatenate([ends[0], free[np.argsort(m.x[free, axis], kind="stable")], ends[1]])
    row = np.column_stack([m.x[who, axis], m.v[who, axis], b.inverse_mass[who], b.radius[who]])
    gaps = np.diff(row[:, PLACE]) - (row[1:, SIZE] + row[:-1, SIZE])
    gaps[row[1:, MASS] + row[:-1, MASS] == 0.0] = np.inf  # fixed bodies do not meet
    return Line(who, axis, m.x[free[0]].copy(), row, gaps)


@inlined
def _carry(row, gaps, dt):
    for k in range(len(gaps)):
        gaps[k] -= (row[k, PACE] - row[k + 1, PACE]) * dt
    for k in range(len(row)):
        row[k, PLACE] += row[k, PACE] * dt


@kernel
def bounce_in_line(row, gaps, e, who, axis, across, ends, numbers, clock, counts, limit, events, turns):
    """Carry bodies on to `limit` [s], or to a meeting that is not an isolated bounce.

    Parameters
    ----------
    row : (n, ROW) array
        Bodies in the order of the line.
    gaps, e : (n - 1,) arrays
        Between neighbours [m], and their coefficients of restitution.
    who : (n,) array of int
        Number of each body in the scene.
    axis, across : int, (3,) array
        Axis of the line, and a point on it.
    ends, numbers : arrays
        Record of impulses, as in `record.Record`; without room (no rows at all) nothing is recorded.
    clock, counts : arrays
        `clock`: time reached in two parts; slower approach is none; gaps below are none; slower parting is none;
        deepest overlap; largest gain of energy; momentum lost, see `lost`.  `counts`: events, rows recorded, place
        of the meeting.
    events, turns : int
        Budgets.
    """
    n = len(row)
    time, rest, need, close, parting = clock[TIME], clock[REST], clock[NEED], clock[CLOSE], clock[PARTING]
    deep, gain = clock[DEEP], clock[GAIN]
    done, recorded = counts[0], counts[1]
    end = PAUSED
    answer = np.empty(n - 1)  # impulse per speed of approach: one division less in every turn
    for k in range(n - 1):
        answer[k] = (1.0 + e[k]) / (row[k, MASS] + row[k + 1, MASS])
    exchanged, pace = np.zeros(n + 1), row[:, PACE].copy()  # across each gap since the start, and how fast all were
    for _ in range(turns):
        least, a = np.inf, 0
        for k in range(n - 1):
            closing = row[k, PACE] - row[k + 1, PACE]
            if closing > need and gaps[k] < closing * least:
                least, a = max(gaps[k], 0.0) / closing, k
        left = (limit - time) - rest
        if not least < left:  # a branch that is foreseen: what follows need not wait for the sum of the times
            _carry(row, gaps, left)
            time, rest, end = limit, 0.0, DONE
            break
        if done >= events:
            break
        dt = least
        _carry(row, gaps, dt)
        part = rest + dt
        total = time + part
        other = total - time  # the sum in two parts, without loss
        rest = (time - (total - other)) + (part - other)
        time = total
        b = a + 1
        closing = row[a, PACE] - row[b, PACE]
        counts[2] = a
        if (
            e[a] * closing <= parting
            or (a > 0 and gaps[a - 1] <= close and row[a - 1, PACE] - row[a, PACE] >= -need)
            or (b < n - 1 and gaps[b] <= close and row[b, PACE] - row[b + 1, PACE] >= -need)
        ):
            end = MEETING
            break
        if len(ends) > 0 and recorded == len(ends):
            end = FULL
            break
        p = answer[a] * closing
        if len(ends) > 0:
            _record(ends, numbers, recorded, who[a], who[b], time, p, row, a, b, axis, across)
            recorded += 1
        done += 1
        deep = min(deep, gaps[a])
        exchanged[b] += p
        row[a, PACE] -= p * row[a, MASS]
        row[b, PACE] += p * row[b, MASS]
        # the impulse times the mean relative velocity, which at e = 1 only rounding makes other than zero
        gain = max(gain, 0.5 * p * ((row[b, PACE] - row[a, PACE]) - closing))
    clock[TIME], clock[REST], clock[DEEP], clock[GAIN] = time, rest, deep, gain
    clock[LOST] = max(clock[LOST], lost(row, pace, exchanged))
    counts[0], counts[1] = done, recorded
    return end


@kernel
def lost(row, pace, exchanged):
    """How far the bodies are from having changed their momentum since they had `pace` by what they `exchanged`.

    Relative to what they had and exchanged; across the gap below body k it was exchanged[k].
    """
    off = there = 0.0
    for k in range(len(row)):
        there += exchanged[k]
        if row[k, MASS] > 0.0:
            gained = (row[k, PACE] - pace[k]) / row[k, MASS]
            off += abs(gained - (exchanged[k] - exchanged[k + 1]))
            there += abs(pace[k]) / row[k, MASS]
    return off / there if there > 0.0 else 0.0


@kernel
def _record(ends, numbers, at, one, other, time, p, row, a, b, axis, across):
    """Put an impulse on record: between spheres, the body with the lower number comes first."""
    first, second, mine, sign = one, other, a, -1.0
    if row[a, SIZE] == 0.0 or (row[b, SIZE] > 0.0 and other < one):
        first, second, mine, sign = other, one, b, 1.0
    ends[at, 0], ends[at, 1] = first, second
    numbers[at, 0], numbers[at, 7] = time, p
    for c in range(3):
        numbers[at, 1 + c], numbers[at, 4 + c] = across[c], 0.0
    numbers[at, 1 + axis] = row[mine, PLACE] - sign * row[mine, SIZE]
    numbers[at, 4 + axis] = sign
