"""Accuracy against time on the terminal and for programs."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import click
from rich.console import Console
from rich.table import Table
from rich.text import Text

from comparisons.advice import Advice, Choice, advise
from comparisons.cell import Campaign
from comparisons.frontier import TARGETS, Frontier, Point, frontiers
from plumbline.finish import wide_console
from reports.frontier import (
    ADVISED,
    BADGE,
    BUDGETS,
    Accuracy,
    Section,
    accuracy,
    advice_text,
    duel_text,
    share_text,
    target_text,
)
from reports.numbers import short
from reports.terminal import STYLES


def show(campaign: Campaign, console: Console | None = None) -> None:
    """Print time to reach each error for every scenario, and over several the shares and the duels."""
    console, told = console or wide_console(), accuracy(campaign)
    for section in told.sections:
        console.print(_reached(section))
        for engine, reason in section.absent:
            console.print(Text(f"{engine}: {reason}", style="dim"))
        console.print()
    if len(told.sections) > 1:
        console.print(_shares(told))
        console.print()
        console.print(_duels(told, ADVISED))
        console.print()
    for words, names in (("do not ask where bodies are", told.without), ("not measured", told.unmeasured)):
        if names:
            console.print(Text(f"{words}: {', '.join(names)}", style="dim"))
    console.print(Text(f"CPU ms per simulated second to a relative place error; {BADGE} disturbed timing", style="dim"))


def _reached(section: Section) -> Table:
    table = _table(section.scenario, *(target_text(t) for t in TARGETS), "order", "alarms")
    for row in section.rows:
        entries = [Text(f"{e.glyph} {e.text}", style=STYLES[e.tone]) for e in row.entries]
        alarms = "; ".join(filter(None, (row.alarm, row.failures)))
        table.add_row(Text(row.engine), *entries, Text(row.order), Text(alarms))
    return table


def _shares(told: Accuracy) -> Table:
    table = _table("share reached within", *(f"{short(b)} ms/s" for b in BUDGETS), "refused", "not run")
    for one in told.shares:
        table.add_row(
            Text(one.engine),
            *(Text(share_text(one, b)) for b in BUDGETS),
            Text(str(one.refused)),
            Text(str(one.unfinished)),
        )
    return table


def _duels(told: Accuracy, target: float) -> Table:
    table = _table(f"to {target_text(target)}: row won–drawn–lost against", *told.engines)
    for a in told.engines:
        row = ["·" if a == b else duel_text(told.duels[target][a, b]) for b in told.engines]
        table.add_row(Text(a), *map(Text, row))
    return table


def _table(*columns: str) -> Table:
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="bold")
    for column in columns:
        table.add_column(Text(column))
    return table


def advice(campaign: Campaign, scenario: str, error: float, engines: Sequence[str] = ()) -> Advice:
    """Advice from what a sweep measured; on `engines` only, if there are any.

    Raises
    ------
    ValueError
        If nothing was measured on the scenario.
    """
    found = frontiers(campaign)
    return advise([f for f in found if not engines or f.engine in engines], scenario, error)


def show_advice(given: Advice, json_: bool) -> None:
    """Print advice in sentences, or for programs."""
    if json_:
        click.echo(json.dumps(_advice_json(given), indent=1))
        return
    for line in advice_text(given):
        click.echo(line)


def as_json(campaign: Campaign) -> dict[str, Any]:
    """Frontiers, shares and duels for programs; null where something is not reached or not known."""
    told = accuracy(campaign)
    return {
        "targets": list(TARGETS),
        "frontiers": [_frontier_json(f) for section in told.sections for f in section.found],
        "shares": [{**asdict(one), "costs": list(one.costs)} for one in told.shares],
        "duels": [
            {"target": target, "engine": a, "against": b, "won": d.wins, "drawn": d.draws, "lost": d.losses,
             "neither": d.neither, "common": d.common}
            for target, pairs in told.duels.items() for (a, b), d in pairs.items()
        ],
    }  # fmt: skip


def _frontier_json(found: Frontier) -> dict[str, Any]:
    reached = {t: found.reach(t)[0] for t in TARGETS}
    order = found.main.order
    return {
        "scenario": found.scenario,
        "engine": found.engine,
        "absent": " ".join(found.absent).strip(),
        "unrun": found.unrun,
        "reach": [{"target": t, "cost": _known(r.cost), "how": r.how} for t, r in reached.items()],
        "order": _known(order.slope) if order else None,
        "points": [_point_json(p) for p in found.points],
    }


def _point_json(point: Point) -> dict[str, Any]:
    cell = point.cell
    return {
        "settings": dict(cell.settings),
        "state": cell.state,
        "error": _known(point.error),
        "phases": [_known(v) for v in point.spread],
        "cost": _known(point.cost),
        "contention": _known(cell.contention),
        "digest": cell.digest,
    }


def _advice_json(given: Advice) -> dict[str, Any]:
    def chosen(choice: Choice) -> dict[str, Any]:
        default = _point_json(choice.default) if choice.default else None
        return {"engine": choice.engine, **_point_json(choice.point), "passes": choice.passes, "default": default}

    return {
        "scenario": given.scenario,
        "error": given.error,
        "choices": [chosen(choice) for choice in given.choices],
        "short": [{"engine": e, "best": _point_json(p) if p else None} for e, p in given.short],
        "absent": [{"engine": e, "state": state, "reason": reason} for e, state, reason in given.absent],
    }


def _known(value: float) -> float | None:
    return value if math.isfinite(value) else None
