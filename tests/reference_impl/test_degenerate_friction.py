"""Degenerate friction: slopes at the limit, slip that is zero or turns, wedges, jams, forces that are not unique."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from mechanics.effects import Friction, Gravity, Hinge, Resting, Rod, Rotation
from mechanics.rotation import about
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Sphere
from reference_impl.audit import kinetic_energy
from reference_impl.simulate import advance, begin
from reference_impl.world import STILL

G = 9.81
FLOOR = Body("floor", HalfSpace())


def rough(mu, *more):
    return (Gravity(), Friction(mu), Resting(), Rotation(), *more)


def brick(name, position, size=(0.4, 0.4, 0.1), mass=2.0, **told):
    return Body(name, Box(size), mass, position, **told)


def slope(angle, velocity=0.0):
    """A block of 2 kg on a plane inclined downwards along x by `angle` [rad], and the direction down."""
    normal = np.array([math.sin(angle), 0.0, math.cos(angle)])
    down = np.array([math.cos(angle), 0.0, -math.sin(angle)])
    block = brick("block", tuple((0.05 * normal).tolist()), orientation=tuple(about((0.0, 1.0, 0.0), angle).tolist()),
                  velocity=tuple((velocity * down).tolist()))  # fmt: skip
    return Body("plane", HalfSpace(tuple(normal.tolist()))), block, down


def friction_on(world, name):
    """Sum of the friction on a body [N]."""
    i = world.scene.names.index(name)
    total = np.zeros(3)
    for h in world.forces:
        if i in (h.a, h.b):
            total += np.array(h.friction) * (1.0 if h.a == i else -1.0)
    return total


@pytest.mark.parametrize("off", [-1e-12, 0.0, 1e-12, 1e-8])
def test_at_the_limit_of_the_slope_a_block_stays_or_hardly_moves(off):
    """µ = tan φ (1 + off): acceleration g (sin φ - µ cos φ); less than 1e-9 g is rest."""
    angle = math.radians(25.0)
    plane, block, down = slope(angle)
    world = begin(Scene((plane, block), rough(math.tan(angle) * (1.0 + off))))
    start = world.state().x[1]
    advance(world, 1.0)
    way = 0.5 * G * math.sin(angle) * -off if off < -1e-9 else 0.0
    assert world.state().x[1] == pytest.approx(start + way * down, abs=1e-11)  # accelerations are certified to 1e-12 g
    if off > -1e-9:
        assert world.mode[1] == STILL


@pytest.mark.parametrize("speed", [0.0, 1.0])
@pytest.mark.parametrize("mu", [0.0, 1e6])
def test_no_friction_and_more_than_any(mu, speed):
    """On a slope: µ = 0 slides by its sine whatever the speed, µ = 1e6 holds what is at rest."""
    angle = math.radians(25.0)
    plane, block, down = slope(angle, speed if mu == 0.0 else 0.0)
    world = begin(Scene((plane, block), rough(mu)))
    start = world.state().x[1]
    advance(world, 0.5)
    way = 0.5 * speed + 0.125 * G * math.sin(angle) if mu == 0.0 else 0.0
    assert world.state().x[1] == pytest.approx(start + way * down, abs=1e-13)


def test_a_ball_under_friction_without_bounds_rolls_at_once():
    """It slides at 3 m/s, µ = 1e6: after 2/7 of v/(µ g), 9e-8 s, it rolls at 5/7 of the speed."""
    ball = Body("ball", Sphere(0.1), 1.0, (0.0, 0.0, 0.1), velocity=(3.0, 0.0, 0.0))
    world = begin(Scene((FLOOR, ball), rough(1e6)))
    advance(world, 0.5)
    state = world.state()
    assert state.v[1] == pytest.approx((15.0 / 7.0, 0.0, 0.0), rel=1e-9, abs=1e-9)
    assert state.w[1, 1] == pytest.approx(150.0 / 7.0, rel=1e-9)


@pytest.mark.parametrize("heading", [0.0, 1.0, 4.0])
def test_what_rolls_exactly_rolls_on_without_friction(heading):
    """On the level, at v = ω r bit by bit or to rounding: no friction acts, and nothing is lost in ten seconds."""
    way = np.array([math.cos(heading), math.sin(heading), 0.0])
    spin = np.array([-way[1], way[0], 0.0]) / 0.125
    ball = Body("ball", Sphere(0.125), 1.0, (0.0, 0.0, 0.125), velocity=tuple(way.tolist()),
                angular_velocity=tuple(spin.tolist()))  # fmt: skip
    world = begin(Scene((FLOOR, ball), rough(0.3)))
    advance(world, 10.0)
    state = world.state()
    assert np.abs(friction_on(world, "ball")).max() <= 1e-12
    assert state.x[1, :2] == pytest.approx(10.0 * way[:2], abs=1e-12)
    assert state.v[1] == pytest.approx(way, abs=1e-13)
    assert state.w[1] == pytest.approx(spin, abs=1e-12)


def test_a_ball_that_spins_about_its_normal_goes_on():
    """A point of contact does not brake a spin about the normal (no drilling friction)."""
    ball = Body("ball", Sphere(0.1), 1.0, (0.0, 0.0, 0.1), angular_velocity=(0.0, 0.0, 20.0))
    world = begin(Scene((FLOOR, ball), rough(0.5)))
    advance(world, 5.0)
    assert world.state().w[1] == pytest.approx((0.0, 0.0, 20.0), rel=1e-13, abs=1e-13)
    assert world.state().x[1] == pytest.approx((0.0, 0.0, 0.1), abs=1e-14)


def test_a_spinning_box_is_braked_by_all_its_corners():
    """A flat box spins on its four corners: α = -µ g r m / I while every corner carries a quarter, then rest.

    By symmetry the loads are equal; r is the distance of a corner from the middle.
    """
    size, mu, rate = 0.4, 0.2, 6.0
    world = begin(Scene((FLOOR, brick("box", (0.0, 0.0, 0.05), (size, size, 0.1), angular_velocity=(0.0, 0.0, rate))),
                        rough(mu)))  # fmt: skip
    brake = mu * G * (size / math.sqrt(2.0)) / (size**2 / 6.0)
    advance(world, 0.2)
    assert world.state().w[1, 2] == pytest.approx(rate - 0.2 * brake, rel=1e-11)
    advance(world, 1.0)
    assert world.mode[1] == STILL
    turned = 2.0 * math.atan2(world.state().q[1, 3], world.state().q[1, 0])
    assert turned == pytest.approx(0.5 * rate**2 / brake, rel=1e-10)


@pytest.mark.parametrize("push", [1e-6, 1.0])
def test_slip_turns_round_where_the_floor_does(push):
    """A block slides up a slope steeper than its friction angle, stops for no time, and slides down again."""
    angle, mu, up = math.radians(30.0), 0.2, 2.0 * math.sqrt(push)
    plane, block, down = slope(angle, -up)
    world = begin(Scene((plane, block), rough(mu)))
    start = world.state().x[1]
    rise, fall = G * (math.sin(angle) + mu * math.cos(angle)), G * (math.sin(angle) - mu * math.cos(angle))
    stop = up / rise
    advance(world, 1.5 * stop)
    way = -0.5 * up**2 / rise + 0.5 * fall * (0.5 * stop) ** 2
    assert (world.state().x[1] - start) @ down == pytest.approx(way, rel=1e-12)
    assert world.state().v[1] @ down == pytest.approx(0.5 * fall * stop, rel=1e-11)


@pytest.mark.parametrize("mu", [0.2, 0.9])
def test_two_plates_that_rub_with_nothing_else_in_the_world(mu):
    """No gravity and no load presses them: there is no normal force, and so no friction."""
    low, high = brick("low", (0.0, 0.0, 0.0)), brick("high", (0.0, 0.0, 0.1), velocity=(0.3, 0.1, 0.0))
    world = begin(Scene((low, high), (Friction(mu), Resting(), Rotation())))
    advance(world, 1.0)
    assert world.state().v[1:] == pytest.approx(np.array([[0.3, 0.1, 0.0]]), abs=1e-15)
    assert not world.state().v[0].any()


def test_the_coefficient_belongs_to_the_pair_in_whichever_order():
    """Friction of a pair is told in either order, and where either body stands in the list."""
    ends = []
    for key, order in ((("a", "floor"), 1), (("floor", "a"), 1), (("a", "floor"), -1)):
        bodies = (FLOOR, brick("a", (0.0, 0.0, 0.05), velocity=(1.0, 0.0, 0.0)))[::order]
        friction = Friction(0.9, {key: 0.1})
        world = begin(Scene(bodies, (Gravity(), friction, Resting(), Rotation())))
        advance(world, 0.5)
        ends.append(world.state().x[world.scene.names.index("a")])
    assert ends[0][0] == pytest.approx(0.5 - 0.125 * 0.1 * G, rel=1e-13)
    assert all((ends[0] == end).all() for end in ends[1:])


@pytest.mark.parametrize(("pull", "follows"), [(2.0, True), (40.0, False)])
def test_a_stack_on_a_sheet_that_is_jerked_away(pull, follows):
    """Below µ g the stack goes with the sheet; above it every box is left behind by µ g, and the upper ones with it."""
    sheet = Body("sheet", Box((40.0, 2.0, 0.2)), position=(0.0, 0.0, -0.1), acceleration=(pull, 0.0, 0.0))
    boxes = [brick(f"b{i}", (0.0, 0.0, 0.05 + 0.1 * i), (0.6, 0.6, 0.1)) for i in range(3)]
    friction = Friction(0.8, {("sheet", "b0"): 0.3})
    world = begin(Scene((sheet, *boxes), (Gravity(), friction, Resting(), Rotation())))
    advance(world, 0.4)
    way = 0.08 * (pull if follows else 0.3 * G)
    assert world.state().x[1:, 0] == pytest.approx(np.full(3, way), abs=1e-11)
    assert np.abs(world.state().w[1:]).max() <= 1e-10


@pytest.mark.parametrize(("half", "holds"), [(44.0, True), (46.0, False)])
def test_a_wedge_is_held_by_its_friction_or_slips_through(half, holds):
    """A ball in a groove whose sides make `half` degrees with the vertical, pressed along the groove by a slope.

    µ = tan: the ball of 1 kg has N = m g / (2 sin half) on each side, and slides along the groove if the axial weight
    exceeds 2 µ N.  The slope is chosen between the two.
    """
    mu = 0.3
    tilt = math.atan(mu / math.sin(math.radians(45.0)))  # at half = 45 degrees exactly the limit
    along, up = np.array([math.cos(tilt), 0.0, -math.sin(tilt)]), np.array([math.sin(tilt), 0.0, math.cos(tilt)])
    side = np.array([0.0, 1.0, 0.0])
    a = math.radians(half)
    normals = [math.sin(a) * up + s * math.cos(a) * side for s in (1.0, -1.0)]
    planes = [Body(f"p{i}", HalfSpace(tuple(n.tolist()))) for i, n in enumerate(normals)]
    ball = Body("ball", Sphere(0.1), 1.0, tuple((0.1 / math.sin(a) * up).tolist()))
    world = begin(Scene((*planes, ball), (Gravity(), Friction(mu), Resting())))
    start = world.state().x[2]
    advance(world, 0.5)
    pull = G * (math.sin(tilt) - mu * math.cos(tilt) / math.sin(a))
    assert (pull < 0.0) == holds
    assert world.state().x[2] == pytest.approx(start + 0.125 * max(pull, 0.0) * along, abs=1e-12)


@pytest.mark.parametrize("mu", [0.05, 0.9, 5.0])
def test_a_ball_jammed_between_two_walls_stays(mu):
    """Walls that lean 10 degrees apart: any squeeze beyond the weight will do, if its friction holds against it.

    The forces are not unique; the motion is, and those that are told lie within their cones and balance the weight.
    """
    lean = math.radians(10.0)
    normals = [np.array([s * math.cos(lean), 0.0, math.sin(lean)]) for s in (1.0, -1.0)]
    walls = [Body(f"w{i}", HalfSpace(tuple(n.tolist()))) for i, n in enumerate(normals)]
    ball = Body("ball", Sphere(0.1), 2.0, (0.0, 0.0, 0.1 / math.sin(lean)))
    world = begin(Scene((*walls, ball), rough(mu)))
    start = world.state().x[2]
    advance(world, 0.5)
    assert world.state().x[2] == pytest.approx(start, abs=1e-13)
    total = sum(h.force * np.array(h.normal) + np.array(h.friction) for h in world.forces)
    assert total == pytest.approx((0.0, 0.0, 2.0 * G), abs=1e-10)
    for h in world.forces:
        assert np.linalg.norm(h.friction) <= mu * h.force * (1.0 + 1e-10)


def test_a_ball_on_a_leaning_rod_is_braked_on_its_circle():
    """On a rough floor, tied by a rod to a point above its middle: v = V tanh(artanh(v0/V) - µ g t / V).

    The rod carries m v² h / r² of the weight, so that friction is µ m g (1 - v²/V²) with V² = g r² / h.
    """
    mu, height, radius, start = 0.25, 0.6, 0.8, 2.0
    post = Body("post", Sphere(0.01), None, (0.0, 0.0, 0.1 + height))
    ball = Body("ball", Sphere(0.1), 2.0, (radius, 0.0, 0.1), velocity=(0.0, start, 0.0))
    world = begin(Scene((FLOOR, post, ball), (Gravity(), Friction(mu), Resting(), Rod("post", "ball"))))
    fast = math.sqrt(G * radius**2 / height)
    for t in (0.2, 0.5, 0.8):
        advance(world, t - world.t)
        state = world.state()
        turn = math.atanh(start / fast) - mu * G * t / fast
        angle = fast**2 / (mu * G * radius) * math.log(math.cosh(math.atanh(start / fast)) / math.cosh(turn))
        speed = fast * math.tanh(turn)
        assert state.x[2] == pytest.approx((radius * math.cos(angle), radius * math.sin(angle), 0.1), abs=1e-11)
        assert np.linalg.norm(state.v[2]) == pytest.approx(speed, abs=1e-11)
    advance(world, 0.5)
    assert not world.state().v[2].any()


@pytest.mark.parametrize("swings", [1, 3])
def test_a_pendulum_whose_bob_slides_on_a_rough_slope(swings):
    """θ'' = -(g sin φ sin θ + µ g cos φ sign θ') / l, swing by swing, by Dormand and Prince."""
    tilt, mu, length = math.radians(50.0), 0.15, 0.9
    up, across = np.array([-math.cos(tilt), 0.0, math.sin(tilt)]), np.array([0.0, 1.0, 0.0])
    normal = np.array([math.sin(tilt), 0.0, math.cos(tilt)])

    def place(angle):
        return 0.1 * normal + length * (math.sin(angle) * across - math.cos(angle) * up)

    post = Body("post", Sphere(0.01), None, tuple((0.1 * normal).tolist()))
    ball = Body("ball", Sphere(0.1), 2.0, tuple(place(1.2).tolist()))
    plane = Body("plane", HalfSpace(tuple(normal.tolist())))
    world = begin(Scene((plane, post, ball), (Gravity(), Friction(mu), Resting(), Rod("post", "ball"))))

    def swung(start, t, sign):
        def rate(_, y):
            return y[1], -(G * math.sin(tilt) * math.sin(y[0]) + mu * G * math.cos(tilt) * sign) / length

        return solve_ivp(rate, (0.0, t), (start, 0.0), "DOP853", rtol=3e-14, atol=1e-15).y[:, -1]

    start, begun, sign = 1.2, 0.0, -1.0
    for _ in range(swings):
        lasts = brentq(lambda t, start=start, sign=sign: swung(start, t, sign)[1], 0.9, 1.4, xtol=1e-15)
        for part in (0.3, 0.7, 1.0):
            advance(world, begun + part * lasts - world.t)
            assert world.state().x[2] == pytest.approx(place(swung(start, part * lasts, sign)[0]), abs=1e-12)
        start, begun, sign = swung(start, lasts, sign)[0], begun + lasts, -sign


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_hinged_bar_on_a_belt_presses_more_where_the_belt_runs_towards_it(way):
    """Hinged at its upper end, lying on the belt with its lower edge: N = ½ m g d / (d + s µ h) about the hinge."""
    mu, angle = 0.3, 0.5
    size, q = (1.0, 0.2, 0.02), about((0.0, 1.0, 0.0), angle)
    ends = [math.cos(angle) * x + math.sin(angle) * z for x, z in ((0.5, -0.01), (-0.5, 0.0))]
    lows = [-math.sin(angle) * x + math.cos(angle) * z for x, z in ((0.5, -0.01), (-0.5, 0.0))]
    bar = Body("bar", Box(size), 3.0, (0.0, 0.0, -lows[0]), tuple(q.tolist()))
    belt = Body("belt", HalfSpace(), velocity=(2.0 * way, 0.0, 0.0))
    post = Body("post", Sphere(0.001), None, (ends[1], 5.0, 1.0))
    hinge = Hinge("post", "bar", (ends[1], 0.0, lows[1] - lows[0]), (0.0, 1.0, 0.0))
    world = begin(Scene((belt, post, bar), (*rough(mu), hinge)))
    advance(world, 0.1)
    d, h = ends[0] - ends[1], lows[1] - lows[0]
    load = 3.0 * G * -ends[1] / (d + way * mu * h)
    assert sum(f.force for f in world.forces) == pytest.approx(load, rel=1e-11)
    assert world.state().x[2] == pytest.approx(bar.position, abs=1e-13)
    assert kinetic_energy(world) <= 1e-24


@pytest.mark.parametrize("speed", [63.0, 1000.0])
def test_what_slides_fast_comes_to_rest_where_it_must(speed):
    """A braked block goes v²/2µg: steps are as long as the motion is simple, and its stop is an event."""
    block = brick("block", (0.0, 0.0, 0.05), velocity=(speed, 0.0, 0.0))
    world = begin(Scene((FLOOR, block), rough(0.3)))
    advance(world, 1.01 * speed / (0.3 * G))
    assert world.mode[1] == STILL
    assert world.state().x[1, 0] == pytest.approx(speed**2 / (0.6 * G), rel=1e-13)
    assert world.audit.steps < 100


def test_a_ball_far_out_tells_its_spin():
    """Where coordinates are large their rounding is no measure for the attitude, whose rate is the spin."""
    speed, mu, r = 63.0, 0.3, 0.1
    world = begin(Scene((FLOOR, Body("ball", Sphere(r), 2.0, (2000.0, 0.0, r), velocity=(speed, 0.0, 0.0))), rough(mu)))
    for t in np.linspace(0.011, 0.5, 20):
        advance(world, t - world.t)
        assert world.state().w[1, 1] == pytest.approx(2.5 * mu * G * t / r, rel=1e-11)


@pytest.mark.parametrize("over", [1e-3, 1e-6])
def test_a_block_that_hardly_slides_is_followed_in_a_few_steps(over):
    """Little above the limit friction turns the slip at the rate g / |c|, which steps must not have to follow."""
    angle = math.radians(25.0)
    plane, block, down = slope(angle)
    world = begin(Scene((plane, block), rough(math.tan(angle) * (1.0 - over))))
    start = world.state().x[1]
    advance(world, 40.0)
    way = 0.5 * G * math.sin(angle) * over * 1600.0
    # accelerations are certified to 1e-12 of g, of which this one is a small part
    assert (world.state().x[1] - start) @ down == pytest.approx(way, rel=1e-12 / over)
    assert world.audit.steps < 200


def test_a_slow_slip_that_turns_keeps_its_course_under_stiff_friction():
    """Across a slope at µ = tan φ: D v = v0 / (1 + cos ψ) with ψ from the fall line, however small v0.

    With u = v / v0 and time in v0 / (g sin φ): u' = cos ψ - 1, ψ' = -sin ψ / u.  Where ψ -> 0 u -> 1/2.
    """
    angle, v0 = math.radians(20.0), 0.02
    plane, block, down = slope(angle)
    across = Body("block", block.shape, 2.0, block.position, block.orientation, (0.0, v0, 0.0))
    effects = (Gravity(), Friction(math.tan(angle)), Resting())
    world = begin(Scene((plane, across), effects))
    for t in (0.002, 0.005, 0.02):
        advance(world, t - world.t)
        v = world.state().v[1]
        speed, along = float(np.linalg.norm(v)), float(v @ down)
        assert speed * (1.0 + along / speed) == pytest.approx(v0, rel=1e-9)
