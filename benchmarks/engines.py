"""The same scene in several engines, at the same sampling, each in its fair profile."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

from adapters import registry
from adapters.run import Run, checked_settings, prepare, run
from benchmarks.row import Beside
from mechanics.scene import Scene

REFERENCE = "reference"
FAIR = ("pybullet", "mujoco", "pymunk")  # their fair profiles; `plumbline describe` gives every setting with its reason


def played(scene: Scene, times: Sequence[float], engine: str = REFERENCE, repeats: int = 1) -> Run:
    """One engine on one scene at its default settings; more than one repeat follows a discarded warm-up."""
    return run(registry.engine(engine), scene, times, repeats=repeats)


def alongside(
    scene: Scene,
    times: Sequence[float],
    error: Callable[[Run], float],
    engines: Sequence[str] = FAIR,
    repeats: int = 1,
) -> tuple[Beside, ...]:
    """What each engine makes of a scene: its error, and what that cost."""
    return tuple(_beside(name, scene, times, error, repeats) for name in engines)


def unread(scene: Scene, times: Sequence[float], engine: str = REFERENCE) -> float:
    """Wall time from each of `times` to the next, where nobody reads a state [s]; the least of two, after a warm-up.

    The reference is called without its adapter, which asks it for the state every time.
    """
    chosen, spent = registry.engine(engine), []
    for _ in range(3):
        draft, _notes = prepare(chosen, scene)
        world = chosen.start(draft, checked_settings(chosen, None))
        advance: Callable[[Any, float], None] = chosen.advance
        if engine == REFERENCE:
            from reference_impl.simulate import advance
        begun = time.perf_counter()
        for before, after in pairwise(times):
            advance(world, after - before)
        spent.append(time.perf_counter() - begun)
        if hasattr(chosen, "close"):
            chosen.close(world)
    return min(spent[1:])


def beside(found: Run, error: Callable[[Run], float]) -> Beside:
    """A run as it stands in a table: an answer with its error and cost, or why there is none."""
    if found.timing is None or found.outcome is not found.trajectory:
        return Beside(found.engine, note=found.outcome.reason)
    return Beside(found.engine, float(error(found)), found.timing.seconds)


def _beside(name: str, scene: Scene, times: Sequence[float], error: Callable[[Run], float], repeats: int) -> Beside:
    try:
        found = played(scene, times, name, repeats)
    except registry.Unavailable as missing:
        return Beside(name, note=missing.reason)
    return beside(found, error)


def fastest(found: Sequence[Beside]) -> Beside:
    """The engine that answered in the least time.

    Raises
    ------
    ValueError
        If none answered.
    """
    answered = [b for b in found if math.isfinite(b.seconds)]
    if not answered:
        raise ValueError(f"no engine answered: {', '.join(f'{b.engine}: {b.note}' for b in found)}")
    return min(answered, key=lambda b: b.seconds)
