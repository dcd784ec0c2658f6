"""The verbs of the gate: `check` runs and compares with a baseline, `baseline` keeps one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING, Any

import click

from plumbline.cli_run import carry_out, planned, run, show_plan
from plumbline.command import as_json, harness, register, usage

if TYPE_CHECKING:
    from comparisons.regression import Baseline
    from plumbline.plan import Job
    from plumbline.results import Results

SUITE = "standard"
OTHERWISE = ("what", "steps", "repeats")  # parameters of `run` that `check` has in another form, or not at all

in_folder = click.option("--folder", default="baselines", show_default=True, metavar="DIR",
                         help="Where baselines live.")  # fmt: skip
of_engines = click.option("-e", "--engine", "engines", multiple=True, metavar="NAME",
                          help="Engine or glob; ! in front leaves out (repeatable).")  # fmt: skip
of_scenarios = click.option("-s", "--scenario", "selectors", multiple=True, metavar="NAME",
                            help="Scenario or glob, as it is printed; ! in front leaves out (repeatable).")  # fmt: skip
of_name = click.option("--name", metavar="NAME", help="Baseline.  [default: what was run, as the run calls it]")


@click.command("check")
@click.argument("what", required=False, metavar="[SUITE|FILE]")
@click.option("--baseline", "name", metavar="NAME", help="Baseline to compare with.  [default: that of the suite]")
@in_folder
@click.option("--strict", is_flag=True, help="What is new, improved or not comparable is a finding, too.")
@click.option("--repeats", type=click.IntRange(1), default=1, show_default=True,
              help="As in `run`; 1 measures no cost.")  # fmt: skip
def check(**asked: Any) -> int:
    """Run, judge, and compare every cell with a baseline: the verb for continuous integration.

    \b
    plumbline check                            the suite standard against its baseline
    plumbline check smoke --baseline standard  a part of it
    plumbline check -e mujoco --junit out.xml --summary "$GITHUB_STEP_SUMMARY"
    """
    from comparisons.regression import FINDINGS, OUTCOMES
    from plumbline.baselines import Store
    from plumbline.results import FAIL_ON

    register(asked["plugins"])
    narrowed = bool(asked["selectors"] or asked["tags"])
    asked |= {"what": asked["what"] or (None if narrowed else SUITE), "steps": ()}
    name = asked["name"] or asked["what"] or SUITE
    with harness(), usage():
        baseline = Store(name, asked["folder"]).baseline()
    jobs = planned(asked)
    if not jobs:
        click.echo("nothing is selected: no scenario has all that is asked for", err=True)
        return 5
    if asked["dry_run"]:
        return show_plan(jobs, asked["json_"])
    if asked["strict"]:
        counted = FAIL_ON if asked["fail_on"] is None else asked["fail_on"]
        asked["fail_on"] = (*counted, *(word for word in OUTCOMES[2:] if word not in FINDINGS))
    whole = asked["what"] == name and not (narrowed or asked["shard"])
    return carry_out(jobs, asked, told={"baseline": within(baseline, jobs, asked, whole).to_plain()})


check.params += [parameter for parameter in run.params if parameter.name not in OTHERWISE]


def within(baseline: Baseline, jobs: Sequence[Job], asked: dict[str, Any], whole: bool) -> Baseline:
    """Those records that the jobs are to answer; what lies outside of the selection is not missed.

    With the `whole` suite also scenarios that are not there any more; where no engine was named, engines likewise.
    """
    from adapters import registry
    from comparisons.regression import identity

    asked_for = {identity(j.scenario.name, j.engine, j.settings) for j in jobs}
    labels, engines = {j.scenario.name for j in jobs}, {j.engine for j in jobs}
    known = set(registry.names())
    kept = [
        r
        for r in baseline.records
        if (r.identity in asked_for if asked["settings"] else whole or r.scenario in labels)
        and (r.engine in engines or not (asked["engines"] or r.engine in known))
    ]
    return replace(baseline, records=tuple(kept))


@click.group("baseline")
def baseline() -> None:
    """Keep baselines: text in version control, one file for each suite, engine and scenario."""


@baseline.command("save")
@click.argument("runs", nargs=-1, required=True, metavar="RUN...")
@of_name
@in_folder
def save(runs: tuple[str, ...], name: str | None, folder: str) -> int:
    """Record the cells of runs that are not recorded yet.

    Rows that are there and say otherwise stay as they are and make the exit code 1: to replace them takes `accept`.
    """
    from plumbline.baselines import Store
    from reports.numbers import count
    from reports.regressions import MARKS, told

    with harness():
        results = _read(runs)
        store = Store(name or results.campaign.title, folder)
        written, differing = store.save(results)
    for change in differing:
        mark = MARKS[change.outcome]
        click.echo(f"{mark.glyph} {mark.word}, kept as it was: {change.scenario} · {change.engine}: {told(change)}")
    click.echo(f"{count(written, 'row')} of platform class {store.platform} recorded in {store.folder}")
    return 1 if differing else 0


@baseline.command("accept")
@click.argument("runs", nargs=-1, required=True, metavar="RUN...")
@of_engines
@of_scenarios
@click.option("--reason", required=True, metavar="TEXT", help="Why this is right; it is kept with every row.")
@of_name
@in_folder
def accept(runs: tuple[str, ...], engines: tuple[str, ...], selectors: tuple[str, ...], reason: str,
           name: str | None, folder: str) -> int:  # fmt: skip
    """Make the named cells of runs the baseline, and nothing else.

    Cells are named with -e and -s, at least one of them; exit code 5 if nothing is named that could be accepted.
    """
    from plumbline.baselines import Store
    from reports.numbers import count

    if not (engines or selectors):
        raise click.UsageError("say with -e and -s which cells are accepted; -s '*' accepts every one")
    if not reason.strip():
        raise click.UsageError("--reason is empty: say why the new answers are right")
    with harness():
        results = _read(runs)
        chosen = [c for c in results.cells if _named(c.engine, engines) and _named(c.scenario, selectors)]
        store = Store(name or results.campaign.title, folder)
        written = store.accept(results, chosen, reason.strip())
    click.echo(f"{count(written, 'row')} of platform class {store.platform} rewritten in {store.folder}")
    return 0 if chosen else 5


@baseline.command("diff")
@click.argument("runs", nargs=-1, required=True, metavar="RUN...")
@of_engines
@of_scenarios
@of_name
@in_folder
@as_json
def diff(runs: tuple[str, ...], engines: tuple[str, ...], selectors: tuple[str, ...], name: str | None,
         folder: str, json_: bool) -> int:  # fmt: skip
    """Compare archived runs with a baseline; exit code 1 if something regressed, moved or is gone.  Runs no engine."""
    import json

    from comparisons.regression import FINDINGS, changes
    from plumbline import finish
    from plumbline.baselines import Store

    with harness(), usage():
        results = _read(runs)
        kept = Store(name or results.campaign.title, folder).baseline()
    chosen = tuple(c for c in results.cells if _named(c.engine, engines) and _named(c.scenario, selectors))
    labels, present = {c.scenario for c in results.cells}, {c.engine for c in results.cells}
    whole = results.campaign.title == kept.name  # otherwise scenarios that the run does not have were not asked for
    records = tuple(
        r
        for r in kept.records
        if r.engine in present
        and (whole or r.scenario in labels)
        and _named(r.engine, engines)
        and _named(r.scenario, selectors)
    )
    campaign = replace(results.campaign, cells=chosen, baseline=replace(kept, records=records).to_plain())
    if json_:
        click.echo(json.dumps(finish.changes_as_json(campaign), indent=1))
    else:
        finish.show_changes(campaign, finish.wide_console(), most=len(chosen) + len(records))
    return int(any(c.outcome in FINDINGS for c in changes(campaign)))


@baseline.command("show")
@click.argument("name", required=False)
@of_engines
@of_scenarios
@in_folder
@as_json
def show(name: str | None, engines: tuple[str, ...], selectors: tuple[str, ...], folder: str, json_: bool) -> None:
    """List baselines, or the rows of one: state, what decides, why it was accepted, on which platform class."""
    import json

    from comparisons.regression import to_plain
    from plumbline.baselines import Store, names
    from plumbline.listing import table

    if name is None:
        found = names(folder)
        click.echo(json.dumps(found) if json_ else "\n".join(found) or f"there is no baseline in {folder}")
        return
    with harness(), usage():
        kept = Store(name, folder).baseline()
    records = [r for r in kept.records if _named(r.engine, engines) and _named(r.scenario, selectors)]
    if json_:
        click.echo(json.dumps([to_plain(r) for r in records], indent=1))
        return
    lines = [("scenario", "engine", "version", "state", "worst", "platform class", "reason")]
    table([*lines, *((r.scenario, r.engine, r.engine_version, r.state, _worst(r), r.platform, r.reason)
                     for r in records)])  # fmt: skip


def _worst(record: Any) -> str:
    from reports.verdict import times_tolerance

    shares = {name: record.values[name] / limits[0] for name, limits in record.demanded.items()
              if name in record.values and limits[0]}  # fmt: skip
    if not shares:
        return ""
    worst = max(shares, key=lambda name: shares[name])
    return f"{worst} {times_tolerance(shares[worst])}"


def _read(runs: Sequence[str]) -> Results:
    from plumbline.results import Results, merged

    return merged([Results.read(path) for path in runs])


def _named(label: str, patterns: Sequence[str]) -> bool:
    """Whether the patterns select `label`; brackets of parameters stand for themselves."""

    def matches(pattern: str) -> bool:
        return label == pattern or fnmatchcase(label, pattern.replace("[", "[[]"))

    wanted = [p for p in patterns if not p.startswith("!")]
    barred = [p.removeprefix("!") for p in patterns if p.startswith("!")]
    return (not wanted or any(map(matches, wanted))) and not any(map(matches, barred))
