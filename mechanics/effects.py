"""The effects, as values.

An effect is switched on by standing in a scene and off by not standing there; its fields say how
strongly it acts.  Vectors are in the world frame unless a field says otherwise.  Bodies are named.
Contact coefficients belong to the *pair* of bodies: `coefficient` holds for every pair and
`between` lists the exceptions.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields
from typing import cast

from mechanics.arrays import SceneError, Triple, real, reals

Pairs = tuple[tuple[tuple[str, str], float], ...]


@dataclass(frozen=True)
class Effect:
    """Base of all effects; `single` effects may stand in a scene only once."""

    single = False

    def names(self) -> tuple[str, ...]:
        """Names of the bodies this effect refers to."""
        return tuple(getattr(self, f.name) for f in fields(self) if f.name in ("a", "b", "body"))


@dataclass(frozen=True)
class Gravity(Effect):
    """Uniform gravity: every body accelerates by `acceleration` [m/s2]."""

    acceleration: Triple = (0.0, 0.0, -9.81)
    single = True

    def __post_init__(self) -> None:
        _set(self, "acceleration", reals("acceleration", self.acceleration, 3))


@dataclass(frozen=True)
class Rotation(Effect):
    """Bodies may turn.  Without it no body turns, whatever acts on it."""

    single = True


@dataclass(frozen=True)
class Drag(Effect):
    """Linear drag: force -`linear` v [kg/s] and torque -`angular` ω [N m s] on `bodies` (none named: all)."""

    linear: float = 0.0
    angular: float = 0.0
    bodies: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        _set(self, "linear", real("linear", self.linear, least=0.0))
        _set(self, "angular", real("angular", self.angular, least=0.0))
        _set(self, "bodies", tuple(self.bodies))

    def names(self) -> tuple[str, ...]:
        return self.bodies


@dataclass(frozen=True)
class Force(Effect):
    """Constant `force` [N] at `point` (body frame [m]) and `torque` [N m] on `body` while start <= t < end [s]."""

    body: str
    force: Triple = (0.0, 0.0, 0.0)
    torque: Triple = (0.0, 0.0, 0.0)
    point: Triple = (0.0, 0.0, 0.0)
    start: float = 0.0
    end: float = math.inf

    def __post_init__(self) -> None:
        for name in ("force", "torque", "point"):
            _set(self, name, reals(name, getattr(self, name), 3))
        _set(self, "start", real("start", self.start, least=0.0))
        if self.end != math.inf:
            _set(self, "end", real("end", self.end, above=self.start))


@dataclass(frozen=True)
class Spring(Effect):
    """Spring and damper in line between two anchors (body frames [m]).

    Tension `stiffness` (d - `length`) + `damping` ḋ [N/m, m, N s/m] at distance d of the anchors.
    """

    a: str
    b: str
    stiffness: float
    length: float
    damping: float = 0.0
    anchor_a: Triple = (0.0, 0.0, 0.0)
    anchor_b: Triple = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        _set(self, "stiffness", real("stiffness", self.stiffness, least=0.0))
        _set(self, "length", real("length", self.length, least=0.0))
        _set(self, "damping", real("damping", self.damping, least=0.0))
        _anchors(self)


@dataclass(frozen=True)
class PairEffect(Effect):
    """A contact effect with one coefficient for every pair of bodies and exceptions in `between`.

    `between` may be given as a mapping {(name, name): coefficient}.
    """

    coefficient: float
    between: Pairs | Mapping[tuple[str, str], float] = field(default=())
    single = True

    def __post_init__(self) -> None:
        _set(self, "coefficient", self._checked("coefficient", self.coefficient))
        given = self.between.items() if isinstance(self.between, Mapping) else self.between
        _set(self, "between", self._pairs(given))

    def _checked(self, name: str, value: object) -> float:
        return real(name, value, least=0.0)

    def _pairs(self, given: Iterable[tuple[tuple[str, str], float]]) -> Pairs:
        pairs: dict[tuple[str, str], float] = {}
        for names, value in given:
            if len(names) != 2 or names[0] == names[1]:
                raise SceneError("between", names, "two different body names")
            a, b = sorted(names)
            if (a, b) in pairs:
                raise SceneError("between", names, "each pair once")
            pairs[a, b] = self._checked(f"between[{a}, {b}]", value)
        return tuple(sorted(pairs.items()))

    @property
    def exceptions(self) -> dict[tuple[str, str], float]:
        """Coefficients of the named pairs, names in alphabetical order."""
        return dict(cast(Pairs, self.between))

    def of(self, a: str, b: str) -> float:
        """Coefficient of the pair of bodies named a and b, in either order."""
        return self.exceptions.get((a, b) if a < b else (b, a), self.coefficient)

    def values(self) -> tuple[float, ...]:
        """Every coefficient that stands in this effect, the default first."""
        return (self.coefficient, *self.exceptions.values())

    def names(self) -> tuple[str, ...]:
        return tuple(name for pair in self.exceptions for name in pair)


@dataclass(frozen=True)
class Restitution(PairEffect):
    """Bodies that collide part at e times the speed of approach: u⁺ = -e u⁻ along the normal, 0 <= e <= 1 (Newton)."""

    def _checked(self, name: str, value: object) -> float:
        return real(name, value, least=0.0, most=1.0)


@dataclass(frozen=True)
class Friction(PairEffect):
    """Coulomb friction with one coefficient µ >= 0, static = kinetic, isotropic."""


@dataclass(frozen=True)
class Resting(Effect):
    """Bodies may lie on each other: contact that lasts, 0 <= gap'' complementary to force >= 0."""

    single = True


@dataclass(frozen=True)
class Rod(Effect):
    """Massless rigid rod: the distance of two anchors (body frames [m]) stays what it is at the start."""

    a: str
    b: str
    anchor_a: Triple = (0.0, 0.0, 0.0)
    anchor_b: Triple = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        _anchors(self)


@dataclass(frozen=True)
class Tether(Effect):
    """Massless inextensible string of `length` [m] between two anchors (body frames [m]).

    Slack while the anchors are closer; when it goes taut the anchors part at `restitution` times
    the speed at which they drew away.
    """

    a: str
    b: str
    length: float
    restitution: float = 0.0
    anchor_a: Triple = (0.0, 0.0, 0.0)
    anchor_b: Triple = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        _set(self, "length", real("length", self.length, above=0.0))
        _set(self, "restitution", real("restitution", self.restitution, least=0.0, most=1.0))
        _anchors(self)


@dataclass(frozen=True)
class Hinge(Effect):
    """Two bodies share `point` and turn against each other about `axis` only.

    Both are given in the world frame as they are at the start, so a hinge is never violated there.
    Hinged bodies do not touch each other.
    """

    a: str
    b: str
    point: Triple = (0.0, 0.0, 0.0)
    axis: Triple = (0.0, 1.0, 0.0)

    def __post_init__(self) -> None:
        _set(self, "point", reals("point", self.point, 3))
        axis = reals("axis", self.axis, 3)
        length = math.sqrt(sum(c * c for c in axis))
        if not 1e-150 < length < 1e150:
            raise SceneError("axis", self.axis, "a vector that can be normalised")
        _set(self, "axis", tuple(c / length for c in axis))


CONTACT_EFFECTS: tuple[type[Effect], ...] = (Restitution, Friction, Resting)

EFFECTS: dict[str, type[Effect]] = {
    e.__name__: e for e in (Gravity, Rotation, Drag, Force, Spring, Restitution, Friction, Resting, Rod, Tether, Hinge)
}


def _set(effect: Effect, name: str, value: object) -> None:
    object.__setattr__(effect, name, value)


def _anchors(effect: Effect) -> None:
    for name in ("anchor_a", "anchor_b"):
        _set(effect, name, reals(name, getattr(effect, name), 3))
