"""The pseudo-inverse in loops is that of the libraries, whatever the rank, and says when there is none."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from reference_impl.pseudo_inverse import pseudo_inverse, times, turned_times


def matrix(seed, m, n, rank, spread):
    rng = np.random.default_rng(seed)
    u, _ = np.linalg.qr(rng.normal(size=(m, m)))
    v, _ = np.linalg.qr(rng.normal(size=(n, n)))
    s = np.zeros((m, n))
    for k in range(min(rank, m, n)):
        s[k, k] = 10.0 ** (-spread * k / max(1, min(m, n) - 1))
    return u @ s @ v.T, min(rank, m, n)


@given(st.integers(0, 10**6), st.integers(1, 13), st.integers(1, 13), st.integers(0, 13), st.floats(0.0, 6.0))
def test_it_is_the_inverse_of_moore_and_penrose(seed, m, n, rank, spread):
    a, rank = matrix(seed, m, n, rank, spread)
    found = np.full((n, m), np.nan)
    assert pseudo_inverse(a, 1e-12, found) == rank
    wanted = np.linalg.pinv(a, rcond=1e-12)
    np.testing.assert_allclose(found, wanted, atol=1e-15 * 10.0 ** (2 * spread) * 30 + 1e-14)
    assert np.abs(a @ found @ a - a).max() < 1e-14 * max(1.0, 10.0**spread)


def test_columns_of_zeros_stay_zero():
    a, _ = matrix(3, 6, 6, 6, 1.0)
    a[:, [1, 4]] = 0.0
    found = np.empty((6, 6))
    assert pseudo_inverse(a, 1e-12, found) == 4
    assert not found[[1, 4]].any()


@pytest.mark.parametrize("bad", [np.nan, np.inf, 1e200])
def test_what_is_not_finite_has_none(bad):
    a = np.eye(3)
    a[0, 1] = bad
    assert pseudo_inverse(a, 1e-12, np.empty((3, 3))) == -1


def test_products():
    rng = np.random.default_rng(1)
    a, x, y = rng.normal(size=(4, 7)), rng.normal(size=7), rng.normal(size=4)
    ax, ay = np.empty(4), np.empty(7)
    times(a, x, ax)
    turned_times(a, y, ay)
    np.testing.assert_allclose(ax, a @ x, rtol=1e-13)
    np.testing.assert_allclose(ay, a.T @ y, rtol=1e-13)
