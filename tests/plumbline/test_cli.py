"""The command line: exit codes, messages that help, output for people and for programs."""

import functools
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from plumbline.cli import main

HEAVY = {"numpy", "pandas", "pyarrow", "rich", "jinja2", "numba", "mechanics", "adapters", "comparisons", "reports"}
SCENE = """
[[body]]
name = "ball"
mass = 1.0
position = [0.0, 0.0, 1.0]
shape = { type = "Sphere", radius = 0.1 }

[[effect]]
type = "Gravity"
"""


@pytest.fixture
def command(toy_file, tmp_path, capsys, monkeypatch):
    """Runs the command line in an empty folder with the engines of the tests; (code, stdout, stderr)."""
    from adapters import registry

    monkeypatch.chdir(tmp_path)

    def call(*words, plugin=True):
        plugins = ["--plugin", str(toy_file)] if plugin else []
        code = main([*words, *plugins])
        return code, *capsys.readouterr()

    yield call
    registry.unregister("toy_engines")


def test_help_needs_nothing_heavy():
    script = "import sys, plumbline, plumbline.cli; print(*{m.partition('.')[0] for m in sys.modules})"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert not HEAVY & set(done.stdout.split())


VERBS = ("list", "describe", "run", "report", "conform", "doctor", "check", "baseline", "compare", "merge", "tables",
         "figures")  # fmt: skip


@pytest.mark.parametrize("verb", [[], *([verb] for verb in VERBS), ["baseline", "accept"]])
def test_every_verb_explains_itself(command, verb):
    code, out, _ = command(*verb, "--help", plugin=False)
    assert code == 0
    assert "Usage: plumbline" in out


def test_without_a_verb_help_is_shown(command):
    code, out, err = command(plugin=False)
    assert code == 0
    assert "Commands:" in out + err


def test_the_version_is_that_of_the_package(command):
    code, out, _ = command("--version", plugin=False)
    assert (code, out) == (0, "plumbline, version 0.1.0\n")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["run", "smok"], "no suite 'smok'; did you mean smoke"),
        (["run", "-s", "bouncing"], "no scenario 'bouncing'; did you mean bouncing-ball"),
        (["run", "-s", "bouncing-ball[e=7]"], "e = 7; allowed: 0.1 to 1"),
        (["run", "-e", "bullet"], "no engine 'bullet'"),
        (["run", "-e", "toy", "--set", "tempo=1"], "no knob 'tempo'"),
        (["run", "-e", "toy", "--set", "dt=fast"], "allowed: a finite number > 0"),
        (["run", "--timeout", "soon"], "'soon' is not a time"),
        (["run", "--jobs", "0"], "0 is not in the range x>=1"),
        (["run", "--fail-on", "bad"], "no state 'bad'"),
        (["run", "--progress", "loud"], "'auto', 'plain', 'off'"),
        (["run", "smoke", "--duration", "1s"], "--duration and --sampling are for scenes in TOML"),
        (["run", "smoke", "--dt", "1e-3"], "--dt is for `plumbline run published`"),
        (["run", "published", "--set", "dt=1"], "published figures have settings of their own"),
        (["run", "no.toml"], "there is no file no.toml"),
        (["describe", "bouncing"], "did you mean bouncing-ball"),
        (["list", "scenes"], "'engines', 'scenarios', 'metrics', 'suites'"),
        (["walk"], "No such command 'walk'"),
        (["run", "--plugin", "nothing.py"], "there is no such Python file"),
    ],
)
def test_what_is_not_possible_is_named_with_what_is_and_exits_2(command, words, message):
    code, out, err = command(*words, plugin="walk" not in words)
    assert (code, out) == (2, "")
    assert message in " ".join(err.split())


def test_a_run_prints_verdicts_writes_the_report_and_names_the_page(command):
    code, out, err = command("run", "-s", "projectile", "-e", "toy", "--progress", "plain")
    assert code == 0
    assert "✓ exact" in out
    page = Path(out.rsplit("report: ", 1)[1].strip())
    assert page.name == "index.html"
    assert page.parent.parent == Path("runs")
    assert {p.name for p in page.parent.iterdir()} >= {"run.json", "cells.jsonl", "traces", "summary.md", "junit.xml"}
    assert "[1/1] ✓ exact: projectile · toy" in err
    assert "\x1b" not in out + err


def test_a_crash_exits_3_and_says_how_to_see_it_again(command):
    code, out, err = command("run", "-s", "projectile", "-e", "toy:faulty", "--set", "fault=segv", "--progress", "off")
    assert (code, err) == (3, "")
    assert "SIGSEGV" in out
    assert "again: plumbline run -e toy:faulty -s 'projectile[]' --set fault=segv" in out
    assert "exit code 3: an engine crashed" in out


def test_findings_exit_1_unless_they_do_not_count(command):
    wrong = ["run", "-s", "projectile", "-e", "toy:faulty", "--set", "fault=nan", "--progress", "off", "--out", "run"]
    assert command(*wrong)[0] == 1
    assert command(*wrong, "--fail-on", "crash")[0] == 0
    assert command(*wrong, "--fail-on", "harness")[0] == 0


def test_nothing_selected_exits_5(command):
    code, _, err = command("run", "smoke", "-s", "projectile", "-e", "toy")
    assert code == 5
    assert "nothing is selected" in err


def test_nothing_that_can_run_exits_5(command, tmp_path):
    (tmp_path / "ghost.py").write_text("import no_such_physics")
    words = ["run", "-s", "projectile", "-e", "ghost", "--plugin", "ghost.py", "--progress", "off"]
    try:
        code, out, _ = command(*words)
    finally:
        from adapters import registry

        registry.unregister("ghost")
    assert code == 5
    assert "not installed" in out
    assert "pip install no_such_physics" in out


def test_what_cannot_be_written_exits_4_before_anything_is_run(command, tmp_path):
    (tmp_path / "file").write_text("")
    for words in (["--out", "file/run"], ["--junit", "file/junit.xml"], ["--summary", "no/where.md"]):
        code, out, err = command("run", "-s", "projectile", "-e", "toy", "--progress", "off", *words)
        assert (code, out) == (4, "")
        assert "cannot write" in err


def test_json_is_all_there_is_on_stdout(command):
    code, out, _ = command("run", "-s", "projectile", "-e", "toy*", "--json", "--progress", "off")
    told = json.loads(out)
    assert (code, told["exit_code"]) == (0, 0)
    assert [c["engine"] for c in told["cells"]] == ["toy", "toy:faulty", "toy:shy"]
    assert Path(told["files"]["index.html"]).is_file()


def test_copies_for_continuous_integration(command, tmp_path):
    (tmp_path / "summary.md").write_text("before\n")
    words = ["run", "-s", "projectile", "-e", "toy", "--progress", "off", "--junit", "j.xml", "--summary", "summary.md"]
    assert command(*words)[0] == 0
    assert (tmp_path / "j.xml").read_text().startswith("<?xml")
    assert (tmp_path / "summary.md").read_text().startswith("before\n#")


def test_a_dry_run_runs_nothing(command, tmp_path):
    code, out, _ = command("run", "smoke", "-e", "toy", "--dry-run")
    assert code == 0
    assert "6 cells" in out
    assert not (tmp_path / "runs").exists()


def test_a_scene_file_runs_as_a_scenario_without_a_truth(command, tmp_path):
    (tmp_path / "drop.toml").write_text(SCENE)
    code, out, _ = command("run", "drop.toml", "-e", "toy", "--duration", "0.3s", "--sampling", "0.1", "--json",
                           "--progress", "off")  # fmt: skip
    (cell,) = json.loads(out)["cells"]
    assert (code, cell["scenario"], cell["duration"], cell["state"]) == (0, "drop", 0.3, "ok")
    assert {m["verdict"] for m in cell["measurements"]} == {"info"}
    assert "energy error" in {m["quantity"] for m in cell["measurements"]}
    again = cell["reproduce"].split()[1:]
    code, out, _ = command(*[w.strip("'") for w in again], "--dry-run", "--json")
    assert [row["key"] for row in json.loads(out)] == [cell["key"]]


def test_a_scene_of_ones_own_is_judged_anew_from_its_run_alone(command, tmp_path):
    (tmp_path / "drop.toml").write_text(SCENE)
    assert command("run", "drop.toml", "-e", "toy", "--out", "run", "--progress", "off")[0] == 0
    (tmp_path / "drop.toml").unlink()
    code, out, err = command("report", "run", "--json", plugin=False)
    assert (code, err) == (0, "")
    assert "energy error" in {m["quantity"] for m in json.loads(out)["cells"][0]["measurements"]}


def test_a_scene_that_is_not_possible_names_the_key(command, tmp_path):
    (tmp_path / "bad.toml").write_text(SCENE.replace("mass = 1.0", "mass = -1.0"))
    code, _, err = command("run", "bad.toml", "-e", "toy")
    assert code == 2
    assert "body[0].mass" in err


def test_bodies_that_overlap_at_the_start_are_reported(command, tmp_path):
    two = SCENE + SCENE.partition("[[effect]]")[0].replace('"ball"', '"other"').replace("1.0]", "1.15]")
    (tmp_path / "two.toml").write_text(two + '[[effect]]\ntype = "Restitution"\ncoefficient = 0.5\n')
    _, _, err = command("run", "two.toml", "-e", "toy", "--progress", "off")
    assert "note: two: ball and other overlap by 0.05 m at the start" in err


def test_a_python_file_with_scenarios_runs_them(command, tmp_path):
    (tmp_path / "mine.py").write_text(
        "from plumbline import Body, Check, Gravity, Scenario, Scene, Sphere, scenario\n"
        "@scenario(tags=('own',), variants=({}, {'speed': 2.0}))\n"
        "def toss(speed: float = 1.0) -> Scenario:\n"
        "    '''A ball is thrown up.'''\n"
        "    ball = Body('ball', Sphere(0.1), mass=1.0, velocity=(0.0, 0.0, speed))\n"
        "    checks = (Check('energy error', 1e-6, 'rounding'),)\n"
        "    return Scenario(Scene((ball,), (Gravity(),)), 0.5, 0.1, checks, 'none')\n"
    )
    code, out, _ = command("run", "mine.py", "-e", "toy", "--json", "--progress", "off")
    cells = json.loads(out)["cells"]
    assert (code, [c["scenario"] for c in cells], {c["state"] for c in cells}) == (0, ["toss", "toss[speed=2]"], {"ok"})
    code, out, _ = command(*cells[0]["reproduce"].replace("'", "").split()[1:], "--dry-run", "--json")
    assert [row["key"] for row in json.loads(out)] == [cells[0]["key"]]
    assert command("describe", "toss", plugin=False)[0] == 2  # the house has not taken it in


def test_a_python_file_that_breaks_names_the_line(command, tmp_path):
    (tmp_path / "bad.py").write_text("import math\n\nmath.sqrt(-1)\n")
    code, _, err = command("run", "bad.py", "-e", "toy")
    assert code == 2
    assert "bad.py, line 3: ValueError" in err
    late = [
        "from plumbline import scenario",
        "@scenario(tags=())",
        "def late():",
        "    'Breaks when built.'",
        "    1 / 0",
    ]
    (tmp_path / "late.py").write_text("\n".join(late))
    assert "late.py, line 5: ZeroDivisionError" in command("run", "late.py", "-e", "toy")[2]
    (tmp_path / "empty.py").write_text("")
    assert "holds no scenario" in command("run", "empty.py", "-e", "toy")[2]


def test_a_report_judges_archived_motions_anew(command, tmp_path):
    command("run", "-s", "projectile", "-e", "toy*", "--progress", "off", "--out", "one")
    command("run", "-s", "free-fall[]", "-e", "toy", "--progress", "off", "--out", "two")
    code, out, err = command("report", "one", "two", "--out", "both", "--junit", "j.xml", plugin=False)
    assert (code, err) == (0, "")
    assert "report: both/index.html" in out
    assert "free-fall" in (tmp_path / "j.xml").read_text()
    code, _, err = command("report", "nowhere", plugin=False)
    assert code == 4
    assert "nowhere is not a run" in err


def test_lists_and_descriptions_are_for_people_and_programs(command):
    code, out, _ = command("list", "--json")
    told = json.loads(out)
    assert code == 0
    assert set(told) == {"engines", "suites", "scenarios", "metrics", "ladders"}
    assert {"toy", "toy:faulty"} <= {e["name"] for e in told["engines"]}
    code, out, _ = command("list", "suites")
    assert "standard" in out
    for name, word in (("bouncing-ball[e=0.5]", "tolerances"), ("toy", "the parabola is exact"), ("smoke", "free-fall"),
                       ("energy error", "energy")):  # fmt: skip
        code, out, _ = command("describe", name)
        assert code == 0
        assert word in out
        assert json.loads(command("describe", name, "--json")[1])["name"] == name


def test_conform_shows_every_law_of_every_engine(command, tmp_path):
    code, out, _ = command("conform", "toy", "toy:shy")
    assert code == 1
    assert "falls with g" in out
    assert "✕ toy, spins with Rotation" in out
    told = json.loads(command("conform", "toy", "--json")[1])["toy"]
    assert {law["name"] for law in told if not law["passed"]} >= {"spins with Rotation"}
    assert next(law for law in told if law["name"] == "falls with g")["passed"]


def test_conform_survives_an_engine_that_does_not(command, tmp_path):
    (tmp_path / "bomb.py").write_text(
        "import ctypes\nname, version, effects, knobs = 'bomb', '1', {}, {}\n"
        "vacuum = start = advance = read = lambda *_: ctypes.string_at(0)\n"
    )
    from adapters import registry

    try:
        code, out, _ = command("conform", "bomb", "--plugin", "bomb.py")
    finally:
        registry.unregister("bomb")
    assert code == 3
    assert "bomb: crash: SIGSEGV" in out
    assert "Segmentation fault" in out


def test_the_doctor_examines_the_machine(command, monkeypatch):
    from plumbline import noise

    monkeypatch.setattr(noise, "LEAST", 2)
    code, out, _ = command("doctor", "--trial", "0.1s", "--json")
    told = json.loads(out)
    assert code == 0
    assert told["noise"]["trials"] >= 2
    assert {"envelope of 3", "envelope of 9"} <= set(told["noise"]["statistics"])
    assert told["fingerprint"]["python"].startswith("CPython")
    code, out, _ = command("doctor", "--trial", "0.1s")
    assert code == 0
    assert out.count("toy") == 3
    assert "alarms at 5 %" in out


@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_ends_workers_keeps_the_journal_and_exits_130(toy_file, tmp_path, sent):
    words = ["run", "-s", "projectile", "-s", "free-fall[]", "-e", "toy", "-e", "toy:faulty", "--set", "fault=hang",
             "--repeats", "1", "--plugin", str(toy_file), "--out", "run", "--progress", "plain",
             "--timeout", "60s"]  # fmt: skip
    # a test run in the background of a script ignores interrupts, and what it starts would inherit that
    heed = functools.partial(signal.signal, sent, signal.SIG_DFL)
    process = subprocess.Popen(
        [sys.executable, "-m", "plumbline", *words], cwd=tmp_path, stderr=subprocess.PIPE, text=True, preexec_fn=heed
    )
    journal = tmp_path / "run" / "cells.jsonl"
    deadline = time.monotonic() + 60.0
    while time.monotonic() < deadline and not (journal.exists() and len(journal.read_text().splitlines()) == 2):
        time.sleep(0.05)
    process.send_signal(sent)
    _, err = process.communicate(timeout=30)
    assert process.returncode == 130
    assert "--out run` goes on from there" in err
    assert "Traceback" not in err
    assert {json.loads(line)["engine"] for line in journal.read_text().splitlines()} == {"toy"}
    assert json.loads((tmp_path / "run" / "run.json").read_text())["stopped"] == "the run was interrupted"


def test_a_reader_that_goes_away_is_no_error(toy_file):
    script = f"{sys.executable} -m plumbline list --plugin {toy_file} | head -n 1"
    done = subprocess.run(["bash", "-o", "pipefail", "-c", script], capture_output=True, text=True, check=False)
    assert done.stderr == ""
    assert done.returncode == 0


def test_a_fault_of_ours_is_no_finding(command, monkeypatch):
    from plumbline import listing

    monkeypatch.setattr(listing, "show", lambda *_: 1 / 0)
    code, _, err = command("list")
    assert code == 4
    assert "ZeroDivisionError" in err
    assert "a fault of plumbline itself" in err


def test_no_colour_where_none_is_wanted(toy_file, tmp_path):
    words = ["run", "-s", "projectile", "-e", "toy", "--plugin", str(toy_file), "--progress", "off"]
    environment = os.environ | {"NO_COLOR": "1", "FORCE_COLOR": "1", "TERM": "xterm-256color"}
    done = subprocess.run([sys.executable, "-m", "plumbline", *words], cwd=tmp_path, env=environment,
                          capture_output=True, text=True, check=True)  # fmt: skip
    assert "\x1b[3" not in done.stdout  # bold and dim are no colours
