"""Energy and momentum of motions that are known in closed form, and of motions with a defect of known size."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from comparisons import energy, momentum, predicted
from comparisons.conserved import conserved
from comparisons.energy import mean_square_error, mechanical_energy
from comparisons.momentum import angular_deviation, linear_deviation
from comparisons.moving import Moving
from mechanics.effects import Drag, Force, Gravity, Restitution, Rotation, Spring
from mechanics.rotation import exponential, product, rotate
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Sphere
from mechanics.trajectory import Trajectory

G = 9.81
T = np.linspace(0.0, 2.0, 201)
speeds = st.floats(-20.0, 20.0)
vectors = st.tuples(speeds, speeds, speeds)
seeds = st.integers(0, 2**32 - 1)
ROUNDING = 1e-13


FALLING = (Gravity(),)


def thrown(position, velocity, mass=2.0, effects=FALLING):
    body = Body("ball", Sphere(0.1), mass=mass, position=position, velocity=velocity)
    return Scene((body,), effects)


@given(vectors, vectors)
def test_a_parabola_keeps_energy_and_momentum(case_of, moved, values, position, velocity):
    scene = thrown(position, velocity)
    g = scene.gravity
    path = np.array(position) + np.outer(T, velocity) + 0.5 * np.outer(T**2, g)
    case = case_of(scene, moved(scene, T, x_ball=path, v_ball=np.array(velocity) + np.outer(T, g)))
    found = values(energy, case) | values(momentum, case)
    assert found["energy error"].value < ROUNDING
    assert found["energy kept"].value == pytest.approx(1.0, abs=ROUNDING)
    assert found["linear momentum error"].value < ROUNDING


@pytest.mark.parametrize("first", ["velocity", "position"])
@given(v0=speeds, h=st.sampled_from([1e-2, 1e-3]))
def test_synchronised_energy_of_a_stepped_fall_is_constant(case_of, moved, values, first, v0, h):
    """Kick then drift leads by h/2, drift then kick lags by as much; raw energy then errs by m g h |v - v0|/2."""
    n = np.arange(round(1.0 / h) + 1)
    v = v0 - G * h * n
    z = 100.0 + h * np.concatenate([[0.0], np.cumsum(v[1:] if first == "velocity" else v[:-1])])
    lead = 0.5 * h if first == "velocity" else -0.5 * h
    scene = thrown((0.0, 0.0, 100.0), (0.0, 0.0, v0))
    zero = np.zeros_like(z)
    motion = moved(scene, h * n, x_ball=np.stack([zero, zero, z], 1), v_ball=np.stack([zero, zero, v], 1))
    found = values(energy, case_of(scene, motion, lead=lead))
    assert found["energy error, synchronised"].value < ROUNDING
    raw = mechanical_energy(scene, motion)
    assert raw - raw[0] == pytest.approx(2.0 * G * lead * (v0 - v) * -1.0, abs=1e-9 * abs(raw).max())
    assert found["energy error"].value > 1e3 * ROUNDING
    textbook = values(predicted, case_of(scene, motion, lead=lead))["predicted position error"].value
    exact = 100.0 + v0 * h * n - 0.5 * G * (h * n) ** 2
    assert textbook == pytest.approx(np.abs(z - exact).max(), rel=1e-9)


def test_harmonic_motion_under_a_constant_force(case_of, moved, values):
    """A spring to a fixed post, pulled by a constant force: x = x₀ + A cos ωt about the displaced rest."""
    k, m, force, amplitude = 50.0, 2.0, 3.0, 0.3
    post = Body("post", Sphere(0.05))
    ball = Body("ball", Sphere(0.05), mass=m, position=(1.0 + force / k + amplitude, 0.0, 0.0))
    scene = Scene((post, ball), (Spring("post", "ball", k, 1.0), Force("ball", (force, 0.0, 0.0))))
    w = np.sqrt(k / m)
    x = 1.0 + force / k + amplitude * np.cos(w * T)
    zero = np.zeros_like(x)
    motion = moved(
        scene, T, x_ball=np.stack([x, zero, zero], 1), v_ball=np.stack([-amplitude * w * np.sin(w * T), zero, zero], 1)
    )
    found = values(energy, case_of(scene, motion))
    assert found["energy error"].value < ROUNDING
    stepped = Trajectory(motion.t, motion.x + 1e-3 * motion.v, motion.q, motion.v, motion.w)
    late = values(energy, case_of(scene, stepped, lead=1e-3))
    assert late["energy error, synchronised"].value < ROUNDING < late["energy error"].value


def tumbler(rng, velocity=(0.0, 0.0, 0.0)):
    q = rng.normal(size=4)
    spin = tuple(rng.normal(size=3))
    body = Body("box", Box((0.1, 0.4, 0.9)), 10.0, (0.0, 0.0, 0.0), tuple(q), velocity, spin)
    return Scene((body,), (Rotation(),))


@given(seeds)
def test_energy_and_angular_momentum_of_a_turned_world(seed):
    """What a free body has does not depend on how the world is turned; L turns with it."""
    rng = np.random.default_rng(seed)
    scene = tumbler(rng, tuple(rng.normal(size=3)))
    start, turn = scene.start(), exponential(rng.normal(size=3))
    turned = [rotate(turn, getattr(start, name)) for name in ("x", "v", "w")]
    plain = Trajectory.of([start])
    other = Trajectory(plain.t, turned[0][None], product(turn, start.q)[None], turned[1][None], turned[2][None])
    first, second = Moving.of(scene, plain), Moving.of(scene, other)
    assert second.kinetic == pytest.approx(first.kinetic, rel=1e-13)
    assert second.spin == pytest.approx(rotate(turn, first.spin), abs=1e-12)


@given(seeds, vectors)
def test_boosts_leave_momentum_errors_alone(seed, boost):
    """Seen from a moving frame, free bodies deviate from conservation by the same momenta."""
    rng = np.random.default_rng(seed)
    scene = Scene(
        tuple(Body(f"b{i}", Box((0.3, 0.2, 0.4)), 1.0 + i, tuple(rng.normal(size=3))) for i in range(3)), (Rotation(),)
    )
    shape = (len(T), 3, 3)
    q = np.repeat(scene.start().q[None], len(T), axis=0)
    x, v, w = (rng.normal(size=shape) for _ in range(3))
    plain = Moving(scene, T, x, q, v, w)
    boosted = Moving(scene, T, x + np.multiply.outer(T, np.array(boost))[:, None], q, v + np.array(boost), w)
    kept = conserved(scene)
    for deviation in (linear_deviation, angular_deviation):
        assert deviation(boosted, kept) == pytest.approx(deviation(plain, kept), abs=1e-10)


def test_two_per_cent_of_energy_stolen_are_found(case_of, moved, values):
    scene = thrown((0.0, 0.0, 0.0), (3.0, 0.0, 0.0), effects=())
    v = np.outer(np.where(T > 1.0, 3.0 * np.sqrt(0.98), 3.0), [1.0, 0.0, 0.0])
    found = values(energy, case_of(scene, moved(scene, T, v_ball=v)))
    assert found["energy error"].value == pytest.approx(0.02, abs=1e-12)
    assert found["energy error"].time == pytest.approx(1.01)
    assert found["energy kept"].value == pytest.approx(0.98, abs=1e-12)


def test_a_rise_is_measured_from_the_lowest_energy_before_it(case_of, moved, values):
    """Drag may only take: down to a half, up by 5 % of the start, down again."""
    scene = thrown((0.0, 0.0, 0.0), (2.0, 0.0, 0.0), effects=(Drag(linear=0.1),))
    level = np.where(T < 0.5, 1.0, np.where(T < 1.0, 0.5, np.where(T < 1.5, 0.55, 0.2)))
    found = values(energy, case_of(scene, moved(scene, T, v_ball=np.outer(2.0 * np.sqrt(level), [1.0, 0.0, 0.0]))))
    assert found["energy rise"].value == pytest.approx(0.05, abs=1e-12)
    assert found["energy rise"].time == pytest.approx(1.0)
    assert "energy error" not in found


@given(seeds)
def test_a_rise_is_never_negative_and_never_more_than_the_error(case_of, seed):
    rng = np.random.default_rng(seed)
    scene = thrown((0.0, 0.0, 1.0), (1.0, 0.0, 0.0), effects=(Gravity(), Drag(linear=0.1)))
    shape = (30, 1, 3)
    q = np.repeat(scene.start().q[None], 30, axis=0)
    motion = Trajectory(np.arange(30.0), rng.normal(size=shape), q, rng.normal(size=shape), np.zeros(shape))
    found = {x.name: x.value for x in energy.measure(case_of(scene, motion, lead=rng.normal()))}
    assert found["energy rise"] >= 0.0
    assert found["energy rise, synchronised"] >= 0.0


def test_a_blow_up_does_not_enlarge_its_own_scale(case_of, moved, values):
    scene = thrown((0.0, 0.0, 5.0), (0.0, 0.0, 0.0))
    z = np.where(T > 1.0, 1e4, 5.0)
    motion = moved(scene, T, x_ball=np.outer(z, [0.0, 0.0, 1.0]))
    assert values(energy, case_of(scene, motion))["energy error"].value > 1e4


def test_bodies_at_rest_are_not_measured_against_nothing(case_of, moved, values):
    """A box that creeps by 1e-9 m/s on a smooth floor has made no error of order one."""
    scene = Scene(
        (Body("floor", HalfSpace()), Body("box", Box((1.0, 1.0, 1.0)), 3.0, (0.0, 0.0, 0.5))),
        (Gravity(), Rotation(), Restitution(1.0)),
    )
    creep = np.where(T > 0.0, 1e-9, 0.0)
    motion = moved(scene, T, v_box=np.outer(creep, [1.0, 0.0, 0.0]), w_box=np.outer(creep, [0.0, 0.0, 1.0]))
    found = values(momentum, case_of(scene, motion)) | values(energy, case_of(scene, motion))
    for name in ("linear momentum error", "angular momentum error", "energy error"):
        assert 0.0 <= found[name].value < 1e-8
    still = values(energy, case_of(scene, moved(scene, T))) | values(momentum, case_of(scene, moved(scene, T)))
    assert all(found.value == 0.0 for name, found in still.items() if name.endswith("error"))


def test_nothing_at_all_is_no_division_by_zero(case_of, moved, values):
    scene = Scene((Body("ball", Sphere(1.0), mass=1.0),), (Rotation(),))
    still = case_of(scene, moved(scene, T))
    assert all(q.value == 0.0 for q in momentum.measure(still))
    assert values(energy, still)["energy error"].value == 0.0
    pushed = case_of(scene, moved(scene, T, v_ball=np.outer(T, [1.0, 0.0, 0.0])))
    assert values(energy, pushed)["energy error"].value == 1.0
    assert values(momentum, pushed)["linear momentum error"].value == 1.0


def test_simbenchmarks_error_leaves_the_last_sample_out():
    assert mean_square_error(np.array([10.0, 12.0, 9.0, 1e9])) == pytest.approx((0.0 + 4.0 + 1.0) / 3.0)
    assert mean_square_error(np.array([10.0])) == 0.0


def test_gazebos_errors_are_relative_to_what_there_was_at_the_start(case_of, moved, values):
    """E(0) = m v²/2 + ω·I ω/2 with the potential 0 at the world's origin, as the benchmark's 368.546 J."""
    box = Body("box", Box((0.1, 0.4, 0.9)), 10.0, velocity=(-2.0, 2.0, 8.0), angular_velocity=(0.1, 5.0, 0.1))
    scene = Scene((box,), (Gravity((0.0, 0.0, -9.8)), Rotation()))
    names = ("relative energy error", "relative angular momentum error")
    motion = moved(scene, T)
    assert mechanical_energy(scene, motion)[0] == pytest.approx(368.5464125, rel=1e-7)
    assert np.linalg.norm(Moving.of(scene, motion).spin[0].sum(axis=0)) == pytest.approx(3.41765, rel=1e-5)
    stuck = values(energy, case_of(scene, moved(scene, T, w_box=0.0), *names)) | values(
        momentum, case_of(scene, moved(scene, T, w_box=np.outer(1.0 + 0.01 * T, box.angular_velocity)), *names)
    )
    assert stuck["relative angular momentum error"].value == pytest.approx(0.02, rel=1e-9)


def test_what_is_not_conserved_is_only_spoken_of_when_asked(case_of, moved, values):
    scene = thrown((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), effects=(Force("ball", (1.0, 0.0, 0.0), end=0.5), Drag(0.1)))
    motion = moved(scene, T)
    assert values(energy, case_of(scene, motion)) == {}
    found = values(energy, case_of(scene, motion, "energy error"))["energy error"]
    assert np.isnan(found.value)
    assert "switched" in found.text
    found = values(momentum, case_of(scene, motion, "linear momentum error"))["linear momentum error"]
    assert np.isnan(found.value)
    assert "drag" in found.text
