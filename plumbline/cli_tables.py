"""The verbs `tables`, `figures` and `rerun`: what a run measured, side by side and over time, for other programs."""

from __future__ import annotations

import json
import math
from pathlib import Path

import click

from plumbline.command import as_json, harness, usage


@click.command("tables")
@click.argument("subjects", nargs=-1, metavar="[SUBJECT]...")
@click.option("--run", "runs", multiple=True, metavar="RUN",
              help="Folder of a run (repeatable).  [default: the newest in runs/]")  # fmt: skip
@click.option("--out", "files", multiple=True, metavar="FILE",
              help="Write .md, .csv, .parquet or .tex instead of printing (repeatable).")  # fmt: skip
@as_json
def tables(subjects: tuple[str, ...], runs: tuple[str, ...], files: tuple[str, ...], json_: bool) -> None:
    """Compare energy, momentum, restitution, penetration or stability over all engines.  Default: the first three.

    CSV, Parquet and JSON hold every digit, the others three and a mark where a tolerance is exceeded.

    \b
    plumbline tables                                       of the newest run, on the terminal
    plumbline tables energy momentum restitution --run runs/today --out balance.tex --out balance.csv
    """
    from plumbline import finish
    from plumbline.results import Results, merged
    from reports import quantities
    from reports.recorded import declared_restitution, look_up

    with harness(), usage():
        chosen = quantities.checked(subjects)
        campaign = merged([Results.read(path) for path in runs or (_newest(),)]).campaign
        asked = declared_restitution(look_up(campaign))
        try:
            for name in files:
                click.echo(f"written: {quantities.write(campaign, chosen, Path(name), asked)}", err=json_)
        except OSError as error:
            raise click.FileError(str(error.filename), error.strerror) from error
    if json_:
        found = quantities.frame(campaign, chosen).to_dict(orient="records")
        click.echo(json.dumps([{name: _plain(value) for name, value in row.items()} for row in found], indent=1))
    elif not files:
        finish.wide_console().print(quantities.terminal(campaign, chosen, asked))


def _plain(value: object) -> object:
    """`value` as JSON holds it: null for what was not measured, a word for infinity."""
    if not isinstance(value, float) or math.isfinite(value):
        return value
    return None if math.isnan(value) else str(value)


def _newest() -> str:
    """The newest run in `runs`: names begin with the time.

    Raises
    ------
    ValueError
        If there is none.
    """
    found = sorted(path.parent for path in Path("runs").glob("*/run.json"))
    if not found:
        raise ValueError("there is no run in runs/: say one with --run")
    return str(found[-1])


@click.command("figures")
@click.option("--run", "runs", multiple=True, metavar="RUN",
              help="Folder of a run (repeatable).  [default: the newest in runs/]")  # fmt: skip
@click.option("-s", "--scenario", "selectors", multiple=True, metavar="NAME",
              help="Only figures of these scenarios, as they are printed (repeatable).")  # fmt: skip
@click.option("--as", "kinds", type=click.Choice(["svg", "png", "pdf"]), multiple=True, default=["svg"],
              show_default=True, help="Format (repeatable); PNG and PDF are drawn by Chromium.")  # fmt: skip
@click.option("--out", required=True, metavar="DIR", help="Folder for the files; made if it is not there.")
def figures(runs: tuple[str, ...], selectors: tuple[str, ...], kinds: tuple[str, ...], out: str) -> int:
    """Write the figures of a run as files: accuracy against cost, and energy, momentum, gap and error over time."""
    from dataclasses import replace

    from plumbline.results import Results, merged
    from reports import figure_files
    from reports.recorded import look_up

    with harness(), usage():
        results = merged([Results.read(path) for path in runs or (_newest(),)])
        campaign = results.campaign
        chosen = tuple(c for c in campaign.cells if not selectors or c.scenario in selectors)
        known, place, amount = look_up(campaign), Path(out), 0
        try:
            place.mkdir(parents=True, exist_ok=True)
            for name, figure in figure_files.figures(replace(campaign, cells=chosen), results.traces, known):
                for kind in kinds:
                    figure_files.write(figure, place / f"{name}.{kind}")
                    amount += 1
        except OSError as error:
            raise click.FileError(str(error.filename), error.strerror) from error
    click.echo(f"{amount} files in {place}")
    return 0 if amount else 5


@click.command("rerun")
@click.option("--run", "runs", multiple=True, metavar="RUN",
              help="Folder of a run (repeatable).  [default: the newest in runs/]")  # fmt: skip
@click.option("-s", "--scenario", "selectors", multiple=True, metavar="NAME",
              help="Only these scenarios, as they are printed (repeatable).")  # fmt: skip
@click.option("--out", required=True, metavar="DIR", help="Folder for the files; made if it is not there.")
def rerun(runs: tuple[str, ...], selectors: tuple[str, ...], out: str) -> int:
    """Write the recorded motions as .rrd files for the viewer Rerun, one for each scenario.

    Needs the package rerun-sdk, an extra: pip install 'plumbline[rerun]'.
    """
    from dataclasses import replace

    from plumbline.results import Results, merged
    from reports import rerun_file
    from reports.figure_files import file_name
    from reports.recorded import look_up, recorded
    from reports.series import time_series

    with harness(), usage():
        results = merged([Results.read(path) for path in runs or (_newest(),)])
        cells = tuple(c for c in results.campaign.cells if not selectors or c.scenario in selectors)
        campaign, place, amount = replace(results.campaign, cells=cells), Path(out), 0
        try:
            place.mkdir(parents=True, exist_ok=True)
            for one in recorded(campaign, results.traces, look_up(campaign), most=len(cells)):
                if one.scene is None:
                    click.echo(f"{one.scenario}: not written, its scene is not known", err=True)
                    continue
                click.echo(rerun_file.write(one, time_series(one), place / f"{file_name(one.scenario)}.rrd"))
                amount += 1
        except OSError as error:
            raise click.FileError(str(error.filename), error.strerror) from error
    return 0 if amount else 5
