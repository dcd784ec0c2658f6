"""A free box spins, faster and faster, and for longer and longer."""

from __future__ import annotations

import numpy as np

from mechanics.effects import Rotation
from mechanics.scene import Body, Scene
from mechanics.shapes import Box
from scenarios.ladder import STABLE, Ladder
from scenarios.scenario import Check, Scenario, scenario
from scenarios.tumbling_box import tumbling

TENTH = "a tenth: what nobody would call conserved"
SIZE, MASS = (0.1, 0.4, 0.9), 10.0  # [m], [kg]
WOBBLE = 0.02  # of the spin, about the other two axes


def spun(spin: float) -> Scene:
    """The box with `spin` [rad/s] about its axis of middle inertia, slightly disturbed: it keeps turning over."""
    rates = tuple((spin * np.array([WOBBLE, 1.0, WOBBLE])).tolist())
    return Scene((Body("box", Box(SIZE), MASS, angular_velocity=rates),), (Rotation(),))


@scenario(tags=("ladder", "flight", "rotation"), suites=(), ranges={"spin": (1e-3, 1e6)})
def fast_spin(spin: float = 1.0) -> Scenario:
    """A box spins freely about its unstable axis for a second: are its energy and its angular momentum kept?

    First-order integrators err by the square of the angle turned in a step; some engines cut speeds at a limit.
    """
    scene = spun(spin)
    return Scenario(
        scene=scene,
        duration=1.0,
        sampling=0.01,
        truth=tumbling(scene),
        checks=(STABLE, Check("energy error", 0.1, TENTH), Check("angular momentum error", 0.1, TENTH)),
        source="Landau and Lifshitz, Mechanics, §37",
        about=(Rotation,),
    )


@scenario(tags=("ladder", "flight", "rotation"), suites=(), ranges={"time": (0.1, 1e4)})
def long_tumble(time: float = 1.0) -> Scenario:
    """A box tumbles freely at 5 rad/s, turning over every few seconds: for how long is its attitude right?

    In 1000 s it turns over hundreds of times.  An error of the attitude of half a radian means that the next
    turning over is predicted for another moment.
    """
    scene = spun(5.0)
    checks = (
        STABLE,
        Check("orientation error", 0.5, "half a radian: which way it points is no longer known"),
        Check("energy error", 0.1, TENTH),
        Check("angular momentum error", 0.1, TENTH),
    )
    return Scenario(
        scene=scene,
        duration=time,
        sampling=time / 100.0,
        truth=tumbling(scene),
        checks=checks,
        source="Landau and Lifshitz, Mechanics, §37; box of Peters and Hsu, Multibody Dynamics 2015",
        about=(Rotation,),
    )


LADDERS = (
    Ladder("spin", "spin of a free box", "rad/s", "fast-spin", (1, 3, 10, 30, 100, 300, 1e3, 3e3, 1e4), "spin"),
    Ladder("tumbling-time", "time for which a free box tumbles", "s", "long-tumble",
           (1, 3, 10, 30, 100, 300, 1000), "time"),
)  # fmt: skip
