"""The end of a run: verdict table, report, copies for continuous integration, exit code."""

from __future__ import annotations

import json
import math
import os
import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click
from rich.console import Console
from rich.text import Text

from comparisons.cell import Campaign, cell_to_json
from comparisons.published import Figure
from comparisons.regression import changes
from plumbline import frontiers, published
from plumbline.results import FAIL_ON, SENTENCES, Results
from plumbline.run_folder import FolderError
from reports.regressions import chapters, lead_sentence, told
from reports.suite import suite_of
from reports.terminal import STYLES, show

WIDE = 180  # columns


@dataclass(frozen=True)
class Outputs:
    """Where else the report is to go.

    Attributes
    ----------
    junit, summary : str or None
        File to write JUnit XML to; file to append the Markdown summary to.
    folder : Path or None
        Folder of the report; None = that of the run.
    """

    junit: str | None = None
    summary: str | None = None
    folder: Path | None = None

    def open(self) -> None:
        """Try to open every output, before an hour of work is spent that could not be written.

        Raises
        ------
        FolderError
        """
        for path in filter(None, (self.junit, self.summary)):
            try:
                with Path(path).open("a", encoding="utf-8"):
                    pass
            except OSError as error:
                raise FolderError(f"cannot write {path}: {error.strerror or error}") from error

    def copy(self, paths: dict[str, Path]) -> None:
        """Bring the files of the report where they are asked for.

        Raises
        ------
        FolderError
        """
        try:
            if self.junit:
                shutil.copyfile(paths["junit.xml"], self.junit)
            if self.summary:
                with Path(self.summary).open("a", encoding="utf-8") as file:
                    file.write(paths["summary.md"].read_text(encoding="utf-8") + "\n")
        except OSError as error:
            raise FolderError(f"cannot write {error.filename}: {error.strerror}") from error


def finish(
    results: Results,
    outputs: Outputs,
    json_: bool,
    fail_on: tuple[str, ...] | None = None,
    figures: Sequence[Figure] | None = None,
) -> int:
    """Print the verdicts (or the published figures), write the report and its copies, and return the exit code."""
    found = published.rows(figures, results) if figures is not None else None
    code = results.exit_code(FAIL_ON if fail_on is None else fail_on)
    if found is not None:
        code = published.exit_code(found, results)
    paths = results.report(outputs.folder)
    outputs.copy(paths)
    if json_:
        told = as_json(results, paths, code)
        click.echo(json.dumps(told if found is None else told | {"figures": found}, indent=1))
        return code
    console = wide_console()
    if results.campaign.ladders:
        frontiers.show(frontiers.rows(results.campaign))
    suite = suite_of(results.campaign)
    if found is None and (suite.cells or not results.campaign.ladders):
        show(suite, console)
        show_changes(results.campaign, console)
    elif found is not None:
        published.show(found, console)
    say_commands(results)
    if results.campaign.cells and code:
        click.echo(f"exit code {code}: {SENTENCES[code]}")
    click.echo(f"report: {paths['index.html']}")
    return code


def show_changes(campaign: Campaign, console: Console, most: int = 20) -> None:
    """What is not identical to the baseline, where there is one: at most so many lines of each outcome."""
    found = changes(campaign)
    if not found:
        return
    console.print()
    for chapter in chapters(campaign, found):
        for line in chapter.lines[:most]:
            said = f"{line.scenario} · {line.engine}: {line.sentence}".removesuffix(": ")
            style = STYLES[chapter.mark.tone]
            console.print(Text(f"{chapter.mark.glyph} {chapter.mark.word}", style=style), Text(said))
        if len(chapter.lines) > most:
            console.print(f"  and {len(chapter.lines) - most} more {chapter.mark.word}; the report has them all")
    console.print(Text(lead_sentence(campaign, found)))


def wide_console() -> Console:
    """Console on stdout; where nobody says how wide it is (a log, a file), wide enough for eight engines."""
    console = Console()
    return console if console.is_terminal or "COLUMNS" in os.environ else Console(width=WIDE)


def say_commands(results: Results, most: int = 5) -> None:
    """The commands that run what broke once more, where there are any."""
    broken = [c for c in results.cells if c.state in ("error", "crash", "timeout", "oom", "diverged") and c.reproduce]
    for cell in broken[:most]:
        click.echo(f"again: {cell.reproduce}")
    if len(broken) > most:
        click.echo(f"       and {len(broken) - most} more; the report has every command")


def changes_as_json(campaign: Campaign) -> list[dict[str, Any]]:
    """Every cell beside its record for programs; empty without a baseline."""
    return [
        {"scenario": c.scenario, "engine": c.engine, "settings": dict(c.settings), "outcome": c.outcome,
         "quantity": c.quantity, "before": _finite(c.before), "now": _finite(c.now), "told": told(c)}
        for c in changes(campaign)
    ]  # fmt: skip


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def as_json(results: Results, paths: dict[str, Path], code: int) -> dict[str, Any]:
    """The run for programs."""
    campaign = results.campaign
    return {
        "id": campaign.id,
        "title": campaign.title,
        "started": campaign.started,
        "wall_seconds": campaign.wall_seconds,
        "exit_code": code,
        "folder": str(results.folder),
        "files": {name: str(path) for name, path in paths.items()},
        "cards": {name: told["card"] for name, told in campaign.engines.items() if "card" in told},
        "cells": [json.loads(cell_to_json(cell)) for cell in results.cells],
        "changes": changes_as_json(campaign),
    }
