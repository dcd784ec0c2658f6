"""What two spheres exchange when they bounce, and whether one formula does it: see `loop`."""

from __future__ import annotations

import math

from reference_impl.bounces.queue import (
    BEGIN,
    BEGIN_REST,
    DEEPEST,
    EVENTS,
    FORESEEN,
    IMBALANCE,
    LAST,
    LIGHT,
    MOMENT,
    NOW,
    NOW_REST,
    PARTING,
    RADIUS,
    RECORDED,
    RISE,
    SCALE,
    TURN,
    WALL,
    A,
    L,
    Q,
)
from reference_impl.collisions import GRAIN, NOISE, SAME_REST
from reference_impl.kernels import inlined, lean


@lean
def ends_here(real, whole, a, b, n, at_a, at_b, gap, rate, e, figures):
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
def rub(real, a, b, n, at_a, at_b, rate, p, mu, impulse, slip):
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
def begin_bounce(real, a, b, n, at_a, at_b, p, impulse, was):
    """Remember what both bodies do before the normal impulse p, which is put into `impulse`.

    Returns their kinetic energy [J].
    """
    _remember(real, a, at_a, was[0])
    _remember(real, b, at_b, was[1])
    for c in range(3):
        impulse[c] = p * n[c]
    return _energy(real, a, at_a) + _energy(real, b, at_b)


@lean
def turn_to_now(real, a, b, hi, lo):
    """Bring the attitudes of both bodies from where their parabolas begin to the time hi + lo."""
    for i in (a, b):
        if real[i, TURN] > 0.0:
            _turn(real, i, (hi - real[i, BEGIN]) + (lo - real[i, BEGIN_REST]))


@inlined
def push(real, a, b, n, at_a, at_b, p):
    """Velocities after the normal impulse p."""
    for c in range(3):
        at_a[3 + c] += p * real[a, LIGHT] * n[c]
        at_b[3 + c] -= p * real[b, LIGHT] * n[c]


@lean
def enter_bounce(real, a, b, n, at_a, at_b, gap, p, before, impulse, was, ends, numbers, figures, counts):
    """Put a bounce on record and into the audit: where, along which normal, how hard, and what it did not keep."""
    row = counts[RECORDED]
    ends[row, 0], ends[row, 1] = a, b
    numbers[row, 0], numbers[row, 7] = figures[NOW] + figures[NOW_REST], p
    for c in range(3):
        numbers[row, 1 + c] = at_a[c] - real[a, RADIUS] * n[c]
        numbers[row, 4 + c] = n[c]
    counts[RECORDED] += 1
    counts[EVENTS] += 1
    figures[DEEPEST] = min(figures[DEEPEST], gap)
    figures[RISE] = max(figures[RISE], _energy(real, a, at_a) + _energy(real, b, at_b) - before)
    figures[IMBALANCE] = max(figures[IMBALANCE], imbalance(real, a, b, at_a, at_b, n, impulse, was))
