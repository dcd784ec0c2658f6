"""Effects that a motion needs and its scene does not declare, told from the motion alone.

An engine in which an effect is not switched on cannot say that it is missing: bodies that may not touch pass through
each other, and what may not turn does not.  The judge sees it in the motion, whichever engine made it:

contact      two bodies overlap that do not at the start, and the scene declares no contact effect at all.
Restitution  bodies collide faster than what a scheme with time steps takes for lying, and it is not declared.
Resting      bodies stay in touch for `LASTS` samples while loads act, and it is not declared.
Rotation     a force has a moment about the centre of a body that touches nothing, and it is not declared; or a rough
             ball slides on the one body that it touches.

Not seen are moments by rods, tethers and contacts of anything but balls: what balances them cannot be told from motion.
A scenario that demands something is known to declare what it needs; there a finding is the engine's, and only told.  Of
a scene of which nothing is known it is an error, with effect, bodies and time.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from comparisons.gap import bounded_gap, overlaps, surface_distance, unmeasurable
from comparisons.measurement import Case, Quantity
from comparisons.penetration import close_pairs, pose
from comparisons.restitution import impacts
from mechanics.effects import Force, Resting, Restitution, Rotation
from mechanics.scene import Scene
from mechanics.shapes import Sphere, bounding_radius

QUANTITIES = {
    "undeclared effects": ("1", "effects that the motion needs and the scene does not declare"),
}
DEEP = 1e-6  # of the smaller body: overlap that is no rounding
NEAR = 1e-3  # of the smaller body: what is nearer touches
LASTS = 10  # samples
SLIDES = 1e-3  # of the speed scale: slower is no sliding


class Missing(NamedTuple):
    """An effect that a motion needs."""

    effect: str
    bodies: tuple[str, ...]
    time: float  # [s]
    why: str

    @property
    def sentence(self) -> str:
        """Effect, bodies and time."""
        names = " and ".join(repr(b) for b in self.bodies)
        return f"{self.why} ({names} at t = {self.time:.6g} s), but the scene does not declare {self.effect}"


def measure(case: Case) -> Iterator[Quantity]:
    """How many effects are missing; the text has one sentence for each."""
    found = missing(case)
    if found:
        text = "; ".join(one.sentence for one in found)
        yield Quantity("undeclared effects", float(len(found)), "1", found[0].time, text)


def missing(case: Case) -> tuple[Missing, ...]:
    """The first need of each effect that the scene does not declare, in order of time."""
    if len(case.trajectory) < 2 or not case.scene.moving:
        return ()
    first: dict[str, Missing] = {}
    for one in (*_meetings(case), *_collisions(case), *_lasting(case), *_turning(case)):
        if one.effect not in first or one.time < first[one.effect].time:
            first[one.effect] = one
    return tuple(sorted(first.values(), key=lambda one: one.time))


def _meetings(case: Case) -> Iterator[Missing]:
    """Bodies that go into each other where nothing makes them touch."""
    if case.scene.touching:
        return
    scene = replace(case.scene, effects=(*case.scene.effects, Resting()))
    drawn = {frozenset((o.a, o.b)) for o in overlaps(scene)}  # bodies that are in each other from the start may be
    for i, j in close_pairs(scene, case.trajectory):
        names = scene.names[i], scene.names[j]
        if frozenset(names) in drawn or unmeasurable(*(scene.bodies[k].shape for k in (i, j))):
            continue
        deep = _gap(case, i, j) < -DEEP * _smaller(scene, i, j)
        if deep.any():
            time = float(case.trajectory.t[int(np.argmax(deep))])
            yield Missing("Restitution or Resting", names, time, "bodies meet")


def _collisions(case: Case) -> Iterator[Missing]:
    """Impacts in scenes in which bodies may lie or slide, but not collide."""
    if Restitution in case.scene.needs or not case.scene.touching:
        return
    step = float(case.run.settings.get("dt", 0.0))
    for found in impacts(case.scene, case.trajectory, case.run.lead, step):
        if found.clear.any():
            k = int(np.argmax(found.clear))
            yield Missing(
                "Restitution", found.bodies, float(found.time[k]), f"bodies collide at {found.speed[k]:.4g} m/s"
            )


def _lasting(case: Case) -> Iterator[Missing]:
    """Contact that lasts in scenes in which bodies may collide, but not lie."""
    scene, m = case.scene, case.moving
    if Resting in scene.needs or not scene.touching or len(m.t) < LASTS or not m.pull.any():
        return
    for i, j in close_pairs(scene, case.trajectory):
        if unmeasurable(*(scene.bodies[k].shape for k in (i, j))):
            continue
        near = np.abs(_gap(case, i, j)) <= NEAR * _smaller(scene, i, j)
        runs = np.lib.stride_tricks.sliding_window_view(near, LASTS).all(axis=1)
        if runs.any():
            time = float(m.t[int(np.argmax(runs))])
            yield Missing("Resting", (scene.names[i], scene.names[j]), time, "bodies stay in contact")


def _turning(case: Case) -> Iterator[Missing]:
    """Moments on bodies that may not turn and that nothing can keep from it."""
    scene = case.scene
    if Rotation in scene.needs:
        return
    moments = [(force, moment) for force in scene.all(Force) if (moment := scene.moment(force)).any()]
    rough = list(_rough_balls(scene))
    if not moments and not rough:
        return
    t, touches = case.trajectory.t, _touches(case)
    for force, moment in moments:
        acts = (t >= force.start) & (t < force.end) & ~touches[:, scene.index(force.body)].any(axis=1)
        if acts.any():
            time, size = float(t[int(np.argmax(acts))]), float(np.linalg.norm(moment))
            yield Missing("Rotation", (force.body,), time, f"a moment of {size:.4g} N m acts on a body in flight")
    for ball, other in rough:
        rubs = _slides(case, ball, other) & touches[:, ball, other] & (touches[:, ball].sum(axis=1) == 1)
        if rubs.sum() >= 2:  # at one sample alone it may be on its way through an impact
            names = scene.names[ball], scene.names[other]
            yield Missing("Rotation", names, float(t[int(np.argmax(rubs))]), "friction turns a ball")


def _rough_balls(scene: Scene) -> Iterator[tuple[int, int]]:
    """Places of moving balls and of what they may rub against."""
    for pair in scene.pairs():
        for ball, other in (pair, pair[::-1]):
            body = scene.bodies[ball]
            rough = isinstance(body.shape, Sphere) and not body.fixed and scene.friction(*pair) > 0.0
            if rough and not unmeasurable(body.shape, scene.bodies[other].shape):
                yield ball, other


def _slides(case: Case, ball: int, other: int) -> np.ndarray:
    """(T,) whether a ball that does not turn would slide on the surface of another body if it touched it."""
    motion = case.trajectory
    n = surface_distance(case.scene.bodies[other].shape, pose(motion, other), motion.x[:, ball])[1]
    slip = motion.v[:, ball] - motion.v[:, other]
    slip = slip - np.einsum("ti,ti->t", slip, n)[:, None] * n
    return np.asarray(np.linalg.norm(slip, axis=1) > SLIDES * case.moving.speed_scale.max())


def _touches(case: Case) -> np.ndarray:
    """(T, n, n) which bodies touch at which sample."""
    scene, n = case.scene, len(case.scene.bodies)
    out = np.zeros((len(case.trajectory), n, n), dtype=bool)
    for i, j in close_pairs(scene, case.trajectory, NEAR * float(case.moving.radius.max())):
        if unmeasurable(*(scene.bodies[k].shape for k in (i, j))):
            out[:, i, j] = out[:, j, i] = True  # not known: then nothing is said
        else:
            out[:, i, j] = out[:, j, i] = _gap(case, i, j) <= NEAR * _smaller(scene, i, j)
    return out


def _gap(case: Case, i: int, j: int) -> np.ndarray:
    shapes = (case.scene.bodies[k].shape for k in (i, j))
    return np.asarray(bounded_gap(*shapes, pose(case.trajectory, i), pose(case.trajectory, j)))


def _smaller(scene: Scene, i: int, j: int) -> float:
    return min(bounding_radius(scene.bodies[k].shape) for k in (i, j))
