"""The penalty method: its closed forms hold, and what it costs shows."""

import math
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from mechanics.effects import Drag, Force, Friction, Gravity, Hinge, Resting, Restitution, Rotation
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, Capsule, HalfSpace, Mesh, Sphere
from reference_impl.effects.penalty import GRAVITY, LEAST, damping_ratio, restitution_of
from reference_impl.errors import Overlap, Stalled, Unsupported
from reference_impl.penalty import begin

FLOOR = Body("floor", HalfSpace())
DEPTH = 1e-4
OMEGA = math.sqrt(GRAVITY / DEPTH)


def landing(e, speed=1.0, **more):
    """A ball that meets the floor at `speed`, without gravity."""
    ball = Body("ball", Sphere(0.1), 1.0, (0.0, 0.0, 0.1), velocity=(0.0, 0.0, -speed), **more)
    return Scene((FLOOR, ball), (Restitution(e),))


def brick(size):
    """A box as a mesh of twelve triangles."""
    corners = np.array(list(product((-0.5, 0.5), repeat=3))) * size
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    return Mesh(tuple(map(tuple, corners.tolist())), tuple(triangles))


def rebound(e, dt, depth=DEPTH):
    world = begin(landing(e), dt, depth)
    world.advance(0.04)
    return float(world.state().v[1, 2])


def test_the_restitution_of_a_spring_and_damper_in_closed_form():
    # m = 1 kg, k = 1e5 N/m, c = 40 N s/m, evaluated with forty digits
    assert restitution_of(40.0 / (2.0 * math.sqrt(1e5))) == pytest.approx(0.82607563393153414, rel=1e-14)


@pytest.mark.parametrize("zeta", [0.01, 0.3, 0.7, 0.8, 0.999, 1.0, 1.001, 2.0, 5.0])
def test_the_closed_form_is_what_the_equation_of_motion_says(zeta):
    def released(t, y):
        return -y[0] - 2.0 * zeta * y[1]

    released.terminal, released.direction = True, -1.0
    motion = solve_ivp(lambda t, y: [y[1], -y[0] - 2.0 * zeta * y[1]], (0.0, 100.0), [0.0, -1.0], events=released,
                       rtol=1e-11, atol=1e-13, method="DOP853", first_step=1e-6)  # fmt: skip
    assert restitution_of(zeta) == pytest.approx(motion.y[1, -1], rel=1e-7)


@given(st.floats(LEAST, 1.0))
def test_damping_is_chosen_for_the_restitution(e):
    assert restitution_of(damping_ratio(e)) == pytest.approx(e, abs=1e-12)


def test_too_little_restitution_is_that_of_the_least():
    assert damping_ratio(0.0) == damping_ratio(LEAST)


@pytest.mark.parametrize("e", [1.0, 0.8, 0.5, 0.1])
def test_a_ball_rebounds_with_its_restitution_as_steps_get_finer(e):
    coarse, fine = (abs(rebound(e, dt) - e) for dt in (1e-3, 1e-4))
    assert coarse < 0.05
    # first order: the damper's force jumps when contact begins
    assert fine < 0.25 * coarse


def test_penetration_of_an_impact_in_closed_form():
    # the ball and floor of the closed form above, whose deepest overlap has been evaluated with forty digits
    zeta, omega = 40.0 / (2.0 * math.sqrt(1e5)), math.sqrt(1e5)
    world = begin(landing(restitution_of(zeta)), 2e-5, GRAVITY / omega**2)
    world.advance(0.02)
    assert -world.audit.gap == pytest.approx(0.0028741531516805679, rel=1e-3)


@pytest.mark.parametrize("speed", [0.1, 1.0, 3.0])
def test_an_impact_goes_deeper_than_the_depth_that_was_asked(speed):
    world = begin(landing(1.0, speed), 1e-4, DEPTH)
    world.advance(0.02)
    assert -world.audit.gap == pytest.approx(speed / OMEGA, rel=1e-2)
    assert speed < 0.05 or -world.audit.gap > 3.0 * DEPTH


@pytest.mark.parametrize("mass", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("depth", [1e-3, 1e-5])
def test_a_ball_sinks_in_by_the_depth_whatever_its_mass(mass, depth):
    ball = Body("ball", Sphere(0.1), mass, (0.0, 0.0, 0.1))
    radian = math.sqrt(depth / 9.81)
    world = begin(Scene((FLOOR, ball), (Gravity(), Resting())), 0.2 * radian, depth)
    world.advance(30.0 * radian)
    assert 0.1 - world.state().x[1, 2] == pytest.approx(depth, rel=1e-6)
    assert sum(h.force for h in world.forces) == pytest.approx(9.81 * mass, rel=1e-6)


def test_four_corners_are_four_springs():
    box = Body("box", Box((0.4, 0.3, 0.2)), 2.0, (0.0, 0.0, 0.1))
    world = begin(Scene((FLOOR, box), (Gravity(), Resting(), Rotation())), 1e-3, DEPTH)
    world.advance(0.1)
    assert 0.1 - world.state().x[1, 2] == pytest.approx(DEPTH / 4.0, rel=1e-6)
    assert [h.force for h in world.forces] == pytest.approx([2.0 * 9.81 / 4.0] * 4, rel=1e-6)


@pytest.mark.parametrize("e", [0.8, 0.5])
def test_four_corners_at_once_have_another_restitution(e):
    length, width, height = size = (1.0, 0.5, 0.5)
    box = Body("box", Box(size), 1.0, (0.0, 0.0, 0.25), velocity=(0.0, 0.0, -1.0))
    world = begin(Scene((FLOOR, box), (Restitution(e), Rotation())), 2e-5, DEPTH)
    world.advance(0.02)
    # mobility of one corner times the mass; that of all four together is 4
    alone = 1.0 + 3.0 * width**2 / (width**2 + height**2) + 3.0 * length**2 / (length**2 + height**2)
    expected = restitution_of(damping_ratio(e) * math.sqrt(4.0 / alone))
    assert expected > e + 0.01
    assert world.state().v[1, 2] == pytest.approx(expected, abs=1e-3)


def test_the_price_of_a_depth_is_the_step():
    for depth, dt in ((1e-4, 1e-3), (1e-6, 1e-3), (1e-6, 1e-4)):
        world = begin(landing(1.0), dt, depth)
        world.advance(0.02)
        assert world.audit.resolution == pytest.approx(math.sqrt(GRAVITY / depth) * dt, rel=1e-12)
    # beyond the limit of stability of Runge-Kutta, 2.8, a spring gives more than it got
    assert rebound(1.0, 1e-3, depth=1e-6) > 1.2


def test_a_step_far_too_long_is_no_answer():
    ball = Body("ball", Sphere(0.1), 1.0, (0.0, 0.0, 0.1), velocity=(0.0, 0.0, -1.0))
    world = begin(Scene((FLOOR, ball), (Gravity(), Restitution(0.01))), 1e-2, 1e-310)
    with pytest.raises(Stalled, match="blew up"):
        world.advance(0.1)


def test_a_ball_that_crosses_a_plate_in_one_step_is_not_seen():
    plate = Body("plate", Box((1.0, 1.0, 0.002)))
    ball = Body("ball", Sphere(0.005), 1.0, (0.0, 0.0, 0.075), velocity=(0.0, 0.0, -100.0))
    world = begin(Scene((plate, ball), (Restitution(1.0),)), 1e-3, DEPTH)
    world.advance(0.01)
    assert world.state().v[1, 2] == -100.0


@settings(max_examples=15)
@given(st.floats(0.1, 10.0), st.floats(0.1, 1.0))
def test_two_balls_keep_their_momentum(ratio, e):
    a = Body("a", Sphere(0.1), 1.0, (-0.1001, 0.0, 0.0), velocity=(1.0, 0.0, 0.0))
    b = Body("b", Sphere(0.1), ratio, (0.1, 0.03, 0.0), velocity=(-0.5, 0.0, 0.0))
    world = begin(Scene((a, b), (Restitution(e), Rotation())), 1e-3, DEPTH)
    world.advance(0.03)
    v = world.state().v
    assert v[0] + ratio * v[1] == pytest.approx([1.0 - 0.5 * ratio, 0.0, 0.0], abs=1e-13 * (1.0 + ratio))
    assert not world.state().w.any() or np.abs(world.state().w).max() < 1e-12


def test_angular_momentum_is_kept_to_the_order_of_the_step_when_boxes_meet():
    a = Body("a", Box((0.2, 0.2, 0.2)), 1.0, (-0.16, 0.0, 0.0), (0.9, 0.1, 0.3, 0.2), (1.0, 0.0, 0.0))
    b = Body("b", Box((0.2, 0.3, 0.2)), 2.0, (0.16, 0.05, 0.02), velocity=(-1.0, 0.0, 0.0))
    mass = np.array([[1.0], [2.0]])
    changes = []
    for dt in (1e-3, 5e-4):
        world = begin(Scene((a, b), (Restitution(0.7), Rotation())), dt, DEPTH)
        before = world.state()
        world.advance(0.1)
        after = world.state()
        assert world.audit.gap < 0.0
        # neither body turns at the start
        orbital = np.cross(after.x, mass * after.v) - np.cross(before.x, mass * before.v)
        changes.append(np.abs(orbital.sum(axis=0) + world.y[:, 10:13].sum(axis=0)).max())
    assert changes[0] < 1e-7
    assert changes[1] < changes[0] / 10.0


def test_vertices_of_a_mesh_land_like_the_corners_of_a_box():
    size = (0.4, 0.3, 0.2)
    effects = (Gravity(), Restitution(0.4), Resting(), Rotation())
    states = []
    for shape in (Box(size), brick(size)):
        body = Body("body", shape, 1.0, (0.0, 0.0, 0.2), (1.0, 0.2, 0.1, 0.0), inertia=(0.01, 0.02, 0.03))
        world = begin(Scene((FLOOR, body), effects), 2e-3, DEPTH)
        world.advance(0.2)
        states.append(world.state())
    assert world.audit.gap < 0.0
    assert states[0].x == pytest.approx(states[1].x, abs=1e-9)
    assert states[0].q == pytest.approx(states[1].q, abs=1e-9)


@pytest.mark.parametrize("lower", [Box((0.6, 0.6, 0.2)), brick((0.6, 0.6, 0.2))], ids=["box", "mesh"])
@pytest.mark.parametrize("upper", [Sphere(0.1), Box((0.2, 0.2, 0.2)), brick((0.2, 0.2, 0.2))], ids=["s", "b", "m"])
def test_bodies_lie_on_boxes_and_on_fields_of_meshes(lower, upper):
    body = Body("body", upper, 1.0, (0.02, 0.03, 0.2))
    world = begin(Scene((Body("table", lower), body), (Gravity(), Resting(), Rotation())), 1e-3, DEPTH)
    world.advance(0.06)
    # the field of a mesh is exact on the flat of its faces, away from the ridges
    assert -3.0 * DEPTH < world.state().x[1, 2] - 0.2 < 0.0
    assert sum(h.force * h.normal[2] for h in world.forces) == pytest.approx(9.81, rel=1e-2)


def test_loads_begin_and_end_within_a_step():
    push = Force("ball", (2.0, 0.0, 0.0), start=0.01234, end=0.04321)
    ball = Body("ball", Sphere(0.1), 4.0, (0.0, 0.0, 1.0))
    world = begin(Scene((ball,), (push,)), 1e-2, DEPTH)
    world.advance(0.1)
    assert world.state().v[0, 0] == pytest.approx(0.5 * (0.04321 - 0.01234), rel=1e-13)


def test_drag_is_part_of_the_ode():
    ball = Body("ball", Sphere(0.1), 2.0, velocity=(1.0, 0.0, 0.0))
    world = begin(Scene((ball,), (Drag(3.0),)), 1e-2, DEPTH)
    world.advance(1.0)
    assert world.state().v[0, 0] == pytest.approx(math.exp(-1.5), rel=1e-9)


def test_times_add_up_to_whole_steps():
    world = begin(landing(1.0), 1e-3, DEPTH)
    for _ in range(7):
        world.advance(0.0004)
    assert world.t == pytest.approx(0.003)
    assert world.steps == 3


@pytest.mark.parametrize(
    ("bodies", "effects", "said"),
    [
        ((FLOOR, Body("can", Capsule(0.1, 0.2), 1.0, (0, 0, 1))), (Restitution(0.5),), "'can', a Capsule"),
        ((FLOOR, Body("a", Sphere(0.1), 1.0, (0, 0, 1))), (Friction(0.5),), "Friction with a coefficient of 0.5"),
        ((Body("a", Sphere(0.1), 1.0), Body("b", Sphere(0.1), 1.0, (1, 0, 0))), (Hinge("a", "b"),), "Hinge"),
    ],
)
def test_what_it_has_no_part_for_is_refused_by_name(bodies, effects, said):
    with pytest.raises(Unsupported, match=said):
        begin(Scene(bodies, effects), 1e-3, DEPTH)


def test_bodies_that_overlap_at_the_start_are_refused():
    ball = Body("ball", Sphere(0.1), 1.0, (0.0, 0.0, 0.09))
    with pytest.raises(Overlap, match=r"'ball' and 'floor' overlap by 0\.01 m"):
        begin(Scene((FLOOR, ball), (Restitution(0.5),)), 1e-3, DEPTH)


def test_smooth_contact_needs_no_more_than_friction_zero():
    ball = Body("ball", Sphere(0.1), 1.0, (0.0, 0.0, 0.1))
    world = begin(Scene((FLOOR, ball), (Gravity(), Friction(0.0))), 1e-3, DEPTH)
    world.advance(0.1)
    assert world.state().x[1, 2] == pytest.approx(0.1 - DEPTH, rel=1e-6)
