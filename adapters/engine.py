"""What an engine is to the house.

An engine is anything with the names of `Engine`; a module or an object will do.  It starts from a
vacuum, in which bodies drift and do not turn, and each effect of the scene is switched on by the
function its table names.  What the table does not list is refused by the house.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, Protocol, runtime_checkable

from mechanics.arrays import Triple
from mechanics.effects import Effect
from mechanics.scene import Scene
from mechanics.trajectory import State

Knob = float | str
Settings = Mapping[str, Knob]


class Refusal(Exception):
    """An engine's "I cannot", with the reason.

    Raised by adapters; an outcome of a run, never an error of the house.
    """

    def __init__(self, reason: str) -> None:
        self.reason = reason
        super().__init__(reason)


class Diverged(Exception):
    """An engine noticed itself that its state is no longer sound (a warning counter, a reset)."""


class BadScene(Exception):
    """The scene needs an effect that it does not declare; the message names effect, body and time."""


class Impact(NamedTuple):
    """One collision, as the engine reports it."""

    time: float  # [s]
    a: str
    b: str
    point: Triple  # world [m]
    normal: Triple  # unit, from b to a
    impulse: float  # along the normal, on a [N s]


class ContactForce(NamedTuple):
    """One contact that lasts, as the engine reports it."""

    time: float  # [s]
    a: str
    b: str
    point: Triple  # world [m]
    normal: Triple  # unit, from b to a
    force: Triple  # on a, world [N]


@runtime_checkable
class Engine(Protocol):
    """The interface of an engine.

    Attributes
    ----------
    name : str
        `engine` for the profile configured as fairly as its documentation allows, `engine:profile` for others.
    version : str
        Version of the engine itself.
    effects : mapping
        Effect type -> function(draft, effect) that switches it on.  It returns None if the engine
        does it exactly, a sentence if it approximates (printed as a footnote), or raises Refusal.
    knobs : mapping
        What trades accuracy for time: name -> values, coarse to fine.  ``dt`` is a time step [s].

    Optional names, read through the functions below: `defaults`, `profile`, `on_request`, `sample`, `laws`, `settle`,
    `lead`, `events`, `contacts`, `close`.  `known` maps laws of `adapters.conformance` that the engine breaks to the
    reason; `repeats` = False says that it does not repeat itself bit for bit.
    """

    name: str
    version: str
    effects: Mapping[type[Effect], Callable[[Any, Any], str | None]]
    knobs: Mapping[str, Sequence[Knob]]

    def vacuum(self, scene: Scene, /) -> Any:
        """Draft of a world in which the bodies of `scene` drift and do not turn."""

    def start(self, draft: Any, knobs: Settings, /) -> Any:
        """World compiled from the draft with the given knobs."""

    def advance(self, world: Any, duration: float, /) -> None:
        """Carry the world `duration` [s] on: the only clocked call."""

    def read(self, world: Any, /) -> State:
        """State of all bodies in scene order; its `t` is the time the world has really reached [s]."""


def defaults(engine: Engine) -> dict[str, Knob]:
    """Knob settings a run uses when nobody asks for others; the middle of each ladder where the engine names none."""
    named = getattr(engine, "defaults", {})
    chosen = {name: named.get(name, ladder[len(ladder) // 2]) for name, ladder in engine.knobs.items()}
    # 4 and 4.0 are one setting, and a cell is known by its settings
    return {name: value if isinstance(value, str) else float(value) for name, value in chosen.items()}


def checked_settings(engine: Engine, settings: Settings | None) -> dict[str, Knob]:
    """Defaults of the engine overlaid with `settings`.

    Raises
    ------
    ValueError
        For a knob the engine does not have, a word where a number is due, or a number that is not positive.
    """
    merged = defaults(engine)
    for name, value in (settings or {}).items():
        if name not in engine.knobs:
            raise ValueError(f"{engine.name} has no knob {name!r}; its knobs are {', '.join(engine.knobs) or 'none'}")
        words = [v for v in engine.knobs[name] if isinstance(v, str)]
        if words and value not in engine.knobs[name]:
            raise ValueError(f"{engine.name}: {name} = {value!r}; allowed: {', '.join(map(str, engine.knobs[name]))}")
        if not words and not (isinstance(value, (int, float)) and 0.0 < float(value) < float("inf")):
            raise ValueError(f"{engine.name}: {name} = {value!r}; allowed: a finite number > 0")
        merged[name] = value if words else float(value)
    return merged


def profile(engine: Engine) -> Mapping[str, str]:
    """Every setting that departs from the engine's own default, with the reason."""
    return getattr(engine, "profile", {})


def settled(engine: Engine, settings: Settings, scene: Scene) -> Settings:
    """Settings in which every choice an engine leaves to the scene (an "auto") has been made for `scene`."""
    return engine.settle(settings, scene) if hasattr(engine, "settle") else settings  # type: ignore[attr-defined]


def on_request(engine: Engine) -> bool:
    """Whether the engine runs only when it is asked for by name: a variant of another one, for comparison."""
    return bool(getattr(engine, "on_request", False))


def sample(engine: Engine) -> str:
    """The suite on which an engine that runs on request runs all the same, as a baseline; "" for none."""
    return str(getattr(engine, "sample", ""))


def laws(engine: Engine) -> tuple[str, ...]:
    """Knobs that choose which law holds, not how accurately it is solved: no sweep for accuracy turns them."""
    return tuple(getattr(engine, "laws", ()))


def lead(engine: Engine, settings: Settings) -> float:
    """By how much time the positions an engine reports run ahead of its velocities [s].

    Semi-implicit Euler moves with the new velocity: x(t) pairs with v(t - h/2) in a uniform field,
    so positions lead by +h/2; an engine that moves first and then kicks lags, -h/2.  Energy is
    comparable only after x is carried back by lead * v.  The settings are to be `settled` first.
    """
    return float(engine.lead(settings)) if hasattr(engine, "lead") else 0.0  # type: ignore[attr-defined]


class Clock:
    """Whole steps for a fixed-step engine, so that rounding never accumulates.

    Each `steps(duration)` moves the target on by `duration` and answers how many steps bring the
    world closest to it.
    """

    def __init__(self, dt: float) -> None:
        self.dt, self.target, self.count = dt, 0.0, 0

    def steps(self, duration: float) -> int:
        """Number of steps to take now."""
        self.target += duration
        due = round(self.target / self.dt) - self.count
        if due <= 0:
            return 0
        self.count += due
        return due

    @property
    def time(self) -> float:
        """Time reached [s]."""
        return self.count * self.dt
