"""What is due next, and who is near: a tournament of all bodies, and a grid of cells.

A body has one row of numbers (`real`) and one of whole numbers (`whole`), so that what an event needs of
it lies together in memory; the names below are the columns.  Every body has its own clock: its position is that
of the parabola from `BEGIN` on.  Clocks have two parts, whose sum is the time: events may be
closer together than the rounding of the time itself (Galperin's blocks), and are still in order.
"""

from __future__ import annotations

import numpy as np

from reference_impl.kernels import inlined, lean
from reference_impl.time_of_contact import parabola

X, V, A = 0, 3, 6  # position, velocity and acceleration
BEGIN, BEGIN_REST = 9, 10  # when the parabola begins [s]
RADIUS, LIGHT, TURN = 11, 12, 13  # inverse mass and inverse moment
CROSS = 14  # when the body leaves its cell
HIT, HIT_REST = 15, 16  # next meeting, or until when nothing is met
DUE, DUE_REST = 17, 18  # the earlier of both
NORMAL, Q, L = 19, 22, 26  # of a half-space; attitude and angular momentum
FORESEEN = 29  # when it will have bounced for the last time [s], as `collisions` foresees it
REALS = 30

WALL, STILL, EVERYWHERE, GROUP = 0, 1, 2, 3  # half-space; at rest for good; not in the grid; row of the law's tables
PARTNER, STAMP, COUNT = 4, 5, 6  # of the next meeting, its count then; how often this body's motion has changed
CELL, INSIDE, SIDE, NEXT, BEFORE = 7, 10, 11, 12, 13  # cell (3), whether it is in it, side it leaves by, its bucket
CHANGED = 14  # motion that Python does not know yet
BESIDE, ARRIVED = 15, 16  # bits: walls that the cell comes near to, and those of them that the cell before did not
WHOLES = 17

# columns of `figures`, of which there is one row for all: the time, and what the loop goes by and finds
NOW, NOW_REST, CELL_SIZE, QUIET, TOLERANCE, PARTING, MOMENT, LAST, SCALE, DEEPEST, RISE, IMBALANCE = range(12)
FIGURES = 12
# columns of `counts`
EVENTS, RECORDED, SEARCHES, FIRST, SECOND = range(5)
COUNTS = 5

NOBODY = -1
BITS = 62  # walls for which there is a bit
SLACK = 1e-3  # of the edge of a cell, by which a wall that is not near its cell is clear of a body


@inlined
def place(real, i, hi, lo, desk, at):
    """Position and velocity of body i at time hi + lo into row `at` of `desk` (rows, 6)."""
    s = (hi - real[i, BEGIN]) + (lo - real[i, BEGIN_REST])
    for c in range(3):
        v, a = real[i, V + c], real[i, A + c]
        desk[at, c] = real[i, X + c] + s * (v + 0.5 * a * s)
        desk[at, 3 + c] = v + a * s


@inlined
def earlier(real, i, j):
    """Whether what body i has to do comes before that of j."""
    if real[i, DUE] != real[j, DUE]:
        return real[i, DUE] < real[j, DUE]
    return real[i, DUE_REST] < real[j, DUE_REST]


@lean
def schedule(real, tree, i):
    """Put the next event of body i in its place; the first of all is tree[1]."""
    if real[i, CROSS] < real[i, HIT]:
        real[i, DUE], real[i, DUE_REST] = real[i, CROSS], 0.0
    else:
        real[i, DUE], real[i, DUE_REST] = real[i, HIT], real[i, HIT_REST]
    node = (i + len(tree) // 2) >> 1
    while node > 0:
        first, second = tree[2 * node], tree[2 * node + 1]
        winner = second if second != NOBODY and earlier(real, second, first) else first
        if winner == tree[node] and winner != i:
            return  # further up nothing has changed
        tree[node] = winner
        node >>= 1


@inlined
def bucket(head, x, y, z):
    """Place of the cell x, y, z in `head`, whose edges are powers of two."""
    return x & (head.shape[0] - 1), y & (head.shape[1] - 1), z & (head.shape[2] - 1)


@lean
def leave(whole, head, i):
    """Take body i out of its cell."""
    after, before = whole[i, NEXT], whole[i, BEFORE]
    if after != NOBODY:
        whole[after, BEFORE] = before
    if before != NOBODY:
        whole[before, NEXT] = after
    else:
        head[bucket(head, whole[i, CELL], whole[i, CELL + 1], whole[i, CELL + 2])] = after


@lean
def enter(whole, head, i):
    """Put body i into the cell its row names."""
    at = bucket(head, whole[i, CELL], whole[i, CELL + 1], whole[i, CELL + 2])
    whole[i, NEXT], whole[i, BEFORE] = head[at], NOBODY
    if head[at] != NOBODY:
        whole[head[at], BEFORE] = i
    head[at] = i


@lean
def next_cell(real, whole, i, desk, at, hi, lo, cell):
    """Find when body i, now at row `at` of `desk`, leaves its cell of edge `cell` [m], and by which side."""
    real[i, CROSS] = np.inf
    for c in range(3):
        v, a = desk[at, 3 + c], real[i, A + c]
        low = desk[at, c] - cell * whole[i, CELL + c]
        if a != 0.0:
            below, above = parabola(low, v, a), parabola(cell - low, -v, -a)
        elif v < 0.0:
            below, above = max(low, 0.0) / -v, np.inf  # what `parabola` gives, without a root
        elif v > 0.0:
            below, above = np.inf, max(cell - low, 0.0) / v
        else:
            continue
        t = hi + (lo + min(below, above))
        if t < real[i, CROSS]:
            real[i, CROSS] = t
            whole[i, SIDE] = 2 * c + (1 if above < below else 0)


@lean
def near_walls(real, whole, walls, i, cell):
    """Note which of `walls` body i may touch in its cell of edge `cell` [m]."""
    before, whole[i, BESIDE] = whole[i, BESIDE], 0
    for at in range(len(walls)):
        k = walls[at]
        room = -real[i, RADIUS] - SLACK * cell  # at the corner of the cell that is the nearest to the wall
        for c in range(3):
            n = real[k, NORMAL + c]
            corner = whole[i, CELL + c] if n > 0.0 else whole[i, CELL + c] + 1
            room += n * (cell * corner - real[k, X + c])
        if room <= 0.0:
            whole[i, BESIDE] |= 1 << at
    whole[i, ARRIVED] = whole[i, BESIDE] & ~before


@lean
def cross_over(real, whole, head, walls, i, cell):
    """Move body i to the next cell, of edge `cell` [m], by the side it leaves."""
    leave(whole, head, i)
    c = whole[i, SIDE] // 2
    whole[i, CELL + c] += 1 if whole[i, SIDE] % 2 == 1 else -1
    enter(whole, head, i)
    near_walls(real, whole, walls, i, cell)


@lean
def around(whole, head, everywhere, walls, i, entered, near):
    """Bodies that i may meet before it or they change cells, into `near`; returns how many.

    With `entered`, only those that have come near since it entered its cell.  Cells that are a
    multiple of an edge of `head` apart share a list: who is far off is looked at in vain, and nobody twice.
    """
    count = 0
    if whole[i, EVERYWHERE] == 1:
        for k in range(len(whole)):
            if k != i:
                near[count] = k
                count += 1
        return count
    x0 = y0 = z0 = -1
    x1 = y1 = z1 = 1
    if entered:
        axis, edge = whole[i, SIDE] // 2, 1 if whole[i, SIDE] % 2 == 1 else -1
        if axis == 0:
            x0 = x1 = edge
        elif axis == 1:
            y0 = y1 = edge
        else:
            z0 = z1 = edge
    for x in range(whole[i, CELL] + x0, whole[i, CELL] + x1 + 1):
        for y in range(whole[i, CELL + 1] + y0, whole[i, CELL + 1] + y1 + 1):
            for z in range(whole[i, CELL + 2] + z0, whole[i, CELL + 2] + z1 + 1):
                k = head[bucket(head, x, y, z)]
                while k != NOBODY:
                    if k != i:
                        near[count] = k
                        count += 1
                    k = whole[k, NEXT]
    if not entered:
        for at in range(len(everywhere)):
            near[count] = everywhere[at]
            count += 1
    bits = whole[i, ARRIVED] if entered else whole[i, BESIDE]
    for at in range(len(walls)):
        if bits >> at & 1:
            near[count] = walls[at]
            count += 1
    return count
