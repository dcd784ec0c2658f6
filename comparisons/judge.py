"""The judge: every quantity of every comparison, what was demanded of it, and the state of the cell.

A comparison is a module of this package with two names:

    QUANTITIES: dict[str, tuple[str, str]]       name -> unit, definition in one line
    measure(case: Case) -> Iterator[Quantity]    those of them that make sense for the case

It is found by being there; nothing else has to be touched.
"""

from __future__ import annotations

import importlib
import math
import pkgutil
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from types import ModuleType
from typing import NamedTuple

import numpy as np

import comparisons
from adapters.engine import Refusal
from adapters.run import Failure, Run
from comparisons.cell import Cell, cell_key
from comparisons.measurement import Case, Measurement, Quantity
from mechanics.trajectory import Trajectory
from scenarios.scenario import Check, Scenario


@dataclass(frozen=True)
class Judgement:
    """What the judge says of one run.

    Attributes
    ----------
    measurements : tuple of Measurement
    state : str
        One of `comparisons.cell.STATES`.
    stage, reason : str
        Where and why, for every state but ok.
    """

    measurements: tuple[Measurement, ...]
    state: str
    stage: str = ""
    reason: str = ""


class Definition(NamedTuple):
    """What a quantity is."""

    name: str
    unit: str
    meaning: str
    comparison: str  # the module that measures it


def judge(scenario: Scenario, run: Run) -> Judgement:
    """Measure a run and compare it with what the scenario demands.

    A run that broke is measured as far as it got, and nothing is demanded of it.  A demanded quantity
    that cannot be computed, where none fails by measurement, makes the state "error" at the stage
    "judge": a fault of the house, never charged to the engine.  A scene of which nothing is demanded
    and whose motion needs an effect that it does not declare is an error, too, with effect, bodies and time.
    """
    motion, broken = _sound(run)
    if isinstance(run.outcome, Refusal):
        return Judgement((), "refused", "build", run.outcome.reason)
    quantities = _measured(Case(scenario, run, motion)) if motion is not None and len(motion) else []
    if broken is not None:
        return Judgement(tuple(_informed(q) for q in quantities), broken.state, broken.stage, broken.reason)
    checks = {check.quantity: check for check in scenario.checks}
    rows = [_judged(q, checks.get(q.name)) for q in quantities]
    rows += [_missing(check) for name, check in checks.items() if name not in {q.name for q in quantities}]
    lacking = next((row.text for row in rows if row.quantity == "undeclared effects" and row.value > 0.0), "")
    if lacking and not checks:  # what demands something is known to declare what it needs
        return Judgement(tuple(rows), "error", "advance", lacking)
    return Judgement(tuple(rows), *verdict(rows))


def to_cell(
    scenario: Scenario, run: Run, *, judgement: Judgement | None = None, trace: str = "", reproduce: str = ""
) -> Cell:
    """The record of a run, judged.

    Parameters
    ----------
    scenario : Scenario
    run : Run
    judgement : Judgement, optional
        Of this run, if it is already there.
    trace : str
        Path of the recorded motion, relative to the run's folder.
    reproduce : str
        The command that runs this cell again.
    """
    said = judgement or judge(scenario, run)
    motion = run.trajectory
    reached = float(motion.t[-1]) if motion is not None and len(motion) else 0.0
    timing = run.timing
    return Cell(
        key=cell_key(scenario.name, scenario.version, run.engine, run.version, run.settings),
        scenario=scenario.name,
        family=scenario.family,
        version=scenario.version,
        tags=scenario.tags,
        engine=run.engine,
        engine_version=run.version,
        settings=dict(run.settings),
        state=said.state,
        duration=scenario.duration,
        stage=said.stage,
        reason=said.reason,
        time=run.outcome.time if isinstance(run.outcome, Failure) else reached,
        measurements=said.measurements,
        cost=timing.seconds / reached if timing is not None and reached > 0.0 else math.nan,
        repeats=len(timing.wall) if timing is not None else 0,
        contention=timing.contention if timing is not None else math.nan,
        deterministic=timing.deterministic if timing is not None else True,
        build_seconds=run.build_seconds if motion is not None else math.nan,
        digest=motion.digest() if motion is not None and len(motion) else "",
        impacts=len(run.events) if run.knows_events else -1,
        notes=run.notes,
        output=run.output,
        trace=trace,
        reproduce=reproduce,
        audit=dict(run.audit),
    )


@cache
def describe_quantities() -> tuple[Definition, ...]:
    """Every quantity there is, by comparison.

    Raises
    ------
    ValueError
        If two comparisons define the same quantity.
    """
    rows = [
        Definition(name, unit, meaning, module.__name__.rpartition(".")[2])
        for module in _comparisons()
        for name, (unit, meaning) in module.QUANTITIES.items()
    ]
    for row in rows:
        same = [other.comparison for other in rows if other.name == row.name]
        if len(same) > 1:
            raise ValueError(f"quantity {row.name!r} is defined by {' and '.join(same)}")
    return tuple(rows)


@cache
def _comparisons() -> tuple[ModuleType, ...]:
    names = sorted(m.name for m in pkgutil.iter_modules(comparisons.__path__) if m.name != "judge")
    modules = [importlib.import_module(f"comparisons.{name}") for name in names]
    return tuple(m for m in modules if hasattr(m, "QUANTITIES") and hasattr(m, "measure"))


def _sound(run: Run) -> tuple[Trajectory | None, Failure | None]:
    """The motion up to the first state that is not finite, and how the run broke, if it did."""
    motion = run.trajectory
    broken = run.outcome if isinstance(run.outcome, Failure) else None
    if motion is None:
        return None, broken
    parts = (getattr(motion, name).reshape(len(motion), -1) for name in ("x", "q", "v", "w"))
    finite = np.logical_and.reduce([np.isfinite(part).all(axis=1) for part in parts])
    if finite.all():
        return motion, broken
    count = int(np.argmin(finite))
    reason = f"the motion holds NaN or infinity from t = {motion.t[count]:.6g} s on"
    return motion.until(count), broken or Failure("diverged", "read", float(motion.t[count]), reason)


def _measured(case: Case) -> list[Quantity]:
    found: list[Quantity] = []
    for module in _comparisons():
        try:
            with np.errstate(over="ignore", invalid="ignore"):  # a run that blows up overflows, and that is its result
                found.extend(module.measure(case))
        except Exception as error:  # a fault of the house must not end a campaign, nor pass unseen
            said = f"{module.__name__} failed: {type(error).__name__}: {error}"
            done = {q.name for q in found}
            asked = [n for n in module.QUANTITIES if case.asks(n) and n not in done] or [next(iter(module.QUANTITIES))]
            found += [Quantity(n, math.nan, module.QUANTITIES[n][0], text=said) for n in asked if n not in done]
    return found


def _judged(quantity: Quantity, check: Check | None) -> Measurement:
    if check is None:
        return _informed(quantity)
    value = quantity.value
    if math.isnan(value):
        verdict = "unmeasured"
    elif value <= check.exact:
        verdict = "exact"
    else:
        verdict = "ok" if value <= check.tolerance else "fail"
    demands = (check.tolerance, check.exact, check.why)
    return Measurement(quantity.name, value, quantity.unit, quantity.time, quantity.text, *demands, verdict)


def _informed(quantity: Quantity) -> Measurement:
    said = (quantity.name, quantity.value, quantity.unit, quantity.time, quantity.text)
    return Measurement(*said, math.nan, math.nan, "", "info")


def _missing(check: Check) -> Measurement:
    known = {row.name: row.unit for row in describe_quantities()}
    word = "does not apply to this scene and run" if check.quantity in known else "there is no such quantity"
    demands = (check.tolerance, check.exact, check.why)
    return Measurement(check.quantity, math.nan, known.get(check.quantity, ""), math.nan, word, *demands, "unmeasured")


def verdict(rows: Sequence[Measurement]) -> tuple[str, str, str]:
    """State, stage and reason; what failed by measurement has failed, whatever else could not be measured."""
    failed = [
        f"{row.quantity} {row.value:.3g} {row.unit} exceeds {row.tolerance:.3g}"
        for row in rows
        if row.verdict == "fail"
    ]
    unmeasured = [f"{row.quantity} could not be measured: {row.text}" for row in rows if row.verdict == "unmeasured"]
    if failed or unmeasured:
        return "fail" if failed else "error", "judge", "; ".join(failed + unmeasured)
    return "ok", "", ""
