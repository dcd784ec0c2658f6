"""Penalty: contact as a load.  Bodies may overlap, and a spring and damper pushes them apart.

At a contact of gap g < 0 and normal velocity u the force along the normal is

    f = max(0, -k g - c u)

It only pushes: contact ends when the force vanishes, which is before the overlap does.

Stiffness.  A body is to sink in by `depth` under its own weight, so that with the reduced mass m of the pair

    k = m ω²,    ω = sqrt(g / depth)

with g the greatest acceleration by loads, standard gravity where none acts.  That is the price of the
method: whatever the mass, steps must resolve ω.  And it is the weight that sinks in by `depth`: an impact
at speed v goes as deep as v / ω.

Damping.  Of one contact with effective mass μ (turning included) c = 2 ζ sqrt(k μ); restitution e follows
from ζ alone, and ζ is chosen for e.  Schwager and Pöschel, Coefficient of restitution and linear-dashpot
model revisited, Granular Matter 9 (2007).  Several contacts of a body are springs in parallel: it sinks in
less, and its restitution is another.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from mechanics.effects import Friction, Resting, Restitution
from mechanics.scene import Scene
from reference_impl.collide.overlap import Touch
from reference_impl.effects.resting import Pose
from reference_impl.errors import Unsupported
from reference_impl.kernels import apply, apply_transposed, cross, dot, kernel
from reference_impl.parts import Law, Parts
from reference_impl.state import Bodies

GRAVITY = 9.80665  # standard [m/s2]
LEAST = 0.01  # restitution below which damping costs more steps than it is worth
REST = 1.0  # damping ratio of bodies that only rest on each other: the fastest return without overshoot


def restitution(scene: Scene, effect: Restitution) -> Parts:
    """Bodies touch, and damping is chosen for e."""
    return Parts(law=Law(touching=True, restitution=effect))


def resting(scene: Scene, effect: Resting) -> Parts:
    """Bodies touch; a spring carries a weight for as long as it lies there."""
    return Parts(law=Law(touching=True, resting=True))


def frictionless(scene: Scene, effect: Friction) -> Parts:
    """Smooth contact.

    Raises
    ------
    Unsupported
        If any pair has a coefficient above zero.
    """
    if any(effect.values()):
        raise Unsupported(f"Friction with a coefficient of {max(effect.values()):g}: only 0 (smooth contact)")
    return Parts(law=Law(touching=True))


def restitution_of(zeta: float) -> float:
    """Coefficient of restitution of a spring and damper of damping ratio ζ >= 0 that only push.

    With contact until the force vanishes

        e = exp(-ζ ω t),    ω t = (π - atan2(2 ζ sqrt(1 - ζ²), 1 - 2 ζ²)) / sqrt(1 - ζ²)     for ζ < 1,

    exp(-2) at ζ = 1, and the same with hyperbolic functions above.
    """
    if zeta < 1.0:
        s = math.sqrt((1.0 - zeta) * (1.0 + zeta))
        if s > 1e-6:
            return math.exp(-zeta / s * (math.pi - math.atan2(2.0 * zeta * s, 1.0 - 2.0 * zeta * zeta)))
    if zeta > 1.0:
        s = math.sqrt((zeta - 1.0) * (zeta + 1.0))
        if s > 1e-6:
            return math.exp(-2.0 * zeta / s * math.log(zeta + s))
    return math.exp(-2.0 * zeta)


def damping_ratio(e: float) -> float:
    """Damping ratio ζ whose restitution is e; that of `LEAST` for less."""
    from scipy.optimize import brentq

    if e >= 1.0:
        return 0.0
    return float(brentq(lambda zeta: restitution_of(zeta) - max(e, LEAST), 0.0, 10.0, xtol=1e-15, rtol=1e-14))


def damping_ratios(scene: Scene, law: Law) -> np.ndarray:
    """Damping ratio of every pair of bodies (n, n)."""
    n = len(scene.bodies)
    if law.restitution is None:
        return np.full((n, n), REST)
    known: dict[float, float] = {}
    out = np.zeros((n, n))
    for i, j in scene.pairs():
        e = law.restitution.of(scene.names[i], scene.names[j])
        if e not in known:
            known[e] = damping_ratio(e)
        out[i, j] = out[j, i] = known[e]
    return out


class Push(NamedTuple):
    """Contact forces on the bodies of a scene."""

    along: np.ndarray  # (m,) at each contact, on a along the normal [N]
    force: np.ndarray  # (n, 3) sum over each body [N]
    torque: np.ndarray  # (n, 3) sum over each body [N m]
    fastest: float  # greatest frequency sqrt(k / μ) of a contact [rad/s]


def push(touch: Touch, pose: Pose, b: Bodies, omega: float, zeta: np.ndarray) -> Push:
    """Contact forces of springs with frequency `omega` [rad/s] and damping ratios `zeta` (n, n)."""
    along, force, torque = np.zeros(len(touch.gap)), np.zeros_like(pose.x), np.zeros_like(pose.x)
    fastest = _push(touch.ends, touch.normal, touch.point, touch.gap, pose.x, pose.rotation, pose.v, pose.w,
                    b.inverse_mass, b.inverse_inertia, omega, zeta, along, force, torque)  # fmt: skip
    return Push(along, force, torque, fastest)


@kernel
def _push(
    ends, normal, point, gap, x, rotation, v, w, inverse_mass, inverse_inertia, omega, zeta, along, force, torque
):
    fastest = 0.0
    for k in range(len(gap)):
        if gap[k] >= 0.0:
            continue
        a, b, n = ends[k, 0], ends[k, 1], normal[k]
        ra, rb = point[k] - x[a], point[k] - x[b]
        u = dot(n, v[a] + cross(w[a], ra)) - dot(n, v[b] + cross(w[b], rb))
        mobility = inverse_mass[a] + inverse_mass[b]
        stiffness = omega * omega / mobility
        for i, r in ((a, ra), (b, rb)):
            body = apply_transposed(rotation[i], cross(r, n))
            mobility += dot(body, apply(inverse_inertia[i], body))
        damping = 2.0 * zeta[a, b] * math.sqrt(stiffness / mobility)
        fastest = max(fastest, math.sqrt(stiffness * mobility))
        f = max(0.0, -stiffness * gap[k] - damping * u)
        along[k] = f
        ta, tb = cross(ra, n), cross(rb, n)
        for c in range(3):
            force[a, c] += f * n[c]
            force[b, c] -= f * n[c]
            torque[a, c] += f * ta[c]
            torque[b, c] -= f * tb[c]
    return fastest
