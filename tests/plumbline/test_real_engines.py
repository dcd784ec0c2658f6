"""The face with the engines it was built for: one scenario through all of them, to a report."""

import json

from adapters import registry
from plumbline.cli import main


def test_every_installed_engine_goes_the_whole_way(tmp_path, capsys):
    code = main(["run", "-e", "*", "-s", "projectile", "--out", str(tmp_path / "run"), "--json", "--progress", "off"])
    told = json.loads(capsys.readouterr().out)
    states = {cell["engine"]: cell["state"] for cell in told["cells"]}
    installed = {row.name for row in registry.listings() if row.state == "installed"}
    assert {name for name, state in states.items() if state not in ("not-installed", "error")} == installed
    assert {states[name] for name in installed if ":" not in name} == {"ok"}
    assert code == told["exit_code"]
    assert (tmp_path / "run" / "index.html").stat().st_size > 10_000
    assert all(cell["cost"] > 0.0 and cell["repeats"] == 3 for cell in told["cells"] if cell["state"] == "ok")
