"""Touching features of cylinders: over a half-space, and with a sphere.

A cylinder that is tilted touches a half-space with the lowest point of a rim, one that lies on its side with
those of both rims.  One that stands on its base touches with a disc: four of its border's points stand for it,
the first of them in the direction in which the body is pulled along the surface, so that it tips over where it
would.  (What the disc can carry beyond these four, by leaning between two of them, is 30 % of its radius.)
"""

from __future__ import annotations

import math

import numpy as np

from reference_impl.collide.features import FACE, LINE, RIM, RING
from reference_impl.collide.primitives import put
from reference_impl.kernels import apply_transposed, cross, dot, kernel, norm


@kernel
def cylinder_plane(a, b, xa, ra, ring, half, xb, normal, local, pull, reach, kinds, reals, count):
    """Cylinder a over half-space b with world normal `normal`, `local` in the frame of b.

    `pull` [m/s2] is the acceleration of a relative to b by the loads.
    """
    body = apply_transposed(ra, normal)
    slope = math.sqrt(body[0] * body[0] + body[1] * body[1])
    height = dot(normal, xa - xb)
    for end in range(2):
        side = half if end else -half
        gap = height + side * body[2] - ring * slope
        if gap > reach:
            continue
        if gap + 2.0 * ring * slope <= reach:
            count = _base(a, b, ra, ring, side, normal, local, pull, end, kinds, reals, count)
            continue
        put(kinds, reals, count, a, b, RIM, end, 0)
        reals[count, 2], reals[count, 5] = side, 1.0
        for c in range(3):
            reals[count, 9 + c] = local[c]
        reals[count, 12] = reals[count, 13] = ring
        count += 1
    return count


@kernel
def _base(a, b, ra, ring, side, normal, local, pull, end, kinds, reals, count):
    """Four points of the border of a base that lies flat."""
    along = dot(pull, normal)
    way = pull - along * normal
    if norm(way) <= 1e-12 * abs(along):
        for c in range(3):
            way[c] = ra[c, 0]
    first = apply_transposed(ra, way)
    first[2] = 0.0
    first /= norm(first)
    up = np.zeros(3)
    up[2] = 1.0
    second = cross(up, first)
    for k in range(4):
        put(kinds, reals, count, a, b, FACE, 4 * end + k, 0)
        sign = ring if k < 2 else -ring
        for c in range(3):
            reals[count, c] = sign * (first[c] if k % 2 == 0 else second[c])
            reals[count, 9 + c] = local[c]
        reals[count, 2] = side
        count += 1
    return count


@kernel
def sphere_cylinder(a, b, xa, xb, rb, radius, ring, half, reach, kinds, reals, count):
    """Sphere a at the side, a base or a rim of cylinder b."""
    local = apply_transposed(rb, xa - xb)
    rho = math.sqrt(local[0] * local[0] + local[1] * local[1])
    wide, high = rho - ring, abs(local[2]) - half
    end = 1 if local[2] > 0.0 else 0
    side = half if end else -half
    if wide > 0.0 and high > 0.0:
        if math.sqrt(wide * wide + high * high) - radius > reach:
            return count
        put(kinds, reals, count, a, b, RING, 0, end)
        reals[count, 3], reals[count, 8], reals[count, 11], reals[count, 12] = ring, side, 1.0, radius
    elif wide > high:
        if wide - radius > reach:
            return count
        put(kinds, reals, count, a, b, LINE, 0, 2)
        reals[count, 11], reals[count, 12] = 1.0, ring + radius
    else:
        if high - radius > reach:
            return count
        put(kinds, reals, count, a, b, FACE, 0, end)
        reals[count, 8], reals[count, 11], reals[count, 12] = side, 1.0 if end else -1.0, radius
    reals[count, 13] = radius
    return count + 1


@kernel
def cylinder_margin(kind, local, ring, half):
    """How far inside its feature of a cylinder a sphere's centre lies, `local` in the cylinder's frame [m]."""
    wide = math.sqrt(local[0] * local[0] + local[1] * local[1]) - ring
    high = abs(local[2]) - half
    if kind == FACE:
        return -wide
    if kind == LINE:
        return -high
    return min(wide, high)
