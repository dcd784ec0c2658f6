"""Pairs of bodies that may touch, and until when their bounding spheres keep them apart."""

from __future__ import annotations

import numpy as np

from mechanics.effects import Hinge, Rod
from mechanics.scene import Scene
from reference_impl.kernels import kernel, norm
from reference_impl.state import ORDER, PLANE
from reference_impl.time_of_contact import parabola

MANY = 100  # pairs from which on the bounds are looked at for all pairs at once
STEPS = 50  # of the advancement of one pair in one call
NEAR = 1e-3  # distance of the bounds below which the bodies themselves are looked at [sum of the radii]


def all_pairs(scene: Scene) -> np.ndarray:
    """Places (i < j) of the bodies that may touch, (p, 2): `Scene.pairs` for thousands of bodies."""
    n = len(scene.bodies)
    if not scene.touching:
        return np.zeros((0, 2), dtype=np.int64)
    i, j = np.triu_indices(n, 1)
    fixed = np.array([body.fixed for body in scene.bodies])
    keep = ~(fixed[i] & fixed[j])
    for kind in (Rod, Hinge):
        for joint in scene.all(kind):
            low, high = sorted((scene.index(joint.a), scene.index(joint.b)))
            keep[low * n - low * (low + 1) // 2 + high - low - 1] = False
    return np.column_stack([i[keep], j[keep]])


@kernel
def _at(t, begin, series, x, v):
    """Position and velocity on a path at time t."""
    s = t - begin
    for c in range(3):
        p, d = series[ORDER, c], 0.0
        for k in range(ORDER - 1, -1, -1):
            d = d * s + p
            p = p * s + series[k, c]
        x[c], v[c] = p, d


@kernel
def keep_apart(pairs, clear, hits, skip, static, shape, normal, reach, begin, end, x_series, bounds, limit, ahead):
    """Put off the times `clear` until which pairs cannot touch, as far as their bounding spheres tell.

    Pairs that are clear until `limit`, that hit, or that are to be skipped are left as they are; pairs of bodies
    that are static never touch.  Along the line of centres the gap of the spheres has |gap''| bounded by the
    relative acceleration, as in `time_of_contact`; a half-space is its own bound.  No pair is put off beyond
    the end of a segment, nor by more than `ahead` [s].
    """
    xa, va, xb, vb, r, v = np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    for p in range(len(pairs)):
        if clear[p] >= limit or hits[p] or skip[p]:
            continue
        a, b = pairs[p, 0], pairs[p, 1]
        if static[a] and static[b]:
            clear[p] = np.inf
            continue
        for c in range(3):
            r[c] = bounds[a, c] - bounds[b, c]
        pull = norm(r) + bounds[a, 3] + bounds[b, 3]
        last = min(end[a], end[b], clear[p] + ahead)
        room = reach[a] if shape[b] == PLANE else reach[a] + reach[b]
        for _ in range(STEPS):
            _at(clear[p], begin[a], x_series[a], xa, va)
            _at(clear[p], begin[b], x_series[b], xb, vb)
            gap = rate = 0.0
            if shape[b] == PLANE:
                for c in range(3):
                    gap += normal[b, c] * (xa[c] - xb[c])
                    rate += normal[b, c] * (va[c] - vb[c])
            else:
                for c in range(3):
                    r[c], v[c] = xa[c] - xb[c], va[c] - vb[c]
                    rate += r[c] * v[c]
                gap = norm(r)
                rate /= gap
            gap -= room
            if not gap > NEAR * room:
                break
            clear[p] = min(clear[p] + parabola(gap, rate, -pull), last)
            if clear[p] >= last:
                break
