"""What there is: engines, suites, scenarios, ladders, metrics."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from typing import Any

import click


def engines() -> list[dict[str, Any]]:
    """Every engine and whether it can be had."""
    from adapters.registry import listings

    return [
        {"name": row.name, "version": row.version, "state": row.state, "reason": row.reason, "install": row.install}
        for row in listings()
    ]


def suites() -> list[dict[str, Any]]:
    """Every suite and how many scenarios it has."""
    from scenarios import catalogue

    return [{"name": name, "scenarios": len(catalogue.suite(name))} for name in catalogue.suites()]


def scenarios() -> list[dict[str, Any]]:
    """Every family of scenarios."""
    from scenarios import catalogue

    return [
        {"name": f.name, "variants": len(f.variants), "suites": list(f.suites), "tags": list(f.tags),
         "summary": (f.build.__doc__ or "").strip().splitlines()[0]}
        for f in catalogue.families().values()
    ]  # fmt: skip


def ladders() -> list[dict[str, Any]]:
    """Every ladder, with its rungs from easy to hard."""
    from scenarios.ladder import find

    return [
        {"name": one.name, "unit": one.unit, "rungs": list(one.rungs), "raises": one.raises, "family": one.family}
        for one in find()
    ]


def metrics() -> list[dict[str, Any]]:
    """Every quantity the comparisons measure."""
    from comparisons.judge import describe_quantities

    return [
        {"name": q.name, "unit": q.unit, "meaning": q.meaning, "comparison": q.comparison}
        for q in describe_quantities()
    ]


SECTIONS: dict[str, Callable[[], list[dict[str, Any]]]] = {
    "engines": engines,
    "suites": suites,
    "scenarios": scenarios,
    "ladders": ladders,
    "metrics": metrics,
}


def show(what: Sequence[str], json_: bool) -> None:
    """Print the sections named."""
    found = {name: SECTIONS[name]() for name in what}
    if json_:
        click.echo(json.dumps(found if len(found) > 1 else next(iter(found.values())), indent=1))
        return
    for n, (name, rows) in enumerate(found.items()):
        if len(found) > 1:
            click.echo(("\n" if n else "") + name)
        table([_line(name, row) for row in rows], indent="  " if len(found) > 1 else "")


def _line(section: str, row: dict[str, Any]) -> tuple[str, ...]:
    if section == "engines":
        return row["name"], row["version"] or row["state"], row["reason"]
    if section == "suites":
        figures = "; `run published` prints published figures and ours" if row["name"] == "published" else ""
        return row["name"], f"{row['scenarios']} scenarios{figures}"
    if section == "scenarios":
        variants = f"{row['variants']} variants" if row["variants"] > 1 else ""
        return row["name"], ", ".join(row["suites"]), variants, row["summary"]
    if section == "ladders":
        unit = "" if row["unit"] == "1" else f" {row['unit']}"
        return row["name"], f"{row['rungs'][0]:g} to {row['rungs'][-1]:g}{unit}", row["raises"]
    return row["name"], row["unit"], row["meaning"]


def table(rows: Sequence[Sequence[str]], indent: str = "") -> None:
    """Print rows in columns; the last column is as wide as it needs to be."""
    if not rows:
        return
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]) - 1)]
    for row in rows:
        cells = [text.ljust(width) for text, width in zip(row, widths, strict=False)]
        click.echo((indent + "  ".join([*cells, row[-1]])).rstrip())
