"""Planning a sweep: which settings of each engine are tried, and in which order."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import zip_longest

from adapters.engine import Engine, Knob, checked_settings, defaults, laws
from adapters.registry import Unavailable
from plumbline.plan import Job, absent_job, engine_or_why, job
from scenarios.scenario import Scenario

KNOBS = ("main", "all")


def ladders(engine: Engine, knobs: str = "all") -> tuple[dict[str, Knob], ...]:
    """Settings of an engine that are swept, each with all of its knobs, the default first.

    "main": the ladder of the first knob that is a number (the time step; the tolerance of the reference).
    "all": besides, the ladder of every other such knob at the defaults, and for each value of a knob that
    is a word (an integrator, a solver, a method) the main ladder again.  Knobs that choose a law
    (`adapters.engine.laws`) stay as they are.

    Raises
    ------
    ValueError
        If `knobs` is neither.
    """
    if knobs not in KNOBS:
        raise ValueError(f"knobs = {knobs!r} is not possible: {' or '.join(KNOBS)}")
    turned = {name: tuple(values) for name, values in engine.knobs.items() if name not in laws(engine)}
    words = {name: values for name, values in turned.items() if any(isinstance(v, str) for v in values)}
    numbers = {name: values for name, values in turned.items() if name not in words}
    main = next(iter(numbers), None)
    rungs: list[dict[str, Knob]] = [{}] + [{main: value} for value in numbers.get(main, ())]
    if knobs == "all":
        rungs += [{name: value} for name, values in numbers.items() if name != main for value in values]
        first = [{main: value} for value in numbers[main]] if main is not None else [{}]
        rungs += [{name: word} | rung for name, values in words.items() for word in values for rung in first
                  if word != defaults(engine)[name]]  # fmt: skip
    settings = [checked_settings(engine, rung) for rung in rungs]
    return tuple({tuple(one.items()): one for one in settings}.values())


def jobs(
    scenarios: Sequence[Scenario], engines: Sequence[str], knobs: str = "all", own_file: str = ""
) -> tuple[Job, ...]:
    """Jobs of a sweep, scenario by scenario and rung by rung: the engines on one rung are timed in one sitting.

    Parameters
    ----------
    knobs : str
        As for `ladders`.
    own_file : str
        Words of the command line that bring the scenarios if the catalogue does not have them.

    Raises
    ------
    ValueError
        As `ladders`.
    """
    found: list[Job] = []
    had = [(engine, () if isinstance(engine, Unavailable) else ladders(engine, knobs))
           for engine in map(engine_or_why, engines)]  # fmt: skip
    for scenario in scenarios:
        rows = zip_longest(*(_column(scenario, engine, settings, own_file) for engine, settings in had))
        found += [one for row in rows for one in row if one is not None]
    return tuple({one.key: one for one in found}.values())


def _column(
    scenario: Scenario, engine: Engine | Unavailable, settings: Sequence[dict[str, Knob]], own_file: str
) -> list[Job]:
    """Jobs of one engine, the default setting first; one job that says why if it cannot be had."""
    if isinstance(engine, Unavailable):
        return [absent_job(scenario, engine, own_file)]
    return [job(scenario, engine, chosen, own_file) for chosen in settings]
