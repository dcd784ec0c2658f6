"""Exhibit 10: a box slides over a floor of tiles."""

from __future__ import annotations

import math

import numpy as np

from mechanics.effects import Gravity, Resting, Rotation
from mechanics.scene import Body, Scene
from mechanics.shapes import Box
from mechanics.trajectory import Trajectory
from scenarios.because import STANDING
from scenarios.exhibit import Exhibit, Remedy
from scenarios.motion import Motion, trajectory, vectors
from scenarios.scenario import Check, Scenario, scenario

TILES, DURATION = 10, 4.0  # each of 1 m; [s]
SPEED = 1.97  # [m/s]; no usual step carries the box onto a seam exactly, where rounding decides what is touched
EXHIBIT = Exhibit(
    number=10,
    title="The flat floor that trips you",
    shown="A smooth box slides over a level floor, of one slab and of ten tiles side by side.  Where each tile is "
    "collided with alone, the box may catch on the edge between two: a corner that a step has carried a hair too "
    "deep meets a vertical face.  The slab is the control.",
    truth="A smooth level floor takes no speed: the box slides on as fast as it came.",
    figures={"final speed": SPEED, "tilt": 0.0},
    origin=(
        "https://github.com/bulletphysics/bullet3/issues/288",
        "https://github.com/bulletphysics/bullet3/issues/676",
        "https://github.com/erincatto/box2d/issues/341",
    ),
    remedies=(
        Remedy("pybullet:undamped", "linearDamping = angularDamping = 0", "PyBullet Quickstart Guide, changeDynamics"),
    ),
)


@scenario(
    tags=("museum", "resting", "box"),
    suites=("museum",),
    variants=({}, {"edge": 0.3}, {"floor": "slab"}),
    ranges={"floor": ("tiles", "slab"), "edge": (0.01, 0.9)},
    version=2,
    because=STANDING,
)
def floor_that_trips(floor: str = "tiles", edge: float = 0.2) -> Scenario:
    """A smooth box of 20 or 30 cm slides at almost 2 m/s over ten flush tiles, or over one slab, and must not notice.

    Level geometry made of pieces is what games and maps are made of.  Contact that knows one piece at a time sees
    edges where the floor has none; whether it catches on one is chance, and another size of box another throw.
    """
    length = 1.0 if floor == "tiles" else float(TILES)
    pieces = [
        Body(f"tile-{k + 1}", Box((length, 1.0, 0.5)), None, (length * (k + 0.5) - 0.5, 0.0, -0.25))
        for k in range(round(TILES / length))
    ]
    box = Body("box", Box((edge, edge, edge)), 1.0, (0.0, 0.0, 0.5 * edge), velocity=(SPEED, 0.0, 0.0))
    scene = Scene((*pieces, box), (Gravity(), Resting(), Rotation()))

    def truth(t: np.ndarray) -> Trajectory:
        slid = Motion(vectors(t, x=SPEED * t, z=0.5 * edge), vectors(t, x=SPEED))
        return trajectory(scene, t, {"box": slid})

    return Scenario(
        scene=scene,
        duration=DURATION,
        sampling=0.02,
        truth=truth,
        checks=(
            Check("final velocity error", 0.01 * SPEED, "one per cent of the speed, which nothing takes"),
            Check("tilt", math.radians(0.5), "half a degree: twice what a box leans whose edge sinks by a millimetre"),
        ),
        source="no friction, no drag: Newton's first law",
        about=(Gravity, Resting),
        exhibit=EXHIBIT,
    )
