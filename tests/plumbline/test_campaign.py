"""A campaign finishes whatever its engines do, writes each cell as it comes, and goes on where it stopped."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

import plumbline
from adapters import registry
from plumbline import judging, plan
from plumbline.campaign import Execution, Options, Silence
from plumbline.results import Results, merged
from scenarios import catalogue

OPTIONS = Options(timeout=30.0)


class Record(Silence):
    """What a watcher is told."""

    def __init__(self, interrupt_after=None):
        self.told, self.ran, self.done = None, [], []
        self.interrupt_after = interrupt_after

    def begin(self, planned, reused):
        self.told = (planned, reused)

    def started(self, job):
        self.ran.append(job.key)

    def finished(self, cell, seconds):
        self.done.append(cell.key)
        if len(self.done) == self.interrupt_after:
            raise KeyboardInterrupt


def execute(folder, jobs, options=OPTIONS, **watching):
    record = Record(**watching)
    try:
        return Execution(jobs, folder, "test", "plumbline run", options, record).run(), record
    except KeyboardInterrupt:
        return None, record


@pytest.fixture(scope="module")
def jobs(toys, tmp_path_factory):
    place = tmp_path_factory.mktemp("plugins")
    (place / "ghost.py").write_text("import no_such_physics")
    (place / "wreck.py").write_text("1 / 0")
    for name in ("ghost", "wreck"):
        registry.register(name, str(place / f"{name}.py"))
    scenarios = catalogue.find("projectile") + catalogue.find("free-fall[]") + catalogue.find("sliding-block[]")
    faults = {"toy:faulty.fault": ["none", "segv", "nan"]}
    yield plan.plan(scenarios, ["toy", "toy:faulty", "ghost", "wreck"], faults)
    for name in ("ghost", "wreck"):
        registry.unregister(name)


@pytest.fixture(scope="module")
def done(jobs, tmp_path_factory):
    folder = tmp_path_factory.mktemp("campaign") / "run"
    results, record = execute(folder, jobs)
    return results, record


def cell(results, scenario, engine, fault=None):
    return next(c for c in results.cells
                if (c.scenario, c.engine, c.settings.get("fault")) == (scenario, engine, fault))  # fmt: skip


def test_every_job_becomes_a_cell_in_the_order_of_the_plan(done, jobs):
    results, record = done
    assert [c.key for c in results.cells] == [job.key for job in jobs]
    assert [c.reproduce for c in results.cells] == [job.reproduce for job in jobs]
    assert sorted(record.done) == sorted(job.key for job in jobs)


def test_each_fault_costs_its_own_cell(done):
    results, _ = done
    for scenario in ("projectile", "free-fall"):
        assert cell(results, scenario, "toy").state == "ok"
        assert cell(results, scenario, "toy:faulty", "none").state == "ok"
        crashed = cell(results, scenario, "toy:faulty", "segv")
        assert (crashed.state, crashed.stage, crashed.time) == ("crash", "advance", pytest.approx(0.5, abs=0.05))
        assert "SIGSEGV" in crashed.reason
        assert "Segmentation fault" in crashed.output
        assert cell(results, scenario, "toy:faulty", "nan").state == "diverged"


def test_what_an_engine_cannot_is_refused_with_the_reason(done):
    refused = cell(done[0], "sliding-block", "toy")
    assert (refused.state, refused.trace) == ("refused", "")
    assert "has no Friction" in refused.reason


def test_engines_that_cannot_be_had_say_why(done):
    missing, broken = cell(done[0], "projectile", "ghost"), cell(done[0], "projectile", "wreck")
    assert (missing.state, broken.state, broken.stage) == ("not-installed", "error", "import")
    assert "pip install no_such_physics" in missing.reason
    assert "ZeroDivisionError" in broken.reason


def test_motions_are_archived_as_far_as_they_go(done):
    results, _ = done
    whole, part = (results.run_of(cell(results, "projectile", *who)) for who in (("toy",), ("toy:faulty", "segv")))
    assert len(part.partial) < len(whole.outcome)
    np.testing.assert_array_equal(part.partial.x, whole.outcome.x[: len(part.partial)])


def test_the_journal_is_one_line_a_cell(done, jobs):
    lines = (done[0].folder / "cells.jsonl").read_text().splitlines()
    assert sorted(json.loads(line)["key"] for line in lines) == sorted(job.key for job in jobs)


def test_run_json_tells_the_plan_and_the_circumstances(done, jobs):
    manifest = json.loads((done[0].folder / "run.json").read_text())
    assert [e["key"] for e in manifest["plan"]] == [job.key for job in jobs]
    assert manifest["stopped"] == ""
    assert manifest["wall_seconds"] > 0.0
    assert {"system", "python", "packages", "processor"} <= set(manifest["fingerprint"])
    assert manifest["engines"]["toy"]["settings"] == {"dt": 0.05}
    assert manifest["engines"]["toy"]["profile"]
    assert manifest["scenarios"]["projectile"]["checks"]


def test_the_frame_is_tidy(done):
    frame = done[0].frame()
    row = frame[(frame.engine == "toy") & (frame.scenario == "projectile") & (frame.quantity == "position error")]
    assert len(row) == 1
    assert row.verdict.item() == "exact"


def test_the_report_is_written_beside_the_journal(done, tmp_path):
    paths = done[0].report()
    assert paths["index.html"].parent == done[0].folder
    assert "SIGSEGV" in paths["index.html"].read_text()
    assert all(path.stat().st_size for path in paths.values())
    assert done[0].report(tmp_path / "elsewhere")["junit.xml"].parent == tmp_path / "elsewhere"


def test_results_are_read_from_the_folder_as_they_were(done):
    assert repr(Results.read(done[0].folder).cells) == repr(done[0].cells)


def test_archived_motions_are_judged_as_they_were(done):
    again, remarks = done[0].judged_again()
    assert remarks == []
    assert repr(again.cells) == repr(done[0].cells)


def test_a_stricter_demand_judges_old_motions_anew(done):
    scenario = catalogue.find("projectile")[0]
    strict = replace(scenario, checks=tuple(replace(c, tolerance=-1.0, exact=-1.0) for c in scenario.checks))
    again, _ = replace(done[0], known=(strict,)).judged_again()
    assert cell(again, "projectile", "toy").state == "fail"
    assert cell(again, "free-fall", "toy").state == "ok"


def test_finished_cells_are_used_again_and_the_rest_is_run(done, jobs, tmp_path):
    folder = tmp_path / "run"
    few = [j for j in jobs if j.engine == "toy"]
    execute(folder, few[:1])
    results, record = execute(folder, few)
    assert record.told == (len(few), 1)
    assert few[0].key not in record.ran
    assert [c.state for c in results.cells] == ["ok", "ok", "refused"]
    _, record = execute(folder, few)
    assert record.ran == []


def test_what_failed_is_run_again_when_that_is_asked(jobs, tmp_path):
    mine = [j for j in jobs if j.scenario.name == "projectile" and j.engine == "toy:faulty"]
    execute(tmp_path, mine)
    assert execute(tmp_path, mine)[1].ran == []
    failed = {j.key for j in mine if j.settings["fault"] != "none"}
    assert set(execute(tmp_path, mine, replace(OPTIONS, rerun="failed"))[1].ran) == failed
    assert len(execute(tmp_path, mine, replace(OPTIONS, rerun="all"))[1].ran) == 3


def test_a_cell_is_run_again_if_its_question_changed_or_it_is_to_be_timed_better(jobs, tmp_path):
    mine = [j for j in jobs if j.scenario.name == "projectile" and j.engine == "toy"]
    execute(tmp_path, mine)
    longer = [replace(j, scenario=replace(j.scenario, duration=j.scenario.duration / 2)) for j in mine]
    assert execute(tmp_path, longer)[1].ran
    assert execute(tmp_path, longer)[1].ran == []
    results, record = execute(tmp_path, longer, replace(OPTIONS, repeats=3))
    assert record.ran
    assert results.cells[0].repeats == 3
    assert results.cells[0].cost > 0.0


def test_a_single_run_is_no_measurement_of_cost(done):
    right = cell(done[0], "projectile", "toy")
    assert right.repeats == 1
    assert math.isnan(right.cost)
    assert math.isnan(right.contention)


def test_cells_that_are_used_again_are_judged_by_todays_demands(jobs, tmp_path):
    mine = [j for j in jobs if j.scenario.name == "projectile" and j.engine == "toy"]
    assert execute(tmp_path, mine)[0].cells[0].state == "ok"
    checks = tuple(replace(c, tolerance=-1.0, exact=-1.0) for c in mine[0].scenario.checks)
    strict = [replace(j, scenario=replace(j.scenario, checks=checks)) for j in mine]
    results, record = execute(tmp_path, strict)
    assert record.ran == []
    assert results.cells[0].state == "fail"
    assert execute(tmp_path, mine)[0].cells[0].state == "ok"


def test_a_cell_whose_motion_is_damaged_is_run_again(jobs, tmp_path):
    mine = [j for j in jobs if j.scenario.name == "projectile" and j.engine == "toy"]
    results, _ = execute(tmp_path, mine)
    (tmp_path / results.cells[0].trace).write_text("gone")
    results, record = execute(tmp_path, mine)
    assert record.ran == [mine[0].key]
    assert results.cells[0].state == "ok"


def test_an_interrupted_campaign_is_valid_and_goes_on(jobs, tmp_path):
    mine = [j for j in jobs if j.engine.startswith("toy")]
    none, record = execute(tmp_path, mine, interrupt_after=2)
    assert none is None
    kept = {c.key for c in Results.read(tmp_path).cells if c.state != "not-run"}
    assert kept == set(record.done)
    rest = [c for c in Results.read(tmp_path).cells if c.state == "not-run"]
    assert rest[0].reason == "the run was interrupted"
    results, record = execute(tmp_path, mine)
    assert record.told == (len(mine), 2)
    assert all(c.state != "not-run" for c in results.cells)


def test_what_the_budget_does_not_reach_is_not_run(jobs, tmp_path):
    mine = [j for j in jobs if j.engine.startswith("toy")]
    results, record = execute(tmp_path, mine, replace(OPTIONS, budget=1e-9))
    assert record.ran == []
    assert {(c.state, c.reason) for c in results.cells} == {("not-run", "the budget of 1e-09 s was spent")}
    assert results.exit_code() == 5


def test_a_fault_of_the_judge_is_never_the_engines(jobs, tmp_path, monkeypatch):
    job = next(j for j in jobs if j.scenario.name == "projectile" and j.engine == "toy")

    def fall_over(*_, **__):
        raise ZeroDivisionError("no truth")

    with monkeypatch.context() as patch:
        patch.setattr(judging, "to_cell", fall_over)
        results, _ = execute(tmp_path, [job])
    assert (results.cells[0].state, results.cells[0].stage) == ("error", "judge")
    assert "ZeroDivisionError: no truth" in results.cells[0].reason
    assert results.exit_code() == 4
    assert execute(tmp_path, [job])[0].cells[0].state == "ok"


def test_runs_are_merged_and_the_last_counts(jobs, tmp_path):
    mine = [j for j in jobs if j.scenario.name == "projectile" and j.engine in ("toy", "toy:faulty")]
    a, _ = execute(tmp_path / "a", mine[:2])
    b, _ = execute(tmp_path / "b", mine[1:])
    both = merged([a, b])
    assert {c.key for c in both.cells} == {j.key for j in mine}
    assert all(both.run_of(c).trajectory is not None for c in both.cells)
    with pytest.raises(ValueError, match="no run"):
        merged([])


@pytest.mark.parametrize(
    ("options", "message"),
    [({"jobs": 0}, "jobs = 0"), ({"repeats": 1.5}, "repeats = 1.5"), ({"timeout": -1.0}, "timeout = -1.0"),
     ({"budget": float("nan")}, "budget = nan"), ({"rerun": "some"}, "none, failed, all")],
)  # fmt: skip
def test_impossible_options_name_what_is_allowed(options, message):
    with pytest.raises(ValueError, match=message):
        Options(**options)


@pytest.mark.parametrize(
    ("states", "code"),
    [(["ok", "refused", "xfail", "not-run"], 0), (["ok", "fail"], 1), (["fail", "diverged", "xpass"], 1),
     (["fail", "crash"], 3), (["timeout"], 3), (["oom", "ok"], 3), (["not-installed", "not-run"], 5), ([], 5)],
)  # fmt: skip
def test_the_exit_code_is_that_of_the_worst_state(done, states, code):
    one = done[0].cells[0]
    cells = tuple(replace(one, state=state, stage="advance") for state in states)
    results = replace(done[0], campaign=replace(done[0].campaign, cells=cells))
    assert results.exit_code() == code
    if code in (1, 3):
        assert results.exit_code(fail_on=()) == 0


def test_a_scenario_of_ones_own_runs_by_the_same_call(toys, tmp_path):
    body = plumbline.Body("ball", plumbline.Sphere(0.1), mass=1.0)
    mine = plumbline.Scenario(plumbline.Scene((body,), (plumbline.Gravity(),)), 1.0, 0.1, (), "none", name="mine")
    results = plumbline.run(mine, "toy", out=tmp_path / "run")
    assert results.cells[0].state == "ok"
    assert results.cells[0].reproduce == ""
    assert results.cells[0].of("energy error").value == pytest.approx(0.0, abs=1e-12)
    assert results.report()
