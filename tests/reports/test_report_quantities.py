"""Energy, momentum and restitution side by side: the same rows in every format, exact where machines read them."""

from __future__ import annotations

import json
import math
import re
from dataclasses import replace

import pandas as pd
import pytest

from plumbline.cli import main
from plumbline.run_folder import RunFolder
from reports import quantities


@pytest.fixture(scope="module")
def folder(campaign, tmp_path_factory):
    """The campaign as a run on disk."""
    place = tmp_path_factory.mktemp("tables") / "run"
    names = ("id", "title", "command", "started", "wall_seconds", "fingerprint", "scenarios", "engines")
    plan = [{"key": c.key, "scenario": c.scenario, "engine": c.engine, "version": c.engine_version,
             "settings": dict(c.settings), "reproduce": ""} for c in campaign.cells]  # fmt: skip
    with RunFolder(place) as run:
        for cell in campaign.cells:
            run.append(cell)
        run.describe({name: getattr(campaign, name) for name in names} | {"plan": plan})
    return place


def test_the_frame_holds_every_measured_number_of_the_subjects(campaign):
    table = quantities.frame(campaign)
    assert set(table.quantity) == {
        "energy error", "energy error, synchronised", "energy rise", "linear momentum error", "angular momentum error",
        "restitution", "restitution error"}  # fmt: skip
    for cell in campaign.cells:
        for m in cell.measurements:
            rows = table[(table.scenario == cell.scenario) & (table.quantity == m.quantity)]
            if len(rows) and not math.isnan(m.value):
                assert rows[cell.engine].item() == m.value
    assert set(quantities.frame(campaign, ("restitution",)).quantity) == {"restitution", "restitution error"}


def test_every_format_has_the_rows_of_the_frame_and_marks_what_is_beyond(campaign):
    table = quantities.frame(campaign)
    lines = quantities.markdown(campaign).splitlines()
    assert len(lines) == len(table) + 4  # head, rule, empty line, legend
    tex = quantities.latex(campaign)
    assert tex.count(r"\\") == len(table) + 1
    beyond = (table[list(table.columns[4:])].gt(table.tolerance, axis=0)).sum().sum()
    assert beyond > 0
    assert "\n".join(lines[:-1]).count(quantities.BROKEN) == tex.count(r"\underline") == beyond
    assert quantities.terminal(campaign).row_count == len(table)


@pytest.mark.parametrize(
    ("text", "tex"),
    [("0.042", "$0.042$"), ("−2.1×10⁻¹⁰", r"$-2.1\cdot10^{-10}$"), ("∞", r"$\infty$"), ("", ""), ("open", "open"),
     ("14.2 ✕", r"\underline{$14.2$}"), ("kg m²/s", r"$\mathrm{kg\,m^{2}/s}$"), ("m/s", "m/s"), ("a_b", r"a\_b")],
)  # fmt: skip
def test_numbers_and_units_in_latex(text, tex):
    assert quantities._number(text) == tex


def test_files_hold_every_digit(campaign, folder, tmp_path, capsys):
    names = [tmp_path / f"t.{kind}" for kind in ("csv", "parquet", "md", "tex")]
    words = [word for name in names for word in ("--out", str(name))]
    assert main(["tables", "energy", "momentum", "--run", str(folder), *words, "--json"]) == 0
    table = quantities.frame(campaign, ("energy", "momentum"))
    numbers = dict.fromkeys(table.columns[3:], float)
    pd.testing.assert_frame_equal(pd.read_parquet(names[1]), table)
    exact = {"check_exact": True, "check_dtype": False}
    pd.testing.assert_frame_equal(pd.read_csv(names[0], dtype={"unit": str}).astype(numbers), table, **exact)
    told = pd.DataFrame(json.loads(capsys.readouterr().out), columns=table.columns)
    pd.testing.assert_frame_equal(told.astype(numbers), table, **exact)
    assert names[2].read_text() == quantities.markdown(campaign, ("energy", "momentum"))
    assert names[3].read_text() == quantities.latex(campaign, ("energy", "momentum"))


def test_hostile_names_stay_names(campaign):
    evil = "<script>|&%$#_{}~^"
    cells = tuple(replace(cell, scenario=evil) for cell in campaign.cells if cell.scenario == "free-fall")
    renamed = replace(campaign, cells=cells)
    assert re.search(r"\| \\<script\\>\\\|\\&%\$\\#\\_\{\}\\~\^ \|", quantities.markdown(renamed))
    assert r"<script>|\&\%\$\#\_\{\}\textasciitilde{}\textasciicircum{} & " in quantities.latex(renamed)


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [(["gravity"], 2, "there is no table of 'gravity'; there are: energy, momentum, restitution"),
     (["energy", "--out", "table.xls"], 2, "a name ends in .md, .csv, .parquet, .tex"),
     (["energy", "--run", "nowhere"], 4, "nowhere is not a run")],
)  # fmt: skip
def test_what_is_not_possible_says_what_is(folder, tmp_path, monkeypatch, capsys, words, code, message):
    monkeypatch.chdir(tmp_path)
    run = [] if "--run" in words else ["--run", str(folder)]
    assert main(["tables", *words, *run]) == code
    assert message in " ".join(capsys.readouterr().err.split())


def test_the_newest_run_is_taken(folder, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["tables"]) == 2
    assert "there is no run in runs/" in capsys.readouterr().err
    (tmp_path / "runs").mkdir()
    (tmp_path / "runs" / "20260101T000000Z-0000").symlink_to(folder)
    assert main(["tables", "restitution"]) == 0
    assert "bouncing-ball" in capsys.readouterr().out
