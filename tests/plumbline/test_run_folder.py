"""The folder of a run loses nothing that was finished, and says clearly what it cannot do."""

import json
from contextlib import suppress
from datetime import UTC, datetime

import pytest

from adapters.engine import Refusal
from adapters.run import Run
from comparisons.cell import Cell, cell_to_json
from plumbline import run_folder
from plumbline.run_folder import FolderError, RunFolder


def cell(key, state="ok"):
    return Cell(key, "drop", "drop", 1, (), "toy", "1", {"dt": 0.1}, state, 1.0)


def entry(key):
    return {"key": key, "scenario": "drop", "engine": "toy", "version": "1", "settings": {}, "reproduce": "plumbline"}


MANIFEST = {
    "id": "x", "title": "t", "command": "c", "started": "", "wall_seconds": 1.0, "stopped": "", "fingerprint": {},
    "scenarios": {"drop": {"duration": 2.0, "tags": ["fall"], "version": 3}}, "engines": {},
    "plan": [entry("a"), entry("b"), entry("c")],
}  # fmt: skip


def test_cells_are_in_the_journal_at_once(tmp_path):
    with RunFolder(tmp_path / "run") as folder:
        for n, key in enumerate("abc"):
            folder.append(cell(key))
            assert len((tmp_path / "run" / "cells.jsonl").read_text().splitlines()) == n + 1
        assert list(folder.finished()) == ["a", "b", "c"]


@pytest.mark.parametrize("cut", [1, 20, 200])
def test_a_line_cut_short_by_a_kill_costs_that_cell_only(tmp_path, cut):
    journal = tmp_path / "cells.jsonl"
    line = cell_to_json(cell("b"))
    journal.write_text(cell_to_json(cell("a")) + "\n" + line[: len(line) - cut])
    assert list(run_folder.read_cells(tmp_path)) == ["a"]
    with RunFolder(tmp_path) as folder:
        folder.append(cell("c"))
        assert list(folder.finished()) == ["a", "c"]
    for text in journal.read_text().splitlines():
        json.loads(text)


def test_rubbish_in_the_journal_is_left_out(tmp_path):
    lines = [cell_to_json(cell("a")), "rubbish", '{"key": 1}', "[]", "null", cell_to_json(cell("b"))]
    (tmp_path / "cells.jsonl").write_text("\n".join(lines) + "\n")
    assert list(run_folder.read_cells(tmp_path)) == ["a", "b"]


def test_of_a_cell_written_twice_the_last_counts(tmp_path):
    with RunFolder(tmp_path) as folder:
        folder.append(cell("a", "crash"))
        folder.append(cell("a", "ok"))
        assert folder.finished()["a"].state == "ok"


def test_what_was_planned_and_not_finished_is_not_run(tmp_path):
    with RunFolder(tmp_path) as folder:
        folder.describe(MANIFEST)
        folder.append(cell("b"))
    campaign = run_folder.read_campaign(tmp_path)
    assert [(c.key, c.state) for c in campaign.cells] == [("a", "not-run"), ("b", "ok"), ("c", "not-run")]
    missing = campaign.cells[0]
    assert (missing.reason, missing.duration, missing.tags, missing.version) == (
        "the run was interrupted",
        2.0,
        ("fall",),
        3,
    )


def test_two_processes_cannot_write_to_one_run(tmp_path):
    with RunFolder(tmp_path), pytest.raises(FolderError, match="another process is writing"):
        RunFolder(tmp_path)
    with RunFolder(tmp_path):
        pass


def test_a_folder_that_cannot_be_made_is_named(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(FolderError, match=r"cannot write to .*file/run: Not a directory"):
        RunFolder(tmp_path / "file" / "run")


def test_a_full_disk_is_named_and_keeps_what_was_written(tmp_path, monkeypatch):
    with RunFolder(tmp_path) as folder:
        folder.append(cell("a"))
        full = open("/dev/full", "a")  # noqa: SIM115  its buffer cannot be written, so it cannot be closed politely
        with monkeypatch.context() as patch:
            patch.setattr(folder, "_journal", full)
            with pytest.raises(FolderError, match="No space left on device; cells that are in the journal are kept"):
                folder.append(cell("b"))
        with suppress(OSError):
            full.close()
        assert list(folder.finished()) == ["a"]


@pytest.mark.parametrize(
    ("text", "message"),
    [(None, "is not a run: run.json: No such file"), ("{", "run.json is damaged"), ('{"schema": 99}', "newer version"),
     ("[]", "newer version")],
)  # fmt: skip
def test_a_folder_that_is_no_run_is_refused(tmp_path, text, message):
    if text is not None:
        (tmp_path / "run.json").write_text(text)
    with pytest.raises(FolderError, match=message):
        run_folder.read_campaign(tmp_path)


def test_a_folder_without_a_journal_is_no_run(tmp_path):
    (tmp_path / "run.json").write_text(json.dumps({"schema": 1, **MANIFEST}))
    with pytest.raises(FolderError, match=r"cells\.jsonl"):
        run_folder.read_campaign(tmp_path)


def test_a_run_without_motion_leaves_no_trace(tmp_path):
    with RunFolder(tmp_path) as folder:
        assert folder.keep("a", Run("toy", "1", {}, Refusal("no"))) == ""
    assert not list((tmp_path / "traces").iterdir())


def test_names_of_runs_sort_by_time():
    assert run_folder.new_id(datetime(2026, 3, 4, 5, 6, 7, tzinfo=UTC)).startswith("20260304T050607Z-")
    assert run_folder.new_id() != run_folder.new_id()
