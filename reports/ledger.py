"""The predicted-error ledger: what each engine's scheme alone must cost, what was measured, and what is left."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from comparisons.cell import Campaign, Cell
from comparisons.predicted import CONTACT, ENERGY, LEFT, SOLVER, SQUARE, STEPPING
from reports.content import Content
from reports.numbers import listed, short, unit_text
from reports.verdict import chosen, engines, first_of_family, scenarios

ROWS = (  # quantity -> what a row calls it; below what was measured stands what was foretold, and what is left
    ("position error", "position error, measured"),
    (STEPPING, "· by time stepping"),
    (LEFT, "· left beyond time stepping"),
    (CONTACT, "· by the scheme with an ideal contact"),
    (SOLVER, "· left beyond scheme and contact: solver"),
    ("energy error", "energy error, as reported"),
    (ENERGY, "· by time levels"),
    ("energy error, synchronised", "· left when synchronised"),
    ("mean square energy error", "mean square energy error, measured"),
    (SQUARE, "· by the textbook"),
)
REST = {LEFT: "position error", SOLVER: "position error", "energy error, synchronised": "energy error"}
FORETOLD = (STEPPING, CONTACT, ENERGY, SQUARE)
WHOLE = 0.01  # of the measured error: what is left is less than this where the scheme explains it


@dataclass(frozen=True)
class Row:
    """One quantity of one scenario over the engines; `explained` where next to nothing is left of what was measured."""

    name: str
    unit: str
    values: tuple[str, ...]
    explained: tuple[bool, ...]


@dataclass(frozen=True)
class Account:
    """The rows of one scenario."""

    scenario: str
    rows: tuple[Row, ...]


def shown(content: Content) -> Mapping[str, Any]:
    """What the section shows; nothing where nothing was foretold."""
    order = foretold(content.suite)
    accounts = ledger(content.suite, order)
    if not accounts:
        return {}
    first = first_of_family(content.suite, [a.scenario for a in accounts])
    return {
        "tables": [
            ("", [a for a in accounts if a.scenario in first]),
            ("Other variants", [a for a in accounts if a.scenario not in first]),
        ],
        "order": [content.engines[e] for e in order],
        "summary": summary(content.suite, order),
    }


def foretold(campaign: Campaign) -> list[str]:
    """Engines of which an error of first order is foretold somewhere, in the order of every table."""
    found = {cell.engine for cell in campaign.cells if _foretold(cell)}
    return [e for e in engines(campaign) if e in found]


def _foretold(cell: Cell) -> bool:
    """Whether some error is foretold that is not 0."""
    return any((m := cell.of(name)) is not None and m.value > 0.0 for name in FORETOLD)


def ledger(campaign: Campaign, order: Sequence[str]) -> tuple[Account, ...]:
    """The account of every scenario in which something was foretold of one of the engines."""
    table, accounts = chosen(campaign), []
    for scenario in scenarios(campaign):
        cells = [table.get((scenario, engine)) for engine in order]
        if any(_foretold(cell) for cell in cells if cell is not None):
            rows = [_row(quantity, name, cells) for quantity, name in ROWS]
            accounts.append(Account(scenario, tuple(row for row in rows if any(row.values))))
    return tuple(accounts)


def explained(cell: Cell, quantity: str) -> bool:
    """Whether less than a hundredth of the measured error is left beyond what was foretold."""
    left, measured = cell.of(quantity), cell.of(REST[quantity])
    return left is not None and measured is not None and left.value < WHOLE * measured.value


def summary(campaign: Campaign, order: Sequence[str]) -> str:
    """How many position errors each engine's scheme explains, with or without an ideal contact, and of how many."""
    table, told = chosen(campaign), []
    for engine in order:
        cells = [table[s, engine] for s in scenarios(campaign) if (s, engine) in table]
        tried = [c for c in cells if any(c.of(q) is not None for q in (LEFT, SOLVER))]
        if tried:
            whole = sum(any(explained(c, q) for q in (LEFT, SOLVER)) for c in tried)
            told.append(f"{engine} {whole} of {len(tried)}")
    return f"Position errors that the scheme explains to 1 %: {listed(told)}." if told else ""


def _row(quantity: str, name: str, cells: Sequence[Cell | None]) -> Row:
    found = [c.of(quantity) if c is not None else None for c in cells]
    unit = next((unit_text(m.unit) for m in found if m is not None), "")
    values = tuple("" if m is None or math.isnan(m.value) else short(m.value) for m in found)
    whole = tuple(c is not None and quantity in REST and explained(c, quantity) for c in cells)
    return Row(name, unit, values, whole)
