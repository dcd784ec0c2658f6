"""The verb `ladder`: raise one difficulty after the other until each engine breaks."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import click

from plumbline.cli_run import seconds
from plumbline.command import as_json, execute, harness, plug_in, register, usage

if TYPE_CHECKING:
    from plumbline.results import Results

DEADLINE = 30.0  # of a rung, in CPU time of the engine [s]
PATIENCE = 10.0  # times as long may a rung take on a machine that is busy


@click.command("ladder")
@click.argument("names", nargs=-1, metavar="[NAME]...")
@click.option("-e", "--engine", "engines", multiple=True, metavar="NAME",
              help="Engine or glob; ! in front leaves out (repeatable). Default: all.")  # fmt: skip
@click.option("-j", "--jobs", type=click.IntRange(1), default=1, show_default=True, help="Engines at the same time.")
@click.option(
    "--timeout", callback=seconds, help="Of a rung, in CPU time; an engine that needs more is too slow.  [default: 30s]"
)
@click.option("--budget", callback=seconds, help="Of the run; what has not begun by then is not run.")
@click.option("--memory", type=click.FloatRange(0.0), default=8.0, show_default=True,
              help="GiB of address space for each engine; 0 = no limit.")  # fmt: skip
@click.option("--out", metavar="DIR", help="Folder of the run; finished rungs in it are kept.  [default: in runs/]")
@click.option("--rerun", type=click.Choice(["failed", "all"]), help="Try rungs that failed, or all, again.")
@click.option("--progress", "style", type=click.Choice(["auto", "plain", "off"]), default="auto", show_default=True)
@plug_in
@as_json
def ladder(names: tuple[str, ...], **asked: Any) -> int:
    """Raise one difficulty rung by rung until each engine breaks, and say how.

    Breaking is what ladders are for, so the exit code is 0 whoever breaks; `plumbline list ladders` names them.

    \b
    plumbline ladder                               every ladder, every installed engine
    plumbline ladder mass-ratio 'stack-*'          some of them
    plumbline ladder step-size -e 'mujoco*'        some engines
    """  # fmt: skip
    register(asked["plugins"])
    with usage():
        from adapters import registry
        from plumbline.climbing import Climbers
        from plumbline.frontiers import rows, show
        from scenarios.ladder import find

        climbers = Climbers(find(names), registry.select(asked["engines"]))
    jobs = climbers.start()
    if not jobs:
        click.echo("nothing is selected: no engine has the knob that is raised", err=True)
        return 5
    results = _climb(climbers, jobs, ", ".join(names) or "all ladders", asked)
    with harness():
        paths = results.report()
    told = rows(results.campaign)
    if asked["json_"]:
        click.echo(json.dumps({"folder": str(results.folder), "frontiers": told}, indent=1))
    else:
        show(told)
        click.echo(f"report: {paths['index.html']}")
    return results.exit_code()


def _climb(climbers: Any, jobs: tuple[Any, ...], title: str, asked: dict[str, Any]) -> Results:
    from plumbline.campaign import Options

    options = Options(
        jobs=asked["jobs"],
        timeout=asked["timeout"] or DEADLINE,
        budget=asked["budget"],
        memory=round(asked["memory"] * 2**30),
        rerun=asked["rerun"] or "none",
        card=False,
        patience=PATIENCE,
    )
    ladders = {"following": climbers.after, "told": {"ladders": climbers.told}, "most": climbers.most}
    return execute(jobs, f"Ladders: {title}", options, asked, **ladders)
