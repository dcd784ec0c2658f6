"""Exhibit 3: Newton's cradle with and without gaps."""

from __future__ import annotations

from dataclasses import replace

from mechanics.effects import Restitution
from scenarios.exhibit import Exhibit, Remedy
from scenarios.newtons_cradle import COUNT, RUN_UP, SPEED, row, swapping, touching_cradle
from scenarios.scenario import Check, Scenario, scenario
from scenarios.tolerance import STEP

EXHIBIT = Exhibit(
    number=3,
    title="Three cradles, none alike",
    shown="One of five equal elastic balls strikes the others.  If they touch, mechanics leaves the outcome to the law "
    "of simultaneous impacts: (-.6, .4, .4, .4, .4) is as legitimate a rule as the (0, 0, 0, 0, 1) that a real cradle "
    "shows.  With gaps of 1 or 10 mm nothing is left open.  Momentum and energy are kept in any case.",
    truth="Equal elastic balls that meet two by two swap velocities: (0, 0, 0, 0, 1).",
    figures={"final velocities": "0 0 0 0 1", "energy kept": 1.0},
    origin=("https://github.com/dimforge/rapier/issues/630", "https://github.com/xissburg/edyn/pull/49"),
    remedies=(
        Remedy("mujoco:elastic", "solref = -10000 0: stiffness without damping",
               "MuJoCo documentation, Modeling: Solver parameters"),
        Remedy("reference:simultaneous", "the other legitimate rule", "Baraff, SIGGRAPH 1989"),
    ),
)  # fmt: skip


@scenario(
    tags=("museum", "impact", "chain"),
    suites=("museum",),
    variants=({}, {"gap": 0.001}, {"gap": 0.01}),
    ranges={"gap": (0.0, 0.1)},
)
def three_cradles(gap: float = 0.0) -> Scenario:
    """One of five equal elastic balls strikes the others, which touch or stand 1 or 10 mm (`gap`, in m) apart.

    Touching balls are an open question of mechanics, and which law was realised is named, not marked.  Balls
    with gaps are none: every impact is between two of them.
    """
    kept = Check("energy error", 0.01, "one per cent of the energy, which every law of elastic impact keeps")
    if gap == 0.0:
        return replace(touching_cradle(), checks=(kept,), exhibit=EXHIBIT)
    scene = row(1, gap)
    meetings = tuple((RUN_UP + k * gap) / SPEED for k in range(1, COUNT))
    return Scenario(
        scene=scene,
        duration=1.0,
        sampling=0.01,
        truth=swapping(scene),
        checks=(
            Check("final velocity error", 0.01 * SPEED, "one per cent of the speed: no other outcome is as near"),
            kept,
        ),
        source="equal masses swap velocities; Herrmann and Seitz, Am. J. Phys. 50 (1982) 977",
        about=(Restitution,),
        events=meetings,
        guard=2.0 * COUNT * STEP,
        exhibit=EXHIBIT,
    )
