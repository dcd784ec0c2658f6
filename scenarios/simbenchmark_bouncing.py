"""The bouncing scene of SimBenchmark, as published."""

from __future__ import annotations

import numpy as np

from mechanics.effects import Gravity, Restitution
from mechanics.scene import Body, Scene
from mechanics.shapes import HalfSpace, Sphere
from mechanics.trajectory import Trajectory
from scenarios.bouncing_ball import bounce, impact_times
from scenarios.motion import Motion, trajectory, vectors
from scenarios.scenario import Check, Scenario, scenario
from scenarios.tolerance import GRAVITY, SAFETY

SIDE, MASS, RADIUS, HEIGHT, PITCH = 7, 10.0, 0.1, 5.0, 2.0  # balls, [kg], [m], [m], [m]
DURATION = 20.0  # [s]


def mean_square_theory(dt: float) -> float:
    """Mean square energy error of semi-implicit Euler with a perfect contact [J2].

    In flight it reports E - E₀ = ±M g v h/2 and each impact falls anywhere in a step, which spreads
    the error evenly over M g v h: variance (M g h)² v²/12 with v² = 2 g (H - R).
    """
    return (SIDE**2 * MASS * GRAVITY * dt) ** 2 * 2.0 * GRAVITY * (HEIGHT - RADIUS) / 12.0


@scenario(
    tags=("published", "impact"),
    suites=("published",),
    variants=({}, {"dt": 0.01}, {"layout": "row"}, {"layout": "row", "dt": 0.01}),
    ranges={"dt": (1e-6, 0.1), "layout": ("grid", "row")},
)
def simbenchmark_bouncing(dt: float = 0.001, layout: str = "grid") -> Scenario:
    """49 elastic balls bounce for 20 s from 5 m: SimBenchmark's test of energy under restitution 1.

    Its published error is the mean over all steps of (E - E₀)², sampled before each step.  The balls
    never meet, so a row of 49 is the same test for engines that live in a plane.  The state is
    recorded at every step.
    """
    places = [(PITCH * i, PITCH * j if layout == "grid" else 0.0) for i, j in _cells(layout)]
    balls = [Body(f"ball-{k + 1}", Sphere(RADIUS), MASS, (x, y, HEIGHT)) for k, (x, y) in enumerate(places)]
    scene = Scene((Body("floor", HalfSpace()), *balls), (Gravity(), Restitution(1.0)))

    def truth(t: np.ndarray) -> Trajectory:
        gap, rise = bounce(t, HEIGHT - RADIUS, 1.0)
        up = vectors(t, z=rise)
        motions = {b.name: Motion(vectors(t, *b.position[:2], RADIUS + gap), up) for b in balls}
        return trajectory(scene, t, motions)

    theory = mean_square_theory(dt)
    why = (
        f"(M g h)² 2 g (H - R)/12 = {theory:.6g} J2 for a first-order scheme at this step, times {SAFETY:g} for safety"
    )
    return Scenario(
        scene=scene,
        duration=DURATION,
        sampling=dt,
        truth=truth,
        checks=(Check("mean square energy error", SAFETY * theory, why),),
        source="Kang and Hwangbo, SimBenchmark (2018), github.com/leggedrobotics/SimBenchmark, test 'bouncing'",
        about=(Gravity, Restitution),
        events=tuple(impact_times(HEIGHT - RADIUS, 1.0, DURATION).tolist()),
        guard=0.05,
    )


def _cells(layout: str) -> list[tuple[int, int]]:
    if layout == "row":
        return [(i, 0) for i in range(SIDE**2)]
    return [(i, j) for i in range(SIDE) for j in range(SIDE)]
