"""Springs and dampers against closed forms, and the laws of momentum and energy."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mechanics.effects import Force, Gravity, Hinge, Resting, Restitution, Rod, Rotation, Spring
from mechanics.rotation import rotate
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Sphere
from reference_impl.errors import Unsupported
from reference_impl.simulate import advance, begin, simulate
from reference_impl.world import STILL

G = 9.81
WALL = Body("wall", Sphere(0.01))


def ball(name, place, velocity=(0.0, 0.0, 0.0), mass=1.0):
    return Body(name, Sphere(0.1), mass, tuple(float(c) for c in place), velocity=tuple(float(c) for c in velocity))


def oscillation(stiffness, damping, mass, start, speed, t):
    """Displacement of m x'' + c x' + k x = 0 at time t, whatever the damping."""
    decay, square = 0.5 * damping / mass, stiffness / mass - (0.5 * damping / mass) ** 2
    rate = np.sqrt(complex(square))
    if abs(rate) == 0.0:
        return math.exp(-decay * t) * (start + (speed + decay * start) * t)
    return float(
        (np.exp(-decay * t) * (start * np.cos(rate * t) + (speed + decay * start) * np.sin(rate * t) / rate)).real
    )


@pytest.mark.parametrize("damping", [0.0, 3.0, 24.0, 60.0])  # free, under-damped, critical, over-damped
def test_a_mass_on_a_spring(damping):
    spring = Spring("wall", "ball", 48.0, 2.0, damping)
    scene = Scene((WALL, ball("ball", (2.5, 0.0, 0.0), (1.5, 0.0, 0.0), 3.0)), (spring,))
    times = (0.0, 0.3, 1.0, 5.0)
    motion = simulate(scene, times)
    for k, t in enumerate(times):
        expected = 2.0 + oscillation(48.0, damping, 3.0, 0.5, 1.5, t)
        assert motion.x[k, 1] == pytest.approx((expected, 0.0, 0.0), abs=2e-12)


@pytest.mark.parametrize("seconds", [5.0, pytest.param(100.0, marks=pytest.mark.long)])
def test_energy_and_phase_of_a_spring_last(seconds):
    """Energy within 1e-12 over 64 periods, and the phase with it."""
    world = begin(Scene((WALL, ball("ball", (1.2, 0.0, 0.0))), (Spring("wall", "ball", 16.0, 1.0),)))
    advance(world, seconds)
    state = world.state()
    stored = 0.5 * state.v[1, 0] ** 2 + 8.0 * (state.x[1, 0] - 1.0) ** 2
    assert stored == pytest.approx(0.5 * 16.0 * 0.04, rel=1e-12)
    assert state.x[1, 0] == pytest.approx(1.0 + 0.2 * math.cos(4.0 * seconds), abs=1e-11)


def test_two_bodies_on_a_spring_keep_their_centre():
    """The distance oscillates with the reduced mass 2/3 kg, the centre keeps its speed."""
    bodies = (ball("a", (0.0, 0.0, 0.0), (0.3, 0.1, 0.2), 1.0), ball("b", (1.4, 0.0, 0.0), (0.3, 0.1, 0.2), 2.0))
    motion = simulate(Scene(bodies, (Spring("a", "b", 6.0, 1.0),)), (0.0, 1.0, 4.0))
    for k, t in ((1, 1.0), (2, 4.0)):
        centre = (motion.x[k, 0] + 2.0 * motion.x[k, 1]) / 3.0
        assert centre == pytest.approx(np.array((2.8 / 3.0, 0.0, 0.0)) + t * np.array((0.3, 0.1, 0.2)), abs=1e-13)
        distance = motion.x[k, 1, 0] - motion.x[k, 0, 0]
        assert distance == pytest.approx(1.0 + 0.4 * math.cos(3.0 * t), abs=1e-12)


def test_a_spring_of_no_length_draws_ellipses_through_everything():
    """F = -k r in space: each coordinate oscillates by itself, and the centre is no special place."""
    start, speed = np.array((0.5, -0.2, 0.3)), np.array((0.1, 0.7, -0.4))
    scene = Scene((WALL, ball("ball", start, speed, 0.5)), (Spring("wall", "ball", 8.0, 0.0),))
    motion = simulate(scene, (0.0, 2.0, 5.0))
    for k, t in ((1, 2.0), (2, 5.0)):
        expected = start * math.cos(4.0 * t) + speed * math.sin(4.0 * t) / 4.0
        assert motion.x[k, 1] == pytest.approx(expected, abs=2e-12)
    straight = simulate(Scene((WALL, ball("ball", (0.5, 0.0, 0.0))), (Spring("wall", "ball", 1.0, 0.0),)), (0.0, 2.0))
    assert straight.x[1, 1, 0] == pytest.approx(0.5 * math.cos(2.0), abs=1e-12)


def test_a_pendulum_on_a_spring_obeys_lagrange():
    """Elastic pendulum in polar coordinates: r'' = r θ'² + g cos θ - k (r - l) / m, r θ'' = -g sin θ - 2 r' θ'."""
    stiffness, length, mass, damping = 60.0, 1.0, 0.8, 0.5

    def rate(_, y):
        r, angle, dr, spin = y
        pull = (stiffness * (r - length) + damping * dr) / mass
        return dr, 0.0, 0.0, 0.0, r * spin**2 + G * math.cos(angle) - pull, -(G * math.sin(angle) + 2.0 * dr * spin) / r

    def flat(t, y):
        dr, _, _, _, bend, twist = rate(t, y)
        return dr, y[3], bend, twist

    times = (0.0, 1.0, 5.0)
    polar = solve_ivp(flat, (0.0, 5.0), (1.1, 1.0, 0.0, 0.0), "DOP853", times, rtol=1e-13, atol=1e-13).y
    start = (1.1 * math.sin(1.0), 0.0, -1.1 * math.cos(1.0))
    scene = Scene(
        (WALL, ball("ball", start, mass=mass)), (Gravity(), Spring("ball", "wall", stiffness, length, damping))
    )
    motion = simulate(scene, times)
    for k in (1, 2):
        r, angle = polar[:2, k]
        assert motion.x[k, 1] == pytest.approx((r * math.sin(angle), 0.0, -r * math.cos(angle)), abs=1e-11)


def test_springs_off_the_centre_turn_bodies_and_keep_energy_and_momentum():
    a = Body("a", Box((0.6, 0.3, 0.2)), 2.0, (0.0, 0.0, 0.0), angular_velocity=(0.5, -1.0, 2.0))
    b = Body("b", Box((0.5, 0.2, 0.4)), 1.0, (1.0, 0.3, 0.0), velocity=(0.0, 0.5, 0.0))
    springs = (Spring("a", "b", 30.0, 0.6, 0.0, (0.3, 0.1, 0.1), (-0.2, 0.1, 0.0)), Spring("b", "a", 10.0, 0.0))
    scene = Scene((a, b), (Rotation(), *springs))
    world = begin(scene)

    def totals():
        s, m, masses = world.state(), world.motion, np.array((2.0, 1.0))
        stored = sum(0.5 * f @ w for f, w in zip(m.L, s.w, strict=True)) + 0.5 * masses @ (s.v**2).sum(axis=1)
        for spring in springs:
            ends = [
                s.x[i] + rotate(s.q[i], np.array(p))
                for i, p in ((scene.index(spring.a), spring.anchor_a), (scene.index(spring.b), spring.anchor_b))
            ]
            stored += 0.5 * spring.stiffness * (np.linalg.norm(ends[0] - ends[1]) - spring.length) ** 2
        spin = (np.cross(s.x, masses[:, None] * s.v) + m.L).sum(axis=0)
        return np.array((*(masses[:, None] * s.v).sum(axis=0), *spin, stored))

    before = totals()
    for _ in range(3):
        advance(world, 1.0)
        assert totals() == pytest.approx(before, abs=5e-12)


def test_a_load_on_a_damped_spring_comes_to_rest_where_it_hangs():
    scene = Scene(
        (WALL, ball("ball", (0.0, 0.0, -1.0), mass=2.0)), (Gravity(), Spring("wall", "ball", 200.0, 1.0, 40.0))
    )
    world = begin(scene)
    advance(world, 10.0)
    assert world.state().x[1] == pytest.approx((0.0, 0.0, -1.0 - 2.0 * G / 200.0), abs=1e-14)


def test_what_hangs_on_a_spring_at_rest_is_at_rest():
    # 1/16 m of stretch for a pull of 16 N/m * 1/16 m: exact in binary
    scene = Scene(
        (WALL, ball("ball", (0.0, 0.0, -1.0625))), (Gravity((0.0, 0.0, -1.0)), Spring("wall", "ball", 16.0, 1.0))
    )
    world = begin(scene)
    advance(world, 100.0)
    assert world.mode[1] == STILL
    assert world.audit.steps == 0
    assert (world.state().x[1] == (0.0, 0.0, -1.0625)).all()


def test_a_box_on_a_spring_lands_on_the_floor():
    """Pulled down to a floor it bounces by Newton's law, and lies there pressed by spring and weight."""
    floor = Body("floor", HalfSpace())
    box = Body("box", Box((0.4, 0.4, 0.2)), 2.0, (0.0, 0.0, 0.6))
    spring = Spring("floor", "box", 50.0, 0.0)
    scene = Scene((floor, box), (Gravity(), Rotation(), Restitution(0.5), Resting(), spring))
    world = begin(scene)
    advance(world, 3.0)
    # 2 z'' = -2 g - 50 z from 0.6 m: a quarter and more of a swing about -2 g / 50
    below = 2.0 * G / 50.0
    time = math.acos((0.1 + below) / (0.6 + below)) / 5.0
    speed = 5.0 * (0.6 + below) * math.sin(5.0 * time)
    first = world.events[:4]
    # features within 1e-9 of the body's size touch: a polynomial that is off may end a step that early
    assert [event.time for event in first] == pytest.approx([time] * 4, abs=1e-9 * 0.3 / speed)
    assert sum(event.impulse for event in first) == pytest.approx(1.5 * 2.0 * speed, rel=1e-10)
    assert world.mode[1] == STILL
    assert sum(h.force for h in world.forces) == pytest.approx(2.0 * G + 50.0 * 0.1, rel=1e-13)
    assert world.state().x[1] == pytest.approx((0.0, 0.0, 0.1), abs=1e-14)


def test_a_spring_drives_a_hinged_bar():
    """A uniform bar on a hinge with a spring from its end to a fixed point, by the equation of its angle."""
    length, mass, stiffness, natural = 0.8, 1.2, 25.0, 0.3
    hook = Body("hook", Sphere(0.01), None, (0.5, 0.0, 0.4))
    bar = Body("bar", Box((length, 0.05, 0.05)), mass, (0.5 * length, 0.0, 0.0), inertia=(1e-3, mass * length**2 / 12,
               mass * length**2 / 12))  # fmt: skip
    effects = (Gravity(), Rotation(), Hinge("wall", "bar"), Spring("hook", "bar", stiffness, natural,
               anchor_b=(0.5 * length, 0.0, 0.0)))  # fmt: skip

    def flat(_, y):
        angle, spin = y  # below the horizontal
        out, turn = np.array((math.cos(angle), -math.sin(angle))), np.array((-math.sin(angle), -math.cos(angle)))
        r = length * out - np.array((0.5, 0.4))
        pull = -stiffness * (1.0 - natural / np.linalg.norm(r)) * r
        torque = length * pull @ turn + 0.5 * mass * G * length * math.cos(angle)
        return spin, torque / (mass * length**2 / 3.0)

    times = (0.0, 0.7, 3.0)
    angles = solve_ivp(flat, (0.0, 3.0), (0.0, 0.0), "DOP853", times, rtol=1e-13, atol=1e-13).y[0]
    motion = simulate(Scene((WALL, hook, bar), effects), times)
    for k in (1, 2):
        expected = 0.5 * length * np.array((math.cos(angles[k]), 0.0, -math.sin(angles[k])))
        assert motion.x[k, 2] == pytest.approx(expected, abs=1e-11)


def test_a_stiff_spring_is_followed():
    """100 MN/m: 16 kHz on 10 g... the motion is resolved, and what is slow beside it stays right."""
    bodies = (ball("a", (0.0, 0.0, 0.0), mass=1.0), ball("b", (1.0, 0.0, 0.0), mass=1.0))
    scene = Scene(bodies, (Spring("a", "b", 1e8, 1.0), Force("a", (2.0, 0.0, 0.0))))
    motion = simulate(scene, (0.0, 1e-3))
    # both masses move on with half the acceleration; the distance oscillates about its shift
    rate = math.sqrt(2e8)
    squeeze = 2.0 / 2e8 * (1.0 - math.cos(rate * 1e-3))
    assert motion.x[1].sum(axis=0)[0] == pytest.approx(1.0 + 2.0 * 0.5 * 1e-6, abs=1e-15)
    assert motion.x[1, 1, 0] - motion.x[1, 0, 0] == pytest.approx(1.0 - squeeze, abs=1e-13)


def test_a_spring_beside_a_rod_between_the_same_bodies_does_nothing():
    bodies = (ball("a", (0.0, 0.0, 0.0), (0.0, 1.0, 0.0)), ball("b", (1.0, 0.0, 0.0), (0.0, -1.0, 0.0)))
    motion = simulate(Scene(bodies, (Rod("a", "b"), Spring("a", "b", 500.0, 0.2))), (0.0, 2.0))
    expected = np.array(((0.5 - 0.5 * math.cos(4.0), 0.5 * math.sin(4.0), 0.0),) * 2)
    expected[1] = np.array((1.0, 0.0, 0.0)) - expected[0]
    assert motion.x[1] == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("spring", [Spring("a", "b", 1.0, 0.5), Spring("a", "b", 0.0, 0.0, 0.5)])
def test_a_spring_without_a_direction_is_refused(spring):
    bodies = (Body("a", Sphere(0.1), 1.0), Body("b", Sphere(0.1), 1.0))
    with pytest.raises(Unsupported, match="Spring between 'a' and 'b': its anchors coincide"):
        begin(Scene(bodies, (spring,)))


@pytest.mark.parametrize("spring", [Spring("a", "b", 0.0, 0.5), Spring("wall", "post", 9.0, 0.5)])
def test_a_spring_that_moves_nothing_costs_nothing(spring):
    bodies = (
        WALL,
        Body("post", Sphere(0.1), position=(1.0, 0.0, 0.0)),
        ball("a", (0.0, 3.0, 0.0)),
        ball("b", (1.0, 3.0, 0.0)),
    )
    assert begin(Scene(bodies, (Gravity(), spring))).links is None
