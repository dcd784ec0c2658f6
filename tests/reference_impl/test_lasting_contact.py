"""Lasting contact: loads, rest, sliding, rocking, and what happens where it begins and ends."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mechanics.effects import Force, Friction, Gravity, Resting, Restitution, Rotation
from mechanics.rotation import about, matrix, normalised
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, Cylinder, HalfSpace, Sphere
from reference_impl.errors import MissingEffect, Unsupported
from reference_impl.settings import Settings
from reference_impl.simulate import advance, begin, simulate
from reference_impl.world import FLYING, STILL

FLOOR = Body("floor", HalfSpace())
SLAB = Body("floor", Box((8.0, 8.0, 1.0)), position=(0.0, 0.0, -0.5))
EFFECTS = (Gravity(), Rotation(), Resting())


def stack(masses, floor=FLOOR):
    boxes = tuple(Body(f"b{i}", Box((1.0, 1.0, 0.5)), m, (0.0, 0.0, 0.25 + 0.5 * i)) for i, m in enumerate(masses))
    return Scene((floor, *boxes), EFFECTS)


def load(world, i):
    """Force through the interface of bodies i and i + 1 [N]."""
    return sum(h.force for h in world.forces if {h.a, h.b} == {i, i + 1})


@pytest.mark.parametrize("solver", ["nnls", "osqp", "dantzig"])
@pytest.mark.parametrize("floor", [FLOOR, SLAB])
@pytest.mark.parametrize("count", [1, 2, 5, 10])
def test_a_stack_carries_what_lies_on_it(count, floor, solver):
    masses = [float(count - i) for i in range(count)]
    world = begin(stack(masses, floor), Settings(solver=solver))
    start = world.state()
    advance(world, 10.0)
    # OSQP's active set is exact after polishing, and its forces are then computed from it
    for i in range(count):
        assert load(world, i) == pytest.approx(9.81 * sum(masses[i:]), rel=1e-12)
    end = world.state()
    assert np.abs(end.x - start.x).max() <= 1e-15
    assert (world.mode[1:] == STILL).all()


@pytest.mark.parametrize("count", [2, 5, 10])
def test_a_stack_under_a_lid_a_million_times_heavier(count):
    masses = [1.0] * (count - 1) + [1e6]
    world = begin(stack(masses))
    advance(world, 10.0)
    # the floor of double precision is eps times the mass ratio, 2e-10; the loads are far better
    for i in range(count):
        assert load(world, i) == pytest.approx(9.81 * sum(masses[i:]), rel=1e-9)
    assert np.abs(world.state().x[:, 2] - [0.0, *(0.25 + 0.5 * i for i in range(count))]).max() < 1e-12


def test_a_force_moves_the_centre_of_pressure():
    """A 2 m x 1 m x 0.5 m box of 7 kg with 20 N down at 0.6 m from its middle: F01 of any book of statics."""
    box = Body("box", Box((2.0, 1.0, 0.5)), 7.0, (0.0, 0.0, 0.25))
    push = Force("box", (0.0, 0.0, -20.0), point=(0.6, 0.0, 0.25))
    world = begin(Scene((FLOOR, box), (*EFFECTS, push)))
    advance(world, 10.0)
    total = sum(h.force for h in world.forces)
    assert total == pytest.approx(88.67, rel=1e-14)
    assert sum(h.force * h.point[0] for h in world.forces) / total == pytest.approx(0.13533325814818992, rel=1e-13)


def test_a_resting_ball_weighs_what_it_weighs():
    world = begin(Scene((FLOOR, Body("ball", Sphere(0.3), 2.0, (0.0, 0.0, 0.3))), (Gravity(), Resting())))
    advance(world, 1.0)
    assert [h.force for h in world.forces] == [pytest.approx(2.0 * 9.81, rel=1e-15)]


def test_a_smooth_slope_accelerates_by_its_sine():
    angle = math.radians(30.0)
    slope = Body("slope", HalfSpace(), orientation=tuple(about((0.0, 1.0, 0.0), angle)))
    up = np.array((math.sin(angle), 0.0, math.cos(angle)))
    down = np.array((math.cos(angle), 0.0, -math.sin(angle)))
    box = Body("box", Box((0.4, 0.4, 0.2)), 1.0, tuple(0.1 * up), tuple(about((0.0, 1.0, 0.0), angle)))
    motion = simulate(Scene((slope, box), (*EFFECTS, Friction(0.0))), (0.0, 1.0, 2.0))
    for k, t in ((1, 1.0), (2, 2.0)):
        assert motion.x[k, 1] == pytest.approx(0.1 * up + 0.5 * 9.81 * 0.5 * t * t * down, abs=1e-11)
        assert np.abs(motion.w[k, 1]).max() < 1e-12


def test_a_rod_falls_from_twenty_degrees_on_a_smooth_floor():
    """Its end slides and its centre falls straight: θ'² = 12 g (cos θ0 - cos θ) / (L (1 + 3 sin² θ))."""
    thin = 1e-4
    lean = about((0.0, 1.0, 0.0), math.radians(20.0))
    height = 0.5 * math.cos(math.radians(20.0)) + 0.5 * thin * math.sin(math.radians(20.0))
    rod = Body("rod", Box((thin, 1.0, 1.0)), 1.0, (0.0, 0.0, height), tuple(lean))
    i = (1.0 + thin**2) / 12.0
    motion = simulate(Scene((FLOOR, rod), EFFECTS), (0.0, 0.1, 0.2, 0.3, 0.4))
    for k in range(1, 5):
        axis = matrix(motion.q[k, 1])[:, 2]
        w = motion.w[k, 1, 1]
        v = motion.v[k, 1]
        energy = 0.5 * v @ v + 0.5 * i * w * w + 9.81 * motion.x[k, 1, 2]
        assert energy == pytest.approx(9.81 * height, rel=1e-12)
        assert abs(motion.x[k, 1, 0]) < 1e-12
        assert motion.x[k, 1, 2] == pytest.approx(0.5 * axis[2] + 0.5 * thin * math.sqrt(1.0 - axis[2] ** 2), abs=1e-12)


@pytest.mark.parametrize("floor", [FLOOR, SLAB])
def test_a_box_dropped_flat_stays_flat(floor):
    box = Body("box", Box((1.0, 0.7, 0.5)), 2.0, (0.0, 0.0, 1.25))
    world = begin(Scene((floor, box), (*EFFECTS, Restitution(0.5))))
    advance(world, 4.0)
    state = world.state()
    assert world.mode[1] == STILL
    assert state.x[1] == pytest.approx((0.0, 0.0, 0.25), abs=1e-14)
    assert state.q[1] == pytest.approx((1.0, 0.0, 0.0, 0.0), abs=1e-16)
    first = world.events[:4]
    assert [e.time for e in first] == pytest.approx([math.sqrt(2.0 / 9.81)] * 4, rel=1e-12)
    # the split among the corners is not unique; the most even one is taken
    assert [e.impulse for e in first] == pytest.approx([1.5 * 2.0 * math.sqrt(2.0 * 9.81) / 4.0] * 4, rel=1e-12)


@settings(max_examples=12, deadline=None)
@given(st.integers(0, 10_000), st.sampled_from([0.0, 0.3, 0.5, 0.7]), st.booleans())
def test_a_thrown_box_comes_to_proven_rest(seed, e, plane):
    rng = np.random.default_rng(seed)
    size = tuple(rng.uniform(0.2, 1.0, 3).tolist())
    q = tuple(normalised(rng.normal(size=4)).tolist())
    box = Body("box", Box(size), 2.0, (0.0, 0.0, 1.3), q, angular_velocity=tuple((3.0 * rng.normal(size=3)).tolist()))
    world = begin(Scene((FLOOR if plane else SLAB, box), (*EFFECTS, Restitution(e))))
    energy = math.inf
    while world.mode[1] != STILL and world.t < 12.0:
        state = world.state()
        now = state.v[1] @ state.v[1] + 0.5 * state.w[1] @ world.motion.L[1] + 2.0 * 9.81 * state.x[1, 2]
        assert now <= energy + 1e-9  # of about 30 J
        energy = now
        low = state.x[1, 2] - np.abs(matrix(state.q[1])[2]) @ (0.5 * np.array(size))
        assert low >= -1e-11
        # frictionless: what spins about the vertical, and what drifts, never stops
        upright = np.abs(matrix(state.q[1])[2]).max() > 1.0 - 1e-13
        if upright and low < 1e-9 and np.abs(state.v[1, 2]) + np.abs(state.w[1, :2]).max() < 1e-9:
            break
        advance(world, 0.1)
    state = world.state()
    assert state.x[1, 2] == pytest.approx(0.5 * min(size, key=lambda s: abs(0.5 * s - state.x[1, 2])), abs=1e-9)
    assert world.audit.gap >= -1e-10
    assert world.audit.energy_rise <= 1e-11


def test_a_box_slides_off_a_table_and_tips():
    """Smooth contact over an edge: the box leaves the table with its speed and falls turning, energy unchanged."""
    table = Body("table", Box((1.0, 1.0, 0.2)), position=(0.0, 0.0, -0.1))
    box = Body("box", Box((0.3, 0.2, 0.1)), 1.0, (0.2, 0.0, 0.05), velocity=(1.0, 0.0, 0.0))
    world = begin(Scene((table, box), (*EFFECTS, Restitution(0.3))))
    before = 0.5 + 9.81 * 0.05
    advance(world, 0.25)
    assert world.state().x[1] == pytest.approx((0.45, 0.0, 0.05), abs=1e-12)
    advance(world, 0.35)
    state = world.state()
    after = 0.5 * state.v[1] @ state.v[1] + 0.5 * state.w[1] @ world.motion.L[1] + 9.81 * state.x[1, 2]
    assert state.w[1, 1] > 1.0  # forwards over the edge
    assert state.v[1, 0] > 1.0
    assert after == pytest.approx(before, rel=1e-9)
    assert not world.events


def test_a_ball_struck_from_above_presses_its_support():
    """A ball falls on a box at rest: the box is woken, and rests again."""
    box = Body("box", Box((1.0, 1.0, 0.5)), 2.0, (0.0, 0.0, 0.25))
    ball = Body("ball", Sphere(0.1), 0.5, (0.0, 0.0, 1.0))
    world = begin(Scene((FLOOR, box, ball), (*EFFECTS, Restitution(0.0))))
    advance(world, 1.0)
    assert (world.mode[1:] == STILL).all()
    assert load(world, 0) == pytest.approx(9.81 * 2.5, rel=1e-13)
    assert load(world, 1) == pytest.approx(9.81 * 0.5, rel=1e-13)


def test_a_load_that_begins_wakes_what_rests():
    box = Body("box", Box((1.0, 1.0, 0.5)), 2.0, (0.0, 0.0, 0.25))
    lift = Force("box", (0.0, 0.0, 30.0), start=1.0, end=1.5)
    motion = simulate(Scene((FLOOR, box), (*EFFECTS, lift)), (0.0, 0.999, 1.5))
    assert motion.x[1, 1, 2] == 0.25
    assert motion.x[2, 1, 2] - 0.25 == pytest.approx(0.5 * (15.0 - 9.81) * 0.25, rel=1e-13)


def test_an_accelerated_support_pushes_harder():
    table = Body("table", Box((2.0, 2.0, 0.2)), position=(0.0, 0.0, -0.1), acceleration=(0.0, 0.0, 2.0))
    box = Body("box", Box((0.4, 0.4, 0.4)), 3.0, (0.0, 0.0, 0.2))
    world = begin(Scene((table, box), EFFECTS))
    advance(world, 1.0)
    assert world.state().x[1, 2] == pytest.approx(0.2 + 1.0, abs=1e-11)
    assert load(world, 0) == pytest.approx(3.0 * 11.81, rel=1e-11)


def test_falling_together_needs_no_force():
    """Two boxes in contact in free fall: no force, no Resting, no parting."""
    boxes = [Body(f"b{i}", Box((1.0, 1.0, 0.5)), 1.0, (0.0, 0.0, 10.0 + 0.5 * i)) for i in range(2)]
    world = begin(Scene(tuple(boxes), (Gravity(), Rotation(), Restitution(0.5))))
    advance(world, 1.0)
    assert not world.events
    assert not world.forces
    assert world.state().x[:, 2] == pytest.approx((10.0 - 4.905, 10.5 - 4.905), abs=1e-11)


def test_rest_that_is_not_declared_is_an_error_of_the_scene():
    box = Body("box", Box((1.0, 1.0, 0.5)), 2.0, (0.0, 0.0, 0.25))
    with pytest.raises(MissingEffect, match=r"'box' and 'floor'.*Resting"):
        simulate(Scene((FLOOR, box), (Gravity(), Rotation(), Restitution(0.5))), (0.0, 1.0))


@pytest.mark.parametrize(("effect", "shape", "match"), [
    (Friction(0.3), Cylinder(0.1, 0.2), "'b', a Cylinder"),
    (Friction(0.0), Cylinder(0.1, 0.2), "'b', a Cylinder"),
])  # fmt: skip
def test_what_cannot_touch_is_refused_before_the_first_step(effect, shape, match):
    with pytest.raises(Unsupported, match=match):
        begin(Scene((Body("table", Box((1.0, 1.0, 1.0))), Body("b", shape, 1.0, (0.0, 0.0, 2.0))), (Gravity(), effect)))


@pytest.mark.parametrize("choice", [{"impact_law": "magic"}, {"solver": "magic"}, {"time_of_contact": "magic"},
                                    {"tolerance": 1.0}, {"events": 0}])  # fmt: skip
def test_settings_name_what_is_allowed(choice):
    with pytest.raises(ValueError, match="allowed"):
        Settings(**choice)


def test_three_boxes_dropped_at_random_settle():
    rng = np.random.default_rng(5)
    boxes = [
        Body(f"b{i}", Box(tuple(rng.uniform(0.2, 0.5, 3).tolist())), float(rng.uniform(0.5, 3.0)),
             (*rng.uniform(-0.1, 0.1, 2).tolist(), 0.6 + 0.9 * i), tuple(normalised(rng.normal(size=4)).tolist()),
             angular_velocity=tuple(rng.normal(size=3).tolist()))
        for i in range(3)
    ]  # fmt: skip
    world = begin(Scene((FLOOR, *boxes), (*EFFECTS, Restitution(0.4))))

    def energy():
        state, total = world.state(), 0.0
        for i, box in enumerate(boxes, start=1):
            total += 0.5 * box.mass * state.v[i] @ state.v[i] + 0.5 * state.w[i] @ world.motion.L[i]
            total += 9.81 * box.mass * state.x[i, 2]
        return total

    before = energy()
    for _ in range(12):
        advance(world, 0.25)
        now = energy()
        assert now <= before + 1e-9
        before = now
    assert world.audit.gap >= -1e-10
    assert world.audit.energy_rise <= 1e-11


@pytest.mark.parametrize("start", [0.1, 0.3, 0.9])
def test_a_ball_leaves_a_sphere_with_all_its_speed(start):
    """It leaves where cos θ = 2/3 cos θ₀, and keeps its horizontal velocity from there on (Newton's laws, energy)."""
    radius, ball = 1.1, Body("ball", Sphere(0.1), 1.0, (1.1 * math.sin(start), 0.0, 1.1 * math.cos(start)))
    world = begin(Scene((Body("big", Sphere(1.0)), ball), (Gravity(), Resting())))
    while world.mode[1] != FLYING or world.t == 0.0:
        advance(world, 0.05)
    cosine = 2.0 / 3.0 * math.cos(start)
    speed = math.sqrt(2.0 * 9.81 * radius * (math.cos(start) - cosine))
    # steps are good to 1e-12, and the fall from rest makes the most of an error at its begin: 1 / θ₀²
    assert world.state().v[1, 0] == pytest.approx(speed * cosine, rel=1e-12 / start**2)
