"""Which effects a scene calls for, told from the scene alone.

Some effects are given: whether there is gravity, a drag, a force, a spring, a rod or friction is what the scene says,
and it can only be asked whether what it says has any consequence.  Turning, colliding and lying are consequences of
the rest: whether they can happen follows from where bodies are, how they move and what pushes them.  The answers err
to one side only: "cannot act" is certain, "may act" is not.

That two bodies cannot meet is certain in free flight: if no pair could meet while all others are in flight, no first
meeting ever happens, and the flights are known.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from mechanics.effects import (
    EFFECTS,
    Drag,
    Effect,
    Force,
    Friction,
    Gravity,
    Hinge,
    Resting,
    Restitution,
    Rod,
    Rotation,
    Spring,
    Tether,
)
from mechanics.rotation import rotate
from mechanics.scene import Body, Scene
from mechanics.shapes import HalfSpace, Sphere, bounding_radius

FOREVER = 1e300  # [s]
ACTS, MAY, CANNOT = "acts", "may act", "cannot act"
FOUND = {
    (True, ACTS): "declared, and it acts",
    (True, MAY): "declared, and it may act",
    (True, CANNOT): "declared, but it cannot act: it could be left out",
    (False, ACTS): "not declared, but called for",
    (False, MAY): "not declared, and it might be called for",
    (False, CANNOT): "not declared, and not called for",
}


class Call(NamedTuple):
    """Whether a scene calls for an effect."""

    effect: str
    declared: bool
    answer: str  # ACTS, MAY or CANNOT
    why: str

    @property
    def sentence(self) -> str:
        """What to make of it."""
        return FOUND[self.declared, self.answer]


class Meeting(NamedTuple):
    """Two bodies that come together."""

    a: str
    b: str
    time: float  # [s]; of their bounding balls
    certain: bool  # whether these are the bodies themselves


def calls(scene: Scene, duration: float = math.inf) -> tuple[Call, ...]:
    """Every effect there is, and whether `scene` calls for it within `duration` [s]."""
    meeting = first_meeting(scene, duration)
    found = []
    for name, kind in EFFECTS.items():
        declared = kind in scene.needs
        if kind in _FOLLOWS:
            answer, why = _FOLLOWS[kind](scene, duration, meeting)
        elif declared:
            told = [_GIVEN[kind](scene, effect, duration, meeting) for effect in scene.all(kind)]
            answer, why = min(told, key=lambda one: (ACTS, MAY, CANNOT).index(one[0]))
        else:
            answer, why = CANNOT, _UNASKED[kind]
        found.append(Call(name, declared, answer, why))
    return tuple(found)


def first_meeting(scene: Scene, duration: float = math.inf) -> Meeting | str:
    """The first meeting of two bodies within `duration` [s], or why there is none.

    Bodies on links, springs and under forces or drag are taken to meet at once: their flights are not known here.
    """
    pairs = list(_pairs(scene))
    if not pairs:
        alone = len(scene.moving) == 1 and len(scene.bodies) == 1
        return "there is one body" if alone else "no two bodies can touch: they are fixed, or joined"
    if any(scene.all(kind) for kind in (Drag, Force, Spring, Rod, Tether, Hinge)):
        i, j = pairs[0]
        return Meeting(scene.names[i], scene.names[j], 0.0, False)
    met = [(time, i, j) for i, j in pairs if (time := _meeting(scene, i, j)) <= min(duration, FOREVER)]
    if not met:
        return "in free flight no two bodies ever meet"
    time, i, j = min(met)
    certain = all(isinstance(scene.bodies[k].shape, (Sphere, HalfSpace)) for k in (i, j))
    return Meeting(scene.names[i], scene.names[j], time, certain)


def _pairs(scene: Scene) -> Iterator[tuple[int, int]]:
    """The pairs that may touch if any contact effect is declared, whether one is or not."""
    joined = {frozenset((e.a, e.b)) for kind in (Rod, Hinge) for e in scene.all(kind)}
    for (i, a), (j, b) in combinations(enumerate(scene.bodies), 2):
        if not (a.fixed and b.fixed) and frozenset((a.name, b.name)) not in joined:
            yield i, j


def _meeting(scene: Scene, i: int, j: int) -> float:
    """When the bounding balls of two bodies first meet in free flight [s]; inf if never; a half-space is itself."""
    if isinstance(scene.bodies[i].shape, HalfSpace):
        i, j = j, i
    a, b = scene.bodies[i], scene.bodies[j]
    r, v = np.subtract(a.position, b.position), np.subtract(a.velocity, b.velocity)
    pull = 0.5 * (_acceleration(scene, a) - _acceleration(scene, b))
    room = bounding_radius(a.shape)
    if isinstance(b.shape, HalfSpace):
        n = rotate(np.array(b.orientation), np.array(b.shape.normal))
        gap = [float(pull @ n), float(v @ n), float(r @ n) - room]
    else:
        room += bounding_radius(b.shape)
        gap = [float(c) for c in (pull @ pull, 2.0 * v @ pull, v @ v + 2.0 * r @ pull, 2.0 * r @ v)]
        gap.append(float(r @ r) - room**2)
    if gap[-1] <= 1e-9 * room * max(room, 1.0):
        return 0.0
    first = np.flatnonzero(gap)[0]
    roots = np.roots(gap[first:])
    times = roots.real[(np.abs(roots.imag) <= 1e-9 * np.abs(roots)) & (roots.real >= 0.0)]
    return float(times.min(initial=math.inf))


def _acceleration(scene: Scene, body: Body) -> np.ndarray:
    return np.array(body.acceleration if body.fixed else scene.gravity)


def _rotation(scene: Scene, duration: float, meeting: Meeting | str) -> tuple[str, str]:
    spinning = next((b.name for b in scene.bodies if any(b.angular_velocity)), "")
    if spinning:
        return ACTS, f"{spinning!r} turns at the start"
    for force in scene.all(Force):
        if force.start < duration and scene.moment(force).any():
            return ACTS, f"the force on {force.body!r} has a moment about its centre"
    for hinge in scene.all(Hinge):
        return ACTS, f"the hinge of {hinge.a!r} and {hinge.b!r} lets them turn and do nothing else"
    for link in (*scene.all(Spring), *scene.all(Rod), *scene.all(Tether)):
        for name, anchor in ((link.a, link.anchor_a), (link.b, link.anchor_b)):
            if any(anchor) and not scene.body(name).fixed:
                return MAY, f"the {type(link).__name__.lower()} of {name!r} does not pull at its centre"
    if not isinstance(meeting, str):
        for i, j in _pairs(scene):
            for k in (i, j):
                if not (scene.bodies[k].fixed or isinstance(scene.bodies[k].shape, Sphere)):
                    return MAY, f"what {scene.names[k]!r} touches need not push through its centre"
            if scene.friction(i, j) > 0.0:
                return MAY, f"friction turns {scene.names[i]!r} or {scene.names[j]!r}"
    return CANNOT, "every force passes through the centre of the body that it pushes, and nothing turns at the start"


def _restitution(scene: Scene, duration: float, meeting: Meeting | str) -> tuple[str, str]:
    if isinstance(meeting, str):
        return CANNOT, meeting
    if meeting.certain and meeting.time > 0.0:
        return ACTS, f"{meeting.a!r} and {meeting.b!r} collide at t = {meeting.time:.4g} s"
    when = "at the start" if meeting.time == 0.0 else f"from t = {meeting.time:.4g} s on"
    return MAY, f"{meeting.a!r} and {meeting.b!r} are near enough {when}"


def _resting(scene: Scene, duration: float, meeting: Meeting | str) -> tuple[str, str]:
    if isinstance(meeting, str):
        return CANNOT, meeting
    presses = [kind.__name__ for kind in (Gravity, Force, Spring, Rod, Tether, Hinge) if kind in scene.needs]
    presses += ["a fixed body that accelerates" for b in scene.bodies if any(b.acceleration)][:1]
    if not presses:
        return CANNOT, "nothing presses bodies together: what meets parts, or stays without a force"
    return MAY, f"{presses[0]} may press {meeting.a!r} and {meeting.b!r} together"


def _gravity(scene: Scene, effect: Gravity, duration: float, meeting: Meeting | str) -> tuple[str, str]:
    if not any(effect.acceleration):
        return CANNOT, "its acceleration is zero"
    return (ACTS, "it pulls every body that has a mass") if scene.moving else (CANNOT, "no body has a mass")


def _drag(scene: Scene, effect: Drag, duration: float, meeting: Meeting | str) -> tuple[str, str]:
    if not (effect.linear or (effect.angular and Rotation in scene.needs)):
        return CANNOT, "its coefficients are zero, or of turns that the scene does not allow"
    return ACTS, "it acts on whatever moves"


def _force(scene: Scene, effect: Force, duration: float, meeting: Meeting | str) -> tuple[str, str]:
    if effect.start >= duration:
        return CANNOT, f"it begins at t = {effect.start:g} s, after the end"
    if not (any(effect.force) or any(effect.torque)):
        return CANNOT, "it is zero"
    return ACTS, f"it pushes {effect.body!r} from t = {effect.start:g} s on"


def _friction(scene: Scene, effect: Friction, duration: float, meeting: Meeting | str) -> tuple[str, str]:
    if isinstance(meeting, str):
        return CANNOT, meeting
    if not any(effect.values()):
        return CANNOT, "every coefficient is zero"
    return MAY, f"{meeting.a!r} and {meeting.b!r} may touch, and slide or be held"


def _spring(scene: Scene, effect: Spring, duration: float, meeting: Meeting | str) -> tuple[str, str]:
    if not (effect.stiffness or effect.damping):
        return CANNOT, "it has neither stiffness nor damping"
    return _holds(scene, effect, duration, meeting)


def _holds(scene: Scene, effect: Any, duration: float, meeting: Meeting | str) -> tuple[str, str]:
    if scene.body(effect.a).fixed and scene.body(effect.b).fixed:
        return CANNOT, f"{effect.a!r} and {effect.b!r} are fixed anyway"
    return ACTS, f"it ties {effect.a!r} to {effect.b!r}"


def _tether(scene: Scene, effect: Tether, duration: float, meeting: Meeting | str) -> tuple[str, str]:
    answer, why = _holds(scene, effect, duration, meeting)
    return (MAY, f"{why} if it goes taut") if answer == ACTS else (answer, why)


_FOLLOWS: dict[type[Effect], Callable[[Scene, float, Meeting | str], tuple[str, str]]] = {
    Rotation: _rotation,
    Restitution: _restitution,
    Resting: _resting,
}
_GIVEN: dict[type[Effect], Callable[..., tuple[str, str]]] = {
    Gravity: _gravity,
    Drag: _drag,
    Force: _force,
    Spring: _spring,
    Friction: _friction,
    Rod: _holds,
    Tether: _tether,
    Hinge: _holds,
}
_UNASKED: dict[type[Effect], str] = {
    Gravity: "the scene has none: bodies keep their speed",
    Drag: "the scene has none: nothing slows bodies in flight",
    Force: "the scene has none",
    Spring: "the scene has none",
    Friction: "contact, if there is any, is smooth",
    Rod: "the scene has none",
    Tether: "the scene has none",
    Hinge: "the scene has none",
}
