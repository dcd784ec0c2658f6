"""How far the bodies are from their true places: one number for every scene, the error of the accuracy frontier.

A body is off its place by the distance of its centre of mass and by the angle it is turned.  Both become
one length through the ball of radius r that holds the body: none of its points is farther off than

    |Δx| + 2 r sin(θ/2).

Over the length by which the scene itself moves this is a number without a unit, so that one target means
the same in every scene.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from adapters.run import sample_times
from comparisons.measurement import Case, Quantity
from mechanics.rotation import angle_between
from mechanics.shapes import bounding_radius
from scenarios.scenario import Scenario

QUANTITIES = {
    "place error": ("m", "largest distance of any point of a body from its true place, |Δx| + 2 r sin(θ/2)"),
    "relative place error": ("1", "the place error over the scale of the motion (see `comparisons.place.scale`)"),
}
ASKED = ("position error", "final position error", "orientation error", "drift", "tilt")


def measure(case: Case) -> Iterator[Quantity]:
    """Place error of a case, in metres and relative; nothing where the scenario does not ask where bodies are.

    A scenario asks if it has a truth and demands one of `ASKED`: elsewhere the truth of a path, if there is
    one, is not what the engines are asked for (a chaotic scene, one about energy).
    """
    if case.scenario.truth is None or not any(case.asks(name) for name in ASKED):
        return
    found, rows = case.trajectory, list(case.scene.moving)
    true = case.scenario.truth(found.t)
    apart = np.linalg.norm(found.x[:, rows] - true.x[:, rows], axis=2)
    turned = 2.0 * _radii(case.scenario) * np.sin(0.5 * angle_between(true.q[:, rows], found.q[:, rows]))
    off = np.nan_to_num(apart) + np.nan_to_num(turned)
    known = ~(np.isnan(apart) & np.isnan(turned))
    worst = np.where(known, off, -1.0).max(axis=1, initial=-1.0)
    told = np.flatnonzero(worst >= 0.0)
    if not len(told):
        return
    error = Quantity.worst("place error", worst[told], "m", found.t[told])
    yield error
    yield Quantity("relative place error", error.value / scale(case.scenario), "1", error.time)


def scale(scenario: Scenario) -> float:
    """Length by which errors of place are measured [m].

    The greatest distance that any centre of mass truly gets from its start at the sample times of the
    scenario, but at least the diameter of the smallest moving body: what turns on the spot or stays where
    it is has no other length.

    Raises
    ------
    ValueError
        For a scenario without a truth or without a moving body.
    """
    rows = list(scenario.scene.moving)
    if scenario.truth is None or not rows:
        raise ValueError(f"{scenario.name}: no truth or no moving body, and so no scale of the motion")
    x = scenario.truth(sample_times(scenario.duration, scenario.sampling)).x[:, rows]
    ways = np.linalg.norm(x - x[:1], axis=2)
    return max(float(np.nanmax(ways, initial=0.0)), 2.0 * float(_radii(scenario).min()))


def _radii(scenario: Scenario) -> np.ndarray:
    """(k,) radii of the balls that hold the moving bodies [m]."""
    return np.array([bounding_radius(scenario.scene.bodies[i].shape) for i in scenario.scene.moving])
