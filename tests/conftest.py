"""Shared by all tests: a modest, repeatable hypothesis profile, and the engines of the tests by name."""

from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

from adapters import registry

slow = [HealthCheck.too_slow, HealthCheck.function_scoped_fixture]
settings.register_profile("house", max_examples=40, deadline=None, derandomize=True, suppress_health_check=slow)
settings.load_profile("house")

# Files that compile much and little of the same: of two processes each begins with another one, so that on a machine
# without compiled kernels neither compiles again what the other one is compiling.  The longest comes early, too.
FIRST = ("test_symmetries", "test_contact_solvers", "test_stronge", "test_friction_problem", "test_mesh_contact",
         "test_penalty", "test_real_engines", "test_lecture", "test_published_table")  # fmt: skip

TOYS = Path(__file__).parent / "adapters" / "toy_engines.py"


def pytest_collection_modifyitems(items):
    """The files of `FIRST` first, everything else as it was."""
    rank = {name: number for number, name in enumerate(FIRST)}
    items.sort(key=lambda item: rank.get(item.path.stem, len(FIRST)))


@pytest.fixture(autouse=True)
def nobody_says_how_wide(monkeypatch):
    """No width of a terminal in the environment: GNU readline puts one there where it is loaded, 80 without any."""
    monkeypatch.delenv("COLUMNS", raising=False)


@pytest.fixture(scope="module")
def toys():
    """The engines of `toy_engines.py`, registered for one file of tests: toy, toy:faulty, toy:shy."""
    registry.register("toy", str(TOYS))
    yield registry.load(str(TOYS))
    registry.unregister("toy")


@pytest.fixture
def toy_file():
    """Path of the file that holds the engines of the tests."""
    return TOYS
