"""Imports go down only, and the judge shares no code with the judged."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FLOOR = {
    "mechanics": 1,
    "scenarios": 2,
    "reference_impl": 2,
    "adapters": 3,
    "comparisons": 4,
    "reports": 5,
    "plumbline": 6,
}
ENGINES = {"pybullet", "mujoco", "pymunk"}
FILES = sorted(path.relative_to(ROOT) for package in FLOOR for path in (ROOT / package).rglob("*.py"))


def imports(path):
    """Absolute names of everything a file imports, wherever in the file; relative imports are not the house's."""
    for node in ast.walk(ast.parse((ROOT / path).read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}:{node.lineno} imports relatively"
            yield node.module


@pytest.mark.parametrize("path", FILES, ids=str)
def test_imports_go_down_only(path):
    package = path.parts[0]
    for name in imports(path):
        other = name.partition(".")[0]
        if other in FLOOR and other != package:
            assert FLOOR[other] < FLOOR[package], f"{path} imports {name}"


@pytest.mark.parametrize("path", [p for p in FILES if p.parts[0] in ("comparisons", "reports", "scenarios")], ids=str)
def test_judges_and_questions_know_no_engine(path):
    for name in imports(path):
        assert name.partition(".")[0] not in {"reference_impl", *ENGINES}, f"{path} imports {name}"
        assert not name.startswith(tuple(f"adapters.{e}" for e in ("reference", *ENGINES))), f"{path} imports {name}"


@pytest.mark.parametrize("path", [p for p in FILES if p.parts[0] == "adapters"], ids=str)
def test_the_reference_engine_is_driven_by_its_adapter_only(path):
    if not path.stem.startswith("reference"):
        assert not any(name.startswith("reference_impl") for name in imports(path))


def test_the_rule_has_something_to_rule():
    assert {path.parts[0] for path in FILES} == set(FLOOR)
    assert set(imports(Path("adapters/run.py"))) >= {"adapters.engine", "mechanics.scene", "numpy"}
