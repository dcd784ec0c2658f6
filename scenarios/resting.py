"""A box and stacks of boxes that must stay where they are."""

from __future__ import annotations

from typing import Any

import numpy as np

from mechanics.effects import Effect, Friction, Gravity, Resting, Rotation
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace
from mechanics.trajectory import Trajectory
from scenarios.because import GRIPPED, STANDING
from scenarios.motion import Motion, constant, trajectory, vectors
from scenarios.scenario import Check, Scenario, Truth, scenario
from scenarios.tolerance import GRAVITY, STEP, first_order

EDGE = 0.5  # [m]; a binary fraction: stacked boxes touch with a gap of 0 bit by bit


def still(scene: Scene) -> Truth:
    """Nothing moves."""

    def truth(t: np.ndarray) -> Trajectory:
        places = scene.start().x
        at_rest = {scene.names[i]: Motion(constant(t, places[i]), vectors(t)) for i in scene.moving}
        return trajectory(scene, t, at_rest)

    return truth


def still_checks(contacts: int) -> tuple[Check, ...]:
    """What is demanded of bodies at rest with `contacts` contacts between the floor and the highest."""
    sink = 10.0 * contacts * GRAVITY * STEP**2
    return (
        first_order("drift", sink, "m", f"10 g h² at each of {contacts} contact(s): gravity moves g h² in a step"),
        first_order("rest speed", 2.0 * GRAVITY * STEP, "m/s", "2 g h: a step's fall of a centre, and as much in spin"),
        first_order("penetration", sink, "m", f"10 g h² at each of {contacts} contact(s)"),
    )


def at_rest(
    scene: Scene,
    checks: tuple[Check, ...],
    *,
    about: tuple[type[Effect], ...],
    source: str,
    duration: float = 2.0,
    sampling: float = 0.02,
) -> Scenario:
    """A scene in which nothing must happen."""
    return Scenario(
        scene=scene,
        duration=duration,
        sampling=sampling,
        truth=still(scene),
        checks=checks,
        source=source,
        about=about,
    )


def standing(scene: Scene, contacts: int, **told: Any) -> Scenario:
    """As `at_rest`, with the checks of `still_checks(contacts)`."""
    return at_rest(scene, still_checks(contacts), **told)


@scenario(tags=("resting", "box"), because=STANDING)
def resting_box() -> Scenario:
    """A flat box of 7 kg lies on a floor for five seconds.  Nothing must happen.

    Its weight is held by four corners whose single forces are not unique; sinking, creeping and
    trembling show what a contact solver leaves undone.
    """
    box = Body("box", Box((2.0, 1.0, 0.5)), mass=7.0, position=(0.0, 0.0, 0.25))
    scene = Scene((Body("floor", HalfSpace()), box), (Gravity(), Resting(), Rotation()))
    return standing(
        scene, 1, about=(Gravity, Resting), source="statics; Baraff, SIGGRAPH 1994", duration=5.0, sampling=0.05
    )


@scenario(
    tags=("resting", "stack", "box"),
    variants=({}, {"count": 5}, {"count": 10}, {"count": 10, "mu": 0.5}),
    ranges={"count": (1, 200), "mu": (0.0, 10.0)},
    because=GRIPPED,
)
def stack(count: int = 2, mu: float = 0.0) -> Scenario:
    """Two, five or ten equal boxes stand on each other for three seconds.  Nothing must happen.

    The lowest contact carries the whole stack: solvers that stop early let it sink, lean and in the
    end fall.  Standing upright needs no friction; without it nothing hides a sideways push.
    """
    boxes = [Body(f"box-{k + 1}", Box((EDGE, EDGE, EDGE)), 1.0, (0.0, 0.0, EDGE * (k + 0.5))) for k in range(count)]
    effects = (Gravity(), Resting(), Rotation(), *((Friction(mu),) if mu else ()))
    scene = Scene((Body("floor", HalfSpace()), *boxes), effects)
    return standing(
        scene,
        count,
        about=(Gravity, Resting),
        source="statics: contact k carries the weight above it",
        duration=3.0,
        sampling=0.05,
    )
