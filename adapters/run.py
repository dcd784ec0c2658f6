"""The only code that drives engines and clocks them.

`run` never raises because of an engine: whatever the engine does ends as a `Run`, with what was
computed until then.
"""

from __future__ import annotations

import gc
import math
import statistics
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from adapters.engine import (
    BadScene,
    ContactForce,
    Diverged,
    Engine,
    Impact,
    Refusal,
    Settings,
    checked_settings,
    lead,
    settled,
)
from mechanics.arrays import SceneError
from mechanics.scene import Scene
from mechanics.trajectory import State, Trajectory

FAILURES = ("diverged", "error", "crash", "timeout", "oom")
LONG = 10_000_000_000  # wall time of a warm-up beyond which a run is not repeated [ns]
STAGES = ("import", "build", "start", "advance", "read", "judge")


@dataclass(frozen=True)
class Failure:
    """How a run broke.

    Attributes
    ----------
    state : str
        One of `FAILURES`.
    stage : str
        One of `STAGES`.
    time : float
        Simulated time reached [s].
    reason : str
    """

    state: str
    stage: str
    time: float
    reason: str


@dataclass(frozen=True)
class Timing:
    """What `advance` cost.

    Attributes
    ----------
    wall : (repeats, intervals) array of int
        Wall time of each sample interval [ns].
    cpu : (repeats,) array of int
        CPU time of the thread over all intervals [ns].
    digests : tuple of str
        Hash of the final state of each repeat: equal, or the envelope means nothing.
    """

    wall: np.ndarray
    cpu: np.ndarray
    digests: tuple[str, ...]

    @property
    def deterministic(self) -> bool:
        """Whether every repeat ended in bitwise the same state."""
        return len(set(self.digests)) <= 1

    @property
    def seconds(self) -> float:
        """Cost of the run [s]: the sum over intervals of the minimum over repeats (the envelope).

        Repeats do the same work in each interval, so the minimum strips interruptions interval by
        interval.  A run that does not repeat itself has no envelope: the least CPU time instead.
        """
        if self.deterministic:
            return float(self.wall.min(axis=0).sum()) * 1e-9
        return float(self.cpu.min()) * 1e-9

    @property
    def contention(self) -> float:
        """Median wall time over the envelope, minus 1: how much the machine disturbed the measurement."""
        envelope = float(self.wall.min(axis=0).sum())
        return statistics.median(self.wall.sum(axis=1).tolist()) / envelope - 1.0 if envelope else 0.0


@dataclass(frozen=True)
class Run:
    """One engine on one scene.

    Attributes
    ----------
    engine, version : str
    settings : dict
        Every knob with the value used.
    outcome : Trajectory, Refusal or Failure
    partial : Trajectory or None
        What had been computed when it failed.
    events : tuple of Impact
        Empty where the engine does not know them (`knows_events`).
    contacts : tuple of ContactForce
        Lasting contacts at the last sample, where the engine knows them.
    timing : Timing or None
    build_seconds : float
        From the scene to a world ready to advance [s].
    notes : tuple of str
        Approximations and remarks of the adapter.
    lead : float
        Time by which positions run ahead of velocities [s].
    audit : dict
        What the engine reports of its own soundness (residuals, budgets), where it does.
    output : str
        What the engine printed.
    """

    engine: str
    version: str
    settings: dict[str, Any]
    outcome: Trajectory | Refusal | Failure
    partial: Trajectory | None = None
    events: tuple[Impact, ...] = ()
    knows_events: bool = False
    contacts: tuple[ContactForce, ...] = ()
    timing: Timing | None = None
    build_seconds: float = 0.0
    notes: tuple[str, ...] = ()
    lead: float = 0.0
    audit: dict[str, float] = field(default_factory=dict)
    output: str = ""

    @property
    def trajectory(self) -> Trajectory | None:
        """The motion as far as it is known: whole, partial, or None."""
        return self.outcome if isinstance(self.outcome, Trajectory) else self.partial


def sample_times(duration: float, sampling: float) -> np.ndarray:
    """Times 0, sampling, 2 sampling ... duration [s]; the last interval may be shorter.

    Raises
    ------
    ValueError
        For a duration or an interval that is not finite and positive.
    """
    for name, value in (("duration", duration), ("sampling", sampling)):
        if not (math.isfinite(value) and value > 0.0):
            raise ValueError(f"{name} = {value!r} is not possible: a finite number > 0")
    count = round(duration / sampling)
    if abs(count * sampling - duration) <= 1e-9 * duration:
        return np.arange(count + 1) * sampling
    return np.append(np.arange(math.floor(duration / sampling) + 1) * sampling, duration)


def checked_times(times: Sequence[float]) -> np.ndarray:
    """`times` as an array.

    Raises
    ------
    ValueError
        If they are not at least two finite, increasing times from 0 on.
    """
    array = np.asarray(times, dtype=np.float64)
    if array.ndim != 1 or len(array) < 2 or not np.isfinite(array).all() or array[0] < 0 or (np.diff(array) <= 0).any():
        raise ValueError(f"times = {times!r} is not possible: at least two finite, increasing times >= 0")
    return array if array[0] == 0.0 else np.concatenate([[0.0], array])


def prepare(engine: Engine, scene: Scene) -> tuple[Any, tuple[str, ...]]:
    """Draft of the scene with every effect switched on, and the footnotes of what is approximated.

    Raises
    ------
    Refusal
        For an effect the engine does not list, and for whatever the adapter itself refuses.
    """
    for effect in scene.effects:
        if type(effect) not in engine.effects:
            known = ", ".join(sorted(kind.__name__ for kind in engine.effects))
            raise Refusal(f"{engine.name} has no {type(effect).__name__}; it has {known}")
    draft = engine.vacuum(scene)
    notes = [engine.effects[type(effect)](draft, effect) for effect in scene.effects]
    return draft, tuple(note for note in notes if note)


def run(
    engine: Engine,
    scene: Scene,
    times: Sequence[float],
    settings: Settings | None = None,
    repeats: int = 1,
    sampled: bool = True,
    until: Callable[[State], bool] | None = None,
) -> Run:
    """Run `scene` in `engine`, recording the state at `times` [s], or only up to the first for which `until` holds.

    With more than one repeat a warm-up precedes them, whose motion is kept and whose time is not; each repeat is built
    anew, because only a rebuilt world is the same world in every engine.  A run that takes longer than
    `LONG` even when it is warm is not repeated, and says so.

    Parameters
    ----------
    sampled : bool
        Whether the state is read at all times, or only at the first and the last, where `until` does not look at it.

    Raises
    ------
    ValueError
        For times or settings that are not possible; never because of what the engine does.
    """
    times = checked_times(times)
    chosen = checked_settings(engine, settings)
    ahead = lead(engine, settled(engine, chosen, scene))
    blank = Run(engine.name, engine.version, dict(chosen), Failure("error", "build", 0.0, ""), lead=ahead)
    return in_turns([partial(_attempt, engine, scene, times, chosen, blank, until)], repeats, sampled)[0]


def in_turns(cells: Sequence[Callable[[bool], Run]], repeats: int = 1, sampled: bool = True) -> list[Run]:
    """Runs of several cells in one sitting; with more than one repeat they are timed in turns, A B B A.

    Whatever slows the machine down for a while then slows all of them, and none is favoured by its place.  Everything
    runs once first: that is the motion that is kept, and it warms up.  What broke in it is not run again; what took
    longer than `LONG` is run once more, because an engine may compile itself in its first run, and not repeated if that
    is as long.  When it is timed, states are not read on the way: between two reads the caches are the engine's.

    Parameters
    ----------
    cells : sequence of functions
        Each runs its cell once, with states read at every sample or not; the timing of what it returns has one row.
    repeats : int
    sampled : bool
        Whether the first run is read at every sample.
    """
    first = [cell(sampled) for cell in cells]
    if repeats <= 1:
        return first
    warm = [
        cell(False) if _is_whole(run) and not _is_short(run) else run for cell, run in zip(cells, first, strict=True)
    ]
    timed: dict[int, list[Run]] = {k: [] for k, run in enumerate(warm) if _is_short(run)}
    for turn in range(repeats):
        for k in sorted(timed, reverse=turn % 2 == 0):
            if not timed[k] or _is_whole(timed[k][-1]):  # after a run that broke none is risked
                run = cells[k](False)  # of what ended well the motion is there already
                timed[k].append(replace(run, outcome=first[k].outcome) if _is_whole(run) else run)
    return [_timed(first[k], timed[k]) if k in timed else _untimed(first[k], warm[k]) for k in range(len(cells))]


def _is_whole(run: Run) -> bool:
    return isinstance(run.outcome, Trajectory)


def _is_short(run: Run) -> bool:
    return _is_whole(run) and run.timing is not None and int(run.timing.wall.sum()) <= LONG


def _untimed(first: Run, warm: Run) -> Run:
    """A run that is not repeated; one that came to its end twice says why."""
    if not _is_whole(warm) or warm.timing is None:
        return warm
    note = f"run twice, not timed: {warm.timing.wall.sum() * 1e-9:.0f} s"
    return replace(first, timing=warm.timing, notes=(*first.notes, note))


def _timed(first: Run, repeats: Sequence[Run]) -> Run:
    """The first run with the timings of the repeats, or the repeat that broke."""
    if not _is_whole(repeats[-1]):
        return repeats[-1]
    timings = [run.timing for run in repeats if run.timing is not None]
    wall, cpu = (np.concatenate([getattr(timing, name) for timing in timings]) for name in ("wall", "cpu"))
    return replace(first, timing=Timing(wall, cpu, tuple(d for timing in timings for d in timing.digests)))


def _attempt(
    engine: Engine,
    scene: Scene,
    times: np.ndarray,
    settings: Settings,
    blank: Run,
    until: Callable[[State], bool] | None,
    sampled: bool,
) -> Run:
    """One run from draft to last sample."""
    said: dict[str, Any] = {}
    states: list[State] = []
    wall: list[int] = []
    cpu = [0]
    stage = ["build"]
    world = None
    try:
        begun = time.perf_counter()
        draft, said["notes"] = prepare(engine, scene)
        stage[0] = "start"
        world = engine.start(draft, settings)
        said["build_seconds"] = time.perf_counter() - begun
        for state in _samples(engine, world, times, sampled or until is not None, stage, wall, cpu):
            states.append(state)
            if until is not None and until(state):
                break
        said |= _spoken(engine, world)
        outcome: Trajectory | Refusal | Failure = Trajectory.of(states)
    except Refusal as refusal:
        outcome = refusal
    except Exception as error:
        outcome = _failure(error, stage[0], states)
        said |= {"partial": Trajectory.of(states) if states else None}
    finally:
        if world is not None and hasattr(engine, "close"):
            with suppress(Exception):  # the answer is there; how the world ends does not change it
                engine.close(world)
    run = replace(blank, **said, outcome=outcome)
    if not wall:
        return run
    digests = (run.trajectory.digest(),) if run.trajectory is not None else ()
    return replace(run, timing=Timing(np.array([wall], dtype=np.int64), np.array(cpu, dtype=np.int64), digests))


def _samples(
    engine: Engine, world: Any, times: np.ndarray, sampled: bool, stage: list[str], wall: list[int], cpu: list[int]
) -> Iterator[State]:
    stage[0] = "read"
    yield engine.read(world)
    with _no_garbage_collection():
        for interval in np.diff(times).tolist():
            stage[0] = "advance"
            cpu_before, before = time.thread_time_ns(), time.perf_counter_ns()
            engine.advance(world, interval)
            wall.append(time.perf_counter_ns() - before)
            cpu[0] += time.thread_time_ns() - cpu_before
            if not sampled and len(wall) < len(times) - 1:
                continue
            stage[0] = "read"
            state = engine.read(world)
            if not (np.isfinite(state.x).all() and np.isfinite(state.v).all()
                    and np.isfinite(state.q).all() and np.isfinite(state.w).all()):  # fmt: skip
                raise Diverged("the state holds NaN or infinity")
            yield state


def _spoken(engine: Engine, world: Any) -> dict[str, Any]:
    said: dict[str, Any] = {}
    if hasattr(engine, "events"):
        said |= {"events": tuple(engine.events(world)), "knows_events": True}
    if hasattr(engine, "contacts"):
        said["contacts"] = tuple(engine.contacts(world))
    if hasattr(engine, "audit"):
        said["audit"] = {str(name): float(value) for name, value in engine.audit(world).items()}
    return said


def _failure(error: Exception, stage: str, states: list[State]) -> Failure:
    reached = states[-1].t if states else 0.0
    if isinstance(error, Diverged):
        return Failure("diverged", stage, reached, str(error))
    if isinstance(error, MemoryError):
        return Failure("oom", stage, reached, "out of memory")
    if isinstance(error, (BadScene, SceneError)):
        return Failure("error", stage, reached, str(error))
    where = traceback.extract_tb(error.__traceback__)[-1]
    return Failure("error", stage, reached, f"{type(error).__name__}: {error} ({where.name}, line {where.lineno})")


@contextmanager
def _no_garbage_collection() -> Iterator[None]:
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()
