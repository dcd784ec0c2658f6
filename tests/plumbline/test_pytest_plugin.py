"""`pytest --plumbline ENGINE` as the developer of an engine sees it."""

import os
import subprocess
import sys
from importlib import metadata
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest

ROOT = Path(__file__).parents[2]
TOYS = ROOT / "tests" / "adapters" / "toy_engines.py"
INSTALLED = any(point.name == "plumbline" for point in metadata.entry_points(group="pytest11"))
HEAVY = """
import sys

sys.path.insert(0, {folder!r})
from toy_engines import Toy


class Heavy(Toy):
    @staticmethod
    def gravity(draft, effect):
        Toy.gravity(draft, effect)
        draft.g *= 1.01


heavy = Heavy("heavy")
ENGINES = {{"heavy": heavy}}
"""
OWN_TEST = "def test_of_ones_own():\n    assert True\n"


@pytest.fixture
def run(tmp_path):
    """Runs pytest in a folder with one test of its own; (exit code, stdout)."""
    (tmp_path / "test_own.py").write_text(OWN_TEST)

    def call(*words):
        loaded = [] if INSTALLED else ["-p", "plumbline.pytest_plugin"]
        done = subprocess.run(
            [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", *loaded, *words], cwd=tmp_path, text=True,
            capture_output=True, env={**os.environ, "PYTHONPATH": str(ROOT), "PYTEST_ADDOPTS": ""}, check=False,
        )  # fmt: skip
        return done.returncode, done.stdout + done.stderr

    return call


def plumbline(*words):
    return ["--plumbline-plugin", str(TOYS), *(w for word in words for w in ("--plumbline", word))]


def test_scenarios_pass_are_skipped_and_stand_beside_ones_own_tests(run, tmp_path):
    junit = tmp_path / "junit.xml"
    code, said = run(*plumbline("toy"), "--plumbline-scenario", "projectile", "--plumbline-scenario", "sliding-block[]",
                     "-rs", "-v", "--junit-xml", str(junit))  # fmt: skip
    assert code == 0, said
    assert "2 passed, 1 skipped" in said
    assert "toy::projectile PASSED" in said
    assert "toy has no Friction; it has Gravity, Rotation" in said
    (case,) = (
        c
        for c in ET.parse(junit).iter("testcase")
        if c.get("classname") == "plumbline.toy" and c.get("name") == "projectile"
    )
    assert "position error [m]" in {p.get("name") for p in case.iter("property")}


def test_a_failure_is_told_in_words_with_the_command_and_without_a_traceback(run):
    code, said = run(*plumbline("toy:faulty"), "--plumbline-scenario", "projectile", "--plumbline-set", "fault=segv",
                     "--plumbline-set", "fault=none", "--plumbline-set", "fault=print")  # fmt: skip
    assert code == 1
    assert "1 failed, 3 passed" in said
    assert "! crash: projectile in toy:faulty 1.2.3" in said
    assert "SIGSEGV, in advance after t = 0.5" in said
    assert "Segmentation fault" in said
    assert "reproduce: plumbline run -e toy:faulty -s 'projectile[]' --set fault=segv" in said
    assert "Traceback" not in said
    assert "pytest_plugin.py" not in said


def test_a_wrong_answer_names_quantity_value_tolerance_and_reason(run, tmp_path):
    (tmp_path / "heavy.py").write_text(HEAVY.format(folder=str(TOYS.parent)))
    words = ["--plumbline", "heavy", "--plumbline-plugin", "heavy.py", "--plumbline-scenario", "projectile"]
    code, said = run(*words)
    assert code == 1
    assert "✕ fail: projectile in heavy 1.2.3" in said
    assert "settings: dt = 0.05" in said
    lines = [line for line in said.splitlines() if line.startswith("fail ")]
    assert lines
    assert all(", tolerance " in line and " tol)" in line for line in lines)
    assert "because g t h/2" in said


def test_what_fails_for_a_reason_on_record_is_expected_to(run):
    code, said = run("--plumbline", "pymunk:stock", "--plumbline-scenario", "free-fall[]", "-rx")
    assert code == 0
    assert "1 xfailed" in said
    assert "pymunk moves first and kicks then" in said


def test_k_chooses_and_without_the_option_there_are_no_scenarios(run):
    code, said = run(*plumbline("toy"), "-k", "free-fall and not mass", "--co", "-q")
    assert code == 0
    assert [line for line in said.splitlines() if "::" in line] == ["plumbline::toy::free-fall"]
    code, said = run("--co", "-q")
    assert [line for line in said.splitlines() if "::" in line] == ["test_own.py::test_of_ones_own"]


@pytest.mark.parametrize(
    ("words", "message"),
    [(["--plumbline", "bullet"], "--plumbline: there is no engine 'bullet'"),
     (["--plumbline", "toy", "--plumbline-plugin", str(TOYS), "--plumbline-suite", "smok"], "did you mean smoke")],
)  # fmt: skip
def test_what_is_not_there_is_a_usage_error(run, words, message):
    code, said = run(*words)
    assert code == 4
    assert message in said
    assert "Traceback" not in said


def test_the_module_imports_nothing_of_the_house():
    script = "import sys, plumbline.pytest_plugin; print(*{m.partition('.')[0] for m in sys.modules})"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True,
                          env={**os.environ, "PYTHONPATH": str(ROOT)})  # fmt: skip
    assert not {"numpy", "mechanics", "adapters", "comparisons", "reports"} & set(done.stdout.split())
