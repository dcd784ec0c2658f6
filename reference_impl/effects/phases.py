"""The impact of one rough contact, followed through compression and expansion.

The relative velocity u = (normal, two tangents) of the touching points changes with the normal impulse p as

    du/dp = W (1, f),    f = -µ s / |s| while the contact slips with s,    |f| <= µ and s = 0 while it sticks,

with W the mobility of the contact (3, 3) (Routh 1860; Keller, Impact with friction, J. Appl. Mech. 53, 1986).
Compression ends where the normal velocity is zero.  Expansion ends

    energetic    where the normal impulse has given back e² of the work it took (Stronge, Rigid body collisions with
                 friction, Proc. R. Soc. A 431, 1990); never makes energy, since friction only takes it
    poisson      where the impulse is 1 + e times that of compression; may make energy where slip reverses

Slip in a constant direction, rolling and slip that begins from rest have closed forms.  Where the direction of slip
turns, dτ = dp / |s| makes the equations polynomial: their Taylor series is followed to rounding.
"""

from __future__ import annotations

import math

import numpy as np

from reference_impl.kernels import kernel

ORDER = 20  # of the Taylor series of slip that turns
STEPS = 4_000  # budget: pieces of one impact
STRAIGHT = 1e-15  # turning of the slip below which it is straight [rate of the slip]
STOPPED = 1e-16  # slip that is none [speed at the start]
COMPRESSION = -1e-300  # a normal velocity of zero about to be negative: its sign tells the phase [m/s]
ENERGETIC, POISSON = 0, 1
HYPOTHESES = {"energetic": ENERGETIC, "poisson": POISSON}


@kernel
def strike(w, u, mu, e, hypothesis, r):
    """Impulse of one impact into `r`; False if the budget ran out.

    Parameters
    ----------
    w : (3, 3) array
        Mobility, positive definite: normal, two tangents [1/kg].
    u : (3,) array
        Relative velocity before, normal part negative [m/s].
    mu, e : float
        Coefficients of friction and restitution.
    hypothesis : int
        ENERGETIC or POISSON.
    r : (3,) array
        Becomes the impulse on a along normal and tangents [N s].
    """
    v, r[:] = u.copy(), 0.0
    speed = max(abs(u[0]), abs(u[1]), abs(u[2]))
    tally = np.zeros(
        4
    )  # work since the deepest compression, its depth [J], the impulse up to there, whether all is over
    f, series = np.zeros(2), np.empty((8, ORDER + 1))
    rate = abs(w[0, 1]) + abs(w[0, 2]) + mu * (abs(w[1, 1]) + abs(w[1, 2]) + abs(w[2, 2]))
    for _ in range(STEPS):
        if tally[3] > 0.0:
            return True
        slip = math.sqrt(v[1] * v[1] + v[2] * v[2])
        slows, holds = 0.0, False
        if mu == 0.0:
            f[:] = 0.0
        elif slip <= STOPPED * speed:
            v[1] = v[2] = 0.0
            holds = _from_rest(w, mu, f)
        else:
            c, s = v[1] / slip, v[2] / slip
            x = w[0, 1] - mu * (w[1, 1] * c + w[1, 2] * s)
            y = w[0, 2] - mu * (w[1, 2] * c + w[2, 2] * s)
            if abs(c * y - s * x) > STRAIGHT * rate:
                _turning(w, mu, e, hypothesis, rate, v, r, tally, series)
                continue
            f[0], f[1], slows = -mu * c, -mu * s, -(c * x + s * y)
        _straight(w, e, hypothesis, slip, slows, holds, f, v, r, tally)
    return False


@kernel
def _turned_back(v, p, tally, e):
    """Note the end of compression: the normal velocity is zero."""
    v[0] = 0.0
    if tally[0] < 0.0:
        tally[1] -= tally[0]
        tally[0], tally[2] = 0.0, p
        if e == 0.0:
            tally[3] = 1.0


@kernel
def _from_rest(w, mu, f):
    """Friction per normal impulse of a contact that does not slip; True if it holds it, False if slip begins."""
    a, b, c, x, y = w[1, 1], w[1, 2], w[2, 2], w[0, 1], w[0, 2]
    det = a * c - b * b
    f[0], f[1] = -(c * x - b * y) / det, -(a * y - b * x) / det
    if f[0] * f[0] + f[1] * f[1] <= mu * mu:
        return True
    # slip along s with (µ W_T + λ) s = W_Tn and λ > 0, for which |s| = 1: |s(λ)| falls from > 1 to below 1
    low, high = 0.0, math.sqrt(x * x + y * y)
    for _ in range(200):
        middle = 0.5 * (low + high)
        if middle in (low, high):
            break
        p, q = mu * a + middle, mu * c + middle
        d = p * q - mu * mu * b * b
        if math.hypot((q * x - mu * b * y) / d, (p * y - mu * b * x) / d) > 1.0:
            low = middle
        else:
            high = middle
    p, q = mu * a + high, mu * c + high
    sx, sy = q * x - mu * b * y, p * y - mu * b * x
    size = math.hypot(sx, sy)
    f[0], f[1] = -mu * sx / size, -mu * sy / size
    return False


@kernel
def _straight(w, e, hypothesis, slip, slows, holds, f, v, r, tally):
    """On with constant friction `f` to the next event: slip ends, compression ends or begins again, the impact ends."""
    gain = w[0, 0] + w[0, 1] * f[0] + w[0, 2] * f[1]
    stop = slip / slows if slows > 0.0 else math.inf
    turn = finish = math.inf
    if v[0] < 0.0:
        turn = -v[0] / gain if gain > 0.0 else math.inf
    elif hypothesis == POISSON:
        finish = (1.0 + e) * tally[2] - r[0]
    else:
        more = e * e * tally[1] - tally[0]
        square = v[0] * v[0] + 2.0 * gain * more
        if square >= 0.0:
            finish = 2.0 * more / (v[0] + math.sqrt(square))
        else:
            turn = -v[0] / gain
    p = min(stop, turn, finish)
    approached = v[0] < 0.0
    tally[0] += p * (v[0] + 0.5 * gain * p)
    v[0] += gain * p
    v[1] += p * (w[0, 1] + w[1, 1] * f[0] + w[1, 2] * f[1])
    v[2] += p * (w[0, 2] + w[1, 2] * f[0] + w[2, 2] * f[1])
    r[0], r[1], r[2] = r[0] + p, r[1] + p * f[0], r[2] + p * f[1]
    if holds or p == stop:
        v[1] = v[2] = 0.0
    if p == turn:
        if approached:
            _turned_back(v, r[0], tally, e)
        else:
            v[0] = COMPRESSION
    elif p == finish:
        tally[3] = 1.0


@kernel
def _expand(w, mu, c, s, slip, u, t):
    """Taylor coefficients in τ of cos, sin, slip, u_n, p, work and both parts of the friction impulse."""
    t[:] = 0.0
    t[0, 0], t[1, 0], t[2, 0], t[3, 0] = c, s, slip, u
    turn, grow, lift = np.zeros(ORDER), np.zeros(ORDER), np.zeros(ORDER)
    ax, ay = np.zeros(ORDER), np.zeros(ORDER)
    for k in range(ORDER):
        ax[k] = -mu * (w[1, 1] * t[0, k] + w[1, 2] * t[1, k])
        ay[k] = -mu * (w[1, 2] * t[0, k] + w[2, 2] * t[1, k])
        lift[k] = -mu * (w[0, 1] * t[0, k] + w[0, 2] * t[1, k])
        if k == 0:
            ax[0] += w[0, 1]
            ay[0] += w[0, 2]
            lift[0] += w[0, 0]
        for j in range(k + 1):
            turn[k] += t[0, j] * ay[k - j] - t[1, j] * ax[k - j]
            grow[k] += t[0, j] * ax[k - j] + t[1, j] * ay[k - j]
        dc, ds, dslip, du, dwork, dx, dy = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for j in range(k + 1):
            dc -= t[1, j] * turn[k - j]
            ds += t[0, j] * turn[k - j]
            dslip += t[2, j] * grow[k - j]
            du += t[2, j] * lift[k - j]
            dwork += t[2, j] * t[3, k - j]
            dx -= mu * t[2, j] * t[0, k - j]
            dy -= mu * t[2, j] * t[1, k - j]
        n = k + 1.0
        t[0, k + 1], t[1, k + 1], t[2, k + 1], t[3, k + 1] = dc / n, ds / n, dslip / n, du / n
        t[4, k + 1], t[5, k + 1], t[6, k + 1], t[7, k + 1] = t[2, k] / n, dwork / n, dx / n, dy / n


@kernel
def _at(t, x):
    """Value of the polynomial with coefficients t at x."""
    total = 0.0
    for k in range(len(t) - 1, -1, -1):
        total = total * x + t[k]
    return total


@kernel
def _crossing(t, level, end):
    """Where the polynomial t crosses `level` between 0 and `end`, at whose ends it lies on different sides."""
    low, high = 0.0, end
    rising = _at(t, end) >= level
    for _ in range(100):
        middle = 0.5 * (low + high)
        if middle in (low, high):
            break
        if (_at(t, middle) >= level) == rising:
            high = middle
        else:
            low = middle
    return high


@kernel
def _turning(w, mu, e, hypothesis, rate, v, r, tally, t):
    """On by one Taylor step of slip that turns, or to the event within it."""
    slip = math.sqrt(v[1] * v[1] + v[2] * v[2])
    _expand(w, mu, v[1] / slip, v[2] / slip, slip, v[0], t)
    end = 2.0 / rate
    for k in range(ORDER - 1, ORDER + 1):
        size = max(abs(t[0, k]), abs(t[1, k]), abs(t[2, k]) / slip)
        if size > 0.0:
            end = min(end, (1e-17 / size) ** (1.0 / k))
    after = _at(t[3], end)
    level = e * e * tally[1] - tally[0] if hypothesis == ENERGETIC else (1.0 + e) * tally[2] - r[0]
    given = t[5] if hypothesis == ENERGETIC else t[4]
    turns = finishes = False
    if v[0] < 0.0:
        turns = after >= 0.0
    elif _at(given, end) >= level:
        finishes = True
    else:
        turns = after < 0.0
    approached = v[0] < 0.0
    if turns:
        end = _crossing(t[3], 0.0, end)
    elif finishes:
        end = _crossing(given, level, end)
    c, s, slip = _at(t[0], end), _at(t[1], end), _at(t[2], end)
    size = math.sqrt(c * c + s * s)
    v[0], v[1], v[2] = _at(t[3], end), slip * c / size, slip * s / size
    r[0], r[1], r[2] = r[0] + _at(t[4], end), r[1] + _at(t[6], end), r[2] + _at(t[7], end)
    tally[0] += _at(t[5], end)
    if turns:
        if approached:
            _turned_back(v, r[0], tally, e)
        else:
            v[0] = COMPRESSION
    elif finishes:
        tally[3] = 1.0
