"""Galperin's blocks: collisions that count the digits of pi, in the engine and in its kernel."""

from __future__ import annotations

import math
import time

import numpy as np

from benchmarks.row import Figure, Row
from mechanics.effects import Restitution
from mechanics.scene import Body, Scene
from mechanics.shapes import HalfSpace, Sphere
from reference_impl.bounces.line import CLOCK, bounce_in_line
from reference_impl.simulate import advance, begin

RADIUS = 0.1  # [m]


def scene(power: int) -> Scene:
    """A ball at rest between a wall and one of 100^power its mass that comes at 1 m/s."""
    wall = Body("wall", HalfSpace((1.0, 0.0, 0.0)))
    small = Body("small", Sphere(RADIUS), 1.0, (1.0, 0.0, 0.0))
    great = Body("great", Sphere(RADIUS), 100.0**power, (2.0, 0.0, 0.0), velocity=(-1.0, 0.0, 0.0))
    return Scene((wall, small, great), (Restitution(1.0),))


def digits(power: int) -> int:
    """How many collisions there are: the first power + 1 digits of pi, unless many nines follow (Galperin 2003)."""
    return int(math.pi * 10.0**power)


def in_the_engine(power: int) -> tuple[int, float]:
    """Collisions that the engine records, and wall time [s]."""
    world = begin(scene(power))
    begun = time.perf_counter()
    advance(world, 10.0)
    return len(world.events), time.perf_counter() - begun


def in_the_kernel(power: int) -> tuple[int, float]:
    """Collisions that the kernel of bodies on a line counts, none of them recorded, and wall time [s]."""
    row, clock, counts = np.zeros((3, 4)), np.zeros(CLOCK), np.zeros(3, dtype=np.int64)
    row[1] = 1.0, 0.0, 1.0, RADIUS  # coordinate, velocity, inverse mass, radius
    row[2] = 2.0, -1.0, 100.0**-power, RADIUS
    clock[2:5] = 1e-12, 1e-14, 1e-9
    gaps = np.array([1.0 - RADIUS, 1.0 - 2.0 * RADIUS])
    record = np.empty((0, 2), dtype=np.int64), np.empty((0, 8))
    begun = time.perf_counter()
    bounce_in_line(row, gaps, np.ones(2), np.arange(3), 0, np.zeros(3), *record, clock, counts, 10.0, 10**9, 10**9)
    return int(counts[0]), time.perf_counter() - begun


def measure(tiny: bool = False) -> Row:
    """Six digits in the engine, eight in its kernel."""
    recorded, counted = (2, 3) if tiny else (5, 7)
    in_the_engine(1)
    in_the_kernel(1)
    found, seconds = in_the_engine(recorded)
    count, kernel_seconds = in_the_kernel(counted)
    return Row(
        name="galperin",
        subject=f"Galperin's blocks, mass ratios 100^{recorded} and 100^{counted}",
        figures=(
            Figure(f"collisions recorded by the engine, less {digits(recorded):,}", abs(found - digits(recorded)), 0.0),
            Figure(f"collisions counted by the kernel, less {digits(counted):,}", abs(count - digits(counted)), 0.0),
            Figure("wall time of the kernel", kernel_seconds, 1.0, "s"),
        ),
        how=f"the engine takes {1e6 * seconds / found:.2g} µs a collision and records each; the kernel takes "
        f"{1e9 * kernel_seconds / count:.2g} ns and records none; stepping engines cannot: the last collisions are "
        "closer together than any step",
    )
