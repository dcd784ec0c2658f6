"""Degenerate impacts: bounces that accumulate, and what happens where impulses are not unique."""

import math

import numpy as np
import pytest

from mechanics.effects import Drag, Gravity, Resting, Restitution, Rotation
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Sphere
from reference_impl.settings import Settings
from reference_impl.simulate import advance, begin
from reference_impl.world import STILL

FLOOR = Body("floor", HalfSpace())


def ball(height, radius=0.1, **told):
    return Body("ball", Sphere(radius), 1.0, (0.0, 0.0, height + radius), **told)


@pytest.mark.parametrize("law", ["propagation", "sequential", "simultaneous"])
@pytest.mark.parametrize("e", [0.0, 0.3, 0.5, 0.8, 0.95])
def test_bounces_accumulate_where_the_series_says(e, law):
    """t∞ = √(2h/g) (1 + e) / (1 - e), whatever the number of bounces; afterwards the ball lies still."""
    world = begin(Scene((FLOOR, ball(0.5)), (Gravity(), Restitution(e), Resting())), Settings(impact_law=law))
    end = math.sqrt(1.0 / 9.81) * (1.0 + e) / (1.0 - e)
    advance(world, 1.001 * end)
    if e > 0.0:
        assert world.audit.last_bounce == pytest.approx(end, rel=1e-12 / (1.0 - e))
    assert world.mode[1] == STILL
    assert world.state().x[1, 2] == pytest.approx(0.1, abs=1e-14)


@pytest.mark.parametrize(
    ("height", "velocity"),
    [(1.5e3, (0.0, 0.0, 0.0)), (-1.38, (0.7, -0.3, 2.4)), (2.0, (20.0, 0.0, 0.0)), (0.0, (0.0, 0.0, -1e-6))],
    ids=["far up", "below the origin", "fast sideways", "slow"],
)
def test_bounces_end_where_rounding_alone_would_keep_them_up(height, velocity):
    """Positions are rounded: far from the origin, or beside a fast motion, the last bounces are noise."""
    floor = Body("floor", HalfSpace(), position=(0.0, 0.0, height))
    body = Body("ball", Sphere(0.11853493896012271), 2.0, (0.0, 0.0, height + 0.3), velocity=velocity)
    world = begin(Scene((floor, body), (Gravity(), Restitution(0.3), Resting())))
    advance(world, 2.0)
    fall = body.position[2] - height - body.shape.radius
    up, g = velocity[2], 9.81
    speed = math.sqrt(up * up + 2.0 * g * fall)
    end = (up + speed) / g + 2.0 * 0.3 * speed / (g * 0.7)
    # the time of the last bounce is known to what a rounding of the height makes of it
    grain = np.spacing(abs(height) + 0.3)
    assert world.audit.last_bounce == pytest.approx(end, abs=1e-14 + 20.0 * math.sqrt(grain / g))
    assert len(world.events) < 60
    assert abs(world.state().v[1, 2]) <= 1e-15
    assert world.state().x[1, 2] == pytest.approx(height + body.shape.radius, abs=4.0 * grain + 1e-14)


def test_bounces_end_on_a_floor_that_moves():
    slab = Body("floor", Box((80.0, 80.0, 1.0)), position=(0.0, 0.0, -0.5), velocity=(5.0, 0.0, 2.0))
    world = begin(Scene((slab, ball(0.4)), (Gravity(), Restitution(0.5), Resting())))
    advance(world, 2.0)
    assert len(world.events) < 60
    # lasting contact with a floor that moves is integrated, to 1e-12
    assert world.state().v[1] == pytest.approx((0.0, 0.0, 2.0), abs=1e-12)
    assert world.state().x[1, 2] == pytest.approx(0.1 + 4.0, abs=1e-12)


def test_bounces_in_the_air_end_too():
    world = begin(Scene((FLOOR, ball(0.5)), (Gravity(), Restitution(0.5), Resting(), Drag(0.2))))
    advance(world, 4.0)
    assert world.mode[1] == STILL


def test_an_edge_that_hangs_over_slides_off_and_turns():
    """A plate falls with its edge on a smaller box: two axes separate them equally well, and only one does so for long.

    Energy and momentum across the floor are kept.
    """
    lower = Body("lower", Box((0.5, 0.4, 0.5)), 0.5, (0.5, -0.5, 0.25), velocity=(1.0, -1.0, 0.0),
                 angular_velocity=(0.0, -3.0, 0.0))  # fmt: skip
    upper = Body("upper", Box((0.25, 0.5, 0.5)), 0.08, (0.5, -0.5, 1.45), velocity=(0.0, 0.0, 1.0),
                 angular_velocity=(0.0, 1.0, 2.0))  # fmt: skip
    scene = Scene((FLOOR, lower, upper), (Gravity(), Rotation(), Restitution(1.0), Resting()))
    world = begin(scene)
    advance(world, 1.0)
    end = world.state()
    assert 0.5 * end.v[1, :2] + 0.08 * end.v[2, :2] == pytest.approx((0.5, -0.5), abs=1e-12)
    assert len(world.events) < 1000
