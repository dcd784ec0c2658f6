"""How the gap of circles changes: the rim of a cylinder on a plane, and a point at such a rim.

Both belong to `features`, whose text tells the layout of a contact.  Where a rim touches a plane the
touching point travels along the rim, and gap'' holds more than the acceleration of one material point.
"""

from __future__ import annotations

import math

import numpy as np

from reference_impl.kernels import apply, cross, dot, kernel, norm


@kernel
def rim_on_plane(reals, ra, wa, rb, wb, xa, arm_a, r, dr, ddr, n, point):
    """Gap, rate and bias of the lowest point of a circle of a over a plane of b with normal n.

    With the circle's centre at r from the plane's point, its axis u and y = n·u the gap is n·r - R s,
    s = sqrt(1 - y²) = |n × u|, and s s' = -y y'.
    """
    u, normal = apply(ra, reals[3:6]), apply(rb, reals[9:12])
    du, dn = cross(wa, u), cross(wb, normal)
    ddu, ddn = cross(wa, du), cross(wb, dn)
    radius = reals[13]
    y = dot(normal, u)
    dy = dot(dn, u) + dot(normal, du)
    ddy = dot(ddn, u) + 2.0 * dot(dn, du) + dot(normal, ddu)
    s = norm(cross(normal, u))
    ds = -y * dy / s
    dds = -(dy * dy + y * ddy + ds * ds) / s
    for c in range(3):
        n[c] = normal[c]
        point[c] = xa[c] + arm_a[c] - radius * (normal[c] - y * u[c]) / s
    gap = dot(normal, r) - radius * s
    rate = dot(normal, dr) + dot(dn, r) - radius * ds
    return gap, rate, dot(normal, ddr) + 2.0 * dot(dn, dr) + dot(ddn, r) - radius * dds


@kernel
def rim_travel(reals, ra, wa, rb, wb, va, spin_a, n):
    """Velocity of the point at which such a circle is lowest, as it travels along the circle [m/s]."""
    u = apply(ra, reals[3:6])
    du, dn = cross(wa, u), cross(wb, n)
    y = dot(n, u)
    dy = dot(dn, u) + dot(n, du)
    s = norm(cross(n, u))
    ds = -y * dy / s
    out = np.empty(3)
    for c in range(3):
        down = (n[c] - y * u[c]) / s
        out[c] = va[c] + spin_a[c] - reals[13] * (dn[c] - dy * u[c] - y * du[c] - ds * down) / s
    return out


@kernel
def point_at_rim(reals, rb, wb, r, dr, ddr, n, dn):
    """Distance of a point from a circle of b, its rate and bias; writes the direction from the circle and its rate.

    With the height h = r·e over the circle's plane and the distance ρ from its axis e, D² = (ρ - R)² + h².
    """
    e = apply(rb, reals[9:12])
    de = cross(wb, e)
    dde = cross(wb, de)
    ring = reals[3]
    h = dot(r, e)
    dh = dot(dr, e) + dot(r, de)
    ddh = dot(ddr, e) + 2.0 * dot(dr, de) + dot(r, dde)
    out = np.empty(3)
    for c in range(3):
        out[c] = r[c] - h * e[c]
    rho = norm(out)
    drho = (dot(r, dr) - h * dh) / rho
    wide = rho - ring
    distance = math.sqrt(wide * wide + h * h)
    rate = (wide * drho + h * dh) / distance
    # ρ'² + ρ ρ'' and D'² + D D'' from the squares
    ddrho = (dot(dr, dr) + dot(r, ddr) - dh * dh - h * ddh - drho * drho) / rho
    bias = (drho * drho + wide * ddrho + dh * dh + h * ddh - rate * rate) / distance
    for c in range(3):
        outward = out[c] / rho
        n[c] = (r[c] - ring * outward) / distance
        slope = (dr[c] - dh * e[c] - h * de[c] - drho * outward) / rho
        dn[c] = (dr[c] - ring * slope - rate * n[c]) / distance
    return distance, rate, bias
