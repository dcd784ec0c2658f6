"""Exhibit 2: a bounce that depends on where in a step it falls, and on how fine the steps are."""

from __future__ import annotations

from dataclasses import replace

from scenarios.bouncing_ball import bouncing_ball
from scenarios.exhibit import Exhibit, Remedy
from scenarios.scenario import Check, Scenario, scenario

STEPS = (1.0 / 240.0, 1e-3, 2.5e-4)  # [s]
EXHIBIT = Exhibit(
    number=2,
    title="The bounce that vanishes as you refine",
    shown="A perfectly elastic ball, dropped at eight phases of a step.  Contacts that exist before bodies touch brake "
    "the ball in the air, the more steps it spends there; then a finer step makes the bounce smaller.  Soft contacts "
    "without damping converge instead, as long as steps resolve them.",
    truth="With e = 1 the ball comes back to where it was dropped, for ever.",
    figures={"restitution": 1.0, "energy kept": 1.0},
    origin=("https://github.com/bulletphysics/bullet3/issues/3094", "https://github.com/bulletphysics/bullet3/issues/1530",
            "https://github.com/leggedrobotics/SimBenchmark/issues/4"),
    remedies=(
        *(Remedy("pybullet:undamped", "linearDamping = angularDamping = 0, and finer steps",
                 "PyBullet Quickstart Guide, changeDynamics", {"dt": dt}) for dt in STEPS),
        Remedy("mujoco:elastic", "solref = -10000 0: stiffness without damping",
               "MuJoCo documentation, Modeling: Solver parameters"),
    ),
)  # fmt: skip


@scenario(tags=("museum", "impact"), suites=("museum",))
def vanishing_bounce() -> Scenario:
    """An elastic ball dropped from 1 m must keep coming back to 1 m, at every phase of a step and every step.

    One impact tells nothing: an engine with time steps meets it at some phase of a step, and may gain here what it
    loses there.  So the drop is repeated at several phases, and with finer steps.
    """
    why = "two per cent of the speed: far above what gravity adds while an impact is late, far below a lost bounce"
    checks = (Check("restitution error", 0.02, why),)
    return replace(bouncing_ball(e=1.0), checks=checks, exhibit=EXHIBIT)
