"""Radau's collocation: its coefficients, its order, and that a fast decay does not shorten its steps."""

from __future__ import annotations

import math

import numpy as np
import pytest

from reference_impl.collocation import STAGES, Collocation, table


def method(size, allowed=1e-13):
    return Collocation(np.full(size, 1e-7), np.full(size, allowed))


def test_the_weights_integrate_polynomials_as_far_as_they_must():
    """At every node to degree s - 1, at the last one, Radau's rule, to degree 2 s - 2."""
    nodes, weights, _ = table()
    for degree in range(STAGES):
        assert weights @ nodes**degree == pytest.approx(nodes ** (degree + 1) / (degree + 1), rel=1e-13, abs=1e-16)
    for degree in range(2 * STAGES - 1):
        assert weights[-1] @ nodes**degree == pytest.approx(1.0 / (degree + 1), rel=1e-13)
    assert abs(weights[-1] @ nodes ** (2 * STAGES - 1) - 0.1) > 1e-6


def test_its_end_is_of_order_nine():
    """The error of one step of y' = y cos t, y = exp(sin t), falls with the tenth power of the step."""

    def rate(t, y):
        return y * math.cos(t)

    errors = []
    for h in (0.8, 0.4):
        one = method(1)
        end, _ = one.step(rate, 0.3, np.array([math.exp(math.sin(0.3))]), h, np.array([math.exp(math.sin(0.3)) *
                                                                                   math.cos(0.3)]))  # fmt: skip
        assert one.converged
        errors.append(abs(end[0] - math.exp(math.sin(0.3 + h))))
    assert 9.0 <= math.log2(errors[0] / errors[1]) <= 12.0


@pytest.mark.parametrize("decay", [1e2, 1e5, 1e8])
def test_a_fast_decay_is_left_behind_at_once(decay):
    """y' = -k (y - cos t) - sin t from y(0) = 1: y = cos t whatever k, in one step of 0.1.

    But for the error of its nodes, of the order of h^6 / 720, over k h.
    """

    def rate(t, y):
        return -decay * (y - math.cos(t)) - math.sin(t)

    one = method(1)
    end, stages = one.step(rate, 0.0, np.ones(1), 0.1, np.zeros(1))
    assert one.converged
    assert end[0] == pytest.approx(math.cos(0.1), abs=1e-12)
    assert len(stages) == STAGES + 1


def test_the_error_that_is_told_bounds_the_one_there_is():
    """Of y' = y, relative to 1e-13 allowed."""
    for h in (0.2, 0.5, 1.0):
        one = method(1)
        end, stages = one.step(lambda t, y: y, 0.0, np.ones(1), h, np.ones(1))
        assert abs(end[0] - math.exp(h)) <= 1e-13 * one.error(stages, h, np.full(1, 1e-13)) + 4e-16


def test_stages_that_are_not_found_are_no_step():
    """A rate that jumps to and fro has none."""
    one = method(1, 1e-15)
    _, stages = one.step(lambda t, y: np.where(y > 0.0, -1.0, 1.0) + 0.3, 0.0, np.zeros(1), 1.0, np.ones(1))
    assert not one.converged
    assert one.error(stages, 1.0, np.full(1, 1e-15)) > 1.0
