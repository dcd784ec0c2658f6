"""Accuracy against cost: one figure per scenario, all on the same axes of cost."""

from __future__ import annotations

import math

from comparisons.cell import Campaign, Cell
from reports.figures import Axis, Figure, Series
from reports.numbers import settings_text, short
from reports.verdict import engines, mark, ratio, ratio_text, scenarios


def cost_figures(campaign: Campaign) -> list[Figure]:
    """Worst error / tolerance over CPU milliseconds per simulated second, for every scenario with a cost.

    Several settings of an engine are joined in the order in which they were run.  All figures share the axis of
    cost, so that panels compare.
    """
    points = [c for c in campaign.cells if has_point(c)]
    if not points:
        return []
    logs = [math.log10(1e3 * c.cost) for c in points]
    limits = (10.0 ** math.floor(min(logs) - 0.05), 10.0 ** math.ceil(max(logs) + 0.05))
    x = Axis("CPU ms per simulated second", log=True, better="← cheaper", limits=limits)
    figures = []
    for scenario in scenarios(campaign):
        cells = [c for c in points if c.scenario == scenario]
        if cells:
            figures.append(_figure(scenario, cells, x, engines(campaign)))
    return figures


def has_point(cell: Cell) -> bool:
    """Whether the cell has both an error and a cost: one is never shown without the other."""
    return math.isfinite(cell.cost) and cell.cost > 0.0 and cell.worst is not None


def _figure(scenario: str, cells: list[Cell], x: Axis, order: list[str]) -> Figure:
    series = []
    for engine in order:
        own = [c for c in cells if c.engine == engine]
        if own:
            cost, error = [1e3 * c.cost for c in own], [ratio(c.worst) for c in own]
            series.append(Series(engine, cost, error, joined=len(own) > 1, tips=[_tip(c) for c in own]))
    y = Axis("worst error / tolerance", log=True, better="↓ better")
    summary = "; ".join(_tip(c) for c in cells)
    return Figure(scenario, x, y, tuple(series), guide=(1.0, "tolerance"), front=True, summary=f"{scenario}: {summary}")


def _tip(cell: Cell) -> str:
    settings = f" ({settings_text(cell.settings)})" if cell.settings else ""
    return f"{cell.engine}{settings}: {mark(cell).word}, {ratio_text(cell)}, {short(1e3 * cell.cost)} ms/s"
