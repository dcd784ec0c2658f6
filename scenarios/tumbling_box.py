"""A box tumbles freely: rotation alone."""

from __future__ import annotations

import numpy as np

from mechanics.effects import Rotation
from mechanics.rotation import IDENTITY
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, Cylinder
from mechanics.trajectory import Trajectory
from scenarios.free_rotation import free_rotation
from scenarios.motion import Motion, constant, trajectory
from scenarios.scenario import Check, Scenario, Truth, scenario
from scenarios.tolerance import first_order, rounding

# Distance from the closed form of the worse of explicit and linearly implicit Euler for I ω̇ = I ω × ω, at
# 1 ms over the scene's two seconds: attitude [rad], angular velocity [rad/s], energy, angular momentum
# (relative).  The tests integrate both schemes anew.
EULER = {
    "middle": (0.0163, 0.0345, 0.00772, 0.00449),
    "largest": (4.00e-4, 1.65e-3, 1.86e-5, 2.23e-4),
    "smallest": (2.30e-3, 0.0108, 1.44e-4, 2.54e-3),
    "symmetric": (3.44e-3, 0.0134, 7.84e-4, 7.05e-4),
}


def tumbling(scene: Scene) -> Truth:
    """Motion of bodies on which nothing acts at all and which turn."""

    def truth(t: np.ndarray) -> Trajectory:
        start, motions = scene.start(), {}
        for i in scene.moving:
            moments = np.diag(scene.bodies[i].inertia_tensor)
            q, w = free_rotation(moments, start.q[i], start.w[i], t)
            drift = start.x[i] + t[:, None] * start.v[i]
            motions[scene.names[i]] = Motion(drift, constant(t, start.v[i]), q, w)
        return trajectory(scene, t, motions)

    return truth


def tumbling_checks(errors: tuple[float, float, float, float]) -> tuple[Check, ...]:
    """What is demanded of free rotation if a first-order scheme errs by `errors`, in the order of `EULER`."""
    attitude, spin, energy, momentum = errors
    by = "what Euler's method, explicit or linearly implicit, errs by here"
    return (
        rounding("position error", "nothing pushes the body", exact=1e-12),
        first_order("orientation error", attitude, "rad", by),
        first_order("angular velocity error", spin, "rad/s", by),
        first_order("energy error", energy, "1", by),
        first_order("angular momentum error", momentum, "1", by),
    )


@scenario(
    tags=("flight", "rotation"),
    suites=("smoke", "standard"),
    variants=({}, {"axis": "largest"}, {"axis": "smallest"}),
    ranges={"axis": ("middle", "largest", "smallest")},
)
def tumbling_box(axis: str = "middle") -> Scenario:
    """A box spins at 5 rad/s about one of its axes, slightly disturbed, with nothing acting on it.

    About the axis of its middle moment of inertia that is unstable and the box turns over after 1.2 s
    (Dzhanibekov); about the other two it only wobbles.  Energy and angular momentum stay what they
    are in truth; first-order integrators change both.
    """
    place = {"largest": 0, "middle": 1, "smallest": 2}[axis]  # moments 97/120, 41/60 and 17/120 kg m2
    spin = tuple(5.0 if k == place else 0.1 for k in range(3))
    box = Body("box", Box((0.1, 0.4, 0.9)), mass=10.0, orientation=IDENTITY, angular_velocity=spin)
    scene = Scene((box,), (Rotation(),))
    return Scenario(
        scene=scene,
        duration=2.0,
        sampling=0.01,
        truth=tumbling(scene),
        checks=tumbling_checks(EULER[axis]),
        source="Landau and Lifshitz, Mechanics, §37; box and spin of Peters and Hsu, Multibody Dynamics 2015",
        about=(Rotation,),
    )


@scenario(tags=("flight", "rotation"))
def symmetric_top() -> Scenario:
    """A cylinder thrown with a wobble: its axis goes round a cone at constant speed.

    With two equal moments the motion is two uniform rotations: about the fixed angular momentum at
    |L|/I₁, and about the body's own axis.
    """
    top = Body("top", Cylinder(0.2, 0.1), mass=2.0, angular_velocity=(1.0, 0.0, 6.0))
    scene = Scene((top,), (Rotation(),))
    return Scenario(
        scene=scene,
        duration=2.0,
        sampling=0.01,
        truth=tumbling(scene),
        checks=tumbling_checks(EULER["symmetric"]),
        source="Landau and Lifshitz, Mechanics, §33; Kane, Likins and Levinson, Spacecraft Dynamics, §3.1",
        about=(Rotation,),
    )
