"""`plumbline effects`: names, files and folders; what it finds is kept, gone on with, and reported."""

import json

import pytest
from click.testing import CliRunner

from plumbline import cli, effects
from plumbline.cli import main

SCENE = """
[[body]]
name = "ball"
shape = { type = "Sphere", radius = 0.1 }
mass = 1.0
position = [0.0, 0.0, 1.0]

[[effect]]
type = "Gravity"

[[effect]]
type = "Rotation"
"""
FLOOR = """
[[body]]
name = "floor"
shape = { type = "HalfSpace" }
"""
OWN = """
from mechanics.effects import Gravity
from mechanics.scene import Body, Scene
from mechanics.shapes import Sphere
from scenarios.scenario import Scenario, scenario


@scenario(tags=("own",))
def falling() -> Scenario:
    \"\"\"A ball falls.\"\"\"
    return Scenario(Scene((Body("ball", Sphere(0.1), 1.0),), (Gravity(),)), 0.2, 0.02, (), "none: made for this test")
"""


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "alone.toml"
    path.write_text(SCENE)
    return path


def told(*args):
    result = CliRunner().invoke(cli.cli, ["effects", *map(str, args), "--json", "--untimed"], standalone_mode=False)
    assert result.exception is None, result.output
    return json.loads(result.stdout), result.return_value


def test_a_scene_of_ones_own(scene):
    (found,), code = told(scene, "-e", "reference")
    answers = {call["effect"]: call for call in found["calls"]}
    assert answers["Rotation"]["sentence"] == "declared, but it cannot act: it could be left out"
    assert answers["Restitution"]["why"] == "there is one body"
    verdicts = {row["effect"]: row["verdict"] for row in found["proofs"][0]["rows"]}
    assert verdicts.pop("Gravity") == "changes"
    assert set(verdicts.values()) == {"same"}
    assert code == 0


def test_what_a_scene_lacks_is_a_finding(scene):
    scene.write_text(SCENE + FLOOR)
    (found,), code = told(scene, "-e", "reference")
    answers = {call["effect"]: call for call in found["calls"]}
    assert answers["Restitution"]["sentence"] == "not declared, but called for"
    assert answers["Restitution"]["why"].startswith("'ball' and 'floor' collide at t = 0.428")
    assert code == 1


def test_scenarios_in_python_and_of_the_catalogue(tmp_path):
    path = tmp_path / "mine.py"
    path.write_text(OWN)
    found, _ = told(path, "free-fall", "-e", "reference")
    assert [one["scenario"] for one in found] == ["falling", "free-fall"]


def test_what_was_found_is_kept_and_reported(scene, tmp_path, capsys, monkeypatch):
    folder = tmp_path / "kept"
    args = ["effects", str(scene), "-e", "reference", "--untimed", "--out", str(folder)]
    assert main(args) == 0
    said = capsys.readouterr().out
    assert "Rotation: declared, but it cannot act" in said
    assert "left out, the motion is the same to the last bit" in said
    monkeypatch.setattr(effects, "prove", lambda *_: pytest.fail("it was found out already"))
    assert main(args) == 0
    assert main(["report", str(folder)]) in (0, 5)
    page = (folder / "index.html").read_text()
    assert 'id="effects"' in page
    assert "alone" in page


def test_a_changed_scene_is_found_out_anew(scene, tmp_path, monkeypatch):
    folder = tmp_path / "kept"
    told(scene, "-e", "reference", "--out", folder)
    scene.write_text(SCENE.replace("1.0]", "2.0]"))
    asked = []
    real = effects.prove
    monkeypatch.setattr(effects, "prove", lambda *args: asked.append(args) or real(*args))
    told(scene, "-e", "reference", "--out", folder)
    assert len(asked) == 1


def test_unknown_names_are_usage_errors(capsys):
    assert main(["effects", "no-such-scene"]) == 2
    assert "no-such-scene" in capsys.readouterr().err
