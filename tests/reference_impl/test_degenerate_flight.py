"""Free rotation against two oracles: elliptic functions in closed form, and a Taylor series in 48 digits.

`scenarios.free_rotation` computes the closed form (Jacobi's functions, Carlson's integrals) in double precision;
`taylor` below integrates Euler's equations and the quaternion equation in 48 digits and shares no formula with
either.  Where both exist they must agree first.
"""

import math
from fractions import Fraction

import numpy as np
import pytest

from mechanics.effects import Drag, Force, Gravity, Rotation
from mechanics.rotation import about, angle_between, matrix, normalised, product, rotate
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, Sphere
from reference_impl.simulate import advance, begin, simulate
from scenarios.free_rotation import free_rotation

ONE = (1.0, 0.0, 0.0, 0.0)
BITS = 160


def taylor(moments, q, w, end, order=32):
    """Attitude and world angular velocity (as floats) after `end` [s] of free rotation, by series in 48 digits.

    Whole numbers in units of 2^-160 stand for q and for the angle ω h turned in a step h, which is at most 1/4.
    """
    moments, spin = [Fraction(m) for m in moments], _turn([q[0], *(-c for c in q[1:])], w)
    ratios = [whole((moments[c - 2] - moments[c - 1]) / moments[c]) for c in range(3)]
    count = max(1, math.ceil(4.0 * float(max(abs(c) for c in spin)) * end))
    step = Fraction(end) / count
    a, b = [whole(c * step) for c in spin], [whole(c) for c in q]
    size = math.isqrt(sum(c * c for c in b))
    b = [(c << BITS) // size for c in b]
    for _ in range(count):
        turn, attitude = [a], [b]
        for k in range(order):
            turn.append(_euler(ratios, turn, k))
            attitude.append(_attitude(turn, attitude, k))
        a, b = ([sum(row[c] for row in rows) for c in range(len(rows[0]))] for rows in (turn, attitude))
    b = [Fraction(c, 1 << BITS) for c in b]
    found = _turn(b, [Fraction(c, 1 << BITS) / step for c in a])
    return np.array([float(c) for c in b]), np.array([float(c) for c in found])


def whole(value):
    """A number in units of 2^-160."""
    return round(Fraction(value) * (1 << BITS))


def _turn(q, v):
    """Vector v turned by the quaternion q of any length, in rational numbers."""
    (w, x, y, z), v = [Fraction(c) for c in q], [Fraction(c) for c in v]
    rows = ((w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)),
            (2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)),
            (2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z))  # fmt: skip
    square = w * w + x * x + y * y + z * z
    return [sum(r * c for r, c in zip(row, v, strict=True)) / square for row in rows]


def _euler(ratios, a, k):
    """Next coefficient of ω₁' = (I₂ - I₃) / I₁ ω₂ ω₃ and its cyclic companions."""
    out = []
    for c in range(3):
        total = sum(a[j][c - 2] * a[k - j][c - 1] for j in range(k + 1)) >> BITS
        out.append(((ratios[c] * total) >> BITS) // (k + 1))
    return out


def _attitude(a, b, k):
    """Next coefficient of q' = ½ q ω."""
    total = [0, 0, 0, 0]
    for j in range(k + 1):
        (s, x, y, z), (u, v, w) = b[j], a[k - j]
        total[0] -= x * u + y * v + z * w
        total[1] += s * u + y * w - z * v
        total[2] += s * v + z * u - x * w
        total[3] += s * w + x * v - y * u
    return [(t >> BITS) // (2 * (k + 1)) for t in total]


def tumbled(moments, q, w, end):
    """Attitude and angular velocity of the engine after `end` [s], and the relative drift of energy and momentum."""
    body = Body("b", Box((0.1, 0.1, 0.1)), 1.0, orientation=tuple(q), angular_velocity=tuple(w), inertia=tuple(moments))
    motion = simulate(Scene((body,), (Rotation(),)), (0.0, end))

    def kept(k):
        axes = matrix(motion.q[k, 0])
        momentum = axes @ (np.array(moments) * (axes.T @ motion.w[k, 0]))
        return momentum, motion.w[k, 0] @ momentum

    (before, energy), (after, later) = kept(0), kept(1)
    size = np.linalg.norm(before) or 1.0
    return motion.q[1, 0], motion.w[1, 0], np.abs(after - before).max() / size, abs(later / (energy or 1.0) - 1.0)


CASES = {
    "three moments": ((1.0, 2.0, 2.5), (2.0, 3.0, 4.0), 5.0),
    "three moments, other order": ((2.5, 1.0, 2.0), (-2.0, 0.5, 4.0), 5.0),
    "prolate": ((1.0, 2.0, 2.0), (3.0, 1.0, -2.0), 5.0),
    "oblate": ((1.0, 1.0, 1.8), (0.3, 0.0, 2.0), 5.0),
    "sphere": ((1.5, 1.5, 1.5), (1.0, -2.0, 3.0), 5.0),
    "flat plate": ((1.0, 2.0, 3.0), (2.0, 3.0, 4.0), 5.0),
    "first axis": ((1.0, 2.0, 2.5), (4.0, 0.0, 0.0), 5.0),
    "second axis": ((1.0, 2.0, 2.5), (0.0, 4.0, 0.0), 5.0),
    "third axis": ((1.0, 2.0, 2.5), (0.0, 0.0, 4.0), 5.0),
    "separatrix": ((2.25, 2.0, 1.0), (1.0, 1.0, 0.75), 5.0),
    "beside the separatrix": ((2.25, 2.0, 1.0), (1.0, 1.0 + 1e-9, 0.75), 5.0),
    "a trace off the second axis": ((1.0, 2.0, 3.0), (1e-9, 3.0, 1e-9), 5.0),
    "needle": ((1.0, 1.0, 1e-6), (1.0, -2.0, 300.0), 0.2),
    "moments spread by 1e12": ((1.0, 1.0, 1e-12), (0.5, 0.2, 3.0), 2.0),
    "fast": ((1.0, 2.0, 2.5), (6e3, 5e3, -6e3), 2e-3),
    "slow": ((1.0, 2.0, 2.5), (1e-8, 2e-8, -1e-8), 1e8),
}


@pytest.mark.parametrize("name", CASES)
def test_free_rotation_against_a_long_series(name):
    """Attitude to rounding times the angle turned; what is steep, by how steep it is."""
    moments, w, end = CASES[name]
    q = about((3.0, -1.0, 2.0), 0.9) if name != "separatrix" else np.array(ONE)
    exact, spin = taylor(moments, q, w, end)
    attitude, found, momentum, energy = tumbled(moments, q, w, end)
    assert momentum <= 1e-13
    assert energy <= 1e-13
    # the rounding of the start, 2e-16, grows as exp(λ t) where ω₂ is unstable, λ = ω₂ √((I₂-I₁)(I₃-I₂)/(I₁ I₃)) < 2
    turned = np.linalg.norm(w) * end
    steep = {"second axis": 5e3, "separatrix": 50.0, "beside the separatrix": 50.0, "a trace off the second axis": 5e3}
    tolerance = 1e-15 * (10.0 + 5.0 * turned) * steep.get(name, 1.0)
    # the engine keeps L, whose rounding is a spin of 2e-16 |L| / I about the axis of the least moment I
    momenta = np.linalg.norm(np.array(moments) * rotate(q * (1.0, -1.0, -1.0, -1.0), np.array(w)))
    tolerance += 1e-15 * momenta / min(moments) * end
    assert float(angle_between(attitude, exact)) <= tolerance
    assert np.abs(found - spin).max() <= tolerance * max(np.linalg.norm(w), 1.0 / end)


@pytest.mark.parametrize("seed", range(12))
def test_random_rotation_against_elliptic_functions(seed):
    """Random moments and spins for 10 s; every fourth body symmetric, by turns the flat and the long way."""
    rng = np.random.default_rng(seed)
    moments = np.sort(rng.uniform(1.0, 2.0, 3))
    if seed % 4 == 3:
        moments[1] = moments[0] if seed % 8 == 3 else moments[2]
    moments = rng.permutation(moments)
    q, w = normalised(rng.normal(size=4)), 3.0 * rng.normal(size=3)
    attitude, found, momentum, energy = tumbled(moments, q, w, 10.0)
    exact, spin = free_rotation(moments, q, w, np.array([10.0]))
    assert momentum <= 1e-13
    assert energy <= 1e-13
    # both err by rounding at each of the 50 rad turned
    assert float(angle_between(attitude, exact[0])) <= 2e-12
    assert np.abs(found - spin[0]).max() <= 1e-11


def test_the_two_oracles_agree():
    q, w = about((1.0, 2.0, -1.0), 0.7), np.array((0.7, 2.0, -1.0))
    for moments in ((1.0, 1.5, 2.2), (2.0, 1.0, 1.2)):
        exact, spin = taylor(moments, q, w, 4.0)
        turned, other = free_rotation(np.array(moments), q, w, np.array([4.0]))
        assert float(angle_between(turned[0], exact)) <= 1e-14 * 10
        assert np.abs(other[0] - spin).max() <= 1e-14 * 50


WING_NUTS = [
    ((1.0, 2.0, 3.0), (1e-3, 5.0, 1e-3)),
    ((2.0, 3.0, 1.0), (5.0, 1e-3, 2e-3)),
    ((1.0, 2.0, 3.0), (1e-3, 5.0, 0.0)),
    ((3.0, 2.0, 1.0), (-1e-3, 5.0, 1e-3)),
    ((1.0, 2.0, 3.0), (1e-4, 5.0, 2e-4)),
]


@pytest.mark.parametrize(("moments", "w"), WING_NUTS)
def test_a_wing_nut_turns_over_for_a_hundred_seconds(moments, w):
    """Dzhanibekov's effect: some 40 turnovers in 500 rad."""
    attitude, _, momentum, energy = tumbled(moments, ONE, w, 100.0)
    exact, _ = free_rotation(np.array(moments), np.array(ONE), np.array(w), np.array([100.0]))
    assert momentum <= 1e-15 * 4
    assert energy <= 1e-15 * 4
    # the axes are those of the world: nothing is rounded at the start, and what is kept is kept to the last bit
    assert float(angle_between(attitude, exact[0])) <= 1e-11


def sensitivity(moments, q, w, end):
    """Angle after `end` [s] by which free rotation changes if the start does by one unit in the last place [rad]."""
    exact, _ = free_rotation(moments, q, w, np.array([end]))
    out = 0.0
    for k in range(7):
        near, spin = q.copy(), w.copy()
        part, c = (near, k) if k < 4 else (spin, k - 4)
        part[c] = np.nextafter(part[c], np.inf)
        other, _ = free_rotation(moments, normalised(near), spin, np.array([end]))
        out += float(angle_between(other[0], exact[0]))
    return out


@pytest.mark.parametrize("seed", range(6))
def test_a_wing_nut_askew_turns_over_as_exactly_as_its_start_tells(seed):
    """Beside the separatrix the rounding of the angular velocity in the world is much beside |L|² - 2 T I₂.

    One unit in the last place of the start is 1e-11 to 1e-10 rad after 100 s; the engine, which rounds the start three
    times (to momentum, to the principal axes, to the invariants), may err by as many of them as that.
    """
    rng = np.random.default_rng(seed)
    moments, q = np.array((1.0, 2.0, 3.0)), normalised(rng.normal(size=4))
    w = rotate(q, np.array((1e-3, 5.0, 2e-3)))
    attitude, _, momentum, energy = tumbled(moments, q, w, 100.0)
    exact, _ = free_rotation(moments, q, w, np.array([100.0]))
    assert momentum <= 1e-15 * 4
    assert energy <= 1e-15 * 4
    assert float(angle_between(attitude, exact[0])) <= 3.0 * sensitivity(moments, q, w, 100.0) + 1e-11


@pytest.mark.parametrize("seed", range(6))
def test_axes_of_a_tensor_with_products_are_found_as_exactly(seed):
    """The same motion in a frame of the body that is not that of its principal axes."""
    rng = np.random.default_rng(100 + seed)
    moments, q, axes = np.array((1.0, 2.0, 3.0)), normalised(rng.normal(size=4)), normalised(rng.normal(size=4))
    w = rotate(q, np.array((1e-3, 5.0, 2e-3)))
    turn = matrix(axes)
    tensor = turn @ np.diag(moments) @ turn.T
    whole = tuple(map(tuple, (0.5 * (tensor + tensor.T)).tolist()))
    start = product(q, axes * (1.0, -1.0, -1.0, -1.0))  # of the body, whose principal axes have the attitude q
    body = Body("b", Box((0.1, 0.1, 0.1)), 1.0, orientation=tuple(start), angular_velocity=tuple(w), inertia=whole)
    motion = simulate(Scene((body,), (Rotation(),)), (0.0, 100.0))
    exact, _ = free_rotation(moments, q, w, np.array([100.0]))
    found = product(motion.q[1, 0], axes)
    # the nine entries of the tensor are rounded as well
    assert float(angle_between(found, exact[0])) <= 10.0 * sensitivity(moments, q, w, 100.0) + 1e-11


def test_a_body_that_does_not_turn_stays_as_it_stands():
    attitude, spin, _, _ = tumbled((1.0, 2.0, 2.5), about((1.0, 1.0, 0.0), 1.0), (0.0, 0.0, 0.0), 100.0)
    assert (attitude == about((1.0, 1.0, 0.0), 1.0)).all()
    assert not spin.any()


def test_a_quaternion_and_its_negative_are_one_attitude():
    q, w = about((1.0, 2.0, 3.0), 2.0), (1.0, -2.0, 0.5)
    one, other = (tumbled((1.0, 2.0, 2.5), sign * q, w, 3.0) for sign in (1.0, -1.0))
    assert (one[0] == -other[0]).all()
    assert (one[1] == other[1]).all()


def test_principal_axes_that_are_a_left_handed_set_are_the_same_tensor():
    """An inertia tensor with products: its eigenvectors may come out left-handed, the motion may not notice."""
    turn = matrix(about((1.0, -1.0, 2.0), 1.1))
    left = turn @ np.diag((1.0, 1.0, -1.0))
    moments, w = np.array((1.0, 2.0, 2.5)), (1.0, -2.0, 3.0)
    motions = []
    for axes in (turn, left):
        tensor = axes @ np.diag(moments) @ axes.T
        tensor = tuple(map(tuple, (0.5 * (tensor + tensor.T)).tolist()))
        body = Body("b", Box((0.1, 0.1, 0.1)), 1.0, angular_velocity=w, inertia=tensor)
        motions.append(simulate(Scene((body,), (Rotation(),)), (0.0, 4.0)))
    assert float(angle_between(motions[0].q[1, 0], motions[1].q[1, 0])) <= 1e-13
    # the same body with its frame along the principal axes
    exact, spin = free_rotation(moments, about((1.0, -1.0, 2.0), 1.1), np.array(w), np.array([4.0]))
    assert np.abs(motions[0].w[1, 0] - spin[0]).max() <= 1e-12
    point = rotate(motions[0].q[1, 0], turn @ np.array((1.0, 0.0, 0.0)))
    assert np.abs(point - rotate(exact[0], np.array((1.0, 0.0, 0.0)))).max() <= 1e-12


def test_times_that_are_not_ahead_ask_for_nothing():
    """t = 0 gives the start bit by bit, a time that is past the state that was reached."""
    body = Body("b", Box((0.1, 0.2, 0.3)), 1.0, (1.0, 2.0, 3.0), velocity=(4.0, 5.0, 6.0),
                angular_velocity=(1.0, 2.0, 3.0))  # fmt: skip
    scene = Scene((body,), (Gravity(), Rotation()))
    motion = simulate(scene, (-1.0, 0.0))
    start = scene.start()
    for name in ("x", "q", "v"):
        assert (getattr(motion, name) == getattr(start, name)).all()
    assert np.abs(motion.w - start.w).max() <= 1e-15 * 4.0
    world = begin(scene)
    advance(world, 0.5)
    advance(world, 0.0)
    advance(world, -0.1)
    assert world.t == 0.5


def test_heavy_symmetric_top_in_flight_precesses_under_a_torque():
    """A constant world torque along L of a body that spins about it only changes the spin."""
    body = Body("b", Box((0.2, 0.2, 0.3)), 1.0, angular_velocity=(0.0, 0.0, 5.0))
    motion = simulate(Scene((body,), (Rotation(), Force("b", torque=(0.0, 0.0, 0.02)))), (0.0, 3.0))
    inertia = (0.2**2 + 0.2**2) / 12.0
    assert motion.w[1, 0] == pytest.approx((0.0, 0.0, 5.0 + 3.0 * 0.02 / inertia), abs=1e-12)
    angle = math.remainder(15.0 + 0.5 * 9.0 * 0.02 / inertia, 2.0 * math.pi)
    assert float(angle_between(motion.q[1, 0], about((0.0, 0.0, 1.0), angle))) <= 1e-12


@pytest.mark.parametrize("drag", [1e-12, 1.0, 1e3])
def test_drag_of_any_strength_is_the_exponential(drag):
    """From a trace of drag, where v = v₀ - k v₀ t, to a body that stops within a millisecond."""
    body = Body("b", Sphere(0.1), 1.0, velocity=(3.0, 0.0, 0.0))
    motion = simulate(Scene((body,), (Drag(drag),)), (0.0, 0.01, 1.0))
    for k, t in ((1, 0.01), (2, 1.0)):
        assert motion.x[k, 0, 0] == pytest.approx(-3.0 / drag * math.expm1(-drag * t), rel=1e-13)
        assert motion.v[k, 0, 0] == pytest.approx(3.0 * math.exp(-drag * t), rel=1e-12, abs=1e-300)
