"""Contact features and how their gap changes.

A contact joins a feature of body a with a feature of body b and belongs to one of seven kinds:

    FACE    a point of a, widened by a radius, on a plane of b
    EDGES   an edge of a crossing an edge of b, both widened by radii
    POINT   a point of a at a point of b, widened by the sum of the radii
    LINE    a point of a, widened by a radius, at an edge of b
    RIM     a circle of a on a plane of b
    RING    a point of a, widened by a radius, at a circle of b
    CORD    a point of a held by a string to a point of b: the gap is the slack (`effects.tether`)

The unit normal n points from b to a and the gap is negative in overlap.  Along any motion

    gap'  = J·(velocities)                 (negative: the bodies approach)
    gap'' = J·(accelerations) + bias       (bias: everything the velocities alone bring)

with J = (n, r_a × n, -n, -r_b × n) for arms r from the centres of mass to the contact point.

Whole numbers of a contact: a, b, kind, id of the feature of a, id of the feature of b.  Numbers:
point (3) and direction (3) in the frame of a, point (3) and direction (3) in the frame of b
(direction = edge through the point, its middle; or outward normal of the face; or axis of the circle
around the point), sum of the radii, radius of a.  The edges of EDGES are directed so that a × b points
from b to a.  For RIM the radius of a is that of the circle; for RING the radius of the circle of b stands
in place of the direction in a, which a point has not.  For CORD the length stands in place of the sum of the radii.
"""

from __future__ import annotations

import math

import numpy as np

from reference_impl.collide.rims import point_at_rim, rim_on_plane
from reference_impl.kernels import along, apply, cross, dot, kernel, minus, norm

FACE, EDGES, POINT, LINE, RIM, RING, CORD = 0, 1, 2, 3, 4, 5, 6
WHOLE, REAL = 5, 14


@kernel
def kinematics(kinds, reals, xa, ra, va, wa, xb, rb, vb, wb, n, point):
    """Gap [m], its rate [m/s] and bias [m/s2] of one contact; writes unit normal and contact point (world).

    Parameters
    ----------
    kinds, reals : arrays
        The contact (see the module's text).
    xa, ra, va, wa : position (3,), rotation matrix (3, 3), velocity and angular velocity of body a
    xb, rb, vb, wb : the same of body b
    n, point : (3,) arrays, written
    """
    kind = kinds[2]
    radius = reals[12]
    arm_a = apply(ra, reals[0:3])
    arm_b = apply(rb, reals[6:9])
    r = np.empty(3)  # from b's point to a's
    dr = np.empty(3)  # its rate
    spin_a, spin_b = cross(wa, arm_a), cross(wb, arm_b)
    for c in range(3):
        r[c] = xa[c] - xb[c] + arm_a[c] - arm_b[c]
        dr[c] = va[c] - vb[c] + spin_a[c] - spin_b[c]
    ddr = minus(cross(wa, spin_a), cross(wb, spin_b))  # its second rate without accelerations
    if kind == EDGES:
        return _crossing(reals, ra, wa, rb, wb, xb, arm_b, r, dr, ddr, n, point)
    if kind == RIM:
        return rim_on_plane(reals, ra, wa, rb, wb, xa, arm_a, r, dr, ddr, n, point)
    if kind == RING:
        distance, rate, bias = point_at_rim(reals, rb, wb, r, dr, ddr, n, spin_b)
    elif kind == FACE:
        distance, rate, bias = _over_face(reals, rb, wb, r, dr, ddr, n)
    elif kind == LINE:
        distance, rate, bias = _beside_edge(reals, rb, wb, r, dr, ddr, n)
    else:
        distance, rate, bias = _from_point(r, dr, ddr, n)
    inner = radius if kind == FACE else reals[13]
    for c in range(3):
        point[c] = xa[c] + arm_a[c] - inner * n[c]
    if kind == CORD:  # the same connection seen from within
        for c in range(3):
            n[c] = -n[c]
        return radius - distance, -rate, -bias
    return distance - radius, rate, bias


@kernel
def _over_face(reals, rb, wb, r, dr, ddr, n):
    """Height of a's point at r over a plane of b, its rate and bias; writes the plane's normal."""
    normal = apply(rb, reals[9:12])
    dn = cross(wb, normal)
    ddn = cross(wb, dn)
    for c in range(3):
        n[c] = normal[c]
    bias = dot(normal, ddr) + 2.0 * dot(dn, dr) + dot(ddn, r)
    return dot(normal, r), dot(normal, dr) + dot(dn, r), bias


@kernel
def _beside_edge(reals, rb, wb, r, dr, ddr, n):
    """Distance of a's point at r from an edge e of b, its rate and bias; writes the direction across e."""
    e = apply(rb, reals[9:12])
    de = cross(wb, e)
    dde = cross(wb, de)
    s = dot(r, e)
    ds = dot(dr, e) + dot(r, de)
    m = along(r, -s, e)
    dm = along(dr, -s, de)  # without s' e, which is across the normal
    ddm = along(along(ddr, -s, dde), -ds, de)
    distance = norm(m)
    for c in range(3):
        n[c] = m[c] / distance
    rate = dot(n, dm)
    true = along(dm, -ds, e)  # whole rate of m, for the rate of the normal
    dn = np.empty(3)
    for c in range(3):
        dn[c] = (true[c] - n[c] * rate) / distance
    return distance, rate, dot(n, ddm) + dot(dn, dm)


@kernel
def _from_point(r, dr, ddr, n):
    """Length of r, its rate and bias; writes its direction."""
    distance = norm(r)
    for c in range(3):
        n[c] = r[c] / distance
    rate = dot(n, dr)
    return distance, rate, dot(n, ddr) + (dot(dr, dr) - rate * rate) / distance


@kernel
def _crossing(reals, ra, wa, rb, wb, xb, arm_b, r, dr, ddr, n, point):
    """Gap, rate and bias of two crossing edges: n ∝ a × b, gap = n·r less the radii.

    With the nearest points P_a = p_a + s a and P_b = p_b + t b, the rate is n·(r' + s a' - t b'),
    because n is perpendicular to both edges.
    """
    a, b = apply(ra, reals[3:6]), apply(rb, reals[9:12])
    da, db = cross(wa, a), cross(wb, b)
    dda, ddb = cross(wa, da), cross(wb, db)
    c = cross(a, b)
    size = norm(c)
    for k in range(3):
        n[k] = c[k] / size
    gap = dot(n, r)
    # the dual basis of (a, b) in their plane: pa·a = 1, pa·b = 0, pb·b = 1, pb·a = 0
    pa, pb = cross(b, n), cross(n, a)
    scale_a, scale_b = dot(pa, a), dot(pb, b)
    for k in range(3):
        pa[k] /= scale_a
        pb[k] /= scale_b
    s, t = -dot(pa, r), dot(pb, r)  # r + s a - t b = gap n
    near = np.empty(3)
    for k in range(3):
        near[k] = dr[k] + s * da[k] - t * db[k]
    rate = dot(n, near)
    na, nb = dot(n, da), dot(n, db)
    dn = np.empty(3)
    for k in range(3):
        dn[k] = -na * pa[k] - nb * pb[k]
    # r' + s' a + s a' - t' b - t b' = gap' n + gap n'
    slide = np.empty(3)
    for k in range(3):
        slide[k] = near[k] - rate * n[k] - gap * dn[k]
    ds, dt = -dot(pa, slide), dot(pb, slide)
    bias = dot(dn, near)
    for k in range(3):
        bias += n[k] * (ddr[k] + ds * da[k] + s * dda[k] - dt * db[k] - t * ddb[k])
        point[k] = xb[k] + arm_b[k] + t * b[k] + (reals[12] - reals[13]) * n[k]
    return gap - reals[12], rate, bias


@kernel
def all_kinematics(kinds, reals, x, rotation, v, w, n, point, gap, rate, bias):
    """`kinematics` of every contact; rows of the outputs belong to rows of `kinds`."""
    for k in range(len(kinds)):
        a, b = kinds[k, 0], kinds[k, 1]
        gap[k], rate[k], bias[k] = kinematics(
            kinds[k], reals[k], x[a], rotation[a], v[a], w[a], x[b], rotation[b], v[b], w[b], n[k], point[k]
        )


@kernel
def rows(kinds, n, point, x, rotation, root, inverse_mass, radius, place, out):
    """Scaled contact rows G = J M^-1/2 into `out` (contacts, 6 per moving body).

    `place[i]` is the number of body i among the moving ones, or -1.  In these coordinates a motion is
    (√m v, Bᵀ Rᵀ L) with B Bᵀ = I⁻¹, so no inverse of an inertia is needed where nothing turns.  The normal
    at a sphere (`radius` > 0) passes through its centre and turns nothing, not even by rounding.
    """
    for k in range(len(kinds)):
        for c in range(out.shape[1]):
            out[k, c] = 0.0
        for side in range(2):
            i = kinds[k, side]
            at = place[i]
            if at < 0:
                continue
            sign = 1.0 if side == 0 else -1.0
            lever = np.zeros(3)
            if radius[i] == 0.0 or kinds[k, 2] == CORD:
                lever = cross(minus(point[k], x[i]), n[k])
            body = np.empty(3)
            for c in range(3):
                body[c] = rotation[i, 0, c] * lever[0] + rotation[i, 1, c] * lever[1] + rotation[i, 2, c] * lever[2]
            for c in range(3):
                out[k, 6 * at + c] = sign * n[k, c] * math.sqrt(inverse_mass[i])
                turn = root[i, 0, c] * body[0] + root[i, 1, c] * body[1] + root[i, 2, c] * body[2]
                out[k, 6 * at + 3 + c] = sign * turn


@kernel
def margin(kinds, reals, xa, ra, xb, rb, half_a, half_b):
    """How far inside its features a contact lies [m]; negative once the features no longer face each other."""
    kind = kinds[2]
    arm_a, arm_b = apply(ra, reals[0:3]), apply(rb, reals[6:9])
    r = np.empty(3)
    for c in range(3):
        r[c] = xa[c] - xb[c] + arm_a[c] - arm_b[c]
    if kind == EDGES:
        a, b = apply(ra, reals[3:6]), apply(rb, reals[9:12])
        n = cross(a, b)
        square = dot(n, n)
        s = -dot(cross(b, n), r) / square
        t = dot(cross(n, a), r) / square
        length_a = abs(reals[3] * half_a[0]) + abs(reals[4] * half_a[1]) + abs(reals[5] * half_a[2])
        length_b = abs(reals[9] * half_b[0]) + abs(reals[10] * half_b[1]) + abs(reals[11] * half_b[2])
        return min(length_a - abs(s), length_b - abs(t))
    if half_b[0] == 0.0:
        return np.inf  # a plane or a sphere has no boundary
    local = np.empty(3)
    for c in range(3):
        local[c] = rb[0, c] * (xa[0] + arm_a[0] - xb[0]) + rb[1, c] * (xa[1] + arm_a[1] - xb[1])
        local[c] += rb[2, c] * (xa[2] + arm_a[2] - xb[2])
    out = np.inf
    for c in range(3):
        # free: the direction along which the feature of b extends
        free = reals[9 + c] == 0.0 if kind == FACE else (kind == LINE and reals[9 + c] != 0.0)
        if free:
            out = min(out, half_b[c] - abs(local[c]))
        elif kind != FACE:
            out = min(out, abs(local[c]) - half_b[c])
    return out
