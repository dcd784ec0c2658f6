"""The coefficients of the Runge-Kutta method in lasting contact are those of DOP853, and of order eight."""

import math

import numpy as np
import pytest
from scipy.integrate import DOP853

from reference_impl import dormand_prince
from reference_impl.integrators import RungeKutta8


@pytest.mark.parametrize("name", ["A", "B", "C", "E3", "E5"])
def test_the_coefficients_are_scipy_s_bit_by_bit(name):
    assert np.array_equal(getattr(dormand_prince, name), getattr(DOP853, name))


def test_an_oscillator_converges_with_the_eighth_power_of_the_step():
    method, errors = RungeKutta8(), []
    for steps in (8, 16):
        y, h = np.array([1.0, 0.0]), 2.0 * math.pi / steps
        for k in range(steps):
            y, _ = method.step(lambda t, y: np.array([y[1], -y[0]]), k * h, y, h, np.array([y[1], -y[0]]))
        errors.append(float(np.linalg.norm(y - [1.0, 0.0])))
    assert math.log2(errors[0] / errors[1]) == pytest.approx(8.0, abs=0.5)
