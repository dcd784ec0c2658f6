"""Coulomb friction: one coefficient per pair, the same for bodies that stick and that slide, isotropic.

At a touch with normal n the bodies slide with the velocity c of one touching point relative to the other,
c = (v_a + ω_a × r_a) - (v_b + ω_b × r_b), of which only the part along the surface counts.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from mechanics.effects import Friction
from mechanics.scene import Scene
from reference_impl.collide.features import EDGES, FACE, LINE, RIM, RING
from reference_impl.collide.rims import point_at_rim, rim_travel
from reference_impl.friction_problem import Rough
from reference_impl.kernels import apply, cross, dot, kernel, norm
from reference_impl.parts import Law, Parts
from reference_impl.state import Bodies

if TYPE_CHECKING:
    from reference_impl.collide.detect import Contacts, Kinematics
    from reference_impl.effects.resting import Island, Pose, Problem


def parts(scene: Scene, effect: Friction) -> Parts:
    """Rough contact; where every coefficient is zero, smooth contact, and nothing of this runs."""
    return Parts(law=Law(touching=True, friction=effect if any(effect.values()) else None))


class Slip(NamedTuple):
    """How the touching points of m contacts slide."""

    velocity: np.ndarray  # (m, 3) along the surface [m/s]
    bias: np.ndarray  # (m, 3) rate of the relative velocity by the velocities alone, while nothing slides [m/s2]
    carried: np.ndarray  # (m, 3) what fixed bodies that move add to the relative velocity [m/s]
    pulled: np.ndarray  # (m, 3) what fixed bodies that accelerate add to its rate [m/s2]


def slips(contacts: Contacts, k: Kinematics, pose: Pose, b: Bodies) -> Slip:
    """Slip of contacts with kinematics `k` for bodies with this pose."""
    out = Slip(*(np.empty((len(contacts.kinds), 3)) for _ in range(4)))
    _slips(contacts.kinds, contacts.reals, k.normal, k.point, pose.x, pose.rotation, pose.v, pose.w, b.inverse_mass,
           b.acceleration, *out)  # fmt: skip
    return out


def frames(normal: np.ndarray, way: np.ndarray) -> np.ndarray:
    """Two unit tangents (m, 2, 3) for each normal (m, 3); the first along `way` (m, 3) where that is not zero."""
    out = np.empty((len(normal), 2, 3))
    _frames(normal, way, out)
    return out


def rough(
    island: Island, problem: Problem, pose: Pose, b: Bodies, tangents: np.ndarray, mu: np.ndarray, slides: np.ndarray
) -> Rough:
    """The rows of a problem with friction in these tangents.

    Its c is left zero, and its d is what joints that hold the bodies add to the tangential accelerations: zero without.
    """
    m, width = problem.g.shape
    g = np.empty((m, 3, width))
    g[:, 0] = problem.g
    _tangent_rows(island.contacts.kinds, tangents, problem.k.point, pose.x, pose.rotation, b.root, b.inverse_mass,
                  island.place, g)  # fmt: skip
    d = np.zeros((m, 3))
    if problem.space is not None:
        d[:, 1:] = -g[:, 1:] @ problem.space.given
        g[:, 1:] = problem.space.within(g[:, 1:].reshape(2 * m, width)).reshape(m, 2, width)
    return Rough(g.reshape(3 * m, width), np.zeros(width), d.ravel(), mu, slides)


@kernel
def _frames(normal, way, out):
    for k in range(len(normal)):
        n = normal[k]
        t = np.zeros(3)
        along = dot(way[k], n)
        for c in range(3):
            t[c] = way[k, c] - along * n[c]
        size = norm(t)
        if size == 0.0:
            least = 0
            for c in range(1, 3):
                if abs(n[c]) < abs(n[least]):
                    least = c
            e = np.zeros(3)
            e[least] = 1.0
            t = cross(n, e)
            size = norm(t)
        for c in range(3):
            out[k, 0, c] = t[c] / size
        other = cross(n, out[k, 0])
        for c in range(3):
            out[k, 1, c] = other[c]


@kernel
def _tangent_rows(kinds, tangents, point, x, rotation, root, inverse_mass, place, g):
    """Scaled rows of both tangents of each contact into g[:, 1] and g[:, 2]; as `collide.features.rows`."""
    for k in range(len(kinds)):
        for which in range(2):
            t = tangents[k, which]
            for c in range(g.shape[2]):
                g[k, 1 + which, c] = 0.0
            for side in range(2):
                i = kinds[k, side]
                at = place[i]
                if at < 0:
                    continue
                sign = 1.0 if side == 0 else -1.0
                arm = np.empty(3)
                for c in range(3):
                    arm[c] = point[k, c] - x[i, c]
                lever = cross(arm, t)
                body = np.empty(3)
                for c in range(3):
                    body[c] = rotation[i, 0, c] * lever[0] + rotation[i, 1, c] * lever[1] + rotation[i, 2, c] * lever[2]
                for c in range(3):
                    g[k, 1 + which, 6 * at + c] = sign * t[c] * math.sqrt(inverse_mass[i])
                    turn = root[i, 0, c] * body[0] + root[i, 1, c] * body[1] + root[i, 2, c] * body[2]
                    g[k, 1 + which, 6 * at + 3 + c] = sign * turn


@kernel
def _slips(kinds, reals, normal, point, x, rotation, v, w, inverse_mass, acceleration, velocity, bias, carried, pulled):
    """See `Slip`.

    With p the contact point as it travels, c' = a_a + α_a × r_a + ω_a × (p' - v_a) - (the same of b).
    """
    for k in range(len(kinds)):
        a, b = kinds[k, 0], kinds[k, 1]
        n = normal[k]
        pace = _travel(kinds[k, 2], reals[k], n, x[a], rotation[a], v[a], w[a], x[b], rotation[b], v[b], w[b])
        arm, other, past, beyond = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
        for c in range(3):
            arm[c], other[c] = point[k, c] - x[a, c], point[k, c] - x[b, c]
            past[c], beyond[c] = pace[c] - v[a, c], pace[c] - v[b, c]
        turn_a, turn_b = cross(w[a], arm), cross(w[b], other)
        bend_a, bend_b = cross(w[a], past), cross(w[b], beyond)
        for c in range(3):
            velocity[k, c] = v[a, c] + turn_a[c] - v[b, c] - turn_b[c]
            bias[k, c] = bend_a[c] - bend_b[c]
            carried[k, c] = pulled[k, c] = 0.0
            if inverse_mass[a] == 0.0:
                carried[k, c] += v[a, c]
                pulled[k, c] += acceleration[a, c]
            if inverse_mass[b] == 0.0:
                carried[k, c] -= v[b, c]
                pulled[k, c] -= acceleration[b, c]
        along = dot(velocity[k], n)
        for c in range(3):
            velocity[k, c] -= along * n[c]


@kernel
def _travel(kind, reals, n, xa, ra, va, wa, xb, rb, vb, wb):
    """Velocity of the contact point as it travels over both bodies [m/s]."""
    arm_a, arm_b = apply(ra, reals[0:3]), apply(rb, reals[6:9])
    spin_a, spin_b = cross(wa, arm_a), cross(wb, arm_b)
    r, dr, out = np.empty(3), np.empty(3), np.empty(3)
    for c in range(3):
        r[c] = xa[c] - xb[c] + arm_a[c] - arm_b[c]
        dr[c] = va[c] - vb[c] + spin_a[c] - spin_b[c]
    if kind == EDGES:
        # P_b = p_b + t b with t from n·(a × r) = t n·(a × b) as both edges turn
        a, b = apply(ra, reals[3:6]), apply(rb, reals[9:12])
        da, db = cross(wa, a), cross(wb, b)
        crossed = cross(a, b)
        square = dot(crossed, crossed)
        s, t = dot(cross(b, crossed), r) / -square, dot(cross(crossed, a), r) / square
        scale = dot(cross(n, a), b)
        # n is perpendicular to both: n' = -(n·a') pa - (n·b') pb in the dual basis of (a, b)
        na, nb = dot(n, da) / scale, dot(n, db) / scale
        pa, pb = cross(b, n), cross(n, a)
        wide, core = reals[12] - reals[13], dot(n, r)
        near, dn = np.empty(3), np.empty(3)
        for c in range(3):
            dn[c] = -na * pa[c] - nb * pb[c]
            near[c] = dr[c] + s * da[c] - t * db[c] - core * dn[c]
        dt = dot(pb, near) / scale
        for c in range(3):
            out[c] = vb[c] + spin_b[c] + dt * b[c] + t * db[c] + wide * dn[c]
        return out
    if kind == RIM:
        return rim_travel(reals, ra, wa, rb, wb, va, spin_a, n)
    dn = np.zeros(3)
    if kind == FACE:
        radius = reals[12]
        dn = cross(wb, n)
    elif kind == RING:
        radius = reals[13]
        point_at_rim(reals, rb, wb, r, dr, dr, out, dn)  # the second rate is not needed
    else:
        radius = reals[13]
        m, dm = r, dr
        if kind == LINE:
            e = apply(rb, reals[9:12])
            de = cross(wb, e)
            s = dot(r, e)
            ds = dot(dr, e) + dot(r, de)
            m, dm = np.empty(3), np.empty(3)
            for c in range(3):
                m[c] = r[c] - s * e[c]
                dm[c] = dr[c] - s * de[c] - ds * e[c]
        distance, along = norm(m), dot(n, dm)
        for c in range(3):
            dn[c] = (dm[c] - along * n[c]) / distance
    for c in range(3):
        out[c] = va[c] + spin_a[c] - radius * dn[c]
    return out
