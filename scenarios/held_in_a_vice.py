"""A block hangs between a wall and a jaw."""

from __future__ import annotations

from mechanics.effects import Force, Friction, Gravity, Resting
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace
from scenarios.because import HELD
from scenarios.resting import standing
from scenarios.scenario import Scenario, scenario

EDGE, HEIGHT, MASS, JAW, MU = 0.5, 1.0, 1.0, 2.0, 0.5  # block [m], its height and the jaw's [m], [kg], [kg]


def least_squeeze(weight: float, mu: float) -> float:
    """Force [N] with which a body of `weight` [N] must be pressed between two rough faces so as not to slip."""
    return 0.5 * weight / mu


@scenario(
    tags=("resting", "friction", "box"),
    suites=(),
    variants=({}, {"squeeze": 1e3}),
    ranges={"squeeze": (9.82, 1e5)},
    because=HELD,
)
def held_in_a_vice(squeeze: float = 10.5) -> Scenario:
    """A block of 1 kg hangs in the air, pressed against a wall by a jaw with 10.5 N.  Nothing must happen.

    With friction 0.5 on both sides 9.81 N are enough.  How wall and jaw share the weight statics does not
    say, so only the motion is asked for: none.  Nothing turns in this scene; the jaw slides freely on the floor.
    """
    block = Body("block", Box((EDGE, EDGE, EDGE)), MASS, (0.5 * EDGE, 0.0, HEIGHT))
    jaw = Body("jaw", Box((EDGE, EDGE, 2.0 * HEIGHT)), JAW, (1.5 * EDGE, 0.0, HEIGHT))
    surfaces = (Body("floor", HalfSpace()), Body("wall", HalfSpace((1.0, 0.0, 0.0))))
    friction = Friction(MU, {("floor", "block"): 0.0, ("floor", "jaw"): 0.0})
    scene = Scene((*surfaces, block, jaw), (Gravity(), friction, Resting(), Force("jaw", (-squeeze, 0.0, 0.0))))
    return standing(
        scene, 2, about=(Gravity, Friction, Resting, Force),
        source="holds if 2 µ s >= m g; the shares of the two faces are not unique (Baraff, Algorithmica 10 (1993) 292)",
    )  # fmt: skip
