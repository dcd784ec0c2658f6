"""Only the effects a scene calls for: is the answer the same without the others, and what do they cost?

One engine runs the scene as it is declared, once with each undeclared effect switched on so that it does nothing, once
with all of these, and once without each declared one (`variants`).  Two runs are compared by how far apart any body
is, and how fast it parts, as shares of how far and how fast the bodies move at all.  They are the same if that is
below `SAME`, which allows a thousandfold growth of the tolerance of 1e-12 with which the reference finds contacts and
integrates lasting ones; and different if it is above `CHANGED`.

Where rounding grows, as in collisions of many balls, two sound runs part sooner or later.  Then the scene is run once
more from a start shifted by rounding: what happens to that happens to any comparison, and the runs are the same for
as long as that one is.

Speed is CPU time of `advance` over the same samples, as a ratio of interleaved runs in one process.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from adapters.engine import Engine, Refusal, Settings
from adapters.run import Failure, Run, in_turns, run, sample_times
from comparisons.variants import Room, idle, idle_in, shaken, without
from mechanics.arrays import SceneError
from mechanics.effects import EFFECTS, Effect
from mechanics.rotation import angle_between
from mechanics.scene import Scene
from mechanics.shapes import bounding_radius
from mechanics.trajectory import State, Trajectory
from scenarios.scenario import Scenario

SAME = 1e-9  # largest difference of two equal motions, as a share of the motion
CHANGED = 1e-6  # least difference of two different ones
ALL = "everything else"
SWITCHES = "own switches"  # of an engine, which it has turned off where a scene does not call for what they do
CLOCK = 3.0  # CPU time that timed runs may take [s]; rounds are as many as fit, but one at the least
LEAST = 0.1  # CPU time below which nothing is slow [s]
ROUNDS = 7  # timed rounds at the most
SLOW = 4.0  # how many times slower than the scene as declared a variant may be until it is cut short
VERDICTS = {
    "same": "the motion is the same",
    "same until": "the motion is the same for as long as rounding allows, or for as long as the run got",
    "changes": "the motion is another one",
    "missing": "the engine stops and names the effect",
    "demanded": "the scene is not possible without it",
    "refused": "the engine refuses the scene",
    "differs": "the motion is neither the same nor clearly another one",
    "broke": "the run failed",
}


@dataclass(frozen=True)
class Row:
    """What one effect, switched on or left out, does to one scene in one engine.

    Attributes
    ----------
    effect : str
        Name of the effect, or `ALL`; `SWITCHES` for the scene as declared in an engine that has all of its own on.
    declared : bool
        Whether the scene declares it: then it was left out, else switched on.
    verdict : str
        One of `VERDICTS`.
    difference : float
        Largest difference while both ran, as a share of the motion; NaN without a motion to compare.
    time : float
        Until when both are the same [s], or from when on they are not.
    ratio : float
        CPU time with the effect over CPU time without it; NaN if it was not measured.
    rounds : int
        Timed runs of each.
    text : str
        What the engine said.
    """

    effect: str
    declared: bool
    verdict: str
    difference: float = math.nan
    time: float = math.nan
    ratio: float = math.nan
    rounds: int = 0
    text: str = ""


@dataclass(frozen=True)
class Proof:
    """What was found for one scenario in one engine.

    Attributes
    ----------
    scenario, engine, version : str
    duration : float
        Of the scenario [s].
    until : float
        Up to when everything was compared [s]; less than `duration` if the budget was spent.
    cost : float
        CPU time of the declared scene per second of its own time [s/s].
    rows : tuple of Row
    reason : str
        Why there is nothing to compare; "" if there is.
    """

    scenario: str
    engine: str
    version: str
    duration: float
    until: float
    cost: float
    rows: tuple[Row, ...]
    reason: str = ""

    @property
    def whole(self) -> bool:
        """Whether it was compared to the end."""
        return _reaches(self.until, self.duration)


def to_plain(proof: Proof) -> dict[str, Any]:
    """For JSON: NaN becomes null."""
    told = asdict(proof)
    for part in (told, *told["rows"]):
        part |= {name: None for name, value in part.items() if isinstance(value, float) and math.isnan(value)}
    return told


def from_plain(told: Mapping[str, Any]) -> Proof:
    """Proof of what `to_plain` wrote.

    Raises
    ------
    TypeError
        For a field that is missing or unknown.
    """
    rows = [Row(**{name: math.nan if value is None else value for name, value in row.items()}) for row in told["rows"]]
    kept = {name: math.nan if value is None else value for name, value in told.items() if name != "rows"}
    return Proof(**kept, rows=tuple(rows))


@dataclass(frozen=True)
class Bench:
    """One scenario in one engine with what all comparisons of it share."""

    engine: Engine
    scenario: Scenario
    settings: Settings | None
    times: np.ndarray
    declared: Run  # the scene as declared, at `times`
    room: Room
    clock: float

    @property
    def whole(self) -> bool:
        """Whether the budget reaches to the end."""
        return _reaches(self.times[-1], self.scenario.duration)

    def run(self, scene: Scene, until: Callable[[State], bool] = lambda _: False, engine: Engine | None = None) -> Run:
        """A run of a variant of the scene, up to where `until` holds or it takes `SLOW` times as long.

        What is too slow is tried once more: the first run of a variant may spend its time on compiling.
        """
        for _ in range(2):
            deadline = Deadline(SLOW * max(_seconds(self.declared), LEAST))
            found = run(
                engine or self.engine, scene, self.times, self.settings,
                until=lambda s, d=deadline: until(s) or d.passed(),
            )  # fmt: skip
            if not deadline.over:
                break
        return found


class Deadline:
    """An amount of CPU time of this thread, from now on [s]; `over` says whether it was found to have passed."""

    def __init__(self, seconds: float) -> None:
        self.end, self.over = time.thread_time() + seconds, False

    def passed(self) -> bool:
        """Whether it has passed."""
        self.over = time.thread_time() > self.end
        return self.over


def prove(
    engine: Engine, scenario: Scenario, budget: float = 1.0, clock: float = CLOCK, settings: Settings | None = None
) -> Proof:
    """What the effects of `scenario` do in `engine`.

    Parameters
    ----------
    budget : float
        CPU time the declared scene may take; what it reaches by then is what is compared [s].
    clock : float
        CPU time that timed runs may take [s], at least one round is run; 0: no speed is measured.
    """
    blank = Proof(scenario.name, engine.name, str(engine.version), scenario.duration, 0.0, math.nan, ())
    bench = _bench(engine, scenario, budget, clock, settings)
    if isinstance(bench, str):
        return replace(blank, reason=bench)
    until = float(bench.times[-1])
    cost = bench.declared.timing.cpu.min() * 1e-9 / until if bench.declared.timing is not None else math.nan
    return replace(blank, until=until, cost=cost, rows=tuple(_rows(bench)))


def _bench(engine: Engine, scenario: Scenario, budget: float, clock: float, settings: Settings | None) -> Bench | str:
    """The scene as declared as far as the budget reaches, or why it does not run."""
    if not scenario.scene.moving:
        return "nothing in the scene has a mass"
    times, reached = sample_times(scenario.duration, scenario.sampling), 0
    while True:
        deadline = Deadline(budget)
        declared = run(engine, scenario.scene, times, settings, until=lambda _, d=deadline: d.passed())
        if not isinstance(declared.outcome, Trajectory):
            return _said(declared)
        if not deadline.over or len(declared.outcome) < 1.5 * reached:
            break
        reached = len(declared.outcome)  # the first run may have spent its time on compiling: a later one gets farther
    times = times[: len(declared.outcome)]
    if len(times) < 2:
        return f"the first sample takes longer than {budget:g} s"
    room = Room.of(scenario.scene, declared.outcome)
    return Bench(engine, scenario, settings, times, declared, room, clock)


def _rows(bench: Bench) -> Iterator[Row]:
    """Rows of all effects, of everything at once, and of the engine's own switches where it has any."""
    scene, found, quiet = bench.scenario.scene, [], []
    for name, kind in EFFECTS.items():
        if kind in scene.needs:
            found.append(_left_out(bench, kind))
            continue
        found.append(_switched_on(bench, name, idle(scene, kind, bench.room)))
        if found[-1][0].verdict.startswith("same"):
            quiet.append(kind)
    found.append(_switched_on(bench, ALL, idle_in(scene, tuple(quiet), bench.room)))
    all_on: Engine | None = getattr(bench.engine, "all_on", None)
    if all_on is not None:
        found.append((_compared(bench, SWITCHES, False, bench.run(scene, engine=all_on)), Variant(scene, all_on)))
    ratios = iter(_ratios(bench, [variant for row, variant in found if row.verdict == "same"]))
    for row, _ in found:
        if row.verdict != "same":
            yield row
            continue
        ratio, rounds = next(ratios)
        yield replace(row, ratio=1.0 / ratio if row.declared else ratio, rounds=rounds)


class Variant(NamedTuple):
    """A scene in an engine."""

    scene: Scene
    engine: Engine


def _left_out(bench: Bench, kind: type[Effect]) -> tuple[Row, Variant]:
    """What is missing without a declared effect; the run ends as soon as it is clear that something is."""
    name, scene = kind.__name__, bench.scenario.scene
    try:
        scene = without(scene, kind)
    except SceneError as error:
        return Row(name, True, "demanded", time=0.0, text=str(error)), Variant(scene, bench.engine)
    return _compared(bench, name, True, bench.run(scene, Gauge(bench).changed)), Variant(scene, bench.engine)


def _switched_on(bench: Bench, name: str, scene: Scene) -> tuple[Row, Variant]:
    return _compared(bench, name, False, bench.run(scene)), Variant(scene, bench.engine)


def _compared(bench: Bench, name: str, declared: bool, found: Run) -> Row:
    """The verdict on a variant that ran, or on how it did not."""
    if isinstance(found.outcome, Refusal):
        return Row(name, declared, "refused", text=found.outcome.reason)
    if isinstance(found.outcome, Failure):
        missing = declared and f"does not declare {name}" in found.outcome.reason
        return Row(name, declared, "missing" if missing else "broke", time=found.outcome.time, text=_said(found))
    apart = Gauge(bench).apart(found)
    end, worst = float(bench.times[len(apart) - 1]), float(apart.max())
    if worst <= SAME:
        text = "" if len(apart) == len(bench.times) else f"cut short: {SLOW:g} times slower than the scene as declared"
        if declared and not text and not bench.whole:
            text = "what comes later the budget leaves open"
        return Row(name, declared, "same until" if text else "same", worst, end, text=text)
    first = int(np.argmax(apart > SAME))
    rounding = _rounding(bench, first if declared else 2 * first)
    if first > 0 and rounding:
        before = float(apart[:first].max())
        return Row(name, declared, "same until", before, float(bench.times[first - 1]), text=rounding)
    verdict = "changes" if worst > CHANGED else "differs"
    return Row(name, declared, verdict, worst, float(bench.times[first]))


def _rounding(bench: Bench, sample: int) -> str:
    """What rounding does to two runs of the declared scene, if it parts them by the time of `sample`."""
    found = bench.run(shaken(bench.scenario.scene, bench.room))
    if not isinstance(found.outcome, Trajectory):
        return ""
    beyond = np.flatnonzero(Gauge(bench).apart(found) > SAME)
    if not len(beyond) or beyond[0] > sample:
        return ""
    return f"a start shifted by rounding parts by {SAME:g} at t = {bench.times[beyond[0]]:.4g} s"


class Gauge:
    """How far a motion is from the declared one, as a share of the motion.

    Places count over how far bodies get from their start and the radius of the smallest, velocities over the fastest
    there is and what falling that radius gives; turns count by what they do to a body's surface.  Velocities are left
    out at samples within `NEAR` of an impact that the engine reports: the sides of an impact are not the same.
    """

    NEAR = 1e-6  # of the time compared

    def __init__(self, bench: Bench) -> None:
        scene, motion = bench.scenario.scene, bench.declared.outcome
        assert isinstance(motion, Trajectory)
        self.rows, self.motion = list(scene.moving), motion
        self.radius = np.array([bounding_radius(scene.bodies[i].shape) for i in self.rows])
        x, v, w = (getattr(motion, name)[:, self.rows] for name in ("x", "v", "w"))
        self.length = float(np.linalg.norm(x - x[0], axis=2).max() + self.radius.min())
        turning = (np.linalg.norm(w, axis=2) * self.radius).max()
        fall = math.sqrt(2.0 * float(np.linalg.norm(scene.gravity)) * float(self.radius.min()))
        self.speed = float(np.linalg.norm(v, axis=2).max() + turning + fall) or 1.0
        self.events, self.near = [e.time for e in bench.declared.events], self.NEAR * float(motion.t[-1])

    def apart(self, found: Run) -> np.ndarray:
        """(T,) difference of a run from the declared one at each sample both have."""
        motion = found.outcome
        assert isinstance(motion, Trajectory)
        times = np.array([*self.events, *(e.time for e in found.events), -math.inf])
        return np.array([self._apart(motion.at(k), k, times) for k in range(len(motion))])

    def changed(self, state: State) -> bool:
        """Whether a state of a run that is under way is clearly another one than the declared at its time."""
        k = min(int(np.searchsorted(self.motion.t, state.t - self.near)), len(self.motion) - 1)
        return self._apart(state, k, np.array([*self.events, -math.inf])) > CHANGED

    def _apart(self, state: State, k: int, events: np.ndarray) -> float:
        own, rows = self.motion.at(k), self.rows
        away = np.linalg.norm(state.x[rows] - own.x[rows], axis=1)
        turned = angle_between(state.q[rows], own.q[rows]) * self.radius
        places = float((away + turned).max()) / self.length
        if np.abs(events - own.t).min() <= self.near:
            return places
        parting = np.linalg.norm(state.v[rows] - own.v[rows], axis=1)
        turning = np.linalg.norm(state.w[rows] - own.w[rows], axis=1) * self.radius
        return max(places, float((parting + turning).max()) / self.speed)


def _ratios(bench: Bench, variants: list[Variant]) -> list[tuple[float, int]]:
    """CPU time of each variant over that of the declared scene, and how many rounds they were run in turns."""
    if not bench.clock:
        return [(math.nan, 0) for _ in variants]
    every = [Variant(bench.scenario.scene, bench.engine), *variants]
    rounds = int(min(max(bench.clock / max(len(every) * _seconds(bench.declared), 1e-9), 1), ROUNDS))
    cells = [partial(run, one.engine, one.scene, bench.times, bench.settings) for one in every]
    own, *others = (_seconds(found) for found in in_turns(cells, rounds))
    return [(other / own if own else math.nan, rounds) for other in others]


def _reaches(time: float, end: float) -> bool:
    return bool(time >= end * (1.0 - 1e-9))


def _seconds(found: Run) -> float:
    return float(found.timing.cpu.min()) * 1e-9 if found.timing is not None else 0.0


def _said(found: Run) -> str:
    outcome = found.outcome
    if isinstance(outcome, Failure):
        return f"{outcome.state} at t = {outcome.time:.6g} s: {outcome.reason}"
    return outcome.reason if isinstance(outcome, Refusal) else ""
