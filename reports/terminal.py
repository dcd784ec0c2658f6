"""The verdict table for the command line."""

from __future__ import annotations

from typing import TYPE_CHECKING

from comparisons.cell import Campaign
from reports.matrix import Entry, matrix
from reports.palette import base, profile
from reports.standing import groups, lead_sentence
from reports.verdict import totals

if TYPE_CHECKING:
    from rich.console import Console

STYLES = {"pass": "", "fail": "bold red", "broke": "bold white on red", "known": "yellow", "none": "dim"}


def show(campaign: Campaign, console: Console | None = None) -> None:
    """Print the verdict table, its footnotes and one sentence per group of engines.

    Colours follow the console: none where output is not a terminal or `NO_COLOR` is set.
    """
    from rich.console import Console as NewConsole
    from rich.table import Table
    from rich.text import Text

    console = console or NewConsole()
    shown = matrix(campaign)
    table = Table(box=None, pad_edge=False, header_style="bold", row_styles=["", "on default"])
    table.add_column("scenario", overflow="fold")
    table.add_column("decides", style="dim", overflow="fold")
    for engine in shown.engines:
        variant = profile(engine)
        table.add_column(Text(base(engine) + (f"\n{variant}" if variant else "")), overflow="fold")
    for row in shown.rows:
        table.add_row(Text(row.scenario), Text(row.decides), *(_entry(e) for e in row.entries))
    console.print(table)
    for number, text in enumerate(shown.footnotes, 1):
        console.print(Text(f"{number:>3}  {text}", style="dim"))
    console.print()
    for group in groups(campaign):
        console.print(Text(f"{group.title}. ", style="bold") + Text(lead_sentence(group, len(shown.rows)), style=""))
    console.print(Text(totals(campaign)))


def _entry(entry: Entry | None):
    from rich.text import Text

    if entry is None:
        return Text("")
    ratio = entry.ratio.replace("× tol", "×").removesuffix(" tol")
    note = f" [{entry.note}]" if entry.note else ""
    return Text(f"{entry.mark.glyph} {entry.mark.word} {ratio}".rstrip() + note, style=STYLES[entry.mark.tone])
