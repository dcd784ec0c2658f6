"""Free flight by power series.

In flight the position is a parabola (exact), or a series where drag acts.  The attitude is a Taylor
series: with the angular momentum l and angular velocity w = I⁻¹ l in the body frame and the
quaternion q,

    l' = l × w + torque,        q' = ½ q w,

products of series are convolutions, so the coefficients follow one from another (Jorba and Zou,
A software package for the numerical integration of ODEs by means of high-order Taylor methods,
2005).  Without a torque the world angular momentum is constant and is never integrated; the spin in
the principal axes goes from one segment to the next on its own series, and is held to the energy and
the momentum the flight began with.
"""

from __future__ import annotations

import math

import numpy as np

from reference_impl.kernels import angular_velocity, apply, apply_transposed, kernel, matrix, norm, turned
from reference_impl.state import ORDER

TRUNCATION = 1e-16  # relative size of the last terms kept; what is left out is less than a tenth of it: below rounding


@kernel
def _reach_of_series(series):
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
def _spin_series(moments, frame, spin_series, out):
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
            _compose(out[k], frame[0], -frame[1], -frame[2], -frame[3])
    return _reach_of_series(out)


@kernel
def _compose(q, w, x, y, z):
    """Quaternion product q (w, x, y, z), in place of q."""
    a, b, c, d = q[0], q[1], q[2], q[3]
    q[0] = a * w - b * x - c * y - d * z
    q[1] = a * x + b * w + c * z - d * y
    q[2] = a * y - b * z + c * w + d * x
    q[3] = a * z + b * y - c * x + d * w


@kernel
def _begin_spin(q, momentum, moments, frame, q_series, spin_series, kept):
    """First coefficients of a new free rotation, and what it keeps: |L|² and |L|² - 2 T I for each moment I.

    The latter, Σ I_c (I_c - I) ω_c² with the kinetic energy T, lack the term of the axis of I: they are known to
    rounding of what is across that axis, however much larger the spin about it.
    """
    for c in range(4):
        q_series[0, c] = q[c]
    if frame[0] != 1.0:
        _compose(q_series[0], frame[0], frame[1], frame[2], frame[3])
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
def _keep(w, moments, kept):
    """Shift the body angular velocity w by rounding, along the least change of I w, to what `_begin_spin` found.

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
def _align(q, w, moments, momentum):
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
def _driven_series(q, momentum, inverse_inertia, torque, lever, spin_drag, out):
    """Taylor series of the quaternion into `out`; returns the time for which it holds [s].

    `lever` = Σ p Fᵀ of forces F constant in the world at points p fixed in the body: their torque
    in the body frame is Σ p × (Rᵀ F), and Rᵀ F' = (Rᵀ F) × w like every constant world vector.
    """
    rotation = matrix(q)
    l = np.zeros((ORDER + 1, 3))
    w = np.zeros((ORDER + 1, 3))
    axes = np.zeros((ORDER + 1, 3, 3))  # axes[k, m]: k-th coefficient of the world axis m in the body frame
    for c in range(4):
        out[0, c] = q[c]
    for c in range(3):
        l[0, c] = rotation[0, c] * momentum[0] + rotation[1, c] * momentum[1] + rotation[2, c] * momentum[2]
        for m in range(3):
            axes[0, m, c] = rotation[m, c]
    dl = np.empty(3)
    dq = np.empty(4)
    for k in range(ORDER):
        for c in range(3):
            w[k, c] = (
                inverse_inertia[c, 0] * l[k, 0] + inverse_inertia[c, 1] * l[k, 1] + inverse_inertia[c, 2] * l[k, 2]
            )
            dl[c] = 0.0
            dq[c + 1] = 0.0
        dq[0] = 0.0
        for j in range(k + 1):
            a, b, p = l[j], w[k - j], out[j]
            dl[0] += a[1] * b[2] - a[2] * b[1]
            dl[1] += a[2] * b[0] - a[0] * b[2]
            dl[2] += a[0] * b[1] - a[1] * b[0]
            dq[0] += -p[1] * b[0] - p[2] * b[1] - p[3] * b[2]
            dq[1] += p[0] * b[0] + p[2] * b[2] - p[3] * b[1]
            dq[2] += p[0] * b[1] - p[1] * b[2] + p[3] * b[0]
            dq[3] += p[0] * b[2] + p[1] * b[1] - p[2] * b[0]
        _add_torque(dl, axes, w, torque, lever, spin_drag, k)
        for c in range(3):
            l[k + 1, c] = dl[c] / (k + 1.0)
        for c in range(4):
            out[k + 1, c] = 0.5 * dq[c] / (k + 1.0)
    return _reach_of_series(out)


@kernel
def _add_torque(dl, axes, w, torque, lever, spin_drag, k):
    """Add the k-th coefficient of the torque in the body frame to `dl` and carry the world axes one order on."""
    for m in range(3):
        e = axes[k, m]
        for c in range(3):
            dl[c] += torque[m] * e[c]
        dl[0] += lever[1, m] * e[2] - lever[2, m] * e[1]
        dl[1] += lever[2, m] * e[0] - lever[0, m] * e[2]
        dl[2] += lever[0, m] * e[1] - lever[1, m] * e[0]
        for j in range(k + 1):
            a, b = axes[j, m], w[k - j]
            axes[k + 1, m, 0] += (a[1] * b[2] - a[2] * b[1]) / (k + 1.0)
            axes[k + 1, m, 1] += (a[2] * b[0] - a[0] * b[2]) / (k + 1.0)
            axes[k + 1, m, 2] += (a[0] * b[1] - a[1] * b[0]) / (k + 1.0)
    for c in range(3):
        dl[c] -= spin_drag * w[k, c]


@kernel
def _path_series(x, v, acceleration, drag, out):
    """Series of the position under a constant acceleration and linear drag; returns for how long it holds [s]."""
    for c in range(3):
        out[0, c] = x[c]
        out[1, c] = v[c]
        out[2, c] = 0.5 * (acceleration[c] - drag * v[c])
        for k in range(2, ORDER):
            out[k + 1, c] = -drag * out[k, c] / (k + 1.0) if drag > 0.0 else 0.0
    return 0.5 / drag if drag > 0.0 else np.inf  # (1/2)^(ORDER + 1) over its factorial is far below rounding


@kernel
def _begin_path(x, v, q, acceleration, drag, x_series, q_series, bounds):
    """Path of a body that keeps its attitude, and bounds of what it can do; returns for how long they hold [s]."""
    span = _path_series(x, v, acceleration, drag, x_series)
    for c in range(4):
        q_series[0, c] = q[c]
        for k in range(1, ORDER + 1):
            q_series[k, c] = 0.0
    bounds[3] = bounds[4] = bounds[5] = 0.0
    for c in range(3):
        bounds[c] = 2.0 * x_series[2, c]
    if drag > 0.0:
        bounds[3] = 2.0 * drag * span * (norm(acceleration) + drag * norm(v))
    return span


@kernel
def free_flight(
    x, v, q, momentum, acceleration, drag, moments, frame, quickness, unevenness, turns,
    x_series, q_series, spin_series, kept, bounds
):  # fmt: skip
    """Polynomials of free flight of one body, bounds of what it can do meanwhile, and how long they hold [s].

    `turns` is False for a body whose attitude needs no series: it does not turn, or looks the same from all sides.
    """
    span = _begin_path(x, v, q, acceleration, drag, x_series, q_series, bounds)
    if not turns or norm(momentum) == 0.0:
        return span
    _begin_spin(q, momentum, moments, frame, q_series, spin_series, kept)
    fastest = _fastest(spin_series[0], moments, quickness)
    bounds[4] = fastest
    # ω₁' = c₁ ω₂ ω₃ with |c| <= unevenness, and Σ ω₂² ω₃² <= |ω|⁴ / 3
    bounds[5] = unevenness * fastest * fastest / math.sqrt(3.0)
    return min(span, _spin_series(moments, frame, spin_series, q_series))


@kernel
def _fastest(w, moments, quickness):
    """Greatest angular velocity of a free body that now turns at w in its principal axes [rad/s].

    With p = 1 / smallest moment: |ω| <= p |L| and |ω|² <= 2 p energy.
    """
    square = energy = 0.0
    for c in range(3):
        square += moments[c] * w[c] * moments[c] * w[c]
        energy += moments[c] * w[c] * w[c]
    return min(quickness * math.sqrt(square), math.sqrt(energy * quickness))


@kernel
def continued_flight(s, x, v, q, momentum, acceleration, drag, moments, frame, x_series, q_series, spin_series, kept,
                     bounds):  # fmt: skip
    """Polynomials of a free flight from s [s] in its segment on, and how long they hold [s]; also writes x, v and q.

    A body that turns keeps what it has kept since `free_flight`: nothing drifts, whatever the number of segments.
    """
    place(s, x_series, x, v)
    if bounds[4] == 0.0:
        for c in range(4):
            q[c] = q_series[0, c]
        return _begin_path(x, v, q, acceleration, drag, x_series, q_series, bounds)
    span = _path_series(x, v, acceleration, drag, x_series)
    for c in range(3):
        bounds[c] = 2.0 * x_series[2, c]
    if drag > 0.0:
        bounds[3] = 2.0 * drag * span * (norm(acceleration) + drag * norm(v))
    _ends(s, q_series)
    _ends(s, spin_series)
    if frame[0] != 1.0:
        _compose(q_series[0], frame[0], frame[1], frame[2], frame[3])
    _keep(spin_series[0], moments, kept)
    _align(q_series[0], spin_series[0], moments, momentum)
    span = min(span, _spin_series(moments, frame, spin_series, q_series))
    for c in range(4):
        q[c] = q_series[0, c]
    return span


@kernel
def _ends(s, series):
    """Replace the first coefficients of a series by its value at s."""
    for c in range(series.shape[1]):
        p = series[ORDER, c]
        for k in range(ORDER - 1, -1, -1):
            p = p * s + series[k, c]
        series[0, c] = p


@kernel
def driven_flight(x, v, q, momentum, acceleration, drag, inverse, quickness, torque, lever, damping, x_series, q_series,
                  bounds):  # fmt: skip
    """As `free_flight`, for a body on which a torque acts: see `_driven_series`."""
    span = _begin_path(x, v, q, acceleration, drag, x_series, q_series, bounds)
    span = min(span, _driven_series(q, momentum, inverse, torque, lever, damping, q_series))
    load = norm(torque) + norm(lever[0]) + norm(lever[1]) + norm(lever[2])
    most = norm(momentum) + (load * span if load > 0.0 else 0.0)
    fastest = quickness * most
    bounds[4] = fastest
    bounds[5] = quickness * (load + damping * fastest + fastest * most)  # ω' = I⁻¹ (torque - ω × L)
    return span


@kernel
def order(series):
    """Order of a polynomial of free flight or of lasting contact: two, five, or all there is."""
    top = 2
    for c in range(series.shape[1]):
        if series[6, c] != 0.0 or series[7, c] != 0.0:
            return ORDER
        if series[3, c] != 0.0 or series[4, c] != 0.0 or series[5, c] != 0.0:
            top = 5
    return top


@kernel
def place(s, x_series, x, v):
    """Position and velocity s seconds into a segment, into the arrays given."""
    top = order(x_series)
    for c in range(3):
        p = x_series[top, c]
        d = 0.0
        for k in range(top - 1, -1, -1):
            d = d * s + p
            p = p * s + x_series[k, c]
        x[c] = p
        v[c] = d


@kernel
def attitude(s, q_series):
    """Quaternion (4 numbers, of about unit length) and its rate (4 numbers) s seconds into a segment."""
    top = order(q_series)
    a, b, c, d = q_series[top, 0], q_series[top, 1], q_series[top, 2], q_series[top, 3]
    da = db = dc = dd = 0.0
    for k in range(top - 1, -1, -1):
        da, db, dc, dd = da * s + a, db * s + b, dc * s + c, dd * s + d
        a, b, c, d = a * s + q_series[k, 0], b * s + q_series[k, 1], c * s + q_series[k, 2], d * s + q_series[k, 3]
    return a, b, c, d, da, db, dc, dd


@kernel
def where(s, x_series, q_series, x, v, q, rate):
    """Position, velocity, quaternion and its rate s seconds into one body's segment, into the arrays given."""
    place(s, x_series, x, v)
    q[0], q[1], q[2], q[3], rate[0], rate[1], rate[2], rate[3] = attitude(s, q_series)


@kernel
def carry(t, plain, inverse_inertia, x, v, q, momentum, begin, x_series, q_series):
    """Set position, velocity and attitude of every body to what its polynomials say at time t.

    A `plain` body in flight turns at a constant angular velocity and its attitude is exact.  A path whose terms of
    order three to five are zero is a parabola: drag has them all, and motion in lasting contact has no others.
    """
    for i in range(len(x)):
        s = t - begin[i]
        parabolic = True
        for c in range(3):
            if x_series[i, 3, c] != 0.0 or x_series[i, 4, c] != 0.0 or x_series[i, 5, c] != 0.0:
                parabolic = False
        top = 2 if parabolic else ORDER
        for c in range(3):
            p = x_series[i, top, c]
            d = 0.0
            for k in range(top - 1, -1, -1):
                d = d * s + p
                p = p * s + x_series[i, k, c]
            x[i, c] = p
            v[i, c] = d
        still = True
        for c in range(4):
            q[i, c] = q_series[i, 0, c]
            still = still and q_series[i, 1, c] == 0.0 and q_series[i, 2, c] == 0.0
        if plain[i] and still:  # friction that lasts turns a sphere as polynomials say
            angle = apply(inverse_inertia[i], momentum[i])
            for c in range(3):
                angle[c] *= s
            now = turned(q_series[i, 0], angle)
            for c in range(4):  # not q[i] = now: numba compiles all of its words for shapes that differ
                q[i, c] = now[c]
            continue
        if still or s == 0.0:
            continue
        a, b, f, g = q_series[i, ORDER]
        for k in range(ORDER - 1, -1, -1):
            a = a * s + q_series[i, k, 0]
            b = b * s + q_series[i, k, 1]
            f = f * s + q_series[i, k, 2]
            g = g * s + q_series[i, k, 3]
        size = math.sqrt(a * a + b * b + f * f + g * g)
        q[i, 0], q[i, 1], q[i, 2], q[i, 3] = a / size, b / size, f / size, g / size


@kernel
def fly_on(t, free, x, v, q, momentum, acceleration, drag, moments, frame, begin, end, start, x_series, q_series,
           spin_series, kept, bounds):  # fmt: skip
    """Continue the flights of the bodies `free` that end by time t, each at its own time, until all last beyond t.

    Returns the number of a body whose series last no time at all, or -1.
    """
    for i in range(len(free)):
        while free[i] and end[i] <= t:
            s = end[i] - begin[i]
            for c in range(3):
                start[i, c] = momentum[i, c]
            begin[i] = end[i]
            end[i] += continued_flight(
                s, x[i], v[i], q[i], momentum[i], acceleration[i], drag[i], moments[i], frame[i], x_series[i],
                q_series[i], spin_series[i], kept[i], bounds[i],
            )  # fmt: skip
            if not end[i] > begin[i]:
                return i
    return -1


@kernel
def spins(q, inverse_inertia, momentum, w):
    """Angular velocities R I⁻¹ Rᵀ L of all bodies into `w` (n, 3) [rad/s]."""
    body = np.empty(3)
    turn = np.empty(3)
    for i in range(len(q)):
        l = momentum[i]
        if l[0] == 0.0 and l[1] == 0.0 and l[2] == 0.0:
            w[i, 0] = w[i, 1] = w[i, 2] = 0.0
            continue
        a, b, f, g = q[i]
        s = 2.0 / (a * a + b * b + f * f + g * g)
        xx, yy, zz = 1.0 - s * (f * f + g * g), 1.0 - s * (b * b + g * g), 1.0 - s * (b * b + f * f)
        xy, yx = s * (b * f - a * g), s * (b * f + a * g)
        xz, zx = s * (b * g + a * f), s * (b * g - a * f)
        yz, zy = s * (f * g - a * b), s * (f * g + a * b)
        body[0] = xx * l[0] + yx * l[1] + zx * l[2]
        body[1] = xy * l[0] + yy * l[1] + zy * l[2]
        body[2] = xz * l[0] + yz * l[1] + zz * l[2]
        for c in range(3):
            turn[c] = (
                inverse_inertia[i, c, 0] * body[0]
                + inverse_inertia[i, c, 1] * body[1]
                + inverse_inertia[i, c, 2] * body[2]
            )
        w[i, 0] = xx * turn[0] + xy * turn[1] + xz * turn[2]
        w[i, 1] = yx * turn[0] + yy * turn[1] + yz * turn[2]
        w[i, 2] = zx * turn[0] + zy * turn[1] + zz * turn[2]


@kernel
def driven_momentum(s, inertia, x_series, q_series):
    """World angular momentum of a body on which a torque acts, s seconds into its segment [kg m2/s]."""
    x, v, q, rate = np.empty(3), np.empty(3), np.empty(4), np.empty(4)
    where(s, x_series, q_series, x, v, q, rate)
    rotation = matrix(q)
    return apply(rotation, apply(inertia, apply_transposed(rotation, angular_velocity(q, rate))))
