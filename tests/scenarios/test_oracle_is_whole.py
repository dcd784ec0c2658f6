"""Every entry of the catalogue of numbers is reproduced or excused, and every number that is listed is compared."""

from __future__ import annotations

import runpy
import tomllib
from pathlib import Path

import pytest

HERE = Path(__file__).parent
MODULES = sorted(path for path in HERE.glob("test_oracle_*.py") if path != Path(__file__))
# how many entries the catalogue has in each of its chapters: A free flight ... H mass properties
CHAPTERS = {"A": 3, "B": 5, "C": 13, "D": 15, "E": 14, "F": 8, "G": 10, "H": 1}


def tables(name: str) -> dict[str, dict[str, object]]:
    return tomllib.loads((HERE / name).read_text(encoding="utf-8"))


NUMBERS, EXCUSED = tables("oracle_numbers.toml"), tables("oracle_excused.toml")


def entry(table: str) -> str:
    """The entry of the catalogue that a table is a part or a variant of."""
    return table.partition("-")[0]


def test_every_entry_is_reproduced_or_excused():
    whole = {f"{chapter}{k:02d}" for chapter, count in CHAPTERS.items() for k in range(1, count + 1)}
    assert {entry(name) for name in (*NUMBERS, *EXCUSED)} == whole
    assert {entry(name) for name in EXCUSED} - {entry(name) for name in NUMBERS} == {"D09", "D10", "E09", "E10", "F08"}


def test_every_table_is_computed_by_one_test_and_every_number_of_it_compared():
    computed = [name for module in MODULES for name in runpy.run_path(str(module))["ENTRIES"]]
    assert sorted(computed) == sorted(NUMBERS)
    assert all(set(table) - {"loss"} for table in NUMBERS.values())


@pytest.mark.parametrize("name", EXCUSED)
def test_an_excuse_has_a_reason_and_numbers_that_are_not_reproduced(name):
    reason, *numbers = EXCUSED[name].items()
    assert reason[0] == "reason"
    assert len(reason[1]) > 15
    assert numbers
    assert name not in NUMBERS
    reproduced = {quantity for table, said in NUMBERS.items() if entry(table) == entry(name) for quantity in said}
    whole = name == entry(name)
    assert not (whole and reproduced)
