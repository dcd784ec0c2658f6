"""A body on a spring and a damper."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from mechanics.effects import Spring
from mechanics.scene import Body, Scene
from mechanics.shapes import Sphere
from mechanics.trajectory import Trajectory
from scenarios.motion import Motion, trajectory, vectors
from scenarios.scenario import Scenario, scenario
from scenarios.tolerance import STEP, first_order

MASS, SPEED, LENGTH = 1.0, 1.0, 1.0  # [kg], towards the spring [m/s], of the spring when it is slack [m]


class Damped(NamedTuple):
    """m ẍ = -k x - c ẋ with less than critical damping."""

    rate: float  # ω₀ = √(k/m) [rad/s]
    zeta: float  # c/(2 √(k m)) < 1

    @property
    def ringing(self) -> float:
        """ω_d = ω₀ √(1 - ζ²) [rad/s]."""
        return self.rate * math.sqrt(1.0 - self.zeta**2)

    def struck(self, t: np.ndarray, speed: float) -> tuple[np.ndarray, np.ndarray]:
        """Excursion [m] and velocity [m/s] at times t after it left x = 0 at `speed`."""
        size, turn = speed / self.ringing * np.exp(-self.zeta * self.rate * t), self.ringing * t
        return size * np.sin(turn), size * (self.ringing * np.cos(turn) - self.zeta * self.rate * np.sin(turn))

    def farthest(self) -> float:
        """Time [s] at which it first turns round."""
        return math.atan2(math.sqrt(1.0 - self.zeta**2), self.zeta) / self.ringing

    def back(self) -> float:
        """Time [s] at which it is back at x = 0."""
        return math.pi / self.ringing

    def unloaded(self) -> float:
        """Time [s] at which the force first vanishes, a little before it is back: the damper pulls by then."""
        lead = math.atan2(2.0 * self.zeta * math.sqrt(1.0 - self.zeta**2), 1.0 - 2.0 * self.zeta**2)
        return (math.pi - lead) / self.ringing


def damped(stiffness: float, damping: float) -> Damped:
    """The oscillator of MASS on a spring [N/m] and a damper [N s/m]."""
    return Damped(math.sqrt(stiffness / MASS), 0.5 * damping / math.sqrt(stiffness * MASS))


@scenario(
    tags=("spring",),
    suites=(),
    variants=({}, {"damping": 0.0}),
    ranges={"stiffness": (1.0, 1e4), "damping": (0.0, 1.9)},
)
def damped_spring(stiffness: float = 100.0, damping: float = 2.0) -> Scenario:
    """A body runs into a spring with a damper at 1 m/s and swings to and fro, less each time.

    Such a spring and damper is what a penalty contact is made of: how deep it goes, how long it takes and which
    share of the speed it returns follow from two numbers.  No gravity.
    """
    way, duration = damped(stiffness, damping), 2.0
    start = (LENGTH, 0.0, 0.0)
    body = Body("body", Sphere(0.05), MASS, start, velocity=(-SPEED, 0.0, 0.0))
    scene = Scene((Body("post", Sphere(0.05)), body), (Spring("post", "body", stiffness, LENGTH, damping),))

    def truth(t: np.ndarray) -> Trajectory:
        x, v = way.struck(t, -SPEED)
        return trajectory(scene, t, {"body": Motion(vectors(t, x=LENGTH + x), vectors(t, x=v))})

    why = "a first-order scheme is a step early or late: "
    return Scenario(
        scene=scene,
        duration=duration,
        sampling=0.01,
        truth=truth,
        checks=(
            first_order("position error", SPEED * STEP, "m", why + "v h"),
            first_order("velocity error", way.rate * SPEED * STEP, "m/s", why + "ω₀ v h"),
        ),
        source="x = v/ω_d exp(-ζ ω₀ t) sin ω_d t; Schwager and Pöschel, Granular Matter 9 (2007) 465",
        about=(Spring,),
    )
