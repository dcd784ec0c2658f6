"""Boxes at rest under loads that are not even: an off-centre push, unequal masses, an overhang."""

from __future__ import annotations

from collections.abc import Sequence

from mechanics.effects import Force, Gravity, Resting, Rotation
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace
from scenarios.because import PUSHED, STANDING
from scenarios.resting import EDGE, standing
from scenarios.scenario import Scenario, scenario
from scenarios.tolerance import GRAVITY

SIZE, MASS = (2.0, 1.0, 0.5), 7.0  # [m], [kg]


def support(load: float, offset: float) -> tuple[float, float]:
    """Force of the floor on the box [N] and where along it this acts [m]; its parts at the corners are not unique."""
    total = MASS * GRAVITY + load
    return total, load * offset / total


@scenario(
    tags=("resting", "box"),
    suites=(),
    variants=({}, {"load": 200.0, "offset": 0.9}),
    ranges={"load": (0.0, 1e4), "offset": (-0.99, 0.99)},
    because=PUSHED,
)
def loaded_box(load: float = 20.0, offset: float = 0.6) -> Scenario:
    """A box of 7 kg lies on a floor and is pressed down by 20 N, 0.6 m from its middle.  Nothing must happen.

    The floor's force moves towards the load, and one end of the box is pressed harder than the other;
    as long as the load stays above the base the box must not tilt.
    """
    box = Body("box", Box(SIZE), MASS, (0.0, 0.0, 0.5 * SIZE[2]))
    push = Force("box", (0.0, 0.0, -load), point=(offset, 0.0, 0.5 * SIZE[2]))
    scene = Scene((Body("floor", HalfSpace()), box), (Gravity(), Resting(), Rotation(), push))
    return standing(
        scene,
        1,
        about=(Gravity, Resting, Force),
        source="statics: the floor carries m g + P at P d/(m g + P) from the middle; Baraff, SIGGRAPH 1994",
        duration=5.0,
        sampling=0.05,
    )


def tower(masses: Sequence[float]) -> tuple[Body, ...]:
    """Equal cubes of `masses` [kg] on each other, the first at the bottom."""
    return tuple(
        Body(f"box-{k + 1}", Box((EDGE, EDGE, EDGE)), m, (0.0, 0.0, EDGE * (k + 0.5))) for k, m in enumerate(masses)
    )


def interfaces(masses: Sequence[float]) -> list[float]:
    """Force [N] in each contact, from the floor up: the weight of everything above."""
    return [GRAVITY * sum(masses[k:]) for k in range(len(masses))]


@scenario(
    tags=("resting", "stack", "box", "mass-ratio"),
    suites=(),
    variants=({}, {"growth": 0.5}, {"growth": 10.0}),
    ranges={"count": (2, 20), "growth": (1e-2, 100.0)},
    because=STANDING,
)
def uneven_stack(growth: float = 2.0, count: int = 5) -> Scenario:
    """Five equal cubes stand on each other, each twice as heavy as the one below it.  Nothing must happen.

    A heavy body on a light one is what solvers that pass forces on from contact to contact find hardest:
    the lowest contact learns of the weight on top last, and meanwhile the stack sinks.
    """
    boxes = tower([growth**k for k in range(count)])
    scene = Scene((Body("floor", HalfSpace()), *boxes), (Gravity(), Resting(), Rotation()))
    return standing(
        scene,
        count,
        about=(Gravity, Resting),
        source="statics: contact k carries the weight above it",
        duration=3.0,
        sampling=0.05,
    )


def overhang(count: int) -> float:
    """Greatest overhang of a stack of `count` equal blocks of length 1, one on each level: ½ (1 + 1/2 + ... + 1/n)."""
    return 0.5 * sum(1.0 / k for k in range(1, count + 1))


@scenario(
    tags=("resting", "stack", "box", "tipping"),
    suites=(),
    variants=({}, {"count": 5, "share": 0.9}),
    ranges={"count": (2, 10), "share": (0.0, 0.999)},
    because=STANDING,
)
def overhanging_stack(count: int = 3, share: float = 0.99) -> Scenario:
    """Three blocks reach out over each other by 99 % of what they can without falling.  Nothing must happen.

    The block on top reaches out by half its length, the next by a quarter, the next by a sixth: with
    enough of them the top one is clear of the lowest.  At 99 % the weight of all above lies just
    inside every edge, and an engine that lets blocks sink or tilt a little lets the stack fall.
    """
    length, thick = 1.0, 0.125
    blocks, reach = [], 0.0
    for k in range(count):  # from the bottom; the block on top of k others counts as number count - k
        place = (share * reach, 0.0, thick * (k + 0.5))
        blocks.append(Body(f"block-{k + 1}", Box((length, 0.5, thick)), 1.0, place))
        reach += 0.5 * length / (count - k - 1) if k < count - 1 else 0.0
    scene = Scene((Body("table", HalfSpace()), *blocks), (Gravity(), Resting(), Rotation()))
    return standing(
        scene, count, about=(Gravity, Resting), source="Hall, Am. J. Phys. 73 (2005) 1107", duration=3.0, sampling=0.05
    )
