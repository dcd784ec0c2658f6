"""Phases of a step in a campaign: every one is run and kept, the worst is judged, the spread is what theory says."""

from __future__ import annotations

import math

import numpy as np
import pytest

from adapters import registry
from comparisons.cell import cell_from_json, cell_to_json
from comparisons.judge import Judgement
from comparisons.measurement import Measurement
from comparisons.phases import over_phases
from plumbline import plan
from plumbline.campaign import Execution, Options
from plumbline.results import Results
from reports.phases import Spread, lines
from scenarios import catalogue

PHASES = 8
STEP = 4e-3
TOY = f'''
from types import SimpleNamespace
import numpy as np
from adapters.engine import Clock
from mechanics.effects import Gravity, Restitution
from mechanics.trajectory import State


class Stepping:
    """Semi-implicit Euler; a ball found in the floor is put back on it and turned round."""

    name, version, knobs = "stepping", "1", {{"dt": ({STEP},)}}
    effects = dict.fromkeys((Gravity, Restitution), lambda draft, effect: None)

    def vacuum(self, scene):
        s = scene.start()
        return SimpleNamespace(scene=scene, x=s.x.copy(), q=s.q, v=s.v.copy(), w=s.w)

    def start(self, draft, knobs):
        draft.clock = Clock(knobs["dt"])
        return draft

    def advance(self, world, duration):
        h = world.clock.dt
        for _ in range(world.clock.steps(duration)):
            world.v[1] += h * world.scene.gravity
            world.x[1] += h * world.v[1]
            if world.x[1, 2] < 0.1 and world.v[1, 2] < 0.0:
                world.x[1, 2] = 0.1
                world.v[1, 2] *= -world.scene.restitution(0, 1)

    def read(self, world):
        return State(world.clock.time, world.x.copy(), world.q, world.v.copy(), world.w)


ENGINES = {{"stepping": Stepping()}}
'''


@pytest.fixture(scope="module")
def stepping(tmp_path_factory):
    path = tmp_path_factory.mktemp("plugins") / "stepping.py"
    path.write_text(TOY)
    registry.register("stepping", str(path))
    yield "stepping"
    registry.unregister("stepping")


@pytest.fixture(scope="module")
def results(stepping, tmp_path_factory):
    (scenario,) = catalogue.find("vanishing-bounce[]")
    jobs = plan.plan((scenario,), [stepping])
    folder = tmp_path_factory.mktemp("phases") / "run"
    return Execution(jobs, folder, "test", "plumbline run", Options(phases=PHASES, card=False)).run()


def test_every_phase_is_run_and_kept(results):
    (cell,) = results.cells
    assert cell.phase_count == PHASES
    assert len(results.traces.others(cell.key)) == PHASES - 1
    assert cell.reproduce.endswith("--phases 8")


def test_putting_a_ball_back_on_the_floor_gains_what_the_phase_says(results):
    """Found at depth d, the ball is lifted by d: the energy gained is m g d, and d is spread evenly over |v| h.

    So over K phases, one impact long, the rise of energy is spread over (K - 1)/K of g |v| h.
    """
    (cell,) = results.cells
    runs = [results.run_of(cell), *results.traces.others(cell.key)]
    fall = math.sqrt(2.0 * 9.81)
    rebound = []
    for run in runs:
        z, v, lead = run.outcome.x[:, 1, 2] - 0.1, run.outcome.v[:, 1, 2], 0.5 * STEP
        after = int(np.argmax(v > 0.0))
        rebound.append(0.5 * v[after] ** 2 + 9.81 * (z[after] - lead * v[after]))
    spread = max(rebound) - min(rebound)
    assert spread == pytest.approx((PHASES - 1) / PHASES * 9.81 * fall * STEP, rel=0.02)
    values = cell.phases["restitution"]
    assert max(values) - min(values) > 1e-3


def test_the_worst_phase_is_judged(results):
    (cell,) = results.cells
    for row in cell.measurements:
        if not math.isnan(row.tolerance):
            assert row.value == max(cell.phases[row.quantity])
            assert "of 8 phases" in row.text


def test_judging_again_and_the_journal_keep_the_phases(results):
    (cell,) = results.cells
    again, remarks = Results.read(results.folder).judged_again()
    assert remarks == []
    assert cell_to_json(again.cells[0]) == cell_to_json(cell)
    assert cell_to_json(cell_from_json(cell_to_json(cell))) == cell_to_json(cell)


def test_finished_phases_are_not_run_again(results, stepping):
    (scenario,) = catalogue.find("vanishing-bounce[]")
    jobs = plan.plan((scenario,), [stepping])
    before = (results.folder / "cells.jsonl").stat().st_size
    Execution(jobs, results.folder, "test", "plumbline run", Options(phases=PHASES, card=False)).run()
    assert (results.folder / "cells.jsonl").stat().st_size == before
    fewer = Execution(jobs, results.folder, "test", "plumbline run", Options(phases=2, card=False)).run()
    assert fewer.cells[0].phase_count == 2


def test_the_table_tells_least_median_and_largest(results):
    (cell,) = results.cells
    told = {line.quantity: line.spreads[0] for line in lines(results.campaign)}
    values = sorted(cell.phases["restitution"])
    assert (told["restitution"].least, told["restitution"].most) == (values[0], values[-1])
    assert told["restitution"].text.count("·") == 2
    assert Spread.of((0.8, 0.8, math.nan)).text == "0.8 (1 not measured)"
    assert Spread.of((math.nan,)) is None


def test_a_phase_that_breaks_decides_and_says_which():
    def judgement(value, state="ok"):
        row = Measurement("position error", value, "m", 0.0, "", 1.0, 1e-9, "because it is so", "ok")
        return Judgement((row,), state, "advance" if state != "ok" else "", "it fell apart" if state != "ok" else "")

    whole, values = over_phases([judgement(0.1), judgement(0.3), judgement(0.2)])
    assert (whole.state, whole.measurements[0].value, values) == ("ok", 0.3, {"position error": (0.1, 0.3, 0.2)})
    broken, _ = over_phases([judgement(0.1), judgement(0.3, "diverged")])
    assert (broken.state, broken.reason) == ("diverged", "it fell apart (phase 1/2 of a step)")
