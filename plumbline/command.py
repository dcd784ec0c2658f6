"""What the verbs of the command line share: how errors end, how jobs are run, and options that several of them take."""

from __future__ import annotations

import shlex
import signal
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from plumbline.campaign import Options
    from plumbline.plan import Job
    from plumbline.results import Results

plug_in = click.option(
    "--plugin", "plugins", multiple=True, metavar="FILE.py", help="Engines of this file join (repeatable)."
)
as_json = click.option("--json", "json_", is_flag=True, help="Print JSON for programs.")


class HarnessFault(click.ClickException):
    """The harness itself could not go on."""

    exit_code = 4


@contextmanager
def usage() -> Iterator[None]:
    """Errors in what was asked for end with their message and exit code 2."""
    from adapters.registry import Unavailable
    from mechanics.arrays import SceneError

    try:
        yield
    except (SceneError, Unavailable, ValueError) as error:
        raise click.UsageError(str(error)) from error


@contextmanager
def harness() -> Iterator[None]:
    """Folders that cannot be read or written end with their message and exit code 4."""
    from adapters.archive import ArchiveError
    from plumbline.run_folder import FolderError

    try:
        yield
    except (FolderError, ArchiveError) as error:
        raise HarnessFault(str(error)) from error


@contextmanager
def terminable() -> Iterator[None]:
    """SIGTERM is answered like Ctrl-C: workers are ended, what is finished is kept."""
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def register(plugins: Sequence[str]) -> None:
    """Make engines of files known, in this process and (through their path) in the workers."""
    from adapters import registry

    for plugin in plugins:
        if not (plugin.endswith(".py") and Path(plugin).is_file()):
            raise click.UsageError(f"--plugin {plugin}: there is no such Python file")
        registry.register(Path(plugin).stem, plugin)


def command() -> str:
    """The command line as it was typed."""
    return shlex.join(["plumbline", *sys.argv[1:]])


def execute(jobs: Sequence[Job], title: str, options: Options, asked: dict[str, Any], **more: Any) -> Results:
    """Run `jobs` with a progress display and return everything.

    Parameters
    ----------
    asked : dict
        What was asked for: the folder "out" (a new one in runs/ if there is none) and the "style" of the display.
    more
        Further arguments of `plumbline.campaign.Execution`.

    Raises
    ------
    KeyboardInterrupt
        On Ctrl-C and SIGTERM, after saying how to go on.
    click.ClickException
        If the folder cannot be read or written.
    """
    from rich.console import Console

    from plumbline.campaign import Execution
    from plumbline.progress import progress
    from plumbline.run_folder import new_id

    folder = Path(asked["out"]) if asked["out"] else Path("runs") / new_id()
    with harness(), terminable(), progress(asked["style"], Console(stderr=True)) as display:
        try:
            return Execution(jobs, folder, title, command(), options, display, **more).run()
        except KeyboardInterrupt:
            click.echo(f"interrupted; what is finished is kept, `--out {folder}` goes on from there", err=True)
            raise
