"""Joints that hold: rods and hinges, as rows J of the scaled motions (Baraff 1996, Linear-time dynamics, section 2).

A joint is a set of rows, each with a gap that is zero as long as it holds, and along any motion

    gap'  = J·(velocities)                 gap'' = J·(accelerations) + bias

with J = (n, l_a, -n, -l_b) for a direction n and levers l.  Rows belong to one of three kinds:

    ROD     the distance of two anchors less the length,  n along the anchors, l = r × n
    POINT   two anchors apart along a world direction n,  l = r × n
    AXIS    an axis s of a along a direction t of b, t·s; n = 0, l_a = l_b = s × t

A hinge is three POINT rows and two AXIS rows.  A rod whose anchors coincide holds them together: three POINT rows.

Contacts are put into the motions that joints leave free (`free_motions`).  With P the projection on these and x₀ the
least acceleration that satisfies the joints, every admissible acceleration is x = x₀ + P z, so that a contact has the
row G P, and its problem the free acceleration x₀ + P c (Gauss).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from mechanics.effects import Hinge, Rod, Rotation
from mechanics.rotation import rotate, unrotate
from mechanics.scene import Scene
from mechanics.shapes import bounding_radius
from reference_impl.errors import Unsupported
from reference_impl.kernels import apply, apply_transposed, cross, dot, kernel, norm
from reference_impl.parts import Parts

ROD, POINT, AXIS = 0, 1, 2
WHOLE, REAL = 4, 14
COINCIDE = 1e-12  # anchors closer than this are at one place [size of the bodies]
MOVES = 1e-9  # speed at the start at which a joint counts as violated [greatest speed there, or size per second]


class Joints(NamedTuple):
    """Rows of joints: whole numbers kind, a, b, number of the effect; lengths in metres."""

    kinds: np.ndarray  # (r, 4)
    reals: np.ndarray  # (r, 14) anchor of a, anchor of b (body frames); see `_row` for the rest
    size: np.ndarray  # (r,) what a gap is compared with: length of a rod, size of a hinge, 1 for angles

    def chosen(self, which: np.ndarray) -> Joints:
        """The rows selected by a boolean or index array."""
        return Joints(self.kinds[which], self.reals[which], self.size[which])


def all_of(parts: tuple[Joints, ...]) -> Joints:
    """The rows of several joints stacked, numbered by joint."""
    empty = Joints(np.zeros((0, WHOLE), dtype=np.int64), np.zeros((0, REAL)), np.zeros(0))
    rows = Joints(*(np.concatenate(arrays) for arrays in zip(empty, *parts, strict=True)))
    rows.kinds[:, 3] = np.repeat(np.arange(len(parts)), [len(part.kinds) for part in parts])
    return rows


def rod(scene: Scene, effect: Rod) -> Parts:
    """Rows of a rod.

    Raises
    ------
    Unsupported
        If its anchors part at the start.
    """
    ends = (scene.index(effect.a), scene.index(effect.b))
    anchors = (np.array(effect.anchor_a), np.array(effect.anchor_b))
    (xa, va), (xb, vb) = (_anchor(scene, i, p) for i, p in zip(ends, anchors, strict=True))
    r, size = xa - xb, _size(scene, ends, anchors)
    length = float(np.linalg.norm(r))
    if length <= COINCIDE * size:
        kinds, reals = _points(ends, anchors)
        return _checked(scene, effect, va - vb, Joints(kinds, reals, np.full(3, size)))
    kinds = np.array([[ROD, *ends, 0]], dtype=np.int64)
    reals = np.zeros((1, REAL))
    reals[0, 0:3], reals[0, 3:6], reals[0, 12] = *anchors, length
    return _checked(scene, effect, (r / length) * ((va - vb) @ (r / length)), Joints(kinds, reals, np.array([length])))


def hinge(scene: Scene, effect: Hinge) -> Parts:
    """Rows of a hinge; where neither body turns only those of its point.

    Raises
    ------
    Unsupported
        If the bodies part at its point, or turn against each other across its axis, at the start.
    """
    ends = (scene.index(effect.a), scene.index(effect.b))
    bodies = [scene.bodies[i] for i in ends]
    q = [np.array(body.orientation) for body in bodies]
    point, axis = np.array(effect.point), np.array(effect.axis)
    anchors = tuple(unrotate(p, point - np.array(body.position)) for p, body in zip(q, bodies, strict=True))
    (_, va), (_, vb) = (_anchor(scene, i, p) for i, p in zip(ends, anchors, strict=True))
    kinds, reals = _points(ends, anchors)
    size = np.full(3, _size(scene, ends, anchors))
    parting = va - vb
    if Rotation in scene.needs:
        kinds = np.concatenate([kinds, [[AXIS, *ends, 0]] * 2])
        turns = np.zeros((2, REAL))
        least = np.eye(3)[int(np.argmin(np.abs(axis)))]
        first = np.cross(axis, least) / np.linalg.norm(np.cross(axis, least))
        for row, t in zip(turns, (first, np.cross(axis, first)), strict=True):
            row[6:9], row[9:12] = unrotate(q[0], axis), unrotate(q[1], t)
        reals, size = np.concatenate([reals, turns]), np.concatenate([size, np.ones(2)])
        spin = np.subtract(bodies[0].angular_velocity, bodies[1].angular_velocity)
        parting = np.append(parting, (spin - axis * (spin @ axis)) * size[0])
    return _checked(scene, effect, parting, Joints(kinds, reals, size))


def _points(ends: tuple[int, int], anchors: tuple[np.ndarray, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Three rows that hold two anchors together, along the axes of the world."""
    kinds = np.array([[POINT, *ends, 0]] * 3, dtype=np.int64)
    reals = np.zeros((3, REAL))
    reals[:, 0:3], reals[:, 3:6], reals[:, 6:9] = *anchors, np.eye(3)
    return kinds, reals


def _anchor(scene: Scene, i: int, anchor: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Place and velocity of a body's anchor at the start, world frame."""
    body = scene.bodies[i]
    arm = rotate(np.array(body.orientation), anchor)
    return np.array(body.position) + arm, np.array(body.velocity) + np.cross(body.angular_velocity, arm)


def _size(scene: Scene, ends: tuple[int, int], anchors: tuple[np.ndarray, ...]) -> float:
    """Length to compare gaps with [m]: of the arms, of the smaller moving body, or what coordinates allow."""
    reach = min((bounding_radius(b.shape) for b in (scene.bodies[i] for i in ends) if not b.fixed), default=1.0)
    far = max(float(np.abs(scene.bodies[i].position).max()) for i in ends)
    return max(reach, 1e-3 * far, *(float(np.linalg.norm(a)) for a in anchors))


def _checked(scene: Scene, effect: Rod | Hinge, parting: np.ndarray, rows: Joints) -> Parts:
    """The rows, none between fixed bodies; a joint whose ends part at `parting` [m/s] at the start is refused."""
    bodies = [scene.body(name) for name in (effect.a, effect.b)]
    who = f"{type(effect).__name__} between {effect.a!r} and {effect.b!r}"
    fastest = max(float(np.linalg.norm(b.velocity) + np.linalg.norm(b.angular_velocity) * rows.size[0]) for b in bodies)
    speed = float(np.linalg.norm(parting))
    if speed > MOVES * (fastest or 1.0):
        raise Unsupported(f"{who}: its ends part at {speed:.6g} m/s at the start; allowed: 0")
    if bodies[0].fixed and bodies[1].fixed:
        if bodies[0].velocity != bodies[1].velocity or bodies[0].acceleration != bodies[1].acceleration:
            raise Unsupported(f"{who}: both are fixed and move against each other; allowed: one body with a mass")
        return Parts()
    return Parts(joints=(rows,))


@kernel
def joint_rows(kinds, reals, x, rotation, v, w, root, inverse_mass, acceleration, place, j, gap, rate, target):
    """`free_motions.Rows` of joints; `place[i]` is the number of body i among the moving ones, or -1."""
    for k in range(len(kinds)):
        a, b = kinds[k, 1], kinds[k, 2]
        n, lever_a, lever_b = np.zeros(3), np.zeros(3), np.zeros(3)
        gap[k], rate[k], target[k] = _row(kinds[k, 0], reals[k], x[a], rotation[a], v[a], w[a],
                                          x[b], rotation[b], v[b], w[b], n, lever_a, lever_b)  # fmt: skip
        for c in range(j.shape[1]):
            j[k, c] = 0.0
        for side in range(2):
            i = a if side == 0 else b
            sign = 1.0 if side == 0 else -1.0
            at = place[i]
            if at < 0:
                target[k] -= sign * dot(n, acceleration[i])
                continue
            turn = apply_transposed(root[i], apply_transposed(rotation[i], lever_a if side == 0 else lever_b))
            for c in range(3):
                j[k, 6 * at + c] = sign * n[c] * math.sqrt(inverse_mass[i])
                j[k, 6 * at + 3 + c] = sign * turn[c]


@kernel
def _row(kind, reals, xa, ra, va, wa, xb, rb, vb, wb, n, lever_a, lever_b):
    """Gap, rate and minus the bias of one row; writes its direction and levers (world frame).

    `reals`: anchors (6); POINT: direction (6:9, world); AXIS: axis of a (6:9) and direction of b (9:12), body
    frames; ROD: length (12).
    """
    if kind == AXIS:
        s, t = apply(ra, reals[6:9]), apply(rb, reals[9:12])
        ds, dt = cross(wa, s), cross(wb, t)
        lever, bend, bow = cross(s, t), cross(ds, t), cross(s, dt)
        rate, bias = 0.0, 0.0
        for c in range(3):
            lever_a[c] = lever_b[c] = lever[c]
            rate += lever[c] * (wa[c] - wb[c])
            bias += (bend[c] + bow[c]) * (wa[c] - wb[c])
        return dot(s, t), rate, -bias
    arm_a, arm_b = apply(ra, reals[0:3]), apply(rb, reals[3:6])
    spin_a, spin_b = cross(wa, arm_a), cross(wb, arm_b)
    bend_a, bend_b = cross(wa, spin_a), cross(wb, spin_b)
    r, dr, ddr = np.empty(3), np.empty(3), np.empty(3)
    for c in range(3):
        r[c] = (xa[c] - xb[c]) + (arm_a[c] - arm_b[c])
        dr[c] = (va[c] - vb[c]) + (spin_a[c] - spin_b[c])
        ddr[c] = bend_a[c] - bend_b[c]
    distance = norm(r) if kind == ROD else 1.0
    for c in range(3):
        n[c] = r[c] / distance if kind == ROD else reals[6 + c]
    turn_a, turn_b = cross(arm_a, n), cross(arm_b, n)
    for c in range(3):
        lever_a[c], lever_b[c] = turn_a[c], turn_b[c]
    rate, bias = dot(n, dr), dot(n, ddr)
    if kind == ROD:
        # across the rod: n turns, and the speed across it bends the path; written so that nothing cancels
        for c in range(3):
            bias += (dr[c] - n[c] * rate) ** 2 / distance
        return distance - reals[12], rate, -bias
    return dot(n, r), rate, -bias
