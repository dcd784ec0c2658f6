"""Two balls collide head-on."""

from __future__ import annotations

import numpy as np

from mechanics.effects import Restitution
from mechanics.scene import Body, Scene
from mechanics.shapes import Sphere
from mechanics.trajectory import Trajectory
from scenarios.motion import Motion, trajectory, vectors
from scenarios.scenario import Scenario, scenario
from scenarios.tolerance import STEP, converged, first_order, rounding

RADIUS, GAP = 0.1, 1.0009  # [m]; the gap closes within a step, not between two, at every usual step size
V1, V2 = 2.0, -0.5  # [m/s]


def after_collision(m1: float, m2: float, v1: float, v2: float, e: float) -> tuple[float, float]:
    """Velocities after a central impact: momentum is kept, relative velocity is turned round and scaled by e."""
    common = (m1 * v1 + m2 * v2) / (m1 + m2)
    return common - e * m2 * (v1 - v2) / (m1 + m2), common + e * m1 * (v1 - v2) / (m1 + m2)


@scenario(
    tags=("impact", "mass-ratio"),
    variants=({}, {"mass_ratio": 10.0}, {"mass_ratio": 1e3}, {"mass_ratio": 1e6}, {"mass_ratio": 1e6, "e": 0.6}),
    ranges={"mass_ratio": (1e-9, 1e9), "e": (0.0, 1.0)},
)
def head_on_collision(mass_ratio: float = 1.0, e: float = 1.0) -> Scenario:
    """A ball of 1 kg at 2 m/s meets one of 1 kg to 1000 t coming at 0.5 m/s; nothing else acts.

    Momentum must be exchanged to the last digit whatever the masses are, and the balls must part at
    e times the speed at which they met.
    """
    light = Body("light", Sphere(RADIUS), mass=1.0, position=(0.0, 0.0, 0.0), velocity=(V1, 0.0, 0.0))
    start = 2.0 * RADIUS + GAP
    heavy = Body("heavy", Sphere(RADIUS), mass=mass_ratio, position=(start, 0.0, 0.0), velocity=(V2, 0.0, 0.0))
    scene = Scene((light, heavy), (Restitution(e),))
    meeting = GAP / (V1 - V2)
    u1, u2 = after_collision(1.0, mass_ratio, V1, V2, e)

    def truth(t: np.ndarray) -> Trajectory:
        before, after, hit = np.minimum(t, meeting), np.maximum(t - meeting, 0.0), t >= meeting
        one = Motion(vectors(t, x=V1 * before + u1 * after), vectors(t, x=np.where(hit, u1, V1)))
        two = Motion(vectors(t, x=start + V2 * before + u2 * after), vectors(t, x=np.where(hit, u2, V2)))
        return trajectory(scene, t, {"light": one, "heavy": two})

    jump = max(abs(u1 - V1), abs(u2 - V2))
    return Scenario(
        scene=scene,
        duration=1.0,
        sampling=0.01,
        truth=truth,
        checks=(
            first_order("position error", jump * STEP, "m", "|Δv| h: the collision is seen up to one step late"),
            converged("velocity error", V1 - V2, "the approach speed in m/s"),
            converged("restitution error", 1.0, "the approach speed, as a ratio"),
            rounding("linear momentum error", "an impulse acts on both balls alike"),
        ),
        source="Newton's law and conservation of momentum; Goldsmith, Impact, ch. 1",
        about=(Restitution,),
        events=(meeting,),
    )
