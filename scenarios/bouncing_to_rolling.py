"""A ball thrown along a rough floor bounces, grips and ends up rolling."""

from __future__ import annotations

import math

import numpy as np

from mechanics.effects import Friction, Gravity, Resting, Restitution, Rotation
from mechanics.rotation import exponential
from mechanics.scene import Body, Scene
from mechanics.shapes import HalfSpace, Sphere
from mechanics.trajectory import Trajectory
from scenarios.bouncing_ball import bounce, delay, impact_times
from scenarios.bouncing_to_rest import rest_time
from scenarios.motion import Motion, trajectory, vectors
from scenarios.scenario import Check, Scenario, Truth, scenario
from scenarios.tolerance import GRAVITY, STEP, first_order

RADIUS, MASS, RATIO = 0.1, 1.0, 0.4  # [m], [kg], moment of inertia over m R²: a solid ball
CLEARANCE, SPEED, E = 0.6, 3.0, 0.7  # [m], [m/s], restitution


def rolling_speed(speed: float, spin: float = 0.0) -> float:
    """Speed at which it ends up rolling, whatever the friction [m/s]: angular momentum about the floor is kept."""
    return (speed + RATIO * RADIUS * spin) / (1.0 + RATIO)


def speeds_after(mu: float, impacts: int) -> np.ndarray:
    """Speed along the floor after 0, 1, ... `impacts` bounces [m/s]: each takes µ (1 + e) of the blow, or grips."""
    fall = math.sqrt(2.0 * GRAVITY * CLEARANCE)
    taken = mu * (1.0 + E) * fall * np.cumsum(E ** np.arange(impacts))
    return np.append(SPEED, np.maximum(SPEED - taken, rolling_speed(SPEED)))


def along_the_floor(scene: Scene, times: np.ndarray, speeds: np.ndarray) -> Truth:
    """Bouncing at `times` [s] with the `speeds` [m/s] along the floor before the first of them, and after each."""
    knots = np.append(0.0, times)
    places = np.append(0.0, np.cumsum(speeds[:-1] * np.diff(knots)))

    def truth(t: np.ndarray) -> Trajectory:
        gap, rise = bounce(t, CLEARANCE, E)
        n = np.searchsorted(times, t, side="right")
        path, pace = places[n] + speeds[n] * (t - knots[n]), speeds[n]
        x, v = vectors(t, x=path, z=RADIUS + gap), vectors(t, x=pace, z=rise)
        turn = (SPEED * t - path) / (RATIO * RADIUS)  # spin grows as speed falls: k R ω = v₀ - v
        w = vectors(t, y=(SPEED - pace) / (RATIO * RADIUS))
        return trajectory(scene, t, {"ball": Motion(x, v, exponential(vectors(t, y=turn)), w)})

    return truth


@scenario(
    tags=("impact", "friction", "rotation", "rolling", "zeno"),
    suites=(),
    variants=({}, {"mu": 0.1}),
    ranges={"mu": (0.09, 10.0)},
)
def bouncing_to_rolling(mu: float = 0.2) -> Scenario:
    """A ball thrown horizontally at 3 m/s bounces along a rough floor and ends up rolling at 5/7 of that.

    Each bounce turns some speed into spin until the ball grips.  Friction acts at the floor only, so the
    angular momentum about a line on the floor is kept, and the last speed is the same for any friction and
    any restitution, through infinitely many bounces.
    """
    ball = Body("ball", Sphere(RADIUS), MASS, (0.0, 0.0, RADIUS + CLEARANCE), velocity=(SPEED, 0.0, 0.0))
    effects = (Gravity(), Restitution(E), Friction(mu), Resting(), Rotation())
    scene = Scene((Body("floor", HalfSpace()), ball), effects)
    end = rest_time(CLEARANCE, E)
    times = impact_times(CLEARANCE, E, end)
    speeds = speeds_after(mu, len(times))
    duration = round(end + 0.5, 2)
    return Scenario(
        scene=scene,
        duration=duration,
        sampling=0.01,
        truth=along_the_floor(scene, times, speeds),
        checks=_checks(mu, speeds, duration),
        source="v = (v₀ + k R ω₀)/(1 + k); Garwin, Am. J. Phys. 37 (1969) 88",
        about=(Gravity, Restitution, Friction, Resting, Rotation),
        events=tuple(times[times < end - 0.02].tolist()),
        guard=0.02,
    )


def _checks(mu: float, speeds: np.ndarray, duration: float) -> tuple[Check, ...]:
    """Late impacts are too fast by g h, and friction takes µ (1 + e) of that too much, while the ball slips."""
    fall, n = math.sqrt(2.0 * GRAVITY * CLEARANCE), np.arange(1, 100)
    late, lost = float(np.max(n * E**n)) * delay(E), float((SPEED - speeds).max()) * STEP
    slips = int(np.sum(speeds > speeds[-1]))
    brake = slips * mu * (1.0 + E) * GRAVITY * delay(E)
    up = GRAVITY * STEP / 2.0 + fall * late
    return (
        first_order(
            "position error", up + lost + brake * duration, "m", "n eⁿ v times the delay of an impact, and the brake's"
        ),
        first_order("final velocity error", brake + GRAVITY * STEP, "m/s", "µ (1 + e) g times that delay, and g h"),
        first_order(
            "orientation error",
            (lost + brake * duration) / (RATIO * RADIUS),
            "rad",
            "what the brake of late impacts leaves, as spin, 5/2 of it over R",
        ),
    )
