"""JUnit, CSV, Parquet and data frames: counts, kinds and numbers survive."""

from __future__ import annotations

import csv
import json
import math
from collections import Counter
from dataclasses import replace
from xml.etree import ElementTree as ET

import numpy as np
import pandas as pd
import pytest

import reports
from reports.junit import OUTCOME, junit
from reports.tables import CELL, COLUMNS, cells_frame, frame


@pytest.fixture(scope="session")
def written(campaign, tmp_path_factory):
    return reports.write(campaign, tmp_path_factory.mktemp("report") / "made" / "on demand")


def test_all_files_are_written(written):
    assert set(written) == {
        "index.html", "summary.md", "junit.xml", "measurements.csv", "measurements.parquet", "cells.csv"
    }  # fmt: skip
    assert all(path.is_file() and path.name == name for name, path in written.items())


def test_junit_counts_agree_with_its_cases_and_with_the_campaign(campaign):
    root = ET.fromstring(junit(campaign).encode())
    assert int(root.get("tests")) == len(campaign.cells) == len(root.findall(".//testcase"))
    for suite in root.findall("testsuite"):
        cells = [c for c in campaign.cells if c.scenario == suite.get("name")]
        assert int(suite.get("tests")) == len(suite.findall("testcase")) == len(cells)
        wanted = Counter(OUTCOME.get(c.state) for c in cells)
        for noun, tag in (("failures", "failure"), ("errors", "error"), ("skipped", "skipped")):
            assert int(suite.get(noun)) == len(suite.findall(f"testcase/{tag}")) == wanted[tag]


def test_every_state_has_one_outcome_in_junit(every_state):
    root = ET.fromstring(junit(every_state).encode())
    outcomes = {}
    for case in root.findall(".//testcase"):
        kinds = [e.tag for e in case if e.tag in ("failure", "error", "skipped")]
        assert len(kinds) <= 1
        outcomes[case.get("classname").removeprefix("s-")] = kinds[0] if kinds else "passed"
    assert outcomes == {
        "ok": "passed", "fail": "failure", "diverged": "failure", "xpass": "failure", "error": "error",
        "crash": "error", "timeout": "error", "oom": "error", "refused": "skipped", "not-installed": "skipped",
        "not-run": "skipped", "xfail": "skipped",
    }  # fmt: skip


def test_junit_says_how_wrong_and_how_to_repeat_it(campaign):
    root = ET.fromstring(junit(campaign).encode())
    (case,) = [
        c for c in root.findall(".//testcase")
        if c.get("classname") == "bouncing-ball" and c.get("name").startswith("mujoco:stock")
    ]  # fmt: skip
    message = case.find("failure").get("message")
    assert message == "position error 0.298 m is 14.2x the tolerance 0.021 m (worst at t = 0.8 s)"
    assert "reproduce: plumbline run -s 'bouncing-ball' -e mujoco:stock --set dt=0.001" in case.findtext("system-out")


def test_junit_drops_what_xml_cannot_hold_and_keeps_the_rest(hostile):
    root = ET.fromstring(junit(hostile).encode())
    name = root.findall("testsuite")[0].get("name")
    assert name.startswith("<script>alert(1)</script>")
    assert not {"\x00", "\x1b", "\ufffe", "\ud800"} & set(name)


def test_frame_has_one_row_per_measurement(campaign):
    table = frame(campaign)
    assert len(table) == sum(len(c.measurements) for c in campaign.cells)
    assert list(table.columns[: len(COLUMNS)]) == list(COLUMNS)
    judged = table[table["tolerance"].notna()]
    assert np.allclose(judged["ratio"], judged["value"] / judged["tolerance"])
    assert set(table["setting.dt"]) == {1e-3}
    only = table[table["engine"] == "mujoco"]
    assert only["setting.iterations"].isna().all()


def test_settings_that_are_words_for_one_engine_are_words_for_all(campaign):
    cells = (replace(campaign.cells[0], settings={"solver": "CG"}), campaign.cells[1],
             replace(campaign.cells[2], settings={"solver": 3.0}))  # fmt: skip
    table = frame(replace(campaign, cells=cells))
    assert set(table["setting.solver"].dropna()) == {"CG", "3.0"}


def test_cells_frame_has_every_cell(campaign):
    table = cells_frame(campaign)
    assert list(table["cell"]) == [c.key for c in campaign.cells]
    assert list(table.columns) == list(CELL)


def test_csv_reads_back_to_the_last_bit(campaign, written):
    with written["measurements.csv"].open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    wanted = [m for c in campaign.cells for m in c.measurements]
    assert len(rows) == len(wanted)
    for row, m in zip(rows, wanted, strict=True):
        for name in ("value", "tolerance", "exact", "time"):
            number = getattr(m, name)
            assert (row[name] == "") if math.isnan(number) else (float(row[name]) == number)
        assert (row["quantity"], row["verdict"], row["text"]) == (m.quantity, m.verdict, m.text)


def test_cells_csv_has_reason_and_command_of_every_cell(campaign, written):
    with written["cells.csv"].open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [(r["cell"], r["state"], r["reason"], r["reproduce"]) for r in rows] == [
        (c.key, c.state, c.reason, c.reproduce) for c in campaign.cells
    ]
    assert all(json.loads(r["settings"]) == dict(c.settings) for r, c in zip(rows, campaign.cells, strict=True))


def test_parquet_reads_back_equal(campaign, written):
    pd.testing.assert_frame_equal(pd.read_parquet(written["measurements.parquet"]), frame(campaign))


def test_a_campaign_of_refusals_has_an_empty_table_with_all_columns(every_state, tmp_path):
    refused = replace(every_state, cells=tuple(replace(c, measurements=()) for c in every_state.cells))
    assert len(frame(refused)) == 0
    paths = reports.write(refused, tmp_path)
    assert list(pd.read_parquet(paths["measurements.parquet"]).columns[: len(COLUMNS)]) == list(COLUMNS)
