"""Failures whose cause is on record: a measured reason turns `fail` into `xfail`, and a cured one into `xpass`.

The record is `known.toml` beside this file, one table per known property.  `*` and `?` match in
engine, scenario and quantity; every other character, brackets included, stands for itself.  Several
scenarios of one cause are a list.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from importlib.resources import files

from comparisons.cell import Cell


@dataclass(frozen=True)
class Known:
    """One known property of an engine.

    Attributes
    ----------
    engine, quantity : str
        Patterns.
    scenario : str or sequence of str
        Pattern, or several.
    reason : str
        What was found to cause it.
    source : str
        Where it was measured or documented.
    version : str
        Engine version it was seen in; of another version it is silent.
    state : str
        State the cell has without this record: "fail", "diverged", ...
    """

    engine: str
    scenario: str | Sequence[str]
    reason: str
    source: str
    version: str
    quantity: str = "*"
    state: str = "fail"

    def about(self, cell: Cell) -> bool:
        """Whether this record speaks of the engine, version and scenario of `cell`."""
        return (
            _matches(self.engine, cell.engine)
            and any(_matches(scenario, cell.scenario) for scenario in self._scenarios)
            and cell.engine_version == self.version
        )

    @property
    def definite(self) -> bool:
        """Whether it names one cell, so that passing it is news."""
        return len(self._scenarios) == 1 and not any(sign in self.engine + self._scenarios[0] for sign in "*?")

    @property
    def _scenarios(self) -> tuple[str, ...]:
        return (self.scenario,) if isinstance(self.scenario, str) else tuple(self.scenario)


def explain(cell: Cell, records: Iterable[Known] | None = None) -> Cell:
    """`cell` with its state turned to xfail if every failing quantity is on record, or to xpass if
    a record names exactly this cell and it does not fail any more."""
    mine = [k for k in (known() if records is None else records) if k.about(cell)]
    if cell.state == "ok":
        cured = [k for k in mine if k.definite]
        return replace(cell, state="xpass", known=_reasons(cured)) if cured else cell
    fitting = [k for k in mine if k.state == cell.state]
    if cell.state != "fail":
        return replace(cell, state="xfail", known=_reasons(fitting)) if fitting else cell
    failing = [m.quantity for m in cell.measurements if m.verdict == "fail"]
    used = [k for k in fitting if any(_matches(k.quantity, q) for q in failing)]
    if failing and all(any(_matches(k.quantity, q) for k in used) for q in failing):
        return replace(cell, state="xfail", known=_reasons(used))
    return cell


@cache
def known() -> tuple[Known, ...]:
    """Every record of `known.toml`.

    Raises
    ------
    ValueError
        For a record with a missing or unknown field.
    """
    text = files("comparisons").joinpath("known.toml").read_text(encoding="utf-8")
    records = []
    for n, table in enumerate(tomllib.loads(text).get("known", [])):
        try:
            records.append(Known(**table))
        except TypeError as error:
            raise ValueError(f"known.toml: known[{n}]: {error}") from None
    return tuple(records)


def _reasons(records: Iterable[Known]) -> str:
    return " ".join(dict.fromkeys(k.reason for k in records))


def _matches(pattern: str, text: str) -> bool:
    return re.fullmatch(re.escape(pattern).replace(r"\*", ".*").replace(r"\?", "."), text) is not None
