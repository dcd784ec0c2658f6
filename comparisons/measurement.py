"""Measurement: one quantity of one run, with what was demanded of it; Case: what a comparison looks at."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from adapters.run import Run
from comparisons.conserved import Conserved, conserved
from comparisons.moving import Moving
from mechanics.scene import Scene
from mechanics.trajectory import Trajectory
from scenarios.scenario import Scenario


@dataclass(frozen=True)
class Case:
    """One run of one scenario as the comparisons see it; `trajectory` is its motion as far as it got."""

    scenario: Scenario
    run: Run
    trajectory: Trajectory

    @property
    def scene(self) -> Scene:
        """The scene that was run."""
        return self.scenario.scene

    @cached_property
    def moving(self) -> Moving:
        """The bodies that have a mass, with their motion."""
        return Moving.of(self.scene, self.trajectory)

    @cached_property
    def conserved(self) -> Conserved:
        """What the effects of the scene conserve."""
        return conserved(self.scene, self.scenario.duration)

    def asks(self, quantity: str) -> bool:
        """Whether the scenario demands something of `quantity`."""
        return any(check.quantity == quantity for check in self.scenario.checks)


@dataclass(frozen=True)
class Quantity:
    """A measured quantity before anything is demanded of it.

    Attributes
    ----------
    name : str
    value : float
        NaN if it is a word (`text`) or could not be measured (`text` says why).
    unit : str
        UCUM text; "1" for ratios.
    time : float
        When the value was attained [s]; NaN if it belongs to no time.
    text : str
    """

    name: str
    value: float
    unit: str
    time: float = math.nan
    text: str = ""

    @staticmethod
    def worst(name: str, series: np.ndarray, unit: str, t: np.ndarray, scale: float = 1.0, text: str = "") -> Quantity:
        """The largest value of `series` (T,) over `scale`, with the time at which it was attained.

        0 over a scale of 0 is 0, anything else over it is infinite; NaN in the series gives NaN.
        """
        worst = int(np.argmax(series))
        value = float(series[worst])
        if value != 0.0:
            value = value / scale if scale else math.inf
        return Quantity(name, value, unit, float(t[worst]), text)


@dataclass(frozen=True)
class Measurement:
    """A quantity with its verdict.

    Attributes
    ----------
    quantity, value, unit, time, text
        As in `Quantity`.
    tolerance, exact : float
        NaN if nothing is demanded.
    why : str
        Reason of the tolerance.
    verdict : str
        "exact" (within rounding), "ok" (within tolerance), "fail", "info" (nothing demanded),
        "unmeasured" (demanded, but the quantity could not be computed: counts as a failure of the house).
    """

    quantity: str
    value: float
    unit: str
    time: float
    text: str
    tolerance: float
    exact: float
    why: str
    verdict: str
