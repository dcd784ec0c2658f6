"""Verbs about runs that are there: `merge` joins them, `compare` sets two side by side."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from plumbline.command import as_json, harness, plug_in, register

if TYPE_CHECKING:
    from plumbline.results import Results


@click.command("merge")
@click.argument("runs", nargs=-1, required=True, metavar="RUN...")
@click.option("--out", required=True, metavar="DIR", help="Folder of the whole; it must not be a run already.")
def merge(runs: tuple[str, ...], out: str) -> int:
    """Join runs to one, such as the parts of `run --shard`; of a cell in several of them the last counts.

    The exit code is that of the whole.
    """
    from plumbline import finish, merging
    from plumbline.results import Results

    with harness():
        whole, remarks = merging.merge([Results.read(path) for path in runs], out)
        for remark in remarks:
            click.echo(f"note: {remark}", err=True)
        return finish.finish(whole, finish.Outputs(), json_=False)


@click.command("compare")
@click.argument("a", metavar="A")
@click.argument("b", metavar="B")
@click.option("--suite", metavar="NAME", help="Suite or file that engines are run on.  [default: smoke]")
@click.option("-s", "--scenario", "selectors", multiple=True, metavar="NAME",
              help="Scenario, glob or name[param=value] that engines are run on (repeatable).")  # fmt: skip
@click.option("--set", "settings", multiple=True, metavar="KNOB=VALUE", help="Knob of the engines (repeatable).")
@click.option("--python", "pythons", multiple=True, metavar="PATH",
              help="Interpreter of the environment of A, and again of B; plumbline is installed in both.")  # fmt: skip
@click.option("--out", metavar="DIR", help="Folder for the two runs.  [default: a new one in runs/]")
@plug_in
@as_json
def compare(a: str, b: str, **asked: Any) -> int:
    """Set two runs, two engines, or an engine in two environments side by side.

    Of two runs or environments the exit code is 1 if B is worse than A, differs or answers less; engines may differ.

    \b
    plumbline compare runs/monday runs/tuesday
    plumbline compare mujoco mujoco:stock -s bouncing-ball
    plumbline compare mujoco mujoco --python old/bin/python --python new/bin/python --suite standard
    """
    from comparisons.regression import FINDINGS
    from plumbline import merging, side_by_side

    register(asked["plugins"])
    archived = [(Path(word) / "run.json").is_file() for word in (a, b)]
    if any(archived) and not all(archived):
        run, other = (a, b) if archived[0] else (b, a)
        raise click.UsageError(f"{run} is a run and {other} is none: two runs, or two engines")
    with harness():
        first, second = _archived(a, b, asked) if all(archived) else _run(a, b, asked)
        engines = None if all(archived) else (a, b)
        campaign, found = side_by_side.compared(first, second, engines)
    remarks = merging.differences([first, second])
    if asked["json_"]:
        click.echo(json.dumps(side_by_side.as_plain(first, second, found, remarks), indent=1))
    else:
        click.echo(f"A: {side_by_side.versions(first, engines and a)} ({first.folder})")
        click.echo(f"B: {side_by_side.versions(second, engines and b)} ({second.folder})")
        for remark in remarks:
            click.echo(f"note: {remark}")
        _show(found)
    if not campaign.cells:
        return 5
    return int((a == b or engines is None) and any(change.outcome in FINDINGS for change in found))


def _archived(a: str, b: str, asked: dict[str, Any]) -> tuple[Results, Results]:
    from plumbline.results import Results

    if any(asked[name] for name in ("suite", "selectors", "settings", "pythons", "out")):
        raise click.UsageError("runs that are there are compared as they are: no --suite, -s, --set, --python or --out")
    return Results.read(a), Results.read(b)


def _run(a: str, b: str, asked: dict[str, Any]) -> tuple[Results, Results]:
    """Run both engines, each in its environment and into a folder of its own."""
    from plumbline.run_folder import new_id
    from plumbline.side_by_side import carried_out

    pythons = asked["pythons"] or (sys.executable, sys.executable)
    if len(pythons) != 2:
        raise click.UsageError(f"--python is given {len(pythons)} times: once for A and once for B, or not at all")
    if a == b and pythons[0] == pythons[1]:
        raise click.UsageError(f"{a} and {b} are the same engine in the same environment")
    words = [asked["suite"]] if asked["suite"] else []
    for flag, name in (("-s", "selectors"), ("--set", "settings"), ("--plugin", "plugins")):
        words += [word for value in asked[name] for word in (flag, value)]
    out = Path(asked["out"]) if asked["out"] else Path("runs") / new_id()
    first, second = (
        carried_out(python, [*words, "-e", engine, "--repeats", "1"], out / name)
        for python, engine, name in zip(pythons, (a, b), ("a", "b"), strict=True)
    )
    return first, second


def _show(found: Any) -> None:
    from rich.table import Table
    from rich.text import Text

    from comparisons.regression import tally
    from plumbline.finish import wide_console
    from plumbline.side_by_side import WORDS, lines

    console = wide_console()
    table = Table(box=None, pad_edge=False, header_style="bold")
    for head in ("scenario", "engine", "what decides", "A", "B", "B / A", ""):
        table.add_column(head, overflow="fold")
    for line, change in zip(lines(found), found, strict=True):
        if change.outcome != "identical":
            cells = (line.scenario, line.engine, line.quantity, line.a, line.b, line.ratio, f"{line.glyph} {line.word}")
            table.add_row(*map(Text, cells))
    if table.row_count:
        console.print(table)
    console.print(Text(", ".join(f"{n} {WORDS[word][1]}" for word, n in tally(found).items()) or "nothing to compare"))
