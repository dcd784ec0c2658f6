"""Five hundred bodies that turn and bounce on a floor: what a simulated second costs in each engine."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from adapters.run import Run
from benchmarks.engines import alongside, beside, fastest, played, unread
from benchmarks.row import Figure, Row
from mechanics.effects import Gravity, Restitution, Rotation
from mechanics.scene import Body, Scene
from mechanics.shapes import HalfSpace, Sphere
from scenarios.bouncing_ball import bounce

RADIUS, E, APART = 0.1, 0.8, 1.0  # [m], restitution, [m]
SAMPLING = 1.0 / 60.0  # [s]


def heights(count: int) -> np.ndarray:
    """Clearances at the start [m]."""
    return np.random.default_rng(2027).uniform(0.5, 2.0, count)


def scene(count: int, planar: bool = False) -> Scene:
    """Spinning balls above a floor, in a square lattice or in one plane, too far apart to meet."""
    rng = np.random.default_rng(5)
    side = count if planar else int(np.ceil(np.sqrt(count)))
    balls = []
    for k, h in enumerate(heights(count).tolist()):
        spin = (0.0, float(rng.normal()), 0.0) if planar else tuple((5.0 * rng.normal(size=3)).tolist())
        place = (APART * (k % side), APART * (k // side), RADIUS + h)
        balls.append(Body(f"ball-{k}", Sphere(RADIUS), 1.0, place, angular_velocity=spin))
    return Scene((Body("floor", HalfSpace()), *balls), (Gravity(), Rotation(), Restitution(E)))


def height_error(count: int) -> Callable[[Run], float]:
    """Worst error of a height at a sample [m]."""

    def error(run: Run) -> float:
        path = run.outcome
        true = np.stack([bounce(path.t, h, E)[0] for h in heights(count).tolist()], axis=1)
        return float(np.abs(path.x[:, 1:, 2] - RADIUS - true).max())

    return error


def measure(tiny: bool = False) -> Row:
    """One second at 60 samples, in space and in one plane, where pymunk can follow; read at each sample, and never."""
    count, samples = (5, 6) if tiny else (500, 60)
    times = [k * SAMPLING for k in range(samples + 1)]
    error = height_error(count)
    figures, rows = [], []
    for where, planar, others in (
        ("in space", False, ("pybullet", "mujoco")),
        ("in a plane", True, ("pybullet", "mujoco", "pymunk")),
    ):
        balls = scene(count, planar)
        ours = beside(played(balls, times, repeats=1 if tiny else 3), error)
        theirs = alongside(balls, times, error, others, repeats=1 if tiny else 2)
        best = fastest(theirs)
        answered = [b.engine for b in theirs if math.isfinite(b.seconds)]
        alone = {name: unread(balls, times, name) for name in (ours.engine, *answered)}
        blind = min(answered, key=lambda name: alone[name])
        figures += [
            Figure(f"{where}, read {samples} times: speed over that of the fastest engine, {best.engine}",
                   best.seconds / ours.seconds, 5.0, at_least=True),
            Figure(f"{where}, never read: speed over that of the fastest engine, {blind}",
                   alone[blind] / alone[ours.engine], 5.0, at_least=True),
        ]  # fmt: skip
        rows += [
            replace(b, engine=f"{b.engine}, {where}", note=b.note or f"never read {alone[b.engine]:.3g} s")
            for b in (ours, *theirs)
        ]
    return Row(
        name="free-bodies",
        subject=f"{count} bodies that turn and bounce, {samples / 60:g} s",
        figures=tuple(figures),
        how=f"balls too far apart to meet, {samples} calls; wall times are those of getting to each sample with its "
        "state ready, reading it is not clocked; engines take the steps of their fair profiles, 1 ms; where nobody "
        "reads, the reference finds out where its bodies are when it is asked, the others have no choice",
        missed="pymunk computes in two dimensions and takes 74 ns for a step of a ball; a thousand steps are 13 mm off",
        judged="height [m]",
        beside=tuple(rows),
    )
