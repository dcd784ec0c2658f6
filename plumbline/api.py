"""The two calls that run engines from Python: one scene in one engine, and a campaign."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from adapters import registry
from adapters import run as driver
from adapters.engine import Engine
from adapters.engine import Settings as Chosen
from adapters.run import Run, sample_times
from adapters.workers import MEMORY, TIMEOUT, Workers
from mechanics.scene import Scene
from plumbline import own_files
from plumbline.plan import Settings, plan
from plumbline.run_folder import new_id
from scenarios import catalogue
from scenarios.scenario import Scenario

if TYPE_CHECKING:
    from plumbline.campaign import Watcher
    from plumbline.results import Results

SAMPLES = 100  # intervals, where only a duration is asked


def simulate(
    scene: Scene,
    engine: str | Engine = "reference",
    *,
    times: Sequence[float] | float,
    settings: Chosen | None = None,
    isolated: bool = False,
    timeout: float = TIMEOUT,
) -> Run:
    """Run one scene in one engine.

    Parameters
    ----------
    engine : str or Engine
        Name of a registered engine, or an engine.
    times : sequence of float, or float
        When to record the state [s], increasing; a number is a duration in 100 equal intervals.
    settings : mapping, optional
        Knob -> value; the engine's defaults for the others.
    isolated : bool
        In a process of its own, where it can crash, hang (`timeout` [s]) or run out of memory
        without harm.

    Returns
    -------
    Run
        `outcome` is a Trajectory, a Refusal with its reason, or a Failure: what an engine does never
        raises.  `notes` name what it approximates, and bodies that overlap at the start.

    Raises
    ------
    ValueError
        For times or settings that are not possible.
    Unavailable, UnknownName
        If the engine is not installed, or there is none of that name.
    """
    sampled = sample_times(times, times / SAMPLES) if isinstance(times, (int, float)) else times
    if not isolated:
        run = driver.run(registry.engine(engine) if isinstance(engine, str) else engine, scene, sampled, settings)
    elif isinstance(engine, str):
        with Workers() as workers:
            run = workers.run(engine, scene, sampled, settings, timeout=timeout)
    else:
        raise ValueError("an isolated engine is known by its name: register it first")
    return replace(run, notes=run.notes + overlap_notes(scene))


def overlap_notes(scene: Scene) -> tuple[str, ...]:
    """One sentence for each pair of bodies that overlap at the start, with the depth."""
    from comparisons.gap import overlaps

    return tuple(f"{o.a} and {o.b} overlap by {o.depth:.3g} m at the start" for o in overlaps(scene))


def run(
    scenarios: str | Scenario | Iterable[str | Scenario],
    engines: str | Iterable[str] | None = None,
    settings: Settings | None = None,
    out: str | Path | None = None,
    *,
    jobs: int = 2,
    repeats: int = 1,
    timeout: float = TIMEOUT,
    budget: float | None = None,
    memory: int = MEMORY,
    rerun: str = "none",
    phases: int = 1,
    card: bool = True,
    watcher: Watcher | None = None,
) -> Results:
    """Run scenarios in engines, each engine in a process of its own, and judge every answer.

    Parameters
    ----------
    scenarios : scenarios, names of suites, selectors or files
        Selectors are names, globs, or ``name[parameter=value]``; files are scenes in TOML or Python.
    engines : names or globs, optional
        ``!`` in front leaves out.  Without any: every registered engine and profile but those that run on
        request, of which some run on the scenarios of one suite all the same.
    settings : mapping, optional
        Knob, or ``engine.knob``, -> a value or a sequence of values, each of which is run.
    out : path, optional
        Folder of the run; a new one in ``runs`` if there is none.  Finished cells in it are used
        again.
    jobs, repeats, timeout, budget, memory, rerun, phases, card
        As in `plumbline.campaign.Options`.
    watcher : Watcher, optional
        Told of every cell as it begins and ends.

    Raises
    ------
    ValueError
        For anything asked that is not possible; UnknownName for a name that is not there.
    FolderError
        If the folder cannot be written; what was finished is kept.
    """
    from plumbline.campaign import Execution, Options, Silence

    asked = [scenarios] if isinstance(scenarios, (str, Scenario)) else list(scenarios)
    chosen = tuple({s.name: s for item in asked for s in _scenarios(item)}.values())
    patterns = [engines] if isinstance(engines, str) else list(engines or ())
    names, baselines = registry.select(patterns), registry.baselines(patterns)
    options = Options(jobs, repeats, timeout, budget, memory, rerun, phases, card)
    results = Execution(
        jobs=plan(chosen, names, settings, baselines=baselines),
        folder=Path(out) if out is not None else Path("runs") / new_id(),
        title=", ".join(item if isinstance(item, str) else item.name for item in asked),
        command=f"plumbline.run({[s.name for s in chosen]!r}, engines={list(names)!r})",
        options=options,
        watcher=watcher or Silence(),
    ).run()
    return replace(results, known=chosen)


def _scenarios(item: str | Scenario) -> tuple[Scenario, ...]:
    if isinstance(item, Scenario):
        if not item.name:
            raise ValueError("Scenario.name is empty: a scenario that is run needs a name")
        return (item,)
    if not isinstance(item, str):
        raise ValueError(f"{item!r} is no scenario: a Scenario, or the name of one, of a suite or of a file")
    if own_files.is_file(item):
        return own_files.scenarios_of(item)
    return catalogue.suite(item) if item in catalogue.suites() else catalogue.find(item)
