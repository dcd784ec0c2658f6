"""Accuracy against time as figures: one panel for each scenario, and the share that is reached within a cost."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import Any

from comparisons.cell import Campaign
from comparisons.frontier import Curve, Frontier, Point
from comparisons.order import ROUNDING
from reports.figures import Axis, Figure, Series
from reports.frontier import Accuracy, Section, disturbed, told_settings
from reports.numbers import short
from reports.verdict import description, mark

REAL_TIME = 1e3  # CPU milliseconds in a second
PLACE = ("position error", "final position error", "drift")  # checks in metres that a place error compares with


def panels(told: Accuracy, campaign: Campaign) -> list[tuple[str, Figure]]:
    """(scenario, figure) for every scenario with a point: relative place error over cost, all on the same axes.

    Errors below `comparisons.order.ROUNDING` say nothing and are drawn there.

    Curves are joined in the order of their ladder.  Settings that broke stand on the rail at the upper edge, at
    the cost of their neighbour in the ladder.  Bands reach down to the best phase of a step.
    """
    costs = [math.log10(p.cost) for s in told.sections for f in s.found for p in f.points if p.whole]
    if not costs:
        return []
    limits = (10.0 ** math.floor(min(costs) - 0.05), 10.0 ** math.ceil(max(costs) + 0.05))
    x = Axis("CPU ms per simulated second", log=True, better="← cheaper", limits=limits)
    errors = [p.error for s in told.sections for f in s.found for p in f.points if p.whole]
    top = 10.0 ** math.ceil(math.log10(max(max(errors), ROUNDING)) + 0.05)
    y = Axis("relative place error, 10⁻¹² for less", log=True, better="↓ better", limits=(ROUNDING, top))
    drawn = []
    for section in told.sections:
        series = tuple(one for f in section.found for one in _series(f))
        if series:
            guide, floor = _guides(section, description(campaign, section.scenario))
            marks = (("x", REAL_TIME, "real time"), *floor)
            figure = Figure(section.scenario, x, y, series, guide, marks, front=True, summary=_summary(section))
            drawn.append((section.scenario, figure))
    return drawn


def _series(found: Frontier) -> Iterator[Series]:
    """Series of one engine: lines of ladders, breaks on the rail, single settings; the first only is named."""
    named = False
    for curve in found.curves:
        costs = _costs(curve)
        line = [(x, p) for x, p in zip(costs, curve.points, strict=True) if math.isfinite(x) and p.whole]
        rail = [(x, p) for x, p in zip(costs, curve.points, strict=True) if math.isfinite(x) and p.broke]
        for shown, joined in ((line, bool(curve.knob)), (rail, False)):
            if shown:
                points = [p for _, p in shown]
                yield Series(
                    found.engine,
                    [x for x, _ in shown],
                    [p.error if p.whole else math.inf for p in points],
                    joined=joined,
                    tips=[_tip(p) for p in points],
                    label=None if named else "",
                    low=[p.spread[0] for p in points] if any(p.spread[0] < p.error for p in points) else (),
                )
                named = True


def _costs(curve: Curve) -> list[float]:
    """Cost of every rung; of one that broke, and so has none, that of its nearest coarser neighbour, else the next."""
    costs = [p.cost if p.whole else math.nan for p in curve.points]
    known = [c for c in costs if math.isfinite(c)]
    found, last = [], known[0] if known else math.nan
    for cost in costs:
        last = cost if math.isfinite(cost) else last
        found.append(last)
    return found


def _tip(point: Point) -> str:
    head = f"{point.cell.engine} ({told_settings(point.cell.settings)}): {mark(point.cell).word}"
    if not point.whole:
        return f"{head}, {point.cell.reason}"
    low, middle, high = (short(v, 2) for v in point.spread)
    error = f"error {high}" if low == high else f"error {low} · {middle} · {high} over the phases of a step"
    noise = f", contention {short(100 * point.cell.contention, 2)} %" if disturbed(point) else ""
    repeats = "" if point.cell.deterministic else ", does not repeat itself"
    return f"{head}, {error}, {short(point.cost)} ms/s{noise}{repeats}"


def _guides(section: Section, told: Mapping[str, Any]) -> tuple[tuple[float, str] | None, tuple]:
    """Tolerance of the scenario as a relative place error, and the bound below which a computation errs by rounding.

    Both only where the scenario demands something in metres of where bodies are.
    """
    check = next((c for c in told["checks"] if c["quantity"] in PLACE), None)
    scale = next((s for f in section.found for p in f.points if (s := _scale(p))), 0.0)
    if check is None or not scale:
        return None, ()
    return (check["tolerance"] / scale, "tolerance"), (("y", check["exact"] / scale, "rounding"),)


def _scale(point: Point) -> float:
    """Length by which errors of the scenario are measured, from the two forms of an error [m]; 0 if unknown."""
    absolute, relative = point.cell.of("place error"), point.cell.of("relative place error")
    if absolute is None or relative is None or not relative.value > 0.0:
        return 0.0
    return absolute.value / relative.value


def _summary(section: Section) -> str:
    parts = []
    for found in section.found:
        best = found.best
        told = (
            f"best error {short(best.error, 2)} at {short(best.cost, 2)} ms/s" if best else found.absent[0] or "broke"
        )
        parts.append(f"{found.engine}: {told}")
    return f"{section.scenario}: {'; '.join(parts)}"


def shares(told: Accuracy) -> Figure | None:
    """Share of the (scenario, target) pairs that each engine reaches within a cost, as stairs; None if nobody does."""
    reached = [c for one in told.shares for c in one.costs]
    if not reached:
        return None
    least, most = 10.0 ** math.floor(math.log10(min(reached))), 10.0 ** math.ceil(math.log10(max(reached)) + 0.05)
    x = Axis("CPU ms per simulated second", log=True, better="← cheaper", limits=(least, most))
    y = Axis("share of its (scenario, target) pairs", better="↑ better", limits=(0.0, 1.0))
    series = []
    for one in told.shares:
        if one.asked:
            steps = [(least, one.within(least)), *((c, one.within(c)) for c in one.costs), (most, one.within(most))]
            corners = [p for (_, low), (c, high) in pairwise(steps) for p in ((c, low), (c, high))]
            corners = [steps[0], *corners]
            series.append(Series(one.engine, *map(list, zip(*corners, strict=True)), joined=True, marked=False))
    spoken = "; ".join(f"{one.engine}: {len(one.costs)} of {one.asked}" for one in told.shares)
    return Figure(
        "Share reached within a cost", x, y, tuple(series), marks=(("x", REAL_TIME, "real time"),), summary=spoken
    )
