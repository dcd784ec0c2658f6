"""Free flight: parabolas exactly, tumbling to the conditioning of the start, loads to high order."""

import math
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mechanics.effects import Drag, Effect, Force, Gravity, Rotation
from mechanics.rotation import about, angle_between, matrix, normalised
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, Capsule, Mesh, Sphere
from reference_impl.errors import Unsupported
from reference_impl.simulate import advance, begin, simulate

TETRAHEDRON = Mesh(
    ((1.0, 1.0, 1.0), (1.0, -1.0, -1.0), (-1.0, 1.0, -1.0), (-1.0, -1.0, 1.0)),
    ((0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)),
)


def angular_momentum(body, q, w):
    r = matrix(q)
    return r @ body.inertia_tensor @ r.T @ w


def test_a_projectile_is_on_its_parabola():
    body = Body("b", TETRAHEDRON, 2.0, (1.0, 2.0, 3.0), velocity=(4.0, -5.0, 6.0))
    times = np.linspace(0.0, 10.0, 21)
    motion = simulate(Scene((body,), (Gravity(),)), times)
    fall = np.outer(-0.5 * 9.81 * times**2, (0.0, 0.0, 1.0))
    assert (
        np.abs(motion.x[:, 0] - (np.array(body.position) + np.outer(times, body.velocity) + fall)).max() < 1e-13 * 600
    )
    assert (motion.q == motion.q[0]).all()


def test_what_is_not_declared_does_not_act():
    body = Body("b", Capsule(0.1, 0.3), 1.0, velocity=(1.0, 0.0, 0.0))
    motion = simulate(Scene((body,)), (0.0, 1.0))
    assert motion.x[-1, 0].tolist() == [1.0, 0.0, 0.0]


def test_gazebo_box_tumbles_as_known_to_seventeen_digits():
    """Peters and Hsu's complex case (scpeters/benchmark); the numbers are Jacobi's solution at 40 digits.

    Near the separatrix a change of the angular momentum by 2e-16, its rounding, turns the attitude
    by 5e-11 within these 10 s: no computation in double precision can be asked for more.
    """
    body = Body("b", Box((0.1, 0.4, 0.9)), 10.0, velocity=(-2.0, 2.0, 8.0), angular_velocity=(0.1, 5.0, 0.1))
    motion = simulate(Scene((body,), (Gravity((0.0, 0.0, -9.8)), Rotation())), (0.0, 10.0))
    q = np.array((0.22516456341395816, -0.61992756249945249, -0.27702915068719459, 0.69874572364031014))
    w = np.array((2.6678188014706755, 4.9388371655813563, 0.19936455139903461))
    assert float(angle_between(motion.q[-1, 0], q)) < 1e-10
    assert np.abs(motion.w[-1, 0] - w).max() < 3e-10


spins = st.lists(st.floats(-20.0, 20.0), min_size=3, max_size=3)
sizes = st.lists(st.floats(0.05, 1.0), min_size=3, max_size=3)


@settings(max_examples=30, deadline=None)
@given(spins, sizes)
def test_a_free_body_keeps_its_energy_and_angular_momentum(w, size):
    body = Body("b", Box(tuple(size)), 2.0, orientation=tuple(about((1.0, 2.0, 3.0), 0.8)), angular_velocity=tuple(w))
    motion = simulate(Scene((body,), (Rotation(),)), (0.0, 0.3, 5.0))
    before = angular_momentum(body, motion.q[0, 0], motion.w[0, 0])
    after = angular_momentum(body, motion.q[-1, 0], motion.w[-1, 0])
    assert np.abs(after - before).max() <= 1e-13 * np.abs(before).max()
    # 1e-13 of the energy per hundred radians: rounding adds up over the segments
    assert motion.w[-1, 0] @ after == pytest.approx(motion.w[0, 0] @ before, rel=3e-13)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_spin_about_a_principal_axis_stays_there(axis):
    w = np.eye(3)[axis] * 7.0
    body = Body("b", Box((0.1, 0.2, 0.3)), 1.0, angular_velocity=tuple(w))
    motion = simulate(Scene((body,), (Rotation(),)), (0.0, 2.0))
    assert float(angle_between(motion.q[-1, 0], about(tuple(np.eye(3)[axis]), 14.0))) < 1e-14 * 20


def test_a_ball_turns_by_one_exponential_however_long():
    body = Body("b", Sphere(0.1), 1.0, angular_velocity=(3.0, -4.0, 12.0))
    motion = simulate(Scene((body,), (Rotation(),)), (0.0, 1000.0))
    exact = about((3.0, -4.0, 12.0), math.remainder(13.0 * 1000.0, 2.0 * math.pi))
    # the angle itself, 13 000 rad, is known to 1e-12
    assert float(angle_between(motion.q[-1, 0], exact)) < 1e-11


def test_sampling_does_not_change_the_flight():
    body = Body("b", Box((0.1, 0.2, 0.3)), 1.0, angular_velocity=(1.0, 2.0, 3.0))
    scene = Scene((body,), (Gravity(), Rotation()))
    often, once = simulate(scene, np.linspace(0.0, 2.0, 101)), simulate(scene, (0.0, 2.0))
    assert (often.q[-1] == once.q[-1]).all()
    assert np.abs(often.x[-1] - once.x[-1]).max() < 1e-14


def test_drag_slows_as_the_exponential():
    body = Body("b", Sphere(0.1), 2.0, velocity=(3.0, 0.0, 0.0), angular_velocity=(0.0, 0.0, 5.0))
    motion = simulate(Scene((body,), (Gravity(), Rotation(), Drag(0.6, 0.01))), (0.0, 4.0))
    k = 0.3
    decay = math.exp(-4.0 * k)
    assert motion.v[-1, 0, 0] == pytest.approx(3.0 * decay, rel=1e-14)
    assert motion.x[-1, 0, 0] == pytest.approx(3.0 / k * (1.0 - decay), rel=1e-14)
    assert motion.v[-1, 0, 2] == pytest.approx(-9.81 / k * (1.0 - decay), rel=1e-14)
    inertia = 0.4 * 2.0 * 0.01
    assert motion.w[-1, 0, 2] == pytest.approx(5.0 * math.exp(-0.01 / inertia * 4.0), rel=1e-12)


def test_a_force_acts_between_its_times_only():
    body = Body("b", Sphere(0.1), 2.0)
    motion = simulate(Scene((body,), (Force("b", (4.0, 0.0, 0.0), start=0.5, end=1.25),)), (0.0, 0.25, 2.0))
    assert motion.v[1, 0, 0] == 0.0
    assert motion.v[-1, 0, 0] == pytest.approx(1.5, rel=1e-15)
    assert motion.x[-1, 0, 0] == pytest.approx(0.5 * 2.0 * 0.75**2 + 1.5 * 0.75, rel=1e-14)


def test_an_offset_force_is_a_pendulum():
    """A constant force at a body point swings the body about its centre of mass as gravity swings a pendulum.

    Energy ½ I ω² - F·R p is conserved; the work is done in the frame of the centre of mass.
    """
    body = Body("b", Box((0.2, 0.3, 0.4)), 1.0, angular_velocity=(2.0, 1.0, -1.0))
    force, point = np.array((0.0, 0.3, -2.0)), np.array((0.1, 0.05, -0.2))
    motion = simulate(Scene((body,), (Rotation(), Force("b", tuple(force), point=tuple(point)))), (0.0, 1.0, 3.0))
    energy = [
        0.5 * motion.w[k, 0] @ angular_momentum(body, motion.q[k, 0], motion.w[k, 0])
        - force @ (matrix(motion.q[k, 0]) @ point)
        for k in range(3)
    ]
    assert energy == pytest.approx([energy[0]] * 3, rel=1e-12)


def test_a_constant_torque_adds_angular_momentum():
    body = Body("b", Box((0.2, 0.3, 0.4)), 1.0, angular_velocity=(2.0, 1.0, -1.0))
    torque = np.array((0.02, -0.01, 0.03))
    motion = simulate(Scene((body,), (Rotation(), Force("b", torque=tuple(torque)))), (0.0, 3.0))
    gained = angular_momentum(body, motion.q[-1, 0], motion.w[-1, 0]) - angular_momentum(
        body, motion.q[0, 0], motion.w[0, 0]
    )
    assert gained == pytest.approx(3.0 * torque, rel=1e-12)


@dataclass(frozen=True)
class Magnet(Effect):
    """An effect that no table lists."""


def test_what_has_no_part_is_refused_by_name():
    with pytest.raises(Unsupported, match="Magnet: not among Drag, "):
        begin(Scene((Body("a", Sphere(0.1), 1.0),), (Magnet(),)))


def test_advancing_in_any_pieces_reaches_the_same_time():
    world = begin(Scene((Body("b", Sphere(0.1), 1.0),), (Gravity(),)))
    for piece in (0.1, 0.2, 0.3):
        advance(world, piece)
    assert world.t == 0.1 + 0.2 + 0.3
    assert world.state().x[0, 2] == pytest.approx(-0.5 * 9.81 * 0.36, rel=1e-14)


def test_unit_quaternions_stay_unit():
    body = Body("b", Box((0.1, 0.2, 0.3)), 1.0, orientation=tuple(normalised(np.array((1.0, 2.0, 3.0, 4.0)))),
                angular_velocity=(9.0, 2.0, 3.0))  # fmt: skip
    motion = simulate(Scene((body,), (Rotation(),)), np.linspace(0.0, 3.0, 31))
    assert np.abs(np.linalg.norm(motion.q, axis=2) - 1.0).max() < 1e-15 * 4
