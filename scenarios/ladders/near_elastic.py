"""Restitution that is nearly 1."""

from __future__ import annotations

import numpy as np

from mechanics.effects import Restitution
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, Sphere
from mechanics.trajectory import Trajectory
from scenarios.ladder import STABLE, Ladder
from scenarios.motion import Motion, trajectory, vectors
from scenarios.scenario import Check, Scenario, scenario

RADIUS, SPEED, WAY = 0.1, 5.0, 1.5  # [m], [m/s], [m] between the places where the ball strikes
DURATION = 2.0  # [s]


def flights(e: float) -> tuple[np.ndarray, np.ndarray]:
    """Times of the impacts [s] and speeds before the first and after each of them [m/s]; the ball starts half way."""
    times, speeds = [0.5 * WAY / SPEED], [SPEED, e * SPEED]
    while times[-1] < DURATION:
        times.append(times[-1] + WAY / speeds[-1])
        speeds.append(e * speeds[-1])
    return np.array(times[:-1]), np.array(speeds[:-1])


@scenario(tags=("ladder", "impact"), suites=(), ranges={"loss": (0.0, 1.0)})
def near_elastic(loss: float = 0.3) -> Scenario:
    """A ball flies to and fro between two walls and loses a small part of its speed at each: which part, really?

    Restitution is 1 less the loss.  The nearer it is to 1, the more is an engine's own loss or gain to be seen.
    """
    e = 1.0 - loss
    walls = [Body(n, Box((0.5, 1.0, 1.0)), position=(s * (0.5 * WAY + RADIUS + 0.25), 0.0, 0.0))
             for n, s in (("left", -1.0), ("right", 1.0))]  # fmt: skip
    ball = Body("ball", Sphere(RADIUS), 1.0, velocity=(SPEED, 0.0, 0.0))
    scene = Scene((*walls, ball), (Restitution(e),))
    times, speeds = flights(e)

    def truth(t: np.ndarray) -> Trajectory:
        n = np.searchsorted(times, t, side="right")
        way = np.where(n % 2 == 0, 1.0, -1.0)
        origin = np.where(n == 0, 0.0, -way * 0.5 * WAY)
        since = t - np.append(0.0, times)[n]
        path = vectors(t, x=origin + way * speeds[n] * since)
        return trajectory(scene, t, {"ball": Motion(path, vectors(t, x=way * speeds[n]))})

    half = "half of the loss: beyond it the loss is not the one that was asked for"
    return Scenario(
        scene=scene,
        duration=DURATION,
        sampling=0.01,
        truth=truth,
        checks=(STABLE, Check("restitution error", 0.5 * loss, half, exact=min(1e-9, 0.05 * loss) or 1e-12)),
        source="Newton's law of restitution, u⁺ = -e u⁻",
        about=(Restitution,),
        events=tuple(t for t in times.tolist() if t < DURATION),
    )


LADDERS = (
    Ladder("near-elastic", "1 - e, the part of the speed lost at an impact", "1", "near-elastic",
           (0.3, 0.1, 0.03, 0.01, 1e-3, 1e-4, 1e-6, 1e-8), "loss"),
)  # fmt: skip
