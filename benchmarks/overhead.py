"""What the house adds to the clocked loop: engines driven through their adapters, and by bare calls of their libraries.

Both take the same steps in worlds built alike, in turns, clocked from sample to sample; their envelopes are compared.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from importlib import import_module
from typing import Any

import numpy as np

from adapters import registry
from adapters.engine import Clock, checked_settings
from adapters.run import prepare, sample_times
from benchmarks.engines import FAIR
from benchmarks.row import Figure, Row
from scenarios import catalogue

SCENES = ("bouncing-ball[]", "sliding-block[]")  # the cheapest steps there are, and dearer ones
REPEATS = 25  # more than elsewhere: a percent is looked for


def bare_mujoco(world: Any) -> Callable[[int], None]:
    """Steps by `mj_step` alone."""
    step, model, data = import_module("mujoco").mj_step, world.model, world.data
    return lambda steps: step(model, data, nstep=steps)


def bare_pybullet(world: Any) -> Callable[[int], None]:
    """Steps by `stepSimulation` alone."""
    step, client = import_module("pybullet").stepSimulation, world.client

    def go(steps: int) -> None:
        for _ in range(steps):
            step(client)

    return go


def bare_pymunk(world: Any) -> Callable[[int], None]:
    """Steps by `Space.step` alone, without substeps."""
    step, h = world.space.step, world.clock.dt

    def go(steps: int) -> None:
        for _ in range(steps):
            step(h)

    return go


BARE: dict[str, Callable[[Any], Callable[[int], None]]] = {
    "mujoco": bare_mujoco,
    "pybullet": bare_pybullet,
    "pymunk": bare_pymunk,
}


def clocked(go: Callable[[Any], None], pieces: list[Any]) -> list[int]:
    """Wall time of `go` on each of the pieces [ns]."""
    spent = []
    for piece in pieces:
        before = time.perf_counter_ns()
        go(piece)
        spent.append(time.perf_counter_ns() - before)
    return spent


def envelopes(name: str, scenario: Any, repeats: int) -> tuple[float, float, int, int]:
    """Envelopes of an engine through its adapter and bare [s], and how many intervals and steps there are.

    Raises
    ------
    ArithmeticError
        If the two do not end in the same state.
    """
    engine = registry.engine(name)
    intervals = np.diff(sample_times(scenario.duration, scenario.sampling)).tolist()
    clock = Clock(float(checked_settings(engine, None)["dt"]))
    steps = [clock.steps(interval) for interval in intervals]
    spent: dict[bool, list[list[int]]] = {True: [], False: []}
    for turn in range(repeats + 1):
        ends = {}
        for bare in sorted(spent, reverse=turn % 2 == 0):
            draft, _ = prepare(engine, scenario.scene)
            world = engine.start(draft, checked_settings(engine, None))
            go, pieces = (BARE[name](world), steps) if bare else (partial(engine.advance, world), intervals)
            spent[bare].append(clocked(go, pieces))
            ends[bare] = engine.read(world).x
            if hasattr(engine, "close"):
                engine.close(world)
        if not np.array_equal(ends[True], ends[False]):
            raise ArithmeticError(f"{name} on {scenario.name}: bare calls end elsewhere than the adapter")
    house, alone = (1e-9 * float(np.min(spent[bare][1:], axis=0).sum()) for bare in (False, True))
    return house, alone, len(intervals), sum(steps)


def measure(tiny: bool = False) -> Row:
    """Every engine that has bare calls, on a cheap scene and on a dearer one."""
    figures, calls, repeats = [], [], 2 if tiny else REPEATS
    for label in SCENES[:1] if tiny else SCENES:
        (scenario,) = catalogue.find(label)
        for name in FAIR:
            house, alone, intervals, steps = envelopes(name, scenario, repeats)
            each = 1e6 * (house - alone) / intervals
            what = f"{name}, {scenario.family}, {steps / intervals:.0f} steps of {1e6 * alone / steps:.2g} µs a call"
            figures.append(Figure(what, house / alone - 1.0, 0.02))
            calls.append(f"{name} {each:.2g}")
    return Row(
        name="overhead",
        subject="what the house adds to the clocked loop, relative",
        figures=tuple(figures),
        how="`advance` of the adapter against bare calls of the library, the same steps to the same state, in turns, "
        f"envelopes of {repeats} repeats; microseconds a call: {', '.join(calls)}",
        missed="half a microsecond to one a call, for the arithmetic of the clock and for looking up the world, is "
        "more than 2 % of a call that does less than 25 to 50 µs of work: ten steps of a single body",
    )
