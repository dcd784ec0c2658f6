"""Bounces in the compiled loop: as the general algorithm has them, conserved quantities, reversal, degenerate cases."""

import math

import numpy as np
import pytest

from mechanics.effects import Force, Friction, Gravity, Resting, Restitution, Rotation
from mechanics.rotation import normalised
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Sphere
from reference_impl.bounces import queue
from reference_impl.errors import MissingEffect, Stalled
from reference_impl.settings import Settings
from reference_impl.simulate import advance, begin, simulate


def room(side):
    """Six walls around the cube from 0 to `side`."""
    walls = []
    for axis in range(3):
        for sign in (1.0, -1.0):
            normal, place = np.zeros(3), np.zeros(3)
            normal[axis], place[axis] = sign, 0.0 if sign > 0.0 else side
            walls.append(Body(f"wall {axis} {sign}", HalfSpace(tuple(normal)), position=tuple(place)))
    return tuple(walls)


def balls(n, seed, side, radii=(0.04, 0.08), speed=1.0, spin=0.0, masses=(1.0, 1.0)):
    """n spheres on the sites of a grid, with random velocities."""
    rng, count = np.random.default_rng(seed), math.ceil(n ** (1 / 3))
    sites = np.array([(i, j, k) for i in range(count) for j in range(count) for k in range(count)])
    pitch, out = side / count, []
    for number, site in enumerate(rng.permutation(sites)[:n]):
        radius = rng.uniform(*radii)
        place = (site + 0.5) * pitch + (0.49 * pitch - radius) * rng.uniform(-1.0, 1.0, 3)
        out.append(
            Body(f"ball {number}", Sphere(radius), rng.uniform(*masses), tuple(place),
                 velocity=tuple(speed * rng.normal(size=3)), angular_velocity=tuple(spin * rng.normal(size=3)),
                 orientation=tuple(normalised(rng.normal(size=4))))
        )  # fmt: skip
    return tuple(out)


def both(scene, duration, **settings):
    """Worlds after `duration`, with the loop and without."""
    with_loop, without = begin(scene, Settings(**settings)), begin(scene, Settings(**settings))
    assert with_loop.flock is not None
    without.flock = None
    for world in (with_loop, without):
        advance(world, duration)
    return with_loop, without


def assert_same(with_loop, without, tolerance):
    assert [(e.a, e.b) for e in with_loop.events] == [(e.a, e.b) for e in without.events]
    for one, other in zip(with_loop.events, without.events, strict=True):
        assert one.time == pytest.approx(other.time, abs=tolerance)
        assert one.impulse == pytest.approx(other.impulse, abs=tolerance)
        assert one.point == pytest.approx(other.point, abs=tolerance)
        assert one.normal == pytest.approx(other.normal, abs=tolerance)
    one, other = with_loop.state(), without.state()
    for name in ("x", "q", "v", "w"):
        assert getattr(one, name) == pytest.approx(getattr(other, name), abs=tolerance), name
    assert with_loop.audit.events == without.audit.events
    assert with_loop.audit.impacts == without.audit.impacts


@pytest.mark.parametrize("seed", range(8))
def test_the_loop_gives_the_events_of_the_general_algorithm(seed):
    """Smooth and rough spheres of different mass and size, turning or not, with and without gravity, all e."""
    rng = np.random.default_rng(seed)
    effects = [Restitution(float(rng.uniform(0.5, 1.0)), {("ball 0", "ball 1"): 0.2, ("ball 2", "wall 0 1.0"): 0.6})]
    if seed % 2:
        effects.append(Gravity())
    if seed % 4 > 1:
        effects.append(Rotation())
    if seed > 3:
        effects.append(Friction(0.3, {("ball 3", "ball 4"): 0.0}))
    n = 6 if seed % 3 else 30  # without and with cells
    side = 1.0 if n == 6 else 1.4
    spin = 5.0 if Rotation() in effects else 0.0
    scene = Scene((*room(side), *balls(n, seed, side, spin=spin, masses=(0.5, 5.0))), tuple(effects))
    with_loop, without = both(scene, 0.8 if n == 6 else 0.25)
    assert len(with_loop.events) > 8
    # what differs in the last digit grows by v/r times the free path at each collision; few have happened
    assert_same(with_loop, without, 1e-10)


def test_looking_more_often_changes_no_bit():
    scene = Scene((*room(1.4), *balls(30, 3, 1.4, spin=3.0)), (Restitution(0.95), Gravity(), Rotation(), Friction(0.2)))
    once, often = begin(scene), begin(scene)
    advance(once, 0.5)
    for _ in range(50):
        advance(often, 0.01)
    assert [e[:3] for e in once.events] == [e[:3] for e in often.events if e.time < once.t]
    fine = simulate(scene, [0.1, 0.25, 0.5])
    assert np.array_equal(fine.x[-1], once.state().x)
    assert np.array_equal(fine.w[-1], once.state().w)


def energy(world):
    b, state = world.bodies, world.state()
    free = b.inverse_mass > 0.0
    inertia = world.bodies.inertia[free, 0, 0]
    kinetic = 0.5 * (state.v[free] ** 2).sum(axis=1) / b.inverse_mass[free] + 0.5 * inertia * (state.w[free] ** 2).sum(
        axis=1
    )
    return float((kinetic - (world.bodies.acceleration[free] * state.x[free]).sum(axis=1) / b.inverse_mass[free]).sum())


def test_a_gas_keeps_its_energy():
    """100 spheres that fill a tenth of their room, e = 1: 10 s and some ten thousand bounces."""
    side = (100 * 4.0 / 3.0 * math.pi * 0.05**3 / 0.1) ** (1.0 / 3.0)
    scene = Scene((*room(side), *balls(100, 5, side, (0.05, 0.05))), (Restitution(1.0), Gravity()))
    world = begin(scene)
    before = energy(world)
    advance(world, 10.0)
    assert len(world.events) > 10_000
    assert energy(world) == pytest.approx(before, rel=1e-13)
    assert world.audit.gap > -1e-14
    assert world.audit.step_rise < 1e-12 * before


def test_a_gas_runs_back_to_where_it_came_from():
    """Ten spheres for 1 s, and back with all velocities reversed."""
    start = Scene((*room(1.0), *balls(10, 7, 1.0, (0.08, 0.1), spin=4.0)), (Restitution(1.0), Rotation(), Gravity()))
    there = begin(start)
    advance(there, 1.0)
    assert len(there.events) > 20
    state = there.state()
    bodies = tuple(
        body if body.fixed else
        Body(body.name, body.shape, body.mass, *(tuple(part[i]) for part in (state.x, state.q, -state.v, -state.w)))
        for i, body in enumerate(start.bodies)
    )  # fmt: skip
    back = begin(Scene(bodies, start.effects))
    advance(back, 1.0)
    assert len(back.events) == len(there.events)
    assert back.state().x == pytest.approx(
        start.start().x, abs=3e-12
    )  # twenty bounces multiply rounding by some 10,000
    assert -back.state().v == pytest.approx(start.start().v, abs=3e-11)


@pytest.mark.parametrize("corner", [(1, 0, 0), (1, 1, 0), (1, 1, 1)])
def test_a_ball_meets_several_walls_at_once(corner):
    """It is thrown exactly into the edge or corner: every wall turns its own component of the velocity."""
    direction = -np.array(corner, dtype=float)
    ball = Body("ball", Sphere(0.125), 1.0, (0.5, 0.5, 0.5), velocity=tuple(2.0 * direction))
    world = begin(Scene((*room(1.0), ball), (Restitution(0.5),)))
    advance(world, 0.25)
    assert len(world.events) == sum(corner)
    assert world.state().v[-1] == pytest.approx(-direction, abs=1e-15)


def test_the_symmetric_break_stays_symmetric():
    """A ball comes between two that touch: both are struck at one instant, which is not for the loop to decide."""
    s = math.sqrt(0.75)
    cue = Body("cue", Sphere(0.5), 1.0, (-2.0, 0.0, 0.0), velocity=(1.0, 0.0, 0.0))
    pair = tuple(Body(name, Sphere(0.5), 1.0, (0.0, y, 0.0)) for name, y in (("one", 0.5), ("other", -0.5)))
    world = begin(Scene((cue, *pair), (Restitution(1.0),)))
    advance(world, 3.0)
    assert world.state().v == pytest.approx(
        np.array([[-0.2, 0.0, 0.0], [0.6, 0.4 * s, 0.0], [0.6, -0.4 * s, 0.0]]), abs=1e-14
    )


def test_balls_fall_on_a_peg_and_on_a_moving_one():
    """Between a ball that falls and one that does not, the gap is of fourth order in time."""
    peg = Body("peg", Sphere(0.2), None, (0.02, 0.01, 0.0))
    paddle = Body("paddle", Sphere(0.3), None, (0.5, 0.0, -1.0), velocity=(0.0, 0.0, 0.7))
    falling = tuple(
        Body(f"ball {k}", Sphere(0.1), 1.0 + k, (0.45 * k, 0.0, 0.6 + 0.3 * k), velocity=(0.1, 0.0, 0.0))
        for k in range(3)
    )
    scene = Scene((peg, paddle, *falling), (Gravity(), Restitution(0.9)))
    with_loop, without = both(scene, 1.2)
    assert len(with_loop.events) >= 3
    # times of contact are iterated there and here, to 1e-12 of the size
    assert_same(with_loop, without, 1e-9)


def test_a_great_sphere_among_small_ones_is_in_no_cell():
    small = balls(40, 11, 2.0, (0.03, 0.04))
    great = Body("great", Sphere(0.5), 50.0, (1.0, 1.0, 3.0), velocity=(0.0, 0.0, -3.0))
    lid = tuple(Body(w.name, w.shape, None, w.position) for w in room(2.0) if w.name != "wall 2 -1.0")
    with_loop, without = both(Scene((*lid, *small, great), (Restitution(0.9), Gravity())), 0.5)
    assert any(len(with_loop.scene.bodies) - 1 in (e.a, e.b) for e in with_loop.events)
    assert_same(with_loop, without, 1e-10)


def test_bodies_a_whole_grid_apart_share_a_list():
    """A ball comes from far outside the grid, through cells whose lists hold bodies that are nowhere near."""
    cloud = balls(30, 17, 1.4, speed=0.2)
    place = np.array(cloud[0].position) + 0.75 * np.array(cloud[0].velocity) - (15.0, 0.02, 0.01)
    shot = Body("shot", Sphere(0.06), 1.0, tuple(place), velocity=(20.0, 0.0, 0.0))
    with_loop, without = both(Scene((*cloud, shot), (Restitution(1.0),)), 1.0)
    assert with_loop.flock.head.shape[0] * with_loop.flock.cell < 10.0
    assert any(30 in (e.a, e.b) for e in with_loop.events)
    assert_same(with_loop, without, 1e-9)


def test_the_cells_list_everybody_near_and_nobody_twice():
    world = begin(Scene((*room(1.4), *balls(60, 19, 1.4, (0.02, 0.04))), (Restitution(1.0),)))
    advance(world, 0.5)
    flock, near = world.flock, np.empty(66, dtype=np.int64)
    cells = flock.whole[:, queue.CELL : queue.CELL + 3]
    for i in range(6, 66):
        count = queue.around(flock.whole, flock.head, flock.everywhere, flock.walls, i, False, near)
        listed = near[:count].tolist()
        close = [k for k in range(6, 66) if k != i and abs(cells[k] - cells[i]).max() <= 1]
        low, radius = flock.cell * cells[i], flock.real[i, queue.RADIUS]
        nearest = np.concatenate([low, 1.4 - low - flock.cell])  # a corner of the cell, from the walls
        walls = [2 * c + side for side in (0, 1) for c in range(3) if nearest[3 * side + c] <= radius]
        assert len(set(listed)) == count
        assert set(listed) >= {*close, *walls}


@pytest.mark.parametrize(("count", "bound"), [(3, 1e-12), (40, 1e-11)])
@pytest.mark.parametrize("motion", [{"velocity": (0.0, 0.0, 0.8)}, {"acceleration": (0.0, 0.0, 1.5)}])
def test_a_floor_that_rises_is_met_where_it_is(motion, count, bound):
    """Few bodies and many, without cells and with them."""
    walls = room(1.4)
    floor = Body("floor", HalfSpace(), position=(0.0, 0.0, -0.2), **motion)
    rest = tuple(w for w in walls if w.name != "wall 2 1.0")
    with_loop, without = both(
        Scene((*rest, floor, *balls(count, 31, 1.4, (0.02, 0.04))), (Restitution(0.9), Gravity())), 0.5
    )
    met = [e for e in with_loop.events if len(rest) in (e.a, e.b)]
    assert met
    assert max(e.point[2] for e in met) > -0.15
    assert_same(with_loop, without, bound)


def test_many_balls_in_one_row_far_apart():
    """The row is much thinner than the room a ball has; each bounces on its own."""
    row = [Body(f"ball {k}", Sphere(0.1), 1.0, (30.0 * k, 0.0, 0.6 + 0.001 * k)) for k in range(30)]
    with_loop, without = both(Scene((Body("floor", HalfSpace()), *row), (Gravity(), Restitution(0.8))), 0.5)
    assert len(with_loop.events) == 30
    assert_same(with_loop, without, 1e-13)


def test_a_state_is_the_same_whenever_it_is_asked_for():
    """Bodies in flight wait until someone looks; looking twice, or not until the end, changes no bit."""
    scene = Scene((*room(1.4), *balls(30, 23, 1.4, spin=3.0)), (Restitution(0.95), Gravity(), Rotation()))
    asked, left = begin(scene), begin(scene)
    for _ in range(20):
        advance(asked, 0.02)
        once, twice = asked.state(), asked.state()
        assert np.array_equal(once.x, twice.x)
        advance(left, 0.02)
    assert left.behind
    assert not asked.behind
    for name in ("x", "q", "v", "w"):
        assert np.array_equal(getattr(asked.state(), name), getattr(left.state(), name)), name


def test_a_force_that_begins_on_the_way():
    bodies = (Body("floor", HalfSpace()), Body("ball", Sphere(0.1), 2.0, (0.0, 0.0, 1.1)))
    scene = Scene(bodies, (Gravity(), Restitution(1.0), Force("ball", (1.0, 0.0, 8.0), start=0.3, end=0.9)))
    with_loop, without = both(scene, 3.0)
    assert len(with_loop.events) >= 3
    assert_same(with_loop, without, 1e-12)


def test_accumulation_is_left_to_the_general_algorithm():
    heap = (*room(1.0), *balls(8, 13, 1.0, (0.08, 0.12)))
    world = begin(Scene(heap, (Gravity(), Restitution(0.3))))
    with pytest.raises(MissingEffect, match="Resting"):
        advance(world, 20.0)


def test_the_budget_of_events_holds():
    scene = Scene((*room(1.0), *balls(10, 1, 1.0)), (Restitution(1.0),))
    world = begin(scene, Settings(events=50))
    with pytest.raises(Stalled, match="more than 50 contacts"):
        advance(world, 1e6)
    assert world.audit.events == 51
    assert len(world.events) == 51


def test_scenes_that_the_loop_does_not_suit():
    floor, ball = Body("floor", HalfSpace()), Body("ball", Sphere(0.1), 1.0, (0.0, 0.0, 1.0))
    box = Body("box", Box((0.1, 0.1, 0.1)), 1.0, (1.0, 0.0, 1.0))
    assert begin(Scene((floor, ball), (Restitution(1.0),))).flock is not None
    assert begin(Scene((floor, ball, box), (Restitution(1.0),))).flock is None
    assert begin(Scene((floor, ball), (Resting(),))).flock is None
    assert begin(Scene((floor, ball), (Restitution(1.0),)), Settings(time_of_contact="bisection")).flock is None
    twist = Force("ball", torque=(1.0, 0.0, 0.0), start=5.0)
    assert begin(Scene((floor, ball), (Restitution(1.0), Rotation(), twist))).flock is None
