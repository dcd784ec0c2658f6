"""Effective coefficient of restitution of every impact, from the motion alone.

An impact shows as a jump of the relative velocity of two bodies that known accelerations (gravity,
constant forces, prescribed motion) do not explain, while they could touch.  The state before it is
carried forward and the state after it backward under those accelerations; the two paths meet at the
time of contact (positions are continuous), and there e = -u⁺/u⁻ along the normal.  Positions are first
carried back by the engine's `lead`, so that they belong to the same time as the velocities.

Measured are impacts whose normal is beyond doubt: a sphere against a sphere or against anything
fixed (against anything where nothing turns), and a body that does not turn against a half-space.
Bodies on springs, rods, tethers and hinges, and scenes with drag, are left out: their accelerations are
not known beforehand.

An engine with time steps knows the time of an impact to one step only, and while that passes
gravity changes u.  The error of an impact is therefore the distance of the coefficient asked for from all values
that a time of contact within one step gives; without acceleration, or without steps, that is |e - asked|.

Too slow to tell, and left out, are impacts slower than |a| max(20 h, 4 Δ, 1.5 Δ/e), with the step h, the
interval of samples Δ and the relative acceleration a: below, that uncertainty exceeds a twentieth
of the speed, or the flight that follows is shorter than three samples.  Left out as well are
intervals in which a third body takes part (the momentum of the pair changes, or another
contact of it acts along the normal) and those whose carried states do not meet at the surface (more than one
impact between two samples).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from comparisons.gap import Pose, surface_distance
from comparisons.measurement import Case, Quantity
from comparisons.penetration import close_pairs
from mechanics.effects import Drag, Force, Hinge, Restitution, Rod, Rotation, Spring, Tether
from mechanics.rotation import unrotate
from mechanics.scene import Scene
from mechanics.shapes import Box, Capsule, Cylinder, HalfSpace, Mesh, Shape, Sphere, bounding_radius
from mechanics.trajectory import Trajectory

QUANTITIES = {
    "restitution error": ("1", "largest difference of the effective from the declared coefficient of restitution"),
    "restitution": ("1", "median of the effective coefficients of restitution"),
    "impacts seen": ("1", "number of impacts whose coefficient could be measured"),
}


@dataclass(frozen=True)
class Impacts:
    """Measured impacts of one pair of bodies, and how many could not be measured.

    Attributes
    ----------
    time : (K,) array [s]
    e : (K,) array
        Effective coefficient of restitution.
    error : (K,) array
        Distance of the declared coefficient from what the time of contact leaves open.
    skipped : int
    """

    time: np.ndarray
    e: np.ndarray
    error: np.ndarray
    skipped: int


def measure(case: Case) -> Iterator[Quantity]:
    """Effective restitution of a case in which it is declared."""
    if Restitution not in case.scene.needs or len(case.trajectory) < 3:
        return
    found = impacts(case.scene, case.trajectory, case.run.lead, _step(case.run.settings))
    time, e, error = (np.concatenate([[], *(getattr(f, n) for f in found)]) for n in ("time", "e", "error"))
    skipped = sum(f.skipped for f in found)
    text = f"{len(e)} measured, {skipped} too slow or not alone" if skipped else ""
    yield Quantity("impacts seen", float(len(e)), "1", text=text)
    if len(e):
        yield Quantity.worst("restitution error", error, "1", time)
        yield Quantity("restitution", float(np.median(e)), "1")
    elif case.asks("restitution error"):
        # impacts were due: if none was even tried, the bodies did not collide
        value, why = (np.nan, text) if skipped else (np.inf, "no impact seen")
        yield Quantity("restitution error", value, "1", text=why)


def impacts(scene: Scene, trajectory: Trajectory, lead: float = 0.0, step: float = 0.0) -> list[Impacts]:
    """Measured impacts of every pair of bodies that has any.

    Parameters
    ----------
    scene : Scene
    trajectory : Trajectory
        Of all bodies of the scene.
    lead : float
        Time by which positions run ahead of velocities [s].
    step : float
        Time step of the engine [s]; 0 = it finds the time of contact.
    """
    intervals = np.diff(trajectory.t)
    reach = float(np.linalg.norm(trajectory.v, axis=2).max() * 2.0 * intervals.max())
    pairs = [
        _Pair.of(scene, trajectory, *ij, lead) for ij in close_pairs(scene, trajectory, reach) if _clear(scene, *ij)
    ]
    pairs = [pair for pair in pairs if pair.hits.any()]
    return [_measured(pair, [p for p in pairs if p is not pair], step) for pair in pairs]


@dataclass(frozen=True, eq=False)
class _Pair:
    """Relative motion of body a as seen from body b, and the intervals in which b pushes a."""

    scene: Scene
    a: int
    b: int
    trajectory: Trajectory
    r: np.ndarray  # (T, 3) [m]
    w: np.ndarray  # (T, 3) [m/s]
    acceleration: np.ndarray  # (3,) known, relative [m/s2]
    gap: np.ndarray  # (T,) [m]
    normal: np.ndarray  # (T, 3)
    hits: np.ndarray  # (T-1,)

    @staticmethod
    def of(scene: Scene, trajectory: Trajectory, i: int, j: int, lead: float) -> _Pair:
        a, b = (j, i) if _plain(scene.bodies[j].shape, scene.bodies[i].shape) else (i, j)
        x = trajectory.x - lead * trajectory.v
        r, w = x[:, a] - x[:, b], trajectory.v[:, a] - trajectory.v[:, b]
        acceleration = _known(scene, a) - _known(scene, b)
        gap, normal = _gap(scene, trajectory, a, b, r, np.arange(len(r)))
        pair = _Pair(scene, a, b, trajectory, r, w, acceleration, gap, normal, np.zeros(0, dtype=bool))
        return _Pair(**{**pair.__dict__, "hits": _hits(pair)})


def _plain(first: Shape, second: Shape) -> bool:
    """Whether `first` is the one to be seen from `second`: the sphere, or what lies on the half-space."""
    return isinstance(second, HalfSpace) or (isinstance(first, Sphere) and not isinstance(second, Sphere))


def _clear(scene: Scene, i: int, j: int) -> bool:
    """Whether the normal and the accelerations of this pair are known beforehand."""
    names = {scene.names[i], scene.names[j]}
    if scene.all(Drag) or any(names & {e.a, e.b} for kind in (Spring, Rod, Tether, Hinge) for e in scene.all(kind)):
        return False
    if any(f.body in names and any(f.force) and (f.start > 0.0 or f.end < np.inf) for f in scene.all(Force)):
        return False
    a, b = (scene.bodies[k] for k in ((j, i) if _plain(scene.bodies[j].shape, scene.bodies[i].shape) else (i, j)))
    if isinstance(b.shape, HalfSpace):
        return True
    solid = not isinstance(b.shape, Mesh) or b.shape.convex
    unturned = isinstance(b.shape, Sphere) or b.fixed or Rotation not in scene.needs
    return isinstance(a.shape, Sphere) and solid and unturned


def _known(scene: Scene, i: int) -> np.ndarray:
    """Acceleration of body i by gravity, constant forces or prescription [m/s2]."""
    body = scene.bodies[i]
    if body.mass is None:
        return np.array(body.acceleration)
    forces = [np.array(f.force) for f in scene.all(Force) if f.body == body.name]
    return np.asarray(scene.gravity + sum(forces, np.zeros(3)) / body.mass)


def _gap(
    scene: Scene, trajectory: Trajectory, a: int, b: int, r: np.ndarray, rows: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Gap [m] and normal of the pair with a at `r` from b, attitudes as at the samples `rows`."""
    pose = Pose(np.zeros_like(r), trajectory.q[rows, b])
    distance, normal = surface_distance(scene.bodies[b].shape, pose, r)
    return distance - _extent(scene.bodies[a].shape, unrotate(trajectory.q[rows, a], normal)), normal


def _extent(shape: Shape, direction: np.ndarray) -> np.ndarray:
    """(T,) how far a body reaches from its centre against each `direction` (T, 3), body frame [m]."""
    match shape:
        case Sphere(radius):
            return np.full(len(direction), radius)
        case Box(size):
            return np.asarray(np.abs(direction) @ (0.5 * np.array(size)))
        case Capsule(radius, length):
            return np.asarray(0.5 * length * np.abs(direction[:, 2]) + radius)
        case Cylinder(radius, length):
            across = radius * np.hypot(direction[:, 0], direction[:, 1])
            return np.asarray(0.5 * length * np.abs(direction[:, 2]) + across)
        case Mesh(vertices):
            return np.asarray(-(direction @ np.array(vertices).T).min(axis=1))
    raise ValueError(f"{shape} has no extent")


def _hits(pair: _Pair) -> np.ndarray:
    """(T-1,) whether b pushed a away between two samples."""
    dt = np.diff(pair.trajectory.t)
    jump = np.diff(pair.w, axis=0) - dt[:, None] * pair.acceleration
    nearer = np.where((pair.gap[1:] < pair.gap[:-1])[:, None], pair.normal[1:], pair.normal[:-1])
    along = np.einsum("ti,ti->t", nearer, jump)
    u = np.abs(np.einsum("ti,ti->t", pair.normal, pair.w))
    fastest = np.linalg.norm(pair.w, axis=1)
    # a hundredth of the approach: far above rounding and damping, far below any impact
    threshold = 0.01 * np.maximum(u[1:], u[:-1]) + 1e-9 * fastest.max()
    reach = np.maximum(fastest[1:], fastest[:-1]) * dt + 0.5 * np.linalg.norm(pair.acceleration) * dt**2
    return np.asarray((along > threshold) & (np.minimum(pair.gap[1:], pair.gap[:-1]) <= reach))


def _measured(pair: _Pair, others: list[_Pair], step: float) -> Impacts:
    asked = pair.scene.restitution(pair.a, pair.b)
    first, last = _windows(pair)
    t, span = pair.trajectory.t, pair.trajectory.t[last] - pair.trajectory.t[first]
    free = np.append(~pair.hits, False)[last]  # nothing pushes after it: the state may be carried back
    away = pair.w[last] - (span * free)[:, None] * pair.acceleration
    start = pair.r[last] - span[:, None] * pair.w[last] + 0.5 * (span**2)[:, None] * pair.acceleration
    apart, jump = pair.r[first] - start, pair.w[first] - pair.w[last] + span[:, None] * pair.acceleration
    s = -np.einsum("ki,ki->k", apart, jump) / np.einsum("ki,ki->k", jump, jump)
    inside = (s >= -1.01 * step - 1e-9 * span) & (s <= span + 1.01 * step + 1e-9 * span)
    s = np.clip(s, 0.0, span)
    r = pair.r[first] + s[:, None] * pair.w[first] + 0.5 * (s**2)[:, None] * pair.acceleration
    gap, normal = _gap(pair.scene, pair.trajectory, pair.a, pair.b, r, first)
    before, after, gain = (np.einsum("ki,ki->k", normal, v) for v in (pair.w[first], away, pair.acceleration + 0 * r))

    def coefficient(at: np.ndarray) -> np.ndarray:
        return np.asarray(-(after + gain * free * at) / (before + gain * at))

    speed = -(before + gain * s)
    limit = np.abs(gain) * np.maximum(20.0 * step, span * max(4.0, 1.5 / asked if asked else 0.0))
    deepest = np.array([-pair.gap[i : j + 1].min() for i, j in zip(first, last, strict=True)])
    slack = 2.0 * step * np.abs(speed) + np.maximum(deepest, 0.0) + 1e-6 * (np.linalg.norm(r, axis=1) + np.abs(gap))
    good = inside & (speed > limit) & (np.abs(gap) <= slack) & _alone(pair, others, first, last, normal)
    good &= _unturned(pair, first, last, speed) & (last < len(t) - 1)
    ends = [coefficient(np.clip(s + d, 0.0, span)) for d in (-step, step)]
    error = np.maximum(0.0, np.maximum(np.minimum(*ends) - asked, asked - np.maximum(*ends)))
    collided = speed > 0.0
    return Impacts((t[first] + s)[good], coefficient(s)[good], error[good], int(np.count_nonzero(collided & ~good)))


def _windows(pair: _Pair) -> tuple[np.ndarray, np.ndarray]:
    """Samples before and after each impact: runs of intervals in which b pushes a, up to the fastest separation.

    A soft contact pushes over many intervals; a body that stays pushes for ever, but after the first
    interval gains no more speed.
    """
    edges = np.diff(np.concatenate([[0], pair.hits.astype(np.int8), [0]]))
    first, stop = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
    last = stop.copy()
    for n in np.flatnonzero(stop - first > 1):
        u = np.einsum("ti,ti->t", pair.normal[first[n] : stop[n] + 1], pair.w[first[n] : stop[n] + 1])
        enough = u[1:] >= u[1:].max() - 0.01 * abs(u[0])
        last[n] = first[n] + 1 + int(np.argmax(enough))
    return first, last


def _alone(pair: _Pair, others: list[_Pair], first: np.ndarray, last: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """(K,) whether no third body had a part in the change of velocity along the normal."""
    bodies, v, t = pair.scene.bodies, pair.trajectory.v, pair.trajectory.t
    if not bodies[pair.b].fixed and not bodies[pair.a].fixed:
        gained = []
        for i in (pair.a, pair.b):
            known = (t[last] - t[first])[:, None] * _known(pair.scene, i)
            gained.append(bodies[i].mass * np.einsum("ki,ki->k", normal, v[last, i] - v[first, i] - known))
        return np.asarray(np.abs(gained[0] + gained[1]) <= 0.01 * np.minimum(np.abs(gained[0]), np.abs(gained[1])))
    mine = pair.b if bodies[pair.a].fixed else pair.a
    alone = np.ones(len(first), dtype=bool)
    for other in others:
        if mine in (other.a, other.b):
            for n, (i, j) in enumerate(zip(first, last, strict=True)):
                rows = i + np.flatnonzero(other.hits[i:j])
                alone[n] &= not (np.abs(other.normal[rows] @ normal[n]) > 0.01).any()
    return alone


def _unturned(pair: _Pair, first: np.ndarray, last: np.ndarray, speed: np.ndarray) -> np.ndarray:
    """(K,) whether the rotation of a plays no part: it is a sphere, or does not turn before nor after."""
    shape = pair.scene.bodies[pair.a].shape
    if isinstance(shape, Sphere):
        return np.ones(len(first), dtype=bool)
    turning = np.linalg.norm(pair.trajectory.w[:, pair.a], axis=1) * bounding_radius(shape)
    return np.asarray(np.maximum(turning[first], turning[last]) <= 1e-3 * np.abs(speed))


def _step(settings: dict[str, object]) -> float:
    """Time step of the engine where it has one [s]."""
    dt = settings.get("dt", 0.0)
    return float(dt) if isinstance(dt, (int, float)) else 0.0
