"""Laws of rotation algebra over random quaternions and vectors."""

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mechanics import rotation

numbers = st.floats(-3.0, 3.0, allow_nan=False)
vectors = st.tuples(numbers, numbers, numbers).map(np.array)
quaternions = st.tuples(numbers, numbers, numbers, numbers).map(np.array).filter(lambda q: np.linalg.norm(q) > 1e-3)
units = quaternions.map(rotation.normalised)


@given(units, units, vectors)
def test_the_product_is_the_rotation_by_q_then_by_p(p, q, v):
    after = rotation.rotate(rotation.product(p, q), v)
    assert after == pytest.approx(rotation.rotate(p, rotation.rotate(q, v)), abs=1e-13)


@given(units, vectors)
def test_a_rotation_keeps_lengths_and_undoes_itself(q, v):
    turned = rotation.rotate(q, v)
    assert np.linalg.norm(turned) == pytest.approx(np.linalg.norm(v), abs=1e-14)
    assert rotation.unrotate(q, turned) == pytest.approx(v, abs=1e-13)


@given(units, vectors)
def test_the_matrix_rotates_like_the_quaternion(q, v):
    m = rotation.matrix(q)
    assert m @ v == pytest.approx(rotation.rotate(q, v), abs=1e-13)
    assert m @ m.T == pytest.approx(np.eye(3), abs=1e-14)
    assert np.linalg.det(m) == pytest.approx(1.0, abs=1e-14)


@pytest.mark.parametrize("shapes", [((3,), (3,)), ((7, 3), (3,)), ((3,), (7, 3)), ((2, 1, 3), (5, 3))])
def test_the_cross_product_is_numpys_bit_for_bit(shapes):
    a, b = (np.random.default_rng(3).normal(size=shape) for shape in shapes)
    assert np.array_equal(rotation.cross(a, b), np.cross(a, b))


@given(units)
def test_the_quaternion_of_a_matrix_is_the_same_orientation(q):
    assert rotation.angle_between(rotation.from_matrix(rotation.matrix(q)), q) < 1e-14


@pytest.mark.parametrize("axis", [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (1.0, 1.0, 0.0)])
def test_half_turns_have_no_weak_spot(axis):
    half_turn = rotation.about(axis, np.pi)
    assert rotation.angle_between(rotation.from_matrix(rotation.matrix(half_turn)), half_turn) < 1e-14


@given(units, st.floats(1e-15, 1e-3))
def test_angles_far_below_the_reach_of_the_arccosine_are_seen(q, angle):
    nearby = rotation.product(rotation.about((1.0, 2.0, -1.0), angle), q)
    # the product rounds at 1e-16, so an angle is known to about that, absolutely
    assert float(rotation.angle_between(q, nearby)) == pytest.approx(angle, rel=1e-9, abs=1e-15)
    assert rotation.angle_between(q, -nearby) == rotation.angle_between(q, nearby)


@given(vectors)
def test_the_exponential_is_the_rotation_about_the_vector_by_its_length(phi):
    angle = float(np.linalg.norm(phi))
    q = rotation.exponential(phi)
    assert rotation.rotate(q, phi) == pytest.approx(phi, abs=1e-14)
    assert float(rotation.angle_between(q, np.array(rotation.IDENTITY))) == pytest.approx(
        min(angle, 2 * np.pi - angle), abs=1e-14
    )


@pytest.mark.parametrize("size", [0.0, 1e-300, 1e-160, 1e-9, 1e-4])
def test_the_exponential_is_exact_for_the_smallest_rotations(size):
    q = rotation.exponential(np.array([size, 0.0, 0.0]))
    assert q[1] == pytest.approx(float(mpmath.sin(mpmath.mpf(size) / 2)), rel=1e-15, abs=0.0)


def test_batches_broadcast():
    many = rotation.normalised(np.random.default_rng(0).normal(size=(5, 4)))
    one = np.array([0.1, 0.2, 0.3])
    assert rotation.rotate(many, one).shape == (5, 3)
    assert rotation.rotate(many, one)[3] == pytest.approx(rotation.rotate(many[3], one), abs=1e-15)
