"""A block slides down a wedge that is free to move."""

from __future__ import annotations

import math

import numpy as np

from mechanics.effects import Gravity, Resting
from mechanics.rotation import about
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Mesh
from mechanics.trajectory import Trajectory
from scenarios.motion import Motion, trajectory
from scenarios.scenario import Scenario, scenario
from scenarios.tolerance import GRAVITY, STEP, converged, first_order

BLOCK, WEDGE, SLOPE = 1.0, 3.0, math.radians(30.0)  # [kg], [kg], [rad]
SIZE, BASE, DEPTH, DURATION = 0.2, 3.0, 1.0, 0.6  # edge of the block, base and depth of the wedge [m], [s]


def accelerations(slope: float) -> tuple[float, float, float]:
    """Of the wedge backwards, of the block along it [m/s2], and the force between them [N]; nothing has friction."""
    whole, sine, cosine = WEDGE + BLOCK * math.sin(slope) ** 2, math.sin(slope), math.cos(slope)
    wedge = BLOCK * GRAVITY * sine * cosine / whole
    return wedge, (WEDGE + BLOCK) * GRAVITY * sine / whole, BLOCK * WEDGE * GRAVITY * cosine / whole


def prism() -> Mesh:
    """The wedge: a right triangle over its base, highest at x = 0, drawn out along y; about its centre of mass."""
    corners = ((0.0, 0.0), (BASE, 0.0), (0.0, BASE * math.tan(SLOPE)))
    points = tuple((x, y, z) for y in (-0.5 * DEPTH, 0.5 * DEPTH) for x, z in corners)
    sides = ((0, 1, 2), (3, 5, 4), (0, 3, 4), (0, 4, 1), (1, 4, 5), (1, 5, 2), (2, 5, 3), (2, 3, 0))
    return Mesh(points, sides).centred()


@scenario(tags=("resting", "mesh"), suites=(), ranges={"drop": (0.0, 0.5)})
def block_on_wedge(drop: float = 0.2) -> Scenario:
    """A block slides down a smooth wedge that itself slides on a smooth floor.

    The wedge gives way backwards, so the block goes down more steeply than the slope; their common
    centre of mass goes straight down.  Each body's acceleration depends on the other's.  `drop` [m] is how far
    along the slope the block starts from its top.
    """
    down, normal = np.array([math.cos(SLOPE), 0.0, -math.sin(SLOPE)]), np.array([math.sin(SLOPE), 0.0, math.cos(SLOPE)])
    top = BASE * math.tan(SLOPE)
    wedge = Body("wedge", prism(), WEDGE, (BASE / 3.0, 0.0, top / 3.0))
    place = np.array([0.0, 0.0, top]) + (drop + 0.5 * SIZE) * down + 0.5 * SIZE * normal
    turned = tuple(about((0.0, 1.0, 0.0), SLOPE).tolist())
    block = Body("block", Box((SIZE, SIZE, SIZE)), BLOCK, tuple(place.tolist()), turned)
    scene = Scene((Body("floor", HalfSpace()), wedge, block), (Gravity(), Resting()))
    back, along, _ = accelerations(SLOPE)

    def truth(t: np.ndarray) -> Trajectory:
        away = np.array([-back, 0.0, 0.0])
        rows = ((wedge, away), (block, away + along * down))
        s = t[:, None]
        return trajectory(scene, t, {b.name: Motion(np.array(b.position) + 0.5 * a * s**2, a * s) for b, a in rows})

    return Scenario(
        scene=scene,
        duration=DURATION,
        sampling=0.01,
        truth=truth,
        checks=(
            first_order("position error", along * DURATION * STEP / 2.0, "m", "a t h/2 of semi-implicit Euler"),
            first_order("velocity error", GRAVITY * STEP, "m/s", "g h: what gravity changes in one step"),
            converged("linear momentum error", 1.0, "the momentum, as a ratio"),
        ),
        source="A = m g sin α cos α/(M + m sin² α); Kleppner and Kolenkow, Mechanics, ch. 2",
        about=(Gravity, Resting),
    )
