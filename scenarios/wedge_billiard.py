"""A ball runs into the corner between two walls and comes out again."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from mechanics.effects import Restitution
from mechanics.scene import Body, Scene
from mechanics.shapes import HalfSpace, Sphere
from mechanics.trajectory import Trajectory
from scenarios.motion import Motion, trajectory, vectors
from scenarios.scenario import Scenario, scenario
from scenarios.tolerance import STEP, converged, first_order, rounding

RADIUS, SPEED, START = 0.1, 1.0, 3.0  # [m], [m/s], [m] from the apex along the first wall


class Path(NamedTuple):
    """Motion of a point in the wedge 0 <= polar angle <= θ."""

    x: np.ndarray  # (T, 2)
    v: np.ndarray  # (T, 2)
    hits: np.ndarray  # (T,) number of reflections so far


def in_wedge(t: np.ndarray, wedge: float, start: tuple[float, float], speed: float) -> Path:
    """Motion of a point that comes in from `start`, parallel to the wall at angle 0, towards the apex.

    Each reflection is undone by reflecting the wedge instead: the path is then a straight line, and the
    n-th copy of the wedge it has come to, read forwards or backwards, gives the place and the velocity.
    """
    along, height = start[0] - speed * np.asarray(t, dtype=np.float64), start[1]
    angle, distance = np.arctan2(height, along), np.hypot(along, height)
    n = np.floor(angle / wedge)
    odd = n % 2.0 == 1.0
    folded = np.where(odd, (n + 1.0) * wedge - angle, angle - n * wedge)
    heading = np.where(odd, (n + 1.0) * wedge - math.pi, math.pi - n * wedge)
    place = distance[..., None] * np.stack([np.cos(folded), np.sin(folded)], axis=-1)
    return Path(place, speed * np.stack([np.cos(heading), np.sin(heading)], axis=-1), n.astype(int))


def reflections(wedge: float, start: tuple[float, float], speed: float) -> np.ndarray:
    """Times of all reflections; there are ⌈π/θ⌉ - 1 of them."""
    crossed = wedge * np.arange(1, math.ceil(math.pi / wedge))
    return (start[0] - start[1] / np.tan(crossed)) / speed


@scenario(tags=("impact", "walls"), suites=(), variants=({}, {"opening": 50.0}), ranges={"opening": (5.0, 170.0)})
def wedge_billiard(opening: float = 17.0) -> Scenario:
    """An elastic ball runs into the corner between two walls at 17 degrees and is back out after ten impacts.

    Mirroring the walls instead of the ball turns its path into a straight line: there are ⌈π/θ⌉ - 1
    impacts, and they crowd where the ball is closest to the corner.  No energy may be lost or gained.
    """
    wedge, height = math.radians(opening), 0.5
    apex = RADIUS / math.sin(0.5 * wedge)  # behind the apex of the centre's own wedge, along its bisector
    corner = (-apex * math.cos(0.5 * wedge), 0.0, -apex * math.sin(0.5 * wedge))
    lower = Body("lower", HalfSpace(), position=corner)
    upper = Body("upper", HalfSpace((math.sin(wedge), 0.0, -math.cos(wedge))), position=corner)
    ball = Body("ball", Sphere(RADIUS), 1.0, (START, 0.0, height), velocity=(-SPEED, 0.0, 0.0))
    scene = Scene((lower, upper, ball), (Restitution(1.0),))
    times = reflections(wedge, (START, height), SPEED)
    duration = round(float(times[-1]) + 1.0, 2)

    def truth(t: np.ndarray) -> Trajectory:
        path = in_wedge(t, wedge, (START, height), SPEED)
        x, v = (vectors(t, x=a[:, 0], z=a[:, 1]) for a in (path.x, path.v))
        return trajectory(scene, t, {"ball": Motion(x, v)})

    return Scenario(
        scene=scene,
        duration=duration,
        sampling=0.02,
        truth=truth,
        checks=(
            first_order("position error", 2.0 * len(times) * SPEED * STEP, "m", "2 v h for each impact, a step late"),
            converged("velocity error", SPEED, "the speed in m/s"),
            rounding("energy error", "an elastic impact with a wall keeps the speed"),
        ),
        source="unfolding; Tabachnikov, Geometry and Billiards, ch. 1",
        about=(Restitution,),
        events=tuple(times.tolist()),
        guard=2.0 * len(times) * STEP,
    )
