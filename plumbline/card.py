"""The read-back card of engines: read in their own processes, kept with a run, printed as asked / got."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from functools import partial
from typing import Any

import click

from adapters import registry
from adapters.engine import Knob, defaults
from adapters.run import Run
from adapters.workers import Workers
from comparisons.read_back import read_back
from comparisons.reading import Reading, to_plain
from mechanics.scene import Scene
from plumbline.plan import Job

TIMEOUT = 30.0  # of one micro-scene [s]; an engine that compiles as it goes may need most of it the first time
STEP = 1e-3  # over whose phases impacts are spread where an engine has no time step [s]


def read_cards(
    jobs: Iterable[Job], engines: dict[str, Any], workers: Workers, threads: Executor, timeout: float = TIMEOUT
) -> None:
    """Tell `engines`, as `run.json` has them, their cards, where they are not told yet.

    An engine is read with the settings of its first job, and on what the scenarios of its jobs depend on.
    """
    tasks = {}
    for name, own in _by_engine(jobs).items():
        needs = {kind.__name__ for job in own for kind in job.scenario.scene.needs}
        told = engines[name].get("card")
        if told and told["settings"] == dict(own[0].settings) and needs <= set(told["needs"]):
            continue
        tasks[name] = needs, threads.submit(readings, workers, name, own[0].settings, needs, min(timeout, TIMEOUT))
    for name, (needs, task) in tasks.items():
        settings = dict(_by_engine(jobs)[name][0].settings)
        rows = [to_plain(r) for r in task.result()]
        engines[name]["card"] = {"settings": settings, "needs": sorted(needs), "readings": rows}


def keep_cards(before: Mapping[str, Any], now: dict[str, Any]) -> None:
    """Hand down the cards of an earlier part of the same run to engines of the same version."""
    for name, told in before.items():
        if name in now and "card" in told and told.get("version") == now[name].get("version"):
            now[name]["card"] = told["card"]


def _by_engine(jobs: Iterable[Job]) -> dict[str, list[Job]]:
    found: dict[str, list[Job]] = {}
    for job in jobs:
        if job.absent is None:
            found.setdefault(job.engine, []).append(job)
    return found


def readings(
    workers: Workers, engine: str, settings: Mapping[str, Knob], needs: Iterable[str] | None, timeout: float = TIMEOUT
) -> tuple[Reading, ...]:
    """The card of an engine with these settings, read in its own process; see `comparisons.read_back.read_back`."""

    def ask(scene: Scene, times: Sequence[float]) -> Run:
        return workers.run(engine, scene, times, settings, timeout=timeout)

    step = settings.get("dt", STEP)
    return read_back(ask, needs, step if isinstance(step, float) else STEP)


def show(patterns: Sequence[str], json_: bool) -> int:
    """Read the engines back, print asked / got, and return 0, or 5 if none of them can be had.

    Raises
    ------
    UnknownName
        For a pattern that matches no engine.
    """
    names = registry.select(patterns)
    had = {row.name: row for row in registry.listings() if row.name in names}
    present = [name for name in names if had[name].state == "installed"]
    settings = {name: defaults(registry.engine(name)) for name in present}
    with Workers() as workers, ThreadPoolExecutor(2) as threads:
        try:
            one = partial(readings, workers, needs=None)
            cards = dict(zip(present, threads.map(lambda name: one(name, settings[name]), present), strict=True))
        finally:
            workers.close()
    if json_:
        told = {
            name: {"version": had[name].version, "settings": settings[name], "readings": [to_plain(r) for r in card]}
            for name, card in cards.items()
        }
        click.echo(json.dumps(told, indent=1))
    elif cards:
        _print(cards)
    for name in names:
        if name not in cards:
            click.echo(f"{name}: {had[name].reason}", err=True)
    return 0 if cards else 5


def _print(cards: Mapping[str, Sequence[Reading]]) -> None:
    from rich.table import Table
    from rich.text import Text

    from plumbline.finish import wide_console
    from reports.card import lines, remarks

    console = wide_console()
    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("asked for")
    table.add_column("asked", justify="right")
    for name in cards:
        table.add_column(name.replace(":", "\n"), justify="right")
    for line in lines(cards):
        entries = [Text(e.text, style="bold red" if e.verdict == "differs" else "") for e in line.entries]
        table.add_row(line.name, line.asked, *entries)
    console.print(table)
    console.print(
        Text("got, read from motion alone; ≠ differs from what was asked, – refused, ? not read", style="dim")
    )
    for text in remarks(cards):
        console.print(Text(text, style="dim"))
