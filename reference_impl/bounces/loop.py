"""Flight and bounces of spheres, event by event, in one compiled loop.

A bounce is settled here if one formula does it: two bodies meet, nothing else touches either of them, and
they part for good.  Everything else (several contacts at one instant, a bounce after which the bodies stay together,
bodies that rest) ends the loop before anything has been exchanged, and `settle` decides.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np

from reference_impl.bounces.exchange import begin_bounce, ends_here, enter_bounce, push, rub, turn_to_now
from reference_impl.bounces.meetings import gather, normal, predict, touches_another
from reference_impl.bounces.queue import (
    BEGIN,
    BEGIN_REST,
    CELL,
    CELL_SIZE,
    CHANGED,
    COUNT,
    CROSS,
    DUE,
    DUE_REST,
    EVENTS,
    EVERYWHERE,
    FIRST,
    GROUP,
    HIT,
    INSIDE,
    LIGHT,
    NOBODY,
    NOW,
    NOW_REST,
    PARTNER,
    QUIET,
    RECORDED,
    SECOND,
    STAMP,
    STILL,
    WALL,
    L,
    Q,
    V,
    X,
    cross_over,
    enter,
    leave,
    near_walls,
    next_cell,
    place,
    schedule,
)
from reference_impl.kernels import lean

# how the loop ends: at its limit; at a meeting that it leaves to others; out of budget; without room for the record
DONE, MEETING, PAUSED, FULL = 0, 1, 2, 3


@lean
def _begin_again(real, whole, i, state, hi, lo):
    """Body i, unless it is fixed, flies on from what its row of a desk says."""
    if real[i, LIGHT] == 0.0:
        return
    for c in range(3):
        real[i, X + c], real[i, V + c] = state[c], state[3 + c]
    real[i, BEGIN], real[i, BEGIN_REST] = hi, lo
    whole[i, COUNT] += 1
    whole[i, CHANGED] = 1


@lean
def refresh(real, whole, head, tree, everywhere, walls, near, desk, work, fresh, figures, counts):
    """Cells and next events of the bodies `fresh`, whose motion is new."""
    hi, lo, cell = figures[NOW], figures[NOW_REST], figures[CELL_SIZE]
    for i in fresh:
        if whole[i, EVERYWHERE] == 1:
            continue
        if whole[i, INSIDE] != 0:
            leave(whole, head, i)
        place(real, i, hi, lo, desk, 0)
        for c in range(3):
            whole[i, CELL + c] = math.floor(desk[0, c] / cell)
        enter(whole, head, i)
        whole[i, INSIDE] = 1
        near_walls(real, whole, walls, i, cell)
        next_cell(real, whole, i, desk, 0, hi, lo, cell)
    for i in fresh:
        if whole[i, WALL] == 0:
            count = gather(real, whole, head, everywhere, walls, i, False, figures, near, desk)
            predict(real, whole, i, near, count, desk, work, figures, counts, True)
        schedule(real, tree, i)


@lean
def hand_over(real, whole, x_series, q_series, momentum, start, begin, energy):
    """Write the segments of the bodies whose motion Python does not know yet."""
    for i in range(len(whole)):
        if whole[i, CHANGED] == 0:
            continue
        whole[i, CHANGED] = 0
        for c in range(3):
            x_series[i, 0, c] = real[i, X + c] - real[i, BEGIN_REST] * real[i, V + c]
            x_series[i, 1, c] = real[i, V + c]
            momentum[i, c] = start[i, c] = real[i, L + c]
        for c in range(4):
            q_series[i, 0, c] = real[i, Q + c]
        begin[i] = real[i, BEGIN]
        energy[i] = np.nan  # it has been exchanged


@lean
def _change_cell(real, whole, head, tree, everywhere, walls, i, near, desk, work, figures, counts):
    """Body i enters the next cell, and looks at who is near only from there."""
    cross_over(real, whole, head, walls, i, figures[CELL_SIZE])
    count = gather(real, whole, head, everywhere, walls, i, True, figures, near, desk)
    next_cell(real, whole, i, desk, len(desk) - 1, figures[NOW], figures[NOW_REST], figures[CELL_SIZE])
    predict(real, whole, i, near, count, desk, work, figures, counts, False)
    schedule(real, tree, i)


@lean
def _is_isolated(real, whole, i, j, near, count, desk, also, more, beside, rate, quiet):
    """Whether i and j close on each other, neither rests, and nothing else touches one of them."""
    return not (
        rate >= -quiet
        or whole[i, STILL] == 1
        or whole[j, STILL] == 1
        or touches_another(real, whole, i, j, near, count, desk, quiet)
        or (whole[j, WALL] == 0 and touches_another(real, whole, j, i, also, more, beside, quiet))
    )


@lean
def _fly_on(real, whole, tree, i, j, near, count, desk, work, figures, counts):
    """Find what comes next for body i, now at the last row of `desk`, after its bounce with j."""
    hi, lo = figures[NOW], figures[NOW_REST]
    for at in range(count):
        if near[at] == j:
            place(real, j, hi, lo, desk, at)
    if whole[i, EVERYWHERE] == 0:
        next_cell(real, whole, i, desk, len(desk) - 1, hi, lo, figures[CELL_SIZE])
    predict(real, whole, i, near, count, desk, work, figures, counts, True)
    schedule(real, tree, i)


@cache
def bounces(turning: bool, rough: bool) -> Any:
    """The loop for scenes where bodies turn or do not, and where contact is rough or not.

    Returns a kernel; see `Flock.run` for what it is given.
    """

    @lean
    def run(
        real, whole, head, tree, everywhere, walls, restitution, friction, near, also, desk, beside, work, n, ends,
        numbers, figures, counts, limit, events, turns
    ):  # fmt: skip
        mine, other, impulse, slip, was = desk[len(desk) - 1], beside[len(beside) - 1], work[0], work[1], work[3:5]
        for _ in range(turns):
            i = tree[1]
            hi, lo = real[i, DUE], real[i, DUE_REST]
            if hi > limit or (hi == limit and lo >= 0.0):
                figures[NOW], figures[NOW_REST] = limit, 0.0
                return DONE
            if counts[EVENTS] >= events:
                return PAUSED
            figures[NOW], figures[NOW_REST] = hi, lo
            if real[i, CROSS] < real[i, HIT]:
                _change_cell(real, whole, head, tree, everywhere, walls, i, near, desk, work, figures, counts)
                continue
            j, more = whole[i, PARTNER], 0
            count = gather(real, whole, head, everywhere, walls, i, False, figures, near, desk)
            if j == NOBODY or whole[j, COUNT] != whole[i, STAMP]:
                predict(real, whole, i, near, count, desk, work, figures, counts, True)
                schedule(real, tree, i)
                continue
            if counts[RECORDED] == len(ends):
                return FULL
            if whole[j, WALL] == 0:
                more = gather(real, whole, head, everywhere, walls, j, False, figures, also, beside)
            else:
                place(real, j, hi, lo, beside, len(beside) - 1)
            a, b, at_a, at_b = i, j, mine, other
            if whole[j, WALL] == 0 and j < i:
                a, b, at_a, at_b = j, i, other, mine
            gap, rate = normal(real, whole, a, b, at_a, at_b, n)
            e = restitution[whole[a, GROUP], whole[b, GROUP]]
            isolated = _is_isolated(real, whole, i, j, near, count, desk, also, more, beside, rate, figures[QUIET])
            if not isolated or ends_here(real, whole, a, b, n, at_a, at_b, gap, rate, e, figures):
                counts[FIRST], counts[SECOND] = a, b
                return MEETING
            p = -(1.0 + e) * rate / (real[a, LIGHT] + real[b, LIGHT])
            before = begin_bounce(real, a, b, n, at_a, at_b, p, impulse, was)
            if turning:
                turn_to_now(real, a, b, hi, lo)
            if rough:
                # before the normal impulse, which does not change the slip
                rub(real, a, b, n, at_a, at_b, rate, p, friction[whole[a, GROUP], whole[b, GROUP]], impulse, slip)
            push(real, a, b, n, at_a, at_b, p)
            enter_bounce(real, a, b, n, at_a, at_b, gap, p, before, impulse, was, ends, numbers, figures, counts)
            # both fly on; each is looked at where the other has its new motion
            _begin_again(real, whole, i, mine, hi, lo)
            _begin_again(real, whole, j, other, hi, lo)
            _fly_on(real, whole, tree, i, j, near, count, desk, work, figures, counts)
            if whole[j, WALL] == 0:
                _fly_on(real, whole, tree, j, i, also, more, beside, work, figures, counts)
        return PAUSED

    return run
