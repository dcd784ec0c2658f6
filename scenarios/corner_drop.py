"""A box strikes a floor with one corner."""

from __future__ import annotations

from itertools import product

import numpy as np

from mechanics.effects import Restitution, Rotation
from mechanics.rotation import matrix
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace
from mechanics.trajectory import Trajectory
from scenarios.free_rotation import free_rotation
from scenarios.motion import Motion, line, trajectory
from scenarios.scenario import Scenario, scenario
from scenarios.tolerance import STEP, converged, first_order

SIZE, MASS = (0.6, 0.4, 0.2), 3.0  # [m], [kg]
TURNED = (0.8, 0.3, 0.4, -0.33)
SPEED, GAP = 2.0, 0.1007  # [m/s], [m]; the gap closes within a step, not between two


def corner_impact(body: Body, e: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Lowest corner seen from the centre [m], and velocities v', ω' after it has struck a smooth floor."""
    turn = matrix(np.array(body.orientation))
    corners = np.array(list(product((-0.5, 0.5), repeat=3))) * body.shape.size @ turn.T
    arm, up = corners[np.argmin(corners[:, 2])], np.array([0.0, 0.0, 1.0])
    inverse = turn @ np.linalg.inv(body.inertia_tensor) @ turn.T
    lever = np.cross(arm, up)
    approach = np.array(body.velocity) + np.cross(body.angular_velocity, arm)
    impulse = -(1.0 + e) * approach[2] / (1.0 / body.mass + lever @ inverse @ lever)
    return arm, np.array(body.velocity) + impulse / body.mass * up, inverse @ lever * impulse


@scenario(tags=("impact", "rotation", "box"), variants=({}, {"e": 1.0}), ranges={"e": (0.5, 1.0)})
def corner_drop(e: float = 0.5) -> Scenario:
    """A tilted box coming down at 2 m/s without spin strikes a smooth floor with one corner.

    The blow must turn part of the fall into spin, through the full inertia tensor of a turned body;
    then the box tumbles freely.  The scene ends before a second corner comes down.  No gravity.
    """
    shape = Box(SIZE)
    body = Body("box", shape, mass=MASS, orientation=TURNED, velocity=(0.0, 0.0, -SPEED))
    arm, v, w = corner_impact(body, e)
    start = np.array([0.0, 0.0, GAP - arm[2]])
    box = Body("box", shape, mass=MASS, position=tuple(start), orientation=TURNED, velocity=(0.0, 0.0, -SPEED))
    scene = Scene((Body("floor", HalfSpace()), box), (Restitution(e), Rotation()))
    meeting, duration = GAP / SPEED, 0.095

    def truth(t: np.ndarray) -> Trajectory:
        before, after, hit = np.minimum(t, meeting), np.maximum(t - meeting, 0.0), (t >= meeting)[:, None]
        q, spin = free_rotation(np.diag(box.inertia_tensor), np.array(box.orientation), w, after)
        path = line(before, start, np.array(box.velocity)) + after[:, None] * v
        return trajectory(scene, t, {"box": Motion(path, np.where(hit, v, box.velocity), q, np.where(hit, spin, 0.0))})

    turn, jump = float(np.linalg.norm(w)), float(v[2]) + SPEED
    gyration = turn**2 * STEP * (1.0 + (duration - meeting) * turn / 2.0)
    return Scenario(
        scene=scene,
        duration=duration,
        sampling=5e-3,
        truth=truth,
        checks=(
            first_order("position error", jump * STEP, "m", "|Δv| h: the corner is seen up to one step late"),
            converged("velocity error", SPEED, "the approach speed in m/s"),
            first_order("orientation error", turn * STEP, "rad", "|Δω| h: the corner is seen up to one step late"),
            first_order(
                "angular velocity error", gyration, "rad/s", "ω² h (1 + ω t/2): a step late, and Euler's own error"
            ),
        ),
        source="j = -(1 + e) u / (1/m + n·(I⁻¹(r × n)) × r); Baraff, SIGGRAPH course notes (1997), §8",
        about=(Restitution, Rotation),
        events=(meeting,),
    )
