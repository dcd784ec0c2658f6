"""A row in the terminal and in docs/benchmarks.md, where each stands between markers of its own."""

from __future__ import annotations

import math
from typing import Any

from benchmarks.row import Beside, Figure, Row
from plumbline.fingerprint import fingerprint
from reports.numbers import short


def number(value: float, unit: str) -> str:
    """A number with its unit as it stands in a table."""
    if not math.isfinite(value):
        return "none"
    text = f"{int(value):,}" if value == int(value) and 1.0 <= abs(value) < 1e9 else short(value)
    return f"{text} {unit}".rstrip()


def promise(figure: Figure) -> str:
    """What was promised."""
    return f"{'at least' if figure.at_least else 'at most'} {number(figure.target, figure.unit)}"


def show(row: Row, console: Any) -> None:
    """Print a row."""
    from rich.table import Table
    from rich.text import Text

    table = Table(
        title=Text(f"{row.name}: {row.subject}", style="bold"), title_justify="left", box=None, pad_edge=False
    )
    table.add_column("", overflow="fold")
    table.add_column("measured", justify="right", no_wrap=True)
    table.add_column("promised", justify="right", no_wrap=True)
    table.add_column("")
    for figure in row.figures:
        mark = Text("✓ met", style="green") if figure.met else Text("✕ missed", style="bold red")
        table.add_row(figure.what, number(figure.value, figure.unit), promise(figure), mark)
    console.print(table)
    console.print(Text(row.how, style="dim"))
    if row.beside:
        beside = Table(box=None, pad_edge=False)
        for name, justify in (("", "left"), (row.judged, "right"), ("wall time", "right"), ("", "left")):
            beside.add_column(name, justify=justify)
        for b in row.beside:
            beside.add_row(b.engine, number(b.error, ""), number(b.seconds, "s"), b.note)
        console.print(beside)
    if row.missed and not row.met:
        console.print(Text(f"missed: {row.missed}", style="bold"))
    console.print()


def written(page: str, row: Row) -> str:
    """The page with this row in its place, and this machine in that of the machine.

    Raises
    ------
    ValueError
        If the page has no markers for it.
    """
    return _between(_between(page, row.name, _section(row)), "machine", _machine())


def _between(page: str, name: str, text: str) -> str:
    begin, end = f"<!-- {name}: begin -->", f"<!-- {name}: end -->"
    if page.count(begin) != 1 or page.count(end) != 1:
        raise ValueError(f"docs/benchmarks.md needs {begin!r} and {end!r} once each")
    head, rest = page.split(begin)
    return f"{head}{begin}\n\n{text}\n\n{end}{rest.split(end)[1]}"


def _section(row: Row) -> str:
    lines = [f"{row.subject[0].upper()}{row.subject[1:]}.", ""]
    lines += ["| | measured | promised | |", "|---|---|---|---|"]
    lines += [
        f"| {f.what} | {number(f.value, f.unit)} | {promise(f)} | {'met' if f.met else '**missed**'} |"
        for f in row.figures
    ]
    lines += ["", f"{row.how[0].upper()}{row.how[1:]}."]
    if row.missed and not row.met:
        lines += ["", f"Missed: {row.missed}."]
    if row.beside:
        lines += ["", f"| | {row.judged} | wall time | |", "|---|---|---|---|", *map(_line, row.beside)]
    return "\n".join(lines)


def _line(beside: Beside) -> str:
    return f"| {beside.engine} | {number(beside.error, '')} | {number(beside.seconds, 's')} | {beside.note} |"


def _machine() -> str:
    facts = fingerprint()
    packages = ", ".join(f"{name} {version}" for name, version in facts["packages"].items())  # type: ignore[attr-defined]
    system = str(facts["system"]).partition(" ")[0]
    return f"{facts['processor']}, {facts['processors']} processors, {system}, {facts['python']}; {packages}."
