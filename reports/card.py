"""The read-back card as a table, and the cells it makes incomparable."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from comparisons.cell import Campaign, Cell
from comparisons.reading import Reading, dependent, facts, fastest, from_plain
from reports.numbers import short, unit_text
from reports.verdict import description, engines


@dataclass(frozen=True)
class Entry:
    """What one engine got.

    Attributes
    ----------
    text : str
        The number, with ≠ in front of what differs; "–" for a refusal, "?" for what could not be read.
    verdict : str
        As of `Reading.verdict`; "" where the engine was not asked.
    hover : str
        Extremes and remarks.
    """

    text: str
    verdict: str
    hover: str


@dataclass(frozen=True)
class Line:
    """One reading over all engines; `asked` is what most of them were asked."""

    name: str
    asked: str
    entries: tuple[Entry, ...]


def cards(campaign: Campaign) -> dict[str, tuple[Reading, ...]]:
    """Engine -> its card, of those that have one, in the order of the page."""
    found = {}
    for engine in engines(campaign):
        rows = campaign.engines.get(engine, {}).get("card", {}).get("readings", ())
        if rows:
            found[engine] = tuple(from_plain(row) for row in rows)
    return found


def lines(of: Mapping[str, Sequence[Reading]]) -> tuple[Line, ...]:
    """The readings of all cards, each engine's answer beside the others'."""
    first: dict[str, Reading] = {}
    for card in of.values():
        for reading in card:
            first.setdefault(reading.name, reading)
    by_name = [{r.name: r for r in card} for card in of.values()]
    return tuple(
        Line(_heading(reading), _value(reading.asked), tuple(_entry(own.get(name), reading.asked) for own in by_name))
        for name, reading in first.items()
    )


def remarks(of: Mapping[str, Sequence[Reading]]) -> list[str]:
    """Sentences on what was refused or could not be read, one per engine and reason."""
    found: dict[tuple[str, str], list[str]] = {}
    for engine, card in of.items():
        for reading in card:
            if reading.said and reading.verdict in ("refused", "unread"):
                found.setdefault((engine, reading.said), []).append(reading.name)
    return [f"{engine}: {', '.join(names)}: {said}" for (engine, said), names in found.items()]


def differing(campaign: Campaign, cell: Cell) -> tuple[Reading, ...]:
    """What an engine got otherwise than asked and on which the scenario of the cell depends."""
    told = campaign.engines.get(cell.engine, {}).get("card", {})
    scene = description(campaign, cell.scenario).get("scene")
    if not scene or told.get("settings") != dict(cell.settings):
        return ()
    own, speeds = facts(scene), fastest(scene, cell.duration)
    return tuple(r for r in map(from_plain, told["readings"]) if r.matters(own, speeds))


def at_stake(campaign: Campaign) -> dict[str, list[str]]:
    """Engine -> what it got otherwise than asked, of what some scenario of the campaign depends on."""
    found: dict[str, dict[str, None]] = {}
    for cell in campaign.cells:
        for reading in differing(campaign, cell):
            found.setdefault(cell.engine, {})[told(reading)] = None
    return {engine: list(sentences) for engine, sentences in found.items()}


def incomparable(campaign: Campaign, cell: Cell) -> str:
    """What of a cell compares two different questions, and why; "" if nothing does."""
    own = differing(campaign, cell)
    hit = [m.quantity for m in cell.measurements if dependent(m.quantity, own)]
    if not own or (cell.measurements and not hit):
        return ""
    return f"not comparable, {'; '.join(told(r) for r in own)}" + (f": {', '.join(hit)}" if hit else "")


def told(reading: Reading) -> str:
    """ "restitution at 1 m/s: asked 0.8, got 0.13"."""
    unit = unit_text(reading.unit)
    asked = _value(reading.asked) if math.isinf(reading.asked) else f"{_value(reading.asked)} {unit}".rstrip()
    return f"{reading.name}: asked {asked}, got {_range(reading)} {unit}".rstrip()


def _heading(reading: Reading) -> str:
    unit = unit_text(reading.unit)
    return f"{reading.name} [{unit}]" if unit else reading.name


def _entry(reading: Reading | None, asked: float) -> Entry:
    if reading is None:
        return Entry("", "", "")
    if math.isnan(reading.got):
        return Entry("–" if reading.refused else "?", reading.verdict, reading.said)
    text = _value(reading.got)
    if reading.asked != asked:
        text += f" of {_value(reading.asked)}"
    extremes = "" if math.isnan(reading.least) else _range(reading)
    hover = "; ".join(filter(None, (extremes, reading.said)))
    return Entry(f"≠ {text}" if reading.verdict == "differs" else text, reading.verdict, hover)


def _value(value: float) -> str:
    """Three digits; what a computation leaves of zero is not worth them."""
    return "none" if math.isinf(value) else short(0.0 if abs(value) < 1e-12 else value)


def _range(reading: Reading) -> str:
    if math.isnan(reading.least) or _value(reading.least) == _value(reading.most):
        return _value(reading.got)
    return f"{_value(reading.least)} to {_value(reading.most)} over the phases of a step"
