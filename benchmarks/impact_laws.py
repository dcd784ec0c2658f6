"""Several impacts at one instant, under the law that is named: what simple arithmetic says, bit by bit."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np

from benchmarks.engines import played
from benchmarks.row import Figure, Row
from mechanics.effects import Gravity, Resting, Restitution, Rotation
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Sphere

RADIUS = 0.0625  # [m], a binary fraction: touching is a gap of 0 bit by bit
RUN_UP = 0.25  # [m]


def line(masses: tuple[float, ...], launched: int, e: float) -> Scene:
    """Balls in a row that touch, the first `launched` of them on their way in as one at 1 m/s."""
    balls = tuple(
        Body(
            f"ball-{k}",
            Sphere(RADIUS),
            m,
            (2.0 * RADIUS * k - (RUN_UP if k < launched else 0.0), 0.0, 0.0),
            velocity=(1.0 if k < launched else 0.0, 0.0, 0.0),
        )
        for k, m in enumerate(masses)
    )
    return Scene(balls, (Restitution(e),))


def separated(masses: tuple[float, ...], launched: int, e: float) -> list[float]:
    """Velocities in the limit of small gaps: pair after pair, in whole-number arithmetic.

    The approaching pair that is met first is of no consequence where at most two bodies meet at once, which is
    so for one ball striking a row; for more of them and equal masses every order leads to the same end.
    """
    m, v = [Fraction(x) for x in masses], [Fraction(int(k < launched)) for k in range(len(masses))]
    factor = 1 + Fraction(e)
    while True:
        pair = next((k for k in range(len(m) - 1) if v[k] > v[k + 1]), None)
        if pair is None:
            return [float(x) for x in v]
        impulse = factor * (v[pair] - v[pair + 1]) * m[pair] * m[pair + 1] / (m[pair] + m[pair + 1])
        v[pair] -= impulse / m[pair]
        v[pair + 1] += impulse / m[pair + 1]


def line_error(masses: tuple[float, ...], launched: int, e: float = 1.0) -> float:
    """Greatest error of a velocity after the impact [m/s]."""
    found = played(line(masses, launched, e), [0.0, 2.0 * RUN_UP]).outcome
    return float(np.abs(found.v[-1, :, 0] - separated(masses, launched, e)).max())


def break_error() -> float:
    """A ball into two that touch, from the side on which it meets both at once: -1/5, and 3/5 and ± √3/5 [m/s]."""
    h = math.sqrt(3.0) * RADIUS
    places = ((-RUN_UP - h, 0.0, 0.0), (0.0, 0.0, RADIUS), (0.0, 0.0, -RADIUS))
    balls = tuple(
        Body(f"ball-{k}", Sphere(RADIUS), 1.0, x, velocity=(1.0 if k == 0 else 0.0, 0.0, 0.0))
        for k, x in enumerate(places)
    )
    v = played(Scene(balls, (Restitution(1.0),)), [0.0, 2.0 * RUN_UP]).outcome.v[-1]
    true = np.array([[-0.2, 0.0, 0.0], [0.6, 0.0, math.sqrt(3.0) / 5.0], [0.6, 0.0, -math.sqrt(3.0) / 5.0]])
    return float(np.abs(v - true).max())


def landing_error(e: float) -> float:
    """A box that lands flat rises with e times its speed, u = √(2 g h), and does not turn [relative to u]."""
    box = Body("box", Box((1.0, 0.5, 0.25)), 1.0, (0.0, 0.0, 0.375))
    scene = Scene((Body("floor", HalfSpace()), box), (Gravity(), Rotation(), Restitution(e), Resting()))
    speed = math.sqrt(2.0 * 9.81 * 0.25)
    after = 1e-3  # [s]
    found = played(scene, [0.0, speed / 9.81 + after]).outcome
    rise = float(found.v[-1, 1, 2]) + (9.81 * after if e > 0.0 else 0.0)
    return max(abs(rise - e * speed), float(np.abs(found.w[-1, 1]).max())) / speed


def measure(tiny: bool = False) -> Row:
    """Every number of balls into every longer row; chains of unequal masses; a break; a box that lands flat."""
    most = 4 if tiny else 7
    cradles = max(line_error((1.0,) * n, k) for n in range(2, most + 1) for k in range(1, n))
    chains = max(line_error(m, 1) for m in ((3.0, 1.0, 1.0, 1.0), (1.0, 3.0, 1.0), (27.0, 9.0, 3.0, 1.0)))
    lossy = line_error((1.0,) * 5, 1, 0.75)
    return Row(
        name="impact-laws",
        subject="several impacts at one instant, law `propagation`",
        figures=(
            Figure(f"cradles, k balls into n - k, n up to {most}: velocities, error", cradles, 1e-14, "m/s"),
            Figure("chains 3:1:1:1, 1:3:1, 27:9:3:1: velocities, error", chains, 1e-14, "m/s"),
            Figure("cradle of five at e = 0.75: velocities, error", lossy, 1e-14, "m/s"),
            Figure("symmetric break of two balls: velocities, error", break_error(), 1e-14, "m/s"),
            Figure(
                "box that lands flat, e = 0, 0.5, 1: velocity and spin, relative error",
                max(landing_error(e) for e in (0.0, 0.5, 1.0)),
                1e-13,
            ),
        ),
        how="against fractions, pair after pair, and closed forms; engines without this law answer another question",
    )
