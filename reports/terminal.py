"""The verdict table for the command line."""

from __future__ import annotations

from typing import TYPE_CHECKING

from comparisons.cell import Campaign
from reports.card import at_stake
from reports.matrix import Entry, Matrix, matrix
from reports.standing import groups, lead_sentence
from reports.verdict import totals

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

STYLES = {"pass": "", "fail": "bold red", "broke": "bold white on red", "known": "yellow", "none": "dim"}


def show(campaign: Campaign, console: Console | None = None) -> None:
    """Print the verdict table, its footnotes and one sentence per group of engines.

    Engines that do not fit side by side follow in further tables.  Colours follow the console: none
    where output is not a terminal or `NO_COLOR` is set.
    """
    from rich.console import Console as NewConsole
    from rich.text import Text

    console = console or NewConsole()
    shown = matrix(campaign)
    for places in _side_by_side(shown, console.width):
        console.print(_table(shown, places))
        console.print()
    console.print(Text("worst error / tolerance: above 1 fails", style="dim"))
    for number, text in enumerate(shown.footnotes, 1):
        console.print(Text(f"{number:>3}  {text}", style="dim"))
    for group in groups(campaign):
        console.print(Text(f"{group.title}. ", style="bold") + Text(lead_sentence(group, len(shown.rows)), style=""))
    console.print(Text(totals(campaign)))
    for engine, sentences in at_stake(campaign).items():
        console.print(Text(f"{engine} got otherwise than asked: ", style="bold") + Text("; ".join(sentences)))


def _side_by_side(shown: Matrix, width: int) -> list[list[int]]:
    """Places of the engines of each table, as many as `width` characters hold."""
    free = width - max((len(r.scenario) for r in shown.rows), default=0)
    tables: list[list[int]] = [[]]
    used = 0
    for place in range(len(shown.engines)):
        need = 2 + max(len(shown.engines[place]), *(len(_text(r.entries[place])) for r in shown.rows))
        if tables[-1] and used + need > free:
            tables.append([])
            used = 0
        tables[-1].append(place)
        used += need
    return tables


def _table(shown: Matrix, places: list[int]) -> Table:
    from rich.table import Table
    from rich.text import Text

    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="bold")
    table.add_column("scenario", overflow="fold")
    for place in places:
        table.add_column(Text(shown.engines[place]), no_wrap=True, overflow="ellipsis")
    for row in shown.rows:
        entries = [row.entries[place] for place in places]
        cells = [Text(_text(e), style=STYLES[e.mark.tone] if e else "") for e in entries]
        table.add_row(Text(row.scenario), *cells)
    return table


def _text(entry: Entry | None) -> str:
    if entry is None:
        return ""
    ratio = entry.ratio.replace("× tol", "×").replace(" tol", "")
    note = f" [{entry.note}]" if entry.note else ""
    return f"{entry.mark.glyph} {entry.mark.word} {ratio}".rstrip() + note
