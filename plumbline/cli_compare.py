"""Verbs about runs that are there: `merge` joins them, `compare` sets two side by side."""

from __future__ import annotations

import click

from plumbline.command import harness


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
