"""The table of published figures, and the figures themselves, measured anew in the real engines."""

from __future__ import annotations

import math
from functools import cache

import pytest

from adapters import registry
from adapters.engine import checked_settings
from adapters.run import run, sample_times
from comparisons import accuracy, energy, momentum
from comparisons.measurement import Case
from comparisons.published import BOXES_POSITION, CURVES, Figure, compare, figures
from scenarios import catalogue

BY_DEFAULT = figures()
# twenty seconds of 49 balls at 1 ms take minutes in all; their 10 ms figures test the same thing
QUICK = [f for f in BY_DEFAULT if f.scenario.startswith("gazebo") or f.dt == 0.01]


def scenario_of(figure: Figure):
    return next(s for s in catalogue.find(figure.scenario) if s.name == figure.scenario)


@cache
def measured(label: str, engine: str, settings: tuple) -> dict[str, float]:
    scenario = next(s for s in catalogue.find(label) if s.name == label)
    times = sample_times(scenario.duration, scenario.sampling)
    found = run(registry.engine(engine), scenario.scene, times, dict(settings))
    assert found.trajectory is not None, found.outcome
    case = Case(scenario, found, found.trajectory)
    return {q.name: q.value for judge in (accuracy, energy, momentum) for q in judge.measure(case)}


@pytest.mark.parametrize("figure", QUICK, ids=lambda f: f"{f.scenario}-{f.engine}-{f.quantity}-{f.published_for}")
def test_we_measure_what_was_published(figure):
    ours = measured(figure.scenario, figure.engine, tuple(figure.settings.items()))[figure.quantity]
    found = compare(figure, ours)
    assert found.agrees, f"published {figure.published}, ours {ours}"
    assert found.ratio == pytest.approx(1.0, abs=1e-4)


def test_every_promised_figure_is_there():
    promised = {
        ("simbenchmark-bouncing", "pybullet:multibody", 75245.4),
        ("simbenchmark-bouncing[dt=0.01]", "pybullet:multibody", 7.40664e6),
        ("simbenchmark-bouncing", "pybullet", 185.027),
        ("simbenchmark-bouncing[dt=0.01]", "pybullet", 18808.3),
        ("simbenchmark-bouncing[layout=row]", "pymunk", 185.027),
        ("simbenchmark-bouncing[dt=0.01,layout=row]", "pymunk", 18808.3),
        *(("gazebo-boxes", "mujoco", value) for value in (0.012462, 0.0130708, 0.0135771, 0.0124501, 0.049)),
        *(("gazebo-boxes", "pybullet:multibody", value) for value in (0.012462, 0.0130708, 0.049)),
        *(("gazebo-boxes", "pybullet", value) for value in (0.0135771, 0.0124501, 0.049)),
    }
    assert {(f.scenario, f.engine, f.published) for f in BY_DEFAULT} == promised
    assert len(BY_DEFAULT) == 18


@pytest.mark.parametrize("figure", BY_DEFAULT, ids=lambda f: f"{f.scenario}-{f.engine}-{f.quantity}")
def test_every_figure_can_be_run(figure):
    scenario, engine = scenario_of(figure), registry.engine(figure.engine)
    assert checked_settings(engine, figure.settings)["dt"] == figure.dt == scenario.sampling
    assert figure.quantity in {check.quantity for check in scenario.checks}
    assert set(map(type, scenario.scene.effects)) <= set(engine.effects)


def test_steps_nobody_published_have_a_theory_but_no_published_value():
    made = figures((2e-3,))
    assert {f.dt for f in made} == {2e-3}
    assert all(f.published is None for f in made)
    exact = [f for f in made if f.engine == "pybullet" and f.quantity == "mean square energy error"]
    assert exact[0].theory == pytest.approx(4.0 * 185.116, rel=1e-5)
    assert compare(exact[0], 740.0).agrees is None
    assert math.isnan(compare(exact[0], 740.0).ratio)


def test_a_step_the_scenario_does_not_allow_is_refused_by_name():
    with pytest.raises(ValueError, match="dt"):
        figures((1.0,))


def test_agreement_is_within_half_a_unit_of_the_last_digit():
    figure = next(f for f in BY_DEFAULT if f.published == 185.027)
    assert figure.digits == 5
    assert compare(figure, 185.0315).agrees
    assert not compare(figure, 185.0325).agrees
    assert not compare(figure, 184.99).agrees
    assert compare(figure, 185.027).ratio == 1.0


def test_published_curves_are_first_order():
    """Errors fall in proportion to the step, mean squares to its square: a slip in the table would show."""
    for curve in CURVES:
        order = 2.0 if curve.quantity == "mean square energy error" else 1.0
        fine = sorted(h for h in curve.values if h <= 1e-2)
        for coarse, finer in zip(fine[1:], fine, strict=False):
            found = math.log(curve.values[coarse] / curve.values[finer]) / math.log(coarse / finer)
            assert found == pytest.approx(order, abs=0.03), (curve.quantity, coarse)


def test_published_positions_follow_from_semi_implicit_euler():
    for curve in CURVES:
        if curve.quantity == "position error":
            assert all(curve.theory(dt) == pytest.approx(value, rel=1e-12) for dt, value in BOXES_POSITION.items())
