"""Effective coefficient of restitution of every impact, from the motion alone.

An impact shows as a jump of the relative velocity of two bodies that known accelerations (gravity,
constant forces, prescribed motion) do not explain, while they could touch.  The state before it is
carried forward and the state after it backward under those accelerations; the two paths meet at the
time of contact (positions are continuous), and there e = -u⁺/u⁻ along the normal.  Positions are first
carried back by the engine's `lead`, so that they belong to the same time as the velocities.

Measured are impacts whose normal is beyond doubt: a sphere against a sphere or against anything
fixed (against anything where nothing turns), and against a half-space a body that does not turn or that
lands flat (then by its centre: what lands flat must not start to turn).  Bodies on springs, rods,
tethers and hinges, and scenes with drag, are left out: their accelerations are not known beforehand.

An engine with time steps knows the time of an impact to one step h only, and while that passes gravity
changes u: its e is uncertain by (1 + e) |a| h/|u|, with a the relative acceleration.  Too slow to tell
are therefore impacts slower than |a| max(20 h, 4 Δ, 1.5 Δ/e), with Δ the interval of samples: below,
that uncertainty exceeds a tenth, or the flight that follows is shorter than three samples.  They are
left out, unless no impact is faster: then the fastest of them is taken, with that remark.  Left
out in any case are intervals in which a third body takes part (the momentum of the pair changes, or another
contact of it acts along the normal) and those whose carried states do not meet at the surface (more
than one impact between two samples).
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
    "restitution error": ("1", "largest difference of the effective coefficient of restitution from the declared one"),
    "restitution": ("1", "median of the effective coefficients of restitution"),
    "impacts seen": ("1", "number of impacts whose coefficient could be measured"),
}

UNSEEN = 1e-3  # a hop that is too short to be seen falsifies e by e at most: below this it does not matter


@dataclass(frozen=True)
class Impacts:
    """Impacts of one pair of bodies.

    Attributes
    ----------
    bodies : tuple of str
        Names of the pair.
    time : (K,) array [s]
    e : (K,) array
        Effective coefficient of restitution.
    error : (K,) array
        Its distance from the declared one.
    speed : (K,) array
        Speed of approach [m/s].
    clear : (K,) array of bool
        Whether it is fast enough to tell.
    skipped : int
        How many could not be measured.
    """

    bodies: tuple[str, str]
    time: np.ndarray
    e: np.ndarray
    error: np.ndarray
    speed: np.ndarray
    clear: np.ndarray
    skipped: int


def measure(case: Case) -> Iterator[Quantity]:
    """Effective restitution of a case in which it is declared."""
    if Restitution not in case.scene.needs or len(case.trajectory) < 3:
        return
    found = impacts(case.scene, case.trajectory, case.run.lead, _step(case.run.settings))
    time, e, error, speed, clear = (
        np.concatenate([[], *(getattr(f, name) for f in found)]) for name in ("time", "e", "error", "speed", "clear")
    )
    chosen, text = clear > 0.0, ""
    skipped = sum(f.skipped for f in found) + int(np.count_nonzero(~chosen))
    if skipped:
        text = f"{int(chosen.sum())} measured, {skipped} too slow or not alone"
    if len(e) and not chosen.any():
        chosen[np.argmax(speed)], text = True, "slower than what can be told for certain at this step and sampling"
    yield Quantity("impacts seen", float(chosen.sum()), "1", text=text)
    if chosen.any():
        yield Quantity.worst("restitution error", error[chosen], "1", time[chosen], text=text)
        yield Quantity("restitution", float(np.median(e[chosen])), "1")
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
    reach = float(np.linalg.norm(trajectory.v, axis=2).max() * 2.0 * np.diff(trajectory.t).max())
    close = list(close_pairs(scene, trajectory, reach))
    pairs = [pair for ij in close if _clear(scene, *ij) and (pair := _Pair.of(scene, trajectory, *ij, lead)).hits.any()]
    crowd = _Crowd.of(scene, trajectory, close, pairs)
    return [_measured(pair, crowd, step) for pair in pairs]


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
        w = trajectory.v[:, a] - trajectory.v[:, b]
        r = trajectory.x[:, a] - trajectory.x[:, b] - lead * w
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
    shape = scene.bodies[a].shape
    if isinstance(shape, Sphere):
        return distance - shape.radius, normal
    return distance - _extent(shape, unrotate(trajectory.q[rows, a], normal)), normal


def _extent(shape: Shape, direction: np.ndarray) -> np.ndarray:
    """(T,) how far a body that is no sphere reaches from its centre against `direction` (T, 3), body frame [m]."""
    match shape:
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


def _measured(pair: _Pair, crowd: _Crowd, step: float) -> Impacts:
    asked = pair.scene.restitution(pair.a, pair.b)
    first, last = _windows(pair)
    t, span = pair.trajectory.t, pair.trajectory.t[last] - pair.trajectory.t[first]
    free = np.append(~pair.hits, False)[last]  # nothing pushes after it: the state may be carried back
    s = _meeting(pair, first, last, span, free)
    inside = (s >= -1.01 * step - 1e-9 * span) & (s <= span + 1.01 * step + 1e-9 * span)
    s = np.clip(s, 0.0, span)
    r = pair.r[first] + s[:, None] * pair.w[first] + 0.5 * (s**2)[:, None] * pair.acceleration
    gap, normal = _gap(pair.scene, pair.trajectory, pair.a, pair.b, r, first)
    before, after = (np.einsum("ki,ki->k", normal, pair.w[rows]) for rows in (first, last))
    gain = normal @ pair.acceleration
    speed = -(before + gain * s)
    interval = t[first + 1] - t[first]
    limit = np.abs(gain) * np.maximum(20.0 * step, interval * max(4.0, 1.5 / asked if asked > UNSEEN else 0.0))
    deepest = np.array([-pair.gap[i : j + 1].min() for i, j in zip(first, last, strict=True)])
    slack = (
        2.0 * step * np.abs(speed) + 2.0 * np.maximum(deepest, 0.0) + 1e-6 * (np.linalg.norm(r, axis=1) + np.abs(gap))
    )
    good = inside & (speed > 0.0) & (np.abs(gap) <= slack) & (last < len(t) - 1)
    good &= _unturned(pair, first, last, speed, normal)
    good[good] = _alone(pair, crowd, first[good], last[good], normal[good])
    e = (after - gain * free * (span - s)) / np.where(speed > 0.0, speed, 1.0)
    rows = ((t[first] + s)[good], e[good], np.abs(e - asked)[good], speed[good], (speed > limit)[good])
    names = pair.scene.names[pair.a], pair.scene.names[pair.b]
    return Impacts(names, *rows, int(np.count_nonzero((speed > 0.0) & ~good)))


def _meeting(pair: _Pair, first: np.ndarray, last: np.ndarray, span: np.ndarray, free: np.ndarray) -> np.ndarray:
    """(K,) time after the first sample at which the path before meets the path after [s].

    Their distance is c + b s + A s² along the jump of velocity; A = 0 where the same acceleration acts on
    both, and not where the bodies stay together.
    """
    carried = (span * free)[:, None] * pair.acceleration
    jump = pair.w[last] - pair.w[first] - carried
    apart = pair.r[last] - span[:, None] * pair.w[last] + 0.5 * span[:, None] * carried - pair.r[first]
    b = np.linalg.norm(jump, axis=1)
    towards = jump / np.where(b > 0.0, b, 1.0)[:, None]
    c = np.einsum("ki,ki->k", towards, apart)
    quadratic = np.where(free, 0.0, -0.5 * (towards @ pair.acceleration))
    spread = b + np.sqrt(np.maximum(b * b - 4.0 * quadratic * c, 0.0))
    return np.where(b > 0.0, -2.0 * c / np.where(b > 0.0, spread, 1.0), np.nan)  # no jump, no meeting


def _windows(pair: _Pair) -> tuple[np.ndarray, np.ndarray]:
    """Samples before and after each impact: runs of intervals in which b pushes a.

    A soft contact pushes over many intervals and ends when the bodies are apart; a body that stays is
    pushed for ever, and there the fastest separation counts.
    A push that leaves the bodies approaching belongs to the next one.  A soft contact is followed out of the
    overlap, where it still pushes a little.
    """
    u = np.einsum("ti,ti->t", pair.normal, pair.w)
    before, after = _outside(pair.gap)
    edges = np.diff(np.concatenate([[0], pair.hits.astype(np.int8), [0]]))
    windows: list[tuple[int, int]] = []
    for first, stop in zip(np.flatnonzero(edges == 1).tolist(), np.flatnonzero(edges == -1).tolist(), strict=True):
        enough = u[first + 1 : stop + 1] >= u[first + 1 : stop + 1].max() - 0.01 * abs(u[first])
        last = first + 1 + int(np.argmax(enough))
        if stop > first + 1:
            first, last = _through(pair.gap, u, int(before[first]), int(after[stop])) or (first, last)
        if windows and u[windows[-1][1]] < -0.01 * abs(u[windows[-1][0]]):
            first = windows.pop()[0]
        windows.append((first, last))
    return np.array([w[0] for w in windows]), np.array([w[1] for w in windows])


def _through(gap: np.ndarray, u: np.ndarray, first: int, last: int) -> tuple[int, int] | None:
    """The samples before and after a soft contact from which the bodies part, or None if they stay in touch.

    What comes off is fastest in the end; what is damped more is fastest on the way, and creeps back to the surface.
    """
    parted = gap[last] > 0.0 and u[last] > 0.01 * abs(u[first])
    return (first, last) if parted and u[last] > 0.9 * u[first : last + 1].max() else None


def _outside(gap: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(T,) last sample up to each at which the bodies do not overlap, or the first of all; next such one, or the last.

    For all samples at once: what lies in an overlap for long is pushed again and again.
    """
    rows, apart = np.arange(len(gap)), ~(gap < 0.0)
    before = np.maximum.accumulate(np.where(apart, rows, 0))
    after = np.minimum.accumulate(np.where(apart, rows, len(gap) - 1)[::-1])[::-1]
    return before, after


@dataclass(frozen=True)
class _Crowd:
    """Who may take part in an impact of two others."""

    trajectory: Trajectory
    radius: np.ndarray  # (n,) of the bounding balls [m]
    reach: np.ndarray  # (T,) how far anything may get to anything between two samples [m]
    touching: np.ndarray  # (n, n) whether the two come close at all
    unclear: np.ndarray  # (n, n) whether they do, and their impacts are not measured
    pushed: dict[int, list[_Pair]]  # by body: the pairs of it in which something pushes

    @staticmethod
    def of(scene: Scene, trajectory: Trajectory, close: list[tuple[int, int]], pairs: list[_Pair]) -> _Crowd:
        count = len(scene.bodies)
        touching, unclear = np.zeros((2, count, count), dtype=bool)
        for i, j in close:
            touching[i, j] = touching[j, i] = True
            unclear[i, j] = unclear[j, i] = not _clear(scene, i, j)
        pushed: dict[int, list[_Pair]] = {i: [p for p in pairs if i in (p.a, p.b)] for i in scene.moving}
        # not the speed of the two themselves: what stands may be struck and strike on between two samples
        reach = 2.0 * np.linalg.norm(trajectory.v, axis=2).max(axis=1) * np.diff(trajectory.t).max()
        radius = np.array([bounding_radius(b.shape) for b in scene.bodies])
        return _Crowd(trajectory, radius, reach, touching, unclear, pushed)

    def near(self, i: int, rows: np.ndarray) -> np.ndarray:
        """(K, n) whether body i may touch each of the others within an interval of the samples `rows`."""
        apart = np.linalg.norm(self.trajectory.x[rows] - self.trajectory.x[rows, i, None], axis=2)
        return np.asarray(self.touching[i] & (apart <= self.radius + self.radius[i] + self.reach[rows, None]))


def _alone(pair: _Pair, crowd: _Crowd, first: np.ndarray, last: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """(K,) whether no third body had a part in the change of velocity along the normal."""
    moving = [i for i in (pair.a, pair.b) if not pair.scene.bodies[i].fixed]
    company = np.zeros(len(first), dtype=bool)
    for i in moving:
        near = crowd.near(i, first) | crowd.near(i, last)
        near[:, [pair.a, pair.b]] = False
        company |= (near if len(moving) == 2 else near & crowd.unclear[i]).any(axis=1)
    if len(moving) == 2:
        return ~company | _balanced(pair, first, last, normal)
    for other in crowd.pushed[moving[0]]:
        if other is not pair:
            for n, (i, j) in enumerate(zip(first, last, strict=True)):
                rows = i + np.flatnonzero(other.hits[i:j])
                company[n] |= bool((np.abs(other.normal[rows] @ normal[n]) > 0.01).any())
    return ~company


def _balanced(pair: _Pair, first: np.ndarray, last: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """(K,) whether one body gained the momentum along the normal that the other lost, to a hundredth."""
    v, t, gained = pair.trajectory.v, pair.trajectory.t, []
    for i in (pair.a, pair.b):
        change = v[last, i] - v[first, i] - (t[last] - t[first])[:, None] * _known(pair.scene, i)
        gained.append((pair.scene.bodies[i].mass or 0.0) * np.einsum("ki,ki->k", normal, change))
    return np.asarray(np.abs(gained[0] + gained[1]) <= 0.01 * np.minimum(np.abs(gained[0]), np.abs(gained[1])))


def _unturned(pair: _Pair, first: np.ndarray, last: np.ndarray, speed: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """(K,) whether rotation plays no part: a sphere, what does not turn, or what comes unturning and lands flat."""
    shape = pair.scene.bodies[pair.a].shape
    if isinstance(shape, Sphere):
        return np.ones(len(first), dtype=bool)
    turning = np.linalg.norm(pair.trajectory.w[:, pair.a], axis=1) * bounding_radius(shape)
    axes = np.abs(unrotate(pair.trajectory.q[first, pair.a], normal))
    flat = axes.max(axis=1) > 1.0 - 1e-9 if isinstance(shape, Box) else np.zeros(len(first), dtype=bool)
    limit = 1e-3 * np.abs(speed)
    return np.asarray((turning[first] <= limit) & ((turning[last] <= limit) | flat))


def _step(settings: dict[str, object]) -> float:
    """Time step of the engine where it has one [s]."""
    dt = settings.get("dt", 0.0)
    return float(dt) if isinstance(dt, (int, float)) else 0.0
