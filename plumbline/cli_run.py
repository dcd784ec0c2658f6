"""The verb `run`: choose, plan, run, show, report."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import click

from plumbline.command import as_json, execute, harness, plug_in, register, usage

if TYPE_CHECKING:
    from comparisons.published import Figure
    from plumbline.plan import Job
    from scenarios.scenario import Scenario

DEFAULT_SUITE = "smoke"
REPEATS = 3


def seconds(_: click.Context, parameter: click.Parameter, text: str | None) -> float | None:
    """A time as people write it: 30, 30s, 5m, 1.5h."""
    if text is None:
        return None
    factor = {"s": 1.0, "m": 60.0, "h": 3600.0}.get(text[-1:], 0.0)
    try:
        value = float(text[:-1]) * factor if factor else float(text)
    except ValueError:
        value = 0.0
    if not 0.0 < value < float("inf"):
        raise click.BadParameter(f"{text!r} is not a time: a number > 0 of seconds, or with s, m or h", param=parameter)
    return value


def shard(_: click.Context, parameter: click.Parameter, text: str | None) -> tuple[int, int] | None:
    """Which part of how many: 2/4."""
    if text is None:
        return None
    part, _slash, parts = text.partition("/")
    if not (part.isdecimal() and parts.isdecimal() and 1 <= int(part) <= int(parts)):
        raise click.BadParameter(f"{text!r} is no part of a whole: I/N with 1 <= I <= N", param=parameter)
    return int(part), int(parts)


def states(_: click.Context, parameter: click.Parameter, text: str | None) -> tuple[str, ...] | None:
    """Cell states and outcomes, separated by commas; "harness" (or "none"): only faults of the harness itself."""
    if text is None or text in ("none", "harness"):
        return None if text is None else ()
    from comparisons.cell import STATES
    from comparisons.regression import OUTCOMES

    chosen = tuple(word.strip() for word in text.split(","))
    for word in chosen:
        if word not in (*STATES, *OUTCOMES):
            known = ", ".join((*STATES, *OUTCOMES))
            raise click.BadParameter(f"there is no state {word!r}; there are: harness, {known}", param=parameter)
    return chosen


@click.command("run")
@click.argument("what", required=False, metavar="[SUITE|FILE]")
@click.option(
    "-e",
    "--engine",
    "engines",
    multiple=True,
    metavar="NAME",
    help="Engine or glob; ! in front leaves out (repeatable). Default: all.",
)
@click.option(
    "-s",
    "--scenario",
    "selectors",
    multiple=True,
    metavar="NAME",
    help="Scenario, glob or name[param=value]; ! in front leaves out (repeatable).",
)
@click.option(
    "-t", "--tag", "tags", multiple=True, metavar="TAG", help="Scenarios with this tag; ! leaves out (repeatable)."
)
@click.option(
    "--set",
    "settings",
    multiple=True,
    metavar="KNOB=VALUE",
    help="Knob of the engines, or engine.knob=value; repeat a knob to run each value.",
)
@click.option("--duration", callback=seconds, help="Of a scene file.  [default: 2s]")
@click.option(
    "--sampling", callback=seconds, help="Interval of recorded states of a scene file.  [default: duration/100]"
)
@click.option(
    "-j",
    "--jobs",
    type=click.IntRange(1),
    default=2,
    show_default=True,
    help="Engines at the same time; with repeats, scenes.",
)
@click.option(
    "--repeats",
    type=click.IntRange(1),
    help="Timed repeats of each cell, after a warm-up; 1 measures no cost and takes a quarter of the time."
    "  [default: 3; published figures: 1]",
)
@click.option(
    "--phases",
    type=click.IntRange(1),
    help="Phases of a step at which impacts are tried; the worst is judged, least, median and largest are told."
    "  [default: 1; museum: 8]",
)
@click.option(
    "--timeout",
    callback=seconds,
    help="Of one run of a cell; then its engine is killed.  [default: 2m; published figures: 20m]",
)
@click.option("--budget", callback=seconds, help="Of the run; what has not begun by then is not run.")
@click.option(
    "--memory",
    type=click.FloatRange(0.0),
    default=8.0,
    show_default=True,
    help="GiB of address space for each engine; 0 = no limit.",
)
@click.option(
    "--out", metavar="DIR", help="Folder of the run; finished cells in it are kept.  [default: a new one in runs/]"
)
@click.option("--rerun", type=click.Choice(["failed", "all"]), help="Run failed cells, or all, again.")
@click.option(
    "--shard", callback=shard, metavar="I/N", help="Part I of N of the scenarios; `plumbline merge` joins them."
)
@click.option("--dry-run", is_flag=True, help="Show what would be run.")
@click.option(
    "--dt",
    "steps",
    type=click.FloatRange(0.0, min_open=True),
    multiple=True,
    metavar="SECONDS",
    help="Step size of the published figures (repeatable).",
)
@click.option("--junit", metavar="PATH", help="Write JUnit XML here, too.")
@click.option("--summary", metavar="PATH", help="Append the Markdown summary to this file.")
@click.option("--progress", "style", type=click.Choice(["auto", "plain", "off"]), default="auto", show_default=True)
@click.option(
    "--fail-on",
    callback=states,
    metavar="STATES",
    help="States that make the exit code 1 or 3, separated by commas; harness: only faults of the harness.",
)
@plug_in
@as_json
def run(**asked: Any) -> int:
    """Run scenarios in engines, judge every answer and write the report.

    \b
    plumbline run                              the suite smoke, in every installed engine
    plumbline run standard -e 'pybullet*'      a suite in some engines
    plumbline run -s 'bouncing-ball[e=0.5]' --set dt=1e-3 --set dt=1e-4
    plumbline run my_scene.toml --duration 5s  a scene of yours
    plumbline run published --dt 0.002         published figures, ours beside them
    """  # fmt: skip
    register(asked["plugins"])
    if asked["what"] == "published":
        with usage():
            figures, jobs = planned_figures(asked)
    elif asked["steps"]:
        raise click.UsageError("--dt is for `plumbline run published`; for engines use --set dt=VALUE")
    else:
        figures, jobs = None, planned(asked)
    if not jobs:
        click.echo("nothing is selected: no scenario has all that is asked for", err=True)
        return 5
    if asked["dry_run"]:
        return show_plan(jobs, asked["json_"])
    return carry_out(jobs, asked, figures)


def planned(asked: dict[str, Any]) -> tuple[Job, ...]:
    """Jobs of what the command line asks for."""
    with usage():
        from adapters import registry
        from plumbline import own_files
        from plumbline.plan import choose, plan, read_settings

        what, own = asked["what"], ""
        if what is None and not asked["selectors"] and not asked["tags"]:
            what = DEFAULT_SUITE
        if what is not None and own_files.is_file(what):
            own = own_file_words(asked)
        elif asked["duration"] or asked["sampling"]:
            raise ValueError("--duration and --sampling are for scenes in TOML; a scenario says its own")
        scenarios = choose(what, asked["selectors"], asked["tags"], asked["duration"], asked["sampling"])
        if asked["shard"]:  # every n-th: variants of one family, which cost alike, go to different parts
            scenarios = scenarios[asked["shard"][0] - 1 :: asked["shard"][1]]
        engines, baselines = registry.select(asked["engines"]), registry.baselines(asked["engines"])
        return plan(scenarios, engines, read_settings(asked["settings"]), own, baselines)


def planned_figures(asked: dict[str, Any]) -> tuple[tuple[Figure, ...], tuple[Job, ...]]:
    """Published figures that are asked for, and the jobs that answer them."""
    from plumbline import published

    for name in ("settings", "tags", "duration", "sampling", "shard"):
        if asked[name]:
            raise ValueError("published figures have settings of their own; choose with -e, -s and --dt")
    figures = published.chosen(asked["steps"], asked["engines"], asked["selectors"])
    return figures, tuple({job.key: job for job in published.jobs(figures)}.values())


def own_file_words(asked: dict[str, Any]) -> str:
    """The part of the command line that brings a user's file."""
    words = [asked["what"]]
    for name in ("duration", "sampling"):
        words += [f"--{name}", f"{asked[name]!r}"] if asked[name] else []
    return shlex.join(words)


def carry_out(
    jobs: tuple[Job, ...],
    asked: dict[str, Any],
    figures: tuple[Figure, ...] | None = None,
    told: Mapping[str, Any] | None = None,
) -> int:
    """Run the jobs with a progress display, then show and write the report; `told` goes into `run.json`."""
    from dataclasses import replace

    from plumbline import finish
    from plumbline.campaign import TIMEOUT, Options

    scenarios = tuple({job.scenario.name: job.scenario for job in jobs}.values())
    say_overlaps(scenarios)
    timeout = asked["timeout"] or (TIMEOUT if figures is None else 10 * TIMEOUT)
    repeats = asked["repeats"] or (REPEATS if figures is None else 1)
    options = Options(asked["jobs"], repeats, timeout, asked["budget"],
                      round(asked["memory"] * 2**30), asked["rerun"] or "none",
                      asked["phases"] or (8 if asked["what"] == "museum" else 1))  # fmt: skip
    outputs = finish.Outputs(asked["junit"], asked["summary"])
    with harness():
        outputs.open()
    results = replace(execute(jobs, title(asked), options, asked, told=told or {}), known=scenarios)
    with harness():
        return finish.finish(results, outputs, asked["json_"], asked["fail_on"], figures)


def say_overlaps(scenarios: tuple[Scenario, ...]) -> None:
    """Warn of bodies that overlap at the start."""
    from plumbline.api import overlap_notes

    for scenario in scenarios:
        for note in overlap_notes(scenario.scene):
            click.echo(f"note: {scenario.name}: {note}", err=True)


def title(asked: dict[str, Any]) -> str:
    """The run in a few words."""
    words = [asked["what"] or "", *asked["selectors"], *(f"tag {tag}" for tag in asked["tags"])]
    return ", ".join(filter(None, words)) or DEFAULT_SUITE


def show_plan(jobs: tuple[Job, ...], json_: bool) -> int:
    """Print the cells that would be run."""
    import json

    from reports.numbers import count, settings_text

    if json_:
        rows = [{"key": j.key, "scenario": j.scenario.name, "engine": j.engine, "version": j.version,
                 "settings": dict(j.settings), "absent": j.absent.reason if j.absent else ""}
                for j in jobs]  # fmt: skip
        click.echo(json.dumps(rows, indent=1))
        return 0
    for job in jobs:
        said = job.absent.reason if job.absent else settings_text(job.settings)
        click.echo(f"{job.scenario.name:<40} {job.engine:<22} {said}".rstrip())
    simulated = sum(j.scenario.duration for j in jobs if not j.absent)
    click.echo(f"{count(len(jobs), 'cell')}, {simulated:.0f} s of simulated time")
    return 0
