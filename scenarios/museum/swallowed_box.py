"""Exhibit 8: a heavy box on a light one, and a tower that stands at 1 m but not at 10 cm."""

from __future__ import annotations

from dataclasses import replace

from mechanics.effects import Friction, Gravity, Resting, Rotation
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace
from scenarios.because import GRIPPED
from scenarios.exhibit import Exhibit, Remedy
from scenarios.resting import at_rest
from scenarios.scenario import Check, Scenario, scenario

MU = 0.5
EXHIBIT = Exhibit(
    number=8,
    title="The swallowed box and the small tower",
    shown="A box of 1000 kg on one of 1 kg, and towers of twenty equal cubes.  A solver that stops after a few sweeps "
    "lets the heavy box sink into the light one: at rest, finite and without a word.  Towers of small cubes fall where "
    "the same tower of large ones stands, because what contact allows is a length and not a share.",
    truth="Boxes that stand upright on each other stay where they are.",
    figures={"penetration": 0.0, "drift": 0.0, "rest speed": 0.0},
    origin=("https://github.com/dartsim/dart/issues/3442", "https://github.com/jrouwe/JoltPhysics/issues/1390",
            "https://github.com/bulletphysics/bullet3/pull/2145"),
    remedies=(
        Remedy("pybullet:stock", "numSolverIterations = 1000",
               "PyBullet Quickstart Guide, setPhysicsEngineParameter", {"iterations": 1000.0}),
        Remedy("pymunk:stock", "iterations = 200", "pymunk documentation, Space.iterations", {"iterations": 200.0}),
    ),
)  # fmt: skip


def _tower(masses: list[float], edge: float) -> Scenario:
    boxes = [
        Body(f"box-{k + 1}", Box((edge, edge, edge)), mass, (0.0, 0.0, edge * (k + 0.5)))
        for k, mass in enumerate(masses)
    ]
    scene = Scene((Body("floor", HalfSpace()), *boxes), (Gravity(), Friction(MU), Resting(), Rotation()))
    return replace(
        at_rest(
            scene,
            (Check("drift", 0.01 * edge, "one per cent of an edge: more is seen with the naked eye"),),
            about=(Gravity, Resting, Friction),
            source="statics: contact k carries the weight above it",
            duration=5.0,
            sampling=0.05,
        ),
        exhibit=EXHIBIT,
    )


@scenario(
    tags=("museum", "resting", "box"),
    suites=("museum",),
    variants=({}, {"ratio": 100.0}, {"edge": 0.125}),
    ranges={"ratio": (1.0, 1e6), "edge": (0.01, 10.0)},
    because=GRIPPED,
)
def swallowed_box(ratio: float = 1000.0, edge: float = 1.0) -> Scenario:
    """A cube `ratio` times as heavy stands on an equal cube of 1 kg, for five seconds.  Nothing must happen.

    The upper contact carries a thousand times what the lower body weighs; iterations that pass impulses from body to
    body need about as many sweeps to carry them to the floor.
    """
    return _tower([1.0, ratio], edge)


@scenario(
    tags=("museum", "resting", "stack"),
    suites=("museum",),
    variants=({}, {"edge": 0.125}),
    ranges={"edge": (0.01, 10.0)},
    because=GRIPPED,
)
def small_tower(edge: float = 1.0) -> Scenario:
    """Twenty equal cubes stand on each other for five seconds, as large as houses or as bricks.  Nothing must happen.

    Scaled by eight, the same tower is the same problem with time running 2.8 times as fast.
    """
    return _tower([1.0] * 20, edge)
