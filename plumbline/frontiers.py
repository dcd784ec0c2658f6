"""Frontiers of ladders, for the terminal and for programs."""

from __future__ import annotations

from typing import Any

from comparisons.cell import Campaign
from plumbline.listing import table
from reports.ladders import climbs
from reports.numbers import with_unit


def rows(campaign: Campaign) -> list[dict[str, Any]]:
    """One row for each ladder and engine: last good rung, first bad rung, how and why it broke."""
    return [
        {"ladder": c.ladder, "engine": c.engine, "unit": c.unit, "last good": c.frontier.good,
         "first bad": c.frontier.bad, "broke": c.frontier.word, "silent": c.frontier.silent,
         "holds again at": list(c.frontier.again), "why": c.why}
        for c in climbs(campaign)
    ]  # fmt: skip


def show(told: list[dict[str, Any]]) -> None:
    """Print the frontiers, ladder by ladder."""

    def said(row: dict[str, Any], name: str) -> str:
        return "–" if row[name] is None else with_unit(row[name], row["unit"])

    lines = [("ladder", "engine", "holds to", "breaks at", "how", "why")]
    for row in told:
        why = row["why"] if len(row["why"]) < 100 else row["why"][:99] + "…"
        lines.append((row["ladder"], row["engine"], said(row, "last good"), said(row, "first bad"), row["broke"], why))
    table(lines)
