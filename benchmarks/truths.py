"""Motions to forty digits and more, from numbers that are doubles.

The free tumble of a body is had by two routes that share nothing: Taylor series in whole-number
arithmetic (`tumble`), and elliptic functions in closed form (`tumble_closed`).
"""

from __future__ import annotations

from collections.abc import Sequence

import mpmath
from mpmath import mpf

DIGITS = 45
BITS = 180  # of the fixed point: fifty-four decimals
TERMS = 38  # of a series


def _whole(value: float | mpf) -> int:
    return int(mpmath.nint(mpmath.ldexp(mpf(value), BITS)))


def _real(value: int) -> mpf:
    return mpmath.ldexp(mpf(value), -BITS)


def tumble(moments: Sequence[float], q: Sequence[float], w: Sequence[float], time: float | mpf) -> list[mpf]:
    """Attitude (w, x, y, z) of a free body `time` [s] after it was q and turned at w (body frame [rad/s]).

    Euler's equations and q' = ½ q w as Taylor series of `TERMS` terms in fixed point, in steps in which the
    body turns by 0.4 rad at most.
    """
    with mpmath.workdps(DIGITS + 20):
        i = [mpf(m) for m in moments]
        rates = [_whole((i[1] - i[2]) / i[0]), _whole((i[2] - i[0]) / i[1]), _whole((i[0] - i[1]) / i[2])]
        spin, turn = [_whole(c) for c in w], [_whole(c) for c in q]
        fastest = mpmath.sqrt(sum(mpf(c) ** 2 * m for c, m in zip(w, i, strict=True)) / min(i))
        steps = max(1, int(mpmath.ceil(mpf(time) * fastest / mpf("0.4"))))
        h = _whole(mpf(time) / steps)
        for _ in range(steps):
            spin, turn = _step(rates, spin, turn, h)
        size = mpmath.sqrt(sum(_real(c) ** 2 for c in turn))
        return [_real(c) / size for c in turn]


def _step(rates: list[int], spin: list[int], turn: list[int], h: int) -> tuple[list[int], list[int]]:
    """One Taylor step; every number is a whole number of 2^-BITS."""
    w, q = [[c] for c in spin], [[c] for c in turn]

    def product(a: list[int], b: list[int]) -> int:
        return sum(map(int.__mul__, a, reversed(b))) >> BITS

    for k in range(TERMS):
        change = [(rates[c] * product(w[(c + 1) % 3], w[(c + 2) % 3])) >> BITS for c in range(3)]
        p = [[product(q[a], w[b]) for b in range(3)] for a in range(4)]
        rate = (
            -p[1][0] - p[2][1] - p[3][2],
            p[0][0] + p[2][2] - p[3][1],
            p[0][1] - p[1][2] + p[3][0],
            p[0][2] + p[1][1] - p[2][0],
        )
        for series, value in zip((*w, *q), (*change, *(r >> 1 for r in rate)), strict=True):
            series.append(value // (k + 1))

    def total(series: list[int]) -> int:
        value = 0
        for coefficient in reversed(series):
            value = ((value * h) >> BITS) + coefficient
        return value

    return [total(s) for s in w], [total(s) for s in q]


def tumble_closed(moments: Sequence[float], q: Sequence[float], w: Sequence[float], time: float | mpf) -> list[mpf]:
    """The same by Jacobi's functions and an elliptic integral of the third kind, for I₁ < I₂ < I₃ and |L|² > 2 T I₂.

    Landau and Lifshitz, Mechanics, §37; the angle about L from φ' = |L| (2T - L₃²/I₃)/(|L|² - L₃²).
    """
    with mpmath.workdps(DIGITS + 20):
        i1, i2, i3 = (mpf(m) for m in moments)
        w1, w2, w3 = (mpf(c) for c in w)
        energy = i1 * w1**2 + i2 * w2**2 + i3 * w3**2  # 2 T
        square = (i1 * w1) ** 2 + (i2 * w2) ** 2 + (i3 * w3) ** 2
        if not (i1 < i2 < i3 and square > energy * i2):
            raise ValueError(f"moments {moments} and ω = {w} are not of the kind this formula is for")
        a1 = mpmath.sqrt((energy * i3 - square) / (i1 * (i3 - i1)))
        a2 = mpmath.sqrt((energy * i3 - square) / (i2 * (i3 - i2)))
        a3 = mpmath.sqrt((square - energy * i1) / (i3 * (i3 - i1))) * mpmath.sign(w3)
        m = (i2 - i1) * (energy * i3 - square) / ((i3 - i2) * (square - energy * i1))
        rate = (i3 - i2) * a2 * a3 / (i1 * a1)
        start = mpmath.atan2(w2 / a2, w1 / a1)
        u0 = mpmath.ellipf(start, m)
        u = u0 + rate * mpf(time)
        body = [
            a1 * mpmath.ellipfun("cn", u, m=m),
            a2 * mpmath.ellipfun("sn", u, m=m),
            a3 * mpmath.ellipfun("dn", u, m=m),
        ]
        n = i3 * (i1 - i2) / (i1 * (i3 - i2))
        length = mpmath.sqrt(square)
        amplitude = _amplitude(u, m)
        third = mpmath.ellippi(n, amplitude, m) - mpmath.ellippi(n, start, m)
        angle = length * (mpf(time) / i3 + (1 / i1 - 1 / i3) / rate * third)
        first = _frame([i1 * w1, i2 * w2, i3 * w3])
        last = _frame([i1 * body[0], i2 * body[1], i3 * body[2]])
        rotation = mpmath.matrix(
            [[1, 0, 0], [0, mpmath.cos(angle), -mpmath.sin(angle)], [0, mpmath.sin(angle), mpmath.cos(angle)]]
        )
        size = mpmath.sqrt(sum(mpf(c) ** 2 for c in q))
        turned = _matrix([mpf(c) / size for c in q]) * first * rotation * last.T
        return _quaternion(turned)


def _amplitude(u: mpf, m: mpf) -> mpf:
    """am(u), on through all turns: F(am u | m) = u."""
    quarter = mpmath.ellipk(m)
    turns = mpmath.nint(u / (2 * quarter))
    rest = u - 2 * turns * quarter
    return turns * mpmath.pi + mpmath.asin(mpmath.ellipfun("sn", rest, m=m))


def _frame(momentum: list[mpf]) -> mpmath.matrix:
    """Orthonormal columns in the body: along L, along L × axis 3, and their product."""
    x, y, z = momentum
    length, across = mpmath.sqrt(x * x + y * y + z * z), mpmath.sqrt(x * x + y * y)
    e, f = (x / length, y / length, z / length), (y / across, -x / across, mpf(0))
    g = (e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0])
    return mpmath.matrix([[e[k], f[k], g[k]] for k in range(3)])


def _matrix(q: list[mpf]) -> mpmath.matrix:
    w, x, y, z = q
    return mpmath.matrix(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def _quaternion(r: mpmath.matrix) -> list[mpf]:
    """Unit quaternion of a rotation matrix, from its largest component."""
    squares = [
        1 + r[0, 0] + r[1, 1] + r[2, 2],
        1 + r[0, 0] - r[1, 1] - r[2, 2],
        1 - r[0, 0] + r[1, 1] - r[2, 2],
        1 - r[0, 0] - r[1, 1] + r[2, 2],
    ]
    w, x, y, z = range(4)
    sums = {
        (w, x): r[2, 1] - r[1, 2],
        (w, y): r[0, 2] - r[2, 0],
        (w, z): r[1, 0] - r[0, 1],
        (x, y): r[0, 1] + r[1, 0],
        (x, z): r[0, 2] + r[2, 0],
        (y, z): r[1, 2] + r[2, 1],
    }
    top = max(range(4), key=lambda k: squares[k])
    largest = mpmath.sqrt(squares[top]) / 2
    out = [largest if k == top else sums[min(k, top), max(k, top)] / (4 * largest) for k in range(4)]
    return out


def between(a: Sequence[float | mpf], b: Sequence[float | mpf]) -> float:
    """Angle between two attitudes [rad]; neither needs unit length."""
    with mpmath.workdps(DIGITS + 20):
        p, r = [mpf(c) for c in a], [mpf(c) for c in b]
        cosine = sum(x * y for x, y in zip(p, r, strict=True))
        apart = [p[k] * r[j] - p[j] * r[k] for k in range(4) for j in range(k)]
        sine = mpmath.sqrt(sum(c * c for c in apart))
        return float(2 * mpmath.atan2(sine, abs(cosine)))


def agreed(one: Sequence[mpf], other: Sequence[mpf], within: float = 1e-30) -> list[mpf]:
    """`one`, if the other route leads to the same attitude.

    Raises
    ------
    ArithmeticError
        If it does not: then neither is a truth.
    """
    apart = between(one, other)
    if not apart <= within:
        raise ArithmeticError(f"two routes to the truth are {apart:.3g} rad apart")
    return list(one)
