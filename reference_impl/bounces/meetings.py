"""When and whom spheres meet in flight.

Touching is not a tolerance here: meetings are known to the rounding of the coordinates, and so a third
body takes part only if its gap is no more than that and does not open.
"""

from __future__ import annotations

import math

import numpy as np

from reference_impl.bounces.queue import (
    COUNT,
    HIT,
    HIT_REST,
    LIGHT,
    NOBODY,
    NORMAL,
    NOW,
    NOW_REST,
    PARTNER,
    QUIET,
    RADIUS,
    SEARCHES,
    STAMP,
    TOLERANCE,
    WALL,
    A,
    around,
    place,
)
from reference_impl.kernels import inlined, lean
from reference_impl.time_of_contact import parabola, spheres_meet

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
def predict(real, whole, i, near, count, desk, work, figures, counts, fresh):
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
def gather(real, whole, head, everywhere, walls, i, entered, figures, near, desk):
    """Bodies around i and where they are now, as `predict` reads them; returns how many."""
    hi, lo = figures[NOW], figures[NOW_REST]
    count = around(whole, head, everywhere, walls, i, entered, near)
    for at in range(count):
        place(real, near[at], hi, lo, desk, at)
    place(real, i, hi, lo, desk, len(desk) - 1)
    return count


@lean
def touches_another(real, whole, i, partner, near, count, desk, quiet):
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
def normal(real, whole, a, b, at_a, at_b, n):
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
