"""Touching features of spheres, boxes and half-spaces; box against box is in `boxes`.

Every function writes the contacts whose gap is at most `reach` into `kinds` and `reals` from row
`count` on and returns the new count.  The layout of a contact is told in `features`.  A contact of a
sphere and another body has the sphere as body a, one of a half-space has it as body b.
"""

from __future__ import annotations

import math

import numpy as np

from reference_impl.collide.features import FACE, LINE, POINT
from reference_impl.kernels import apply_transposed, dot, kernel


@kernel
def put(kinds, reals, count, a, b, kind, fa, fb):
    """Start contact number `count` with all numbers zero."""
    kinds[count, 0], kinds[count, 1], kinds[count, 2], kinds[count, 3], kinds[count, 4] = a, b, kind, fa, fb
    for c in range(reals.shape[1]):
        reals[count, c] = 0.0


@kernel
def sphere_sphere(a, b, xa, xb, radius_a, radius_b, reach, kinds, reals, count):
    """Two spheres: one contact at most."""
    square = (xa[0] - xb[0]) ** 2 + (xa[1] - xb[1]) ** 2 + (xa[2] - xb[2]) ** 2
    if math.sqrt(square) - radius_a - radius_b > reach:
        return count
    put(kinds, reals, count, a, b, POINT, 0, 0)
    reals[count, 12] = radius_a + radius_b
    reals[count, 13] = radius_a
    return count + 1


@kernel
def sphere_plane(a, b, xa, xb, radius, normal, local, reach, kinds, reals, count):
    """A sphere a over a half-space b with world normal `normal`, `local` in the frame of b."""
    height = normal[0] * (xa[0] - xb[0]) + normal[1] * (xa[1] - xb[1]) + normal[2] * (xa[2] - xb[2])
    if height - radius > reach:
        return count
    put(kinds, reals, count, a, b, FACE, 0, 0)
    for c in range(3):
        reals[count, 9 + c] = local[c]
    reals[count, 12] = radius
    reals[count, 13] = radius
    return count + 1


@kernel
def corner(half, j, out):
    """Corner j of a box in its own frame: bit c of j set = positive side of axis c."""
    for c in range(3):
        out[c] = half[c] if (j >> c) & 1 else -half[c]


@kernel
def corners_plane(a, b, xa, ra, corners, radius, xb, normal, local, reach, kinds, reals, count):
    """Corners of a, each widened by `radius`, at half-space b."""
    body = apply_transposed(ra, normal)
    height = normal[0] * (xa[0] - xb[0]) + normal[1] * (xa[1] - xb[1]) + normal[2] * (xa[2] - xb[2])
    for j in range(len(corners)):
        if height + dot(body, corners[j]) - radius > reach:
            continue
        put(kinds, reals, count, a, b, FACE, j, 0)
        for c in range(3):
            reals[count, c] = corners[j, c]
            reals[count, 9 + c] = local[c]
        reals[count, 12] = reals[count, 13] = radius
        count += 1
    return count


@kernel
def box_plane(a, b, xa, ra, half, xb, normal, local, reach, kinds, reals, count):
    """Corners of box a at half-space b."""
    corners = np.empty((8, 3))
    for j in range(8):
        corner(half, j, corners[j])
    return corners_plane(a, b, xa, ra, corners, 0.0, xb, normal, local, reach, kinds, reals, count)


@kernel
def sphere_box(a, b, xa, xb, rb, radius, half, reach, kinds, reals, count):
    """Sphere a at the nearest face, edge or corner of box b."""
    r = xa - xb
    local = apply_transposed(rb, r)
    beyond = 0
    square = 0.0
    for c in range(3):
        excess = abs(local[c]) - half[c]
        if excess > 0.0:
            beyond += 1
            square += excess * excess
    inside = beyond == 0
    face = 0
    if inside:  # centre within the box: through the nearest face
        for c in range(3):
            if abs(local[c]) - half[c] > abs(local[face]) - half[face]:
                face = c
        gap = abs(local[face]) - half[face] - radius
    else:
        gap = math.sqrt(square) - radius
    if gap > reach:
        return count
    put(kinds, reals, count, a, b, FACE, 0, 0)
    row = reals[count]
    row[12] = radius
    row[13] = radius
    for c in range(3):
        out = c == face if inside else abs(local[c]) > half[c]
        if out:
            row[6 + c] = half[c] if local[c] > 0.0 else -half[c]
    if inside or beyond == 1:
        for c in range(3):
            if row[6 + c] != 0.0:
                row[9 + c] = 1.0 if row[6 + c] > 0.0 else -1.0
                kinds[count, 4] = 2 * c + (1 if row[6 + c] > 0.0 else 0)
    elif beyond == 2:
        kinds[count, 2] = LINE
        for c in range(3):
            if row[6 + c] == 0.0:
                row[9 + c] = 1.0
    else:
        kinds[count, 2] = POINT
    return count + 1


@kernel
def near(x, shape, normal, reach, dirty, pairs, slack, out):
    """Numbers of the pairs with a dirty body whose bounding spheres come within `slack` into `out`; returns how many.

    A half-space is bounded by its own plane.
    """
    count = 0
    for p in range(len(pairs)):
        a, b = pairs[p, 0], pairs[p, 1]
        if not (dirty[a] or dirty[b]):
            continue
        r = x[a] - x[b]
        if shape[b] == 2:
            distance = dot(normal[b], r) - reach[a]
        elif shape[a] == 2:
            distance = -dot(normal[a], r) - reach[b]
        else:
            distance = math.sqrt(dot(r, r)) - reach[a] - reach[b]
        if distance <= slack:
            out[count] = p
            count += 1
    return count
