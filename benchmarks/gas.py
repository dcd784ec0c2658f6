"""An elastic gas of a hundred spheres in a box: energy kept, and seconds simulated per second.

What a second costs is what its impacts cost, and larger spheres at the same speed meet less often: one gas is of
marbles, one of boulders, both at the same filling.
"""

from __future__ import annotations

import numpy as np

from adapters.run import Run
from benchmarks.engines import alongside, beside, played
from benchmarks.row import Figure, Row
from mechanics.effects import Gravity, Restitution
from mechanics.scene import Body, Scene
from mechanics.shapes import HalfSpace, Sphere

SMALL, LARGE = 0.05, 0.5  # radii [m]
FILLING, SPEED = 0.1, 1.0  # of the volume, of each component [m/s]
SAMPLING = 0.1  # [s]


def scene(count: int, radius: float = SMALL) -> Scene:
    """Equal spheres between six walls, e = 1, with gravity; their places on a lattice, their velocities at random."""
    edge = (count * 4.0 / 3.0 * np.pi * radius**3 / FILLING) ** (1.0 / 3.0)
    walls = [
        Body(f"wall-{axis}{'+-'[side]}", HalfSpace(tuple(n.tolist())), position=tuple((0.5 * edge * (1 - n)).tolist()))
        for axis in range(3)
        for side, n in enumerate((np.eye(3)[axis], -np.eye(3)[axis]))
    ]
    rng = np.random.default_rng(2027)
    per_edge = int(np.ceil(count ** (1.0 / 3.0)))
    places = (np.array(list(np.ndindex(per_edge, per_edge, per_edge)))[:count] + 0.5) * edge / per_edge
    velocities = SPEED * rng.normal(size=(count, 3))
    spheres = [
        Body(f"sphere-{k}", Sphere(radius), 1.0, tuple(x.tolist()), velocity=tuple(v.tolist()))
        for k, (x, v) in enumerate(zip(places, velocities, strict=True))
    ]
    return Scene((*walls, *spheres), (Gravity(), Restitution(1.0)))


def energy_error(run: Run) -> float:
    """Greatest relative change of kinetic and potential energy."""
    x, v = run.outcome.x[:, 6:], run.outcome.v[:, 6:]
    energy = (0.5 * (v**2).sum(axis=2) + 9.81 * x[:, :, 2]).sum(axis=1)
    return float(np.abs(energy / energy[0] - 1.0).max())


def measure(tiny: bool = False) -> Row:
    """Ten seconds; other engines one second, because most take longer than that."""
    count, duration, shorter = (8, 0.2, 0.1) if tiny else (100, 10.0, 1.0)
    times = np.arange(0.0, duration + 0.5 * SAMPLING, SAMPLING)
    figures = []
    for radius in (SMALL, LARGE):
        found = played(scene(count, radius), times, repeats=1 if tiny else 5)
        ours, rate = beside(found, energy_error), len(found.events) / duration
        gas = f"radius {radius:g} m, {rate:.0f} impacts/s"
        figures += [
            Figure(f"{gas}: energy, greatest relative change", ours.error, 1e-13),
            Figure(f"{gas}: simulated time over wall time", duration / ours.seconds, 200.0, at_least=True),
        ]
    short = times[times <= shorter + 0.5 * SAMPLING]
    return Row(
        name="gas",
        subject=f"an elastic gas of {count} spheres, {duration:g} s",
        figures=tuple(figures),
        how=f"filling {FILLING:g}, gravity on; engines beside it for {shorter:g} s, radius {SMALL:g} m",
        missed="an impact costs 1.9 µs, which is 200 times real time for marbles if nobody asks where they are, and "
        "175 if they are stopped ten times a second; a machine that does other things beside takes the rest",
        judged=f"energy, relative, in {shorter:g} s",
        beside=(
            beside(played(scene(count), short, repeats=1 if tiny else 5), energy_error),
            *alongside(scene(count), short, energy_error, repeats=1 if tiny else 2),
        ),
    )
