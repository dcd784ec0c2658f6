"""Balls with friction: from sliding to rolling, and impacts with spin."""

from __future__ import annotations

import mpmath
from mpmath import mpf

from adapters.run import Run
from benchmarks.engines import alongside, beside, played
from benchmarks.row import Figure, Row
from benchmarks.truths import DIGITS
from mechanics.effects import Friction, Gravity, Restitution, Rotation
from mechanics.scene import Body, Scene
from mechanics.shapes import HalfSpace, Sphere
from scenarios.sliding_to_rolling import RADIUS, sliding_to_rolling
from scenarios.tolerance import GRAVITY

SPEED, MU, E = 3.0, 0.3, 0.75  # [m/s]
SPINS = (-40.0, -3.0, 0.0, 12.0, 60.0)  # [rad/s]
HEIGHT = 1.25  # of the drop [m]


def rolls() -> tuple[mpf, mpf, mpf, mpf]:
    """When a sliding ball begins to roll, and its way, speed and spin then: t = 2 v/(7 µ g) [s, m, m/s, rad/s]."""
    with mpmath.workdps(DIGITS):
        v, g = mpf(SPEED), mpf(MU) * mpf(GRAVITY)
        t = 2 * v / (7 * g)
        return t, v * t - g * t * t / 2, 5 * v / 7, 5 * v / (7 * mpf(RADIUS))


def rolling_error(after: float) -> float:
    """Worst relative error of way, speed and spin `after` seconds, by which time the ball rolls.

    The way holds the time at which it began: x = v t₀ - µ g t₀²/2 + 5/7 v (t - t₀).
    """
    found = played(sliding_to_rolling(SPEED, MU).scene, [0.0, after]).outcome
    with mpmath.workdps(DIGITS):
        t, way, speed, spin = rolls()
        true = (way + speed * (mpf(after) - t), speed, spin)
    values = (found.x[-1, 1, 0] - found.x[0, 1, 0], found.v[-1, 1, 0], found.w[-1, 1, 1])
    return max(float(abs(mpf(float(a)) - b) / b) for a, b in zip(values, true, strict=True))


def drop(spin: float) -> Scene:
    """A ball that falls on a floor, moving along it and spinning about y."""
    ball = Body(
        "ball",
        Sphere(RADIUS),
        1.0,
        (0.0, 0.0, HEIGHT + RADIUS),
        velocity=(SPEED, 0.0, 0.0),
        angular_velocity=(0.0, spin, 0.0),
    )
    return Scene((Body("floor", HalfSpace()), ball), (Gravity(), Friction(MU), Restitution(E), Rotation()))


def bounce(spin: float) -> tuple[mpf, mpf, mpf]:
    """Velocity along the floor, upward velocity and spin after the impact.

    Friction acts until the ball rolls, 2/7 of the slip, or as much as µ (1 + e) times the speed of the fall allows.
    """
    with mpmath.workdps(DIGITS):
        fall = mpmath.sqrt(2 * mpf(GRAVITY) * (mpf(HEIGHT + RADIUS) - mpf(RADIUS)))
        slip = mpf(SPEED) - mpf(RADIUS) * mpf(spin)
        most = mpf(MU) * (1 + mpf(E)) * fall
        change = -mpmath.sign(slip) * min(2 * abs(slip) / 7, most)
        return mpf(SPEED) + change, mpf(E) * fall, mpf(spin) - mpf("2.5") * change / mpf(RADIUS)


def bounce_error(spin: float) -> float:
    """Worst error of the motion after the impact, relative to the speeds before it."""
    with mpmath.workdps(DIGITS):
        fall = mpmath.sqrt(2 * mpf(GRAVITY) * (mpf(HEIGHT + RADIUS) - mpf(RADIUS)))
        hit = fall / mpf(GRAVITY)
    after = float(hit) + 0.01
    found = played(drop(spin), [0.0, after]).outcome
    along, up, turned = bounce(spin)
    with mpmath.workdps(DIGITS):
        true = (along, up - mpf(GRAVITY) * (mpf(after) - hit), turned * mpf(RADIUS))
    values = (found.v[-1, 1, 0], found.v[-1, 1, 2], found.w[-1, 1, 1] * RADIUS)
    scale = max(SPEED, abs(spin) * RADIUS, float(fall))
    return max(float(abs(mpf(float(a)) - b)) for a, b in zip(values, true, strict=True)) / scale


def measure(tiny: bool = False) -> Row:
    """A ball that begins to roll; five balls that bounce with spin."""
    spins = SPINS[1:3] if tiny else SPINS
    t, way, speed, _ = rolls()
    after = 2.0 * float(t)
    scene = sliding_to_rolling(SPEED, MU).scene

    def error(run: Run) -> float:
        x = mpf(float(run.outcome.x[-1, 1, 0] - run.outcome.x[0, 1, 0]))
        true = way + speed * (mpf(after) - t)
        return float(abs(x - true) / true)

    repeats = 1 if tiny else 3
    found = played(scene, [0.0, after], repeats=repeats)
    return Row(
        name="rolling",
        subject="a ball that slides and begins to roll; impacts with spin and friction",
        figures=(
            Figure("sliding to rolling: way, speed, spin, relative error", rolling_error(after), 1e-14),
            Figure(
                f"impacts with {len(spins)} spins: motion after, relative error", max(map(bounce_error, spins)), 1e-14
            ),
        ),
        how=f"closed forms with {DIGITS} digits; the way at twice the time at which it begins to roll holds that time",
        judged="way, relative",
        beside=(beside(found, error), *alongside(scene, [0.0, after], error, repeats=repeats)),
    )
