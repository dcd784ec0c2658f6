"""What a scene's effects conserve.

The system is the bodies that have a mass.  Forces between them are internal: Newton's third law makes
their sum vanish, and, since each pair of them acts along one line, their moment too.  What is left is
what gravity, constant forces, drag and fixed bodies do.  Each is listed as an `External`, with the
directions in which it can push; a component of momentum is conserved if nothing can push that way.
Impulses that are known beforehand (gravity, constant forces and torques) are subtracted, not counted
against conservation.

Moments.  A force F at r has the moment (r - c) × F about c, which has no component

* along F: a constant force, or a frictionless half-space of normal n, whatever point it acts at,
  never changes the angular momentum along it;
* along Q - c, if F passes through the point Q: a string, rod or spring fastened at Q changes nothing
  about Q itself.

Both hold about a point at rest and about the common centre of mass, wherever that moves.

Without Rotation bodies are kept from turning by a couple from outside, of which nothing is known:
then r is the centre of the body, and only forces between centres leave the angular momentum alone.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import NamedTuple

import numpy as np

from mechanics.effects import Drag, Force, Friction, Hinge, Resting, Restitution, Rod, Rotation, Spring, Tether
from mechanics.rotation import rotate
from mechanics.scene import Body, Scene
from mechanics.shapes import HalfSpace, Sphere

EVERY = np.eye(3)
NONE = np.zeros((0, 3))
CENTRE = "the common centre of mass"


class External(NamedTuple):
    """Something outside the moving bodies that pushes them.

    Attributes
    ----------
    what : str
    force : (k, 3) array
        Directions in which it can push.
    impulse_known : bool
        Whether its impulse is known beforehand and subtracted.
    through : (3,) array or None
        Point at rest through which its force always passes [m].
    central : bool
        Whether its force passes through the centre of the body it pushes.
    couple : (k, 3) array
        Directions in which it can turn without pushing.
    uniform : bool
        Whether it acts on every body in proportion to its mass (gravity): no moment about the centre of mass.
    """

    what: str
    force: np.ndarray
    impulse_known: bool = False
    through: np.ndarray | None = None
    central: bool = False
    couple: np.ndarray = NONE
    uniform: bool = False


@dataclass(frozen=True)
class Conserved:
    """What is conserved, and why the rest is not.

    Attributes
    ----------
    linear, angular : (k, 3) arrays
        Orthonormal directions in which the momentum is conserved, after subtraction of known impulses.
    pivot : (3,) array or None
        Point at rest about which the angular momentum is taken [m]; None: the common centre of mass.
    energy : str
        "conserved", "may only fall" or "unknown".
    linear_why, angular_why, energy_why : tuple of str
        What takes something away, or is accounted for, in words.
    """

    linear: np.ndarray
    angular: np.ndarray
    pivot: np.ndarray | None
    energy: str
    linear_why: tuple[str, ...]
    angular_why: tuple[str, ...]
    energy_why: tuple[str, ...]

    def sentences(self) -> tuple[str, ...]:
        """Three sentences for people: linear momentum, angular momentum, energy."""
        about = CENTRE if self.pivot is None else f"the point {_words(self.pivot)}"
        return (
            _sentence("linear momentum", _directions(self.linear), self.linear_why),
            _sentence(f"angular momentum about {about}", _directions(self.angular), self.angular_why),
            _sentence("energy", self.energy, self.energy_why),
        )


def conserved(scene: Scene, duration: float = math.inf) -> Conserved:
    """What the effects of `scene` conserve while `duration` [s] passes."""
    externals = list(_externals(scene))
    linear = _complement([e.force for e in externals if not e.impulse_known])
    linear_why = tuple(_linear_word(e) for e in externals if len(e.force))
    angular, pivot, angular_why = _angular(scene, externals)
    energy, energy_why = _energy(scene, duration)
    return Conserved(linear, angular, pivot, energy, linear_why, angular_why, energy_why)


def _externals(scene: Scene) -> Iterator[External]:
    if np.any(scene.gravity):
        yield External("gravity", _unit(scene.gravity), impulse_known=True, uniform=True)
    for force in scene.all(Force):
        if np.any(force.force):
            what, central = f"the force on {force.body}", not any(force.point) or Rotation not in scene.needs
            yield External(what, _unit(force.force), impulse_known=True, central=central)
    for drag in scene.all(Drag):
        if drag.linear or drag.angular:
            yield External("drag", EVERY if drag.linear else NONE, central=True, couple=EVERY if drag.angular else NONE)
    yield from _links(scene)
    yield from _touches(scene)


def _links(scene: Scene) -> Iterator[External]:
    """Springs, rods, tethers and hinges that end on a fixed body."""
    for link in chain(scene.all(Spring), scene.all(Rod), scene.all(Tether)):
        ends = ((scene.body(link.a), link.anchor_a), (scene.body(link.b), link.anchor_b))
        fixed = [end for end in ends if end[0].fixed]
        idle = isinstance(link, Spring) and not (link.stiffness or link.damping)
        if len(fixed) == 1 and not idle:
            central = not any(next(anchor for body, anchor in ends if not body.fixed))
            body, anchor = fixed[0]
            what = f"the {type(link).__name__.lower()} to {body.name}"
            yield External(what, EVERY, through=_at_rest(body, anchor), central=central)
    for hinge in scene.all(Hinge):
        ends = [scene.body(hinge.a), scene.body(hinge.b)]
        fixed_ends = [body for body in ends if body.fixed]
        if len(fixed_ends) == 1:
            point = np.array(hinge.point) if _static(fixed_ends[0]) else None
            couple = _complement([_unit(hinge.axis)])
            yield External(f"the hinge to {fixed_ends[0].name}", EVERY, through=point, couple=couple)


def _touches(scene: Scene) -> Iterator[External]:
    """Fixed bodies that can be touched."""
    for i, j in scene.pairs():
        a, b = scene.bodies[i], scene.bodies[j]
        if not (a.fixed or b.fixed):
            continue
        fixed, body = (a, b) if a.fixed else (b, a)
        if scene.friction(i, j) > 0.0:
            yield External(f"{fixed.name}, which has friction", EVERY)
        elif isinstance(fixed.shape, HalfSpace):
            normal = rotate(np.array(fixed.orientation), np.array(fixed.shape.normal))
            what = f"{fixed.name}, a smooth half-space of normal {_words(normal)}"
            yield External(what, _unit(normal), central=isinstance(body.shape, Sphere))
        else:
            through = np.array(fixed.position) if isinstance(fixed.shape, Sphere) and _static(fixed) else None
            what = f"{fixed.name}, which can be touched from several sides"
            yield External(what, EVERY, through=through, central=isinstance(body.shape, Sphere))


def _angular(scene: Scene, externals: Sequence[External]) -> tuple[np.ndarray, np.ndarray | None, tuple[str, ...]]:
    if Rotation not in scene.needs and len(scene.moving) == 1:
        return NONE, None, ("one body that does not turn has none",)
    locked = "" if Rotation in scene.needs else _locking(scene)
    if locked:
        return NONE, None, (locked,)
    points = [e.through for e in externals if e.through is not None and (e.central or Rotation in scene.needs)]
    best: tuple[np.ndarray, np.ndarray | None, tuple[str, ...]] = (NONE, None, ())
    for pivot in (None, *points):
        moments = [_moments(e, pivot, scene) for e in externals]
        free = _complement(moments)
        if pivot is None or len(free) > len(best[0]):
            best = free, pivot, tuple(e.what for e, m in zip(externals, moments, strict=True) if len(m))
    return best


def _moments(external: External, pivot: np.ndarray | None, scene: Scene) -> np.ndarray:
    """Directions of the moment that `external` can have about `pivot`."""
    turning = Rotation in scene.needs
    couple = external.couple if turning else NONE
    if pivot is None and (external.uniform or (external.central and len(scene.moving) == 1)):
        return couple
    known_line = external.through is not None and (external.central or turning)
    if pivot is not None and known_line:
        lever = np.asarray(external.through) - pivot
        arms = np.cross(lever, external.force) if np.linalg.norm(lever) > 1e-12 else NONE
    elif len(external.force) == 1:
        arms = _complement([external.force])  # moments are at right angles to the force
    else:
        arms = EVERY if len(external.force) else NONE
    return np.vstack([arms, couple])


def _locking(scene: Scene) -> str:
    """Which force between moving bodies that do not turn is not along the line of their centres; "" if none."""
    unknown = "and the couple that keeps them from turning is not known"
    for i, j in scene.pairs():
        a, b = scene.bodies[i], scene.bodies[j]
        smooth_spheres = isinstance(a.shape, Sphere) and isinstance(b.shape, Sphere) and not scene.friction(i, j)
        if not (a.fixed or b.fixed or smooth_spheres):
            return f"{a.name} and {b.name} touch off their centres, {unknown}"
    for link in chain(scene.all(Spring), scene.all(Rod), scene.all(Tether), scene.all(Hinge)):
        moving = not (scene.body(link.a).fixed or scene.body(link.b).fixed)
        if moving and (isinstance(link, Hinge) or any(link.anchor_a) or any(link.anchor_b)):
            kind = type(link).__name__.lower()
            return f"the {kind} of {link.a} and {link.b} pulls off their centres, {unknown}"
    return ""


def _energy(scene: Scene, duration: float) -> tuple[str, tuple[str, ...]]:
    driven = tuple(_driven(scene, duration))
    if driven:
        return "unknown", driven
    losses = tuple(dict.fromkeys(_losses(scene)))
    return ("may only fall", losses) if losses else ("conserved", ())


def _driven(scene: Scene, duration: float) -> Iterator[str]:
    for force in scene.all(Force):
        if any(force.torque) and Rotation in scene.needs:
            yield f"the torque on {force.body} does work that is not known from the attitude alone"
        if any(force.force) and not (force.start == 0.0 and force.end >= duration) and force.start < duration:
            yield f"the force on {force.body} is switched while the scene runs"
    involved = {k for pair in scene.pairs() for k in pair}
    for link in chain(scene.all(Spring), scene.all(Rod), scene.all(Tether), scene.all(Hinge)):
        involved |= {scene.index(link.a), scene.index(link.b)}
    for i in sorted(involved):
        if scene.bodies[i].fixed and not _static(scene.bodies[i]):
            yield f"{scene.names[i]} moves by prescription and does work"


def _losses(scene: Scene) -> Iterator[str]:
    pairs = list(scene.pairs())
    if any(scene.restitution(i, j) < 1.0 for i, j in pairs):
        kinds = {
            Restitution: "restitution below 1",
            Resting: "resting contact",
            Friction: "contact without restitution",
        }
        yield next(words for kind, words in kinds.items() if kind in scene.needs)
    if any(scene.friction(i, j) > 0.0 for i, j in pairs):
        yield "friction"
    if any(d.linear or d.angular for d in scene.all(Drag)):
        yield "drag"
    if any(s.damping for s in scene.all(Spring)):
        yield "a damped spring"
    if any(t.restitution < 1.0 for t in scene.all(Tether)):
        yield "a tether that goes taut"


def _static(body: Body) -> bool:
    return not (any(body.velocity) or any(body.acceleration))


def _at_rest(body: Body, anchor: tuple[float, ...]) -> np.ndarray | None:
    if not _static(body):
        return None
    return np.asarray(np.array(body.position) + rotate(np.array(body.orientation), np.array(anchor)))


def _unit(vector: object) -> np.ndarray:
    v = np.asarray(vector, dtype=np.float64)
    return np.asarray((v / np.linalg.norm(v))[None])


def _complement(taken: Sequence[np.ndarray]) -> np.ndarray:
    """Orthonormal directions at right angles to every row of `taken`; coordinate axes where they are."""
    rows = np.vstack([NONE, *taken])
    lengths = np.linalg.norm(rows, axis=1)
    rows = rows[lengths > 0.0] / lengths[lengths > 0.0, None]
    if not len(rows):
        return EVERY
    _, sizes, directions = np.linalg.svd(rows, full_matrices=True)
    free = directions[np.count_nonzero(sizes > 1e-9) :]
    axes = np.array([axis for axis in EVERY if np.linalg.norm(free @ axis) > 1.0 - 1e-15]).reshape(-1, 3)
    return axes if len(axes) == len(free) else free


def _linear_word(external: External) -> str:
    return f"{external.what} (its impulse is known and subtracted)" if external.impulse_known else external.what


def _words(vector: np.ndarray) -> str:
    return "(" + ", ".join(f"{c + 0.0:.6g}" for c in vector) + ")"


def _directions(basis: np.ndarray) -> str:
    if len(basis) == 3:
        return "conserved"
    if len(basis) == 0:
        return "not judged"
    names = {(1.0, 0.0, 0.0): "x", (0.0, 1.0, 0.0): "y", (0.0, 0.0, 1.0): "z"}
    words = [names.get(tuple(np.abs(d).tolist()), _words(d)) for d in basis]
    return "conserved along " + " and ".join(words)


def _sentence(subject: str, verdict: str, why: tuple[str, ...]) -> str:
    listed = ", ".join(dict.fromkeys(why))
    reason = f": {listed}" if listed else ""
    return f"{subject}: {verdict}{reason}"
