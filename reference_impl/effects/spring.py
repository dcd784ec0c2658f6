"""Springs and dampers in line between two anchors: loads that follow the motion.

With r from the anchor of b to that of a, d = |r| and u = r / d the force on a is

    F = -(k (d - l) + c d') u

and its opposite acts on b.  A spring of no length without damping is F = -k r and needs no direction.  Any other has
none where its anchors meet: there it pulls nowhere, and a scene that begins so is refused.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from mechanics.effects import Spring
from mechanics.rotation import rotate
from mechanics.scene import Scene
from reference_impl.errors import Unsupported
from reference_impl.kernels import apply, apply_transposed, cross, dot, kernel, norm
from reference_impl.parts import Parts

REAL = 9


class Springs(NamedTuple):
    """Springs between bodies."""

    ends: np.ndarray  # (s, 2) bodies a and b
    reals: np.ndarray  # (s, 9) anchor of a, anchor of b (body frames) [m], stiffness [N/m], length [m], damping [N s/m]

    def chosen(self, which: np.ndarray) -> Springs:
        """The springs selected by a boolean or index array."""
        return Springs(self.ends[which], self.reals[which])


def parts(scene: Scene, effect: Spring) -> Parts:
    """One spring; none that has neither stiffness nor damping, or no body to move.

    Raises
    ------
    Unsupported
        If its anchors coincide at the start and it needs a direction.
    """
    ends = (scene.index(effect.a), scene.index(effect.b))
    anchors = (effect.anchor_a, effect.anchor_b)
    places = [
        np.array(scene.bodies[i].position) + rotate(np.array(scene.bodies[i].orientation), np.array(anchor))
        for i, anchor in zip(ends, anchors, strict=True)
    ]
    directed = effect.damping > 0.0 or effect.stiffness * effect.length > 0.0
    if directed and not (places[0] - places[1]).any():
        raise Unsupported(f"Spring between {effect.a!r} and {effect.b!r}: its anchors coincide at the start; "
                          "allowed: anchors apart, or a spring of length 0 without damping")  # fmt: skip
    idle = effect.stiffness == 0.0 and effect.damping == 0.0
    if idle or all(scene.bodies[i].fixed for i in ends):
        return Parts()
    reals = np.array([[*effect.anchor_a, *effect.anchor_b, effect.stiffness, effect.length, effect.damping]])
    return Parts(springs=(Springs(np.array([ends], dtype=np.int64), reals),))


def all_of(parts: tuple[Springs, ...]) -> Springs:
    """Several springs as one array."""
    if not parts:
        return Springs(np.zeros((0, 2), dtype=np.int64), np.zeros((0, REAL)))
    return Springs(*(np.concatenate(arrays) for arrays in zip(*parts, strict=True)))


@kernel
def pull(ends, reals, x, rotation, v, w, root, inverse_mass, place, free):
    """Add what springs do to the scaled accelerations `free`; `place[i]` numbers the moving bodies, or is -1."""
    r, dr = np.empty(3), np.empty(3)
    for k in range(len(ends)):
        a, b = ends[k, 0], ends[k, 1]
        arm_a, arm_b = apply(rotation[a], reals[k, 0:3]), apply(rotation[b], reals[k, 3:6])
        spin_a, spin_b = cross(w[a], arm_a), cross(w[b], arm_b)
        for c in range(3):
            r[c] = (x[a, c] - x[b, c]) + (arm_a[c] - arm_b[c])
            dr[c] = (v[a, c] - v[b, c]) + (spin_a[c] - spin_b[c])
        distance = norm(r)
        stiffness, length, damping = reals[k, 6], reals[k, 7], reals[k, 8]
        share = stiffness  # of the force along r
        if distance > 0.0:
            share += (damping * dot(r, dr) / distance - stiffness * length) / distance
        elif length > 0.0:
            share = 0.0
        for side in range(2):
            i = a if side == 0 else b
            at = place[i]
            if at < 0:
                continue
            sign = -share if side == 0 else share
            lever = cross(arm_a if side == 0 else arm_b, r)
            turn = apply_transposed(root[i], apply_transposed(rotation[i], lever))
            for c in range(3):
                free[6 * at + c] += sign * r[c] * math.sqrt(inverse_mass[i])
                free[6 * at + 3 + c] += sign * turn[c]
