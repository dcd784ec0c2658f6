"""A heavy cube on a light one."""

from __future__ import annotations

from mechanics.effects import Friction, Gravity, Resting, Rotation
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace
from scenarios.because import GRIPPED
from scenarios.ladder import STABLE, Ladder
from scenarios.resting import at_rest
from scenarios.scenario import Check, Scenario, scenario

SUNK = "a twentieth of an edge: seen with the naked eye"


@scenario(
    tags=("ladder", "resting", "stack", "box"),
    suites=(),
    ranges={"ratio": (1e-9, 1e9), "edge": (1e-3, 1e3)},
    because=GRIPPED,
)
def heavy_on_light(ratio: float = 1.0, edge: float = 1.0) -> Scenario:
    """A cube of `ratio` kg lies on an equal one of 1 kg for three seconds.  Nothing must happen.

    The lower contact carries the whole weight, and the upper one must push the light cube down by as much:
    an iterative solver hands a fraction of the order of the mass ratio on in each iteration.
    """
    masses = (1.0, ratio)
    boxes = [
        Body(f"box-{k + 1}", Box((edge, edge, edge)), m, (0.0, 0.0, edge * (k + 0.5))) for k, m in enumerate(masses)
    ]
    scene = Scene((Body("floor", HalfSpace()), *boxes), (Gravity(), Friction(0.5), Resting(), Rotation()))
    return at_rest(
        scene,
        (STABLE, Check("drift", 0.05 * edge, SUNK, exact=1e-9 * edge)),
        about=(Gravity, Friction, Resting),
        source="statics; mass ratios of Le Lidec et al., IEEE Trans. Robotics 2024",
        duration=3.0,
        sampling=0.05,
    )


LADDERS = (
    Ladder("mass-ratio", "mass of a 1 m cube over that of the one it lies on", "1", "heavy-on-light",
           (1, 10, 100, 1e3, 1e4, 1e5, 1e6), "ratio"),
)  # fmt: skip
