"""The verbs `sweep` and `advise`: what accuracy costs in time, and which setting to take."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import click

from plumbline.cli_run import seconds
from plumbline.command import as_json, execute, harness, plug_in, register, usage

if TYPE_CHECKING:
    from plumbline.plan import Job
    from plumbline.results import Results

DEFAULT_SUITE = "smoke"
REPEATS = 3
PHASES = 8
PATIENCE = 10.0  # times as long as its deadline may a run take on a machine that is busy

engine_option = click.option(
    "-e", "--engine", "engines", multiple=True, metavar="NAME",
    help="Engine or glob; ! in front leaves out (repeatable). Default: all.",
)  # fmt: skip
knobs_option = click.option(
    "--knobs", type=click.Choice(["main", "all"]), default="main", show_default=True,
    help="main: the ladder of the time step (of the tolerance, for the reference); all: of every knob, and every "
    "integrator, method and solver, too.",
)  # fmt: skip
timeout_option = click.option(
    "--timeout",
    callback=seconds,
    help="Of one run of a setting, in CPU time; then its engine is killed.  [default: 1m]",
)
budget_option = click.option(
    "--budget", callback=seconds, help="Of the whole sweep; what has not begun by then is not run."
)
progress_option = click.option(
    "--progress", "style", type=click.Choice(["auto", "plain", "off"]), default="auto", show_default=True
)


@click.command("sweep")
@click.argument("what", required=False, metavar="[SUITE|SCENARIO|FILE]")
@engine_option
@click.option("-s", "--scenario", "selectors", multiple=True, metavar="NAME",
              help="Scenario, glob or name[param=value]; ! in front leaves out (repeatable).")  # fmt: skip
@click.option(
    "-t", "--tag", "tags", multiple=True, metavar="TAG", help="Scenarios with this tag; ! leaves out (repeatable)."
)
@knobs_option
@click.option("--repeats", type=click.IntRange(2), default=REPEATS, show_default=True,
              help="Timed repeats of each setting, after a warm-up.")  # fmt: skip
@click.option("--phases", type=click.IntRange(1), default=PHASES, show_default=True,
              help="Phases of a step at which impacts are tried; the worst counts.")  # fmt: skip
@click.option("-j", "--jobs", type=click.IntRange(1), default=1, show_default=True, help="Scenes at the same time.")
@timeout_option
@budget_option
@click.option("--out", metavar="DIR", help="Folder of the run; finished settings in it are kept.  [default: in runs/]")
@click.option("--rerun", type=click.Choice(["failed", "all"]), help="Run failed settings, or all, again.")
@click.option("--dry-run", is_flag=True, help="Show what would be run.")
@progress_option
@plug_in
@as_json
def sweep(**asked: Any) -> int:
    """Measure error against the truth and CPU time over every engine's knobs.

    To be inaccurate is what coarse settings are for, so the exit code is 0 whoever errs.

    \b
    plumbline sweep                               the suite smoke, every installed engine, over its time step
    plumbline sweep 'stack[]' --knobs all         over every knob it has
    plumbline sweep 'bouncing-ball[e=0.5]' -e 'mujoco*' -e reference
    plumbline sweep standard --budget 10m --out runs/accuracy     goes on where it stopped
    """  # fmt: skip
    register(asked["plugins"])
    with usage():
        jobs = planned(asked)
    if not jobs:
        click.echo("nothing is selected: no scenario has all that is asked for", err=True)
        return 5
    if asked["dry_run"]:
        from plumbline.cli_run import show_plan

        return show_plan(jobs, asked["json_"])
    results = measured(jobs, asked)
    with harness():
        paths = results.report()
    from plumbline import accuracy

    if asked["json_"]:
        click.echo(json.dumps({"folder": str(results.folder), **accuracy.as_json(results.campaign)}, indent=1))
    else:
        accuracy.show(results.campaign)
        click.echo(f"report: {paths['index.html']}")
    return results.exit_code(())


@click.command("advise")
@click.argument("scene", metavar="SCENARIO")
@click.option("--error", type=click.FloatRange(0.0, min_open=True), default=1e-3, show_default=True,
              help="Relative place error that is good enough.")  # fmt: skip
@click.option("--from", "runs", multiple=True, metavar="RUN",
              help="Folder of an earlier sweep (repeatable).  Without one it is measured now.")  # fmt: skip
@engine_option
@knobs_option
@timeout_option
@budget_option
@click.option("--out", metavar="DIR", help="Folder of what is measured now.  [default: in runs/]")
@progress_option
@plug_in
@as_json
def advise(scene: str, error: float, runs: tuple[str, ...], **asked: Any) -> int:
    """Say which engine and setting is the cheapest that is accurate enough for a scenario.

    Every answer is a measured point: the choice, the next best and by how much, what is wrong with the default
    settings, and who does not get there.

    \b
    plumbline advise newtons-cradle --error 1e-3
    plumbline advise 'stack[count=10]' --error 1e-4 --from runs/accuracy
    """  # fmt: skip
    register(asked["plugins"])
    with usage():
        from adapters import registry
        from plumbline import accuracy
        from plumbline.results import Results, merged

        label, name = one(scene)
        jobs = () if runs else planned(asked | {"what": label, "selectors": (), "tags": ()})
    options = {"repeats": REPEATS, "phases": PHASES, "jobs": 1, "rerun": None, "what": label}
    with harness():
        results = merged([Results.read(path) for path in runs]) if runs else measured(jobs, asked | options)
        if not runs:
            results.report()
    with usage():
        only = registry.select(asked["engines"]) if asked["engines"] else ()
        advice = accuracy.advice(results.campaign, name, error, only)
    accuracy.show_advice(advice, asked["json_"])
    return 0 if advice.choices else 1


def one(scene: str) -> tuple[str, str]:
    """How one scenario is asked for, and its name.

    Raises
    ------
    ValueError
        If the words name more than one.
    """
    from plumbline import own_files
    from plumbline.plan import choose

    own = own_files.is_file(scene)
    label = scene if own or "[" in scene else f"{scene}[]"
    found = choose(label) if own else choose(None, (label,))
    if len(found) != 1:
        raise ValueError(f"{scene} names {', '.join(s.name for s in found)}: only one is possible here")
    return label, found[0].name


def planned(asked: dict[str, Any]) -> tuple[Job, ...]:
    """Jobs of what the command line asks for: the word is a suite, a file, or else a selector of scenarios."""
    from adapters import registry
    from plumbline import own_files, sweeping
    from plumbline.plan import choose
    from scenarios import catalogue

    what, selectors = asked["what"], asked["selectors"]
    if what is None and not selectors and not asked["tags"]:
        what = DEFAULT_SUITE
    own = what is not None and own_files.is_file(what)
    if what is not None and not own and what not in catalogue.suites():
        what, selectors = None, (what, *selectors)
    scenarios = choose(what, selectors, asked["tags"])
    blind = [s.name for s in scenarios if s.truth is None]
    if scenarios and len(blind) == len(scenarios):
        raise ValueError(f"{', '.join(blind)}: no truth is known, and without one there is no error to measure")
    seen = [s for s in scenarios if s.truth is not None]
    return sweeping.jobs(seen, registry.select(asked["engines"]), asked["knobs"], str(what) if own else "")


def measured(jobs: tuple[Job, ...], asked: dict[str, Any]) -> Results:
    """Run a sweep with a progress display."""
    from dataclasses import replace

    from plumbline.campaign import Options

    options = Options(
        jobs=asked["jobs"],
        repeats=asked["repeats"],
        timeout=asked["timeout"] or 60.0,
        budget=asked["budget"],
        rerun=asked["rerun"] or "none",
        phases=asked["phases"],
        card=False,
        patience=PATIENCE,
    )
    title = f"Accuracy against time: {asked['what'] or ', '.join(asked.get('selectors', ())) or DEFAULT_SUITE}"
    scenarios = tuple({job.scenario.name: job.scenario for job in jobs}.values())
    told = {"sweep": {"knobs": asked["knobs"]}}
    return replace(execute(jobs, title, options, asked, told=told), known=scenarios)
