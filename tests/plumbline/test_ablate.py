"""The verb `ablate` on real engines."""

import json

from click.testing import CliRunner

from adapters import registry
from plumbline.cli import cli


def test_pymunk_errs_in_a_bounce_by_its_step_and_by_nothing_else(tmp_path):
    words = ["ablate", "bouncing-ball[e=0.5]", "-e", "pymunk", "--phases", "2", "--progress", "off"]
    told = CliRunner().invoke(cli, [*words, "--json", "--out", str(tmp_path / "run")], catch_exceptions=False)
    parts = {p["setting"]: p for p in json.loads(told.stdout)}
    assert next(iter(parts)) == "dt"
    assert abs(parts["dt"]["alone"] - 1.0) < 1e-2
    assert abs(parts["collision_slop"]["alone"]) < 1e-2
    assert not any("+" in name for name in registry.names())


def test_an_engine_without_two_profiles_is_named():
    told = CliRunner().invoke(cli, ["ablate", "free-fall", "-e", "reference"])
    assert told.exit_code == 2
    assert "there are: mujoco, pybullet, pymunk" in told.output
