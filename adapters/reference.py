"""The Baraff-style reference engine: `reference`, and the same engine with other impact laws.

Where several contacts act in one instant, rigid-body mechanics leaves the outcome to a law.
`reference` lets simultaneous impulses propagate, `reference:sequential` treats one contact at a
time, `reference:simultaneous` solves all at once; for single contacts the three are the same.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from functools import cached_property
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

from adapters.engine import BadScene, ContactForce, Diverged, Impact, Refusal, Settings
from mechanics.effects import Drag, Effect, Force, Friction, Gravity, Resting, Restitution, Rotation
from mechanics.scene import Scene
from mechanics.trajectory import State

if TYPE_CHECKING:
    from reference_impl.world import World


@dataclass
class Draft:
    """A scene whose effects are not switched on yet, and those that are."""

    scene: Scene
    effects: list[Effect] = field(default_factory=list)


class Reference:
    """The reference engine with one impact law, as an engine.

    Parameters
    ----------
    name : str
    impact_law : str
        One of `reference_impl.effects.impact.LAWS`.
    """

    knobs: Mapping[str, tuple[float, ...]] = {"tolerance": (1e-6, 1e-9, 1e-12)}
    defaults: Mapping[str, float] = {"tolerance": 1e-12}

    def __init__(self, name: str, impact_law: str) -> None:
        self.name, self.impact_law = name, impact_law
        self.effects: dict[type[Effect], Callable[[Draft, Any], None]] = dict.fromkeys(
            (Gravity, Rotation, Drag, Force, Restitution, Friction, Resting), _switch_on
        )

    @cached_property
    def version(self) -> str:
        """Version of Plumbline, which the engine is part of."""
        return version("plumbline")

    def vacuum(self, scene: Scene) -> Draft:
        """The scene with nothing switched on."""
        return Draft(scene)

    def start(self, draft: Draft, knobs: Settings) -> World:
        """World at t = 0.

        Raises
        ------
        Refusal
            For shapes that may touch and have no contact routines, and for bodies that overlap.
        """
        from reference_impl.simulate import begin
        from reference_impl.world import Settings as Choices

        with _translated():
            scene = Scene(draft.scene.bodies, tuple(draft.effects))
            return begin(scene, Choices(impact_law=self.impact_law, tolerance=float(knobs["tolerance"])))

    def advance(self, world: World, duration: float) -> None:
        """Carry the world `duration` [s] on.

        Raises
        ------
        BadScene
            If the motion needs an effect that the scene does not declare.
        Diverged
            If a budget of the engine ran out.
        """
        from reference_impl.simulate import advance

        with _translated():
            advance(world, duration)

    def read(self, world: World) -> State:
        """State of all bodies in scene order."""
        return world.state()

    def events(self, world: World) -> tuple[Impact, ...]:
        """Every impulse exchanged so far."""
        names = world.scene.names
        return tuple(Impact(e.time, names[e.a], names[e.b], e.point, e.normal, e.impulse) for e in world.events)

    def contacts(self, world: World) -> tuple[ContactForce, ...]:
        """The contacts that last, with their forces on a."""
        names = world.scene.names
        return tuple(
            ContactForce(world.t, names[h.a], names[h.b], h.point, h.normal, _times(h.force, h.normal))
            for h in world.forces
        )

    def audit(self, world: World) -> dict[str, float]:
        """What the engine knows of its own soundness; see `reference_impl.world.Audit`."""
        return {name: float(value) for name, value in asdict(world.audit).items()} | {
            "evaluations": float(world.search.evaluations)
        }


def _times(force: float, normal: tuple[float, float, float]) -> tuple[float, float, float]:
    return force * normal[0], force * normal[1], force * normal[2]


def _switch_on(draft: Draft, effect: Effect) -> None:
    """Switch an effect on; the engine's own table refuses what it cannot do with these values."""
    from reference_impl.assemble import IMPULSES

    with _translated():
        IMPULSES[type(effect)](draft.scene, effect)
    draft.effects.append(effect)


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
}
