"""Linear and angular momentum, in the directions in which the scene conserves them.

The deviation at time t is what p(t) - p(0) differs from the impulse of the known loads (gravity,
constant forces and torques) up to then, along the conserved directions only (see `conserved`).
Angular momentum is taken about the common centre of mass or about the point at rest about which more of
it is conserved.

Scales, which make the errors pure numbers:

* linear: Σ m v, with v the largest speed of each body during the run, or the speed it would gain by
  falling its own radius if that is larger (so that the creep of bodies at rest is not measured
  against itself);
* angular: the largest value over the run of Σ (|r × m v| + |I ω|), about the same point.  Where
  bodies touch or are linked, or where nothing turns at the start, it is at least
  Σ m v k, with k the radius of gyration: the spin that their momenta would give if they acted at
  that distance.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from comparisons.conserved import Conserved
from comparisons.measurement import Case, Quantity
from comparisons.moving import Moving
from mechanics.effects import Force, Hinge, Rod, Rotation, Spring, Tether

QUANTITIES = {
    "linear momentum error": ("1", "largest change of linear momentum that no declared effect explains, over Σ m v"),
    "angular momentum error": ("1", "largest change of angular momentum that no declared effect explains, over Σ |L|"),
    "relative angular momentum error": (
        "1",
        "largest |H - H(0)| / |H(0)|, H about the centre of mass (as in the Gazebo boxes benchmark)",
    ),
}


def measure(case: Case) -> Iterator[Quantity]:
    """The momentum errors of a case, as far as the scene conserves anything."""
    moving = case.moving
    if not len(moving.mass):
        return
    kept = case.conserved
    linear, angular, relative = QUANTITIES
    if len(kept.linear):
        yield Quantity.worst(linear, linear_deviation(moving, kept), "1", moving.t, linear_scale(moving))
    elif case.asks(linear):
        yield Quantity(linear, np.nan, "1", text=kept.sentences()[0])
    if len(kept.angular):
        scale = angular_scale(moving, kept.pivot)
        yield Quantity.worst(angular, angular_deviation(moving, kept), "1", moving.t, scale)
    elif case.asks(angular):
        yield Quantity(angular, np.nan, "1", text=kept.sentences()[1])
    if case.asks(relative):
        spin = (moving.spin + moving.orbital(None)).sum(axis=1)
        change = np.linalg.norm(spin - spin[0], axis=1)
        yield Quantity.worst(relative, change, "1", moving.t, float(np.linalg.norm(spin[0])))


def linear_deviation(moving: Moving, kept: Conserved) -> np.ndarray:
    """(T,) change of linear momentum in the conserved directions that known impulses do not explain [N s]."""
    elapsed = moving.t - moving.t[0]
    known = moving.mass.sum() * elapsed[:, None] * moving.scene.gravity
    for force in moving.scene.all(Force):
        known = known + _active(force, moving.t)[:, None] * np.array(force.force)
    return np.asarray(np.linalg.norm((moving.momentum - moving.momentum[0] - known) @ kept.linear.T, axis=1))


def angular_deviation(moving: Moving, kept: Conserved) -> np.ndarray:
    """(T,) change of angular momentum in the conserved directions that known torques do not explain [N m s]."""
    total = (moving.spin + moving.orbital(kept.pivot)).sum(axis=1)
    change = total - total[0]
    if Rotation in moving.scene.needs:
        for force in moving.scene.all(Force):
            change = change - _active(force, moving.t)[:, None] * np.array(force.torque)
    return np.asarray(np.linalg.norm(change @ kept.angular.T, axis=1))


def linear_scale(moving: Moving) -> float:
    """Σ m v of the bodies' speed scales [N s]."""
    return float(moving.mass @ moving.speed_scale)


def angular_scale(moving: Moving, pivot: np.ndarray | None) -> float:
    """Largest Σ (|r × m v| + |I ω|) about `pivot`; at least Σ m v k where forces may act off the centres [N m s]."""
    sizes = np.linalg.norm(moving.spin, axis=2) + np.linalg.norm(moving.orbital(pivot), axis=2)
    totals = sizes.sum(axis=1)
    scene = moving.scene
    linked = any(kind in scene.needs for kind in (Spring, Rod, Tether, Hinge))
    if not (scene.touching or linked or totals[0] == 0.0):
        return float(totals.max())
    return max(float(totals.max()), float((moving.mass * moving.gyration) @ moving.speed_scale))


def _active(force: Force, t: np.ndarray) -> np.ndarray:
    """(T,) time for which `force` has acted since the first sample [s]."""
    return np.asarray(np.clip(t, force.start, force.end) - np.clip(t[0], force.start, force.end))
