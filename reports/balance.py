"""Energy, momentum, restitution, penetration and stability: the same quantity side by side for every engine."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from comparisons.cell import Campaign, Cell
from comparisons.measurement import Measurement
from comparisons.stability import STABLE, words
from reports.numbers import short, unit_text
from reports.verdict import chosen, engines, scenarios

SUBJECTS = ("energy", "momentum", "restitution", "penetration", "stability")


@dataclass(frozen=True)
class Line:
    """One quantity of one scenario over all engines.

    Attributes
    ----------
    quantity, unit : str
    values : tuple of str
        One per engine: at most three digits; "" if the engine was not measured.
    texts : tuple of str
        What the measurement says besides its number.
    broken : tuple of bool
        Whether the value is beyond its tolerance.
    """

    quantity: str
    unit: str
    values: tuple[str, ...]
    texts: tuple[str, ...]
    broken: tuple[bool, ...]


@dataclass(frozen=True)
class Section:
    """The lines of one scenario."""

    scenario: str
    lines: tuple[Line, ...]


def balance(
    campaign: Campaign, asked: Mapping[str, float] | None = None, subjects: Sequence[str] = SUBJECTS
) -> tuple[Section, ...]:
    """Lines of every scenario for quantities about `subjects`, subject by subject.

    Parameters
    ----------
    asked : mapping, optional
        Scenario -> coefficient of restitution it declares, written beside what was got.
    """
    table, order = chosen(campaign), engines(campaign)
    sections = []
    for scenario in scenarios(campaign):
        cells = [table.get((scenario, e)) for e in order]
        names = _quantities([c for c in cells if c], subjects)
        lines = tuple(_line(name, cells, (asked or {}).get(scenario)) for name in names)
        if lines:
            sections.append(Section(scenario, lines))
    return tuple(sections)


def _quantities(cells: Sequence[Cell], subjects: Sequence[str]) -> list[str]:
    names = dict.fromkeys(m.quantity for c in cells for m in c.measurements)
    return list(dict.fromkeys(n for subject in subjects for n in names if subject in n.lower()))


def _line(quantity: str, cells: Sequence[Cell | None], asked: float | None) -> Line:
    found = [c.of(quantity) if c else None for c in cells]
    unit = next((m.unit for m in found if m), "")
    told = f" (asked {short(asked)})" if quantity == "restitution" and asked is not None else ""
    return Line(
        quantity + told,
        unit_text(unit),
        tuple(_value(m) for m in found),
        tuple(m.text if m else "" for m in found),
        tuple(m is not None and (m.verdict in ("fail", "unmeasured") or bool(broken_ways(m))) for m in found),
    )


def broken_ways(row: Measurement) -> tuple[str, ...]:
    """The words for the ways in which a motion broke; none for any other quantity."""
    return words(row.text) if row.quantity == "stability" else ()


def _value(row: Measurement | None) -> str:
    if row is None:
        return ""
    if math.isnan(row.value):
        return "unmeasured" if row.verdict == "unmeasured" else "open"
    if row.quantity == "stability":
        return ", ".join(broken_ways(row)) or STABLE
    return short(row.value)
