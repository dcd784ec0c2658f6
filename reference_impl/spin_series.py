"""Free rotation as a power series in time.

With the angular velocity in the principal axes and the quaternion q of these axes, coefficients follow one from
another, because products of series are convolutions (Jorba and Zou, A software package for the numerical integration
of ODEs by means of high-order Taylor methods, 2005).  The spin goes from one segment to the next on its own series,
and is held to the energy and the momentum the flight began with.
"""

from __future__ import annotations

import math

import numpy as np

from reference_impl.kernels import kernel, matrix
from reference_impl.state import ORDER

TRUNCATION = 1e-16  # relative size of the last terms kept; what is left out is less than a tenth of it: below rounding


@kernel
def reach(series):
    """Time within which the last three terms of a series of unit quaternions stay below TRUNCATION [s]."""
    reach = np.inf
    for k in range(ORDER - 2, ORDER + 1):
        top = 0.0
        for c in range(series.shape[1]):
            top = max(top, abs(series[k, c]))
        if top > 0.0:
            reach = min(reach, (TRUNCATION / top) ** (1.0 / k))
    return reach


@kernel
def free_series(moments, frame, spin_series, out):
    """Taylor series of free rotation from the first coefficients in the arrays; returns how long it holds [s].

    `spin_series[0]` is the angular velocity in the principal axes, where Euler's equations are

        ω₁' = (I₂ - I₃) / I₁ ω₂ ω₃,

    and `out[0]` the attitude of the principal axes; the coefficients in `out` become those of the body.
    """
    a = (moments[1] - moments[2]) / moments[0]
    b = (moments[2] - moments[0]) / moments[1]
    c = (moments[0] - moments[1]) / moments[2]
    for k in range(ORDER):
        da = db = dc = dw = dx = dy = dz = 0.0
        for j in range(k + 1):
            p, q, r = spin_series[k - j, 0], spin_series[k - j, 1], spin_series[k - j, 2]
            da += spin_series[j, 1] * r
            db += spin_series[j, 2] * p
            dc += spin_series[j, 0] * q
            w, x, y, z = out[j, 0], out[j, 1], out[j, 2], out[j, 3]
            dw -= x * p + y * q + z * r
            dx += w * p + y * r - z * q
            dy += w * q - x * r + z * p
            dz += w * r + x * q - y * p
        part = 1.0 / (k + 1.0)
        spin_series[k + 1, 0], spin_series[k + 1, 1], spin_series[k + 1, 2] = (
            a * da * part,
            b * db * part,
            c * dc * part,
        )
        part *= 0.5
        out[k + 1, 0], out[k + 1, 1], out[k + 1, 2], out[k + 1, 3] = dw * part, dx * part, dy * part, dz * part
    if frame[0] != 1.0:
        for k in range(ORDER + 1):
            compose(out[k], frame[0], -frame[1], -frame[2], -frame[3])
    return reach(out)


@kernel
def compose(q, w, x, y, z):
    """Quaternion product q (w, x, y, z), in place of q."""
    a, b, c, d = q[0], q[1], q[2], q[3]
    q[0] = a * w - b * x - c * y - d * z
    q[1] = a * x + b * w + c * z - d * y
    q[2] = a * y - b * z + c * w + d * x
    q[3] = a * z + b * y - c * x + d * w


@kernel
def begin_spin(q, momentum, moments, frame, q_series, spin_series, kept):
    """First coefficients of a new free rotation, and what it keeps: |L|² and |L|² - 2 T I for each moment I.

    The latter, Σ I_c (I_c - I) ω_c² with the kinetic energy T, lack the term of the axis of I: they are known to
    rounding of what is across that axis, however much larger the spin about it.
    """
    for c in range(4):
        q_series[0, c] = q[c]
    if frame[0] != 1.0:
        compose(q_series[0], frame[0], frame[1], frame[2], frame[3])
    rotation = matrix(q_series[0])
    kept[0] = 0.0
    for c in range(3):
        l = rotation[0, c] * momentum[0] + rotation[1, c] * momentum[1] + rotation[2, c] * momentum[2]
        spin_series[0, c] = l / moments[c]
        kept[0] += momentum[c] * momentum[c]
    for k in range(3):
        kept[1 + k] = 0.0
        for c in range(3):
            kept[1 + k] += moments[c] * (moments[c] - moments[k]) * spin_series[0, c] * spin_series[0, c]


@kernel
def keep(w, moments, kept):
    """Shift the body angular velocity w by rounding, along the least change of I w, to what `begin_spin` found.

    Of the three differences that is taken which lacks the axis nearest to the momentum: the others' rounding is
    that of the whole, and it would come back as a spin across that axis, or as energy beside the separatrix.
    """
    a, largest = 0, 0.0
    for c in range(3):
        if abs(moments[c] * w[c]) > largest:
            a, largest = c, abs(moments[c] * w[c])
    # with l = I w: the difference D has the half gradient g = (I_c - I_a) w_c, and g·l = D
    short, square, length = kept[1 + a], 0.0, 0.0
    for c in range(3):
        short -= moments[c] * (moments[c] - moments[a]) * w[c] * w[c]
        square += moments[c] * w[c] * moments[c] * w[c]
    along = (kept[1 + a] - short) / square
    for c in range(3):
        length += ((moments[c] - moments[a]) * w[c] - along * moments[c] * w[c]) ** 2
    stretch = 0.5 * (kept[0] - square) / square
    shift = 0.5 * short / length if length > 0.0 else 0.0
    for c in range(3):
        across = (moments[c] - moments[a]) * w[c] / moments[c] - along * w[c]
        w[c] += stretch * w[c] + shift * across


@kernel
def align(q, w, moments, momentum):
    """Turn the attitude q of the principal axes by rounding, so that R I w is along the momentum; to unit length."""
    x, y, z = moments[0] * w[0], moments[1] * w[1], moments[2] * w[2]
    a, b, c, d = q[0], q[1], q[2], q[3]
    # u = q l q⁻¹ in two products, up to the square of the length
    s, e, f, g = -b * x - c * y - d * z, a * x + c * z - d * y, a * y + d * x - b * z, a * z + b * y - c * x
    size = a * a + b * b + c * c + d * d
    ux = (-s * b + e * a - f * d + g * c) / size
    uy = (-s * c + f * a - g * b + e * d) / size
    uz = (-s * d + g * a - e * c + f * b) / size
    half = 0.5 / (momentum[0] ** 2 + momentum[1] ** 2 + momentum[2] ** 2)
    tx = half * (uy * momentum[2] - uz * momentum[1])
    ty = half * (uz * momentum[0] - ux * momentum[2])
    tz = half * (ux * momentum[1] - uy * momentum[0])
    q[0] = a - tx * b - ty * c - tz * d
    q[1] = b + tx * a + ty * d - tz * c
    q[2] = c - tx * d + ty * a + tz * b
    q[3] = d + tx * c - ty * b + tz * a
    size = math.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    for k in range(4):
        q[k] /= size


@kernel
def fastest_spin(w, moments, quickness):
    """Greatest angular velocity of a free body that now turns at w in its principal axes [rad/s].

    With p = 1 / smallest moment: |ω| <= p |L| and |ω|² <= 2 p energy.
    """
    square = energy = 0.0
    for c in range(3):
        square += moments[c] * w[c] * moments[c] * w[c]
        energy += moments[c] * w[c] * w[c]
    return min(quickness * math.sqrt(square), math.sqrt(energy * quickness))


@kernel
def to_end(s, series):
    """Replace the first coefficients of a series by its value at s."""
    for c in range(series.shape[1]):
        p = series[ORDER, c]
        for k in range(ORDER - 1, -1, -1):
            p = p * s + series[k, c]
        series[0, c] = p
