"""Two balls on a rod turn about each other."""

from __future__ import annotations

import numpy as np

from mechanics.effects import Rod
from mechanics.scene import Body, Scene
from mechanics.shapes import Sphere
from mechanics.trajectory import Trajectory
from scenarios.motion import Motion, trajectory, vectors
from scenarios.scenario import Scenario, scenario
from scenarios.tolerance import STEP, first_order, rounding

M, ARMS = (1.0, 2.0), (-1.0, 0.5)  # [kg], from the common centre along the rod [m]
DRIFT = (0.2, 0.1)  # of the common centre along x and z [m/s]


@scenario(tags=("joint", "rod"), suites=(), variants=({}, {"spin": 20.0}), ranges={"spin": (0.1, 100.0)})
def dumbbell(spin: float = 4.0) -> Scenario:
    """Balls of 1 and 2 kg on a massless rod of 1.5 m drift through space and turn at 4 rad/s, for 7.3 s.

    The common centre goes straight on while the balls go round it.  The rod must neither stretch nor give:
    its pull acts on both alike, so momentum stays what it is to the last digit.
    """
    bodies = tuple(
        Body(f"ball-{k + 1}", Sphere(0.05), m, (arm, 0.0, 0.0), velocity=(DRIFT[0], 0.0, DRIFT[1] + arm * spin))
        for k, (m, arm) in enumerate(zip(M, ARMS, strict=True))
    )
    scene = Scene(bodies, (Rod("ball-1", "ball-2"),))

    def truth(t: np.ndarray) -> Trajectory:
        cosine, sine, motions = np.cos(spin * t), np.sin(spin * t), {}
        for body, arm in zip(bodies, ARMS, strict=True):
            x = vectors(t, x=DRIFT[0] * t + arm * cosine, z=DRIFT[1] * t + arm * sine)
            motions[body.name] = Motion(x, vectors(t, x=DRIFT[0] - arm * spin * sine, z=DRIFT[1] + arm * spin * cosine))
        return trajectory(scene, t, motions)

    duration, far = 7.3, max(map(abs, ARMS))
    turn = spin * STEP * (1.0 + spin * duration / 2.0)
    return Scenario(
        scene=scene,
        duration=duration,
        sampling=0.02,
        truth=truth,
        checks=(
            first_order("position error", far * turn, "m", "r ω h (1 + ω t/2): a chord for an arc, step after step"),
            first_order("velocity error", far * spin * turn, "m/s", "r ω² h (1 + ω t/2), likewise"),
            rounding("linear momentum error", "the rod pulls both balls alike"),
        ),
        source="uniform rotation about a centre of mass in uniform motion",
        about=(Rod,),
    )
