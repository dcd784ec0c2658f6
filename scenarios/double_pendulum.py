"""A pendulum hangs from a pendulum."""

from __future__ import annotations

import math

import numpy as np

from mechanics.effects import Gravity, Rod
from mechanics.scene import Body, Scene
from mechanics.shapes import Sphere
from mechanics.trajectory import Trajectory
from scenarios.motion import Motion, trajectory, vectors
from scenarios.scenario import Scenario, scenario
from scenarios.tolerance import GRAVITY, STEP, first_order

LENGTH, MASS, START = 1.0, 1.0, (120.0, -10.0)  # of both [m], [kg]; angles from straight down [degrees]
APART = 1.5  # [1/s], at which nearby motions part in these two seconds, on the whole


def angles(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Angles (2, T) [rad] and rates [rad/s] at times `t`, from rest: Lagrange's equations by Runge-Kutta of order 8."""
    from scipy.integrate import solve_ivp

    def rate(_: float, y: np.ndarray) -> list[float]:
        a, b, u, w = y
        c, s, g = math.cos(a - b), math.sin(a - b), GRAVITY / LENGTH
        # 2 a'' + c b'' = -s w² - 2 g sin a,  c a'' + b'' = s u² - g sin b
        one, two = -s * w * w - 2.0 * g * math.sin(a), s * u * u - g * math.sin(b)
        return [u, w, (one - c * two) / (2.0 - c * c), (2.0 * two - c * one) / (2.0 - c * c)]

    wanted = np.unique(np.append(0.0, t))
    if len(wanted) == 1:
        flow = np.repeat(np.radians([*START, 0.0, 0.0])[:, None], 1, axis=1)
    else:
        start = [*np.radians(START), 0.0, 0.0]
        flow = solve_ivp(rate, (0.0, wanted[-1]), start, "DOP853", wanted, rtol=1e-13, atol=1e-14).y
    flow = flow[:, np.searchsorted(wanted, t)]
    return flow[:2], flow[2:]


@scenario(tags=("joint", "pendulum", "chaos"), suites=(), ranges={"duration": (0.1, 2.5)})
def double_pendulum(duration: float = 2.0) -> Scenario:
    """Two points on massless rods, one below the other, are let go far out and swing wildly.

    The motion is chaotic: nearby motions part so fast that it can be compared for two seconds and not
    for long.  Until then there is one right answer.
    """
    a, b = np.radians(START)
    upper = np.array([math.sin(a), 0.0, -math.cos(a)]) * LENGTH
    lower = upper + np.array([math.sin(b), 0.0, -math.cos(b)]) * LENGTH
    bobs = [Body(f"bob-{k + 1}", Sphere(0.05), MASS, tuple(x.tolist())) for k, x in enumerate((upper, lower))]
    scene = Scene((Body("pivot", Sphere(0.02)), *bobs), (Gravity(), Rod("pivot", "bob-1"), Rod("bob-1", "bob-2")))

    def truth(t: np.ndarray) -> Trajectory:
        angle, rate = angles(t)
        x = vectors(t), vectors(t)
        motions = {}
        for k in range(2):
            sine, cosine = LENGTH * np.sin(angle[k]), LENGTH * np.cos(angle[k])
            x = x[0] + vectors(t, x=sine, z=-cosine), x[1] + vectors(t, x=rate[k] * cosine, z=rate[k] * sine)
            motions[f"bob-{k + 1}"] = Motion(*x)
        return trajectory(scene, t, motions)

    apart = math.exp(APART * duration)
    fast = 2.0 * math.sqrt(GRAVITY * LENGTH)
    return Scenario(
        scene=scene,
        duration=duration,
        sampling=0.01,
        truth=truth,
        checks=(
            first_order("position error", fast * STEP * apart, "m", "v h, grown by e^(1.5 t) as nearby motions part"),
            first_order(
                "velocity error", GRAVITY * STEP * apart, "m/s", "g h, grown by e^(1.5 t) as nearby motions part"
            ),
        ),
        source="Landau and Lifshitz, Mechanics, §5; Shinbrot et al., Am. J. Phys. 60 (1992) 491",
        about=(Gravity, Rod),
    )
