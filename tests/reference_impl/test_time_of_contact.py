"""The time of contact: exact where there is a closed form, and no first contact is ever passed."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mechanics.effects import Drag, Gravity, Resting, Restitution, Rotation
from mechanics.rotation import matrix, normalised
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Sphere
from reference_impl.advancement import gap_plane
from reference_impl.settings import Settings
from reference_impl.simulate import advance, begin, simulate
from reference_impl.time_of_contact import BRACKETED, METHODS, Bracket, bisection, parabola, spheres_meet

FLOOR = Body("floor", HalfSpace())


# rates and accelerations whose squares do not underflow
numbers = st.one_of(st.just(0.0), st.floats(1e-9, 50.0), st.floats(-50.0, -1e-9))


@given(st.floats(0.0, 100.0), numbers, numbers)
def test_the_parabola_is_zero_at_its_root_and_positive_before(gap, rate, acceleration):
    t = parabola(gap, rate, acceleration)
    if math.isinf(t):
        assert rate * rate - 2.0 * acceleration * gap < 0.0 or (rate >= 0.0 and acceleration >= 0.0)
        return
    terms = gap + abs(rate) * t + 0.5 * abs(acceleration) * t * t
    assert abs(gap + rate * t + 0.5 * acceleration * t * t) <= 4e-15 * terms
    for part in (0.25, 0.5, 0.75):
        s = part * t
        assert gap + rate * s + 0.5 * acceleration * s * s >= -4e-15 * terms


@given(st.lists(st.floats(-5.0, 5.0), min_size=6, max_size=6), st.floats(0.01, 0.5))
def test_spheres_meet_where_their_distance_is_the_sum_of_the_radii(numbers, radii):
    r, v = np.array(numbers[:3]), np.array(numbers[3:])
    if np.linalg.norm(r) < radii or np.linalg.norm(v) < 1e-3:
        return
    t = spheres_meet(r, v, radii)
    closest = np.linalg.norm(np.cross(r, v)) / np.linalg.norm(v)
    if math.isinf(t):
        assert r @ v >= 0.0 or closest > radii * (1.0 - 1e-12)
    else:
        # at a graze the root is as ill-conditioned as a double root
        steep = abs((r + v * t) @ v) / radii
        assert abs(np.linalg.norm(r + v * t) - radii) <= 1e-14 * (1.0 + np.linalg.norm(r)) * (
            1.0 + 1.0 / (steep + 1e-8)
        )


@pytest.mark.parametrize("name", BRACKETED)
def test_a_root_in_a_bracket(name):
    """Of 1 - t², and of a function so flat at its root that Newton and false position have to be safeguarded."""
    for gap in (lambda t: (1.0 - t * t, -2.0 * t), lambda t: ((1.0 - t) ** 9, -9.0 * (1.0 - t) ** 8)):
        bracket = Bracket(0.0, 3.0, *gap(0.0), gap(3.0)[0])
        time, count = BRACKETED[name](gap, bracket, 1e-12)
        assert abs(gap(time)[0]) <= 1e-12
        assert 0 < count < 60


def test_bisection_halves_to_the_tolerance():
    time, count = bisection(lambda t: (1.0 - t * t, -2.0 * t), Bracket(0.0, 3.0, 1.0, 0.0, -8.0), 1e-12)
    assert time == pytest.approx(1.0, abs=1e-12)
    assert 35 < count < 50


def boxes(seed, spin):
    rng = np.random.default_rng(seed)
    q = tuple(normalised(rng.normal(size=4)).tolist())
    size = tuple(rng.uniform(0.2, 1.0, 3).tolist())
    return Body("box", Box(size), 1.0, (0.0, 0.0, float(rng.uniform(1.0, 3.0))), q,
                angular_velocity=tuple((spin * rng.normal(size=3)).tolist()))  # fmt: skip


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 100_000), st.sampled_from([0.0, 4.0, 20.0, 60.0]))
def test_no_first_contact_is_passed(seed, spin):
    """Up to the first impact no corner is ever below the floor, and at the impact one is on it."""
    box = boxes(seed, spin)
    world = begin(Scene((FLOOR, box), (Gravity(), Rotation(), Restitution(1.0))))
    while not world.events:
        advance(world, 0.2)
    hit = world.events[0].time
    free = simulate(Scene((box,), (Gravity(), Rotation())), np.linspace(0.0, hit, 500))
    low = [x[2] - np.abs(matrix(q)[2]) @ (0.5 * np.array(box.shape.size)) for x, q in zip(free.x[:, 0], free.q[:, 0],
                                                                                         strict=True)]  # fmt: skip
    assert min(low[:-1]) > -1e-12
    assert abs(low[-1]) < 1e-12


@pytest.mark.parametrize("other", [Box((0.5, 0.7, 0.9)), Sphere(0.3)])
@pytest.mark.parametrize("seed", range(6))
def test_all_methods_agree(seed, other):
    """Two turning bodies that meet in the air: the same time, at the cost that each method is known for."""
    rng = np.random.default_rng(seed)
    q = tuple(normalised(rng.normal(size=4)).tolist())
    a = Body("a", Box((0.6, 0.4, 0.3)), 1.0, (-1.5, 0.0, 0.0), q, (2.0, 0.0, 0.0), tuple(rng.normal(size=3) * 5.0))
    b = Body("b", other, 2.0, (1.5, 0.05, -0.05), velocity=(-2.0, 0.1, 0.0), angular_velocity=(3.0, -1.0, 2.0))
    times, cost = {}, {}
    for method in METHODS:
        world = begin(Scene((a, b), (Rotation(), Restitution(1.0))), Settings(time_of_contact=method))
        while not world.events:
            advance(world, 0.1)
        times[method] = world.events[0].time
        cost[method] = world.search.refinements / max(world.search.brackets, 1)
        assert (world.search.brackets > 0) == (method != "advancement")
    # the gap is within 1e-12 body sizes at an approach of some 4 m/s
    assert list(times.values()) == pytest.approx([times["advancement"]] * 4, abs=1e-12)
    # the bracket is as wide as a hundredth of a body: 2^33 tolerances
    assert 28 <= cost["bisection"] <= 36
    assert cost["illinois"] <= 8
    assert cost["newton"] <= 4


def test_a_ball_in_the_air_meets_the_floor_under_drag():
    """With drag there is no closed form in t: the time from x(t) = g/k² (1 - kt - e^-kt), solved to the end."""
    ball = Body("ball", Sphere(0.1), 1.0, (0.0, 0.0, 1.1))
    world = begin(Scene((FLOOR, ball), (Gravity(), Drag(0.5), Restitution(1.0))))
    advance(world, 1.0)
    t = world.events[0].time
    assert 1.0 + 9.81 / 0.25 * (1.0 - 0.5 * t - math.exp(-0.5 * t)) == pytest.approx(0.0, abs=1e-13)


def test_a_graze_is_no_collision():
    a = Body("a", Sphere(0.1), 1.0, (-1.0, 0.2 + 1e-9, 0.0), velocity=(1.0, 0.0, 0.0))
    world = begin(Scene((a, Body("b", Sphere(0.1), 1.0)), (Restitution(1.0),)))
    advance(world, 2.0)
    assert not world.events


def test_a_thin_plate_at_a_kilometre_per_second_is_not_tunnelled():
    bullet = Body("bullet", Sphere(0.005), 0.01, (-1.0, 0.0, 0.0), velocity=(1000.0, 0.0, 0.0))
    plate = Body("plate", Box((1e-3, 1.0, 1.0)), 1.0)
    world = begin(Scene((bullet, plate), (Rotation(), Restitution(1.0))))
    advance(world, 0.01)
    assert len(world.events) == 1
    assert world.events[0].time == pytest.approx((1.0 - 0.0055) / 1000.0, rel=1e-12)


def test_a_contact_in_a_million_seconds_is_found():
    slow = Body("slow", Box((0.2, 0.2, 0.2)), 1.0, (-1.0, 0.0, 0.0), velocity=(1e-6, 0.0, 0.0))
    wall = Body("wall", Box((0.2, 1.0, 1.0)), None, (1.0, 0.0, 0.0))
    world = begin(Scene((slow, wall), (Restitution(1.0),)))
    advance(world, 2e6)
    assert [e.time for e in world.events[:1]] == [pytest.approx(1.8e6, rel=1e-12)]


def test_bodies_that_never_meet_cost_next_to_nothing():
    a = Body("a", Box((0.2, 0.3, 0.4)), 1.0, velocity=(-1.0, 0.0, 0.0))
    b = Body("b", Box((0.2, 0.3, 0.4)), 1.0, (1.0, 0.0, 0.0), velocity=(1.0, 0.0, 0.0))
    world = begin(Scene((a, b), (Restitution(1.0), Resting())))
    advance(world, 1000.0)
    assert world.search.evaluations < 10


@pytest.mark.parametrize("seed", range(5))
def test_the_gap_over_a_plane_is_that_of_the_lowest_corner(seed):
    """Height and rate from the polynomials alone, against the attitude as a matrix and ω × r."""
    rng = np.random.default_rng(seed)
    up = rng.normal(size=3)
    up /= np.linalg.norm(up)
    floor = Body("floor", HalfSpace(tuple(up)), velocity=tuple(rng.normal(size=3)))
    box = Body("box", Box((0.4, 0.6, 1.0)), 1.0, tuple(5.0 * up), tuple(normalised(rng.normal(size=4))),
               velocity=tuple(rng.normal(size=3)), angular_velocity=tuple(3.0 * rng.normal(size=3)))  # fmt: skip
    world = begin(Scene((floor, box), (Gravity(), Rotation(), Restitution(0.0), Resting())))
    corners = np.array([(x, y, z) for x in (-0.2, 0.2) for y in (-0.3, 0.3) for z in (-0.5, 0.5)])
    m, t = world.motion, 0.7 * float(world.motion.end[1])
    gap, rate = gap_plane(t, m.begin[1], m.x_series[1], m.q_series[1], corners, 0.0, m.begin[0], m.x_series[0], up)
    world.carry(t)
    state = world.state()
    arms = corners @ matrix(state.q[1]).T
    low = int(np.argmin(arms @ up))
    assert gap == pytest.approx(up @ (state.x[1] + arms[low] - state.x[0]), abs=1e-14)
    assert rate == pytest.approx(up @ (state.v[1] + np.cross(state.w[1], arms[low]) - state.v[0]), abs=1e-13)
