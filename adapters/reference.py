"""The Baraff-style reference engine: `reference`, and the same engine with other impact laws.

Where several contacts act in one instant, rigid-body mechanics leaves the outcome to a law.
`reference` lets simultaneous impulses propagate, `reference:sequential` treats one contact at a
time, `reference:simultaneous` solves all at once; for single smooth contacts all are the same.
Every law is a value of the knob `impact_law` too; the profiles are for comparing them in one table.

`reference:lecture` and `reference:penalty` are two older methods in the same house, with time steps:
the algorithm of Baraff's lecture notes, and contact as springs.  They are there to be compared with.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from functools import cached_property
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

from adapters.engine import BadScene, ContactForce, Diverged, Impact, Knob, Refusal, Settings
from adapters.translate import TIME_STEPS
from mechanics.effects import (
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
)  # fmt: skip
from mechanics.scene import Scene
from mechanics.trajectory import State

if TYPE_CHECKING:
    from reference_impl.record import Held

EFFECTS: tuple[type[Effect], ...] = (Gravity, Rotation, Drag, Force, Restitution, Friction, Resting)
LINKS: tuple[type[Effect], ...] = (Rod, Hinge, Spring, Tether)


@dataclass
class Draft:
    """A scene whose effects are not switched on yet, and those that are."""

    scene: Scene
    effects: list[Effect] = field(default_factory=list)


class Profile(ABC):
    """One method of the reference engine, as an engine.

    Parameters
    ----------
    name : str
    """

    knobs: Mapping[str, tuple[Knob, ...]]
    defaults: Mapping[str, Knob]
    profile: Mapping[str, str] = {}
    table: str  # name in `reference_impl.assemble`
    kinds: tuple[type[Effect], ...] = EFFECTS  # what stands in it
    remarks: Mapping[type[Effect], str] = {}  # what is approximated

    def __init__(self, name: str) -> None:
        self.name = name
        self.on_request = name != "reference"  # the other methods are there to be compared with it
        self.effects: dict[type[Effect], Callable[[Draft, Any], str | None]] = dict.fromkeys(
            self.kinds, self._switch_on
        )

    @cached_property
    def version(self) -> str:
        """Version of Plumbline, which the engine is part of."""
        return version("plumbline")

    def vacuum(self, scene: Scene) -> Draft:
        """The scene with nothing switched on."""
        return Draft(scene)

    def _switch_on(self, draft: Draft, effect: Effect) -> str | None:
        """Switch an effect on; the method's own table refuses what it cannot do with these values."""
        from reference_impl import assemble

        with _translated():
            getattr(assemble, self.table)[type(effect)](draft.scene, effect)
        draft.effects.append(effect)
        return self.remarks.get(type(effect))

    def start(self, draft: Draft, knobs: Settings) -> Any:
        """World at t = 0.

        Raises
        ------
        Refusal
            For shapes that may touch and have no contact routines, and for bodies that overlap.
        """
        with _translated():
            return self._begin(Scene(draft.scene.bodies, tuple(draft.effects)), knobs)

    @abstractmethod
    def _begin(self, scene: Scene, knobs: Settings) -> Any:
        """World of the method at t = 0."""

    def advance(self, world: Any, duration: float) -> None:
        """Carry the world `duration` [s] on.

        Raises
        ------
        BadScene
            If the motion needs an effect that the scene does not declare.
        Diverged
            If a budget of the engine ran out.
        """
        with _translated():
            world.advance(duration)

    def read(self, world: Any) -> State:
        """State of all bodies in scene order."""
        return world.state()

    def contacts(self, world: Any) -> tuple[ContactForce, ...]:
        """The contacts that last, with their forces on a."""
        names = world.scene.names
        return tuple(ContactForce(world.t, names[h.a], names[h.b], h.point, h.normal, _force(h)) for h in world.forces)

    def audit(self, world: Any) -> dict[str, float]:
        """What the engine knows of its own soundness; see the `Audit` of each method."""
        return {name: float(value) for name, value in asdict(world.audit).items()}


def _events(self: Profile, world: Any) -> tuple[Impact, ...]:
    """Every impulse exchanged so far."""
    names = world.scene.names
    return tuple(Impact(e.time, names[e.a], names[e.b], e.point, e.normal, e.impulse) for e in world.events)


class Reference(Profile):
    """The reference engine with one impact law unless another is asked for.

    Parameters
    ----------
    name : str
    impact_law : str
        One of `reference_impl.effects.impact.LAWS`.
    """

    knobs: Mapping[str, tuple[Knob, ...]] = {
        "impact_law": ("sequential", "simultaneous", "poisson", "reflections", "propagation"),
        "restitution": ("poisson", "energetic", "newton"),
        "friction": ("convex", "pyramid", "exact"),
        "sides": (4, 8, 16, 32),
        "tolerance": (1e-6, 1e-9, 1e-12),
        "time_of_contact": ("bisection", "illinois", "newton", "advancement"),
        "solver": ("pgs", "lemke", "osqp_dual", "osqp", "dantzig", "nnls", "auto"),
    }
    laws = ("impact_law", "restitution", "friction", "sides")
    table = "IMPULSES"
    kinds = EFFECTS + LINKS
    events = _events

    def __init__(self, name: str, impact_law: str) -> None:
        super().__init__(name)
        self.defaults = {
            "impact_law": impact_law,
            "restitution": "newton",
            "friction": "exact",
            "sides": 4,
            "tolerance": 1e-12,
            "time_of_contact": "advancement",
            "solver": "auto",
        }

    def _begin(self, scene: Scene, knobs: Settings) -> Any:
        from reference_impl.settings import Settings as Choices
        from reference_impl.simulate import begin

        choices = Choices(
            impact_law=str(knobs["impact_law"]),
            restitution=str(knobs["restitution"]),
            friction=str(knobs["friction"]),
            sides=int(knobs["sides"]),
            time_of_contact=str(knobs["time_of_contact"]),
            solver=str(knobs["solver"]),
            tolerance=float(knobs["tolerance"]),
        )
        return begin(scene, choices)

    def advance(self, world: Any, duration: float) -> None:
        """Carry the world `duration` [s] on; raises as `Profile.advance`.

        Left to itself the engine finds out where bodies in flight are by then when it is asked.  Here it does so at
        once: runs are clocked by this call, and what a state costs is part of what it costs to get there.
        """
        from reference_impl.simulate import advance

        with _translated():
            advance(world, duration)
            world.arrive()

    def audit(self, world: Any) -> dict[str, float]:
        """What the engine knows of its own soundness; see `reference_impl.audit.Audit`."""
        incidents = {f"{i.what} of {' and '.join(i.bodies)} at [s]": i.time for i in reversed(world.incidents)}
        counts = ("evaluations", "refinements", "brackets")  # of the gap, in search of times of contact
        return super().audit(world) | {name: float(getattr(world.search, name)) for name in counts} | incidents


class Lecture(Profile):
    """The algorithm of Baraff's lecture notes; `reference_impl.lecture` tells its faults."""

    knobs: Mapping[str, tuple[float, ...]] = {"dt": TIME_STEPS, "tolerance": (1e-6, 1e-9, 1e-12)}
    defaults: Mapping[str, float] = {"dt": 1e-3, "tolerance": 1e-12}
    table = "LECTURE"
    sample = "smoke"  # in every report the default is compared with it there; on everything it takes minutes
    events = _events
    profile: Mapping[str, str] = {
        "integrator = Runge-Kutta 4, step dt": "as in the notes; `reference` flies exact paths between contacts",
        "time of contact = bisection": "penetration is looked for at the end of a step, then the step is halved until "
        "it is `tolerance` of the smallest body deep; `reference` advances conservatively and misses no contact",
        "impact law = sequential": "the notes give impulses one contact at a time; `reference` lets them propagate",
        "resting contact = OSQP on A f + b": "the notes' quadratic program, whose matrix squares the condition number; "
        "`reference` solves it in its factors, certified",
        "threshold = g dt": "slower approach does not bounce; `reference` has no threshold",
    }

    def _begin(self, scene: Scene, knobs: Settings) -> Any:
        from reference_impl.lecture import begin

        return begin(scene, float(knobs["dt"]), float(knobs["tolerance"]))


class Penalty(Profile):
    """Contact as a spring and damper; `reference_impl.effects.penalty` has the formulas."""

    knobs: Mapping[str, tuple[float, ...]] = {"dt": TIME_STEPS, "depth": (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)}
    defaults: Mapping[str, float] = {"dt": 1e-3, "depth": 1e-4}
    table = "PENALTIES"
    profile: Mapping[str, str] = {
        "contact = spring and damper": "a load like any other, in place of impulses and contact forces; bodies overlap",
        "depth (knob)": "how deep a body sinks in under its own weight [m]; sets the stiffness, and steps must resolve "
        "sqrt(g / depth)",
        "integrator = Runge-Kutta of order 4, step dt": "`reference` flies exact paths between contacts",
    }
    remarks: Mapping[type[Effect], str] = {
        Restitution: "Restitution: by damping chosen for one contact at a time, exact as dt goes to zero; "
        "below 0.01 as 0.01",
        Resting: "Resting: bodies lie as deep in each other as their springs need to carry them",
    }

    def _begin(self, scene: Scene, knobs: Settings) -> Any:
        from reference_impl.penalty import begin

        return begin(scene, float(knobs["dt"]), float(knobs["depth"]))


def _force(held: Held) -> tuple[float, float, float]:
    """Normal force and friction together [N]."""
    x, y, z = (held.force * n + t for n, t in zip(held.normal, held.friction, strict=True))
    return x, y, z


@contextmanager
def _translated() -> Iterator[None]:
    """Errors of the engine as the house names them."""
    from reference_impl.errors import MissingEffect, Overlap, Stalled, Unsupported

    try:
        yield
    except (Unsupported, Overlap) as error:
        raise Refusal(str(error)) from None
    except MissingEffect as error:
        raise BadScene(str(error)) from None
    except Stalled as error:
        raise Diverged(str(error)) from None


ENGINES = {
    "reference": Reference("reference", "propagation"),
    "reference:sequential": Reference("reference:sequential", "sequential"),
    "reference:simultaneous": Reference("reference:simultaneous", "simultaneous"),
    "reference:lecture": Lecture("reference:lecture"),
    "reference:penalty": Penalty("reference:penalty"),
}
