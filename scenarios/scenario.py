"""Scenario: a scene, how long, what is known about it, and which effects it is about.

A family of scenarios is a function of parameters, decorated with `scenario`:

    @scenario(tags=("impact",), suites=("smoke", "standard"), variants=({}, {"e": 0.3}), ranges={"e": (0.0, 1.0)})
    def bouncing_ball(e: float = 0.8) -> Scenario: ...

The catalogue finds it by importing the file; nothing else has to be touched.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from mechanics.effects import Effect
from mechanics.scene import Scene
from mechanics.trajectory import Trajectory
from scenarios.exhibit import Exhibit

Truth = Callable[[np.ndarray], Trajectory]


@dataclass(frozen=True)
class Check:
    """What is demanded of one measured quantity.

    Attributes
    ----------
    quantity : str
        Name of a quantity of `comparisons`, for example "position error".
    tolerance : float
        Largest value a careful user accepts, in the quantity's unit; the same for every engine.
    why : str
        Where the tolerance comes from.
    exact : float
        Largest value of a computation that errs by rounding only; an engine within it is marked exact.
    """

    quantity: str
    tolerance: float
    why: str
    exact: float = 1e-9


@dataclass(frozen=True)
class Scenario:
    """A question with its answer key.  Engines get `scene`, never the scenario.

    Attributes
    ----------
    scene : Scene
    duration : float
        [s]
    sampling : float
        Interval between recorded states [s].
    truth : function (T,) times -> Trajectory, or None
        NaN where nothing is known.  Velocities are right-continuous at impacts.
    checks : tuple of Check
    source : str
        Where the truth comes from (a citation).
    about : tuple of effect types
        What the scenario tests.
    events : tuple of float
        Times of the true impacts [s]; velocities are not compared within `guard` [s] of them, where
        an engine with time steps is before or behind the jump by the nature of stepping.
    guard : float
    laws : mapping of str to Trajectory-independent final velocities, or empty
        Where mechanics leaves the answer to the impact law: admissible law -> (n, 3) final velocities
        of all bodies.  The realised law is named, not marked.
    exhibit : Exhibit or None
        What makes it an exhibit of the museum.
    name, version, summary, tags, suites, because, parameters
        Filled in by the `scenario` decorator.  `because`: effect type -> why it is declared although the true motion
        is the same without it.
    """

    scene: Scene
    duration: float
    sampling: float
    checks: tuple[Check, ...]
    source: str
    about: tuple[type[Effect], ...] = ()
    truth: Truth | None = None
    events: tuple[float, ...] = ()
    guard: float = 5e-3
    laws: Mapping[str, tuple[tuple[float, float, float], ...]] = field(default_factory=dict)
    exhibit: Exhibit | None = None
    name: str = ""
    version: int = 1
    summary: str = ""
    tags: tuple[str, ...] = ()
    suites: tuple[str, ...] = ()
    because: Mapping[type[Effect], str] = field(default_factory=dict)
    parameters: Mapping[str, object] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ("duration", "sampling"):
            value = getattr(self, name)
            if not (isinstance(value, (int, float)) and math.isfinite(value) and value > 0.0):
                raise ValueError(f"Scenario.{name} = {value!r} is not possible: a finite number > 0")

    @property
    def family(self) -> str:
        """Name without parameters."""
        return self.name.partition("[")[0]


@dataclass(frozen=True)
class Family:
    """Scenarios that differ in parameters only.

    Attributes
    ----------
    build : function of the parameters -> Scenario
    variants : tuple of dict
        Parameter sets that suites run; the first is the default and the one the smoke suite takes.
    ranges : mapping
        Parameter -> (least, most), both allowed, or a tuple of allowed values if they are words.
    because : mapping
        As in `Scenario`, for every variant of which it is true.
    """

    name: str
    build: Callable[..., Scenario]
    version: int
    tags: tuple[str, ...]
    suites: tuple[str, ...]
    variants: tuple[Mapping[str, object], ...]
    ranges: Mapping[str, Sequence[object]]
    because: Mapping[type[Effect], str]

    @property
    def defaults(self) -> dict[str, object]:
        """Every parameter with its default value."""
        return {n: p.default for n, p in inspect.signature(self.build).parameters.items()}

    def of(self, **parameters: object) -> Scenario:
        """The scenario with these parameters, defaults for the others.

        Raises
        ------
        ValueError
            For an unknown parameter or a value out of its range.
        """
        values = self.defaults
        for name, value in parameters.items():
            if name not in values:
                raise ValueError(f"{self.name} has no parameter {name!r}; it has {', '.join(values) or 'none'}")
            self._check(name, value)
            values[name] = type(values[name])(value)  # type: ignore[call-arg]
        changed = {n: v for n, v in values.items() if v != self.defaults[n]}
        label = ",".join(f"{n}={_short(v)}" for n, v in changed.items())
        return replace(
            self.build(**values),
            name=f"{self.name}[{label}]" if label else self.name,
            version=self.version,
            summary=inspect.cleandoc(self.build.__doc__ or ""),
            tags=self.tags,
            suites=self.suites,
            because=self.because,
            parameters=values,
        )

    def _check(self, name: str, value: object) -> None:
        allowed = self.ranges.get(name)
        if allowed is None:
            return
        if any(isinstance(a, str) for a in allowed):
            if value not in allowed:
                raise ValueError(f"{self.name}: {name} = {value!r}; allowed: {', '.join(map(str, allowed))}")
        elif not (isinstance(value, (int, float)) and allowed[0] <= value <= allowed[1]):  # type: ignore[operator]
            raise ValueError(f"{self.name}: {name} = {value!r}; allowed: {allowed[0]} to {allowed[1]}")

    def all(self) -> tuple[Scenario, ...]:
        """Every variant, the default first."""
        return tuple(self.of(**v) for v in self.variants)


FAMILIES: dict[str, Family] = {}


def scenario(
    *,
    tags: Sequence[str],
    suites: Sequence[str] = ("standard",),
    variants: Sequence[Mapping[str, object]] = ({},),
    ranges: Mapping[str, Sequence[object]] | None = None,
    because: Mapping[type[Effect], str] | None = None,
    version: int = 1,
) -> Callable[[Callable[..., Scenario]], Callable[..., Scenario]]:
    """Enter the decorated function in the catalogue; its name becomes the scenario's, `_` written `-`.

    Every family belongs to the suite `full`, besides the `suites` it names.

    Raises
    ------
    ValueError
        If the name is taken or the function has no docstring.
    """

    def enter(build: Callable[..., Scenario]) -> Callable[..., Scenario]:
        name = build.__name__.replace("_", "-")
        if name in FAMILIES and FAMILIES[name].build.__module__ != build.__module__:
            raise ValueError(f"two scenarios are called {name!r}")
        if not build.__doc__:
            raise ValueError(f"scenario {name!r} needs a docstring a newcomer understands")
        chosen = tuple(dict.fromkeys((*suites, "full")))
        FAMILIES[name] = Family(name, build, version, tuple(tags), chosen, tuple(variants), ranges or {}, because or {})
        return build

    return enter


def _short(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)
