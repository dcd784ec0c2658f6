"""Accuracy against time: what each engine achieved at each of its settings, and what it cost.

A point is one cell: the error is the *relative place error* (see `comparisons.place`), measured against the
truth and never the tolerance that was asked for; the cost is the envelope of CPU time per simulated second.
Where the scenario was run at several phases of a step the worst phase counts, because nobody chooses the
phase.  A curve is a ladder of one knob, everything else being equal, in the order coarse to fine: with
contacts errors are not monotone, and a loop is information.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from comparisons.cell import Campaign, Cell
from comparisons.order import Alarm, Order, alarms, observed_order
from comparisons.pareto import NOWHERE, Pair, Reach, reach

ERROR = "relative place error"
TARGETS = (1e-2, 1e-3, 1e-4, 1e-6)
WHOLE = ("ok", "fail", "xfail", "xpass")  # the run came to its end: only then is an error an error of the whole motion
SHORTER_STEPS = ("dt", "substeps")  # knobs whose ladder has an order of convergence
LEAST_RUNGS = 3  # values of a knob that make a ladder


@dataclass(frozen=True)
class Point:
    """One engine at one setting on one scenario.

    Attributes
    ----------
    cell : Cell
    error : float
        At the worst phase; NaN if there is none: the run broke, was refused, or could not be judged.
    spread : tuple of float
        Least, median and largest error over the phases of a step.
    cost : float
        CPU milliseconds per simulated second; NaN if it was not measured.
    """

    cell: Cell
    error: float
    spread: tuple[float, float, float]
    cost: float

    @staticmethod
    def of(cell: Cell) -> Point:
        """Point of a cell."""
        row = cell.of(ERROR)
        values = cell.phases.get(ERROR) or (row.value if row is not None else math.nan,)
        known = cell.state in WHOLE and not any(math.isnan(v) for v in values)
        spread = (min(values), statistics.median(values), max(values)) if known else (math.nan,) * 3
        return Point(cell, spread[2], spread, 1e3 * cell.cost)

    @property
    def whole(self) -> bool:
        """Whether it has both an error and a cost: one is never shown without the other."""
        return math.isfinite(self.error) and math.isfinite(self.cost)

    @property
    def broke(self) -> bool:
        """Whether the engine began and did not come to the end."""
        return self.cell.state in ("diverged", "crash", "timeout", "oom") or (
            self.cell.state == "error" and self.cell.stage != "judge"
        )

    @property
    def pair(self) -> Pair:
        """Cost and error; infinite both, and so on no front, if one of them is missing."""
        return (self.cost, self.error) if self.whole else (math.inf, math.inf)


@dataclass(frozen=True)
class Curve:
    """A ladder of one knob.

    Attributes
    ----------
    knob : str
    others : dict
        The other settings, which are the same on all rungs.
    points : tuple of Point
        Coarse to fine.
    """

    knob: str
    others: Mapping[str, float | str]
    points: tuple[Point, ...]

    @property
    def whole(self) -> tuple[Point, ...]:
        """Points with error and cost, coarse to fine."""
        return tuple(p for p in self.points if p.whole)

    @property
    def steps(self) -> tuple[float, ...]:
        """What gets smaller from rung to rung: the time step, or one over the number of sub-steps, or of iterations."""
        values = [float(p.cell.settings[self.knob]) for p in self.points]
        rising = len(values) > 1 and values[-1] > values[0]
        return tuple(1.0 / v for v in values) if rising else tuple(values)

    @cached_property
    def order(self) -> Order | None:
        """Observed order of convergence; None for a knob that has none (iterations, tolerances)."""
        return observed_order(self.steps, [p.error for p in self.points]) if self.knob in SHORTER_STEPS else None

    @cached_property
    def alarms(self) -> tuple[Alarm, ...]:
        """Where finer is worse, the gravest first; steps as in `steps`."""
        if not self.knob:
            return ()
        return alarms(self.steps, [math.inf if p.broke else p.error for p in self.points])


@dataclass(frozen=True)
class Frontier:
    """Everything one engine was measured at on one scenario.

    Attributes
    ----------
    scenario, engine : str
    curves : tuple of Curve
        The main ladder first; every point is on a curve of its own if on no other.
    default : Point or None
        At the default settings.
    """

    scenario: str
    engine: str
    curves: tuple[Curve, ...]
    default: Point | None

    @cached_property
    def points(self) -> tuple[Point, ...]:
        """Every point once."""
        return tuple({p.cell.key: p for curve in self.curves for p in curve.points}.values())

    @property
    def main(self) -> Curve:
        """The curve of the engine's first ladder."""
        return self.curves[0]

    @property
    def best(self) -> Point | None:
        """The point with the least error."""
        return min((p for p in self.points if p.whole), key=lambda p: p.error, default=None)

    @property
    def answered(self) -> bool:
        """Whether the engine was put to the question at any setting."""
        return any(p.cell.state in WHOLE or p.broke for p in self.points)

    @property
    def unrun(self) -> int:
        """Settings that were planned and not run: what they would reach is not known."""
        return sum(p.cell.state == "not-run" for p in self.points)

    @property
    def absent(self) -> tuple[str, str]:
        """State and reason of an engine that did not answer (refused, not installed, not run); empty if it did."""
        if self.answered:
            return "", ""
        cell = next((p.cell for p in self.points if p.cell.state != "not-run"), self.points[0].cell)
        return cell.state, cell.reason

    def reach(self, target: float) -> tuple[Reach, Point | None]:
        """The least cost [CPU ms/s] at which the engine comes down to `target`, and the measured point that does.

        Each curve is bracketed on its own (`pareto.reach`); the cheapest counts.
        """
        found: tuple[Reach, Point | None] = (NOWHERE, None)
        for curve in self.curves:
            this = reach([p.pair for p in curve.points], target)
            if this.how and not found[0].cost <= this.cost:
                found = this, curve.points[this.place]
        return found

    def cheapest(self, target: float) -> Point | None:
        """The cheapest measured point within `target`, without interpolation: a setting that can be used as it is."""
        return min((p for p in self.points if p.whole and p.error <= target), key=lambda p: p.cost, default=None)


def frontiers(campaign: Campaign) -> tuple[Frontier, ...]:
    """Frontiers of a campaign by scenario and engine, in the order in which they were run.

    Scenarios of which no cell has an error have none: their question is not where bodies are.
    """
    asked = {c.scenario for c in campaign.cells if c.of(ERROR) is not None}
    groups: dict[tuple[str, str], list[Cell]] = {}
    for cell in campaign.cells:
        if cell.scenario in asked:
            groups.setdefault((cell.scenario, cell.engine), []).append(cell)
    return tuple(_frontier(cells, campaign.engines.get(engine, {})) for (_, engine), cells in groups.items())


def _frontier(cells: Sequence[Cell], told: Mapping) -> Frontier:
    points = [Point.of(cell) for cell in cells]
    default = next((p for p in points if dict(p.cell.settings) == dict(told.get("settings", {}))), None)
    found = _curves(points, told)
    on_some = {p.cell.key for curve in found for p in curve.points}
    found += [Curve("", dict(p.cell.settings), (p,)) for p in points if p.cell.key not in on_some]
    return Frontier(cells[0].scenario, cells[0].engine, tuple(found), default)


def _curves(points: Sequence[Point], told: Mapping) -> list[Curve]:
    """Ladders of at least `LEAST_RUNGS` values of one knob with all others equal; those at the defaults first.

    Only values of the ladder that the engine declares are rungs: a default that lies between two of them, 4 % from
    one, would say nothing of how errors fall.
    """
    knobs, defaults = told.get("knobs", {}), told.get("settings", {})
    found = []
    for knob, ladder in knobs.items():
        if any(isinstance(v, str) for v in ladder):
            continue
        groups: dict[tuple, list[Point]] = {}
        for point in points:
            if point.cell.settings.get(knob) in ladder:
                others = {k: v for k, v in point.cell.settings.items() if k != knob}
                groups.setdefault(tuple(sorted(others.items())), []).append(point)
        found += [_curve(knob, own, ladder[0] > ladder[-1]) for own in groups.values() if len(own) >= LEAST_RUNGS]
    return sorted(found, key=lambda curve: _changed(curve.others, defaults))


def _curve(knob: str, points: Iterable[Point], falling: bool) -> Curve:
    ordered = sorted(points, key=lambda p: float(p.cell.settings[knob]), reverse=falling)
    others = {k: v for k, v in ordered[0].cell.settings.items() if k != knob}
    return Curve(knob, others, tuple(ordered))


def _changed(others: Mapping, defaults: Mapping) -> int:
    return sum(defaults.get(name) != value for name, value in others.items())
