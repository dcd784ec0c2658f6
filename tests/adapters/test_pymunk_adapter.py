"""What is particular to the pymunk adapter."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from adapters.engine import Refusal, checked_settings
from adapters.pymunk import ENGINES
from adapters.run import run
from mechanics.effects import (
    Drag,
    Force,
    Friction,
    Gravity,
    Hinge,
    Resting,
    Restitution,
    Rod,
    Rotation,
    Spring,
    Tether,
)
from mechanics.rotation import about, angle_between, product, rotate
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, Capsule, Cylinder, HalfSpace, Mesh, Sphere
from mechanics.trajectory import Trajectory

pytest.importorskip("pymunk")
FAIR, STOCK = ENGINES["pymunk"], ENGINES["pymunk:stock"]
FLOOR = Body("floor", HalfSpace())
POST = Body("post", Sphere(0.02))
TETRAHEDRON = Mesh(
    ((0.1, 0.1, 0.1), (0.1, -0.1, -0.1), (-0.1, 0.1, -0.1), (-0.1, -0.1, 0.1)),
    ((0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)),
)


def drive(engine, scene, duration, dt=1e-3, samples=2, **knobs):
    outcome = run(engine, scene, np.linspace(0.0, duration, samples), {"dt": dt, **knobs}).outcome
    assert isinstance(outcome, Trajectory), outcome
    return outcome


def ball(name="b", **given):
    return Body(name, Sphere(0.1), 1.0, **given)


@pytest.mark.parametrize(
    ("scene", "reason"),
    [
        (Scene((ball(velocity=(0.0, 1.0, 0.0)),)), "not in the x-z plane"),
        (Scene((ball(), ball("c", position=(1.0, 0.5, 0.0)))), "others at"),
        (Scene((ball(angular_velocity=(1.0, 0.0, 0.0)),), (Rotation(),)), "not along y"),
        (Scene((ball(),), (Gravity((0.0, 1.0, 0.0)),)), "Gravity"),
        (Scene((Body("b", TETRAHEDRON, 1.0),)), "mesh 'b'"),
        (Scene((ball(inertia=((1.0, 0.3, 0.0), (0.3, 1.0, 0.0), (0.0, 0.0, 1.0))),), (Rotation(),)), "principal axis"),
        (Scene((POST, ball()), (Hinge("post", "b"),)), "may not turn"),
        (Scene((POST, ball()), (Tether("post", "b", 1.0, 0.5),)), "without rebound"),
        (Scene((POST, ball()), (Rod("post", "b"),)), "no length"),
        (Scene((Body("wall", Box((1, 1, 1)), position=(0, 2, 0)), ball()), (Restitution(1.0),)), "fixed body 'wall'"),
    ],
)
def test_what_is_not_planar_is_refused_with_the_reason(scene, reason):
    outcome = run(FAIR, scene, (0.0, 0.1)).outcome
    assert isinstance(outcome, Refusal)
    assert reason in outcome.reason


@given(st.floats(-3.0, 3.0), st.floats(-5.0, 5.0))
def test_positive_rotation_about_y_carries_z_towards_x(tilt, rate):
    box = Body("box", Box((0.2, 0.3, 0.4)), 1.0, orientation=tuple(about((0.0, 1.0, 0.0), tilt)),
               angular_velocity=(0.0, rate, 0.0))  # fmt: skip
    motion = drive(FAIR, Scene((box,), (Rotation(),)), 0.1, 1e-2)
    assert angle_between(motion.q[-1, 0], about((0.0, 1.0, 0.0), tilt + 0.1 * rate)) < 1e-12
    assert motion.w[-1, 0] == pytest.approx([0.0, rate, 0.0], abs=1e-12)
    assert rotate(about((0.0, 1.0, 0.0), 0.1), np.array([0.0, 0.0, 1.0]))[0] > 0.0


def test_sphere_keeps_whatever_attitude_it_was_given():
    q = about((1.0, 2.0, 3.0), 0.9)
    motion = drive(FAIR, Scene((ball(orientation=tuple(q), angular_velocity=(0.0, 2.0, 0.0)),), (Rotation(),)), 0.5)
    assert angle_between(motion.q[-1, 0], product(about((0.0, 1.0, 0.0), 1.0), q)) < 1e-12


def test_torque_turns_the_way_the_scene_says_with_the_moment_about_y():
    body = ball(inertia=(0.3, 0.2, 0.3))
    motion = drive(FAIR, Scene((body,), (Force("b", torque=(0.0, 0.1, 0.0)), Rotation())), 0.5)
    assert motion.w[-1, 0] == pytest.approx([0.0, 0.25, 0.0], abs=1e-12)


def test_stock_ball_is_a_disc():
    rolling = Scene(
        (FLOOR, ball(position=(0.0, 0.0, 0.1), velocity=(2.0, 0.0, 0.0))),
        (Gravity(), Rotation(), Friction(0.3), Resting()),
    )
    assert drive(FAIR, rolling, 1.0).v[-1, 1, 0] == pytest.approx(2.0 * 5.0 / 7.0, rel=1e-9)
    assert drive(STOCK, rolling, 1.0).v[-1, 1, 0] == pytest.approx(2.0 * 2.0 / 3.0, rel=1e-6)


@pytest.mark.parametrize(
    ("shape", "height"), [(Sphere(0.1), 0.1), (Box((0.2, 0.3, 0.4)), 0.2), (Capsule(0.1, 0.3), 0.25),
                          (Cylinder(0.1, 0.2), 0.1)]
)  # fmt: skip
def test_shapes_rest_on_a_tilted_floor_at_their_own_height(shape, height):
    q = about((0.0, 1.0, 0.0), -0.4)
    up = rotate(q, np.array([0.0, 0.0, 1.0]))
    # the plane's own frame is turned as well, so that its normal passes two rotations
    turned = about((0.0, 1.0, 0.0), 0.3)
    floor = Body("floor", HalfSpace(tuple(rotate(about((0.0, 1.0, 0.0), -0.7), np.array([0.0, 0.0, 1.0])))),
                 position=(0.5, 0.0, -0.3), orientation=tuple(turned))  # fmt: skip
    body = Body("b", shape, 1.0, tuple(np.array(floor.position) + height * up), tuple(q))
    motion = drive(FAIR, Scene((floor, body), (Gravity(tuple(-9.81 * up)), Resting())), 0.5)
    assert motion.x[-1, 1] == pytest.approx(np.array(body.position), abs=2e-5)


def test_every_pair_gets_its_own_coefficients_where_no_product_could_give_them():
    balls = (ball("a", position=(0.0, 0.0, 0.153), velocity=(0.0, 0.0, -1.0)),
             ball("b", position=(1.0, 0.0, 0.153), velocity=(0.0, 0.0, -1.0)),
             ball("c", position=(3.0, 0.0, 1.0), velocity=(1.0, 0.0, 0.0)),
             ball("d", position=(3.2333, 0.0, 1.0)))  # fmt: skip
    effect = Restitution(0.5, {("a", "floor"): 0.9, ("b", "floor"): 0.0, ("c", "d"): 1.0})
    motion = drive(FAIR, Scene((FLOOR, *balls), (effect,)), 0.12)
    assert motion.v[-1, 1:3, 2] == pytest.approx([0.9, 0.0], abs=1e-12)
    assert motion.v[-1, 3:, 0] == pytest.approx([0.0, 1.0], abs=1e-12)


def test_a_conveyor_takes_a_block_along():
    belt = Body("belt", Box((20.0, 1.0, 0.2)), position=(0.0, 0.0, -0.1), velocity=(1.5, 0.0, 0.0))
    block = Body("block", Box((0.2, 0.2, 0.2)), 1.0, (0.0, 0.0, 0.1))
    motion = drive(FAIR, Scene((belt, block), (Gravity(), Friction(0.5), Resting())), 1.0, samples=11)
    catching_up = 1.5 / (0.5 * 9.81)
    assert motion.v[-1, 1] == pytest.approx([1.5, 0.0, 0.0], abs=1e-9)
    slipped = motion.x[-1, 0, 0] - motion.x[-1, 1, 0]
    assert slipped == pytest.approx(0.5 * 1.5 * catching_up, abs=0.5 * 1.5 * 1e-3 * 1.1)
    assert motion.x[:, 0, 0] == pytest.approx(1.5 * motion.t, abs=1e-12)


def test_a_piston_that_accelerates_is_where_it_should_be_and_lifts_what_lies_on_it():
    piston = Body("piston", Box((1.0, 1.0, 0.2)), position=(0.0, 0.0, -0.1), velocity=(0.0, 0.0, 0.1),
                  acceleration=(0.0, 0.0, 2.0))  # fmt: skip
    block = Body("block", Box((0.2, 0.2, 0.2)), 1.0, (0.0, 0.0, 0.1), velocity=(0.0, 0.0, 0.1))
    motion = drive(FAIR, Scene((piston, block), (Gravity(), Friction(0.5), Resting())), 1.0, samples=11)
    assert motion.x[:, 0, 2] == pytest.approx(-0.1 + 0.1 * motion.t + motion.t**2, abs=1e-12)
    assert motion.v[:, 0, 2] == pytest.approx(0.1 + 2.0 * motion.t, abs=1e-12)
    # each step the piston gains a dt^2 on the block, and pymunk undoes 1 - 0.9^(60 dt) of the overlap
    overlap = 2.0 * 1e-6 / (1.0 - 0.9**0.06)
    assert motion.x[-1, 1, 2] - motion.x[-1, 0, 2] == pytest.approx(0.2 - overlap, abs=2e-6)


def test_fixed_and_moving_fixed_bodies_pass_through_each_other():
    sled = Body("sled", Box((1.0, 1.0, 1.0)), velocity=(1.0, 0.0, 0.0))
    motion = drive(FAIR, Scene((sled, Body("wall", Box((1.0, 1.0, 1.0)), position=(1.2, 0.0, 0.0)), ball(
        position=(0.0, 0.0, 9.0))), (Restitution(0.5),)), 1.0)  # fmt: skip
    assert motion.x[-1, 0, 0] == pytest.approx(1.0, abs=1e-12)


def test_position_lags_by_half_a_substep():
    scene = Scene((ball(),), (Gravity(),))
    result = run(FAIR, scene, (0.0, 1.0), {"dt": 1e-2, "substeps": 4})
    assert result.lead == pytest.approx(-1.25e-3)
    assert result.trajectory.x[-1, 0, 2] == pytest.approx(-0.5 * 9.81 - 9.81 * result.lead, rel=1e-12)


def test_pushes_are_applied_in_every_substep():
    scene = Scene((ball(velocity=(1.0, 0.0, 0.0)),), (Drag(0.5),))
    errors = [abs(drive(FAIR, scene, 1.0, 1e-2, substeps=n).v[-1, 0, 0] - math.exp(-0.5)) for n in (1, 4)]
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.02)


def test_a_stack_stands_and_the_stock_profile_lets_it_shift():
    boxes = tuple(Body(f"b{i}", Box((0.5, 0.5, 0.5)), 1.0, (0.0, 0.0, 0.25 + 0.5 * i)) for i in range(5))
    scene = Scene((FLOOR, *boxes), (Gravity(), Rotation(), Friction(0.5), Resting()))
    drift = []
    for engine in (FAIR, STOCK):
        motion = drive(engine, scene, 3.0, **engine.defaults)
        drift.append(np.abs(motion.x[-1] - motion.x[0]).max())
    assert drift[0] < 3e-4
    assert drift[1] > 3e-3


def hinged_bars(count):
    """Bars of 1 kg in a row from a fixed post, hinged to each other, held out level."""
    bars = tuple(Body(f"bar{i}", Box((1.0, 0.1, 0.1)), 1.0, (0.5 + i, 0.0, 0.0)) for i in range(count))
    names = ["post", *(bar.name for bar in bars)]
    hinges = [Hinge(a, b, (float(i), 0.0, 0.0)) for i, (a, b) in enumerate(pairwise(names))]
    return Scene((POST, *bars), (*hinges, Gravity(), Rotation()))


def energy_error(scene, dt):
    """Greatest change of the energy within a second, after the first sample [J]."""
    result = run(FAIR, scene, np.linspace(0.0, 1.0, 21), {"dt": dt})
    motion = result.trajectory
    height = motion.x[:, 1:, 2] - result.lead * motion.v[:, 1:, 2]
    inertia = scene.bodies[1].inertia_tensor[1, 1]
    energy = (0.5 * (motion.v[:, 1:] ** 2).sum(-1) + 0.5 * inertia * motion.w[:, 1:, 1] ** 2 + 9.81 * height).sum(-1)
    # at the start positions and velocities still belong to one time
    return np.abs(energy[1:] - energy[1]).max()


def test_a_joint_alone_keeps_the_energy_to_second_order():
    one, half = (energy_error(hinged_bars(1), dt) for dt in (1e-3, 5e-4))
    # in each step a chord is taken for an arc and put right: 9.81 m/s2 times (spin dt)^2, some 5 rad/s
    assert one < 9.81 * (5.0 * 1e-3) ** 2
    assert one / half == pytest.approx(4.0, rel=0.1)


def test_joints_that_share_a_body_keep_it_to_first_order():
    one, half = (energy_error(hinged_bars(2), dt) for dt in (1e-3, 5e-4))
    assert one < 0.01 * 9.81
    assert one / half == pytest.approx(2.0, rel=0.1)


@pytest.mark.parametrize("links", [2, 10])
def test_a_chain_holds_a_thousand_times_the_weight_of_a_link(links):
    bars = tuple(Body(f"bar{i}", Box((0.1, 0.1, 1.0)), 1.0, (0.0, 0.0, -0.5 - i)) for i in range(links))
    load = Body("load", Sphere(0.2), 1000.0, (0.0, 0.0, -float(links)))
    names = ["post", *(bar.name for bar in bars), "load"]
    hinges = [Hinge(a, b, (0.0, 0.0, -float(i))) for i, (a, b) in enumerate(pairwise(names))]
    motion = drive(FAIR, Scene((POST, *bars, load), (*hinges, Gravity(), Rotation())), 2.0, samples=21)
    # it sags while the impulses are found, step by step, and the correction takes that back: half is left after 0.1 s
    assert np.abs(motion.x - motion.x[0]).max() < 1e-3
    assert motion.x[-1] == pytest.approx(motion.x[0], abs=1e-5)


def test_two_bodies_on_a_spring_swing_about_their_centre_of_mass():
    a, b = ball("a"), Body("b", Sphere(0.1), 3.0, (1.2, 0.0, 0.0))
    motion = drive(FAIR, Scene((a, b), (Spring("a", "b", 48.0, 1.0),)), 1.0, 1e-4, samples=11)
    # reduced mass 3/4 kg: 8 rad/s
    expected = 1.0 + 0.2 * np.cos(8.0 * motion.t)
    assert motion.x[:, 1, 0] - motion.x[:, 0, 0] == pytest.approx(expected, abs=0.2 * 8.0 * 0.5e-4 * 1.1)


@pytest.mark.parametrize("engine", [FAIR, STOCK], ids=lambda engine: engine.name)
def test_every_departure_from_the_defaults_has_a_reason(engine):
    assert checked_settings(engine, None) == dict(engine.defaults)
    assert engine.version
    assert all(len(reason) > 10 for reason in engine.profile.values())
    assert bool(engine.profile) == (engine is FAIR)
