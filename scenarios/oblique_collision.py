"""Two smooth balls collide off centre."""

from __future__ import annotations

import math

import numpy as np

from mechanics.effects import Restitution
from mechanics.scene import Body, Scene
from mechanics.shapes import Sphere
from mechanics.trajectory import Trajectory
from scenarios.motion import Motion, line, trajectory
from scenarios.scenario import Check, Scenario, scenario
from scenarios.tolerance import STEP, first_order, rounding

M1, M2 = 2.0, 1.0  # [kg]
R1, R2 = 0.3, 0.2  # [m]
SPEED, MEETING, DURATION = 3.0, 0.30037, 1.0  # [m/s], [s], [s]; they meet within a step, not between two
REDUCED = M1 * M2 / (M1 + M2)  # [kg]


@scenario(
    tags=("impact", "oblique"),
    variants=({}, {"e": 1.0}, {"e": 0.5, "offset": 0.4}),
    ranges={"e": (0.0, 1.0), "offset": (-0.49, 0.49)},
)
def oblique_collision(e: float = 0.9, offset: float = 0.25) -> Scenario:
    """A ball of 2 kg at 3 m/s strikes a resting ball of 1 kg off centre, without friction.

    The impulse acts along the line of centres: what the balls do across it must not change, and
    nothing may start to spin.  The offset is the distance of the line of flight from the target's centre.
    """
    contact = np.array([-math.sqrt((R1 + R2) ** 2 - offset**2), 0.0, offset])
    velocity = np.array([SPEED, 0.0, 0.0])
    start = contact - velocity * MEETING
    first = Body("first", Sphere(R1), mass=M1, position=tuple(start.tolist()), velocity=(SPEED, 0.0, 0.0))
    scene = Scene((first, Body("second", Sphere(R2), mass=M2)), (Restitution(e),))
    normal = contact / (R1 + R2)  # from second to first
    impulse = -(1.0 + e) * REDUCED * float(velocity @ normal) * normal  # on first [N s]
    u1, u2 = velocity + impulse / M1, -impulse / M2

    def truth(t: np.ndarray) -> Trajectory:
        before, after, hit = np.minimum(t, MEETING), np.maximum(t - MEETING, 0.0), (t >= MEETING)[:, None]
        one = Motion(line(before, start, velocity) + after[:, None] * u1, np.where(hit, u1, velocity))
        two = Motion(after[:, None] * u2, np.where(hit, u2, 0.0))
        return trajectory(scene, t, {"first": one, "second": two})

    return Scenario(
        scene=scene,
        duration=DURATION,
        sampling=0.01,
        truth=truth,
        checks=_checks(e, offset, float(np.linalg.norm(u2))),
        source="Landau and Lifshitz, Mechanics, §17-18",
        about=(Restitution,),
        events=(MEETING,),
    )


def _checks(e: float, offset: float, jump: float) -> tuple[Check, ...]:
    """A step late the balls overlap by v h, which turns the normal by δ; the impulse P cos α n(α) has |dP/dα| = P."""
    turn = SPEED * STEP * abs(offset) / (R1 + R2) ** 2
    kick = (1.0 + e) * REDUCED / M2 * SPEED * turn
    late = "seen a step late, the overlap turns the normal by δ = v h b/(R₁ + R₂)²: "
    return (
        first_order(
            "position error", jump * STEP + kick * (DURATION - MEETING), "m", late + "|Δv| h + (1 + e) µ v δ t/m₂"
        ),
        first_order("velocity error", kick, "m/s", late + "(1 + e) µ v δ/m₂, µ the reduced mass"),
        rounding("linear momentum error", "an impulse acts on both balls alike"),
    )
