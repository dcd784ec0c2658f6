"""A failure is expected only if every failing quantity is on record, for the version it was seen in."""

from dataclasses import replace

import pytest

from adapters import registry
from comparisons.cell import Cell
from comparisons.known import Known, explain, known
from comparisons.measurement import Measurement
from scenarios.catalogue import families


def measured(quantity, verdict):
    return Measurement(quantity, 2.0, "1", 0.0, "", 1.0, 1e-9, "", verdict)


CELL = Cell("k", "ball[e=0.5]", "ball", 1, (), "pybullet:stock", "3.2.7", {}, "fail", 1.0,
            measurements=(measured("a error", "fail"), measured("b error", "ok")))  # fmt: skip
RECORD = Known("pybullet:*", "ball[e=0.5]", "margin", "measured", "3.2.7", "a error")


def test_a_failure_on_record_is_expected_and_says_why():
    assert explain(CELL, [RECORD]).state == "xfail"
    assert explain(CELL, [RECORD]).known == "margin"


@pytest.mark.parametrize(
    "change",
    [
        {"engine": "mujoco"},
        {"scenario": "ball[e=0.4]"},
        {"version": "3.2.8"},
        {"quantity": "b error"},
        {"state": "crash"},
    ],
)
def test_a_record_of_something_else_is_silent(change):
    assert explain(CELL, [replace(RECORD, **change)]) == CELL


def test_a_record_of_several_scenarios_speaks_of_each_and_names_none():
    several = replace(RECORD, scenario=("cube*", "ball[e=0.5]"), engine="pybullet:stock")
    assert explain(CELL, [several]).state == "xfail"
    assert explain(replace(CELL, scenario="cube[a=1]"), [several]).state == "xfail"
    assert explain(replace(CELL, scenario="ball[e=0.6]"), [several]).state == "fail"
    assert explain(replace(CELL, state="ok", measurements=()), [several]).state == "ok"


def test_one_unexplained_quantity_keeps_the_failure():
    worse = replace(CELL, measurements=(*CELL.measurements, measured("c error", "fail")))
    assert explain(worse, [RECORD]).state == "fail"
    assert explain(worse, [RECORD, replace(RECORD, quantity="c*")]).state == "xfail"


def test_a_cured_cell_is_news_only_if_it_was_named():
    cured = replace(CELL, state="ok", measurements=())
    assert explain(cured, [RECORD]).state == "ok"
    assert explain(cured, [replace(RECORD, engine="pybullet:stock")]).state == "xpass"


def test_other_states_are_explained_by_records_of_that_state():
    diverged = replace(CELL, state="diverged", measurements=())
    assert explain(diverged, [RECORD]).state == "diverged"
    assert explain(diverged, [replace(RECORD, state="diverged")]).state == "xfail"


def test_every_record_gives_a_reason_and_where_it_was_found():
    for record in known():
        assert len(record.reason) > 20
        assert record.source
        assert record.version


def test_every_record_is_about_scenarios_and_engines_that_there_are():
    """A record of a scenario that was renamed, or of another set of parameters, would wait for ever."""
    scenarios = [s.name for family in families().values() for s in family.all()]
    engines = registry.names()
    for record in known():
        patterns = (record.scenario,) if isinstance(record.scenario, str) else record.scenario
        for pattern in patterns:
            one = replace(record, scenario=pattern)
            cells = (replace(CELL, engine=e, engine_version=record.version, scenario=s)
                     for e in engines if e == record.engine or "*" in record.engine for s in scenarios)  # fmt: skip
            assert any(one.about(cell) for cell in cells), f"{record.engine}: {pattern}"
