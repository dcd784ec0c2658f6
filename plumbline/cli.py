"""The command line.  Nothing heavy is imported before a command needs it: `plumbline --help` answers at once."""

from __future__ import annotations

import sys
import traceback
from collections.abc import Sequence
from pathlib import Path

import click

from plumbline.cli_ablate import ablate
from plumbline.cli_compare import compare, merge
from plumbline.cli_effects import effects
from plumbline.cli_gate import baseline, check
from plumbline.cli_ladder import ladder
from plumbline.cli_run import run, seconds
from plumbline.cli_sweep import advise, sweep
from plumbline.cli_tables import figures, rerun, tables
from plumbline.command import as_json, harness, plug_in, register, usage

CODES = """\b
Exit codes:
  0    everything within tolerance, refused with a reason, or on record
  1    findings: an answer is out of tolerance, or worse than in the baseline
  2    usage: a name, value or file that is not possible
  3    an engine crashed, raised, ran out of memory or hung
  4    the harness failed: it could not judge or could not write
  5    nothing was selected, or nothing of it could run
  130  interrupted; the same command with --out goes on where it stopped
"""


def main(args: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code."""
    stdout = sys.stdout
    try:
        code = cli.main(args=None if args is None else list(args), prog_name="plumbline", standalone_mode=False)
        sys.stdout.flush()
        return int(code or 0)
    except click.exceptions.NoArgsIsHelpError as error:
        error.show()
        return 0
    except click.ClickException as error:
        error.show()
        return error.exit_code
    except (click.Abort, KeyboardInterrupt):
        click.echo("interrupted", err=True)
        return 130
    except SystemExit as stop:
        # if the reader of our output goes away, as in `plumbline list | head`, click puts a stand-in in its place
        return int(stop.code or 0) if sys.stdout is stdout else 0
    except Exception:  # a fault of ours: not to be taken for a finding, which has exit code 1
        traceback.print_exc()
        click.echo("this is a fault of plumbline itself, not of an engine or of what was asked", err=True)
        return 4


@click.group(epilog=CODES, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110})
@click.version_option(package_name="plumbline", prog_name="plumbline")
def cli() -> None:
    """Validate and benchmark rigid-body physics engines: who is right, at what cost, and where each one breaks."""


cli.add_command(run)
cli.add_command(ladder)
cli.add_command(effects)
cli.add_command(check)
cli.add_command(baseline)
cli.add_command(sweep)
cli.add_command(advise)
cli.add_command(ablate)
cli.add_command(merge)
cli.add_command(compare)
cli.add_command(tables)
cli.add_command(figures)
cli.add_command(rerun)


@cli.command("list")
@click.argument("what", required=False, type=click.Choice(["engines", "scenarios", "metrics", "suites", "ladders"]))
@plug_in
@as_json
def list_(what: str | None, plugins: tuple[str, ...], json_: bool) -> None:
    """List engines, scenarios, metrics, suites and ladders."""
    from plumbline import listing

    register(plugins)
    listing.show((what,) if what else ("engines", "suites", "scenarios", "ladders", "metrics"), json_)


@cli.command()
@click.argument("name")
@plug_in
@as_json
def describe(name: str, plugins: tuple[str, ...], json_: bool) -> None:
    """Describe a scenario, a suite, an engine or a metric."""
    from plumbline import description

    register(plugins)
    with usage():
        description.show(name, json_)


@cli.command()
@click.argument("runs", nargs=-1, required=True, metavar="RUN...")
@click.option("--out", metavar="DIR", help="Write the report here instead of into the (first) run.")
@click.option("--junit", metavar="PATH", help="Write JUnit XML here, too.")
@click.option("--summary", metavar="PATH", help="Append the Markdown summary to this file.")
@click.option("--as-judged", is_flag=True, help="Keep the verdicts of the run instead of judging its motions anew.")
@as_json
def report(
    runs: tuple[str, ...], out: str | None, junit: str | None, summary: str | None, as_judged: bool, json_: bool
) -> None:
    """Write the report of archived runs: page, summary, JUnit, CSV and Parquet.

    The recorded motions are judged anew by the comparisons as they are now; no engine is run.
    """
    from plumbline import finish
    from plumbline.results import Results, merged

    with harness():
        results, remarks = merged([Results.read(path) for path in runs]), []
        if not as_judged:
            results, remarks = results.judged_again()
        for remark in remarks:
            click.echo(f"note: {remark}", err=True)
        finish.finish(results, finish.Outputs(junit, summary, Path(out) if out else None), json_)


@cli.command()
@click.argument("engines", nargs=-1, metavar="[ENGINE]...")
@plug_in
@as_json
def conform(engines: tuple[str, ...], plugins: tuple[str, ...], json_: bool) -> int:
    """Put engines through the laws every adapter must pass.

    Exit code 1 if a profile configured by the house, or a guest, breaks a law; stock profiles may.
    """
    from plumbline import conformity

    register(plugins)
    with usage():
        return conformity.show(engines, json_)


@cli.command()
@click.argument("engines", nargs=-1, metavar="[ENGINE]...")
@plug_in
@as_json
def card(engines: tuple[str, ...], plugins: tuple[str, ...], json_: bool) -> int:
    """Read back what engines really apply: gravity, damping, inertia, restitution, friction, caps.

    Every number is told from the motion of a small scene; asked and got stand side by side.
    """
    from plumbline import card

    register(plugins)
    with usage():
        return card.show(engines, json_)


@cli.command()
@click.option("--trial", callback=seconds, help="How long timings are tried.  [default: 3s]")
@plug_in
@as_json
def doctor(trial: float | None, plugins: tuple[str, ...], json_: bool) -> None:
    """Look at this machine: versions, missing engines and how to install them, how far its timings can be trusted.

    The same work is timed against itself, and against a tenth more work, over and over: how often would a difference be
    seen that is none, and how often one that is real?  A longer trial finds rarer disturbances.
    """
    from plumbline import health

    register(plugins)
    health.show(json_, trial)
