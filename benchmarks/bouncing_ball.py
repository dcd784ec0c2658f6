"""A ball that bounces five times: apexes and times of impact against their closed forms."""

from __future__ import annotations

import mpmath
from mpmath import mpf

from adapters.run import Run
from benchmarks.engines import alongside, beside, played
from benchmarks.row import Figure, Row
from benchmarks.truths import DIGITS
from mechanics.effects import Gravity, Restitution
from mechanics.scene import Body, Scene
from mechanics.shapes import HalfSpace, Sphere

RADIUS, HEIGHT, E, G = 0.1, 1.1, 0.8, 9.81  # [m], of the centre [m], restitution, [m/s2]


def scene() -> Scene:
    """A ball one metre above a floor."""
    ball = Body("ball", Sphere(RADIUS), mass=1.0, position=(0.0, 0.0, HEIGHT))
    return Scene((Body("floor", HalfSpace()), ball), (Gravity((0.0, 0.0, -G)), Restitution(E)))


def closed(bounces: int) -> tuple[list[mpf], list[mpf], list[mpf]]:
    """Times of impact, times of the apexes after them [s], and the heights of these above the floor [m].

    t_n = √(2h/g) (1 + 2 (e + ... + eⁿ⁻¹)),  h_n = h e²ⁿ.
    """
    with mpmath.workdps(DIGITS):
        h, e, g = mpf(HEIGHT) - mpf(RADIUS), mpf(E), mpf(G)
        fall = mpmath.sqrt(2 * h / g)
        hits = [fall * (1 + 2 * mpmath.fsum(e**k for k in range(1, n))) for n in range(1, bounces + 1)]
        return (
            hits,
            [t + fall * e**n for n, t in enumerate(hits, start=1)],
            [h * e ** (2 * n) for n in range(1, bounces + 1)],
        )


def followed(bounces: int) -> tuple[list[mpf], list[mpf], list[mpf]]:
    """The same by following the ball from impact to impact."""
    with mpmath.workdps(DIGITS):
        g, time, gap, rise = mpf(G), mpf(0), mpf(HEIGHT) - mpf(RADIUS), mpf(0)
        hits, tops, heights = [], [], []
        for _ in range(bounces):
            time += (rise + mpmath.sqrt(rise * rise + 2 * g * gap)) / g
            rise, gap = mpf(E) * mpmath.sqrt(rise * rise + 2 * g * gap), mpf(0)
            hits.append(time)
            tops.append(time + rise / g)
            heights.append(rise * rise / (2 * g))
        return hits, tops, heights


def worst(found: list[float], true: list[mpf]) -> float:
    """Greatest relative error."""
    return max(float(abs(mpf(a) - b) / b) for a, b in zip(found, true, strict=True))


def measure(tiny: bool = False) -> Row:
    """Five bounces at e = 0.8."""
    bounces = 2 if tiny else 5
    truth, other = closed(bounces), followed(bounces)
    if any(
        abs(a - b) > mpf(10) ** (8 - DIGITS)
        for one, two in zip(truth, other, strict=True)
        for a, b in zip(one, two, strict=True)
    ):
        raise ArithmeticError("two routes to the bounces disagree")
    hits, tops, heights = truth
    times = [float(t) for t in tops]

    def apexes(run: Run) -> float:
        return worst([float(z) - RADIUS for z in run.outcome.x[1:, 1, 2]], heights)

    repeats = 1 if tiny else 5
    found = played(scene(), times, repeats=repeats)
    return Row(
        name="bouncing-ball",
        subject=f"a ball that bounces {bounces} times, e = {E:g}",
        figures=(
            Figure("times of impact, relative error", worst([e.time for e in found.events], hits), 1e-14),
            Figure("heights of the apexes, relative error", apexes(found), 1e-14),
        ),
        how=f"sampled at the true times of the apexes; closed forms with {DIGITS} digits, by two routes",
        judged="apexes, relative error",
        beside=(beside(found, apexes), *alongside(scene(), times, apexes, repeats=repeats)),
    )
