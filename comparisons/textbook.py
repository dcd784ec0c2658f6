"""What textbook schemes make of a drop on a floor: balls that fall side by side and bounce, step by step.

Kick, then drift (semi-implicit Euler; a touch is looked for where the step begins):

    v' = -e v  if gap <= 0 and v < 0,  else v - g h;      x' = x + v' h.

Drift, then kick (a touch is looked for where the step ends):

    x' = x + v h;      v' = -e v  if gap' <= 0 and v < 0,  else v - g h.

An engine whose scheme this is, and whose contact is ideal, answers just this; what differs is its solver's doing.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mechanics.effects import Gravity, Restitution, Rotation
from mechanics.scene import Scene
from mechanics.shapes import HalfSpace, Sphere


class Drop(NamedTuple):
    """Balls let go side by side above a level floor."""

    up: np.ndarray  # (3,) unit normal of the floor
    gravity: float  # [m/s2]
    mass: float  # of all balls [kg]
    clearance: float  # of every ball at the start [m]
    e: float


def drop_of(scene: Scene) -> Drop | None:
    """The drop that a scene is; None for any other scene."""
    moving = [scene.bodies[i] for i in scene.moving]
    fixed = [body for body in scene.bodies if body.fixed]
    effect = scene.effect(Restitution)
    simple = {Gravity, Restitution} <= scene.needs <= {Gravity, Restitution, Rotation}
    if not simple or effect is None or effect.between or not moving or len(fixed) != 1:
        return None
    floor, shapes = fixed[0], [body.shape for body in moving]
    if not isinstance(floor.shape, HalfSpace) or any((*floor.velocity, *floor.acceleration)):
        return None
    if not all(isinstance(shape, Sphere) for shape in shapes) or any(any(b.velocity) for b in moving):
        return None
    up, g = np.array(floor.shape.normal), scene.gravity
    places = np.array([body.position for body in moving])
    radii = np.array([shape.radius for shape in shapes if isinstance(shape, Sphere)])
    gaps = (places - floor.position) @ up - radii
    size = float(np.linalg.norm(g))
    if (
        not np.allclose(g, -size * up, atol=1e-12 * size)
        or np.ptp(gaps) > 1e-12
        or gaps[0] <= 0.0
        or _meet(places, radii)
    ):
        return None
    return Drop(up, size, sum(body.mass or 0.0 for body in moving), float(gaps[0]), effect.coefficient)


def _meet(places: np.ndarray, radii: np.ndarray) -> bool:
    """Whether balls that fall side by side touch each other."""
    apart = np.linalg.norm(places[:, None] - places[None], axis=2) - radii[:, None] - radii[None]
    np.fill_diagonal(apart, np.inf)
    return bool((apart <= 0.0).any())


def stepped(drop: Drop, h: float, drift_first: bool, steps: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Gap [m] and upward velocity [m/s] after so many steps of `h` [s], with an ideal contact; see the module."""
    x, v, kick = drop.clearance, 0.0, -drop.gravity * h
    gaps, speeds = [x], [v]
    for _ in range(int(steps.max(initial=0))):
        if drift_first:
            x += v * h
        v = -drop.e * v if x <= 0.0 and v < 0.0 else v + kick
        if not drift_first:
            x += v * h
        gaps.append(x)
        speeds.append(v)
    return np.array(gaps)[steps], np.array(speeds)[steps]


def mean_square_energy_error(drop: Drop, h: float) -> float:
    """Mean of (E - E0)² of balls that bounce for ever (e = 1), (M g h)² 2 g H/12 [J2].

    E - E0 = M g h v/2, and between two impacts v is spread evenly over ±√(2 g H); H is the clearance.
    """
    return (drop.mass * drop.gravity * h) ** 2 * 2.0 * drop.gravity * drop.clearance / 12.0
