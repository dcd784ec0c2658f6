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
from reports.verdict import Mark, anchor, mark, ratio, ratio_text, scenarios, sentence


@dataclass(frozen=True)
class CellView:
    """One entry among all cells.

    Attributes
    ----------
    cell, anchor, mark, ratio, settings, cost
    why : str
        The verdict in words.
    demanded : tuple of (quantity, value, tolerance, ratio, when it was worst, verdict)
    other : tuple of (quantity, value)
        What was measured besides.
    facts : tuple of (name, text)
        How it was run.
    place : int
        Place of its scenario among the scenarios, from 1.
    replay : str
        Fragment that leads to its moment in the replay, or "".
    """

    cell: Cell
    anchor: str
    mark: Mark
    ratio: str
    why: str
    settings: str
    cost: str
    demanded: tuple[tuple[str, ...], ...]
    other: tuple[tuple[str, str], ...]
    facts: tuple[tuple[str, str], ...]
    place: int
    replay: str


def shown(content: Content) -> Mapping[str, Any]:
    """What the section shows: the entries, and every verdict that occurs among them."""
    states = list(dict.fromkeys(mark(c).word for c in content.campaign.cells))
    return {"cells": _cells(content), "states": states}


def _cells(content: Content) -> list[CellView]:
    campaign = content.campaign
    replays = {r.scenario: r for r in content.motion.replays}
    places = {name: k for k, name in enumerate(scenarios(campaign), 1)}
    views = []
    for cell, fragment in zip(campaign.cells, anchor(campaign).values(), strict=True):
        replay = replays.get(cell.scenario)
        views.append(
            CellView(
                cell,
                fragment,
                mark(cell),
                ratio_text(cell),
                sentence(cell),
                settings_text(cell.settings),
                f"{short(1e3 * cell.cost)} ms/s" if has_point(cell) else "",
                tuple(_demanded(m) for m in cell.measurements if not math.isnan(m.tolerance)),
                tuple((m.quantity, _value(m)) for m in cell.measurements if math.isnan(m.tolerance)),
                _details(cell, incomparable(campaign, cell)),
                places[cell.scenario],
                replay.link(cell.key) if replay else "",
            )
        )
    return views


def _demanded(m: Measurement) -> tuple[str, ...]:
    when = "" if math.isnan(m.time) else f"{short(m.time, 4)} s"
    return m.quantity, _value(m), with_unit(m.tolerance, m.unit), short(ratio(m)), when, m.verdict


def _value(m: Measurement) -> str:
    if math.isnan(m.value):
        return m.text or "not measured"
    return with_unit(m.value, m.unit, 6) + (f" ({m.text})" if m.text else "")


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
        "Version": cell.engine_version,
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
