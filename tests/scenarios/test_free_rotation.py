"""Free rotation in closed form against 17-digit numbers and against direct integration."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from mechanics.rotation import angle_between, normalised, rotate, unrotate
from scenarios.free_rotation import free_rotation

GAZEBO = np.array([97 / 120, 41 / 60, 17 / 120])  # box 0.1 x 0.4 x 0.9 m of 10 kg [kg m2]
IDENTITY = np.array([1.0, 0.0, 0.0, 0.0])


def integrated(moments, q, w, t):
    """Newton-Euler equations by an explicit Runge-Kutta method of order 8."""

    i, j, k = moments.tolist()

    def rate(_, y):  # ½ q ω and Euler's equations in the body's frame, number by number
        a, b, c, d, p, q, r = y.tolist()
        return [
            0.5 * (-b * p - c * q - d * r), 0.5 * (a * p + c * r - d * q), 0.5 * (a * q + d * p - b * r),
            0.5 * (a * r + b * q - c * p), (j - k) * q * r / i, (k - i) * r * p / j, (i - j) * p * q / k,
        ]  # fmt: skip

    y = solve_ivp(rate, (0.0, t[-1]), [*q, *unrotate(q, w)], "DOP853", t, rtol=1e-13, atol=1e-14).y.T
    turned = normalised(y[:, :4])
    return turned, rotate(turned, y[:, 4:])


def test_attitude_after_ten_seconds_of_tumbling():
    # 22-digit extrapolation of the quaternion equation, near the separatrix (m = 0.99986)
    q, w = free_rotation(GAZEBO, IDENTITY, np.array([0.1, 5.0, 0.1]), np.array([10.0]))
    q_true = [0.22516456341395816, -0.61992756249945249, -0.27702915068719459, 0.69874572364031014]
    w_true = [2.6678188014706755, 4.9388371655813563, 0.19936455139903461]
    np.testing.assert_allclose(q[0] * np.sign(q[0, 0]), q_true, atol=1e-13)
    np.testing.assert_allclose(w[0], w_true, atol=1e-13)
    np.testing.assert_allclose(
        unrotate(q[0], w[0]), [2.7558404051468494, -3.7359635192162199, -3.1618090034675183], atol=1e-13
    )


def test_the_middle_component_flips_every_half_period():
    t = np.array([0.0, 3.0284220790078382, 6.0568441580156764])
    q, w = free_rotation(GAZEBO, IDENTITY, np.array([0.1, 5.0, 0.1]), t)
    body = unrotate(q, w)
    # half a period turns two components round, a whole one none
    np.testing.assert_allclose(np.abs(body[1]), np.abs(body[0]), atol=1e-13)
    assert body[1, 1] == pytest.approx(-5.0, abs=1e-13)
    np.testing.assert_allclose(body[2], body[0], atol=1e-13)


kinds = st.sampled_from(["asymmetric", "prolate", "oblate", "sphere"])


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1), kinds)
def test_agrees_with_direct_integration(seed, kind):
    random = np.random.default_rng(seed)
    moments = np.sort(random.uniform(1.0, 2.0, 3))
    moments[1] = {"asymmetric": moments.mean(), "prolate": moments[2], "oblate": moments[0], "sphere": 1.0}[kind]
    moments = random.permutation(np.ones(3) if kind == "sphere" else moments)
    q, w, t = normalised(random.normal(size=4)), 3.0 * random.normal(size=3), np.array([0.0, 0.5, 1.0, 3.0])
    turned, spin = free_rotation(moments, q, w, t)
    expected, expected_spin = integrated(moments, q, w, t)
    assert np.max(angle_between(turned, expected)) < 1e-9
    np.testing.assert_allclose(spin, expected_spin, atol=1e-9)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_keeps_energy_and_angular_momentum(seed):
    random = np.random.default_rng(seed)
    moments, q, w = random.uniform(1.0, 2.0, 3), normalised(random.normal(size=4)), random.normal(size=3)
    turned, spin = free_rotation(moments, q, w, np.linspace(0.0, 100.0, 50))
    body = unrotate(turned, spin)
    momentum = rotate(turned, moments * body)
    np.testing.assert_allclose(
        momentum, np.broadcast_to(rotate(q, moments * unrotate(q, w)), momentum.shape), atol=1e-12
    )
    np.testing.assert_allclose((moments * body**2).sum(axis=1), (moments * unrotate(q, w) ** 2).sum(), rtol=1e-12)


def test_spin_about_a_principal_axis_is_uniform():
    q, w = free_rotation(GAZEBO, IDENTITY, np.array([0.0, 2.0, 0.0]), np.array([0.5]))
    np.testing.assert_allclose(q[0], [np.cos(0.5), 0.0, np.sin(0.5), 0.0], atol=1e-15)
    assert w[0].tolist() == [0.0, 2.0, 0.0]


def test_the_separatrix_is_refused():
    # |L|² = 2 T I₂, in binary fractions: 9/4 (9/4 - 2) 1² = 1 (2 - 1) (3/4)²
    with pytest.raises(ValueError, match="separatrix"):
        free_rotation(np.array([2.25, 2.0, 1.0]), IDENTITY, np.array([1.0, 1.0, 0.75]), np.array([1.0]))
