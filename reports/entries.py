"""All cells, one entry each: verdict, every measurement, how it was run and how to run it again."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from comparisons.cell import Cell
from comparisons.measurement import Measurement
from reports.card import incomparable
from reports.charts import has_point
from reports.content import Content
from reports.numbers import count, settings_text, short, with_unit
from reports.verdict import Mark, anchor, mark, ratio, ratio_text, sentence


@dataclass(frozen=True)
class CellView:
    """One entry among all cells."""

    cell: Cell
    anchor: str
    mark: Mark
    ratio: str
    why: str
    settings: str
    cost: str
    rows: tuple[tuple[str, ...], ...]
    facts: tuple[tuple[str, str], ...]
    replay: str


def shown(content: Content) -> Mapping[str, Any]:
    """What the section shows: the entries, and every verdict that occurs among them."""
    states = list(dict.fromkeys(mark(c).word for c in content.campaign.cells))
    return {"cells": _cells(content), "states": states}


def _cells(content: Content) -> list[CellView]:
    views = []
    campaign = content.campaign
    replays = {r.scenario: r for r in content.motion.replays}
    for cell, fragment in zip(campaign.cells, anchor(campaign).values(), strict=True):
        cost = f"{short(1e3 * cell.cost)} ms/s" if has_point(cell) else ""
        rows = tuple(_measurement(m) for m in cell.measurements)
        settings = settings_text(cell.settings)
        shown = replays.get(cell.scenario)
        link = shown.link(cell.key) if shown else ""
        facts = _details(cell, incomparable(campaign, cell))
        views.append(
            CellView(cell, fragment, mark(cell), ratio_text(cell), sentence(cell), settings, cost, rows, facts, link)
        )
    return views


def _measurement(m: Measurement) -> tuple[str, ...]:
    value = m.text if math.isnan(m.value) else with_unit(m.value, m.unit, 6)
    if m.text and not math.isnan(m.value):
        value = f"{value} ({m.text})"
    demanded = "" if math.isnan(m.tolerance) else with_unit(m.tolerance, m.unit)
    share = "" if math.isnan(m.tolerance) else short(ratio(m))
    when = "" if math.isnan(m.time) else f"{short(m.time, 4)} s"
    return m.quantity, value, demanded, share, when, m.verdict, m.why


def _details(cell: Cell, differs: str) -> tuple[tuple[str, str], ...]:
    timing = ""
    if math.isfinite(cell.cost):
        timing = f"{short(1e3 * cell.cost, 4)} ms CPU per simulated second, {count(cell.repeats, 'repeat')}"
        if math.isfinite(cell.contention):
            timing += f", contention {short(100 * cell.contention, 2)} %"
            timing += " (disturbed: above 25 %)" if cell.contention > 0.25 else ""
    build = f"{short(1e3 * cell.build_seconds)} ms" if math.isfinite(cell.build_seconds) else ""
    reached = (
        f"{short(cell.time, 6)} s of {short(cell.duration, 6)} s" if cell.time else f"{short(cell.duration, 6)} s asked"
    )
    facts = {
        "Engine": f"{cell.engine} {cell.engine_version}",
        "Settings": settings_text(cell.settings),
        "Simulated": reached,
        "Cost": timing,
        "Build": build,
        "Repeats itself": "bit for bit" if cell.deterministic else "no: the cost is the least CPU time of the repeats",
        "Impacts": "" if cell.impacts < 0 else f"{cell.impacts} reported by the engine",
        "Read back": differs,
        "Notes": "; ".join(cell.notes),
        "On record": cell.known,
        "Audit": settings_text(cell.audit),
        "Final state": cell.digest,
        "Recorded motion": cell.trace,
        "Printed": cell.output,
    }
    if not cell.digest:
        del facts["Repeats itself"]
    return tuple((name, text) for name, text in facts.items() if text)
