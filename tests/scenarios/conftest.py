"""Numbers computed elsewhere with 40 digits, one test for each.

`oracle_numbers.toml` holds the numbers of a catalogue of closed forms, evaluated in 40-digit arithmetic and checked by
a second route for each entry; they were printed with up to 17 digits.  A module with a dictionary ENTRIES, entry ->
function that computes its quantities, has every test with an argument `printed` repeated for each of the numbers.
"""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

DIGITS = 4e-14  # relative: what double arithmetic keeps of 17 printed digits over a dozen operations
NUMBERS = tomllib.loads(Path(__file__).with_name("oracle_numbers.toml").read_text(encoding="utf-8"))


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    if "printed" not in metafunc.fixturenames:
        return
    rows = []
    for name, compute in metafunc.module.ENTRIES.items():
        printed = dict(NUMBERS[name])
        digits = DIGITS * printed.pop("loss", 1.0)  # cancellation costs some entries more
        for quantity, value in printed.items():
            close = pytest.approx(float(value), rel=digits, abs=digits)
            rows.append(pytest.param(compute, quantity, close, id=f"{name}-{quantity}"))
    metafunc.parametrize(("compute", "quantity", "printed"), rows)
