"""Bodies on joints that meet others, or rest."""

import math

import numpy as np
import pytest
from pendulums import PIVOT, UP, G, bob, down
from scipy.special import ellipk

from mechanics.effects import Gravity, Hinge, Resting, Restitution, Rod, Rotation
from mechanics.rotation import about, rotate
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Sphere
from reference_impl.reactions import joint_forces
from reference_impl.simulate import advance, begin, simulate
from reference_impl.world import HELD, STILL


def test_a_struck_rod_and_its_centre_of_percussion():
    """A ball hits a hanging rod at x below its hinge; at 2 l / 3 the hinge feels nothing (E11 of any book)."""
    length, m, mass, speed = 1.2, 3.0, 0.2, 10.0
    for x, e in ((0.9, 0.5), (0.9, 0.0), (0.8, 0.5)):
        body = Body("rod", Box((0.02, 0.02, length)), m, (0.0, 0.0, -0.5 * length),
                    inertia=(m * length**2 / 12, m * length**2 / 12, 1e-3))  # fmt: skip
        ball = bob("ball", (-0.11, 0.0, -x), (speed, 0.0, 0.0), mass)
        scene = Scene((PIVOT, body, ball), (Rotation(), Restitution(e), Resting(), Hinge("rod", "pivot")))
        world = begin(scene)
        advance(world, 0.005 + 1e-11)
        i = m * length**2 / 3.0
        spin = (1.0 + e) * mass * speed * x / (i + mass * x * x)
        assert len(world.events) == 1
        assert world.events[0].time == pytest.approx(0.005, rel=1e-13)
        assert world.events[0].impulse == pytest.approx(i * spin / x, rel=1e-13)
        state = world.state()
        assert -state.w[1, 1] == pytest.approx(spin, rel=1e-12)
        assert state.v[2, 0] == pytest.approx(speed - i * spin / (mass * x), rel=1e-12)
        assert np.linalg.norm(state.v[1] - np.cross(state.w[1], state.x[1])) <= 1e-13


def test_a_pendulum_bounces_off_a_wall():
    """From rest at 60 degrees it meets a wall where it hangs, and again at e times the speed."""
    amplitude, e = math.radians(60.0), 0.7
    wall = Body("wall", HalfSpace((1.0, 0.0, 0.0)), position=(-0.05, 0.0, 0.0))
    scene = Scene((PIVOT, wall, bob("bob", down(amplitude))), (Gravity(), Restitution(e), Rod("pivot", "bob")))
    world = begin(scene)

    def quarter(angle):
        return float(ellipk(math.sin(0.5 * angle) ** 2)) / math.sqrt(G)

    advance(world, 3.0)
    time = quarter(amplitude)
    speed = 2.0 * math.sqrt(G) * math.sin(0.5 * amplitude)
    for event in world.events[:3]:
        assert event.time == pytest.approx(time, abs=1e-11)
        assert event.impulse == pytest.approx((1.0 + e) * speed, rel=1e-11)
        speed *= e
        time += 2.0 * quarter(2.0 * math.asin(speed / (2.0 * math.sqrt(G))))
    assert world.audit.energy_rise <= 1e-14


def test_a_door_meets_a_stop():
    """A door on a vertical hinge turns evenly and strikes a fixed ball: Newton's law at its edge, e ω back."""
    e, spin = 0.6, 2.0
    door = Body("door", Box((0.9, 0.04, 2.0)), 20.0, (0.45, 0.0, 1.0), velocity=(0.0, 0.45 * spin, 0.0),
                angular_velocity=(0.0, 0.0, spin))  # fmt: skip
    stop = Body("stop", Sphere(0.05), None, (0.0, 0.8, 1.0))
    scene = Scene((PIVOT, door, stop), (Gravity(), Rotation(), Restitution(e), Hinge("pivot", "door", axis=UP)))
    world = begin(scene)
    advance(world, 1.0)
    # the face, 0.02 m off the hinge's plane, is 0.05 m from the ball's centre when 0.8 cos θ = 0.07
    time = math.acos(0.07 / 0.8) / spin
    # ten steps of 1e-13 each in the quaternion, at 0.8 m: 1e-12 m or so
    assert [event.time for event in world.events] == pytest.approx([time], abs=1e-11)
    assert world.state().w[1] == pytest.approx((0.0, 0.0, -e * spin), abs=1e-11)
    turned = rotate(about(UP, spin * time - e * spin * (1.0 - time)), np.array((0.45, 0.0, 0.0)))
    assert world.state().x[1] == pytest.approx(turned + np.array((0.0, 0.0, 1.0)), abs=1e-11)
    (f,) = joint_forces(world)
    assert f.force[2] == pytest.approx(-20.0 * G, rel=1e-13)  # on the pivot


def test_a_hinged_bar_lies_on_its_other_end():
    """A bar on a hinge and on a ball under its far end: each carries half, and all of it rests."""
    bar = Body("bar", Box((1.0, 0.1, 0.1)), 2.0, (0.5, 0.0, 0.0))
    prop = Body("prop", Sphere(0.2), None, (1.0, 0.0, -0.25))
    scene = Scene((PIVOT, bar, prop), (Gravity(), Rotation(), Resting(), Hinge("bar", "pivot")))
    world = begin(scene)
    advance(world, 1.0)
    assert [h.force for h in world.forces] == [pytest.approx(G, rel=1e-13)]
    (f,) = joint_forces(world)
    assert np.array(f.force) == pytest.approx((0.0, 0.0, G), abs=1e-13)
    assert world.mode[1] == STILL
    assert (world.state().x[1] == (0.5, 0.0, 0.0)).all()


def test_what_hangs_at_rest_is_at_rest_until_it_is_hit():
    bobs = (bob("upper", (0.0, 0.0, -1.0)), bob("lower", (0.0, 0.0, -2.0)))
    ball = bob("ball", (-2.0, 0.0, -2.0), (2.0, 0.0, 4.905 * 0.95))
    effects = (Gravity(), Restitution(1.0), Rod("pivot", "upper"), Rod("upper", "lower"))
    world = begin(Scene((PIVOT, *bobs, ball), effects))
    advance(world, 0.5)
    assert (world.mode[1:3] == STILL).all()
    assert (world.state().x[1:3] == ((0.0, 0.0, -1.0), (0.0, 0.0, -2.0))).all()
    steps = world.audit.steps
    assert steps == 0
    advance(world, 0.46)
    assert world.events
    assert (world.mode[1:3] == HELD).all()
    assert world.state().v[2, 0] > 1.0
    assert world.audit.energy_rise <= 1e-14


def test_a_joint_keeps_what_flies_beside_it_apart():
    """A ball that has nothing to do with a pendulum flies on the same bits with and without it."""
    ball = bob("ball", (5.0, 0.0, 0.0), (1.0, 0.0, 3.0))
    floor = Body("floor", HalfSpace(), position=(0.0, 0.0, -3.0))
    effects = (Gravity(), Restitution(0.8))
    alone = simulate(Scene((floor, ball), effects), (0.0, 0.5, 2.0))
    scene = Scene((floor, ball, PIVOT, bob("bob", (1.0, 0.0, 0.0))), (*effects, Rod("pivot", "bob")))
    assert simulate(scene, (0.0, 0.5, 2.0)).x[:, 1] == pytest.approx(alone.x[:, 1], abs=1e-13)
