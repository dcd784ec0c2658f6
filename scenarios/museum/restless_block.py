"""Exhibit 6: a block well below the friction angle that creeps."""

from __future__ import annotations

from dataclasses import replace

from scenarios.because import HELD
from scenarios.exhibit import Exhibit, Remedy
from scenarios.incline import incline
from scenarios.scenario import Check, Scenario, scenario

EXHIBIT = Exhibit(
    number=6,
    title="The block that cannot hold still",
    shown="A block on a slope of 10 degrees with µ = 1, at 18 % of what friction can hold.  Friction that is "
    "regularised lets it creep at a constant speed, which neither smaller steps nor another mass change: a documented "
    "trade-off of soft constraints, with documented ways out.",
    truth="Below the friction angle a block does not move.",
    figures={"creep speed": 0.0, "drift": 0.0},
    origin=("https://github.com/google-deepmind/mujoco/issues/3328", "https://github.com/newton-physics/newton/issues/3943"),
    remedies=(
        Remedy("mujoco:elliptic", "cone = elliptic", "MuJoCo documentation, Computation: Contact"),
        Remedy("mujoco:noslip", "cone = elliptic, impratio = 10, noslip_iterations = 10",
               "MuJoCo documentation, Modeling: Preventing slip"),
    ),
)  # fmt: skip


@scenario(tags=("museum", "friction"), suites=("museum",), because=HELD)
def restless_block() -> Scenario:
    """A block on a gentle, rough slope must stay where it is for ten seconds.

    Grippers that lose what they hold, and robots that drift while they stand, are this scene.
    """
    checks = (Check("drift", 1e-3, "a millimetre in ten seconds: what a gripper may lose without dropping anything"),)
    scene = incline(mu=1.0, slope=10.0)
    return replace(scene, duration=10.0, sampling=0.1, checks=checks, exhibit=EXHIBIT)
