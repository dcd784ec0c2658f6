"""Torque-free rotation of a rigid body in closed form, attitude included.

The angular velocity of a body with three different moments runs through Jacobi's elliptic functions
of u = u₀ + p t (Landau and Lifshitz, Mechanics, §37).  Its attitude is found without Euler angles:
L is constant in the world, and the body's axis 3 goes round it at the rate

    φ̇ = |L| (2T - L₃²/I₃) / (|L|² - L₃²) = |L| [1/I₃ + (1/I₁ - 1/I₃) / (1 - n sn² u)],
    n = I₃ (I₁ - I₂) / (I₁ (I₃ - I₂)),

whose integral is an elliptic integral of the third kind.  Axis 3 is the one L stays around in the
body: that of the largest moment if |L|² > 2 T I_middle, of the smallest otherwise.

Near the separatrix the complementary parameter 1 - m is small and all the accuracy sits in it, so it
is formed from differences of moments without cancellation and handed down; SciPy's ellipj takes m
and loses five digits there.  Integrals are Carlson's (Numerical Computation of Real or Complex
Elliptic Integrals, 1995); the functions come from the arithmetic-geometric mean (Abramowitz and
Stegun, §16.4).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mechanics.arrays import Quat, Quats, Vec3, Vectors
from mechanics.rotation import exponential, from_matrix, matrix, product, rotate, unrotate


def free_rotation(moments: Vec3, q: Quat, w: Vec3, t: np.ndarray) -> tuple[Quats, Vectors]:
    """Attitude and angular velocity of a free body, `t` [s] after they were `q` and `w`.

    Parameters
    ----------
    moments : (3,) [kg m2]
        Principal moments along the body axes: of any kind.
    q : (4,)
        Unit quaternion, body to world.
    w : (3,) [rad/s]
        World frame.
    t : (T,) [s]

    Returns
    -------
    q : (T, 4) array
        Unit quaternions, body to world.
    w : (T, 3) array
        World frame [rad/s].  Both err by less than 1e-12 over tens of turns.

    Raises
    ------
    ValueError
        For an asymmetric body on the separatrix |L|² = 2 T I_middle, or within rounding of a principal axis.
    """
    moments, q = np.asarray(moments, dtype=np.float64), np.asarray(q, dtype=np.float64)
    w_body = unrotate(q, np.asarray(w, dtype=np.float64))
    if np.count_nonzero(w_body) <= 1:  # about a principal axis: uniform
        return product(exponential(t[:, None] * np.asarray(w)), q), np.repeat(np.asarray(w)[None], len(t), axis=0)
    for axis in range(3):
        if moments[axis - 2] == moments[axis - 1]:
            return _symmetric(moments, axis, q, w_body, t)
    return _asymmetric(moments, q, w_body, t)


def _symmetric(moments: Vec3, axis: int, q: Quat, w_body: Vec3, t: np.ndarray) -> tuple[Quats, Vectors]:
    """Symmetric top: L/I₁ turns it in the world while ω₃ (1 - I₃/I₁) turns it about its own axis."""
    across, along = moments[axis - 1], moments[axis]
    spin = w_body[axis] * (1.0 - along / across) * np.eye(3)[axis]
    precession = rotate(q, moments * w_body / across)
    turned = product(exponential(t[:, None] * precession), product(q, exponential(t[:, None] * spin)))
    return turned, precession + rotate(turned, spin)


@dataclass(frozen=True)
class _Cycle:
    """ω₁ = a₁ cn u, ω₂ = a₂ sn u, ω₃ = a₃ dn u with u = `phase` + `rate` t, on the body axes `order`."""

    order: tuple[int, ...]
    amplitudes: Vec3  # [rad/s]
    rate: float  # p [rad/s]; its sign comes from Euler's equations
    rest: float  # 1 - m
    phase: float  # u₀


def _cycle(moments: Vec3, w_body: Vec3) -> _Cycle:
    def excess(i: int) -> float:
        """|L|² - 2 T Iᵢ, without the terms that cancel."""
        return float((moments * (moments - moments[i]) * w_body**2).sum())

    order = tuple(int(k) for k in np.argsort(moments))
    if excess(order[1]) < 0.0:
        order = order[::-1]
    i1, i2, i3 = (float(moments[k]) for k in order)
    least, middle, most = (excess(k) for k in order)
    rest = (i3 - i1) * middle / ((i3 - i2) * least) if least else 1.0
    if not (1e-300 < rest < 1.0 and most):
        raise ValueError(f"no closed form for ω = {w_body} rad/s with moments {moments}: separatrix or principal axis")
    a1, a2 = np.sqrt(-most / (i1 * (i3 - i1))), np.sqrt(-most / (i2 * (i3 - i2)))
    a3 = np.copysign(np.sqrt(least / (i3 * (i3 - i1))), w_body[order[2]])
    # I₁ ω̇₁ = (I₂ - I₃) ω₂ ω₃ holds with a minus if `order` is an odd permutation
    parity = 1.0 if order in ((0, 1, 2), (1, 2, 0), (2, 0, 1)) else -1.0
    rate = parity * (i3 - i2) * a2 * a3 / (i1 * a1)
    sine, cosine = w_body[order[1]] / a2, w_body[order[0]] / a1
    phase = _first_kind(sine, abs(cosine), rest)
    if cosine < 0.0:
        phase = np.copysign(2.0 * _quarter(rest), sine) - phase
    return _Cycle(order, np.array([a1, a2, a3]), float(rate), float(rest), float(phase))


def _asymmetric(moments: Vec3, q: Quat, w_body: Vec3, t: np.ndarray) -> tuple[Quats, Vectors]:
    cycle = _cycle(moments, w_body)
    u = cycle.phase + cycle.rate * np.append(0.0, t)
    turns = np.round(u / (2.0 * _quarter(cycle.rest)))
    sn, cn, dn = _jacobi(u - 2.0 * turns * _quarter(cycle.rest), cycle.rest)
    flip = np.where(turns % 2.0, -1.0, 1.0)
    body = np.empty((len(u), 3))
    body[:, cycle.order] = cycle.amplitudes * np.stack([flip * cn, flip * sn, dn], axis=-1)
    size = float(np.linalg.norm(moments * w_body))
    angle = _precession(moments[list(cycle.order)], size, cycle, u, sn, cn, turns)
    frames = _frames(moments * body, cycle.order[2])
    start = matrix(q) @ frames[0]
    turned = matrix(exponential((angle - angle[0])[1:, None] * start[:, 0])) @ start
    attitude = turned @ frames[1:].transpose(0, 2, 1)
    quaternions = np.array([from_matrix(rotation) for rotation in attitude]).reshape(-1, 4)
    return quaternions, np.einsum("tij,tj->ti", attitude, body[1:])


def _frames(momentum: Vectors, axis: int) -> np.ndarray:
    """Orthonormal frames (columns) in the body: along L, along L × axis 3, and their product."""
    along = momentum / np.linalg.norm(momentum, axis=-1, keepdims=True)
    across = np.cross(along, np.eye(3)[axis])
    across /= np.linalg.norm(across, axis=-1, keepdims=True)
    return np.stack([along, across, np.cross(along, across)], axis=-1)


def _precession(
    moments: Vec3, size: float, cycle: _Cycle, u: np.ndarray, sn: np.ndarray, cn: np.ndarray, turns: np.ndarray
) -> np.ndarray:
    """Angle [rad] by which axis 3 has gone round L since u = 0, of size |L|; `moments` in the cycle's order."""
    i1, i2, i3 = moments
    n = i3 * (i1 - i2) / (i1 * (i3 - i2))
    whole = _third_kind(n, np.ones(1), np.zeros(1), cycle.rest)
    third = _third_kind(n, sn, cn, cycle.rest) + 2.0 * turns * whole
    return np.asarray(size / cycle.rate * (u / i3 + (1.0 / i1 - 1.0 / i3) * third))


def _jacobi(u: np.ndarray, rest: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """sn, cn, dn of |u| <= K and complementary parameter `rest`, by descending Landen transformation."""
    a, b, ratios = 1.0, np.sqrt(rest), []
    while abs(a - b) > 1e-15 * a:
        ratios.append((a - b) / (a + b))
        a, b = 0.5 * (a + b), np.sqrt(a * b)
    amplitude = 2.0 ** len(ratios) * a * u
    for ratio in reversed(ratios):
        amplitude = 0.5 * (amplitude + np.arcsin(ratio * np.sin(amplitude)))
    sn, cn = np.sin(amplitude), np.cos(amplitude)
    return sn, cn, np.sqrt(cn**2 + rest * sn**2)


def _quarter(rest: float) -> float:
    """Complete integral of the first kind, K."""
    from scipy.special import ellipkm1

    return float(ellipkm1(rest))


def _first_kind(sn: float | np.ndarray, cn: float | np.ndarray, rest: float) -> np.ndarray:
    from scipy.special import elliprf

    return np.asarray(sn * elliprf(cn**2, cn**2 + rest * sn**2, 1.0))


def _third_kind(n: float, sn: np.ndarray, cn: np.ndarray, rest: float) -> np.ndarray:
    """Π(n; φ | m) for |φ| <= π/2."""
    from scipy.special import elliprj

    last = elliprj(cn**2, cn**2 + rest * sn**2, 1.0, cn**2 + (1.0 - n) * sn**2)
    return np.asarray(_first_kind(sn, cn, rest) + n / 3.0 * sn**3 * last)
