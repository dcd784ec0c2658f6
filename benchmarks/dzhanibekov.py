"""A free body that flips over again and again (Dzhanibekov): its attitude after a hundred seconds."""

from __future__ import annotations

import time

import numpy as np

from adapters.run import Run
from benchmarks.engines import alongside, beside, played
from benchmarks.row import Figure, Row
from benchmarks.truths import agreed, between, tumble, tumble_closed
from mechanics.effects import Rotation
from mechanics.rotation import matrix
from mechanics.scene import Body, Scene
from mechanics.shapes import Sphere
from mechanics.trajectory import Trajectory
from reference_impl.kernels import apply, apply_transposed, kernel, spin_rate
from reference_impl.kernels import matrix as rotation_of

MOMENTS = (1.0, 2.0, 3.0)  # [kg m2]
SPIN = (1e-3, 5.0, 1e-3)  # [rad/s], about the axis of the middle moment but for a thousandth
ACCURACY = 1e-9  # [rad], to be reached by Runge-Kutta steps
START = (1.0, 0.0, 0.0, 0.0)


def scene() -> Scene:
    """One body in a vacuum."""
    return Scene((Body("body", Sphere(1.0), mass=1.0, angular_velocity=SPIN, inertia=MOMENTS),), (Rotation(),))


def drifts(trajectory: Trajectory) -> tuple[float, float]:
    """Relative change of energy and of angular momentum from the first state to the last."""
    inertia = np.diag(MOMENTS)
    momenta, energies = [], []
    for q, w in zip(trajectory.q[:, 0], trajectory.w[:, 0], strict=True):
        rotation = matrix(q)
        momenta.append(rotation @ inertia @ rotation.T @ w)
        energies.append(0.5 * w @ momenta[-1])
    size = np.linalg.norm(momenta[0])
    return abs(energies[-1] / energies[0] - 1.0), float(np.linalg.norm(momenta[-1] - momenta[0]) / size)


@kernel
def runge_kutta(q, momentum, inverse, h, steps):
    """Attitude after `steps` steps of the classical Runge-Kutta method of order four on q' = ½ ω q, L constant."""
    for _ in range(steps):
        k = np.empty((4, 4))
        for stage in range(4):
            at = q.copy()
            if stage > 0:
                reach = h if stage == 3 else 0.5 * h
                for c in range(4):
                    at[c] += reach * k[stage - 1, c]
            r = rotation_of(at)
            k[stage] = spin_rate(at, apply(r, apply(inverse, apply_transposed(r, momentum))))
        size = 0.0
        for c in range(4):
            q[c] += h / 6.0 * (k[0, c] + 2.0 * k[1, c] + 2.0 * k[2, c] + k[3, c])
            size += q[c] * q[c]
        for c in range(4):
            q[c] /= np.sqrt(size)
    return q


def by_steps(duration: float, truth: list, accuracy: float = ACCURACY) -> tuple[float, float]:
    """Wall time [s] and error [rad] of the coarsest Runge-Kutta run, halving the step, within `accuracy`.

    Steps are halved until the error no longer falls; the best there is, if none is good enough.
    """
    momentum = np.array(MOMENTS) * np.array(SPIN)
    inverse = np.diag(1.0 / np.array(MOMENTS))
    runge_kutta(np.array(START), momentum, inverse, 0.01, 1)
    last = np.inf
    per_second = 16
    while True:
        steps = round(per_second * duration)
        q, begun = np.array(START), time.perf_counter()
        runge_kutta(q, momentum, inverse, duration / steps, steps)
        seconds, error = time.perf_counter() - begun, between(q, truth)
        if error <= accuracy or (last < 1e-6 and error > last):
            return seconds, error
        last, per_second = error, 2 * per_second


def measure(tiny: bool = False) -> Row:
    """A hundred seconds, against elliptic functions and against Taylor series with forty digits."""
    duration = 2.0 if tiny else 100.0
    truth = agreed(tumble_closed(MOMENTS, START, SPIN, duration), tumble(MOMENTS, START, SPIN, duration))

    def error(run: Run) -> float:
        return between(run.outcome.q[-1, 0], truth)

    found = played(scene(), [0.0, duration], repeats=2 if tiny else 5)
    energy, momentum = drifts(found.outcome)
    seconds, reached = by_steps(duration, truth)
    return Row(
        name="dzhanibekov",
        subject=f"a body that flips over by itself, {duration:g} s",
        figures=(
            Figure("attitude, error", error(found), 1e-10, "rad"),
            Figure("energy, relative change", energy, 1e-13),
            Figure("angular momentum, relative change", momentum, 1e-13),
            Figure(
                f"times cheaper than Runge-Kutta 4, compiled, with an error of {reached:.1g} rad",
                seconds / found.timing.seconds,
                100.0,
                at_least=True,
            ),
        ),
        how="attitude at the end; truth by elliptic functions and by Taylor series, which agree to 1e-30",
        judged="attitude [rad]",
        beside=(beside(found, error), *alongside(scene(), [0.0, duration], error)),
    )
