"""Stability: whether a motion stays one that the scene allows at all, however inaccurate it may be.

Accuracy asks how far an answer is from the truth; stability asks whether it is still an answer.  The ways
to break are a closed vocabulary, `BREAKS`.  All of them are silent: the engine went on and handed in
numbers.  They rank below a crash, a deadline or a refusal, which at least say that there is no answer.

Everything is judged from the motion, by bounds that are far from what a first-order scheme at a sensible
step does, so that a break is never a matter of tolerance:

energy        where the scene says that it cannot grow, it is not above its start plus the work of loads
              by more than a tenth of the energy the scene has to spend.  First-order schemes err by less
              than a hundredth in every scenario of the standard suite at a step of 1 ms.
overlap       half of the deepest there can be between two convex bodies, the sum of their inner radii
              (then their centres coincide): a body is then nearer to being in the other than on it.
joints        a hinge's two sides do not part by more than half the bounding radius of its smallest moving body;
              a rod or a taut string is not longer, a rod not shorter, by more than half its length.
standing      of a scenario that demands something of "drift": no body is away from its place by more than
              half its bounding radius, or turned by more than 0.5 rad, a third of the way to its next face.
reset         between two samples a body jumps farther than four times what its speeds can carry it, and
              everything is as it was within the first interval after the start.
speed cap     in free flight a component of the velocity that gravity must raise stays at one value, bit by
              bit, or what flight keeps is cut at the start by ten times what the next interval takes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from adapters.run import Failure
from comparisons.energy import energy_scale, potential_energy
from comparisons.gap import bounded_gap, overlaps, unmeasurable
from comparisons.joints import joints
from comparisons.measurement import Case, Quantity
from comparisons.penetration import close_pairs, pose
from comparisons.rest import displacements, turns
from mechanics.arrays import Scalars
from mechanics.effects import Force, Friction, Gravity, Resting, Restitution, Rotation
from mechanics.rotation import angle_between, rotate, unrotate
from mechanics.shapes import Box, Capsule, Cylinder, HalfSpace, Mesh, Shape, Sphere, bounding_radius

QUANTITIES = {
    "stability": ("1", "in how many ways the motion is none that the scene allows; 0 = stable"),
}
BREAKS = {
    "not finite": "the state holds NaN or infinity",
    "reset": "the motion begins again from the start",
    "speed cap": "a velocity stays at a limit that nothing in the scene sets",
    "tunnelled": "a body goes through a fixed one",
    "sank": "two bodies are more in each other than on each other",
    "came apart": "a joint holds no longer what it joins",
    "energy gained": "energy rises where nothing gives any",
    "fell": "what must stand does not",
    "not normalised": "a quaternion is no rotation",
}
STABLE = "stable"
GAIN = 0.1  # of the energy the scene has to spend
DEPTH = 0.5  # of the sum of the inner radii
AWAY = 0.5  # of the bounding radius, or of a joint's length
TURNED = 0.5  # [rad]
UNIT = 1e-6  # deviation of |q| from 1: single precision rounds by 6e-8, and sums of a few such are still a rotation
CUT = 0.01  # logarithm of what is lost at once
HELD = 3  # samples at one value
EQUAL = 1e-12  # relative; what a velocity differs by that is set to the same limit again and again
FREE = frozenset({Gravity, Rotation, Restitution, Friction, Resting})  # effects under which flight is free


class Break(NamedTuple):
    """One way in which a motion broke."""

    word: str  # of BREAKS
    time: float  # when it is first seen [s]
    text: str


def measure(case: Case) -> Iterator[Quantity]:
    """The number of ways in which the motion broke; the text names them, the worst first."""
    found = breaks(case)
    text = "; ".join(f"{b.word}: {b.text}, from t = {b.time:.4g} s on" for b in found)
    first = min((b.time for b in found), default=math.nan)
    yield Quantity("stability", float(len(found)), "1", first, text or STABLE)


def words(text: str) -> tuple[str, ...]:
    """The words of `BREAKS` in the text of a measured stability, in order; none if it is stable."""
    return tuple(w for part in text.split("; ") if (w := part.partition(":")[0]) in BREAKS)


def breaks(case: Case) -> tuple[Break, ...]:
    """Every way in which the motion of a case broke, in the order of `BREAKS`."""
    if not len(case.moving.mass):
        return ()
    through = dict(_tunnelled(case))
    found = [_not_finite(case), _reset(case), _capped(case), next(iter(through.values()), None),
             _sunk(case, set(through)), _parted(case), _gained(case), _fallen(case), _not_normalised(case)]  # fmt: skip
    return tuple(b for b in found if b is not None)


def _not_finite(case: Case) -> Break | None:
    """The driver stops at the first state that is not finite; an archived motion may hold more of them."""
    outcome, motion = case.run.outcome, case.run.trajectory
    noticed = isinstance(outcome, Failure) and (outcome.state, outcome.stage) == ("diverged", "read")
    if noticed or (motion is not None and len(motion) > len(case.trajectory)):
        return Break("not finite", float(case.trajectory.t[-1]), "the next state holds NaN or infinity")
    return None


def _not_normalised(case: Case) -> Break | None:
    off = np.abs(np.linalg.norm(case.moving.q, axis=2) - 1.0)
    return _first("not normalised", case, (off > UNIT).any(axis=1), lambda k: f"|q| is off 1 by {off[k].max():.3g}")


def _reset(case: Case) -> Break | None:
    m = case.moving
    if len(m.t) < 3:
        return None
    dt = np.diff(m.t)[:, None]
    speed, spin = (np.linalg.norm(part, axis=2) for part in (m.v, m.w))
    carried = np.maximum(speed[:-1], speed[1:]) * dt + m.pull * dt**2
    turned = np.maximum(spin[:-1], spin[1:]) * dt
    step = np.linalg.norm(np.diff(m.x, axis=0), axis=2)
    jump = (step > 4.0 * carried + 1e-6 * m.radius) | (angle_between(m.q[:-1], m.q[1:]) > 4.0 * turned + 1e-6)
    again = np.ones(len(m.t), dtype=bool)
    away_x, away_v, away_w = (np.linalg.norm(path - path[0], axis=2) for path in (m.x, m.v, m.w))
    for away, scale in ((away_x, m.radius), (away_v, m.speed_scale), (away_w, spin.max(axis=0)), (turns(m), 1.0)):
        again &= (away <= 1.5 * away[1] + 1e-9 * scale).all(axis=1)
    back = np.append(False, jump.any(axis=1) & ~again[:-1]) & again
    return _first("reset", case, back, lambda k: "every body is back where it began, without having gone there")


def _capped(case: Case) -> Break | None:
    """A limit that is met on the way, component by component, or one that the start is already above."""
    if not case.scene.needs <= FREE or len(case.moving.t) <= HELD:
        return None
    free = _flying(case)
    return _cut(case, free) or _held(case, free)


def _cut(case: Case, free: np.ndarray) -> Break | None:
    """What free flight keeps, v - g t and the spin, is cut in the first interval and not in the next.

    Drag takes its share of every interval; a limit takes all at once.
    """
    m = case.moving
    flight = m.v[:3] - m.t[:3, None, None] * case.scene.gravity
    for name, unit, path, kept in (("velocity", "m/s", m.v, flight), ("spin", "rad/s", m.w, m.spin[:3])):
        size = np.linalg.norm(kept, axis=2)
        with np.errstate(divide="ignore", invalid="ignore"):
            lost, then = np.log(size[0] / size[1]), np.abs(np.log(size[1] / size[2]))
        cut = (size[1:] > 0.0).all(axis=0) & (lost > CUT + 10.0 * then) & free[:2].all(axis=0)
        if cut.any():
            body = int(np.argmax(cut))
            before, after = (np.linalg.norm(path[k, body]) for k in (0, 1))
            text = f"the {name} of {_name(case, body)} is cut from {before:.6g} to {after:.6g} {unit} at once"
            return Break("speed cap", float(m.t[1]), text)
    return None


def _held(case: Case, free: np.ndarray) -> Break | None:
    """A component that gravity must raise stays at its largest value."""
    m = case.moving
    size = np.abs(m.v)
    cap = size[1:].max(axis=0)
    held = (size >= cap * (1.0 - EQUAL)) & (cap > 0.0) & free[:, :, None] & (m.v * case.scene.gravity > 0.0)
    held[0] = False
    runs = np.lib.stride_tricks.sliding_window_view(held, HELD, axis=0).all(axis=-1)
    if not runs.any():
        return None
    k, body, axis = (int(i) for i in np.argwhere(runs)[0])
    text = f"the velocity of {_name(case, body)} along {'xyz'[axis]} stays at {cap[body, axis]:.6g} m/s"
    return Break("speed cap", float(m.t[k]), text)


def _flying(case: Case) -> np.ndarray:
    """(T, k) whether nothing can reach a moving body in the interval after each sample, at anybody's largest speed."""
    m, scene = case.moving, case.scene
    far = np.ones((len(m.t), len(m.mass)), dtype=bool)
    fastest = np.linalg.norm(m.v, axis=2).max() + np.sqrt((scene.gravity**2).sum()) * np.diff(m.t).max()
    reach = 2.0 * fastest * np.append(np.diff(m.t), 0.0)
    for pair in scene.pairs():
        for one, other in (pair, pair[::-1]):
            if scene.bodies[one].fixed:
                continue
            far[:, scene.moving.index(one)] &= _apart(case, one, other) > reach
    return far


def _apart(case: Case, i: int, j: int) -> Scalars:
    """(T,) lower bound of the gap between two bodies, from their bounding balls [m]."""
    shapes = [case.scene.bodies[k].shape for k in (i, j)]
    if isinstance(shapes[1], HalfSpace):
        normal = rotate(np.array(case.scene.bodies[j].orientation), np.array(shapes[1].normal))
        return np.asarray((case.trajectory.x[:, i] - case.trajectory.x[:, j]) @ normal - bounding_radius(shapes[0]))
    away = np.linalg.norm(case.trajectory.x[:, i] - case.trajectory.x[:, j], axis=1)
    return np.asarray(away - sum(bounding_radius(s) for s in shapes))


def _tunnelled(case: Case) -> Iterator[tuple[tuple[int, int], Break]]:
    """Fixed boxes and balls that the centre of a moving body crosses from one sample to the next.

    A body that does not enter another keeps its centre an inner radius away from it, so the straight line
    between two samples of its path crosses the other only if it went through.
    """
    if len(case.trajectory) < 2:
        return
    stride = float(np.linalg.norm(np.diff(case.trajectory.x, axis=0), axis=2).max())
    for i, j in close_pairs(case.scene, case.trajectory, stride):
        fixed, moving = (i, j) if case.scene.bodies[i].fixed else (j, i)
        if not case.scene.bodies[fixed].fixed or case.scene.bodies[moving].fixed:
            continue
        at = pose(case.trajectory, fixed)
        path = unrotate(at.q, case.trajectory.x[:, moving] - at.x)
        crossed = _crosses(case.scene.bodies[fixed].shape, path)
        names = case.scene.names
        what = f"{names[moving]} crosses {names[fixed]}"
        found = _first("tunnelled", case, np.append(False, crossed), lambda _, what=what: what)
        if found:
            yield (i, j), found


def _crosses(shape: Shape, path: np.ndarray) -> np.ndarray:
    """(T - 1,) whether the lines between successive points (T, 3) go right through a shape at the origin."""
    start, step = path[:-1], np.diff(path, axis=0)
    match shape:
        case Sphere(radius):
            inner = np.full(3, radius / math.sqrt(3.0))
        case Box(size):
            inner = 0.5 * np.array(size)
        case _:
            return np.zeros(len(step), dtype=bool)
    with np.errstate(divide="ignore", invalid="ignore"):
        sides = np.stack([(-inner - start) / step, (inner - start) / step])
    still = step == 0.0
    within = np.abs(start) < inner
    enter = np.where(still, np.where(within, -np.inf, np.inf), sides.min(axis=0)).max(axis=1)
    leave = np.where(still, np.where(within, np.inf, -np.inf), sides.max(axis=0)).min(axis=1)
    return np.asarray((enter < leave) & (enter >= 0.0) & (leave <= 1.0))


def _sunk(case: Case, through: set[tuple[int, int]]) -> Break | None:
    """The first pair that overlaps too deep, besides those that are known to have gone through each other."""
    worst: Break | None = None
    scene = case.scene
    at_start = {frozenset((o.a, o.b)): o.depth for o in overlaps(scene)}
    for i, j in close_pairs(scene, case.trajectory):
        shapes, names = [scene.bodies[k].shape for k in (i, j)], [scene.names[k] for k in (i, j)]
        if (i, j) in through or unmeasurable(*shapes):
            continue
        depth = -bounded_gap(*shapes, pose(case.trajectory, i), pose(case.trajectory, j))
        limit = DEPTH * sum(map(inner_radius, shapes)) + at_start.get(frozenset(names), 0.0)
        found = _first("sank", case, depth > limit, lambda _, d=depth, n=names: f"{n[0]} and {n[1]}, {d.max():.3g} m")
        if found and (worst is None or found.time < worst.time):
            worst = found
    return worst


def _parted(case: Case) -> Break | None:
    """The first joint that came apart."""
    broken = [
        _first("came apart", case, j.error > AWAY * j.size, lambda _, j=j: f"{j.name}, by up to {j.error.max():.3g} m")
        for j in joints(case.scene, case.trajectory)
    ]
    return min((b for b in broken if b is not None), key=lambda b: b.time, default=None)


def inner_radius(shape: Shape) -> float:
    """Radius of the largest ball about the body's origin that fits into the shape [m]; 0 for a HalfSpace.

    A half-space has its origin on its surface: a body in it is counted by its own radius alone.
    """
    match shape:
        case Sphere(radius):
            return radius
        case Box(size):
            return 0.5 * min(size)
        case Capsule(radius, _):
            return radius
        case Cylinder(radius, length):
            return min(radius, 0.5 * length)
        case Mesh(vertices, triangles):
            a, b, c = (np.array(vertices)[np.array(triangles)[:, k]] for k in range(3))
            normal = np.cross(b - a, c - a)
            return float(np.abs(np.einsum("ti,ti->t", a, normal) / np.linalg.norm(normal, axis=1)).min())
    return 0.0


def _gained(case: Case) -> Break | None:
    """Energy above its start, less the work of loads and what the undoing of an overlap at the start may lift."""
    m, scene, duration = case.moving, case.scene, case.scenario.duration
    if any("by prescription" in why for why in case.conserved.energy_why):
        return None
    potential = potential_energy(m, case.trajectory, case.run.lead, duration)
    energy = m.kinetic + potential
    work = _work(case)
    lifted = sum(o.depth for o in overlaps(scene)) * float(m.mass @ m.pull)
    scale = max(energy_scale(m, potential), float(np.abs(work).max()))
    gain = energy - energy[0] - work - lifted
    return _first(
        "energy gained", case, gain > GAIN * scale, lambda _: f"up to {gain.max() / scale:.3g} of all there is"
    )


def _work(case: Case) -> Scalars:
    """(T,) work of the forces and torques that have no potential, from the motion [J].

    That of a force is exact but for the intervals in which it is switched; that of a torque is a trapezoidal sum.
    """
    scene, t = case.scene, case.moving.t
    total = np.zeros(len(t) - 1)
    for force in scene.all(Force):
        i = scene.index(force.body)
        acting = (np.clip(t[1:], force.start, force.end) - np.clip(t[:-1], force.start, force.end)) / np.diff(t)
        if force.start > 0.0 or force.end < case.scenario.duration:
            point = case.trajectory.x[:, i] + rotate(case.trajectory.q[:, i], np.array(force.point))
            total += acting * (np.diff(point, axis=0) @ np.array(force.force))
        if Rotation in scene.needs:
            power = case.trajectory.w[:, i] @ np.array(force.torque)
            total += acting * 0.5 * (power[1:] + power[:-1]) * np.diff(t)
    return np.append(0.0, np.cumsum(total))


def _fallen(case: Case) -> Break | None:
    if not case.asks("drift"):
        return None
    m = case.moving
    away = displacements(m)
    round_ones = [isinstance(case.scene.bodies[i].shape, Sphere) for i in case.scene.moving]
    turned = np.where(round_ones, 0.0, turns(m))
    lost = (away > AWAY * m.radius) | (turned > TURNED)

    def told(k: int) -> str:
        body = int(np.argmax(lost[k]))
        return f"{_name(case, body)} by up to {away[:, body].max():.3g} m and {turned[:, body].max():.3g} rad"

    return _first("fell", case, lost.any(axis=1), told)


def _first(word: str, case: Case, when: np.ndarray, text: Callable[[int], str]) -> Break | None:
    """The break at the first sample of `when`, or None; `text` tells it from the sample's number."""
    if not when.any():
        return None
    k = int(np.argmax(when))
    return Break(word, float(case.trajectory.t[k]), text(k))


def _name(case: Case, body: int) -> str:
    return case.scene.names[case.scene.moving[body]]
