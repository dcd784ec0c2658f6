"""A run in parts is the whole run: every cell once, in its order, with its motion."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from adapters import registry
from comparisons.cell import cell_to_json
from plumbline import merging
from plumbline.cli import main
from plumbline.results import Results, merged
from plumbline.run_folder import FolderError

TOYS = str(Path(__file__).parents[1] / "adapters" / "toy_engines.py")
WHAT = ["-e", "toy", "-s", "projectile", "-s", "free-fall", "-s", "sliding-block", "-s", "head-on-collision"]


@pytest.fixture(scope="module")
def parts(tmp_path_factory):
    """Folders of the whole run and of its three parts."""
    place = tmp_path_factory.mktemp("shards")
    common = ["run", *WHAT, "--plugin", TOYS, "--repeats", "1", "--progress", "off", "--fail-on", "harness"]
    assert main([*common, "--out", str(place / "whole")]) == 0
    for part in (1, 2, 3):
        assert main([*common, "--shard", f"{part}/3", "--out", str(place / f"part{part}")]) == 0
    yield place
    registry.unregister("toy_engines")


def read(place, *names):
    return [Results.read(place / name) for name in names]


def test_parts_are_disjoint_and_nearly_equal(parts):
    labels = [[c.scenario for c in r.cells] for r in read(parts, "part1", "part2", "part3")]
    (whole,) = read(parts, "whole")
    assert sorted(label for part in labels for label in part) == sorted(c.scenario for c in whole.cells)
    assert max(map(len, labels)) - min(map(len, labels)) <= 1


def test_merged_parts_are_the_whole(parts, tmp_path, capsys):
    assert main(["merge", *(str(parts / f"part{n}") for n in (1, 2, 3)), "--out", str(tmp_path / "all")]) == 0
    (whole,), (joined,) = read(parts, "whole"), read(tmp_path, "all")
    assert [c.key for c in joined.cells] == [c.key for c in whole.cells]
    for a, b in zip(whole.cells, joined.cells, strict=True):
        told = [{**json.loads(cell_to_json(c)), "build_seconds": 0, "trace": 0} for c in (a, b)]
        assert told[0] == told[1]
        if a.trace:
            assert joined.run_of(b).trajectory.digest() == whole.run_of(a).trajectory.digest()
    assert (tmp_path / "all" / "index.html").is_file()
    assert "note" not in capsys.readouterr().err


def test_a_merged_run_goes_on_like_any_other(parts, tmp_path):
    merging.merge(read(parts, "part1", "part3"), tmp_path / "some")
    words = ["run", *WHAT, "--plugin", TOYS, "--repeats", "1", "--out", str(tmp_path / "some")]
    assert main([*words, "--progress", "off", "--fail-on", "harness"]) == 0
    assert [c.key for c in read(tmp_path, "some")[0].cells] == [c.key for c in read(parts, "whole")[0].cells]


def test_what_was_not_run_never_takes_the_place_of_an_answer(parts):
    (whole,) = read(parts, "whole")

    idle = replace(whole, campaign=replace(whole.campaign, cells=tuple(replace(c, state="not-run")
                                                                       for c in whole.cells)))  # fmt: skip
    assert [c.state for c in merged([whole, idle]).cells] == [c.state for c in whole.cells]
    assert [c.state for c in merged([idle, whole]).cells] == [c.state for c in whole.cells]


def test_runs_with_other_packages_say_so(parts):

    (one,) = read(parts, "part1")
    told = {**one.campaign.fingerprint, "packages": {"mujoco": "0.1"}, "processor": "abacus"}
    other = replace(one, campaign=replace(one.campaign, fingerprint=told))
    remarks = merging.differences([one, other])
    assert "the runs come from different machines: their times are not to be compared" in remarks
    assert any(remark.startswith("mujoco in versions") for remark in remarks)
    assert merging.differences([one, one]) == []


def test_a_run_is_not_merged_into_another(parts):
    with pytest.raises(FolderError, match="is a run already"):
        merging.merge(read(parts, "part1"), parts / "part2")


@pytest.mark.parametrize("text", ["0/3", "4/3", "1", "a/b", "1/0", "-1/3"])
def test_a_part_that_is_none_is_refused(text, capsys):
    assert main(["run", "--shard", text]) == 2
    assert "is no part of a whole" in capsys.readouterr().err
