"""Baselines on disk: text that reads back to the bit, a row for each platform class, and nothing replaced unasked."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from comparisons.cell import Campaign, Cell
from comparisons.measurement import Measurement
from plumbline.baselines import BaselineError, Store, names
from plumbline.results import Results
from scenarios.catalogue import UnknownName

OURS = Path(__file__).parents[2] / "baselines"


def results(*values, engine="toy:stock", settings=None, scenario="drop[e=0.5,h=1]", state="ok"):
    cells = tuple(
        Cell(f"k{n}", scenario, "drop", 1, (), engine, "1", settings or {"dt": 0.1 / (n + 1)}, state, 1.0, digest="d",
             measurements=(Measurement("position error", value, "m", 1.0, "", 1.0, 1e-9, "", "ok"),))
        for n, value in enumerate(values)
    )  # fmt: skip
    told = {scenario: {"question": "q"}}
    return Results(Campaign("id", "standard", "c", "", 0.0, {}, told, {}, cells), Path("runs/none"))


def store(place, platform="here"):
    return Store("standard", place, platform)


def files(place):
    return {path: path.read_text() for path in place.rglob("*") if path.is_file()}


def test_numbers_are_text_that_reads_back_to_the_bit(tmp_path):
    values = (0.1 + 0.2, 1e-300, 5e-324, 123456789.12345679, float("inf"))
    assert store(tmp_path).save(results(*values)) == (5, [])
    assert {r.values["position error"] for r in store(tmp_path).baseline().records} == set(values)
    (text,) = files(tmp_path).values()
    assert "0.30000000000000004" in text
    assert json.dumps(json.loads(text), indent=1, sort_keys=True) + "\n" == text


def test_one_file_for_each_scenario_and_engine_under_a_name_for_every_system(tmp_path):
    store(tmp_path).save(results(1.0, 2.0))
    store(tmp_path).save(results(1.0, engine="other"))
    found = {str(path.relative_to(tmp_path)) for path in files(tmp_path)}
    assert found == {"standard/toy.stock/drop[e=0.5,h=1].json", "standard/other/drop[e=0.5,h=1].json"}
    assert names(tmp_path) == ["standard"]


def test_the_first_platform_stands_for_all_others_until_they_have_rows_of_their_own(tmp_path):
    store(tmp_path, "first").save(results(0.5))
    (generic,) = store(tmp_path, "second").baseline().records
    assert (generic.platform, generic.values["position error"]) == ("first", 0.5)
    assert store(tmp_path, "second").save(results(0.6)) == (1, [])
    (own,) = store(tmp_path, "second").baseline().records
    assert (own.platform, own.values["position error"]) == ("second", 0.6)
    assert store(tmp_path, "third").baseline().records == (generic,)


def test_what_was_saved_is_saved_once_and_never_replaced(tmp_path):
    store(tmp_path).save(results(0.5))
    before = files(tmp_path)
    assert store(tmp_path).save(results(0.5)) == (0, [])
    written, (change,) = store(tmp_path).save(results(0.7))
    assert (written, change.outcome) == (0, "regressed")
    assert files(tmp_path) == before


def test_accept_rewrites_the_row_of_this_platform_with_the_reason(tmp_path):
    for platform in ("here", "there"):
        store(tmp_path, platform).save(results(0.5))
    new = results(0.7)
    assert store(tmp_path).accept(new, new.cells, "because") == 1
    assert store(tmp_path).accept(new, new.cells, "again") == 0
    (here,), (there,) = (store(tmp_path, p).baseline().records for p in ("here", "there"))
    assert (here.values["position error"], here.reason) == (0.7, "because")
    assert (there.values["position error"], there.reason) == (0.5, "first recorded")


def test_a_cell_with_another_setting_takes_the_place_of_its_record(tmp_path):
    store(tmp_path).save(results(0.5, settings={"dt": 0.1}))
    new = results(0.5, settings={"dt": 0.1, "substeps": 1.0})
    store(tmp_path).accept(new, new.cells, "a knob was added")
    (kept,) = store(tmp_path).baseline().records
    assert kept.settings == {"dt": 0.1, "substeps": 1.0}


@pytest.mark.parametrize("state", ["not-run", "not-installed"])
def test_what_nobody_was_asked_is_not_recorded(tmp_path, state):
    assert store(tmp_path).save(results(0.5, state=state)) == (0, [])
    assert files(tmp_path) == {}


def test_a_baseline_that_is_not_there_names_those_that_are(tmp_path):
    store(tmp_path).save(results(0.5))
    with pytest.raises(UnknownName, match=r"no baseline in .* 'standart'; did you mean standard"):
        Store("standart", tmp_path).baseline()


@pytest.mark.parametrize(
    ("text", "message"),
    [("{", "is damaged"), ("[]", "is no baseline of schema 1"), ('{"schema": 2}', "is no baseline of schema 1"),
     ('{"schema": 1, "cells": [{}]}', "is damaged: KeyError")],
)  # fmt: skip
def test_a_damaged_file_is_named(tmp_path, text, message):
    store(tmp_path).save(results(0.5))
    (path,) = files(tmp_path)
    path.write_text(text)
    with pytest.raises(BaselineError, match=message) as caught:
        store(tmp_path).baseline()
    assert str(path) in str(caught.value)


def test_a_row_with_something_missing_is_named(tmp_path):
    store(tmp_path).save(results(0.5))
    (path,) = files(tmp_path)
    data = json.loads(path.read_text())
    del data["cells"][0]["rows"]["here"]["digest"]
    path.write_text(json.dumps(data))
    with pytest.raises(BaselineError, match="digest too much or too little"):
        store(tmp_path).baseline()


def test_a_folder_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "standard").write_text("in the way")
    with pytest.raises(BaselineError, match="cannot write"):
        store(tmp_path).save(results(0.5))


def test_our_own_baseline_is_whole_and_written_by_this_code():
    kept = Store("standard", OURS, "no such platform").baseline()
    assert len({r.identity for r in kept.records}) == len(kept.records) > 300
    assert {"reference", "mujoco", "pybullet", "pymunk"} <= {r.engine for r in kept.records}
    for path in (OURS / "standard").glob("*/*.json"):
        text = path.read_text()
        assert json.dumps(json.loads(text), indent=1, sort_keys=True, allow_nan=False) + "\n" == text


def test_a_record_of_a_broken_run_is_kept_like_any_other(tmp_path):
    crashed = results(0.5)
    cells = tuple(replace(c, state="crash", measurements=(), digest="") for c in crashed.cells)
    store(tmp_path).save(replace(crashed, campaign=replace(crashed.campaign, cells=cells)))
    (kept,) = store(tmp_path).baseline().records
    assert (kept.state, kept.values) == ("crash", {})
