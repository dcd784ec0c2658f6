"""How far timings can be trusted here and now: work timed against the same work, and against a tenth more of it.

A trial is a sitting of three pieces of work in turns, as `adapters.run.in_turns` times engines: A, B, which is the
same, and C, which is a tenth more.  Over many trials the ratios B/A say how large a difference has to be before it
means anything, and the ratios C/A how often a real one would be seen.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from adapters.run import Timing

REPEATS = (3, 5, 9)  # of engines; the first as `plumbline run` takes them unless it is told otherwise
INTERVALS, UNITS = 50, 10  # in a repeat, and units of work in an interval
MORE = 0.1  # what C does more
GATES = (0.01, 0.02, 0.03, 0.05, 0.075, 0.1, 0.15, 0.2, 0.3)  # relative differences that could be taken for real ones
LEAST = 10  # trials


class Statistic(NamedTuple):
    """A way to make one number of the timing of several repeats."""

    name: str
    repeats: int
    of: Callable[[Timing], float]


ENVELOPES = tuple(Statistic(f"envelope of {n}", n, lambda timing: timing.seconds) for n in REPEATS)
STATISTICS = (
    *ENVELOPES,
    Statistic(f"CPU time, least of {REPEATS[0]}", REPEATS[0], lambda timing: float(timing.cpu.min())),
    Statistic(f"wall time, least of {REPEATS[0]}", REPEATS[0], lambda timing: float(timing.wall.sum(axis=1).min())),
    Statistic(f"wall time, mean of {REPEATS[0]}", REPEATS[0], lambda timing: float(timing.wall.mean())),
)


@dataclass(frozen=True)
class Noise:
    """What the trials gave.

    Attributes
    ----------
    same, more : mapping of str to (trials,) array
        By statistic: time of B over that of A, and time of C over that of A.
    contention : float
        Median over the trials of the contention of A.
    """

    same: Mapping[str, np.ndarray]
    more: Mapping[str, np.ndarray]
    contention: float

    @property
    def trials(self) -> int:
        """How many trials there were."""
        return len(self.same[ENVELOPES[0].name])

    def alarms(self, statistic: str, gate: float) -> float:
        """Share of the trials in which identical work differed by more than `gate`, either way."""
        ratio = self.same[statistic]
        return float((np.maximum(ratio, 1.0 / ratio) > 1.0 + gate).mean())

    def seen(self, statistic: str, gate: float) -> float:
        """Share of the trials in which the work that was a tenth more took longer by more than `gate`."""
        return float((self.more[statistic] > 1.0 + gate).mean())

    def gate(self, statistic: str) -> float:
        """The smallest of `GATES` that identical work never passed; infinite if there is none."""
        return next((gate for gate in GATES if not self.alarms(statistic, gate)), math.inf)

    def told(self) -> dict[str, object]:
        """For programs."""
        rates = {
            name: {
                "gate": self.gate(name) if self.gate(name) < math.inf else None,
                "alarms": {f"{gate:g}": self.alarms(name, gate) for gate in GATES},
                "seen": {f"{gate:g}": self.seen(name, gate) for gate in GATES},
            }
            for name in self.same
        }
        return {"trials": self.trials, "contention": self.contention, "statistics": rates}

    def verdict(self) -> str:
        """What follows, in a sentence: the least repeats whose envelope tells `MORE` from nothing."""
        busy = f", busy as it is (contention {self.contention:.0%})," if self.contention > 0.25 else ""
        for envelope in ENVELOPES:
            gate = self.gate(envelope.name)
            if gate < MORE:
                seen = self.seen(envelope.name, gate)
                return (
                    f"this machine{busy} supports a gate of {100.0 * gate:g} % with --repeats {envelope.repeats}: "
                    f"a real +{MORE:.0%} is seen in {seen:.0%} of comparisons"
                )
        return f"do not trust timings now: this machine{busy} cannot tell +{MORE:.0%} from nothing"


def unit(state: np.ndarray) -> np.ndarray:
    """A piece of work of about 10 µs that is the same every time."""
    for _ in range(2):
        state = state @ state
        state = state / np.abs(state).max()
    return state


def measured(seconds: float) -> Noise:
    """The noise of this machine, from trials for so many seconds, at least `LEAST` of them."""
    same: dict[str, list[float]] = {statistic.name: [] for statistic in STATISTICS}
    more: dict[str, list[float]] = {statistic.name: [] for statistic in STATISTICS}
    contention: list[float] = []
    end = time.monotonic() + seconds
    while time.monotonic() < end or len(contention) < LEAST:
        timings = sitting((UNITS, UNITS, round((1.0 + MORE) * UNITS)))
        for name, repeats, of in STATISTICS:
            a, b, c = (of(first(timing, repeats)) for timing in timings)
            same[name].append(b / a)
            more[name].append(c / a)
        contention.append(timings[0].contention)
    arrays = ({name: np.array(values) for name, values in ratios.items()} for ratios in (same, more))
    return Noise(*arrays, float(np.median(contention)))


def first(timing: Timing, repeats: int) -> Timing:
    """The timing of the first so many repeats."""
    return Timing(timing.wall[:repeats], timing.cpu[:repeats], timing.digests[:repeats])


def sitting(works: tuple[int, ...]) -> list[Timing]:
    """Timings of pieces of work, so many units an interval each, in turns A B C C B A."""
    most = REPEATS[-1]
    rows: list[list[tuple[list[int], int]]] = [[] for _ in works]
    for turn in range(1 + most):  # the first one warms up
        for k in sorted(range(len(works)), reverse=turn % 2 == 1):
            rows[k].append(_clocked(works[k]))
    return [
        Timing(np.array([wall for wall, _ in found[1:]]), np.array([cpu for _, cpu in found[1:]]), ("same",) * most)
        for found in rows
    ]


def _clocked(units: int) -> tuple[list[int], int]:
    """Wall times of the intervals and CPU time of all of them [ns]."""
    state, wall = np.random.default_rng(1).normal(size=(24, 24)), []
    cpu = time.thread_time_ns()
    for _ in range(INTERVALS):
        before = time.perf_counter_ns()
        for _ in range(units):
            state = unit(state)
        wall.append(time.perf_counter_ns() - before)
    return wall, time.thread_time_ns() - cpu
