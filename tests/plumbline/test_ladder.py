"""Two short ladders in real engines: frontiers in journal, report and command line, and a climb that goes on."""

import json

import pytest

from plumbline.campaign import Execution, Options, Silence
from plumbline.cli import main
from plumbline.climbing import Climbers
from plumbline.results import Results
from reports.ladders import climbs
from reports.suite import without_ladders
from scenarios.ladder import Ladder

SHORT = (
    Ladder("short-tower", "cubes on each other", "1", "tower", (1, 2, 50), "count", fixed={"edge": 0.1}),
    Ladder("short-step", "time step", "s", "tower", (1e-3, 1e-1), knob="dt"),
)
ENGINES = ("reference", "pymunk:stock")


class Seen(Silence):
    def __init__(self):
        self.planned, self.ran = None, []

    def begin(self, planned, reused):
        self.planned = (planned, reused)

    def started(self, job):
        self.ran.append(job.key)


def climb(folder):
    climbers, seen = Climbers(SHORT, ENGINES), Seen()
    run = Execution(climbers.start(), folder, "short", "plumbline ladder", Options(jobs=1, timeout=60.0), seen,
                    climbers.after, {"ladders": climbers.told}, climbers.most)  # fmt: skip
    return run.run(), seen


@pytest.fixture(scope="module")
def climbed(tmp_path_factory):
    folder = tmp_path_factory.mktemp("climb")
    return climb(folder)


def test_the_reference_stands_and_a_stock_engine_with_a_slop_of_a_tenth_of_a_metre_does_not(climbed):
    results, _ = climbed
    found = {(c.ladder, c.engine): c for c in climbs(results.campaign)}
    assert set(found) == {("short-tower", "reference"), ("short-tower", "pymunk:stock"), ("short-step", "pymunk:stock")}
    tower = found["short-tower", "reference"]
    assert tower.frontier[:3] == (50.0, None, "")
    broken = found["short-tower", "pymunk:stock"]
    assert broken.frontier.bad < 50.0
    assert broken.frontier.silent
    assert broken.why
    assert found["short-step", "pymunk:stock"].tries[0].rung == 1e-3


def test_every_try_is_in_the_journal_and_the_manifest(climbed):
    results, seen = climbed
    manifest = json.loads((results.folder / "run.json").read_text())
    keys = [key for told in manifest["ladders"].values() for tries in told["climbs"].values() for _, key in tries]
    assert {entry["key"] for entry in manifest["plan"]} == set(keys) == {c.key for c in results.cells}
    assert seen.planned == (8, 0)
    assert not without_ladders(results.campaign).cells


def test_a_climb_goes_on_from_what_is_there(climbed):
    results, before = climbed
    again, seen = climb(results.folder)
    assert before.ran
    assert seen.ran == []
    assert climbs(again.campaign) == climbs(results.campaign)


def test_the_page_shows_ladders_instead_of_verdicts(climbed):
    results, _ = climbed
    html = results.report()["index.html"].read_text()
    assert 'id="ladders"' in html
    assert 'id="verdicts"' not in html
    assert "short-tower" in html
    assert Results.read(results.folder).campaign.ladders == results.campaign.ladders


def test_the_command_prints_frontiers(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    words = ["ladder", "overlap", "-e", "reference", "--progress", "off", "--out", "here"]
    assert main([*words, "--json"]) == 0
    (row,) = json.loads(capsys.readouterr().out)["frontiers"]
    assert (row["last good"], row["first bad"], row["broke"], row["silent"]) == (None, 1e-4, "refused", False)
    assert "overlap by 0.0001 m" in row["why"]
    assert main(words) == 0
    assert "refused" in capsys.readouterr().out


@pytest.mark.parametrize(("words", "said"), [
    (["ladder", "mas-ratio"], "did you mean mass-ratio"), (["ladder", "-e", "bulet"], "there is no engine"),
])  # fmt: skip
def test_what_there_is_not(words, said, capsys):
    assert main(words) == 2
    assert said in capsys.readouterr().err


def test_a_ladder_nobody_can_climb(capsys):
    assert main(["ladder", "step-size", "-e", "reference"]) == 5
    assert "no engine has the knob" in capsys.readouterr().err


def test_ladders_are_listed(capsys):
    assert main(["list", "ladders"]) == 0
    assert "mass-ratio" in capsys.readouterr().out
