"""The heavy symmetric top with one point held, and the spherical pendulum, in closed form.

θ is the angle of the axis from straight up and u = cos θ.  Energy and the two angular momenta that are kept, about the
vertical (I₁ b) and about the axis (I₁ c = I₃ ω₃), leave u̇² = β (u - u₁)(u - u₂)(u - u₃), β = 2 m g l/I₁, so that

    u = u₁ + (u₂ - u₁) sn² (ν t + δ, m),  ν² = β (u₃ - u₁)/4,  m = (u₂ - u₁)/(u₃ - u₁).

φ̇ = (b - c u)/(1 - u²) and ψ̇ = ω₃ - φ̇ u are periodic, so their Fourier series, integrated term by term, give the
angles to rounding (Whittaker, Analytical Dynamics, §71; Trefethen and Weideman, SIAM Review 56 (2014) 385).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from mechanics.arrays import Quats, Vectors
from mechanics.rotation import exponential, product

SAMPLES = 4096  # of one period: twice as many as 175 degrees of a spherical pendulum need


class Release(NamedTuple):
    """A top let go with its axis at an angle, going round at a rate, and neither rising nor falling.

    A spherical pendulum is a top without spin: c = 0.
    """

    pull: float  # β = 2 m g l / I₁ [1/s2]
    c: float  # I₃ ω₃ / I₁ [rad/s]
    angle: float  # θ at the start, from straight up [rad]
    round: float  # φ̇ at the start [rad/s]
    spin: float = 0.0  # ω₃, along the axis [rad/s]


class Nodding(NamedTuple):
    """The way of u = cos θ."""

    low: float  # u₁, the least
    high: float  # u₂
    rate: float  # ν [rad/s]
    m: float
    begins_low: bool
    b: float  # [rad/s]

    @property
    def period(self) -> float:
        """Of θ, θ̇, φ̇ and ψ̇ [s]."""
        from scipy.special import ellipk

        return 2.0 * float(ellipk(self.m)) / self.rate


class Axis(NamedTuple):
    """Where the axis of a top points."""

    u: np.ndarray  # cos θ, (T,)
    u_rate: np.ndarray  # [1/s]
    phi: np.ndarray  # azimuth, 0 at the start [rad]
    phi_rate: np.ndarray  # [rad/s]
    psi: np.ndarray  # turn about the axis, 0 at the start [rad]
    psi_rate: np.ndarray  # [rad/s]


def nodding(top: Release) -> Nodding:
    """Turning points and rate of the nodding: one of the three roots is the start, the others solve a quadratic."""
    u = math.cos(top.angle)
    b = top.round * math.sin(top.angle) ** 2 + top.c * u
    a = top.pull * u + (math.sin(top.angle) * top.round) ** 2
    first = top.pull * u - a - top.c**2
    last = first * u + 2.0 * b * top.c - top.pull
    # the parabola pull x² + first x + last opens upwards and is not positive at 1: one root beyond, one within
    beyond = 0.5 * (math.sqrt(first**2 - 4.0 * top.pull * last) + abs(first)) / top.pull
    roots = (beyond, last / (top.pull * beyond)) if first < 0.0 else (-last / (top.pull * beyond), -beyond)
    other, third = min(roots), max(roots)
    low, high = min(u, other), max(u, other)
    return Nodding(low, high, 0.5 * math.sqrt(top.pull * (third - low)), (high - low) / (third - low), u <= other, b)


def _turn(top: Release, way: Nodding, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """u and its rate at times t."""
    from scipy.special import ellipj, ellipk

    sn, cn, dn, _ = ellipj(way.rate * t + (0.0 if way.begins_low else float(ellipk(way.m))), way.m)
    span = way.high - way.low
    return way.low + span * sn**2, 2.0 * span * way.rate * sn * cn * dn


def _rates(top: Release, way: Nodding, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """φ̇ and ψ̇ [rad/s] where the axis is at u."""
    phi = (way.b - top.c * u) / ((1.0 - u) * (1.0 + u))
    return phi, top.spin - phi * u


def _integrated(rates: np.ndarray, period: float, t: np.ndarray) -> np.ndarray:
    """∫ from 0 to t of an even function of this period, given at equally spaced times of one period."""
    waves = np.fft.rfft(rates).real / len(rates)
    kept = np.arange(1, len(rates) // 2)
    kept = kept[np.abs(waves[kept]) > 1e-17 * np.abs(waves).max()]
    rate = 2.0 * math.pi * kept / period
    return waves[0] * t + np.sin(t[:, None] * rate) @ (2.0 * waves[kept] / rate)


def axis(top: Release, t: np.ndarray) -> Axis:
    """Where the axis of `top` points `t` [s] after it was let go."""
    way = nodding(top)
    u, u_rate = _turn(top, way, t)
    once = np.linspace(0.0, way.period, SAMPLES, endpoint=False)
    cycle = _rates(top, way, _turn(top, way, once)[0])
    phi, psi = (_integrated(rates, way.period, t) for rates in cycle)
    phi_rate, psi_rate = _rates(top, way, u)
    return Axis(u, u_rate, phi, phi_rate, psi, psi_rate)


def direction(way: Axis) -> tuple[Vectors, Vectors]:
    """Unit vector along the axis, at the start in the half plane x > 0 of x-z, and its rate of change [1/s]."""
    sine = np.sqrt((1.0 - way.u) * (1.0 + way.u))
    ahead = np.stack([np.cos(way.phi), np.sin(way.phi), 0.0 * way.phi], axis=-1)
    across = np.stack([-np.sin(way.phi), np.cos(way.phi), 0.0 * way.phi], axis=-1)
    up = np.array([0.0, 0.0, 1.0])
    slope = (-way.u * way.u_rate / sine)[:, None]
    rate = slope * ahead + (sine * way.phi_rate)[:, None] * across + way.u_rate[:, None] * up
    return sine[:, None] * ahead + way.u[:, None] * up, rate


def attitude(way: Axis) -> tuple[Quats, Vectors]:
    """Quaternion, body z along the axis, and angular velocity in the world [rad/s]: φ about z, θ about y, ψ about z."""
    theta = np.arctan2(np.sqrt((1.0 - way.u) * (1.0 + way.u)), way.u)

    def turned(angle: np.ndarray, k: int) -> Quats:
        return exponential(angle[:, None] * np.eye(3)[k])

    q = product(turned(way.phi, 2), product(turned(theta, 1), turned(way.psi, 2)))
    along, _ = direction(way)
    falls = -way.u_rate / np.sin(theta)
    across = np.stack([-np.sin(way.phi), np.cos(way.phi), 0.0 * way.phi], axis=-1)
    w = falls[:, None] * across + way.psi_rate[:, None] * along
    w[:, 2] += way.phi_rate
    return q, w
