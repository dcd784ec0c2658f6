"""The verb `effects`: what a scene calls for, whether the rest changes anything, and what leaving it out saves."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from plumbline.cli_run import seconds
from plumbline.command import as_json, command, harness, plug_in, register, usage

if TYPE_CHECKING:
    from scenarios.scenario import Scenario

BUDGET, CLOCK = 1.0, 3.0  # CPU time [s]


@click.command("effects")
@click.argument("scenes", nargs=-1, required=True, metavar="SCENARIO|SUITE|FILE...")
@click.option("-e", "--engine", "engines", multiple=True, metavar="NAME",
              help="Engine or glob; ! in front leaves out (repeatable). Default: all.")  # fmt: skip
@click.option(
    "--budget", callback=seconds, help="CPU time of a scene in an engine; what it reaches is compared.  [default: 1s]"
)
@click.option(
    "--clock", callback=seconds, help="CPU time of the timed runs of a scene in an engine, about.  [default: 3s]"
)
@click.option("--untimed", is_flag=True, help="Compare motions only.")
@click.option("--out", metavar="DIR", help="Keep what is found in this folder, that of a run or a new one: "
              "`plumbline report DIR` shows it, and the same command goes on where it stopped.")  # fmt: skip
@plug_in
@as_json
def effects(
    scenes: tuple[str, ...],
    engines: tuple[str, ...],
    budget: float | None,
    clock: float | None,
    untimed: bool,
    out: str | None,
    plugins: tuple[str, ...],
    json_: bool,
) -> int:
    """Say which effects a scene calls for, prove that the others change nothing, and measure what they cost.

    Every effect that the scene does not declare is switched on so that it does nothing, and the motion is compared
    with that of the scene as declared; every effect that it declares is left out, and the motion is another one, or
    the scenario says why the effect is declared.  Exit code 1 if a scene calls for an effect that it does not declare.

    \b
    plumbline effects newtons-cradle                      one scenario, every installed engine
    plumbline effects my_scene.toml -e reference          a scene of your own
    plumbline effects full -e reference --out runs/proof  a suite; report with `plumbline report runs/proof`
    """  # fmt: skip
    register(plugins)
    with usage():
        from adapters import registry
        from plumbline import effects as found_out

        chosen = _chosen(scenes)
        names = registry.select(engines)
        names = tuple(name for name in names if not isinstance(_of(name), registry.Unavailable))
    if not chosen or not names:
        click.echo("nothing is selected", err=True)
        return 5
    told, missing = [], False
    with harness():
        title = f"Effects: {', '.join(scenes)}"
        store = found_out.Store(Path(out) if out else None, title, command())
        spent = 0.0 if untimed else clock or CLOCK
        for n, found in enumerate(found_out.find_out(chosen, names, budget or BUDGET, spent, store)):
            missing |= any(call.answer == "acts" and not call.declared for call in found.calls)
            told.append(found_out.as_json(found))
            if not json_:
                if n:
                    click.echo()
                found_out.show(found)
    if json_:
        click.echo(json.dumps(told, indent=1))
    elif out:
        click.echo(f"\nkept in {out}: `plumbline report {out}` shows it")
    return 1 if missing else 0


def _chosen(words: tuple[str, ...]) -> tuple[Scenario, ...]:
    """Scenarios of suites, files, globs and names; a plain name is the scenario with its default parameters."""
    from plumbline.own_files import is_file
    from plumbline.plan import choose
    from scenarios import catalogue

    found: dict[str, Scenario] = {}
    for word in words:
        if is_file(word) or word in catalogue.suites():
            chosen = choose(word)
        else:
            chosen = choose(None, (f"{word}[]" if word in catalogue.families() else word,))
        found |= {scenario.name: scenario for scenario in chosen}
    return tuple(found.values())


def _of(name: str) -> object:
    """The engine of that name, or why it cannot be had."""
    from adapters import registry

    try:
        return registry.engine(name)
    except registry.Unavailable as error:
        return error
