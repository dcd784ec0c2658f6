"""Balls on a line that stick together as they meet."""

from __future__ import annotations

import numpy as np

from mechanics.effects import Restitution
from mechanics.scene import Scene
from mechanics.trajectory import Trajectory
from scenarios.motion import Motion, trajectory, vectors
from scenarios.on_a_line import balls_on_a_line
from scenarios.scenario import Scenario, scenario
from scenarios.tolerance import STEP, converged, first_order, rounding

RADIUS, PITCH, SPEED = 0.0625, 1.0, 2.0  # [m], [m] between balls as points, [m/s]


def couplings(count: int) -> np.ndarray:
    """Times [s] at which the train of 1, 2, ... balls takes in the next of `count`: k (k + 1)/2 gaps at full speed."""
    k = np.arange(1, count)
    return PITCH / SPEED * k * (k + 1) / 2.0


@scenario(tags=("impact", "chain"), suites=(), variants=({}, {"count": 3}), ranges={"count": (2, 20)})
def sticking_train(count: int = 6) -> Scenario:
    """A ball runs into the first of five, without bounce, the two of them into the next, and so on.

    After k impacts the train of k + 1 balls travels at v/(k + 1).  It must neither come apart nor gain
    energy, and an impact at its head must be felt at its tail at once: handled pair by pair, such an
    impact never ends.
    """
    places, speeds = [PITCH * i for i in range(count)], [SPEED] + [0.0] * (count - 1)
    scene = Scene(balls_on_a_line(RADIUS, [1.0] * count, places, speeds), (Restitution(0.0),))
    times = couplings(count)
    start = scene.start().x[:, 0]

    def truth(t: np.ndarray) -> Trajectory:
        joined = np.searchsorted(times, t, side="right")
        pace = SPEED / (joined + 1.0)
        head = PITCH * joined + pace * (t - np.append(0.0, times)[joined])  # the train as a point
        motions = {}
        for i, name in enumerate(scene.names):
            x = np.where(joined >= i, head + 2.0 * RADIUS * i, start[i])
            motions[name] = Motion(vectors(t, x=x), vectors(t, x=np.where(joined >= i, pace, 0.0)))
        return trajectory(scene, t, motions)

    duration = round(float(times[-1]) + 0.5, 3)
    late = SPEED * sum(1.0 / k for k in range(1, count)) * STEP
    return Scenario(
        scene=scene,
        duration=duration,
        sampling=duration / 400.0,
        truth=truth,
        checks=(
            first_order("position error", late, "m", "Σ |Δv| h <= v h (1 + 1/2 + 1/3 + ...): each impact a step late"),
            converged("velocity error", SPEED, "the first approach speed in m/s"),
            rounding("linear momentum error", "an impulse acts on both balls alike"),
        ),
        source="momentum: after k impacts v/(k + 1), at t = k (k + 1)/2 gaps over v",
        about=(Restitution,),
        events=tuple(times.tolist()),
        guard=2.0 * count * STEP,
    )
