"""A micro-scene and what is read from it; see `comparisons.read_back`."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from adapters.run import Run
from comparisons.reading import Reading
from mechanics.effects import EFFECTS
from mechanics.scene import Body, Scene
from mechanics.shapes import Sphere
from mechanics.trajectory import Trajectory

Ask = Callable[[Scene, Sequence[float]], Run]
Times = Callable[[float], tuple[float, ...]]  # of the time step [s]
Got = tuple[float, float, float, str]  # got, least, most, remark

G = 9.81  # [m/s2]
MOTION = ("position", "velocity", "energy")  # words in the names of quantities that depend on how a body moves
TURN = ("orientation", "angular", "energy")  # and on how it turns


@dataclass(frozen=True)
class Probe:
    """One micro-scene and what is read from it.

    Attributes
    ----------
    readings : tuple of Reading
        What is asked, nothing got yet.
    scene : function of the time step [s] -> Scene
    times : function of the time step [s] -> tuple of float [s]
    got : function (scene, motion) -> iterator over (got, least, most, said), one for each of the readings
    instead : function (ask, reason) -> readings, or None
        What is asked if this is refused.
    """

    readings: tuple[Reading, ...]
    scene: Callable[[float], Scene]
    times: Times
    got: Callable[[Scene, Trajectory], Iterator[Got]]
    instead: Callable[[Ask, str], list[Reading]] | None = None

    @property
    def effects(self) -> tuple[str, ...]:
        """Effects on which every one of its readings depends."""
        common = set(EFFECTS).intersection(*(r.about for r in self.readings))
        return tuple(sorted(common))

    def read(self, scene: Scene, motion: Trajectory) -> list[Reading]:
        """The readings of a motion."""
        found = zip(self.readings, self.got(scene, motion), strict=True)
        return [replace(r, got=got, least=least, most=most, said=said) for r, (got, least, most, said) in found]

    def blank(self, refused: bool = False, said: str = "") -> list[Reading]:
        """The readings where there is no motion."""
        return [replace(r, refused=refused, said=said) for r in self.readings]


def ball(name: str, x: float, z: float, **more: object) -> Body:
    """A sphere of 0.1 m and 1 kg in the plane y = 0, at x and z [m]; `more` as in `Body`."""
    return Body(name, Sphere(0.1), 1.0, (x, 0.0, z), **more)  # type: ignore[arg-type]


def one(value: float, said: str = "") -> Got:
    """A single number."""
    return float(value), math.nan, math.nan, said


def several(values: Sequence[float] | np.ndarray) -> Got:
    """Median and extremes of several numbers."""
    return float(np.median(values)), float(np.min(values)), float(np.max(values)), ""


def until(end: float) -> Times:
    """Times 0 and `end` [s]."""
    return lambda _: (0.0, end)


def at_once(step: float) -> tuple[float, ...]:
    """After one step, and after a twentieth of a second."""
    return 0.0, step, max(0.05, 2.0 * step)


def reading(
    name: str, unit: str, asked: float, tolerance: float, about: tuple[str, ...], bears_on: tuple[str, ...]
) -> Reading:
    """A reading before anything is read; fields as in `Reading`."""
    return Reading(name, unit, asked, math.nan, tolerance, about=about, bears_on=bears_on)
