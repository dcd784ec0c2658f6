"""Islands in lasting contact: each on its own clock, and none the wiser for what the others do."""

import numpy as np
import pytest

from mechanics.effects import Friction, Gravity, Resting, Restitution, Rotation
from mechanics.rotation import about
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Sphere
from reference_impl.simulate import advance, begin

FLOOR = Body("floor", HalfSpace())
EFFECTS = (Gravity(), Rotation(), Resting(), Restitution(0.4))


def leaning(name, x, angle):
    """A box that stands on one edge and topples."""
    q = about((0.0, 1.0, 0.0), angle)
    height = 0.5 * (0.4 * abs(np.cos(angle)) + 0.3 * abs(np.sin(angle)))
    return Body(name, Box((0.3, 0.5, 0.4)), 2.0, (x, 0.0, float(height)), tuple(q.tolist()))


def thrown(name, x, height):
    """A box that comes from above, turning."""
    return Body(name, Box((0.3, 0.5, 0.4)), 1.0, (x, 0.0, height), tuple(about((0.6, 0.8, 0.0), 0.4).tolist()),
                angular_velocity=(1.0, 2.0, -0.5))  # fmt: skip


# of one size and pace, so that the scales of length and time are those of each alone
ONE = (leaning("one", 0.0, 0.3), thrown("above", 5.0, 1.2))
OTHER = (leaning("other", 20.0, 0.5), Body("ball", Sphere(0.4), 1.0, (25.0, 0.0, 1.0), velocity=(0.5, 0.0, 0.0)))


def course(bodies, effects, times):
    world = begin(Scene((FLOOR, *bodies), effects))
    states = []
    for t in times:
        advance(world, t - world.t)
        states.append(world.state())
    return world, states


@pytest.mark.parametrize("mu", [None, 0.4])
def test_two_islands_together_move_as_each_alone(mu):
    effects = EFFECTS if mu is None else (*EFFECTS, Friction(mu))
    times = [0.1 * k for k in range(1, 13)]
    _, both = course((*ONE, *OTHER), effects, times)
    _, first = course(ONE, effects, times)
    _, second = course(OTHER, effects, times)
    for together, left, right in zip(both, first, second, strict=True):
        for name in ("x", "q", "v", "w"):
            whole = getattr(together, name)
            assert np.array_equal(whole[1:3], getattr(left, name)[1:])
            assert np.array_equal(whole[3:], getattr(right, name)[1:])


@pytest.mark.parametrize("mu", [None, 0.4])
def test_looking_changes_nothing(mu):
    effects = EFFECTS if mu is None else (*EFFECTS, Friction(mu))
    _, often = course(ONE, effects, [0.01 * k for k in range(1, 100)] + [1.0])
    _, once = course(ONE, effects, [1.0])
    for name in ("x", "q", "v", "w"):
        assert np.array_equal(getattr(often[-1], name), getattr(once[-1], name))
