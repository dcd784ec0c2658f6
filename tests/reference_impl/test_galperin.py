"""Bodies on a line: Galperin's blocks, whose collisions count the digits of pi, and chains of beads.

G. Galperin, Playing pool with pi, Regular and Chaotic Dynamics 8 (2003).
"""

import math

import numpy as np
import pytest

from mechanics.effects import Restitution
from mechanics.scene import Body, Scene
from mechanics.shapes import HalfSpace, Sphere
from reference_impl.bounces.line import CLOCK, DEEP, bounce_in_line
from reference_impl.bounces.loop import DONE
from reference_impl.simulate import advance, begin

WALL = Body("wall", HalfSpace((1.0, 0.0, 0.0)))


def blocks(power):
    """A sphere at rest between a wall and one of 100^power its mass that comes at 1 m/s."""
    return Scene(
        (WALL, Body("small", Sphere(0.1), 1.0, (1.0, 0.0, 0.0)),
         Body("great", Sphere(0.1), 100.0**power, (2.0, 0.0, 0.0), velocity=(-1.0, 0.0, 0.0))),
        (Restitution(1.0),),
    )  # fmt: skip


def velocities(count, power):
    """Of small and great after `count` collisions: in (√m v, √M V) they are reflections, together a rotation."""
    angle = 2.0 * math.atan(10.0**-power) * ((count + 1) // 2)
    sign = 1.0 if count % 2 == 0 else -1.0
    return sign * math.sin(angle) * 10.0**power, -math.cos(angle)


@pytest.mark.parametrize(("power", "count"), [(0, 3), (1, 31), (2, 314), (3, 3141), (4, 31415), (5, 314159)])
def test_collisions_count_the_digits_of_pi(power, count):
    world = begin(blocks(power))
    advance(world, 10.0)
    assert len(world.events) == count
    assert world.state().v[1:, 0] == pytest.approx(velocities(count, power), abs=1e-11 * 10.0**power)
    # unfolded, the great one's distance from the wall is a hyperbola; at the end it is far away on its asymptote
    assert world.audit.gap > -1e-15
    assert world.audit.events == count
    times = np.array([e.time for e in world.events[-1000:]])
    assert (np.diff(times) >= 0.0).all()


def test_eight_digits_in_the_kernel():
    power, row = 7, np.zeros((3, 4))
    row[1] = 1.0, 0.0, 1.0, 0.1
    row[2] = 2.0, -1.0, 100.0**-power, 0.1
    clock, counts = np.zeros(CLOCK), np.zeros(3, dtype=np.int64)
    clock[2:5] = 1e-12, 1e-14, 1e-9
    nothing = np.empty((0, 2), dtype=np.int64), np.empty((0, 8))
    end = bounce_in_line(row, np.array([0.9, 0.8]), np.ones(2), np.arange(3), 0, np.zeros(3), *nothing, clock, counts,
                         10.0, 40_000_000, 50_000_000)  # fmt: skip
    assert end == DONE
    assert counts[0] == 31415926
    assert row[1:, 1] == pytest.approx(velocities(31415926, power), abs=1e-12 * 10.0**power)  # of the greatest speed
    assert clock[DEEP] > -1e-15
