"""Towers of cubes: how high, how small, in which units, and with how large a step they stand."""

from __future__ import annotations

from mechanics.effects import Friction, Gravity, Resting, Rotation
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace
from scenarios.because import GRIPPED
from scenarios.ladder import STABLE, Ladder
from scenarios.resting import at_rest
from scenarios.scenario import Check, Scenario, scenario
from scenarios.tolerance import GRAVITY

PLACE = "a quarter of an edge: with so much between neighbours a tower leans to its fall"


@scenario(
    tags=("ladder", "resting", "stack", "box"),
    suites=(),
    ranges={"count": (1, 1000), "edge": (1e-3, 1e3), "scale": (1e-6, 1e6)},
    because=GRIPPED,
)
def tower(count: int = 1, edge: float = 1.0, scale: float = 1.0) -> Scenario:
    """Equal cubes with friction 0.5 stand on each other for three seconds: does the tower stand?

    With `scale` every length and gravity are written in another unit of length, 1000 for millimetres: the
    physics is the same, and whatever then changes is a constant in an engine that has a unit.
    """
    size = edge * scale
    boxes = [Body(f"box-{k + 1}", Box((size, size, size)), 1.0, (0.0, 0.0, size * (k + 0.5))) for k in range(count)]
    effects = (Gravity((0.0, 0.0, -GRAVITY * scale)), Friction(0.5), Resting(), Rotation())
    scene = Scene((Body("floor", HalfSpace()), *boxes), effects)
    return at_rest(
        scene,
        (STABLE, Check("drift", 0.25 * size, PLACE, exact=1e-9 * size)),
        about=(Gravity, Friction, Resting),
        source="statics; the towers of Baraff, SIGGRAPH 1994, and of every engine's demonstration",
        duration=3.0,
        sampling=0.05,
    )


LADDERS = (
    Ladder("stack-height", "cubes of 1 m on each other", "1", "tower", (1, 2, 5, 10, 20, 50, 100), "count"),
    Ladder("stack-height-small", "cubes of 0.1 m on each other", "1", "tower", (1, 2, 5, 10, 20, 50, 100), "count",
           fixed={"edge": 0.1}),
    Ladder("units-smaller", "length in numbers, five cubes of 1 m: 100 in pixels, 1000 in mm", "1", "tower",
           (1, 10, 100, 1000), "scale", fixed={"count": 5}),
    Ladder("units-larger", "length in numbers, five cubes of 1 m: 0.001 in km", "1", "tower",
           (1, 0.1, 0.01, 0.001), "scale", fixed={"count": 5}),
    Ladder("step-size", "time step, ten cubes of 1 m", "s", "tower",
           (2.5e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2, 2e-2, 5e-2, 1e-1), knob="dt", fixed={"count": 10}),
)  # fmt: skip
