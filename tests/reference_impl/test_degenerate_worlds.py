"""Degenerate worlds: very many bodies, very unequal ones, very fast spins, bodies in one place, bounces without end."""

import math

import numpy as np
import pytest

from mechanics.effects import Friction, Gravity, Resting, Restitution, Rod, Rotation
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Sphere
from reference_impl.errors import Overlap
from reference_impl.reactions import joint_forces
from reference_impl.simulate import advance, begin
from reference_impl.world import STILL

G = 9.81
FLOOR = Body("floor", HalfSpace())


@pytest.mark.parametrize("count", [300, pytest.param(2000, marks=pytest.mark.long)])
def test_a_field_of_boxes_comes_to_proven_rest_at_once(count):
    """Four contacts under every box: as many islands as boxes, one look at each, and the floor carries them all."""
    edge = math.isqrt(count - 1) + 1
    boxes = [Body(f"b{i}", Box((0.2, 0.2, 0.2)), 1.0, (0.3 * (i % edge), 0.3 * (i // edge), 0.1)) for i in range(count)]
    world = begin(Scene((FLOOR, *boxes), (Gravity(), Rotation(), Resting())))
    start = world.state().x
    advance(world, 1.0)
    assert (world.mode[1:] == STILL).all()
    assert world.audit.events == world.audit.rests == count
    assert world.audit.steps == 0
    assert len(world.forces) == 4 * count
    assert math.fsum(h.force for h in world.forces) == pytest.approx(count * G, rel=1e-14)
    assert np.abs(world.state().x - start).max() <= 1e-15


def test_a_chain_of_two_hundred_links_hangs():
    """Each link carries the weights below it, and nothing moves by a bit."""
    count = 200
    links = [Body(f"m{k}", Sphere(0.01), 1.0, (0.0, 0.0, -0.0625 * (k + 1))) for k in range(count)]
    bodies = (Body("pin", Sphere(0.01)), *links)
    rods = [Rod(a.name, b.name) for a, b in zip(bodies, links, strict=False)]
    world = begin(Scene(bodies, (Gravity(), *rods)))
    start = world.state().x
    advance(world, 1.0)
    assert (world.mode[1:] == STILL).all()
    assert (world.state().x == start).all()
    pull = sorted(abs(f.force[2]) for f in joint_forces(world))
    # the condition of its rows is about their number, and each force feels the rounding of the greatest
    assert pull == pytest.approx([G * (k + 1) for k in range(count)], abs=count * 2.2e-16 * G * count)


@pytest.mark.parametrize("ratio", [1e8, 1e-8])
def test_head_on_at_a_hundred_million_to_one(ratio):
    """v1' = v (m1 - m2) / (m1 + m2), v2' = 2 v m1 / (m1 + m2), each to the rounding of its own size."""
    a = Body("a", Sphere(0.1), ratio, (-0.5, 0.0, 0.0), velocity=(1.0, 0.0, 0.0))
    world = begin(Scene((a, Body("b", Sphere(0.1), 1.0, (0.5, 0.0, 0.0))), (Restitution(1.0),)))
    advance(world, 1.0)
    expected = ((ratio - 1.0) / (ratio + 1.0), 2.0 * ratio / (ratio + 1.0))
    assert world.state().v[:, 0] == pytest.approx(expected, rel=4e-16)
    assert world.audit.imbalance <= 1e-15


@pytest.mark.parametrize("spin", [1e4, -1e4])
def test_a_ball_that_spins_ten_thousand_rad_per_second_lands_on_a_rough_floor(spin):
    """It slips through the whole impact: friction gives µ (1 + e) u along, and takes 5/2 of that over r of the spin."""
    radius, e, mu, height = 0.1, 0.5, 0.3, 1.0
    ball = Body("ball", Sphere(radius), 2.0, (0.0, 0.0, radius + height), angular_velocity=(0.0, spin, 0.0))
    world = begin(Scene((FLOOR, ball), (Gravity(), Rotation(), Restitution(e), Friction(mu), Resting())))
    advance(world, 0.6)
    struck = (1.0 + e) * math.sqrt(2.0 * G * height)
    state, way = world.state(), math.copysign(1.0, spin)
    assert state.v[1, 0] == pytest.approx(way * mu * struck, rel=1e-14)
    assert state.w[1, 1] == pytest.approx(spin - way * 2.5 * mu * struck / radius, rel=1e-15)
    assert abs(state.w[1, 0]) + abs(state.w[1, 2]) == 0.0


@pytest.mark.parametrize("shape", [Sphere(0.1), Box((0.2, 0.2, 0.2))])
def test_bodies_in_one_place_are_refused_by_name(shape):
    bodies = (Body("one", shape, 1.0, (0.3, 0.2, 0.1)), Body("two", shape, 1.0, (0.3, 0.2, 0.1)))
    with pytest.raises(Overlap, match=r"overlap by 0\.2 m at t = 0 s") as error:
        begin(Scene(bodies, (Restitution(0.5), Rotation())))
    assert set(error.value.bodies) == {"one", "two"}


@pytest.mark.parametrize("away", [0.0, 0.1, 0.2])
def test_fixed_bodies_may_overlap_or_touch_and_nothing_comes_of_it(away):
    """Infinite masses on both sides are no contact; a ball beside them falls as if they were not there."""
    posts = (Body("p", Box((0.2, 0.2, 0.2))), Body("q", Box((0.2, 0.2, 0.2)), position=(away, 0.0, 0.0)))
    ball = Body("ball", Sphere(0.1), 1.0, (5.0, 0.0, 0.0))
    world = begin(Scene((*posts, ball), (Gravity(), Rotation(), Restitution(0.5), Resting(), Friction(0.4))))
    advance(world, 1.0)
    assert world.audit.events == 0
    assert world.state().x[2, 2] == pytest.approx(-0.5 * G, rel=1e-15)
    assert (world.state().x[:2] == [p.position for p in posts]).all()


@pytest.mark.parametrize("e", [1e-300, 1e-12, 1e-6, 0.9999])
def test_the_last_bounce_of_a_ball_that_hardly_bounces_or_hardly_loses(e):
    """t∞ = √(2h/g) (1 + e) / (1 - e); from a height of 1e-4 m even with e = 0.9999 it takes 90 s and 1e5 bounces."""
    height = 1e-4
    world = begin(Scene((FLOOR, Body("ball", Sphere(0.1), 1.0, (0.0, 0.0, 0.1 + height))),
                        (Gravity(), Restitution(e), Resting())))  # fmt: skip
    end = math.sqrt(2.0 * height / G) * (1.0 + e) / (1.0 - e)
    advance(world, 1.001 * end)
    assert world.mode[1] == STILL
    assert world.state().x[1, 2] == pytest.approx(0.1, abs=1e-16)
    # the height is known to half a place of 0.1 m, and so is its root, which the time is in proportion to
    if e > 1e-6:
        assert world.audit.last_bounce == pytest.approx(end, rel=np.spacing(0.1) / height)
