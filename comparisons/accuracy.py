"""Distance from the truth, where the scenario knows it.

The truth is evaluated at the times the engine really reached.  What it leaves open (NaN) is not
compared.  Velocities are not compared within the scenario's guard of a true impact: there an engine
with time steps is before or behind the jump by the nature of stepping.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from comparisons.measurement import Case, Quantity
from mechanics.rotation import angle_between

QUANTITIES = {
    "position error": ("m", "largest distance of any centre of mass from its true place"),
    "velocity error": ("m/s", "largest difference of any velocity from the true one, away from impacts"),
    "orientation error": ("rad", "largest angle by which any body is turned against its true attitude"),
    "angular velocity error": (
        "rad/s",
        "largest difference of any angular velocity from the true one, away from impacts",
    ),
    "final position error": ("m", "the position error at the last sample"),
    "final velocity error": ("m/s", "the velocity error at the last sample that is away from impacts"),
}


def measure(case: Case) -> Iterator[Quantity]:
    """Errors against the scenario's truth; nothing where there is none."""
    if case.scenario.truth is None:
        return
    found, t = case.trajectory, case.trajectory.t
    true, quiet = case.scenario.truth(t), calm(case)
    turned = angle_between(true.q, found.q)
    yield from _errors("position error", distance(found.x, true.x), "m", t, np.ones_like(quiet), "final position error")
    yield from _errors("velocity error", distance(found.v, true.v), "m/s", t, quiet, "final velocity error")
    yield from _errors("orientation error", _known(turned, np.isnan(true.q).any(axis=2)), "rad", t, np.ones_like(quiet))
    yield from _errors("angular velocity error", distance(found.w, true.w), "rad/s", t, quiet)


def calm(case: Case) -> np.ndarray:
    """(T,) whether a sample is further than the scenario's guard from every true impact."""
    events = np.array(case.scenario.events)
    return np.asarray(~(np.abs(case.trajectory.t[:, None] - events) <= case.scenario.guard).any(axis=1))


def distance(found: np.ndarray, true: np.ndarray) -> np.ndarray:
    """(T,) largest length over the bodies of what differs in the known components; -1 where none is known."""
    known = ~np.isnan(true)
    lengths = np.linalg.norm(np.where(known, found - np.where(known, true, 0.0), 0.0), axis=2)
    return np.where(known.any(axis=2), lengths, -1.0).max(axis=1)


def _known(values: np.ndarray, unknown: np.ndarray) -> np.ndarray:
    return np.where(unknown, -1.0, values).max(axis=1)


def _errors(
    name: str, series: np.ndarray, unit: str, t: np.ndarray, allowed: np.ndarray, final: str = ""
) -> Iterator[Quantity]:
    rows = np.flatnonzero(allowed & ~(series < 0.0))
    if not len(rows):
        return
    yield Quantity.worst(name, series[rows], unit, t[rows])
    if final:
        yield Quantity(final, float(series[rows[-1]]), unit, float(t[rows[-1]]))
