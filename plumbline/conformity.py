"""The laws of adapters as a table: laws down, engines across."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import click

from adapters import registry
from adapters.conformance import Law
from adapters.run import Failure
from adapters.workers import Workers
from plumbline.finish import wide_console

TIMEOUT = 300.0  # for all laws of one engine [s]

Verdict = tuple[Law, ...] | Failure | registry.Unavailable


def tried(names: Sequence[str], jobs: int = 2) -> dict[str, Verdict]:
    """What came of each engine: its laws, how its process died, or why it cannot be had."""

    def one(workers: Workers, name: str) -> Verdict:
        try:
            return workers.check(name, TIMEOUT)
        except registry.Unavailable as unavailable:
            return unavailable

    with Workers() as workers, ThreadPoolExecutor(jobs) as threads:
        try:
            return dict(zip(names, threads.map(lambda name: one(workers, name), names), strict=True))
        finally:
            workers.close()


def glyph(law: Law) -> str:
    """✓ kept, – does not apply, ~ broken and on record, ✕ broken."""
    if law.passed:
        return "–" if math.isnan(law.value) else "✓"
    return "~" if law.known else "✕"


def exit_code(found: Mapping[str, Verdict]) -> int:
    """3 if an engine's process died, 1 if a law is broken that is not on record, 5 if no engine could be tried."""
    if not any(isinstance(v, tuple) for v in found.values()) and not any(
        isinstance(v, Failure) for v in found.values()
    ):
        return 5
    if any(isinstance(v, Failure) for v in found.values()):
        return 3
    return 1 if any(glyph(law) == "✕" for v in found.values() if isinstance(v, tuple) for law in v) else 0


def show(patterns: Sequence[str], json_: bool) -> int:
    """Try the engines, print what came of it, and return the exit code.

    Raises
    ------
    UnknownName
        For a pattern that matches no engine.
    """
    found = tried(registry.select(patterns or ("*",)))
    if json_:
        click.echo(json.dumps({name: _plain(verdict) for name, verdict in found.items()}, indent=1))
        return exit_code(found)
    from rich.table import Table
    from rich.text import Text

    console = wide_console()
    kept = {name: v for name, v in found.items() if isinstance(v, tuple)}
    if kept:
        table = Table(box=None, pad_edge=False, header_style="bold")
        table.add_column("law")
        for name in kept:
            table.add_column(name.replace(":", "\n"), justify="center")
        for n, law in enumerate(next(iter(kept.values()))):
            table.add_row(law.name, *(glyph(laws[n]) for laws in kept.values()))
        console.print(table)
        console.print(Text("✓ kept   ✕ broken   ~ broken, reason on record   – does not apply", style="dim"))
    for name, verdict in found.items():
        for line in remarks(name, verdict):
            console.print(Text(line))
    return exit_code(found)


def remarks(name: str, verdict: Verdict) -> list[str]:
    """What must be said of an engine besides its column."""
    if isinstance(verdict, registry.Unavailable):
        return [f"{name}: {verdict.reason}"]
    if isinstance(verdict, Failure):
        return [f"{name}: {verdict.state}: {verdict.reason}"]
    lines = []
    for law in verdict:
        if not law.passed:
            lines.append(
                f"{glyph(law)} {name}, {law.name}: {law.explanation}" + (f"; {law.known}" if law.known else "")
            )
        elif law.known:
            lines.append(f"▲ {name}, {law.name}: kept now, though on record as broken ({law.known})")
    return lines


def _plain(verdict: Verdict) -> Any:
    if isinstance(verdict, registry.Unavailable):
        return {"state": "not-installed", "reason": verdict.reason}
    if isinstance(verdict, Failure):
        return {"state": verdict.state, "reason": verdict.reason}
    return [vars(law) | {"value": law.value if math.isfinite(law.value) else None} for law in verdict]
