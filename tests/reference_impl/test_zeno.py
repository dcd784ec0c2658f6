"""Bounces without end in finite time: where and when they come to rest, and that no threshold shows."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mechanics.effects import Friction, Gravity, Resting, Restitution, Rotation
from mechanics.rotation import about, normalised
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Sphere
from reference_impl import collisions
from reference_impl.simulate import advance, begin
from reference_impl.world import FLYING, STILL, World

G = 9.81
FLOOR = Body("floor", HalfSpace())


def rest_after(height: float, pull: float, e: float) -> float:
    """When a ball dropped from `height` under the acceleration `pull` has bounced for the last time [s]."""
    return math.sqrt(2.0 * height / pull) * (1.0 + e) / (1.0 - e)


def dropped(e: float, height: float, *more, floor: Body = FLOOR, velocity=(0.0, 0.0, 0.0)) -> World:
    ball = Body("ball", Sphere(0.1), 2.0, (0.0, 0.0, 0.1 + height), velocity=velocity)
    return begin(Scene((floor, ball), (Gravity(), Restitution(e), Resting(), *more)))


@pytest.mark.parametrize(("e", "height"), [(0.1, 1.0), (0.5, 1.0), (0.9, 1.0), (0.97, 0.05)])
def test_a_ball_comes_to_rest_when_it_should(e, height):
    """Within the rounding of a time; the height is exact from the last bounce on."""
    world, time = dropped(e, height), rest_after(height, G, e)
    advance(world, 0.999999 * time)
    assert world.state().x[1, 2] >= 0.1
    advance(world, time + 0.1 - world.t)
    assert world.audit.last_bounce == pytest.approx(time, rel=4e-16)
    assert world.state().x[1].tolist() == [0.0, 0.0, 0.1]
    assert world.mode[1] == STILL


@pytest.mark.long
def test_a_ball_that_bounces_eighteen_thousand_times():
    world, time = dropped(0.999, 0.01), rest_after(0.01, G, 0.999)
    advance(world, time + 0.1)
    assert len(world.events) > 15_000
    assert world.audit.last_bounce == pytest.approx(time, rel=4e-16)
    assert world.mode[1] == STILL


@pytest.mark.parametrize("e", [0.5, 0.9])
@pytest.mark.parametrize("degrees", [10.0, 40.0])
def test_on_a_smooth_incline_it_slides_on_as_if_it_had_never_bounced(degrees, e):
    angle = math.radians(degrees)
    slope = Body("slope", HalfSpace(), orientation=tuple(about((0.0, 1.0, 0.0), angle).tolist()))
    up, down = np.array([math.sin(angle), 0.0, math.cos(angle)]), np.array([math.cos(angle), 0.0, -math.sin(angle)])
    ball = Body("ball", Sphere(0.1), 2.0, tuple((0.4 * up).tolist()))
    world = begin(Scene((slope, ball), (Gravity(), Restitution(e), Resting())))
    time = rest_after(0.3, G * math.cos(angle), e)
    advance(world, time + 0.3)
    assert world.audit.last_bounce == pytest.approx(time, rel=1e-14)
    way = 0.5 * G * math.sin(angle) * (time + 0.3) ** 2
    assert world.state().x[1] == pytest.approx(0.1 * up + way * down, abs=1e-14 * max(way, 1.0))


@pytest.mark.parametrize("lift", [-3.0, 4.0])
@pytest.mark.parametrize("e", [0.5, 0.9])
def test_on_an_accelerating_floor_the_relative_acceleration_counts(e, lift):
    floor = Body("floor", Box((2.0, 2.0, 0.2)), position=(0.0, 0.0, -0.1), acceleration=(0.0, 0.0, lift))
    world, time = dropped(e, 0.3, floor=floor), rest_after(0.3, G + lift, e)
    advance(world, time + 0.2)
    assert world.audit.last_bounce == pytest.approx(time, rel=1e-14)
    # a contact keeps the gap at which it was found, up to 1e-12 of the radius, beside the rounding of a place: that of
    # the floor, of the ball, of the truth and of its own sum, half a place each, and of two in the time squared
    place = 0.1 + 0.5 * lift * world.t**2
    assert world.state().x[1, 2] == pytest.approx(place, abs=1e-12 * 0.1 + 4.0 * np.spacing(abs(place)))
    assert sum(h.force for h in world.forces) == pytest.approx(2.0 * (G + lift), rel=1e-12)


@pytest.mark.parametrize("e", [0.3, 0.8])
def test_friction_acts_through_the_bounces_as_through_contact(e):
    """Normal impulses up to t are m (g t + w), w the velocity upwards: while it slides x = v t - µ (g t²/2 + z - h).

    Before, during and after the accumulation alike.
    """
    mu, v = 0.05, 9.0
    world, time = dropped(e, 0.5, Friction(mu), Rotation(), velocity=(v, 0.0, 0.0)), rest_after(0.5, G, e)
    for t in (0.5 * time, 0.9 * time, time, 1.1 * time):
        advance(world, t - world.t)
        state = world.state()
        x = v * t - mu * (0.5 * G * t * t + state.x[1, 2] - 0.6)
        assert state.x[1, 0] == pytest.approx(x, rel=4e-15)
        assert state.v[1, 0] == pytest.approx(v - mu * (G * t + state.v[1, 2]), rel=4e-15, abs=1e-14)


def test_between_walls_without_gravity_it_never_rests():
    walls = (Body("left", HalfSpace((1.0, 0.0, 0.0)), position=(-1.0, 0.0, 0.0)),
             Body("right", HalfSpace((-1.0, 0.0, 0.0)), position=(1.0, 0.0, 0.0)))  # fmt: skip
    ball = Body("ball", Sphere(0.1), 1.0, velocity=(1.0, 0.0, 0.0))
    world = begin(Scene((*walls, ball), (Restitution(0.5), Resting())))
    # 0.9 s to the first wall, then 1.8 s times 2^k
    advance(world, 0.9 + 1.8 * (2.0 + 4.0 + 8.0 + 16.0) + 1.0)
    assert len(world.events) == 5
    assert world.mode[2] == FLYING
    assert abs(world.state().v[2, 0]) == 0.5**5
    assert math.isnan(world.audit.last_bounce)


def test_two_balls_one_above_the_other_come_to_rest():
    low = Body("low", Sphere(0.2), 2.0, (0.0, 0.0, 0.5))
    high = Body("high", Sphere(0.1), 0.5, (0.0, 0.0, 1.0))
    world = begin(Scene((FLOOR, low, high), (Gravity(), Restitution(0.5), Resting())))
    advance(world, 4.0)
    assert (world.mode[1:] == STILL).all()
    assert world.state().x[1:, 2] == pytest.approx((0.2, 0.5), abs=1e-12)
    assert max(world.audit.energy_rise, world.audit.step_rise) <= 1e-13
    loads = {(h.a, h.b): h.force for h in world.forces}
    assert sorted(loads.values()) == pytest.approx([0.5 * G, 2.5 * G], rel=1e-13)


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_the_last_bounce_does_not_show(factor, monkeypatch):
    """Half or twice as long a last bounce changes nothing beyond rounding."""
    ends = []
    for last in (collisions.LAST_ALONE, factor * collisions.LAST_ALONE):
        monkeypatch.setattr(collisions, "LAST_ALONE", last)
        world = dropped(0.8, 0.3, Friction(0.1), Rotation(), velocity=(3.0, 0.0, 0.0))
        advance(world, 4.0)
        ends.append((world.state(), world.audit.last_bounce))
    (a, first), (b, second) = ends
    assert first == pytest.approx(second, rel=4e-16)
    # a rough impact rounds four times (impulse, friction, two sums), by half a place of 3 m/s; this is carried along
    # for 4 s, and each of the flights rounds a place below 16 m
    rounding = 2.0 * len(world.events) * np.spacing(3.0)
    assert a.v[1] == pytest.approx(b.v[1], abs=rounding)
    assert a.x[1] == pytest.approx(b.x[1], abs=4.0 * rounding + 0.5 * len(world.events) * np.spacing(8.0))


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_where_a_box_rests_hardly_depends_on_when_its_corners_do(factor, monkeypatch):
    """Bounces of a corner that last less than a thousandth of the scene's time are skipped, together."""
    q = tuple(about((0.0, 1.0, 0.0), 0.2).tolist())
    ends = []
    for limit in (collisions.ACCUMULATION, factor * collisions.ACCUMULATION):
        monkeypatch.setattr(collisions, "ACCUMULATION", limit)
        box = Body("box", Box((0.5, 0.3, 0.2)), 2.0, (0.0, 0.0, 0.5), q, velocity=(0.4, 0.0, 0.0))
        world = begin(Scene((FLOOR, box), (Gravity(), Rotation(), Restitution(0.4), Friction(0.5), Resting())))
        advance(world, 3.0)
        assert world.mode[1] == STILL
        ends.append(world.state())
    assert ends[0].x[1, 2] == pytest.approx(0.1, abs=1e-12)
    assert ends[0].x[1] == pytest.approx(ends[1].x[1], abs=1e-3)
    assert ends[0].q[1] == pytest.approx(ends[1].q[1], abs=1e-12)


def test_a_corner_rests_while_the_box_still_moves():
    """A box dropped on one edge, e = 0.5, without friction: energy never rises, and it lies flat in the end."""
    q = tuple(normalised(np.array((1.0, 0.0, 0.08, 0.0))).tolist())
    box = Body("box", Box((0.5, 0.3, 0.2)), 2.0, (0.0, 0.0, 0.4), q)
    world = begin(Scene((FLOOR, box), (Gravity(), Rotation(), Restitution(0.5), Resting())))
    advance(world, 4.0)
    assert world.state().x[1, 2] == pytest.approx(0.1, abs=1e-11)
    assert max(world.audit.energy_rise, world.audit.step_rise) <= 1e-11
    assert world.audit.gap >= -1e-11
