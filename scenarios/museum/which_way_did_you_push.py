"""Exhibit 7: friction that depends on the direction."""

from __future__ import annotations

from dataclasses import replace

from scenarios.exhibit import Exhibit, Remedy
from scenarios.scenario import Check, Scenario, scenario
from scenarios.sliding_block import sliding_block
from scenarios.tolerance import GRAVITY

MU, SPEED = 0.5, 3.0
EXHIBIT = Exhibit(
    number=7,
    title="Which way did you push?",
    shown="The same push in three directions.  A pyramid in place of Coulomb's cone makes friction stronger or weaker "
    "between its edges and turns the block aside, to one side or the other depending on which pyramid it is.",
    truth="A block stops after v²/(2 µ g), in a straight line, in every direction.",
    figures={"stopping distance": SPEED**2 / (2.0 * MU * GRAVITY), "turned aside": 0.0},
    origin=("https://github.com/bulletphysics/bullet3/issues/2590", "https://github.com/dartsim/dart/issues/841"),
    remedies=(Remedy("mujoco:elliptic", "cone = elliptic", "MuJoCo documentation, Computation: Contact"),),
)


@scenario(
    tags=("museum", "friction"),
    suites=("museum",),
    variants=({}, {"heading": 22.5}, {"heading": 45.0}),
    ranges={"heading": (0.0, 90.0)},
)
def which_way_did_you_push(heading: float = 0.0) -> Scenario:
    """A block is pushed at 3 m/s along an axis, at 22.5 or at 45 degrees (`heading`) and must stop equally far away.

    Friction knows no directions; solvers that treat two tangents apart do.
    """
    why = "two per cent of the way: first-order steps err by less than one at 1/60 s, pyramids by forty"
    checks = (Check("final position error", 0.02 * SPEED**2 / (2.0 * MU * GRAVITY), why),)
    return replace(sliding_block(heading=heading, mu=MU, speed=SPEED), checks=checks, exhibit=EXHIBIT)
