"""What a campaign is doing, on stderr: a bar for people, one line a cell for logs, or nothing."""

from __future__ import annotations

import time
from contextlib import ExitStack
from types import TracebackType
from typing import Any

from comparisons.cell import Cell
from plumbline.plan import Job
from reports.verdict import mark

STYLES = ("auto", "plain", "off")


class Plain:
    """One line a finished cell."""

    def __init__(self) -> None:
        self._done = self._planned = 0

    def __enter__(self) -> Plain:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def begin(self, planned: int, reused: int) -> None:
        """Say how much there is to do."""
        self._done, self._planned = reused, planned
        if reused:
            _say(f"{reused} of {planned} cells are there already")

    def started(self, job: Job) -> None:
        """Nothing: a line is written when the cell is finished."""

    def finished(self, cell: Cell, seconds: float) -> None:
        """Count, verdict, cell, time taken; the reason if something broke."""
        self._done += 1
        width = len(str(self._planned))
        verdict = mark(cell)
        line = (
            f"[{self._done:>{width}}/{self._planned}] {verdict.glyph} {verdict.word}: {cell.scenario} · {cell.engine}"
        )
        reason = f": {cell.reason}" if verdict.tone == "broke" else ""
        _say(f"{line} ({seconds:.1f} s){reason}")


class Off(Plain):
    """Silence."""

    def begin(self, planned: int, reused: int) -> None:
        """Nothing."""

    def finished(self, cell: Cell, seconds: float) -> None:
        """Nothing."""


class Bar:
    """Cells done, remaining time, what is running; what broke is written above the bar as it happens."""

    def __init__(self, console: Any) -> None:
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

        self._bar = Progress(
            BarColumn(bar_width=24),
            MofNCompleteColumn(),
            TextColumn("cells"),
            TimeElapsedColumn(),
            TextColumn("{task.fields[left]}"),
            TextColumn("{task.fields[now]}", style="dim"),
            console=console,
            transient=True,
        )
        self._task = self._bar.add_task("", total=None, now="", left="")
        self._running: dict[str, str] = {}
        self._stack = ExitStack()
        self._begun, self._reused, self._planned, self._done = 0.0, 0, 0, 0

    def __enter__(self) -> Bar:
        self._stack.enter_context(self._bar)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stack.close()

    def begin(self, planned: int, reused: int) -> None:
        """Set the bar."""
        self._begun, self._planned, self._reused, self._done = time.monotonic(), planned, reused, reused
        self._bar.update(self._task, total=planned, completed=reused)

    def started(self, job: Job) -> None:
        """Show the cell as running."""
        self._running[job.key] = job.label
        self._show()

    def finished(self, cell: Cell, seconds: float) -> None:
        """Move on; a broken cell leaves a line."""
        self._running.pop(cell.key, None)
        self._done += 1
        verdict = mark(cell)
        if verdict.tone == "broke":
            said = f"{verdict.glyph} {verdict.word}: {cell.scenario} · {cell.engine}: {cell.reason}"
            self._bar.console.print(said, style="red", markup=False, highlight=False)
        self._bar.update(self._task, completed=self._done)
        self._show()

    def _show(self) -> None:
        fresh = self._done - self._reused
        left = ""
        if fresh >= 3:
            seconds = (time.monotonic() - self._begun) / fresh * (self._planned - self._done)
            left = f"about {seconds:.0f} s left" if seconds < 120.0 else f"about {seconds / 60.0:.0f} min left"
        self._bar.update(self._task, now=", ".join(self._running.values()), left=left)


def _say(text: str) -> None:
    import click

    click.echo(text, err=True)


def progress(style: str, console: Any) -> Plain | Bar:
    """Display of the given style; "auto" is a bar on a terminal and lines elsewhere."""
    if style == "off":
        return Off()
    return Bar(console) if style == "auto" and console.is_terminal else Plain()
