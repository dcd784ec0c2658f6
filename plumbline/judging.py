"""From a run to its cell: judged by the comparisons, explained where the cause is on record."""

from __future__ import annotations

import math
import traceback
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from adapters.registry import NotInstalled
from adapters.run import Run
from comparisons.cell import Cell
from comparisons.judge import judge, to_cell
from comparisons.known import explain
from comparisons.phases import over_phases
from plumbline.plan import Job
from scenarios.phase import STEP, delays, later
from scenarios.scenario import Scenario


def judged(job: Job, run: Run, trace: str = "", more: Sequence[Run] = ()) -> Cell:
    """Cell of a run.  What the judge cannot do is its own failure (stage "judge"), never the engine's.

    `more` are the runs of the other phases of a step, in order (see `scenarios.phase`).
    """
    try:
        again = f"{job.reproduce} --phases {1 + len(more)}" if more and job.reproduce else job.reproduce
        return _cell(job.scenario, run, trace, again, more)
    except Exception as error:
        where = traceback.extract_tb(error.__traceback__)[-1]
        reason = f"{type(error).__name__}: {error} ({Path(where.filename).name}, line {where.lineno})"
        return _unjudged(job, "error", "judge", reason, trace=trace, output=run.output, notes=run.notes)


def judged_again(scenario: Scenario, run: Run, cell: Cell, more: Sequence[Run] = ()) -> Cell:
    """The cell of an archived run, and of the other phases of a step, as the comparisons judge it now."""
    return replace(_cell(scenario, run, cell.trace, cell.reproduce, more), key=cell.key)


def step_of(settings: Mapping[str, object]) -> float:
    """The step over which phases are spread [s]: the engine's, or `scenarios.phase.STEP` where it has none."""
    step = settings.get("dt", STEP)
    return float(step) if isinstance(step, (int, float)) else STEP


def _cell(scenario: Scenario, run: Run, trace: str, reproduce: str, more: Sequence[Run]) -> Cell:
    """Judged and explained.

    A single run has no warm-up before it and is no measurement of cost: first runs took up to 90
    times as long where an engine compiles as it goes, up to 5 times elsewhere.
    """
    if more:
        runs = (run, *more)
        begun = delays(scenario, len(runs), step_of(run.settings))
        said = [judge(later(scenario, delay), each) for delay, each in zip(begun, runs, strict=True)]
        judgement, values = over_phases(said)
        cell = to_cell(scenario, run, judgement=judgement, trace=trace, reproduce=reproduce)
        cell = explain(replace(cell, phases=values))
    else:
        cell = explain(to_cell(scenario, run, trace=trace, reproduce=reproduce))
    return cell if cell.repeats > 1 else replace(cell, cost=math.nan, contention=math.nan)


def absent(job: Job) -> Cell:
    """Cell of a job whose engine cannot be had here."""
    if isinstance(job.absent, NotInstalled):
        return _unjudged(job, "not-installed", "import", job.absent.reason)
    return _unjudged(job, "error", "import", job.absent.reason if job.absent else "")


def _unjudged(job: Job, state: str, stage: str, reason: str, **told: object) -> Cell:
    scenario = job.scenario
    return Cell(
        key=job.key,
        scenario=scenario.name,
        family=scenario.family,
        version=scenario.version,
        tags=scenario.tags,
        engine=job.engine,
        engine_version=job.version,
        settings=dict(job.settings),
        state=state,
        duration=scenario.duration,
        stage=stage,
        reason=reason,
        reproduce=job.reproduce,
        **told,  # type: ignore[arg-type]
    )
