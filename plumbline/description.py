"""All about one thing: a scenario, an engine, a suite or a metric."""

from __future__ import annotations

import json
from typing import Any

import click

from adapters import registry
from adapters.engine import Engine, defaults, profile
from comparisons.conserved import conserved
from comparisons.judge import describe_quantities
from plumbline.listing import table
from reports.numbers import settings_text, short, with_unit
from scenarios import catalogue
from scenarios.scenario import Scenario


def show(name: str, json_: bool) -> None:
    """Describe what goes by `name`.

    Raises
    ------
    UnknownName
        If nothing does.
    Unavailable
        For an engine that is not installed.
    """
    family = name.partition("[")[0]
    if family in catalogue.families():
        scenario = catalogue.find(name)[0]
        _print(about_scenario(scenario), json_, scenario_lines)
    elif name in registry.names():
        _print(about_engine(registry.engine(name)), json_, engine_lines)
    elif name in catalogue.suites():
        _print(about_suite(name), json_, suite_lines)
    elif name in {q.name for q in describe_quantities()}:
        _print(about_metric(name), json_, metric_lines)
    else:
        known = [
            *catalogue.families(),
            *registry.names(),
            *catalogue.suites(),
            *(q.name for q in describe_quantities()),
        ]
        raise catalogue.unknown("scenario, engine, suite or metric", name, known)


def _print(told: dict[str, Any], json_: bool, lines: Any) -> None:
    if json_:
        click.echo(json.dumps(told, indent=1, default=str))
    else:
        lines(told)


def about_scenario(scenario: Scenario) -> dict[str, Any]:
    """Everything a scenario says."""
    family = catalogue.families()[scenario.family]
    return {
        "name": scenario.name,
        "summary": scenario.summary,
        "version": scenario.version,
        "suites": list(scenario.suites),
        "tags": list(scenario.tags),
        "parameters": {
            n: {"value": v, "range": list(family.ranges.get(n, ()))} for n, v in scenario.parameters.items()
        },
        "variants": [s.name for s in family.all()],
        "duration": scenario.duration,
        "sampling": scenario.sampling,
        "bodies": [
            {"name": b.name, "shape": repr(b.shape), "mass": b.mass, "position": b.position}
            for b in scenario.scene.bodies
        ],
        "effects": [repr(e) for e in scenario.scene.effects],
        "because": {kind.__name__: why for kind, why in scenario.because.items() if kind in scenario.scene.needs},
        "conserves": list(conserved(scenario.scene, scenario.duration).sentences()),
        "truth": "known" if scenario.truth else "not known",
        "laws": list(scenario.laws),
        "source": scenario.source,
        "checks": [vars(c) | {"unit": _unit(c.quantity)} for c in scenario.checks],
    }


def scenario_lines(told: dict[str, Any]) -> None:
    """Print a scenario."""
    click.echo(f"{told['name']} (version {told['version']}; suites: {', '.join(told['suites']) or 'none'})\n")
    click.echo(f"{told['summary']}\n")
    click.echo(f"{short(told['duration'])} s, recorded every {short(told['sampling'])} s; truth {told['truth']}")
    click.echo(f"source: {told['source']}")
    if told["parameters"]:
        click.echo("\nparameters")
        rows = [(n, str(p["value"]), _range(p["range"])) for n, p in told["parameters"].items()]
        table(rows, "  ")
        click.echo(f"  variants of the suites: {', '.join(told['variants'])}")
    bodies = told["bodies"]
    click.echo("\nbodies")
    table(
        [(b["name"], "fixed" if b["mass"] is None else f"{b['mass']:g} kg", _cut(b["shape"])) for b in bodies[:12]],
        "  ",
    )
    if len(bodies) > 12:
        click.echo(f"  and {len(bodies) - 12} more")
    for heading, lines in (("effects", [_cut(e) for e in told["effects"]]), ("conserves", told["conserves"])):
        click.echo(f"\n{heading}")
        for line in lines or ["none"]:
            click.echo(f"  {line}")
    if told["because"]:
        click.echo("\ndeclared although the true motion may be the same without")
        table(list(told["because"].items()), "  ")
    if told["laws"]:
        click.echo(f"\nmechanics leaves the answer to the impact law; named, not marked: {', '.join(told['laws'])}")
    click.echo("\ntolerances, the same for every engine")
    for check in told["checks"]:
        click.echo(f"  {check['quantity']} ≤ {with_unit(check['tolerance'], check['unit'])}: {check['why']}")
    if not told["checks"]:
        click.echo("  none: everything is measured, nothing demanded")


def about_engine(engine: Engine) -> dict[str, Any]:
    """Everything an engine says of itself."""
    return {
        "name": engine.name,
        "version": str(engine.version),
        "effects": sorted(kind.__name__ for kind in engine.effects),
        "knobs": {name: list(ladder) for name, ladder in engine.knobs.items()},
        "defaults": defaults(engine),
        "profile": dict(profile(engine)),
        "reports": [n for n in ("events", "contacts", "audit") if hasattr(engine, n)],
        "source": registry.source_of(engine.name).target,
    }


def engine_lines(told: dict[str, Any]) -> None:
    """Print an engine."""
    click.echo(f"{told['name']} {told['version']} ({told['source']})\n")
    click.echo(f"effects   {', '.join(told['effects']) or 'none'}")
    click.echo(f"reports   {', '.join(told['reports']) or 'motion only'}")
    click.echo(f"defaults  {settings_text(told['defaults']) or 'no knobs'}")
    click.echo("\nknobs, coarse to fine")
    table([(name, ", ".join(f"{v:g}" if isinstance(v, (int, float)) else v for v in ladder))
           for name, ladder in told["knobs"].items()], "  ")  # fmt: skip
    click.echo("\nsettings that depart from the engine's own defaults, and why")
    for name, why in told["profile"].items():
        click.echo(f"  {name}: {why}")
    if not told["profile"]:
        click.echo("  none")


def about_suite(name: str) -> dict[str, Any]:
    """Scenarios of a suite."""
    return {"name": name, "scenarios": [s.name for s in catalogue.suite(name)]}


def suite_lines(told: dict[str, Any]) -> None:
    """Print a suite."""
    click.echo(f"suite {told['name']}, {len(told['scenarios'])} scenarios")
    for scenario in told["scenarios"]:
        click.echo(f"  {scenario}")


def about_metric(name: str) -> dict[str, Any]:
    """Definition of a quantity and who demands it."""
    quantity = next(q for q in describe_quantities() if q.name == name)
    demanded = [
        f"{f.name}: ≤ {with_unit(c.tolerance, quantity.unit)}, {c.why}"
        for f in catalogue.families().values()
        for c in f.all()[0].checks
        if c.quantity == name
    ]
    return {**quantity._asdict(), "demanded": demanded}


def metric_lines(told: dict[str, Any]) -> None:
    """Print a metric."""
    click.echo(f"{told['name']} [{told['unit']}]: {told['meaning']} (comparisons/{told['comparison']}.py)")
    for line in told["demanded"] or ["no scenario demands it; it is measured and shown"]:
        click.echo(f"  {line}")


def _unit(quantity: str) -> str:
    return next((q.unit for q in describe_quantities() if q.name == quantity), "")


def _range(allowed: list[Any]) -> str:
    if not allowed:
        return ""
    return "one of " + ", ".join(allowed) if isinstance(allowed[0], str) else f"{allowed[0]:g} to {allowed[-1]:g}"


def _cut(text: str, width: int = 120) -> str:
    return text if len(text) <= width else text[: width - 1] + "…"
