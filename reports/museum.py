"""The museum: each exhibit with its truth, and stock, fair and remedied rows side by side."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from comparisons.cell import Campaign, Cell
from reports.numbers import settings_text, short, unit_text
from reports.palette import profile
from reports.phases import Spread
from reports.verdict import Mark, description, engines, mark, scenarios, sentence

KINDS = ("reference", "stock", "fair", "recommended")


@dataclass(frozen=True)
class Row:
    """One run of an exhibit.

    Attributes
    ----------
    kind : str
        One of `KINDS`.
    engine, version, settings : str
    remedy : str
        The documented remedy and its source; "" where it is none.
    mark : Mark
    why : str
        What the verdict says.
    figures : tuple of str
        As many as the exhibit shows.
    """

    kind: str
    engine: str
    version: str
    settings: str
    remedy: str
    mark: Mark
    why: str
    figures: tuple[str, ...]


@dataclass(frozen=True)
class Table:
    """One scenario of an exhibit: heads of its figures, their true values, and the rows."""

    scenario: str
    heads: tuple[str, ...]
    truths: tuple[str, ...]
    rows: tuple[Row, ...]


@dataclass(frozen=True)
class Room:
    """One exhibit."""

    number: int
    title: str
    shown: str
    truth: str
    origin: tuple[str, ...]
    tables: tuple[Table, ...]


def rooms(campaign: Campaign) -> tuple[Room, ...]:
    """Every exhibit of the campaign, in the museum's order."""
    found: dict[int, tuple[Mapping[str, Any], list[Table]]] = {}
    for scenario in scenarios(campaign):
        label = description(campaign, scenario).get("exhibit")
        if label:
            found.setdefault(label["number"], (label, []))[1].append(_table(campaign, scenario, label))
    return tuple(
        Room(n, label["title"], label["shown"], label["truth"], tuple(label["origin"]), tuple(tables))
        for n, (label, tables) in sorted(found.items())
    )


def _table(campaign: Campaign, scenario: str, label: Mapping[str, Any]) -> Table:
    cells = [c for c in campaign.cells if c.scenario == scenario]
    units = {m.quantity: unit_text(m.unit) for c in cells for m in c.measurements}
    heads = tuple(f"{name} [{units[name]}]" if units.get(name) else name for name in label["figures"])
    truths = tuple(v if isinstance(v, str) else short(v, 4) for v in label["figures"].values())
    order = {name: k for k, name in enumerate(engines(campaign))}
    rows = [(_row(cell, label), order[cell.engine]) for cell in cells]
    rows.sort(key=lambda row: (KINDS.index(row[0].kind), row[1]))
    return Table(scenario, heads, truths, tuple(row for row, _ in rows))


def _row(cell: Cell, label: Mapping[str, Any]) -> Row:
    remedy = next((r for r in label["remedies"] if _is(cell, r)), None)
    kind = "recommended" if remedy else "reference" if cell.engine == "reference" else profile(cell.engine)
    return Row(
        kind if kind in KINDS else "fair",
        cell.engine,
        cell.engine_version,
        settings_text(cell.settings),
        f"{remedy['words']} ({remedy['source']})" if remedy else "",
        mark(cell),
        sentence(cell),
        tuple(_figure(cell, name) for name in label["figures"]),
    )


def _is(cell: Cell, remedy: Mapping[str, Any]) -> bool:
    asked = remedy["settings"]
    return cell.engine == remedy["engine"] and all(cell.settings.get(name) == value for name, value in asked.items())


def _figure(cell: Cell, name: str) -> str:
    row, spread = cell.of(name), Spread.of(cell.phases.get(name, ()))
    if spread is not None:
        return spread.text
    if row is None:
        return "–"
    return row.text if math.isnan(row.value) else short(row.value, 4)
