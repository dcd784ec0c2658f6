"""Large swings of a pendulum, and falls from near its top, in closed form.

φ̈ = -ω² sin φ, φ from the lowest point.  A body that turns about a fixed edge, or slides on a circle, is such a
pendulum, counted from the top: ψ = π - φ, ψ̈ = +ω² sin ψ.  Abramowitz and Stegun, ch. 16-17.
"""

from __future__ import annotations

import math

import numpy as np


def swing(t: np.ndarray, rate: float, amplitude: float) -> tuple[np.ndarray, np.ndarray]:
    """Angle φ [rad] and its rate [rad/s] at times `t` after release from rest at `amplitude`; `rate` is ω [rad/s]."""
    from scipy.special import ellipj

    k = math.sin(0.5 * amplitude)
    sn, cn, dn, _ = ellipj(rate * np.asarray(t, dtype=np.float64), k * k)
    return 2.0 * np.arcsin(k * cn / dn), -2.0 * rate * k * math.cos(0.5 * amplitude) * sn / dn


def quarter(rate: float, amplitude: float) -> float:
    """Time [s] from rest at `amplitude` to the lowest point."""
    from scipy.special import ellipkm1

    return float(ellipkm1(math.cos(0.5 * amplitude) ** 2)) / rate


def fall(t: np.ndarray, rate: float, start: float) -> tuple[np.ndarray, np.ndarray]:
    """Angle ψ from the top [rad] and its rate [rad/s] at times `t` from rest at `start`; even in t."""
    angle, speed = swing(t, rate, math.pi - start)
    return math.pi - angle, -speed


def fall_speed(rate: float, start: float, angle: float) -> float:
    """Rate [rad/s] at `angle` from the top after a fall from rest at `start`: ψ̇² = 2 ω² (cos ψ₀ - cos ψ)."""
    # the difference of cosines as a product does not cancel
    return 2.0 * rate * math.sqrt(math.sin(0.5 * (angle + start)) * math.sin(0.5 * (angle - start)))


def fall_time(rate: float, start: float, angle: float) -> float:
    """Time [s] from rest at `start` to `angle`, both from the top, start <= angle < 2π - start."""
    from scipy.special import elliprf

    rest = math.sin(0.5 * start) ** 2  # 1 - m
    sn = min(1.0, math.cos(0.5 * angle) / math.cos(0.5 * start))
    cosine = math.sqrt(max(0.0, 1.0 - sn * sn))
    left = sn * float(elliprf(cosine**2, cosine**2 + rest * sn**2, 1.0))
    return quarter(rate, math.pi - start) - left / rate


def whirl(t: np.ndarray, rate: float, spin: float) -> tuple[np.ndarray, np.ndarray]:
    """Angle φ [rad] and its rate [rad/s] at times `t` after the pendulum hung straight down and turned at `spin` > 0.

    It goes over the top, φ = 2 am (½ spin t, (2 ω/spin)²), if spin > 2 ω, and else swings.
    """
    from scipy.special import ellipj

    t, k = np.asarray(t, dtype=np.float64), 0.5 * spin / rate
    if k > 1.0:
        _, _, dn, amplitude = ellipj(0.5 * spin * t, 1.0 / k**2)
        return 2.0 * amplitude, spin * dn
    sn, cn, _, _ = ellipj(rate * t, k * k)
    return 2.0 * np.arcsin(k * sn), spin * cn


def whirl_time(rate: float, spin: float, angle: float) -> float:
    """Time [s] from straight down at `spin` > 0 to `angle` <= π, which it reaches: F (φ/2 | (2 ω/spin)²) 2/spin."""
    from scipy.special import elliprf

    sine = math.sin(0.5 * angle)
    left = max(0.0, 1.0 - (2.0 * rate / spin * sine) ** 2)
    return 2.0 / spin * sine * float(elliprf(math.cos(0.5 * angle) ** 2, left, 1.0))


def passing(t: np.ndarray, rate: float, slowest: float) -> tuple[np.ndarray, np.ndarray]:
    """Angle ψ from the top [rad], growing, and its rate [rad/s] at times `t` after it passed the top at `slowest`."""
    spin = math.hypot(slowest, 2.0 * rate)
    angle, speed = whirl(np.asarray(t, dtype=np.float64) + whirl_time(rate, spin, math.pi), rate, spin)
    return angle - math.pi, speed


def passing_time(rate: float, slowest: float, angle: float) -> float:
    """Time [s] from the top, passed at `slowest` > 0, to `angle`, of either sign: odd in the angle."""
    spin = math.hypot(slowest, 2.0 * rate)
    left = whirl_time(rate, spin, math.pi) - whirl_time(rate, spin, math.pi - abs(angle))
    return math.copysign(left, angle)
