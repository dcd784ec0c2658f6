"""Random scenes for the tests of the reference engine."""

import importlib.util
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def scenes():
    """The module `random_scenes.py` beside this file."""
    spec = importlib.util.spec_from_file_location("random_scenes", Path(__file__).with_name("random_scenes.py"))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
