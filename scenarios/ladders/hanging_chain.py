"""A chain of hinged links holds a load."""

from __future__ import annotations

from mechanics.effects import Gravity, Hinge, Rotation
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, Sphere
from scenarios.because import STANDING
from scenarios.ladder import STABLE, Ladder
from scenarios.resting import at_rest
from scenarios.scenario import Check, Scenario, scenario

LINK, LOAD = 0.25, 100.0  # [m], [kg]; a binary fraction: the links meet bit by bit
STRETCHED = "half a link"


@scenario(tags=("ladder", "joint", "chain"), suites=(), ranges={"links": (1, 1000)}, because=STANDING)
def hanging_chain(links: int = 1) -> Scenario:
    """Links of 1 kg, hinged to each other, hang straight down and hold a ball of 100 kg.  Nothing must happen.

    Every hinge carries the ball.  Solvers that go from hinge to hinge let a long chain stretch.
    """
    bodies = [Body("pivot", Sphere(0.05))]
    hinges = []
    for k in range(links):
        bodies.append(Body(f"link-{k + 1}", Box((0.05, 0.05, LINK)), 1.0, (0.0, 0.0, -LINK * (k + 0.5))))
        hinges.append(Hinge(bodies[-2].name, bodies[-1].name, point=(0.0, 0.0, -LINK * k)))
    end = (0.0, 0.0, -LINK * links)
    hinges.append(Hinge(bodies[-1].name, "load", point=end))
    bodies.append(Body("load", Sphere(0.125), LOAD, end))
    scene = Scene(tuple(bodies), (Gravity(), Rotation(), *hinges))
    return at_rest(
        scene,
        (STABLE, Check("drift", 0.5 * LINK, STRETCHED + ": a chain that is longer by that has come apart")),
        about=(Gravity, Hinge),
        source="statics: hinge k carries the load and the links below it",
    )


LADDERS = (
    Ladder("chain-length", "links of 1 kg that hold 100 kg", "1", "hanging-chain", (1, 2, 5, 10, 20, 50, 100), "links"),
)
