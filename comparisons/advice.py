"""Advice: the cheapest setting that was measured to be accurate enough, and what is wrong with the default.

From measured points only: nothing is interpolated, because a setting that nobody ran is no advice.  Costs within
a factor of `wins.MARGIN` cannot be told apart, and then the default is preferred.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from comparisons.frontier import Frontier, Point
from comparisons.wins import MARGIN


@dataclass(frozen=True)
class Choice:
    """One engine with its cheapest setting within the error that is asked for."""

    engine: str
    point: Point
    default: Point | None

    @property
    def passes(self) -> bool:
        """Whether this setting is within every tolerance of the scenario, too: place is not all there is."""
        return self.point.cell.state in ("ok", "xpass")


@dataclass(frozen=True)
class Advice:
    """What to use for one scenario.

    Attributes
    ----------
    scenario : str
    error : float
        The relative place error that is asked for.
    choices : tuple of Choice
        Of every engine that reaches it, cheapest first: the choice, the runner-up, and so on.
    short : tuple of (str, Point or None)
        Engines that do not reach it, with their best point.
    absent : tuple of (str, str, str)
        Engines that did not answer, with state (refused, not installed, not run) and reason.
    """

    scenario: str
    error: float
    choices: tuple[Choice, ...]
    short: tuple[tuple[str, Point | None], ...]
    absent: tuple[tuple[str, str, str], ...]

    @property
    def ratio(self) -> float | None:
        """Cost of the runner-up over that of the choice."""
        return self.choices[1].point.cost / self.choices[0].point.cost if len(self.choices) > 1 else None


def advise(found: Sequence[Frontier], scenario: str, error: float) -> Advice:
    """Advice for one scenario from measured frontiers.

    Raises
    ------
    ValueError
        If the error is not a positive number, or nothing was measured on the scenario.
    """
    if not error > 0.0:
        raise ValueError(f"error = {error!r} is not possible: a number > 0")
    own = [f for f in found if f.scenario == scenario]
    if not own:
        known = ", ".join(dict.fromkeys(f.scenario for f in found)) or "nothing"
        raise ValueError(f"{scenario}: no error of place was measured on it; measured: {known}")
    points = {f.engine: _chosen(f, error) for f in own if f.answered}
    choices = [Choice(f.engine, p, f.default) for f in own if (p := points.get(f.engine)) is not None]
    return Advice(
        scenario,
        error,
        tuple(sorted(choices, key=lambda choice: choice.point.cost)),
        tuple((f.engine, f.best) for f in own if f.answered and points[f.engine] is None),
        tuple((f.engine, *f.absent) for f in own if not f.answered),
    )


def _chosen(found: Frontier, error: float) -> Point | None:
    """The cheapest measured point within the error, or the default if it is as cheap as the clock can tell."""
    cheapest, default = found.cheapest(error), found.default
    if cheapest is None or default is None or not (default.whole and default.error <= error):
        return cheapest
    return default if default.cost <= MARGIN * cheapest.cost else cheapest
