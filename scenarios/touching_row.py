"""Balls strike a row of balls that touch: the rows of Newton's cradle, from three to six."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

from mechanics.effects import Restitution
from mechanics.scene import Body, Scene
from scenarios.impact_laws import outcomes
from scenarios.newtons_cradle import RADIUS, RUN_UP, SPEED
from scenarios.on_a_line import balls_on_a_line
from scenarios.scenario import Scenario, scenario
from scenarios.tolerance import converged, rounding


def outcomes_of_row(balls: tuple[Body, ...], launched: int, e: float) -> dict:
    """Velocities of all balls after the first `launched` have met the others, by law."""
    together = [replace(b, position=(2.0 * RADIUS * i, 0.0, 0.0)) for i, b in enumerate(balls)]
    pairs = [(a.name, b.name) for a, b in pairwise(balls)]
    ahead = range(len(pairs))
    return outcomes(Scene(tuple(together), (Restitution(e),)), pairs, e, {"sequential": ahead})


@scenario(
    tags=("impact", "simultaneous", "chain"),
    suites=(),
    variants=({}, {"count": 4}, {"count": 5, "launched": 2}, {"count": 5, "e": 0.9}),
    ranges={"count": (2, 6), "launched": (1, 5), "e": (0.1, 1.0)},
)
def touching_row(count: int = 3, launched: int = 1, e: float = 1.0) -> Scenario:
    """One or more of three to five equal balls strike the others, which touch: the impact law decides.

    One contact after the other, as many balls leave as came, as in a real cradle; all contacts at once,
    the balls that came are thrown back.  The law is named, not marked.  Momentum is marked, and energy:
    kept for e = 1, not gained below.
    """
    places, speeds = [0.0 if i >= launched else -RUN_UP for i in range(count)], [SPEED] * launched
    balls = balls_on_a_line(RADIUS, [1.0] * count, places, speeds + [0.0] * (count - launched))
    energy = "energy error" if e == 1.0 else "energy rise"
    return Scenario(
        scene=Scene(balls, (Restitution(e),)),
        duration=1.0,
        sampling=0.01,
        checks=(
            rounding("linear momentum error", "an impulse acts on both balls alike"),
            converged(energy, 1.0, "the energy, as a ratio"),
        ),
        source="Herrmann and Seitz, Am. J. Phys. 50 (1982) 977; Baraff, SIGGRAPH 1989",
        about=(Restitution,),
        events=(RUN_UP / SPEED,),
        laws=outcomes_of_row(balls, launched, e),
    )
