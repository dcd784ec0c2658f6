"""Bodies and scenes.  An ill-posed scene cannot be constructed.

A scene says what there is and what acts.  It knows no time step, no solver and no duration.
World frame: right-handed, z up, SI units.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import TypeVar

import numpy as np

from mechanics.arrays import Mat33, SceneError, Triple, Vec3, frozen, real, reals
from mechanics.effects import CONTACT_EFFECTS, Effect, Force, Friction, Gravity, Hinge, Restitution, Rod, Rotation
from mechanics.inertia import check_inertia, mass_properties
from mechanics.rotation import IDENTITY, rotate
from mechanics.shapes import SHAPES, HalfSpace, Mesh, Shape, Sphere
from mechanics.trajectory import State

E = TypeVar("E", bound=Effect)


@dataclass(frozen=True)
class Body:
    """A rigid body.

    Parameters
    ----------
    name : str
    shape : Shape
    mass : float or None
        [kg]; None = fixed: moved by nothing.
    position : (3,) [m]
        Of the centre of mass, world frame.
    orientation : (4,)
        Quaternion (w, x, y, z), body to world; made a unit quaternion.
    velocity : (3,) [m/s], angular_velocity : (3,) [rad/s]
        World frame.  A fixed body with a velocity moves at it for ever (a conveyor, a piston).
    inertia : (3,) or (3, 3), optional [kg m2]
        Principal moments along the body axes, or tensor in the body frame, about the centre of
        mass.  Without it: that of the homogeneous shape.
    acceleration : (3,) [m/s2]
        Of a fixed body with prescribed motion; zero for every other.

    Raises
    ------
    SceneError
        For negative, zero or NaN mass, impossible inertia, infinite or NaN state, a quaternion that
        cannot be normalised, a moving HalfSpace, a mesh whose centre of mass is not the origin.
    """

    name: str
    shape: Shape
    mass: float | None = None
    position: Triple = (0.0, 0.0, 0.0)
    orientation: tuple[float, float, float, float] = IDENTITY
    velocity: Triple = (0.0, 0.0, 0.0)
    angular_velocity: Triple = (0.0, 0.0, 0.0)
    inertia: tuple[float, ...] | tuple[tuple[float, ...], ...] | None = None
    acceleration: Triple = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name:
            raise SceneError("body.name", self.name, "a non-empty text")
        try:
            self._check()
        except SceneError as error:
            raise error.within(f"body {self.name!r}") from None

    def _check(self) -> None:
        if not isinstance(self.shape, tuple(SHAPES.values())):
            raise SceneError("shape", self.shape, f"one of {', '.join(SHAPES)}")
        for name in ("position", "velocity", "angular_velocity", "acceleration"):
            object.__setattr__(self, name, reals(name, getattr(self, name), 3))
        object.__setattr__(self, "orientation", _unit_quaternion(self.orientation))
        if self.fixed:
            self._check_fixed()
        else:
            self._check_moving()

    def _check_fixed(self) -> None:
        if self.inertia is not None:
            raise SceneError("inertia", self.inertia, "no inertia for a fixed body (mass None)")
        if any(self.angular_velocity):
            raise SceneError("angular_velocity", self.angular_velocity, "zero: fixed bodies do not turn")

    def _check_moving(self) -> None:
        object.__setattr__(self, "mass", real("mass", self.mass, above=0.0))
        if isinstance(self.shape, HalfSpace):
            raise SceneError("mass", self.mass, "None: a HalfSpace can only be fixed")
        if any(self.acceleration):
            raise SceneError("acceleration", self.acceleration, "zero: only fixed bodies have a prescribed motion")
        if self.inertia is not None:
            object.__setattr__(self, "inertia", _inertia(self.inertia))
            check_inertia("inertia", self.inertia_tensor)
        if isinstance(self.shape, Mesh):
            offset = np.abs(mass_properties(self.shape).centre).max()
            if offset > 1e-9 * float(np.abs(self.shape.vertices).max()):
                raise SceneError("shape", f"Mesh with its centre of mass {offset:g} m off", "use Mesh.centred()")

    @property
    def fixed(self) -> bool:
        """Whether nothing can move this body."""
        return self.mass is None

    @property
    def inertia_tensor(self) -> Mat33:
        """Inertia about the centre of mass, body frame [kg m2].

        Raises
        ------
        SceneError
            For a fixed body, which has none.
        """
        if self.mass is None:
            raise SceneError(f"body {self.name!r}.inertia", None, "a body with a mass")
        if self.inertia is None:
            return frozen(self.mass * mass_properties(self.shape).inertia)
        given = np.array(self.inertia, dtype=np.float64)
        return frozen(np.diag(given) if given.ndim == 1 else given)


@dataclass(frozen=True)
class Scene:
    """Bodies and the effects that act on them.

    Raises
    ------
    SceneError
        For a scene without bodies, repeated or unknown body names, an effect given twice, or a
        body that turns in a scene without Rotation.
    """

    bodies: tuple[Body, ...]
    effects: tuple[Effect, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "bodies", _tuple_of(Body, "bodies", self.bodies))
        object.__setattr__(self, "effects", _tuple_of(Effect, "effects", self.effects))
        if not self.bodies:
            raise SceneError("bodies", (), "at least one body")
        names = [b.name for b in self.bodies]
        for name, count in Counter(names).items():
            if count > 1:
                raise SceneError("bodies", name, "every body name once")
        for kind, count in Counter(type(e) for e in self.effects).items():
            if kind.single and count > 1:
                raise SceneError("effects", kind.__name__, f"one {kind.__name__} at most (there are {count})")
        for effect in self.effects:
            self._check_names(effect, names)
        if Rotation not in self.needs:
            for body in self.bodies:
                if any(body.angular_velocity):
                    allowed = "zero, or Rotation() among the effects"
                    raise SceneError(f"body {body.name!r}.angular_velocity", body.angular_velocity, allowed)

    def _check_names(self, effect: Effect, names: Sequence[str]) -> None:
        kind = type(effect).__name__
        for name in effect.names():
            if name not in names:
                raise SceneError(kind, name, f"a body of the scene: {', '.join(names)}")
        ends = (getattr(effect, "a", None), getattr(effect, "b", None))
        if ends[0] is not None and ends[0] == ends[1]:
            raise SceneError(kind, ends, "two different bodies")
        driven = getattr(effect, "body", None)
        if driven is not None and self.body(driven).fixed:
            raise SceneError(f"{kind}.body", driven, "a body with a mass")

    @cached_property
    def needs(self) -> frozenset[type[Effect]]:
        """The types of all effects of the scene."""
        return frozenset(type(e) for e in self.effects)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the bodies in scene order."""
        return tuple(b.name for b in self.bodies)

    def index(self, name: str) -> int:
        """Place of the body `name` in the scene.

        Raises
        ------
        SceneError
            If there is no such body.
        """
        if name not in self.names:
            raise SceneError("body", name, f"a body of the scene: {', '.join(self.names)}")
        return self.names.index(name)

    def body(self, name: str) -> Body:
        """The body `name`; raises SceneError if there is none."""
        return self.bodies[self.index(name)]

    def effect(self, kind: type[E]) -> E | None:
        """The first effect of type `kind`, or None."""
        return next((e for e in self.effects if isinstance(e, kind)), None)

    def all(self, kind: type[E]) -> tuple[E, ...]:
        """Every effect of type `kind`."""
        return tuple(e for e in self.effects if isinstance(e, kind))

    @cached_property
    def moving(self) -> tuple[int, ...]:
        """Places of the bodies that have a mass."""
        return tuple(i for i, b in enumerate(self.bodies) if not b.fixed)

    @property
    def gravity(self) -> Vec3:
        """Acceleration by gravity [m/s2]; zero where none is declared."""
        gravity = self.effect(Gravity)
        return frozen(gravity.acceleration if gravity else (0.0, 0.0, 0.0))

    @property
    def touching(self) -> bool:
        """Whether bodies can touch at all: some contact effect is declared."""
        return any(kind in self.needs for kind in CONTACT_EFFECTS)

    def pairs(self) -> Iterator[tuple[int, int]]:
        """Places (i < j) of the bodies that may touch: not both fixed, not joined by a Rod or Hinge."""
        if not self.touching:
            return
        joined = {frozenset((e.a, e.b)) for kind in (Rod, Hinge) for e in self.all(kind)}  # type: ignore[attr-defined]
        for (i, a), (j, b) in combinations(enumerate(self.bodies), 2):
            if not (a.fixed and b.fixed) and not (joined and frozenset((a.name, b.name)) in joined):
                yield i, j

    def restitution(self, i: int, j: int) -> float:
        """Coefficient of restitution of bodies i and j; 0 where Restitution is not declared."""
        effect = self.effect(Restitution)
        return effect.of(self.names[i], self.names[j]) if effect else 0.0

    def friction(self, i: int, j: int) -> float:
        """Coefficient of friction of bodies i and j; 0 where Friction is not declared."""
        effect = self.effect(Friction)
        return effect.of(self.names[i], self.names[j]) if effect else 0.0

    def moment(self, force: Force) -> Vec3:
        """Moment of `force` about the centre of its body as that is turned at the start, world frame [N m].

        Without Rotation it stays so.  In line with the centre it is zero, not the rounding of a product.
        """
        arm, push = rotate(np.array(self.body(force.body).orientation), np.array(force.point)), np.array(force.force)
        turning = np.cross(arm, push)
        turning[np.abs(turning) <= 1e-15 * np.linalg.norm(arm) * np.linalg.norm(push)] = 0.0
        return frozen(turning + np.array(force.torque))

    def start(self) -> State:
        """The state at t = 0, in scene order."""
        return State(
            0.0,
            frozen([b.position for b in self.bodies]),
            frozen([b.orientation for b in self.bodies]),
            frozen([b.velocity for b in self.bodies]),
            frozen([b.angular_velocity for b in self.bodies]),
        )

    def out_of_plane(self) -> str | None:
        """Why this scene is not planar (motion in the x-z plane, rotation about y), or None if it is.

        Planar means: every moving body has the same y; bodies are turned about y only (a sphere
        has no attitude to mind); velocities, gravity and forces lie in the plane, spins and torques
        along y; half-spaces have their normal in the plane.
        """
        level = None
        for body in self.bodies:
            reason = _leaves_plane(body)
            if reason:
                return f"body {body.name!r}: {reason}"
            if not body.fixed:
                if level is not None and body.position[1] != level:
                    return f"body {body.name!r}: y = {body.position[1]:g} m, others at {level:g} m"
                level = body.position[1]
        for effect in self.effects:
            for name, across in (("acceleration", False), ("force", False), ("point", False), ("anchor_a", False),
                                 ("anchor_b", False), ("torque", True), ("axis", True)):  # fmt: skip
                vector = getattr(effect, name, None)
                if vector is not None and not (isinstance(effect, Hinge) and name == "point"):
                    bad = (vector[0] or vector[2]) if across else vector[1]
                    if bad:
                        return f"{type(effect).__name__}.{name} = {vector}"
        return None


def _leaves_plane(body: Body) -> str | None:
    _, x, _, z = body.orientation
    if not isinstance(body.shape, Sphere) and (x or z):
        return f"orientation {body.orientation} is not about y"
    if isinstance(body.shape, HalfSpace) and body.shape.normal[1]:
        return f"normal {body.shape.normal} is not in the x-z plane"
    if body.velocity[1] or body.acceleration[1]:
        return f"velocity {body.velocity} is not in the x-z plane"
    if body.angular_velocity[0] or body.angular_velocity[2]:
        return f"angular velocity {body.angular_velocity} is not along y"
    return None


def _unit_quaternion(value: object) -> tuple[float, ...]:
    q = reals("orientation", value, 4)
    norm = math.sqrt(sum(c * c for c in q))
    if not 1e-150 < norm < 1e150:
        raise SceneError("orientation", value, "a quaternion that can be normalised (not zero)")
    # a quaternion that already has unit length stays bitwise as it is
    return q if abs(norm - 1.0) < 1e-15 else tuple(c / norm for c in q)


def _inertia(value: Sequence[object]) -> tuple[object, ...]:
    allowed = "3 principal moments or a 3 x 3 tensor"
    if isinstance(value, (str, bytes)) or not isinstance(value, (Sequence, np.ndarray)) or len(value) != 3:
        raise SceneError("inertia", value, allowed)
    if all(isinstance(row, (Sequence, np.ndarray)) for row in value):
        return tuple(reals(f"inertia[{i}]", row, 3) for i, row in enumerate(value))
    return reals("inertia", value, 3, above=0.0)


def _tuple_of(kind: type, field: str, values: Iterable[object]) -> tuple[object, ...]:
    if isinstance(values, (str, bytes)) or not isinstance(values, Iterable):
        raise SceneError(field, values, f"a sequence of {kind.__name__}")
    items = tuple(values)
    for n, item in enumerate(items):
        if not isinstance(item, kind):
            raise SceneError(f"{field}[{n}]", item, f"a {kind.__name__}")
    return items
