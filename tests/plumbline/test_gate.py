"""The gate with real engines: an unchanged run is identical, and friction that is 2 % off in one adapter is caught."""

import json
from xml.etree import ElementTree as ET

import pytest

from adapters import registry
from plumbline.baselines import Store
from plumbline.cli import main
from plumbline.results import Results

SCENES = ["-s", "sliding-block[]", "-s", "head-on-collision[]"]
DEFECT = """
from dataclasses import fields, replace

from adapters.pymunk import ENGINES as HEALTHY, Pymunk


class Slippery(Pymunk):
    def _friction(self, draft, effect):
        draft.friction = replace(effect, coefficient={factor} * effect.coefficient)


was = HEALTHY["pymunk"]
ENGINES = {{"pymunk": Slippery(**{{f.name: getattr(was, f.name) for f in fields(was)}})}}
"""


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """A folder with the baseline `gate` of two engines on two scenes."""
    place = tmp_path_factory.mktemp("gate")
    words = ["run", *SCENES, "-e", "pymunk", "-e", "mujoco", "--repeats", "1", "--out", str(place / "run")]
    assert main([*words, "--progress", "off"]) == 0
    assert main(["baseline", "save", str(place / "run"), "--name", "gate", "--folder", str(place / "baselines")]) == 0
    return place


@pytest.fixture
def check(recorded, tmp_path, capsys):
    """Runs `plumbline check` against it; (exit code, JSON, run folder)."""

    def call(*words, factor=None, engines=("pymunk", "mujoco")):
        plugin = tmp_path / "pymunk.py"  # takes the place of the adapter of that name
        if factor is not None:
            plugin.write_text(DEFECT.format(factor=factor))
            words = (*words, "--plugin", str(plugin))
        out = recorded / f"run-{factor}-{len(engines)}"  # what has been run once is only compared again
        chosen = [word for engine in engines for word in ("-e", engine)]
        capsys.readouterr()
        code = main(["check", *SCENES, *chosen, "--baseline", "gate", "--folder", str(recorded / "baselines"),
                     "--out", str(out), "--progress", "off", "--json", *words])  # fmt: skip
        return code, json.loads(capsys.readouterr().out), out

    yield call
    registry.unregister("pymunk")


def outcomes(told):
    return {(c["scenario"], c["engine"]): c["outcome"] for c in told["changes"]}


def test_an_unchanged_run_is_identical_to_the_last_bit(check):
    code, told, _ = check("--strict")
    assert code == 0
    assert len(told["changes"]) == 4
    assert set(outcomes(told).values()) == {"identical"}


def test_a_plugin_that_changes_nothing_is_identical_too(check):
    code, told, _ = check(factor=1.0)
    assert (code, set(outcomes(told).values())) == (0, {"identical"})


def test_friction_2_per_cent_off_in_one_adapter_is_caught_and_named_everywhere(check, tmp_path):
    junit, summary = tmp_path / "junit.xml", tmp_path / "summary.md"
    code, told, run = check("--junit", str(junit), "--summary", str(summary), factor=1.02)
    assert code == 1
    guilty = ("sliding-block", "pymunk")
    assert {place for place, word in outcomes(told).items() if word != "identical"} == {guilty}
    assert outcomes(told)[guilty] == "regressed"

    assert "### ▼ regressed (1 cell)" in summary.read_text()
    assert "- **pymunk** on sliding-block:" in summary.read_text()
    cases = {(c.get("classname"), c.get("name").split(" ")[0]): c for c in ET.parse(junit).getroot().iter("testcase")}
    assert [place for place, case in cases.items() if case.find("failure") is not None] == [guilty]
    failure = cases[guilty].find("failure")
    assert "regressed: ok → fail; velocity error" in failure.get("message")
    assert "reproduce: plumbline run -e pymunk -s 'sliding-block[]'" in cases[guilty].find("system-out").text
    page = (run / "index.html").read_text()
    section = page.partition('<section id="regressions"')[2].partition("</section>")[0]
    assert section.count("<li>") == 1
    assert "sliding-block" in section
    assert "ok → fail" in section


def test_a_defect_too_small_for_the_tolerance_is_caught_by_the_baseline_alone(check):
    code, told, _ = check(factor=1.0001)
    (guilty,) = (c for c in told["cells"] if (c["scenario"], c["engine"]) == ("sliding-block", "pymunk"))
    assert guilty["state"] == "ok"
    assert code == 1
    assert outcomes(told)["sliding-block", "pymunk"] == "regressed"


def test_what_is_regressed_is_a_finding_only_if_it_is_to_count(check):
    assert check("--fail-on", "crash", factor=1.0001)[0] == 0
    assert check("--fail-on", "regressed", factor=1.0001)[0] == 1


def test_the_archived_run_is_compared_without_an_engine(check, recorded, capsys):
    _, _, run = check(factor=1.02)
    words = ["baseline", "diff", str(run), "--name", "gate", "--folder", str(recorded / "baselines")]
    assert main(words) == 1
    said = capsys.readouterr().out
    assert "▼ regressed sliding-block · pymunk: ok → fail; velocity error" in said
    assert "3 identical and 1 regressed" in said
    assert main([*words, "-s", "head-on-collision"]) == 0


def test_save_never_replaces_and_accept_replaces_what_is_named(check, recorded, tmp_path, capsys):
    _, _, run = check(factor=1.02)
    folder = tmp_path / "copy"
    assert main(["baseline", "save", str(recorded / "run"), "--name", "gate", "--folder", str(folder)]) == 0
    before = {path: path.read_text() for path in folder.rglob("*.json")}
    assert main(["baseline", "save", str(run), "--name", "gate", "--folder", str(folder)]) == 1
    assert "▼ regressed, kept as it was: sliding-block · pymunk" in capsys.readouterr().out
    assert {path: path.read_text() for path in folder.rglob("*.json")} == before

    words = ["baseline", "accept", str(run), "--name", "gate", "--folder", str(folder)]
    assert main(words) == 2
    assert main([*words, "-e", "*", "--reason", " "]) == 2
    assert main([*words, "-s", "no-such-scene", "--reason", "none"]) == 5
    assert main([*words, "-s", "head-on-collision", "--reason", "nothing changed here"]) == 0
    assert {path: path.read_text() for path in folder.rglob("*.json")} == before
    assert main([*words, "-s", "sliding-block", "-e", "pymunk", "--reason", "the belt is new"]) == 0
    after = {path: path.read_text() for path in folder.rglob("*.json")}
    (changed,) = (path for path in before if after[path] != before[path])
    assert changed == folder / "gate" / "pymunk" / "sliding-block.json"
    assert '"reason": "the belt is new"' in after[changed]
    assert main(["baseline", "diff", str(run), "--name", "gate", "--folder", str(folder)]) == 0


def test_an_engine_that_is_not_here_any_more_is_gone(check, recorded):
    code, told, _ = check(engines=("mujoco",))
    assert (code, len(told["changes"])) == (0, 2)
    results = Results.read(recorded / "run")
    store = Store("gate", recorded / "baselines")
    assert {r.engine for r in store.baseline().records} == {"pymunk", "mujoco"} == {c.engine for c in results.cells}


def test_another_platform_class_is_compared_with_the_generic_rows(check, monkeypatch):
    monkeypatch.setattr("plumbline.baselines.platform_class", lambda: "plan9-mips")
    code, told, _ = check()
    assert (code, set(outcomes(told).values())) == (0, {"identical"})
    code, told, _ = check(factor=1.0001)  # less than a tenth of the tolerance: rounding may do as much elsewhere
    assert (code, outcomes(told)["sliding-block", "pymunk"]) == (0, "in band")
    code, told, _ = check(factor=1.02)
    assert (code, outcomes(told)["sliding-block", "pymunk"]) == (1, "regressed")
