"""Where cost is measured, the cells of a scene sit together; where it is not, engines go their own ways."""

import json
from dataclasses import replace

import pytest

from plumbline import plan
from plumbline.campaign import Execution, Options
from plumbline.lanes import Lanes
from scenarios import catalogue

OPTIONS = Options(timeout=30.0, card=False)


@pytest.fixture(scope="module")
def jobs(toys):
    scenarios = catalogue.find("projectile") + catalogue.find("free-fall[]")
    return plan.plan(scenarios, ["toy", "toy:faulty", "toy:shy"], {"toy:faulty.fault": ["none", "segv"]})


def labels(jobs):
    return [(job.scenario.family, job.engine) for job in jobs]


def test_without_timing_each_engine_takes_its_next_cell(jobs):
    waiting = list(jobs)
    with Lanes(replace(OPTIONS, jobs=2)) as lanes:
        assert labels(lanes.give(waiting)) == [("projectile", "toy")]
        assert labels(lanes.give(waiting)) == [("projectile", "toy:faulty")]
        assert lanes.give(waiting) == ()
        assert len(waiting) == len(jobs) - 2
        assert lanes.told.startswith("none")


def test_with_timing_a_lane_takes_all_cells_of_a_scene(jobs):
    waiting = list(jobs)
    with Lanes(replace(OPTIONS, jobs=2, repeats=2)) as lanes:
        first, second = lanes.give(waiting), lanes.give(waiting)
        assert {job.scenario.family for job in first} == {"projectile"}
        assert {job.scenario.family for job in second} == {"free-fall"}
        assert (*first, *second) == tuple(jobs)
        assert waiting == []


def test_a_crash_in_a_sitting_costs_its_own_cell(jobs, tmp_path):
    mine = [job for job in jobs if job.scenario.family == "projectile"]
    results = Execution(mine, tmp_path, "test", "", replace(OPTIONS, repeats=3)).run()
    told = {(c.engine, c.settings.get("fault")): c for c in results.cells}
    assert told["toy:faulty", "segv"].state == "crash"
    for sound in (("toy", None), ("toy:faulty", "none"), ("toy:shy", None)):
        assert (told[sound].state, told[sound].repeats) == ("ok", 3)
        assert told[sound].cost > 0.0
    assert "in turns A B B A" in json.loads((tmp_path / "run.json").read_text())["fingerprint"]["timing"]
