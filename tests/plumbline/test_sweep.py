"""Sweeps run for real: orders that theory gives, resumption, advice from what was measured, and the report of it."""

import json
import math

import pytest
from click.testing import CliRunner

from adapters import registry
from adapters.engine import checked_settings, defaults
from adapters.run import run, sample_times
from comparisons.advice import advise as advice_of
from comparisons.frontier import ERROR, frontiers
from comparisons.judge import judge
from comparisons.order import observed_order
from plumbline import sweeping
from plumbline.cli import cli
from plumbline.results import Results
from reports.frontier import accuracy
from scenarios import catalogue

NAMES = ("reference", "pymunk", "mujoco:stock")
ASKED = [part for name in NAMES for part in ("-e", name)]
COMMAND = ("sweep", "free-fall[]", *ASKED, "--knobs", "main", "--repeats", 2, "--progress", "off")
STEPS = [1.0 / (60 * 2**k) for k in range(5)]


def invoke(*words):
    return CliRunner().invoke(cli, [str(w) for w in words], catch_exceptions=False, standalone_mode=False)


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    """Free fall over the main ladder of some engines."""
    out = tmp_path_factory.mktemp("sweep") / "run"
    told = invoke(*COMMAND, "--json", "--out", out)
    assert told.return_value == 0, told.output
    return out, json.loads(told.stdout)


def frontier(swept, engine):
    found = frontiers(Results.read(swept[0]).campaign)
    return next(f for f in found if f.engine == engine)


@pytest.mark.parametrize(("scenario", "name", "settings", "order"), [
    ("free-fall[]", "pymunk", {}, 1.0),  # semi-implicit Euler
    ("pendulum[kind=rod]", "mujoco", {"integrator": "Euler"}, 1.0),
    ("pendulum[kind=rod]", "mujoco", {"integrator": "RK4"}, 4.0),
])  # fmt: skip
def test_schemes_show_the_order_that_theory_gives(scenario, name, settings, order):
    (asked,), engine = catalogue.find(scenario), registry.engine(name)
    times = sample_times(1.0, 0.1)
    errors = []
    for dt in STEPS:
        done = run(engine, asked.scene, times, {"dt": dt, **settings})
        errors.append(next(m.value for m in judge(asked, done).measurements if m.quantity == ERROR))
    assert observed_order(STEPS, errors).slope == pytest.approx(order, abs=0.1)


def test_semi_implicit_euler_errs_in_free_fall_by_what_the_textbook_says(swept):
    """x is off by g dt t / 2 after a fall of g t²/2, and so by dt / t of the way."""
    duration = catalogue.find("free-fall[]")[0].duration
    for point in frontier(swept, "pymunk").main.points:
        assert point.error == pytest.approx(point.cell.settings["dt"] / duration, rel=1e-6)


def test_targets_are_reached_between_the_steps_that_reach_them(swept):
    found = frontier(swept, "pymunk")
    reached, point = found.reach(1e-3)
    assert reached.how == "between"
    assert point.cell.settings["dt"] == 1.0 / 960.0  # dt / 1.5 s is 6.9e-4 there, 1.4e-3 one step coarser
    assert found.reach(1e-6)[0].how == ""
    assert frontier(swept, "reference").reach(1e-6)[0].how == "below"


def test_a_finished_sweep_is_taken_up_without_running_anything(swept):
    before = (swept[0] / "cells.jsonl").read_text()
    told = invoke(*COMMAND, "--out", swept[0])
    assert told.return_value == 0
    assert (swept[0] / "cells.jsonl").read_text() == before
    assert "not reached (best" in told.stdout


def test_advice_is_a_measured_point_and_says_what_is_wrong_with_the_default(swept):
    told = json.loads(invoke("advise", "free-fall", "--error", 1e-4, "--from", swept[0], "--json").stdout)
    measured = {json.dumps(p["settings"], sort_keys=True) for f in swept[1]["frontiers"] for p in f["points"]}
    costs = [c["cost"] for c in told["choices"]]
    assert costs == sorted(costs)
    assert {c["engine"] for c in told["choices"]} == set(NAMES)
    for choice in told["choices"]:
        assert choice["error"] <= 1e-4
        assert json.dumps(choice["settings"], sort_keys=True) in measured
    pymunk = next(c for c in told["choices"] if c["engine"] == "pymunk")
    assert pymunk["default"]["error"] == pytest.approx(1e-3 / 1.5, rel=1e-6)


def test_advice_of_what_nobody_reaches_says_so(swept):
    told = invoke("advise", "free-fall", "--error", 1e-12, "--from", swept[0], "-e", "pymunk")
    assert told.stdout.startswith("No engine comes down to 10⁻¹².\npymunk does not get there: best 4.3×10⁻⁵ at ")
    assert told.return_value == 1
    with pytest.raises(ValueError, match="measured: free-fall"):
        advice_of(frontiers(Results.read(swept[0]).campaign), "stack", 1e-3)


def test_the_report_tells_of_the_sweep_and_keeps_its_points_out_of_the_verdicts(swept):
    campaign, text = Results.read(swept[0]).campaign, (swept[0] / "summary.md").read_text()
    page = (swept[0] / "index.html").read_text()
    assert "What accuracy costs in time" in text
    assert 'id="frontier"' in page
    assert page.count('class="cell') <= 2 * len(NAMES)  # one entry a default, not one a point
    assert "--set dt=" not in text  # commands are told of verdicts only
    section = accuracy(campaign).sections[0]
    assert [row.engine for row in section.rows] == ["reference", "pymunk", "mujoco:stock"]


def test_every_setting_that_is_swept_is_one_the_engine_takes():
    for name in registry.select(("*",)):
        engine = registry.engine(name)
        main, every = sweeping.ladders(engine, "main"), sweeping.ladders(engine, "all")
        assert main[0] == defaults(engine)
        assert all(checked_settings(engine, one) == one for one in every)
        assert {tuple(one.items()) for one in main} <= {tuple(one.items()) for one in every}


def test_laws_stay_as_they_are_and_methods_are_tried():
    engine = registry.engine("reference")
    settings = sweeping.ladders(engine)
    assert {one["impact_law"] for one in settings} == {"propagation"}
    for knob in ("time_of_contact", "solver", "tolerance"):
        assert {one[knob] for one in settings} == set(engine.knobs[knob])
    with pytest.raises(ValueError, match="main or all"):
        sweeping.ladders(engine, "some")


def test_a_scenario_without_a_truth_cannot_be_swept():
    told = CliRunner().invoke(cli, ["sweep", "random-boxes[]"])
    assert told.exit_code == 2
    assert "no truth is known" in told.output


def test_engines_on_one_rung_stand_together_in_the_plan():
    jobs = sweeping.jobs(catalogue.find("free-fall[]"), ("pymunk", "mujoco"), "main")
    assert [job.engine for job in jobs[:6]] == ["pymunk", "mujoco"] * 3
    assert math.isclose(float(jobs[2].settings["dt"]), float(jobs[3].settings["dt"]))
