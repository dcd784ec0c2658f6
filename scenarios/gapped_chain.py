"""Balls of different masses on a line, with gaps: one impact after the other."""

from __future__ import annotations

from mechanics.effects import Restitution
from mechanics.scene import Scene
from scenarios.on_a_line import balls_on_a_line, between_impacts, impacts_in_turn, travel
from scenarios.scenario import Scenario, scenario
from scenarios.tolerance import STEP, converged, first_order, rounding

RADIUS = 0.05  # [m]
MASSES, PLACES, SPEEDS = (4.0, 2.0, 1.0, 3.0), (0.0, 1.0, 2.0, 3.5), (3.0, 0.0, 0.0, -1.0)  # [kg], [m], [m/s]
DURATION = 6.0  # [s]


@scenario(tags=("impact", "chain"), suites=(), variants=({}, {"e": 0.5}), ranges={"e": (0.1, 1.0)})
def gapped_chain(e: float = 1.0) -> Scenario:
    """Balls of 4, 2, 1 and 3 kg, far apart on a line, collide seven times (e = 1) or nine times (e = 1/2).

    Every impact is between two balls, so mechanics leaves nothing open and the whole history is a
    sequence of fractions.  An engine that gets one impact wrong gets the order of the next ones wrong.
    """
    scene = Scene(balls_on_a_line(RADIUS, MASSES, PLACES, SPEEDS), (Restitution(e),))
    sequence = impacts_in_turn(MASSES, PLACES, SPEEDS, e, DURATION)
    late = travel(SPEEDS, sequence) * STEP
    return Scenario(
        scene=scene,
        duration=DURATION,
        sampling=0.02,
        truth=between_impacts(scene, RADIUS, sequence),
        checks=(
            first_order("position error", late, "m", "Σ |Δv| h: every impact is seen up to one step late"),
            converged("velocity error", SPEEDS[0] - SPEEDS[-1], "the first approach speed in m/s"),
            rounding("linear momentum error", "an impulse acts on both balls alike"),
        ),
        source="momentum and Newton's law, impact by impact in fractions",
        about=(Restitution,),
        events=tuple(i.time for i in sequence),
        guard=2.0 * len(sequence) * STEP,
    )
