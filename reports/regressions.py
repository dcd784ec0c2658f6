"""Cells beside their records in a baseline, in words: the same for page, Markdown, terminal and JUnit."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from comparisons.cell import Campaign
from comparisons.regression import OTHER, SAME, Change, changes, tally
from reports.content import Content
from reports.numbers import listed, settings_text, short, with_unit
from reports.verdict import Mark, anchor, engine_order, sentence

MARKS = {
    "identical": Mark("=", "identical", "pass"),
    "in band": Mark("≈", "in band", "pass"),
    "improved": Mark("▲", "improved", "known"),
    "moved": Mark("◆", "moved", "fail"),
    "regressed": Mark("▼", "regressed", "fail"),
    "gone": Mark("∅", "gone", "fail"),
    "new": Mark("+", "new", "none"),
    "not comparable": Mark("≁", "not comparable", "none"),
}
LEADS = {
    "regressed": "Worse than recorded by more than the band, or in state.",
    "gone": "There was an answer, and there is none now.",
    "moved": "Not worse by what is demanded, but something else that is measured left its band.",
    "improved": "Better than recorded by more than the band; the old record stays until `plumbline baseline accept`.",
    "not comparable": "The scenario asks something else than when it was recorded.",
    "new": "Not in the baseline; `plumbline baseline save` records it.",
    "in band": "Not the same bits, but every number within its band.",
}


@dataclass(frozen=True)
class Line:
    """One change as printed.  `fragment` is that of the cell on the page, "" if there is none."""

    scenario: str
    engine: str
    settings: str
    sentence: str
    fragment: str


@dataclass(frozen=True)
class Chapter:
    """Changes of one outcome."""

    mark: Mark
    lead: str
    lines: tuple[Line, ...]


def lead_sentence(campaign: Campaign, found: Sequence[Change]) -> str:
    """ "Against the baseline standard (linux-x86_64-v3): 388 identical, 2 regressed." """
    baseline = campaign.baseline
    words = listed([f"{n} {word}" for word, n in tally(found).items()]) or "nothing to compare"
    foreign = sum(c.record is not None and not c.same for c in found)
    other = f", {foreign} of them recorded on another platform class" if foreign else ""
    return f"Against the baseline {baseline['name']} (platform class {baseline['platform']}): {words}{other}."


def told(change: Change) -> str:
    """What has changed, in words: "position error 0.0024 m → 0.0071 m, 3 times as much (band 0.1 %)"."""
    parts = [change.why] if change.why else []
    if change.quantity:
        parts.append(_numbers(change))
    cell, record = change.cell, change.record
    if change.outcome in ("gone", "regressed") and cell is not None and change.why and not change.quantity:
        parts.append(sentence(cell))
    if cell is not None and record is not None and dict(record.settings) != dict(cell.settings):
        parts.append(f"settings {settings_text(record.settings)} → {settings_text(cell.settings)}")
    if cell is not None and record is not None and record.engine_version != cell.engine_version:
        parts.append(f"engine {record.engine_version} → {cell.engine_version}")
    return "; ".join(parts)


def _numbers(change: Change) -> str:
    measured = change.cell.of(change.quantity) if change.cell else None
    unit = measured.unit if measured else "1"
    digits = 3
    while digits < 17 and short(change.before, digits) == short(change.now, digits):
        digits += 1
    both = f"{with_unit(change.before, unit, digits)} → {with_unit(change.now, unit, digits)}"
    band = f"band {100 * SAME:g} %" if change.same else f"band {100 * OTHER:g} % of value or tolerance"
    factor = change.now / change.before if change.before else math.inf
    if change.outcome not in ("regressed", "improved") or not (factor < 1e4 and abs(factor - 1.0) > 0.02):
        return f"{change.quantity} {both} ({band})"
    much = f"{short(factor)} times as much" if factor > 1.0 else f"{short(100 * factor, 2)} % of it"
    return f"{change.quantity} {both}, {much} ({band})"


def chapters(campaign: Campaign, found: Sequence[Change]) -> tuple[Chapter, ...]:
    """Everything that is not identical, by outcome, what weighs most first."""
    fragments = {id(c): name for c, name in zip(campaign.cells, anchor(campaign).values(), strict=True)}
    order = {name: k for k, name in enumerate(engine_order(c.engine for c in found))}
    made = []
    for outcome, lead in LEADS.items():
        own = sorted((c for c in found if c.outcome == outcome), key=lambda c: order[c.engine])
        lines = tuple(
            Line(c.scenario, c.engine, settings_text(c.settings), told(c), fragments.get(id(c.cell), "")) for c in own
        )
        if lines:
            made.append(Chapter(MARKS[outcome], lead, lines))
    return tuple(made)


def shown(content: Content) -> Mapping[str, Any]:
    """What the section of the page shows."""
    found = changes(content.campaign)
    if not found:
        return {}
    return {"lead": lead_sentence(content.campaign, found), "chapters": chapters(content.campaign, found)}
