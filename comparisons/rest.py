"""Rest: whether what must stay stays, measured where a scenario asks for it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from comparisons.measurement import Case, Quantity
from comparisons.moving import Moving
from mechanics.effects import Resting
from mechanics.rotation import angle_between

QUANTITIES = {
    "drift": ("m", "largest distance of any moving body from where it started"),
    "tilt": ("rad", "largest angle by which any moving body is turned against its attitude at the start"),
    "rest speed": ("m/s", "upper bound of the speed of any point of any body at the last sample, |v| + |ω| r"),
    "out of plane": ("m", "largest distance of any moving body from the plane of a planar scene"),
}


def measure(case: Case) -> Iterator[Quantity]:
    """Drift and tilt where they are asked for, speed at the end where bodies may rest, distance from the plane."""
    moving = case.moving
    if not len(moving.mass):
        return
    if case.asks("drift"):
        yield Quantity.worst("drift", displacements(moving).max(axis=1), "m", moving.t)
    if case.asks("tilt"):
        yield Quantity.worst("tilt", turns(moving).max(axis=1), "rad", moving.t)
    if case.asks("rest speed") or Resting in case.scene.needs:
        speed = np.linalg.norm(moving.v[-1], axis=1) + np.linalg.norm(moving.w[-1], axis=1) * moving.radius
        yield Quantity("rest speed", float(speed.max()), "m/s", float(moving.t[-1]))
    if case.scene.out_of_plane() is None:
        level = case.scene.bodies[case.scene.moving[0]].position[1]
        yield Quantity.worst("out of plane", np.abs(moving.x[:, :, 1] - level).max(axis=1), "m", moving.t)


def displacements(moving: Moving) -> np.ndarray:
    """(T, k) distances of the moving bodies from where they started [m]."""
    return np.asarray(np.linalg.norm(moving.x - moving.x[0], axis=2))


def turns(moving: Moving) -> np.ndarray:
    """(T, k) angles by which the moving bodies are turned against their attitudes at the start [rad]."""
    return np.asarray(angle_between(moving.q[:1], moving.q))
