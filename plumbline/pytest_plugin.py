"""Scenarios as pytest items, for the test suite of whoever builds an engine: `pytest --plumbline ENGINE`.

    pytest --plumbline mujoco                                        the suite smoke
    pytest --plumbline 'my-engine*' --plumbline-suite standard       another suite
    pytest --plumbline mine --plumbline-plugin engines.py -k bounc   an engine that is not installed, some scenarios

An item passes if every demanded quantity is within its tolerance.  What the engine refuses is skipped with its reason,
what fails for a reason on record is an expected failure, and a failure names quantity, value, tolerance and the
command that runs it alone.  Without the option this module costs pytest nothing: it imports nothing else.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from adapters.workers import Workers
    from comparisons.cell import Cell
    from plumbline.plan import Job

DEADLINE = 120.0  # of one item [s]


def pytest_addoption(parser: pytest.Parser) -> None:
    """Options of the group `plumbline`."""
    group = parser.getgroup("plumbline", "scenarios of Plumbline as tests")
    group.addoption("--plumbline", action="append", default=[], metavar="ENGINE",
                    help="run scenarios in this engine (or glob) as tests; repeatable")  # fmt: skip
    group.addoption("--plumbline-suite", metavar="SUITE", help="suite or file of scenarios [default: smoke]")
    group.addoption("--plumbline-scenario", action="append", default=[], metavar="NAME",
                    help="scenario, glob or name[param=value]; repeatable")  # fmt: skip
    group.addoption("--plumbline-set", action="append", default=[], metavar="KNOB=VALUE",
                    help="knob of the engine; repeatable")  # fmt: skip
    group.addoption("--plumbline-plugin", action="append", default=[], metavar="FILE.py",
                    help="engines of this file join; repeatable")  # fmt: skip
    group.addoption("--plumbline-timeout", type=float, default=DEADLINE, metavar="SECONDS",
                    help=f"of one item; then its engine is killed [default: {DEADLINE:g}]")  # fmt: skip


@pytest.hookimpl(tryfirst=True)  # before -k and -m choose among the items
def pytest_collection_modifyitems(session: pytest.Session, config: pytest.Config, items: list[pytest.Item]) -> None:
    """Add the scenarios behind the tests that were found."""
    if config.option.plumbline:
        group = Scenarios.from_parent(session, name="plumbline", nodeid="plumbline")
        items.extend(group.collect())


class Scenarios(pytest.Collector):
    """All scenarios that are asked for, and the processes of their engines."""

    workers: Workers

    def collect(self) -> Iterator[ScenarioItem]:
        """One item for each scenario, engine and combination of settings."""
        from adapters.workers import Workers

        self.workers = Workers()
        self.config.add_cleanup(self.workers.close)
        for job in _jobs(self.config):
            yield ScenarioItem.from_parent(self, name=_name(job), job=job)


class ScenarioItem(pytest.Item):
    """One scenario in one engine."""

    def __init__(self, *, job: Job, **more: Any) -> None:
        super().__init__(**more)
        self.job = job
        self.add_marker("plumbline")

    def runtest(self) -> None:
        """Run and judge; every number goes into the JUnit file that pytest writes."""
        from adapters.run import sample_times
        from plumbline.judging import absent, judged

        job, scenario = self.job, self.job.scenario
        if job.absent is not None:
            cell = absent(job)
        else:
            times = sample_times(scenario.duration, scenario.sampling)
            timeout, workers = self.config.option.plumbline_timeout, self.parent.workers
            cell = judged(job, workers.run(job.engine, scenario.scene, times, job.settings, timeout=timeout))
        self.user_properties += [(f"{m.quantity} [{m.unit}]", m.value) for m in cell.measurements]
        if cell.state in ("refused", "not-installed"):
            pytest.skip(cell.reason)
        if cell.state == "xfail":
            pytest.xfail(cell.known)
        if cell.state != "ok":
            raise Wrong(cell)

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        """What is wrong, without a traceback through the harness."""
        if isinstance(excinfo.value, Wrong):
            return explained(excinfo.value.cell)
        return super().repr_failure(excinfo, style)

    def reportinfo(self) -> tuple[str, None, str]:
        """Where the item is from: no file, its own name."""
        return "plumbline", None, self.name


class Wrong(Exception):
    """The answer is not right; `cell` says how."""

    def __init__(self, cell: Cell) -> None:
        self.cell = cell
        super().__init__(f"{cell.scenario} in {cell.engine}: {cell.state}")


def explained(cell: Cell) -> str:
    """A cell that is not right, in lines: the sentence, every demand with its value, what was printed, the command."""
    from reports.numbers import settings_text, with_unit
    from reports.verdict import mark, ratio, sentence, times_tolerance

    sign = mark(cell)
    lines = [
        f"{sign.glyph} {sign.word}: {cell.scenario} in {cell.engine} {cell.engine_version}",
        f"settings: {settings_text(cell.settings)}",
        *([] if cell.state == "fail" else [sentence(cell)]),  # of which the table says more
        "",
    ]
    demanded = [m for m in cell.measurements if not math.isnan(m.tolerance)]
    width = max((len(m.quantity) for m in demanded), default=0)
    for m in sorted(demanded, key=ratio, reverse=True):
        when = "" if math.isnan(m.time) else f" at t = {m.time:.4g} s"
        told = f"{with_unit(m.value, m.unit, 4)}, tolerance {with_unit(m.tolerance, m.unit)}"
        lines += [f"{m.verdict:<10} {m.quantity:<{width}}  {told} ({times_tolerance(ratio(m))}){when}"]
        lines += [f"{'':<10} {'':<{width}}  because {m.why}"] if m.verdict == "fail" and m.why else []
    lines += [f"note: {note}" for note in cell.notes]
    lines += ["", "the engine printed:", cell.output] if cell.output else []
    lines += ["", f"reproduce: {cell.reproduce}"] if cell.reproduce else []
    return "\n".join(lines)


def _jobs(config: pytest.Config) -> tuple[Job, ...]:
    """What the options ask for.

    Raises
    ------
    UsageError
        For a name or a value that is not possible, with what is.
    """
    from adapters import registry
    from mechanics.arrays import SceneError
    from plumbline import own_files
    from plumbline.plan import choose, plan, read_settings

    asked = config.option
    for plugin in asked.plumbline_plugin:
        registry.register(Path(plugin).stem, plugin)
    what = asked.plumbline_suite or (None if asked.plumbline_scenario else "smoke")
    own_file = what if what and own_files.is_file(what) else ""
    try:
        scenarios = choose(what, asked.plumbline_scenario)
        return plan(scenarios, registry.select(asked.plumbline), read_settings(asked.plumbline_set), own_file)
    except (SceneError, registry.Unavailable, ValueError) as error:
        raise pytest.UsageError(f"--plumbline: {error}") from error


def _name(job: Job) -> str:
    from adapters import registry
    from adapters.engine import defaults
    from reports.numbers import settings_text

    if job.absent is not None:
        return f"{job.engine}::{job.scenario.name}"
    usual = defaults(registry.engine(job.engine))
    other = settings_text({knob: value for knob, value in job.settings.items() if value != usual[knob]})
    return f"{job.engine}::{job.scenario.name}" + (f" ({other})" if other else "")


def pytest_configure(config: pytest.Config) -> None:
    """Name the marker of the items, so that `-m plumbline` chooses them."""
    config.addinivalue_line("markers", "plumbline: a scenario of Plumbline in an engine")
