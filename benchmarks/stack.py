"""A stack of equal boxes, and a heavy lid on a small one: what each interface carries, and whether they stand."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from adapters.run import Run
from benchmarks.engines import alongside, beside, played
from benchmarks.row import Figure, Row
from mechanics.effects import Gravity, Resting, Rotation
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace

EDGE, G = 0.5, 9.81  # [m], a binary fraction: stacked boxes touch with a gap of 0 bit by bit; [m/s2]
LOADED = 1.0  # after which the loads are read [s]


def scene(masses: tuple[float, ...], velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Scene:
    """Smooth boxes on a floor, from the lowest to the highest, all with one velocity."""
    boxes = tuple(
        Body(f"box-{k}", Box((EDGE, EDGE, EDGE)), m, (0.0, 0.0, (k + 0.5) * EDGE), velocity=velocity)
        for k, m in enumerate(masses)
    )
    return Scene((Body("floor", HalfSpace()), *boxes), (Gravity((0.0, 0.0, -G)), Rotation(), Resting()))


def load_error(masses: tuple[float, ...]) -> Callable[[Run], float]:
    """Worst relative error of what an interface carries at the end of a run: the weight of the boxes above it."""
    names = ("floor", *(f"box-{k}" for k in range(len(masses))))

    def error(run: Run) -> float:
        worst = 0.0
        for k in range(len(masses)):
            pair = {names[k], names[k + 1]}
            carried = math.fsum(abs(c.force[2]) for c in run.contacts if {c.a, c.b} == pair)
            weight = G * math.fsum(masses[k:])
            worst = max(worst, abs(carried / weight - 1.0))
        return worst

    return error


def moved(run: Run) -> float:
    """Greatest displacement of a box from the start to the end [m]."""
    x = run.outcome.x
    return float(np.linalg.norm(x[-1] - x[0], axis=-1).max())


def measure(tiny: bool = False) -> Row:
    """Twenty equal boxes; five under a lid of a million times their mass."""
    equal, lid = ((1.0,) * 3, (1.0,) * 2 + (1e6,)) if tiny else ((1.0,) * 20, (1.0,) * 5 + (1e6,))
    for_long = 1.0 if tiny else 60.0
    figures, every = [], []
    for masses, name, bound in ((equal, "equal boxes", 1e-13), (lid, "lid of 1e6", 1e-12)):
        short = played(scene(masses), [0.0, LOADED])
        stands = played(scene(masses), [0.0, for_long])
        figures += [
            Figure(f"{name}: loads of the interfaces, relative error", load_error(masses)(short), bound),
            Figure(f"{name}: displacement after {for_long:g} s", moved(stands), 1e-12, "m"),
        ]
        every += [beside(short, load_error(masses)), *alongside(scene(masses), [0.0, LOADED], load_error(masses))]
    half = len(every) // 2
    notes = [
        (f"{b.engine}, {name}", b) for name, part in (("equal", every[:half]), ("lid", every[half:])) for b in part
    ]
    return Row(
        name="stack",
        subject=f"a stack of {len(equal)} boxes, and {len(lid) - 1} under a lid of mass ratio 1e6",
        figures=tuple(figures),
        how=f"sums of the contact forces that engines report after {LOADED:g} s against the weight above",
        judged="loads, relative",
        beside=tuple(type(b)(name, b.error, b.seconds, b.note) for name, b in notes),
    )
