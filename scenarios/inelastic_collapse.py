"""Three balls on a line that lose nearly everything at each impact: infinitely many impacts in a finite time."""

from __future__ import annotations

import math
from fractions import Fraction

from mechanics.effects import Restitution
from mechanics.scene import Scene
from scenarios.on_a_line import Impact, balls_on_a_line, between_impacts, impacts_in_turn, travel
from scenarios.scenario import Scenario, scenario
from scenarios.tolerance import STEP, converged, first_order, rounding

RADIUS = 0.05  # [m]
PLACES, SPEEDS = (0.0, 1.0, 1.6), (2.0, 0.0, -1.0)  # [m], [m/s]
CRITICAL = 7.0 - 4.0 * math.sqrt(3.0)  # restitution below which three equal balls collapse
MOST = 120  # impacts followed; at e = 0.05 the balls are 1e-38 m apart after the first forty


def history(e: float) -> list[Impact[float]]:
    """Impacts of the three balls, equal in mass; where they accumulate, the last one joins all three for good.

    Relative speeds fall below the rounding of the speeds themselves, so the sequence is made of fractions.
    """
    mass = (Fraction(1),) * 3
    places, speeds = ([Fraction(v).limit_denominator(1000) for v in values] for values in (PLACES, SPEEDS))
    exact = impacts_in_turn(mass, places, speeds, Fraction(e).limit_denominator(10**6), most=MOST)
    sequence = [
        Impact(float(i.time), i.pair, tuple(map(float, i.places)), tuple(map(float, i.velocities))) for i in exact
    ]
    if e < CRITICAL:
        end, common = sequence[-1].time, sum(SPEEDS) / 3.0
        place = sum(PLACES) / 3.0 + common * end
        sequence.append(Impact(math.nextafter(end, math.inf), 0, (place,) * 3, (common,) * 3))
    return sequence


@scenario(tags=("impact", "chain", "hard"), suites=(), variants=({}, {"e": 0.1}), ranges={"e": (0.01, 1.0)})
def inelastic_collapse(e: float = 0.05) -> Scenario:
    """Two balls close in on a third between them and lose 95 % of their speed at each impact.

    Below e = 7 - 4√3 = 0.072 the ball in the middle goes back and forth infinitely often within a
    finite time, after which all three travel together; above it, a few impacts part them.  A loop
    that handles one impact after the other never gets past the collapse.
    """
    scene = Scene(balls_on_a_line(RADIUS, (1.0, 1.0, 1.0), PLACES, SPEEDS), (Restitution(e),))
    sequence = history(e)
    late = travel(SPEEDS, sequence) * STEP
    return Scenario(
        scene=scene,
        duration=1.5,
        sampling=0.01,
        truth=between_impacts(scene, RADIUS, sequence),
        checks=(
            first_order("position error", late, "m", "Σ |Δv| h: every impact is seen up to one step late"),
            converged("final velocity error", SPEEDS[0] - SPEEDS[-1], "the first approach speed in m/s"),
            rounding("linear momentum error", "an impulse acts on both balls alike"),
        ),
        source="McNamara and Young, Phys. Fluids A 4 (1992) 496",
        about=(Restitution,),
        events=tuple(sorted({i.time for i in sequence})),
        guard=0.02,
    )
