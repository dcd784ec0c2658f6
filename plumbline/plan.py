"""What is to be run: scenarios x engines x settings -> jobs, each of which becomes one cell."""

from __future__ import annotations

import math
import shlex
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from fnmatch import fnmatchcase
from functools import partial
from itertools import product
from typing import Any

from adapters import registry
from adapters.engine import Engine, Knob, checked_settings, defaults, profile
from comparisons.cell import cell_key
from mechanics.scene_file import scene_digest, scene_to_dict
from plumbline import own_files
from scenarios import catalogue
from scenarios.scenario import Scenario

Settings = Mapping[str, Knob | Sequence[Knob]]


@dataclass(frozen=True)
class Job:
    """One cell to be run.

    Attributes
    ----------
    key : str
        As of the cell.
    scenario : Scenario
    engine, version : str
    settings : dict
        Every knob of the engine with its value.
    reproduce : str
        The one-line command that runs this cell alone.
    absent : Unavailable or None
        Why the engine cannot be run here.
    """

    key: str
    scenario: Scenario
    engine: str
    version: str
    settings: Mapping[str, Knob]
    reproduce: str
    absent: registry.Unavailable | None = None

    @property
    def label(self) -> str:
        """For people."""
        return f"{self.scenario.name} · {self.engine}"


def choose(
    what: str | None = None,
    selectors: Sequence[str] = (),
    tags: Sequence[str] = (),
    duration: float | None = None,
    sampling: float | None = None,
) -> tuple[Scenario, ...]:
    """Scenarios of a suite or file, narrowed by selectors and tags; without `what`, of the whole catalogue.

    Selectors are names, globs, `name[parameter=value]`, and any of them with `!` in front to leave
    out; tags likewise.  With a suite or a file, selectors pick among its scenarios.

    Raises
    ------
    UnknownName
        For a suite, selector or tag that names nothing there is.
    ValueError, SceneError
        For a parameter out of range, a file without scenarios, a scene that is not possible.
    """
    if what is None:
        pool, find = None, catalogue.find
    elif own_files.is_file(what):
        pool = own_files.scenarios_of(what, duration, sampling)
        find = partial(_find_own, pool)
    else:
        pool = catalogue.suite(what)
        find = partial(_find_in_suite, pool)
    wanted = [s for s in selectors if not s.startswith("!")]
    barred = [s.removeprefix("!") for s in selectors if s.startswith("!")]
    chosen = _unique(s for w in wanted for s in find(w)) if wanted else pool
    if chosen is None:
        chosen = _unique(s for f in catalogue.families().values() for s in f.all())
    out = {s.name for b in barred for s in find(b)}
    return tuple(s for s in chosen if s.name not in out and _tagged(s, tags, pool or ()))


def _find_in_suite(pool: Sequence[Scenario], selector: str) -> tuple[Scenario, ...]:
    """Scenarios of the suite that match; with parameters, the one they give, in the suite or not."""
    named = catalogue.find(selector)
    return named if "[" in selector else tuple(s for s in pool if s.name in {n.name for n in named})


def _find_own(pool: Sequence[Scenario], selector: str) -> tuple[Scenario, ...]:
    bare = "[" not in selector
    found = tuple(
        s for s in pool if s.name == selector.removesuffix("[]") or (bare and fnmatchcase(s.family, selector))
    )
    if not found:
        raise catalogue.unknown("scenario", selector, [s.name for s in pool])
    return found


def _tagged(scenario: Scenario, tags: Sequence[str], pool: Sequence[Scenario]) -> bool:
    known = {t for f in catalogue.families().values() for t in f.tags} | {t for s in pool for t in s.tags}
    for tag in tags:
        if tag.removeprefix("!") not in known:
            raise catalogue.unknown("tag", tag.removeprefix("!"), sorted(known))
    wanted = {t for t in tags if not t.startswith("!")}
    barred = {t.removeprefix("!") for t in tags if t.startswith("!")}
    return (not wanted or bool(wanted & set(scenario.tags))) and not barred & set(scenario.tags)


def _unique(scenarios: Iterable[Scenario]) -> tuple[Scenario, ...]:
    return tuple({s.name: s for s in scenarios}.values())


def read_settings(items: Iterable[str]) -> dict[str, list[Knob]]:
    """Settings of the command line: `knob=value` or `engine.knob=value`; a knob named twice gets both values.

    Raises
    ------
    ValueError
        For an item without a name or a value.
    """
    settings: dict[str, list[Knob]] = {}
    for item in items:
        name, sign, text = item.partition("=")
        if not (sign and name.strip() and text.strip()):
            raise ValueError(f"{item!r} is not of the form knob=value or engine.knob=value")
        settings.setdefault(name.strip(), []).append(_knob(text.strip()))
    return settings


def _knob(text: str) -> Knob:
    """A number, or a word: what is not finite is a word, because no knob has such a value."""
    try:
        value = float(text)
    except ValueError:
        return text
    return value if math.isfinite(value) else text


def settings_of(engine: Engine, settings: Settings) -> tuple[dict[str, Knob], ...]:
    """Every combination of the settings that are about `engine`, each with all of its knobs.

    Raises
    ------
    ValueError
        For a value that is not possible, or a knob asked of this engine by name that it does not have.
    """
    mine: dict[str, tuple[Knob, ...]] = {}
    for name, given in settings.items():
        pattern, _, knob = name.rpartition(".")
        if fnmatchcase(engine.name, pattern) if pattern else knob in engine.knobs:
            mine[knob] = (given,) if isinstance(given, (str, int, float)) else tuple(given)
    combinations = product(*mine.values())
    return tuple(checked_settings(engine, dict(zip(mine, values, strict=True))) for values in combinations)


def plan(
    scenarios: Sequence[Scenario],
    engines: Sequence[str],
    settings: Settings | None = None,
    own_file: str = "",
    baselines: Mapping[str, str] | None = None,
) -> tuple[Job, ...]:
    """The jobs, scenario by scenario; an engine that cannot be had is a job, too, and says so.

    Parameters
    ----------
    engines : sequence of str
        Names.
    own_file : str
        Words of the command line that bring the scenarios if the catalogue does not have them.
    baselines : mapping, optional
        Engines that run besides, on the scenarios of one suite each: name -> suite.

    Raises
    ------
    ValueError
        For settings that are not possible, or about no engine of these.
    """
    settings = settings or {}
    besides = {name: {s.name for s in catalogue.suite(suite)} for name, suite in (baselines or {}).items()}
    besides = {name: some for name, some in besides.items() if any(s.name in some for s in scenarios)}
    had: dict[str, Engine | registry.Unavailable] = {name: engine_or_why(name) for name in (*engines, *besides)}
    present = [e for e in had.values() if not isinstance(e, registry.Unavailable)]
    _check_used(settings, present)
    choices = {e.name: settings_of(e, settings) for e in present}
    jobs = []
    asked = set(engines)
    for scenario in scenarios:
        jobs += _remedied(scenario, asked, own_file)
        for name, engine in had.items():
            if name in besides and scenario.name not in besides[name]:
                continue
            if isinstance(engine, registry.Unavailable):
                jobs.append(absent_job(scenario, engine, own_file))
            else:
                jobs += [job(scenario, engine, chosen, own_file) for chosen in choices[name]]
    return tuple({job.key: job for job in jobs}.values())


def job(scenario: Scenario, engine: Engine, settings: Mapping[str, Knob], own_file: str = "") -> Job:
    """The job of one cell; `settings` are every knob of the engine with its value."""
    version = str(engine.version)
    key = cell_key(scenario.name, scenario.version, engine.name, version, settings)
    told = {k: v for k, v in settings.items() if v != defaults(engine)[k]}
    return Job(key, scenario, engine.name, version, settings, reproduce(scenario, engine.name, told, own_file))


def absent_job(scenario: Scenario, engine: registry.Unavailable, own_file: str = "") -> Job:
    """The job of an engine that cannot be had here."""
    key = cell_key(scenario.name, scenario.version, engine.name, "", {})
    return Job(key, scenario, engine.name, "", {}, reproduce(scenario, engine.name, {}, own_file), engine)


def _remedied(scenario: Scenario, engines: Collection[str], own_file: str) -> list[Job]:
    """Jobs of the remedies of an exhibit, for those engines of which some profile runs."""
    jobs = []
    libraries = {name.partition(":")[0] for name in engines}
    for remedy in scenario.exhibit.remedies if scenario.exhibit else ():
        if remedy.engine.partition(":")[0] in libraries:
            jobs += plan((replace(scenario, exhibit=None),), (remedy.engine,), remedy.settings, own_file)
    return [replace(job, scenario=scenario) for job in jobs]


def engine_or_why(name: str) -> Engine | registry.Unavailable:
    """The engine of that name, or why it cannot be had here."""
    try:
        return registry.engine(name)
    except registry.Unavailable as unavailable:
        return unavailable


def _check_used(settings: Settings, engines: Sequence[Engine]) -> None:
    """A setting that no engine of the run has is a slip of the pen, not a wish."""
    for name in settings:
        pattern, _, knob = name.rpartition(".")
        if pattern and not any(fnmatchcase(e.name, pattern) for e in engines):
            raise catalogue.unknown("engine in this run for --set", pattern, [e.name for e in engines])
        if not pattern and engines and not any(knob in e.knobs for e in engines):
            raise catalogue.unknown("knob", knob, sorted({k for e in engines for k in e.knobs}))


def reproduce(scenario: Scenario, engine: str, settings: Mapping[str, Knob], own_file: str = "") -> str:
    """The command that runs this cell alone; "" for a scenario that only a caller in Python has."""
    if not own_file and scenario.family not in catalogue.families():
        return ""
    label = scenario.name if "[" in scenario.name else f"{scenario.name}[]"  # without brackets: every variant
    words = ["plumbline", "run", *shlex.split(own_file), "-e", engine, "-s", label]
    for name, value in settings.items():
        words += ["--set", f"{name}={value!r}" if isinstance(value, float) else f"{name}={value}"]
    return shlex.join(words)


def described(scenarios: Iterable[Scenario]) -> dict[str, Any]:
    """What a reader needs beside the numbers, by label: the scene, too, and a hash of what was asked (`question`)."""
    return {
        s.name: {
            "summary": s.summary,
            "source": s.source,
            "tags": list(s.tags),
            "effects": sorted(kind.__name__ for kind in s.scene.needs),
            "duration": s.duration,
            "sampling": s.sampling,
            "version": s.version,
            "question": f"{scene_digest(s.scene)}-{s.duration!r}-{s.sampling!r}",
            "scene": scene_to_dict(s.scene),
            "checks": [vars(c) for c in s.checks],
            **({"exhibit": asdict(s.exhibit)} if s.exhibit else {}),
        }
        for s in scenarios
    }


def described_engines(jobs: Iterable[Job]) -> dict[str, Any]:
    """Version, default settings, knobs (coarse to fine) and profile of every engine of the plan."""
    told: dict[str, Any] = {}
    for job in jobs:
        if job.engine in told:
            continue
        if job.absent is not None:
            told[job.engine] = {"version": "", "settings": {}, "profile": {}, "absent": job.absent.reason}
        else:
            engine = registry.engine(job.engine)
            told[job.engine] = {
                "version": job.version,
                "settings": defaults(engine),
                "knobs": {name: list(ladder) for name, ladder in engine.knobs.items()},
                "profile": dict(profile(engine)),
            }
    return told
