"""Islands in lasting contact: each on its own clock, and none the wiser for what the others do."""

import math

import numpy as np
import pytest

from mechanics.effects import Friction, Gravity, Resting, Restitution, Rotation
from mechanics.rotation import about
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Sphere
from reference_impl.simulate import advance, begin
from reference_impl.world import FLYING, HELD, STILL

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


# islands at rest


def stack(masses, floor=FLOOR, high=0.0):
    boxes = tuple(
        Body(f"b{i}", Box((1.0, 1.0, 0.5)), m, (0.0, 0.0, high + 0.25 + 0.5 * i)) for i, m in enumerate(masses)
    )
    return Scene((floor, *boxes), EFFECTS)


def load(world, i):
    """Force through the interface of bodies i and i + 1 [N]."""
    return sum(h.force for h in world.forces if {h.a, h.b} == {i, i + 1})


@pytest.mark.parametrize(("masses", "allowed"), [([1.0] * 20, 1e-13), ([1.0] * 4 + [1e6], 1e-12)])
def test_a_stack_stands_for_a_minute_unmoved_under_exact_loads(masses, allowed):
    world = begin(stack(masses))
    start = world.state()
    advance(world, 60.0)
    end = world.state()
    for name in ("x", "q", "v", "w"):
        assert np.array_equal(getattr(start, name), getattr(end, name))
    for i in range(len(masses)):
        assert load(world, i) == pytest.approx(9.81 * sum(masses[i:]), rel=allowed)
    assert (world.audit.events, world.audit.steps) == (1, 0)  # looked at once, and never stepped


def test_what_rests_costs_nothing_while_others_move():
    """Nine stacks at rest round a ball that bounces for ever: no contact of theirs is looked at again."""
    boxes = [
        Body(f"b{i}-{k}", Box((0.4, 0.4, 0.2)), 1.0, (2.0 * (i % 3), 2.0 * (i // 3), 0.1 + 0.2 * k))
        for i in range(9)
        for k in range(3)
    ]
    ball = Body("ball", Sphere(0.2), 1.0, (1.0, 1.0, 1.0))
    scene = Scene((FLOOR, *boxes, ball), (Gravity(), Rotation(), Resting(), Restitution(1.0)))
    world = begin(scene)
    advance(world, 0.4)
    assert (world.mode[1:-1] == STILL).all()
    evaluations = world.search.evaluations
    advance(world, 4.0)
    bounces = world.audit.events - 9  # each stack once
    assert bounces == 5
    # of the ball: its closed form with the floor once a bounce, and a look at the 27 boxes, all out of its way
    assert world.search.evaluations - evaluations <= 28 * 40 * bounces
    assert world.audit.steps == 0
    few = Scene((FLOOR, ball), (Gravity(), Rotation(), Resting(), Restitution(1.0)))
    alone, bouncing = begin(few), begin(few)
    alone.flock = None  # the loop of bounces, which takes scenes of spheres only, rounds otherwise
    for one in (alone, bouncing):
        advance(one, 4.4)
    assert np.array_equal(alone.state().x[1], world.state().x[-1])
    assert bouncing.state().x[1] == pytest.approx(world.state().x[-1], abs=2e-14)  # both are 2e-15 off the truth


def test_a_stack_on_a_lift_carries_its_weight_and_more():
    lift = Body("floor", Box((4.0, 4.0, 1.0)), position=(0.0, 0.0, -0.5), acceleration=(0.0, 0.0, 0.3))
    world = begin(stack([1.0] * 20, lift))
    advance(world, 1.0)
    assert (world.mode[1:] == HELD).all()
    z = world.state().x[1:, 2]
    assert z == pytest.approx(0.15 + 0.25 + 0.5 * np.arange(20), abs=1e-13)
    for i in range(20):
        assert load(world, i) == pytest.approx((9.81 + 0.3) * (20 - i), rel=1e-12)


ALONG = (0.0, 0.5, 0.0)


def test_a_wall_under_way_is_an_island_of_hundreds_of_contacts():
    bricks = [
        Body(f"b{k}-{i}", Box((0.98, 0.5, 0.5)), 1.0, (i + 0.5 * (k % 2), 0.0, 0.25 + 0.5 * k), velocity=ALONG)
        for k in range(6)
        for i in range(8 - k % 2)
    ]  # fmt: skip
    world = begin(Scene((FLOOR, *bricks), EFFECTS))
    advance(world, 0.2)
    assert len(world.forces) > 200
    total = sum(h.force for h in world.forces if 0 in (h.a, h.b))
    assert total == pytest.approx(9.81 * len(bricks), rel=1e-12)
    state = world.state()
    assert state.x[1:, 1] == pytest.approx(np.full(len(bricks), 0.1), abs=1e-13)
    assert np.abs(state.x[1:, 2] - [b.position[2] for b in bricks]).max() <= 1e-13


# rests that are hardly any


def box_over_edge(offset):
    """A box on a table, its middle `offset` beyond the table's edge."""
    table = Body("table", Box((2.0, 2.0, 1.0)), position=(0.0, 0.0, -0.5))
    return Scene((table, Body("box", Box((1.0, 1.0, 0.5)), 1.0, (1.0 + offset, 0.0, 0.25))), EFFECTS)


@pytest.mark.parametrize("offset", [-1e-12, 0.0])
def test_a_box_balanced_on_an_edge_stays(offset):
    world = begin(box_over_edge(offset))
    start = world.state()
    advance(world, 2.0)
    assert world.mode[1] == STILL
    assert np.array_equal(world.state().x, start.x)
    assert sum(h.force for h in world.forces) == pytest.approx(9.81, rel=1e-13)


def test_a_box_beyond_its_balance_tips():
    world = begin(box_over_edge(1e-3))
    advance(world, 1.5)
    assert world.state().w[1, 1] > 1e-2
    # a picometre beyond is within the rounding of a torque of metres, and either answer is right: it only must end
    world = begin(box_over_edge(1e-12))
    advance(world, 1.0)
    assert abs(world.state().x[1, 2] - 0.25) <= 1e-6


@pytest.mark.parametrize("legs", [3, 4, 100])
def test_a_plate_on_many_legs_weighs_what_it_weighs(legs):
    """The split among more than three legs is not unique; here it is the smallest, and even by symmetry."""
    plate = Body("plate", Box((4.0, 4.0, 0.2)), 50.0, (0.0, 0.0, 1.1))
    angles = 2.0 * math.pi * np.arange(legs) / legs
    feet = [
        Body(f"leg{k}", Sphere(0.1), None, (1.5 * math.cos(a), 1.5 * math.sin(a), 0.9)) for k, a in enumerate(angles)
    ]
    world = begin(Scene((*feet, plate), EFFECTS))
    advance(world, 1.0)
    forces = [h.force for h in world.forces]
    assert sum(forces) == pytest.approx(50.0 * 9.81, rel=1e-13)
    assert forces == [pytest.approx(50.0 * 9.81 / legs, rel=1e-11)] * legs
    assert world.mode[-1] == STILL


def test_a_body_between_two_fixed_walls_is_not_squeezed():
    walls = [Body(f"wall{k}", Box((1.0, 4.0, 4.0)), None, (s, 0.0, 0.0)) for k, s in enumerate((-1.0, 1.0))]
    world = begin(Scene((*walls, Body("box", Box((1.0, 1.0, 1.0)), 2.0)), EFFECTS))
    advance(world, 0.5)  # smooth walls: it falls between them, touching both
    assert world.state().x[2] == pytest.approx((0.0, 0.0, -0.5 * 9.81 * 0.25), abs=1e-13)
    assert not world.forces


def test_a_stack_without_weight_needs_no_force():
    world = begin(Scene(stack([1.0] * 5).bodies, (Rotation(), Resting(), Restitution(0.5))))
    start = world.state()
    advance(world, 10.0)
    assert np.array_equal(world.state().x, start.x)
    assert not world.forces


def test_a_stack_in_free_fall_keeps_together_without_force():
    world = begin(Scene(stack([1.0] * 5, high=20.0).bodies[1:], EFFECTS))
    advance(world, 1.0)
    assert not world.forces
    assert not world.events
    assert np.diff(world.state().x[:, 2]) == pytest.approx([0.5] * 4, abs=1e-14)


def test_a_ladder_on_a_smooth_wall_slides():
    """Nothing holds its foot: θ'' = 3 g sin θ / (2 L) for a thin rod at θ from the wall, both ends in contact."""
    angle, thin = 0.3, 1e-3
    wall = Body("wall", HalfSpace((1.0, 0.0, 0.0)))
    c, s = math.cos(angle), math.sin(angle)
    rod = Body("rod", Box((thin, 0.5, 2.0)), 1.0, (s + 0.5 * thin * c, 0.0, c + 0.5 * thin * s),
               tuple(about((0.0, 1.0, 0.0), -angle).tolist()))  # fmt: skip
    world = begin(Scene((FLOOR, wall, rod), EFFECTS))
    energy = 9.81 * rod.position[2]
    advance(world, 0.4)
    state = world.state()
    assert (world.mode[2], state.w[2, 1] < -0.3) == (HELD, True)
    now = 0.5 * state.v[2] @ state.v[2] + 0.5 * state.w[2] @ world.motion.L[2] + 9.81 * state.x[2, 2]
    assert now == pytest.approx(energy, rel=1e-11)


def test_a_lintel_on_two_pillars_loads_each_with_half():
    pillars = [Body(f"pillar{k}", Box((0.5, 0.5, 2.0)), 3.0, (x, 0.0, 1.0)) for k, x in enumerate((-1.0, 1.0))]
    lintel = Body("lintel", Box((3.0, 0.5, 0.5)), 5.0, (0.0, 0.0, 2.25))
    world = begin(Scene((FLOOR, *pillars, lintel), EFFECTS))
    start = world.state()
    advance(world, 10.0)
    assert np.array_equal(world.state().x, start.x)
    for k in (1, 2):
        on, under = ([h.force for h in world.forces if {h.a, h.b} == {k, other}] for other in (3, 0))
        assert sum(on) == pytest.approx(2.5 * 9.81, rel=1e-13)
        assert sum(under) == pytest.approx(5.5 * 9.81, rel=1e-13)


def test_a_needle_stands_on_its_end():
    needle = Body("needle", Box((1e-3, 1e-3, 1.0)), 1.0, (0.0, 0.0, 0.5))
    world = begin(Scene((FLOOR, needle), EFFECTS))
    advance(world, 60.0)
    assert world.mode[1] == STILL
    assert world.state().x[1, 2] == 0.5


def test_floors_one_on_the_other_share_the_load():
    """The same contact a hundred times over: fixed slabs in one place; the load is theirs together."""
    slabs = [Body(f"slab{k}", Box((4.0, 4.0, 1.0)), None, (0.0, 0.0, -0.5)) for k in range(25)]
    world = begin(Scene((*slabs, Body("box", Box((1.0, 1.0, 1.0)), 3.0, (0.0, 0.0, 0.5))), EFFECTS))
    advance(world, 1.0)
    assert world.mode[-1] == STILL
    assert len(world.forces) == 100
    assert sum(h.force for h in world.forces) == pytest.approx(3.0 * 9.81, rel=1e-13)
    assert max(h.force for h in world.forces) == pytest.approx(0.03 * 9.81, rel=1e-10)


def test_a_ball_that_arrives_wakes_only_what_it_meets():
    far = Body("far", Box((1.0, 1.0, 0.5)), 1.0, (9.0, 0.0, 0.25))
    ball = Body("ball", Sphere(0.3), 1.0, (0.0, 0.0, 2.0))
    world = begin(Scene((*stack([1.0] * 2).bodies, far, ball), (*EFFECTS[:3], Restitution(0.0))))
    advance(world, 0.1)
    assert world.mode.tolist() == [FLYING, STILL, STILL, STILL, FLYING]
    looked = world.audit.events
    advance(world, 1.0)
    assert world.audit.events == looked + 1
    assert (world.mode[1:] == STILL).all()
    assert load(world, 0) == pytest.approx(3.0 * 9.81, rel=1e-13)
