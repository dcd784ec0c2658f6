"""Shared by all tests: a modest, repeatable hypothesis profile, and the engines of the tests by name."""

from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

from adapters import registry

slow = [HealthCheck.too_slow, HealthCheck.function_scoped_fixture]
settings.register_profile("house", max_examples=40, deadline=None, derandomize=True, suppress_health_check=slow)
settings.load_profile("house")

TOYS = Path(__file__).parent / "adapters" / "toy_engines.py"


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
