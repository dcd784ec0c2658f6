"""Command line: `python -m benchmarks [NAME ...] [--tiny] [--write]`."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

import click

from benchmarks.page import show, written
from benchmarks.row import Row

NAMES = (
    "bouncing-ball",
    "contact-time",
    "dzhanibekov",
    "stack",
    "impact-laws",
    "incline",
    "rolling",
    "thrown-boxes",
    "gas",
    "galperin",
    "free-bodies",
    "stack-speed",
    "startup",
    "overhead",
)
PAGE = Path(__file__).resolve().parents[1] / "docs" / "benchmarks.md"


def measured(name: str, tiny: bool = False) -> Row:
    """The row of one benchmark, measured now; `tiny` for a size that only shows that it runs.

    Raises
    ------
    KeyError
        For a name that is not among `NAMES`.
    """
    if name not in NAMES:
        raise KeyError(f"no benchmark {name!r}; there are {', '.join(NAMES)}")
    return import_module(f"benchmarks.{name.replace('-', '_')}").measure(tiny)


@click.command()
@click.argument("names", nargs=-1, type=click.Choice(NAMES), metavar="[NAME]...")
@click.option("--tiny", is_flag=True, help="Sizes that only show that everything runs.")
@click.option("--write", is_flag=True, help="Enter what was measured in docs/benchmarks.md.")
def main(names: tuple[str, ...], tiny: bool, write: bool) -> None:
    """Measure what the reference engine promises (all NAMEs if none is given) and print promise and measurement."""
    from rich.console import Console

    if tiny and write:
        raise click.UsageError("tiny sizes are not for the page")
    console = Console()
    for name in names or NAMES:
        with console.status(name):
            row = measured(name, tiny)
        show(row, console)
        if write:
            PAGE.write_text(written(PAGE.read_text(encoding="utf-8"), row), encoding="utf-8")


if __name__ == "__main__":
    main()
