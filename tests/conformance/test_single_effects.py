"""Each mapping of an effect against its closed form, in every fair profile that is installed."""

import importlib.util
import math

import numpy as np
import pytest

import adapters.mujoco
import adapters.pybullet
import adapters.pymunk
from adapters.engine import Refusal
from adapters.run import run
from mechanics.effects import Drag, Force, Friction, Gravity, Hinge, Resting, Restitution, Rod, Rotation, Spring, Tether
from mechanics.rotation import IDENTITY, about, angle_between, rotate
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Sphere
from mechanics.trajectory import Trajectory

G = 9.81
FLOOR = Body("floor", HalfSpace())
POST = Body("post", Sphere(0.02))
FAIR = [
    engine
    for module in (adapters.pybullet, adapters.mujoco, adapters.pymunk)
    for engine in module.ENGINES.values()
    if not engine.stock and importlib.util.find_spec(engine.name.partition(":")[0])
]
SPATIAL = [engine for engine in FAIR if engine.name != "pymunk"]
every_engine = pytest.mark.parametrize("engine", FAIR, ids=lambda engine: engine.name)
spatial_engine = pytest.mark.parametrize("engine", SPATIAL, ids=lambda engine: engine.name)
MUJOCO = pytest.mark.skipif(not importlib.util.find_spec("mujoco"), reason="MuJoCo is not installed")


def drive(engine, scene, duration, dt=1e-3, samples=2, **knobs):
    """The motion at `samples` equidistant times, and the run."""
    result = run(engine, scene, np.linspace(0.0, duration, samples), {"dt": dt, **knobs})
    assert isinstance(result.outcome, Trajectory), result.outcome
    return result.outcome


def possible(engine, scene):
    """Skip where the engine says that it cannot."""
    outcome = run(engine, scene, (0.0, 0.01)).outcome
    if isinstance(outcome, Refusal):
        pytest.skip(outcome.reason)


@every_engine
@pytest.mark.parametrize("e", [0.0, 0.3, 0.5, 0.8, 1.0])
def test_ball_leaves_the_floor_at_e_times_its_speed_at_any_phase_and_step(engine, e):
    for dt in (1e-2, 1e-3, 1e-4):
        for phase in np.linspace(0.05, 0.95, 4):
            ball = Body("ball", Sphere(0.1), 1.0, (0.3, 0.0, 0.1 + (3.0 + phase) * dt), velocity=(0.0, 0.0, -1.0))
            motion = drive(engine, Scene((FLOOR, ball), (Restitution(e),)), 20 * dt, dt)
            assert motion.v[-1, 1] == pytest.approx([0.0, 0.0, e], abs=1e-12)


@every_engine
@pytest.mark.parametrize("speed", [0.05, 20.0])
def test_restitution_has_no_threshold(engine, speed):
    ball = Body("ball", Sphere(0.1), 1.0, (0.0, 0.0, 0.1 + 3.3e-3 * speed), velocity=(0.0, 0.0, -speed))
    motion = drive(engine, Scene((FLOOR, ball), (Restitution(0.5),)), 0.02)
    assert motion.v[-1, 1, 2] == pytest.approx(0.5 * speed, rel=1e-12)


@every_engine
@pytest.mark.parametrize("ratio", [1.0, 1e3, 1e6])
@pytest.mark.parametrize("e", [0.0, 0.5, 1.0])
def test_head_on_collision_at_any_mass_ratio(engine, ratio, e):
    light = Body("light", Sphere(0.1), 1.0, velocity=(1.0, 0.0, 0.0))
    heavy = Body("heavy", Sphere(0.1), ratio, (0.2033, 0.0, 0.0))
    motion = drive(engine, Scene((light, heavy), (Restitution(e),)), 0.02)
    expected = [(1.0 - ratio * e) / (1.0 + ratio), (1.0 + e) / (1.0 + ratio)]
    # MuJoCo's Newton solver stops at 1e-10 of the problem's scale: 7e-13 here
    assert motion.v[-1, :, 0] == pytest.approx(expected, abs=2e-12)


@every_engine
def test_oblique_smooth_collision_changes_velocities_along_the_normal_only(engine):
    a = Body("a", Sphere(0.1), 1.0, velocity=(1.0, 0.0, 0.0))
    b = Body("b", Sphere(0.1), 2.0, (0.3, 0.0, 0.1))
    normal = np.array([-math.sqrt(0.2**2 - 0.1**2), 0.0, -0.1]) / 0.2
    change = -(1.0 + 0.7) * normal[0] / (1.0 + 0.5) * normal
    for dt in (1e-3, 1e-4):
        motion = drive(engine, Scene((a, b), (Restitution(0.7),)), 0.3, dt)
        # the bodies overlap by up to v dt when the engine sees them, which turns the normal by v dt / (r tan 60°)
        assert motion.v[-1, 0] == pytest.approx(np.add((1.0, 0.0, 0.0), change), abs=2.0 * dt / 0.2)
        assert motion.v[-1, 0] + 2.0 * motion.v[-1, 1] == pytest.approx([1.0, 0.0, 0.0], abs=1e-12)


@every_engine
def test_box_that_falls_on_its_edge_turns_as_mechanics_says(engine):
    size, tilt, e, height = np.array([0.2, 0.1, 0.4]), 0.5, 0.5, 0.5
    box = Body("box", Box(tuple(size)), 1.0, (0.0, 0.0, height), tuple(about((0.0, 1.0, 0.0), tilt)))
    arm = min((rotate(np.array(box.orientation), size / 2 * [sx, 0, sz]) for sx in (-1, 1) for sz in (-1, 1)),
              key=lambda r: r[2])  # fmt: skip
    landing = math.sqrt(2.0 * (height + arm[2]) / G)
    inertia = (size[0] ** 2 + size[2] ** 2) / 12.0
    impulse = (1.0 + e) * G * landing / (1.0 + arm[0] ** 2 / inertia)
    spin = -arm[0] * impulse / inertia  # (r × j z)_y = -r_x j
    dt, rest = 1e-4, 0.02
    motion = drive(engine, Scene((FLOOR, box), (Gravity(), Rotation(), Restitution(e))), landing + rest, dt)
    # the engine sees the edge up to one step late, at a speed up to g dt too high
    assert motion.w[-1, 1] == pytest.approx([0.0, spin, 0.0], abs=abs(spin) * 5.0 * dt / landing)
    turned = angle_between(motion.q[-1, 1], about((0.0, 1.0, 0.0), tilt + spin * rest))
    assert turned < 2.0 * abs(spin) * dt
    assert motion.v[-1, 1, 2] == pytest.approx(-G * landing + impulse - G * rest, abs=5.0 * G * dt)


@every_engine
@pytest.mark.parametrize("direction", [0.0, 0.25 * math.pi])
def test_sliding_block_stops_after_v_squared_over_two_mu_g(engine, direction):
    speed, mu = 2.0, 0.5
    velocity = (speed * math.cos(direction), speed * math.sin(direction), 0.0)
    block = Body("block", Box((0.2, 0.2, 0.2)), 1.0, (0.0, 0.0, 0.1), velocity=velocity)
    scene = Scene((FLOOR, block), (Gravity(), Rotation(), Friction(mu), Resting()))
    possible(engine, scene)
    for dt in (4e-3, 1e-3):
        motion = drive(engine, scene, 0.6, dt)
        distance = float(np.linalg.norm(motion.x[-1, 1, :2]))
        # a first-order stepper begins to brake a step early or late: v dt / 2, and 1 % for its rounding up to a step
        assert abs(distance - speed**2 / (2.0 * mu * G)) <= 0.5 * speed * dt * 1.01
        # MuJoCo still undoes its overlap then, 1 % a step
        assert np.abs(motion.v[-1, 1]).max() < 1e-3


@every_engine
def test_block_holds_on_an_incline_below_the_threshold_and_slides_above(engine):
    mu = 0.5
    for share in (0.9, 1.1):
        slope = math.atan(share * mu)
        q = about((0.0, 1.0, 0.0), slope)
        up, down = rotate(q, np.array([0.0, 0.0, 1.0])), rotate(q, np.array([1.0, 0.0, 0.0]))
        plane = Body("plane", HalfSpace(tuple(up)))
        block = Body("block", Box((0.2, 0.2, 0.2)), 1.0, tuple(0.1 * up), tuple(q))
        motion = drive(engine, Scene((plane, block), (Gravity(), Rotation(), Friction(mu), Resting())), 1.0, 1e-3, 3)
        gained = float((motion.v[2, 1] - motion.v[1, 1]) @ down) / 0.5
        expected = max(0.0, G * (math.sin(slope) - mu * math.cos(slope)))
        if share < 1.0:
            # MuJoCo's friction is a damper and creeps at 6e-6 m/s
            assert float(np.linalg.norm(motion.v[-1, 1])) < 1e-5
        # PyBullet's block rocks by a hundredth of a degree while it slides, MuJoCo's hops by 10 µm
        hopping = 0.03 if engine.name == "mujoco" else 5e-3
        assert gained == pytest.approx(expected, abs=hopping if share > 1.0 else 1e-5)
        assert float(motion.x[-1, 1] @ up) == pytest.approx(0.1, abs=2e-5)


@every_engine
def test_sliding_ball_rolls_at_five_sevenths_of_its_speed(engine):
    ball = Body("ball", Sphere(0.1), 1.0, (0.0, 0.0, 0.1), velocity=(2.0, 0.0, 0.0))
    motion = drive(engine, Scene((FLOOR, ball), (Gravity(), Rotation(), Friction(0.3), Resting())), 0.6)
    # MuJoCo: soft friction leaves the last slip to fade with 20 ms, 3e-5 m/s
    assert motion.v[-1, 1] == pytest.approx([10.0 / 7.0, 0.0, 0.0], abs=1e-4)
    assert motion.w[-1, 1] == pytest.approx([0.0, 100.0 / 7.0, 0.0], abs=1e-3)


@every_engine
@pytest.mark.parametrize("count", [1, 5])
def test_boxes_stay_where_they_were_put(engine, count):
    boxes = tuple(Body(f"b{i}", Box((0.5, 0.5, 0.5)), 1.0, (0.0, 0.0, 0.25 + 0.5 * i)) for i in range(count))
    motion = drive(engine, Scene((FLOOR, *boxes), (Gravity(), Rotation(), Friction(0.5), Resting())), 1.0, samples=11)
    # a step of free fall, g dt^2 = 10 µm, per box before the contact acts, and 20 µm of sideways jitter
    assert np.abs(motion.x - motion.x[0]).max() < 3e-5 * count
    assert angle_between(motion.q[-1, 1:], np.array(IDENTITY)).max() < 1e-4


@spatial_engine
def test_free_tumbling_converges_at_the_order_of_the_integrator(engine):
    body = Body("b", Sphere(0.1), 1.0, inertia=(1.0, 2.0, 3.0), angular_velocity=(0.1, 5.0, 0.1))
    scene = Scene((body,), (Rotation(),))
    truth = drive(engine, scene, 0.5, 1e-5 if engine.name != "mujoco" else 1e-4).q[-1, 0]
    errors = [float(angle_between(drive(engine, scene, 0.5, dt).q[-1, 0], truth)) for dt in (1e-2, 5e-3)]
    order = math.log2(errors[0] / errors[1])
    assert order == pytest.approx(4.0 if engine.name == "mujoco" else 1.0, abs=0.1)


@every_engine
def test_drag_is_exponential(engine):
    body = Body("b", Sphere(0.1), 2.0, velocity=(1.0, 0.0, 0.0), angular_velocity=(0.0, 3.0, 0.0))
    motion = drive(engine, Scene((body,), (Drag(0.8, 0.01), Rotation())), 1.0)
    # explicit Euler: relative error (c/m)^2 t dt / 2, with c/m 0.4 and 1.25 per second
    assert motion.v[-1, 0, 0] == pytest.approx(math.exp(-0.4), rel=0.5 * 0.4**2 * 1e-3 * 1.01)
    assert motion.w[-1, 0, 1] == pytest.approx(3.0 * math.exp(-1.25), rel=0.5 * 1.25**2 * 1e-3 * 1.01)


@every_engine
def test_force_acts_in_its_window_only(engine):
    push = Force("b", (1.0, 0.0, 2.0), (0.0, 0.003, 0.0), start=0.1234, end=0.5678)
    body = Body("b", Sphere(0.1), 2.0)
    motion = drive(engine, Scene((body,), (push, Rotation())), 1.0)
    held = 0.5678 - 0.1234
    assert motion.v[-1, 0] == pytest.approx([0.5 * held, 0.0, held], abs=1e-12)
    assert motion.w[-1, 0] == pytest.approx([0.0, 0.003 / 0.008 * held, 0.0], abs=1e-12)


@every_engine
def test_force_off_the_centre_turns_a_body(engine):
    push = Force("b", (1.0, 0.0, 0.0), point=(0.0, 0.0, 0.02))
    body = Body("b", Box((0.2, 0.2, 0.2)), 2.0, inertia=(1.0, 1.0, 1.0))
    motion = drive(engine, Scene((body,), (push, Rotation())), 0.1)
    # the torque is z × x = +y, 0.02 N m; its arm turns by 1e-4 rad meanwhile
    assert motion.w[-1, 0] == pytest.approx([0.0, 0.002, 0.0], rel=1e-6)


@every_engine
def test_spring_swings_at_its_frequency(engine):
    body = Body("b", Sphere(0.1), 2.0, (1.2, 0.0, 0.0))
    scene = Scene((Body("wall", Sphere(0.02)), body), (Spring("wall", "b", 50.0, 1.0),))
    motion = drive(engine, scene, 1.5, samples=16)
    expected = 1.0 + 0.2 * np.cos(5.0 * motion.t)
    # semi-implicit Euler leads or lags by half a step of the speed, 0.2 x 5 x dt / 2
    assert np.abs(motion.x[:, 1, 0] - expected).max() < 5.1e-4


@every_engine
def test_spring_may_hang_on_a_half_space(engine):
    bob = Body("bob", Sphere(0.1), 2.0, (0.0, 0.0, -0.5))
    ceiling = Body("ceiling", HalfSpace((0.0, 0.0, -1.0)), position=(0.0, 0.0, 1.0))
    scene = Scene((ceiling, bob), (Spring("ceiling", "bob", 50.0, 1.5 - 2.0 * G / 50.0), Gravity()))
    motion = drive(engine, scene, 0.5)
    assert motion.x[-1, 1] == pytest.approx([0.0, 0.0, -0.5], abs=1e-12)


@every_engine
def test_spring_between_offset_anchors_conserves_momentum(engine):
    a = Body("a", Sphere(0.1), 1.0)
    b = Body("b", Sphere(0.1), 2.0, (1.2, 0.0, 0.1))
    spring = Spring("a", "b", 50.0, 1.0, 0.5, (0.0, 0.0, 0.1), (0.0, 0.0, -0.1))
    motion = drive(engine, Scene((a, b), (spring, Rotation())), 1.0, samples=11)
    mass = np.array([[1.0], [2.0]])
    momentum = (mass * motion.v).sum(axis=1)
    spin = (np.cross(motion.x, mass * motion.v) + 0.4 * 0.01 * mass * motion.w).sum(axis=1)
    # RK4 conserves angular momentum to its order only, 1e-12 here
    assert np.abs(momentum).max() < 1e-11
    assert np.abs(spin).max() < 1e-11


def pendulum(times, slope=0.0, pull=G):
    """Angle below the horizontal of a rigid pendulum released from there, and its rate; φ'' = pull cos φ."""
    state, h, out = np.array([slope, 0.0]), 1e-4, []

    def rate(y):
        return np.array([y[1], pull * math.cos(y[0])])

    now = 0.0
    for t in times:
        while now < t - 0.5 * h:
            a = rate(state)
            b = rate(state + 0.5 * h * a)
            c = rate(state + 0.5 * h * b)
            state = state + h / 6.0 * (a + 2.0 * b + 2.0 * c + rate(state + h * c))
            now += h
        out.append(state)
    return np.array(out).T


@every_engine
def test_hinged_rod_swings_as_a_physical_pendulum(engine):
    rod = Body("rod", Box((1.0, 0.1, 0.1)), 1.0, (0.5, 0.0, 0.0), inertia=(0.02, 0.03, 0.04))
    scene = Scene((POST, rod), (Hinge("post", "rod"), Gravity(), Rotation()))
    possible(engine, scene)
    motion = drive(engine, scene, 1.0, samples=11)
    angle, rate = pendulum(motion.t, pull=0.5 * G / (0.25 + 0.03))
    place = 0.5 * np.stack([np.cos(angle), 0.0 * angle, -np.sin(angle)], axis=1)
    # first order: half a step of the top speed, 2.1 m/s (RK4: 1e-10)
    bound = 1e-9 if engine.name == "mujoco" else 1.5e-3
    assert np.linalg.norm(motion.x[:, 1] - place, axis=1).max() < bound
    assert np.abs(motion.w[:, 1, 1] - rate).max() < 3.0 * bound


@every_engine
def test_rod_keeps_its_length(engine):
    scene = Scene((POST, Body("bob", Sphere(0.1), 1.0, (1.0, 0.0, 0.0))), (Rod("post", "bob"), Gravity()))
    possible(engine, scene)
    motion = drive(engine, scene, 1.0, samples=21)
    # a step moves the bob along the tangent: (v dt)^2 / 2 = 1e-5 m at 4.4 m/s
    assert np.abs(np.linalg.norm(motion.x[:, 1], axis=1) - 1.0).max() < 1.1e-5
    angle, _ = pendulum(motion.t)
    place = np.stack([np.cos(angle), 0.0 * angle, -np.sin(angle)], axis=1)
    assert np.linalg.norm(motion.x[:, 1] - place, axis=1).max() < 0.5 * 4.43 * 1e-3 * 1.1


@every_engine
@pytest.mark.parametrize("e", [0.0, 0.5])
def test_tether_goes_taut_with_its_restitution(engine, e):
    bob = Body("bob", Sphere(0.1), 1.0, (0.0, 0.0, -0.5), velocity=(0.0, 0.0, -1.0))
    scene = Scene((POST, bob), (Tether("post", "bob", 1.0, e),))
    possible(engine, scene)
    motion = drive(engine, scene, 0.8, samples=17)
    # MuJoCo undoes 1 % of the stretch per step, which is up to v dt deep: 1 % of the speed
    assert motion.v[-1, 1, 2] == pytest.approx(e, abs=1e-2)
    assert -motion.x[:, 1, 2].min() < 1.0 + 1.1e-3


@every_engine
def test_contact_forces_on_an_incline_balance_weight(engine):
    slope = math.atan(0.4)
    q = about((0.0, 1.0, 0.0), slope)
    up = rotate(q, np.array([0.0, 0.0, 1.0]))
    block = Body("block", Box((0.2, 0.2, 0.2)), 3.0, tuple(0.1 * up), tuple(q))
    plane = Body("plane", HalfSpace(tuple(up)))
    contacts = run(engine, Scene((plane, block), (Gravity(), Friction(0.5), Resting())), (0.0, 1.0)).contacts
    total = np.zeros(3)
    for contact in contacts:
        side = 1.0 if contact.a == "block" else -1.0
        assert {contact.a, contact.b} == {"block", "plane"}
        assert side * np.array(contact.normal) == pytest.approx(up, abs=1e-9)
        assert side * np.dot(contact.force, up) > 0.0
        total += side * np.array(contact.force)
    # MuJoCo's friction creeps, and gains the last 1e-5 of its force for ever
    assert total == pytest.approx([0.0, 0.0, 3.0 * G], abs=1e-3)
