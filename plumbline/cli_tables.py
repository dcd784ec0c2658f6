"""The verb `tables`: energy, momentum, restitution of every engine side by side, for any run and in any format."""

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
