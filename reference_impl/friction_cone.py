"""The cone of friction: projection onto it, the certificate of an answer, and one contact alone.

Forces and relative motions of m contacts are (3 m,) arrays: normal, tangent, tangent of each.
"""

from __future__ import annotations

import math

from reference_impl.kernels import kernel

OFF, HOLDS, SLIPS = 0, 1, 2  # states of a contact


@kernel
def project(n, a, b, mu):
    """Nearest point to (n, a, b) in the cone |(a, b)| <= mu n."""
    t = math.sqrt(a * a + b * b)
    if t <= mu * n:
        return n, a, b
    if mu * t <= -n:
        return 0.0, 0.0, 0.0
    top = (n + mu * t) / (1.0 + mu * mu)
    return top, mu * top * a / t, mu * top * b / t


@kernel
def rate(u, r, mu, slides, convex):
    """Greatest component of r - P_K(r - u - µ|u_T| n) over all contacts; |min(f, u_n)| where a contact slides."""
    worst = 0.0
    for i in range(len(mu)):
        n, a, b = r[3 * i], r[3 * i + 1], r[3 * i + 2]
        if slides[i]:
            worst = max(worst, abs(min(n, u[3 * i])), abs(a + mu[i] * n), abs(b))
            continue
        more = 0.0 if convex else mu[i] * math.sqrt(u[3 * i + 1] ** 2 + u[3 * i + 2] ** 2)
        p, q, s = project(n - u[3 * i] - more, a - u[3 * i + 1], b - u[3 * i + 2], mu[i])
        worst = max(worst, abs(n - p), abs(a - q), abs(b - s))
    return worst


@kernel
def _solve3(w, alpha, q, out):
    """Solution of (w + diag(0, α, α)) out = -q by elimination of the symmetric matrix."""
    a, b, c = w[0, 0], w[0, 1], w[0, 2]
    d, e, f = w[1, 1] + alpha, w[1, 2], w[2, 2] + alpha
    c00, c01, c02 = d * f - e * e, c * e - b * f, b * e - c * d
    det = a * c00 + b * c01 + c * c02
    c11, c12, c22 = a * f - c * c, b * c - a * e, a * d - b * b
    out[0] = -(c00 * q[0] + c01 * q[1] + c02 * q[2]) / det
    out[1] = -(c01 * q[0] + c11 * q[1] + c12 * q[2]) / det
    out[2] = -(c02 * q[0] + c12 * q[1] + c22 * q[2]) / det


@kernel
def single(w, q, mu, out):
    """Exact solution for one contact, u = w r + q: off, held, or slipping.

    Slip is u_T = -α r_T for some α > 0, so r(α) = -(w + diag(0, α, α))⁻¹ q, and α is where |r_T| = µ r_n:
    positive at α = 0 (else the contact holds), negative for large α, where r_n -> -q_n / w_nn > 0.
    """
    if q[0] >= 0.0:
        out[:] = 0.0
        return
    if mu == 0.0:
        out[0], out[1], out[2] = -q[0] / w[0, 0], 0.0, 0.0
        return
    scale = w[1, 1] + w[2, 2]
    det = w[1, 1] * w[2, 2] - w[1, 2] ** 2
    if scale <= 1e-30:
        out[0], out[1], out[2] = -q[0] / w[0, 0], 0.0, 0.0
        return
    _solve3(w, 1e-15 * scale if det <= 1e-14 * scale * scale else 0.0, q, out)
    excess = math.sqrt(out[1] ** 2 + out[2] ** 2) - mu * out[0]
    if excess <= 0.0 and math.isfinite(excess):
        return
    low, high = 0.0, scale
    f_low, f_high = excess, 1.0
    for _ in range(200):
        _solve3(w, high, q, out)
        f_high = math.sqrt(out[1] ** 2 + out[2] ** 2) - mu * out[0]
        if f_high <= 0.0:
            break
        low, f_low = high, f_high
        high *= 4.0
    side = 0
    for _ in range(100):
        if high - low <= 1e-16 * high:
            break
        middle = (low * f_high - high * f_low) / (f_high - f_low)
        if not low < middle < high:
            middle = 0.5 * (low + high)
        _solve3(w, middle, q, out)
        f = math.sqrt(out[1] ** 2 + out[2] ** 2) - mu * out[0]
        if f == 0.0:
            break
        if f > 0.0:
            low, f_low = middle, f
            if side == 1:
                f_high *= 0.5
            side = 1
        else:
            high, f_high = middle, f
            if side == -1:
                f_low *= 0.5
            side = -1
        if abs(f) <= 1e-16 * mu * abs(out[0]):
            break
    t = math.sqrt(out[1] ** 2 + out[2] ** 2)
    if t > 0.0:
        out[1], out[2] = mu * out[0] * out[1] / t, mu * out[0] * out[2] / t


@kernel
def single_convex(w, q, mu, out):
    """The same without the term µ |u_T| n: projected gradients from `out` on."""
    step = 1.0 / (w[0, 0] + w[1, 1] + w[2, 2])
    for _ in range(500):
        u0 = q[0] + w[0, 0] * out[0] + w[0, 1] * out[1] + w[0, 2] * out[2]
        u1 = q[1] + w[1, 0] * out[0] + w[1, 1] * out[1] + w[1, 2] * out[2]
        u2 = q[2] + w[2, 0] * out[0] + w[2, 1] * out[1] + w[2, 2] * out[2]
        n, a, b = project(out[0] - step * u0, out[1] - step * u1, out[2] - step * u2, mu)
        change = abs(n - out[0]) + abs(a - out[1]) + abs(b - out[2])
        out[0], out[1], out[2] = n, a, b
        if change <= 1e-16 * abs(n):
            break
