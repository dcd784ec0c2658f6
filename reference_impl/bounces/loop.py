"""Flight and bounces of spheres, event by event, in one compiled loop.

A bounce is settled here if one formula does it: two bodies meet, nothing else touches either of them, and
they part for good.  Everything else (several contacts at one instant, a bounce after which the bodies stay together,
bodies that rest) ends the loop before anything has been exchanged, and `settle` decides.

Touching is not a tolerance here: meetings are known to the rounding of the coordinates, and so a third
body takes part only if its gap is no more than that and does not open.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np

from reference_impl.bounces.queue import (
    BEGIN,
    BEGIN_REST,
    CELL,
    CHANGED,
    COUNT,
    CROSS,
    DUE,
    DUE_REST,
    EVERYWHERE,
    FORESEEN,
    GROUP,
    HIT,
    HIT_REST,
    INSIDE,
    LIGHT,
    NOBODY,
    NORMAL,
    PARTNER,
    RADIUS,
    STAMP,
    STILL,
    TURN,
    WALL,
    A,
    L,
    Q,
    V,
    X,
    around,
    cross_over,
    enter,
    leave,
    near_walls,
    next_cell,
    place,
    schedule,
)
from reference_impl.collisions import GRAIN, NOISE, SAME_REST
from reference_impl.kernels import inlined, lean
from reference_impl.time_of_contact import parabola, spheres_meet

# how the loop ends: at its limit; at a meeting that it leaves to others; out of budget; without room for the record
DONE, MEETING, PAUSED, FULL = 0, 1, 2, 3

# columns of `figures`
NOW, NOW_REST, CELL_SIZE, QUIET, TOLERANCE, PARTING, MOMENT, LAST, SCALE, DEEPEST, RISE, IMBALANCE = range(12)
FIGURES = 12
# columns of `counts`
EVENTS, RECORDED, SEARCHES, FIRST, SECOND = range(5)
COUNTS = 5

ROUNDING = 16.0 * 2.0**-52  # of a gap, relative to the coordinates it is the difference of
CLEARLY = 1.0 - 1e-6  # what is less by this factor is less, whatever rounding has done
LOOKS = 60  # steps towards a meeting on curved relative paths, before it is looked at again later


@lean
def _curved_meeting(work, radii, quiet, tolerance, most):
    """When two spheres meet that are accelerated differently [s], and whether they do then; at most `most`.

    Conservative advancement along the line of centres, on which gap'' >= -|pull|.
    """
    k, t = math.sqrt(work[2, 0] ** 2 + work[2, 1] ** 2 + work[2, 2] ** 2), 0.0
    for _ in range(LOOKS):
        square = approach = 0.0
        for c in range(3):
            r = work[0, c] + t * (work[1, c] + 0.5 * work[2, c] * t)
            square += r * r
            approach += r * (work[1, c] + work[2, c] * t)
        distance = math.sqrt(square)
        gap, rate = distance - radii, approach / distance
        room = gap if rate > quiet else max(gap, 0.0)
        if gap <= tolerance and abs(rate) <= quiet:
            room += tolerance
        s = parabola(room, rate, -k)
        if t + s >= most:
            return most, False
        t += s
        if gap <= tolerance and rate < -quiet:
            return t, True
    return t, False


@inlined
def _meeting(real, whole, i, k, desk, at, work, quiet, tolerance, most):
    """Seconds until bodies i and k, now at the last row of `desk` and at row `at`, meet, and whether they do then.

    At most `most`.
    """
    if real[i, LIGHT] == 0.0 and real[k, LIGHT] == 0.0:
        return most, False
    me = len(desk) - 1
    if whole[k, WALL] == 1:
        gap, rate, pull = -real[i, RADIUS], 0.0, 0.0
        for c in range(3):
            n = real[k, NORMAL + c]
            gap += n * (desk[me, c] - desk[at, c])
            rate += n * (desk[me, 3 + c] - desk[at, 3 + c])
            pull += n * (real[i, A + c] - real[k, A + c])
        # a first glance that only excludes what is clear beyond rounding
        if gap * CLEARLY > -most * (min(rate, 0.0) + 0.5 * most * min(pull, 0.0)):
            return most, False
        if gap <= tolerance and abs(rate) <= quiet and pull >= 0.0:
            return most, False
        return parabola(gap, rate, pull), True
    approach = square = speed = 0.0
    straight = True
    for c in range(3):
        r, v = desk[me, c] - desk[at, c], desk[me, 3 + c] - desk[at, 3 + c]
        approach += r * v
        square += r * r
        speed += v * v
        straight = straight and real[i, A + c] == real[k, A + c]
    radii = real[i, RADIUS] + real[k, RADIUS]
    if straight:
        # the same: they pass each other, or take longer than if they came head on
        excess = CLEARLY * (square - radii * radii)
        if approach >= 0.0 or approach * approach < speed * excess or excess > -2.0 * approach * most:
            return most, False
        if approach >= -quiet * math.sqrt(square):
            return most, False
    for c in range(3):
        work[0, c], work[1, c] = desk[me, c] - desk[at, c], desk[me, 3 + c] - desk[at, 3 + c]
        work[2, c] = real[i, A + c] - real[k, A + c]
    if straight:
        return spheres_meet(work[0], work[1], radii), True
    return _curved_meeting(work, radii, quiet, tolerance, most)


@lean
def _predict(real, whole, i, near, count, desk, work, figures, counts, fresh):
    """Next meeting of body i among the first `count` of `near`; without `fresh`, of these and those it knew before.

    Where they are now is in the rows of `desk`, where i is in the last.
    """
    hi, lo = figures[NOW], figures[NOW_REST]
    if fresh:
        real[i, HIT], real[i, HIT_REST] = np.inf, 0.0
        whole[i, PARTNER] = NOBODY
    counts[SEARCHES] += count
    most = (real[i, HIT] - hi) + (real[i, HIT_REST] - lo)
    found, touches = NOBODY, False
    for at in range(count):
        k = near[at]
        s, meets = _meeting(real, whole, i, k, desk, at, work, figures[QUIET], figures[TOLERANCE], most)
        if s < most:
            most, found, touches = s, k, meets
    if found == NOBODY:
        return
    # the sum hi + lo + most in two parts, without loss
    part = lo + most
    total = hi + part
    other = total - hi
    real[i, HIT] = total
    real[i, HIT_REST] = (hi - (total - other)) + (part - other)
    whole[i, PARTNER], whole[i, STAMP] = (found, whole[found, COUNT]) if touches else (NOBODY, 0)


@lean
def _gather(real, whole, head, everywhere, walls, i, entered, figures, near, desk):
    """Bodies around i and where they are now, as `_predict` reads them; returns how many."""
    hi, lo = figures[NOW], figures[NOW_REST]
    count = around(whole, head, everywhere, walls, i, entered, near)
    for at in range(count):
        place(real, near[at], hi, lo, desk, at)
    place(real, i, hi, lo, desk, len(desk) - 1)
    return count


@lean
def _touches_another(real, whole, i, partner, near, count, desk, quiet):
    """Whether a body other than the partner touches i now and does not part from it."""
    me = len(desk) - 1
    for at in range(count):
        k = near[at]
        if k == partner or (real[i, LIGHT] == 0.0 and real[k, LIGHT] == 0.0):
            continue
        size = real[i, RADIUS] + real[k, RADIUS]
        gap = rate = 0.0
        if whole[k, WALL] == 1:
            gap = -size
            for c in range(3):
                gap += real[k, NORMAL + c] * (desk[me, c] - desk[at, c])
                rate += real[k, NORMAL + c] * (desk[me, 3 + c] - desk[at, 3 + c])
                size += abs(desk[me, c]) + abs(desk[at, c])
        else:
            square = 0.0
            for c in range(3):
                r = desk[me, c] - desk[at, c]
                square += r * r
                rate += r * (desk[me, 3 + c] - desk[at, 3 + c])
            if square > 1.0001 * size * size:
                continue
            distance = math.sqrt(square)
            gap = distance - size
            rate /= distance
            for c in range(3):
                size += abs(desk[me, c]) + abs(desk[at, c])
        if gap <= ROUNDING * size and rate <= quiet:
            return True
    return False


@lean
def _normal(real, whole, a, b, at_a, at_b, n):
    """Unit normal from b to a; returns their gap [m] and its rate [m/s]."""
    gap, rate = -real[a, RADIUS], 0.0
    if whole[b, WALL] == 1:
        for c in range(3):
            n[c] = real[b, NORMAL + c]
            gap += n[c] * (at_a[c] - at_b[c])
            rate += n[c] * (at_a[3 + c] - at_b[3 + c])
        return gap, rate
    distance = 0.0
    for c in range(3):
        n[c] = at_a[c] - at_b[c]
        distance += n[c] * n[c]
    distance = math.sqrt(distance)
    for c in range(3):
        n[c] /= distance
        rate += n[c] * (at_a[3 + c] - at_b[3 + c])
    return distance + gap - real[b, RADIUS], rate


@lean
def _ends_here(real, whole, a, b, n, at_a, at_b, gap, rate, e, figures):
    """Whether the bodies would stay together after this bounce, or would not come back from a last one.

    The rules, and the time of rest that is foreseen, are those of `collisions` for a sphere on its own.
    """
    closing = across = 0.0
    for c in range(3):
        closing -= n[c] * (real[a, A + c] - real[b, A + c])
        across += (at_a[3 + c] - at_b[3 + c] - rate * n[c]) ** 2
    if whole[b, WALL] == 0:
        closing -= across / (real[a, RADIUS] + real[b, RADIUS])  # the spheres turn about each other
    parting = -e * rate
    if parting <= figures[PARTING] or parting <= 0.5 * closing * figures[MOMENT]:
        return True
    if closing <= 0.0 or e == 1.0:
        return False
    bounce = 2.0 * parting / closing
    body, at = (a, at_a) if real[a, LIGHT] > 0.0 else (b, at_b)
    away = max(abs(at[0]), abs(at[1]), abs(at[2]))
    if bounce < figures[LAST] or parting <= 2.0 * figures[PARTING]:
        return True
    if parting**2 <= 8.0 * closing * max(-gap, GRAIN * away):
        return True
    rest = figures[NOW] + bounce / (1.0 - e)
    noise = NOISE * away / (-rate * (1.0 - e))
    if not abs(rest - real[body, FORESEEN]) <= SAME_REST * max(figures[SCALE], rest) + noise:
        real[body, FORESEEN] = rest
    return False


@lean
def _energy(real, i, state):
    """Kinetic energy of a body that moves as its row of a desk says [J]."""
    if real[i, LIGHT] == 0.0:
        return 0.0
    square = state[3] * state[3] + state[4] * state[4] + state[5] * state[5]
    spin = real[i, L] ** 2 + real[i, L + 1] ** 2 + real[i, L + 2] ** 2
    return 0.5 * (square / real[i, LIGHT] + real[i, TURN] * spin)


@inlined
def _remember(real, i, state, was):
    """Keep the velocity and the angular momentum of body i in `was` (6,)."""
    for c in range(3):
        was[c], was[3 + c] = state[3 + c], real[i, L + c]


@inlined
def imbalance(real, a, b, at_a, at_b, n, impulse, was):
    """How far a bounce is from keeping momentum, and angular momentum about the contact, relative to what there is.

    As `audit.imbalance`, but sizes are sums over the components.  `impulse` (3,) is that on a, to which a fixed body
    answers; `was` (2, 6) is what was remembered of a and b.
    """
    fixed, other = real[a, LIGHT] == 0.0, real[b, LIGHT] == 0.0
    mass_a, mass_b = 0.0 if fixed else 1.0 / real[a, LIGHT], 0.0 if other else 1.0 / real[b, LIGHT]
    lost = there = 0.0
    for c in range(3):
        off = mass_a * (at_a[3 + c] - was[0, c]) + mass_b * (at_b[3 + c] - was[1, c])
        if fixed:
            off += impulse[c]
        elif other:
            off -= impulse[c]
        lost += abs(off)
        there += mass_a * (abs(at_a[3 + c]) + abs(was[0, c])) + mass_b * (abs(at_b[3 + c]) + abs(was[1, c]))
    worst = lost / there
    if not ((fixed or real[a, TURN] > 0.0) and (other or real[b, TURN] > 0.0)):
        return worst
    mass_a *= real[a, RADIUS]
    mass_b *= real[b, RADIUS]
    lost = there = 0.0
    for c in range(3):
        d, e = (c + 1) % 3, (c + 2) % 3
        off = (real[a, L + c] - was[0, 3 + c]) + (real[b, L + c] - was[1, 3 + c])
        off += n[d] * (mass_a * (at_a[3 + e] - was[0, e]) - mass_b * (at_b[3 + e] - was[1, e]))
        off -= n[e] * (mass_a * (at_a[3 + d] - was[0, d]) - mass_b * (at_b[3 + d] - was[1, d]))
        lost += abs(off)
        there += mass_a * (abs(at_a[3 + c]) + abs(was[0, c])) + mass_b * (abs(at_b[3 + c]) + abs(was[1, c]))
        there += abs(was[0, 3 + c]) + abs(was[1, 3 + c])
    return max(worst, lost / there)


@lean
def _rub(real, a, b, n, at_a, at_b, rate, p, mu, impulse, slip):
    """Add the tangential impulse of two spheres whose normal impulse is p: it stops the slip, or is mu p.

    It is added to `impulse`, too, and left in `slip`.

    At a sphere the tangential mobility 1/m + r²/I is the same in every direction, and normal and tangential
    impulses do not act on each other.
    """
    for c in range(3):
        d, e = (c + 1) % 3, (c + 2) % 3
        turn = 0.0  # ω × r of both, with r = -R n and + R n
        for i in (a, b):
            turn -= real[i, TURN] * real[i, RADIUS] * (real[i, L + d] * n[e] - real[i, L + e] * n[d])
        slip[c] = at_a[3 + c] - at_b[3 + c] - rate * n[c] + turn
    size = math.sqrt(slip[0] * slip[0] + slip[1] * slip[1] + slip[2] * slip[2])
    if size == 0.0:
        return
    mobility = 0.0
    for i in (a, b):
        mobility += real[i, LIGHT] + real[i, TURN] * real[i, RADIUS] ** 2
    along = -min(mu * p, size / mobility) / size
    for c in range(3):
        slip[c] *= along  # the impulse on a
    for c in range(3):
        d, e = (c + 1) % 3, (c + 2) % 3
        at_a[3 + c] += real[a, LIGHT] * slip[c]
        at_b[3 + c] -= real[b, LIGHT] * slip[c]
        impulse[c] += slip[c]
        lever = n[d] * slip[e] - n[e] * slip[d]
        for i in (a, b):
            if real[i, TURN] > 0.0:
                real[i, L + c] -= real[i, RADIUS] * lever


@lean
def _turn(real, i, s):
    """Turn body i as its momentum does in s seconds: `kernels.turned`, in place."""
    x, y, z = real[i, TURN] * real[i, L] * s, real[i, TURN] * real[i, L + 1] * s, real[i, TURN] * real[i, L + 2] * s
    half = 0.5 * math.sqrt(x * x + y * y + z * z)
    c = math.cos(half)
    s = 0.5 if half == 0.0 else 0.5 * math.sin(half) / half
    x, y, z = s * x, s * y, s * z
    a, b, f, g = real[i, Q], real[i, Q + 1], real[i, Q + 2], real[i, Q + 3]
    a, b, f, g = (
        c * a - x * b - y * f - z * g,
        c * b + x * a + y * g - z * f,
        c * f - x * g + y * a + z * b,
        c * g + x * f - y * b + z * a,
    )
    size = math.sqrt(a * a + b * b + f * f + g * g)
    real[i, Q], real[i, Q + 1], real[i, Q + 2], real[i, Q + 3] = a / size, b / size, f / size, g / size


@lean
def _begin_again(real, whole, i, state, hi, lo):
    """Body i flies on from what its row of a desk says."""
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
            count = _gather(real, whole, head, everywhere, walls, i, False, figures, near, desk)
            _predict(real, whole, i, near, count, desk, work, figures, counts, True)
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
        quiet = figures[QUIET]
        impulse, slip, was = work[0], work[1], work[3:5]
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
                cross_over(real, whole, head, walls, i, figures[CELL_SIZE])
                count = _gather(real, whole, head, everywhere, walls, i, True, figures, near, desk)
                next_cell(real, whole, i, desk, len(desk) - 1, hi, lo, figures[CELL_SIZE])
                _predict(real, whole, i, near, count, desk, work, figures, counts, False)
                schedule(real, tree, i)
                continue
            j = whole[i, PARTNER]
            count = _gather(real, whole, head, everywhere, walls, i, False, figures, near, desk)
            if j == NOBODY or whole[j, COUNT] != whole[i, STAMP]:
                _predict(real, whole, i, near, count, desk, work, figures, counts, True)
                schedule(real, tree, i)
                continue
            if counts[RECORDED] == len(ends):
                return FULL
            more = 0
            if whole[j, WALL] == 0:
                more = _gather(real, whole, head, everywhere, walls, j, False, figures, also, beside)
            else:
                place(real, j, hi, lo, beside, len(beside) - 1)
            mine, other = desk[len(desk) - 1], beside[len(beside) - 1]
            a, b, at_a, at_b = i, j, mine, other
            if whole[j, WALL] == 0 and j < i:
                a, b, at_a, at_b = j, i, other, mine
            gap, rate = _normal(real, whole, a, b, at_a, at_b, n)
            e = restitution[whole[a, GROUP], whole[b, GROUP]]
            if (
                rate >= -quiet
                or whole[i, STILL] == 1
                or whole[j, STILL] == 1
                or _touches_another(real, whole, i, j, near, count, desk, quiet)
                or (whole[j, WALL] == 0 and _touches_another(real, whole, j, i, also, more, beside, quiet))
                or _ends_here(real, whole, a, b, n, at_a, at_b, gap, rate, e, figures)
            ):
                counts[FIRST], counts[SECOND] = a, b
                return MEETING
            before = _energy(real, a, at_a) + _energy(real, b, at_b)
            if turning:
                for k in (a, b):
                    if real[k, TURN] > 0.0:
                        _turn(real, k, (hi - real[k, BEGIN]) + (lo - real[k, BEGIN_REST]))
            p = -(1.0 + e) * rate / (real[a, LIGHT] + real[b, LIGHT])
            _remember(real, a, at_a, was[0])
            _remember(real, b, at_b, was[1])
            for c in range(3):
                impulse[c] = p * n[c]
            if rough:
                # before the normal impulse, which does not change the slip
                _rub(real, a, b, n, at_a, at_b, rate, p, friction[whole[a, GROUP], whole[b, GROUP]], impulse, slip)
            row = counts[RECORDED]
            ends[row, 0], ends[row, 1] = a, b
            numbers[row, 0], numbers[row, 7] = hi + lo, p
            for c in range(3):
                numbers[row, 1 + c] = at_a[c] - real[a, RADIUS] * n[c]
                numbers[row, 4 + c] = n[c]
                at_a[3 + c] += p * real[a, LIGHT] * n[c]
                at_b[3 + c] -= p * real[b, LIGHT] * n[c]
            counts[RECORDED] += 1
            counts[EVENTS] += 1
            figures[DEEPEST] = min(figures[DEEPEST], gap)
            figures[RISE] = max(figures[RISE], _energy(real, a, at_a) + _energy(real, b, at_b) - before)
            off = imbalance(real, a, b, at_a, at_b, n, impulse, was)
            figures[IMBALANCE] = max(figures[IMBALANCE], off)
            # both fly on; each is looked at where the other has its new motion
            if real[i, LIGHT] > 0.0:
                _begin_again(real, whole, i, mine, hi, lo)
            if real[j, LIGHT] > 0.0:
                _begin_again(real, whole, j, other, hi, lo)
            for at in range(count):
                if near[at] == j:
                    place(real, j, hi, lo, desk, at)
            for at in range(more):
                if also[at] == i:
                    place(real, i, hi, lo, beside, at)
            if whole[i, EVERYWHERE] == 0:
                next_cell(real, whole, i, desk, len(desk) - 1, hi, lo, figures[CELL_SIZE])
            _predict(real, whole, i, near, count, desk, work, figures, counts, True)
            schedule(real, tree, i)
            if whole[j, WALL] == 1:
                continue
            if whole[j, EVERYWHERE] == 0:
                next_cell(real, whole, j, beside, len(beside) - 1, hi, lo, figures[CELL_SIZE])
            _predict(real, whole, j, also, more, beside, work, figures, counts, True)
            schedule(real, tree, j)
        return PAUSED

    return run
