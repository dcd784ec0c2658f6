"""Two cubes that begin in each other."""

from __future__ import annotations

from mechanics.effects import Friction, Gravity, Resting, Rotation
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace
from scenarios.because import GRIPPED
from scenarios.ladder import STABLE, Ladder
from scenarios.scenario import Check, Scenario, scenario

EDGE = 1.0  # [m]
THROWN = "the overlap, by which the cube is lifted if it is undone, and a twentieth of an edge"


@scenario(tags=("ladder", "resting", "overlap", "box"), suites=(), ranges={"overlap": (0.0, 0.9)}, because=GRIPPED)
def overlapping_boxes(overlap: float = 0.0) -> Scenario:
    """A cube lies on another one, put together with an overlap of a part of their edge.  It must not be thrown.

    Rigid bodies cannot overlap, so there is no true motion.  To push them apart, to leave them, and to refuse
    the scene are all sound; to throw the upper one into the air makes energy of a slip of the pen.
    """
    lower = Body("lower", Box((EDGE, EDGE, EDGE)), 1.0, (0.0, 0.0, 0.5 * EDGE))
    upper = Body("upper", Box((EDGE, EDGE, EDGE)), 1.0, (0.0, 0.0, (1.5 - overlap) * EDGE))
    scene = Scene((Body("floor", HalfSpace()), lower, upper), (Gravity(), Friction(0.5), Resting(), Rotation()))
    return Scenario(
        scene=scene,
        duration=2.0,
        sampling=0.02,
        checks=(STABLE, Check("drift", (overlap + 0.05) * EDGE, THROWN)),
        source="none: outside of rigid-body mechanics; overlap recovery of Catto, Solver2D (2024)",
        about=(Gravity, Resting),
    )


LADDERS = (
    Ladder("overlap", "overlap at the start over the edge of a cube", "1", "overlapping-boxes",
           (1e-4, 1e-3, 0.01, 0.03, 0.1, 0.2, 0.4), "overlap"),
)  # fmt: skip
