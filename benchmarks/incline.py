"""A block on an inclined plane for a second: whether it stays where it must, and how far it slides where not."""

from __future__ import annotations

from collections.abc import Callable

import mpmath
import numpy as np
from mpmath import mpf

from adapters.run import Run
from benchmarks.engines import alongside, beside, played
from benchmarks.row import Beside, Figure, Row
from benchmarks.truths import DIGITS
from scenarios.incline import incline
from scenarios.tolerance import GRAVITY

MU = 0.5  # the block stays up to an angle of 26.565 degrees
ANGLES = (20.0, 26.5, 30.0, 45.0)
DURATION = 1.0  # [s]


def way(angle: float) -> mpf:
    """How far the block has slid after `DURATION` [m]: g (sin α - µ cos α) t²/2, or not at all."""
    with mpmath.workdps(DIGITS):
        a = mpmath.radians(mpf(angle))
        pull = mpf(GRAVITY) * (mpmath.sin(a) - mpf(MU) * mpmath.cos(a))
        return max(pull, mpf(0)) * mpf(DURATION) ** 2 / 2


def position_error(angle: float) -> Callable[[Run], float]:
    """Distance of the block from where it must be at the end [m]."""
    a = np.radians(angle)
    down = np.array([np.cos(a), 0.0, -np.sin(a)])

    def error(run: Run) -> float:
        x = run.outcome.x[:, 1]
        return float(np.linalg.norm(x[-1] - x[0] - float(way(angle)) * down))

    return error


def measure(tiny: bool = False) -> Row:
    """Two angles at which friction holds, two at which it does not."""
    angles = ANGLES[1:3] if tiny else ANGLES
    figures: list[Figure] = []
    worst: dict[str, list[Beside]] = {}
    for angle in angles:
        scene, error = incline(mu=MU, slope=angle).scene, position_error(angle)
        found = beside(played(scene, [0.0, DURATION], repeats=1 if tiny else 3), error)
        does = "slides" if way(angle) > 0 else "stays"
        figures.append(Figure(f"{angle:g} degrees, {does}: position, error", found.error, 1e-13, "m"))
        for b in (found, *alongside(scene, [0.0, DURATION], error, repeats=1 if tiny else 3)):
            worst.setdefault(b.engine, []).append(b)
    return Row(
        name="incline",
        subject=f"a block on an incline, friction {MU:g}, {DURATION:g} s",
        figures=tuple(figures),
        how=f"against g (sin α - µ cos α) t²/2 with {DIGITS} digits",
        judged="worst position [m]",
        beside=tuple(
            Beside(
                name,
                max(b.error for b in all_),
                sum(b.seconds for b in all_),
                next((b.note for b in all_ if b.note), ""),
            )
            for name, all_ in worst.items()
        ),
    )
