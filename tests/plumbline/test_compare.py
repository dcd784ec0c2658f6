"""Two runs, two engines, or one engine in two environments: what differs is named, and nothing else."""

import json
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from adapters import registry
from plumbline import side_by_side
from plumbline.cli import main
from plumbline.results import Results

# an engine whose next version brakes a little, as an upgrade may bring
ENGINE = """
import os
import sys

sys.path.insert(0, {folder!r})
from toy_engines import Toy


class Spinner(Toy):
    version = os.environ.get("SPINNER_VERSION", "1.0")

    def advance(self, world, duration):
        super().advance(world, duration)
        if self.version != "1.0":
            world.v *= 1.0 - 1e-3 * duration


ENGINES = {{"spinner": Spinner("spinner")}}
"""
TOYS = Path(__file__).parents[1] / "adapters" / "toy_engines.py"


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A folder with the engine, and with an interpreter whose environment has its next version."""
    place = tmp_path_factory.mktemp("compare")
    (place / "spinner.py").write_text(ENGINE.format(folder=str(TOYS.parent)))
    python = place / "newer-python"
    python.write_text(f'#!/bin/sh\nSPINNER_VERSION=2.0 exec {sys.executable} "$@"\n')
    python.chmod(0o755)
    yield place
    registry.unregister("spinner")


def compare(place, *words):
    return main(["compare", *words, "--plugin", str(place / "spinner.py")])


@pytest.fixture(scope="module")
def upgraded(place):
    """Exit code of the comparison of both versions; the runs stay in place/both."""
    return compare(place, "spinner", "spinner", "--python", sys.executable, "--python", str(place / "newer-python"),
                   "-s", "projectile", "--out", str(place / "both"))  # fmt: skip


def test_another_version_of_an_engine_that_answers_worse_is_found(upgraded, place, capsys):
    assert upgraded == 1
    assert main(["compare", str(place / "both" / "a"), str(place / "both" / "b")]) == 1
    said = capsys.readouterr().out
    assert said.startswith("A: spinner 1.0 (")
    assert "B: spinner 2.0 (" in said
    assert "▼ B is worse" in said
    assert "projectile" in said


def test_the_other_way_round_it_is_better_and_no_finding(upgraded, place, capsys):
    assert main(["compare", str(place / "both" / "b"), str(place / "both" / "a")]) == 0
    assert "▲ B is better" in capsys.readouterr().out


def test_a_run_beside_itself_is_identical(upgraded, place, capsys):
    assert main(["compare", str(place / "both" / "a"), str(place / "both" / "a"), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert {pair["outcome"] for pair in told["pairs"]} == {"identical"}
    assert told["remarks"] == []


def test_two_engines_are_compared_scenario_by_scenario_and_may_differ(place, capsys):
    plugin = ["--plugin", str(TOYS)]
    try:
        code = compare(place, "spinner", "toy", *plugin, "-s", "projectile", "--out", str(place / "engines"))
    finally:
        registry.unregister("toy_engines")
    said = capsys.readouterr().out
    assert code == 0
    assert "A: spinner 1.0" in said
    assert "B: toy 1.2.3" in said
    assert "1 identical" in said


def test_cells_of_two_engines_are_paired_though_their_settings_differ(upgraded, place):
    a = Results.read(place / "both" / "a")
    cells = tuple(replace(c, engine="other", settings={"step": 1.0}) for c in a.cells)
    b = replace(a, campaign=replace(a.campaign, cells=cells))
    _, found = side_by_side.compared(a, b, ("spinner", "other"))
    assert [change.outcome for change in found] == ["in band"]


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [(["{a}", "spinner"], 2, "is a run and spinner is none"),
     (["{a}", "{b}", "--suite", "smoke"], 2, "compared as they are"),
     (["spinner", "spinner"], 2, "the same engine in the same environment"),
     (["spinner", "spinner", "--python", "one"], 2, "--python is given 1 times"),
     (["spinner", "spinner", "--python", "/no/such/python", "--python", "x"], 4, "cannot start /no/such/python"),
     (["spinner", "nobody", "-s", "projectile", "--out", "{place}/none"], 4, "there is no engine 'nobody'")],
)  # fmt: skip
def test_what_cannot_be_compared_says_why(upgraded, place, capsys, words, code, message):
    names = {"a": place / "both" / "a", "b": place / "both" / "b", "place": place}
    assert compare(place, *(word.format(**names) for word in words)) == code
    assert message in " ".join(capsys.readouterr().err.split())
