"""Contact features: separation against the true distance, the whole contact set, degenerate positions, kinematics."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mechanics.rotation import about, exponential, matrix, normalised, product
from reference_impl.collide.boxes import box_box, separations
from reference_impl.collide.features import EDGES, FACE, REAL, WHOLE, kinematics, margin
from reference_impl.collide.primitives import box_plane, sphere_box

REACH = 1e-9
ONE = np.array((0.5, 0.5, 0.5))
STRAIGHT = (1.0, 0.0, 0.0, 0.0)


def contacts(xa, qa, half_a, xb, qb, half_b):
    """Separation of two boxes and, of each contact: kind, normal (towards a), point, gap, margin."""
    kinds, reals = np.zeros((40, WHOLE), dtype=np.int64), np.zeros((40, REAL))
    place = (np.array(xa, dtype=float), np.array(xb, dtype=float))
    turn = (matrix(np.array(qa)), matrix(np.array(qb)))
    half = (np.array(half_a), np.array(half_b))
    count, gap = box_box(0, 1, place[0], turn[0], half[0], place[1], turn[1], half[1], REACH, REACH, kinds, reals, 0)
    out, zero = [], np.zeros(3)
    for k in range(count):
        i, j = kinds[k, :2]
        n, point = np.empty(3), np.empty(3)
        values = kinematics(kinds[k], reals[k], place[i], turn[i], zero, zero, place[j], turn[j], zero, zero, n, point)
        inside = margin(kinds[k], reals[k], place[i], turn[i], place[j], turn[j], half[i], half[j])
        out.append((int(kinds[k, 2]), n if i == 0 else -n, point, values[0], inside))
    return gap, out


def points(found):
    return sorted(tuple(round(float(c), 9) + 0.0 for c in contact[2]) for contact in found)


@pytest.mark.parametrize("tilt", [0.0, 1e-14, 1e-12, 1e-10])
def test_coplanar_faces_touch_at_four_corners(tilt):
    q = about((1.0, 2.0, 0.0), tilt)
    gap, found = contacts((0, 0, 1.0), q, ONE, (0, 0, 0), STRAIGHT, ONE)
    assert gap == pytest.approx(0.0, abs=2.0 * tilt + 1e-15)
    assert len(found) == 4
    assert all(n == pytest.approx((0, 0, 1), abs=2.0 * tilt + 1e-15) for _, n, *_ in found)


def test_turned_faces_touch_at_the_eight_corners_of_their_common_polygon():
    gap, found = contacts((0, 0, 1.0), about((0.0, 0.0, 1.0), 0.3), ONE, (0, 0, 0), STRAIGHT, ONE)
    assert gap == pytest.approx(0.0, abs=1e-15)
    assert [kind for kind, *_ in found] == [EDGES] * 8
    assert all(abs(g) < 1e-15 and inside > 0.1 for _, _, _, g, inside in found)
    assert len(set(points(found))) == 8
    for x, y, z in points(found):
        assert max(abs(x), abs(y)) == pytest.approx(0.5)
        assert z == pytest.approx(0.5)


def test_shifted_faces_touch_at_the_corners_of_their_overlap():
    _, found = contacts((0.3, 0.2, 1.0), STRAIGHT, ONE, (0, 0, 0), STRAIGHT, ONE)
    assert points(found) == [(-0.2, -0.3, 0.5), (-0.2, 0.5, 0.5), (0.5, -0.3, 0.5), (0.5, 0.5, 0.5)]


def test_a_small_face_on_a_large_one_and_below_it():
    large = np.array((2.0, 2.0, 0.1))
    expected = [(x, y) for x in (-0.5, 0.5) for y in (-0.5, 0.5)]
    for a, b, z in ((ONE, large, 0.1), (large, ONE, 0.5)):
        _, found = contacts((0, 0, 0.6), STRAIGHT, a, (0, 0, 0), STRAIGHT, b)
        assert [p[:2] for p in points(found)] == expected
        assert all(p[2] == pytest.approx(z) for p in points(found))
        assert {kind for kind, *_ in found} == {FACE}


def test_an_edge_on_a_face_touches_at_its_ends_or_where_it_leaves():
    long = np.array((0.5, 0.7, 0.5))
    q = about((0.0, 1.0, 0.0), math.pi / 4)
    height = 0.5 + math.sqrt(0.5)
    _, found = contacts((0, 0, height), q, long, (0, 0, 0), STRAIGHT, ONE)
    assert points(found) == [(0.0, -0.5, 0.5), (0.0, 0.5, 0.5)]
    _, found = contacts((0, 0, height), q, np.array((0.5, 0.3, 0.5)), (0, 0, 0), STRAIGHT, ONE)
    assert points(found) == [(0.0, -0.3, 0.5), (0.0, 0.3, 0.5)]


def test_crossing_edges_touch_once():
    a = product(about((0.0, 0.0, 1.0), math.pi / 2), about((0.0, 1.0, 0.0), math.pi / 4))
    gap, found = contacts((0, 0, math.sqrt(2.0)), a, ONE, (0, 0, 0), about((0.0, 1.0, 0.0), math.pi / 4), ONE)
    assert gap == pytest.approx(0.0, abs=1e-15)
    assert [(kind, tuple(np.round(n, 12) + 0.0)) for kind, n, *_ in found] == [(EDGES, (0, 0, 1))]
    assert found[0][2] == pytest.approx((0, 0, math.sqrt(0.5)))


def test_a_corner_on_a_face_touches_once():
    # the long diagonal upright: the corner is half the diagonal below the centre
    q = product(about((0.0, 1.0, 0.0), -math.atan(math.sqrt(0.5))), about((1.0, 0.0, 0.0), math.pi / 4))
    gap, found = contacts((0.1, 0.2, 0.5 + math.sqrt(0.75)), q, ONE, (0, 0, 0), STRAIGHT, ONE)
    assert abs(gap) < 1e-15
    assert [kind for kind, *_ in found] == [FACE]
    assert found[0][2] == pytest.approx((0.1, 0.2, 0.5))


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 100_000))
def test_the_order_of_the_boxes_does_not_matter(seed):
    rng = np.random.default_rng(seed)
    (qa, qb), (half_a, half_b) = normalised(rng.normal(size=(2, 4))), rng.uniform(0.1, 0.6, (2, 3))
    way = rng.normal(size=3)
    way /= np.linalg.norm(way)

    def apart(distance):
        return contacts(distance * way, qa, half_a, np.zeros(3), qb, half_b)[0]

    low, high = 0.0, 3.0  # separation is continuous along the way: bring them to a touch
    for _ in range(80):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if apart(middle) > 0.0 else (middle, high)
    gap, first = contacts(high * way, qa, half_a, np.zeros(3), qb, half_b)
    _, second = contacts(np.zeros(3), qb, half_b, high * way, qa, half_a)
    assert abs(gap) < 1e-14
    assert len(first) >= 1
    assert np.array(points(first)) == pytest.approx(np.array(points(second)), abs=1e-8)
    for (_, n, _, g, inside), (_, m, *_) in zip(first, second, strict=True):
        assert abs(g) < 1e-9
        assert inside >= -1e-8
        assert n == pytest.approx(-m, abs=1e-9)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 100_000))
def test_separation_is_a_lower_bound_of_the_distance_of_any_two_points(seed):
    rng = np.random.default_rng(seed)
    q = normalised(rng.normal(size=(2, 4)))
    half, x = rng.uniform(0.1, 0.6, (2, 3)), rng.normal(size=3)
    ra, rb = matrix(q[0]), matrix(q[1])
    values = np.empty(15)
    best = values[separations(ra, half[0], rb, half[1], x, values)]
    a = x + (rng.uniform(-1, 1, (200, 3)) * half[0]) @ ra.T
    b = (rng.uniform(-1, 1, (200, 3)) * half[1]) @ rb.T
    nearest = np.linalg.norm(a[:, None] - b[None], axis=2).min()
    assert best <= nearest
    inside = (np.abs(a @ rb) < half[1]).all(axis=1).any()  # a point of one within the other
    assert not (inside and best > 0.0)


@pytest.mark.parametrize(("centre", "kind", "gap"), [
    ((0.2, 0.1, 0.7), 0, 0.1), ((0.8, 0.1, 0.9), 3, 0.4), ((0.8, 0.9, 1.7), 2, 1.2), ((0.1, 0.0, 0.3), 0, -0.3),
])  # fmt: skip
def test_a_ball_at_face_edge_corner_and_inside_of_a_box(centre, kind, gap):
    kinds, reals = np.zeros((1, WHOLE), dtype=np.int64), np.zeros((1, REAL))
    x, zero, turn = np.array(centre), np.zeros(3), np.eye(3)
    assert sphere_box(0, 1, x, zero, turn, 0.1, ONE, 10.0, kinds, reals, 0) == 1
    n, point = np.empty(3), np.empty(3)
    found = kinematics(kinds[0], reals[0], x, turn, zero, zero, zero, turn, zero, zero, n, point)[0]
    assert kinds[0, 2] == kind
    assert found == pytest.approx(gap)
    assert point == pytest.approx(x - 0.1 * n)


def test_a_box_over_a_plane_counts_its_low_corners():
    kinds, reals = np.zeros((8, WHOLE), dtype=np.int64), np.zeros((8, REAL))
    up = np.array((0.0, 0.0, 1.0))
    for q, count in ((STRAIGHT, 4), (tuple(about((0.0, 1.0, 0.0), 0.1)), 2), (tuple(about((1.0, 2.0, 0.0), 0.1)), 1)):
        turn = matrix(np.array(q))
        height = float(np.abs(turn[2]) @ ONE)
        found = box_plane(0, 1, np.array((0, 0, height)), turn, ONE, np.zeros(3), up, up, REACH, kinds, reals, 0)
        assert found == count


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 100_000), st.integers(0, 3))
def test_gap_rate_and_bias_are_the_derivatives_of_the_gap(seed, kind):
    """Bodies that turn steadily and move evenly: then gap'' is the bias, and gap' its integral."""
    rng = np.random.default_rng(seed)
    wa, wb, va, vb, xa, xb = rng.normal(size=(6, 3))
    xa = 0.3 * xa + (0.0, 0.0, 3.0)
    qa, qb = normalised(rng.normal(size=(2, 4)))
    kinds, reals = np.array((0, 1, kind, 0, 0)), np.zeros(REAL)
    reals[0:3], reals[6:9] = 0.2 * rng.normal(size=(2, 3))
    a, b = rng.normal(size=(2, 3))
    reals[3:6], reals[9:12] = a / np.linalg.norm(a), b / np.linalg.norm(b)
    reals[12] = reals[13] = 0.2
    if kind == EDGES:
        reals[12] = 0.3
    n, point = np.empty(3), np.empty(3)

    def at(t):
        ra, rb = matrix(product(exponential(wa * t), qa)), matrix(product(exponential(wb * t), qb))
        return kinematics(kinds, reals, xa + va * t, ra, va, wa, xb + vb * t, rb, vb, wb, n, point)

    if kind == EDGES and np.linalg.norm(np.cross(matrix(qa) @ reals[3:6], matrix(qb) @ reals[9:12])) < 0.2:
        return  # nearly parallel edges: their nearest points are far away and finite differences lose all digits
    if kind == 3 and np.linalg.norm(np.cross(xa - xb, matrix(qb) @ reals[9:12])) < 0.5:
        return  # a point nearly on the line
    h = 1e-3
    gap, rate = ({k: at(k * h)[c] for k in range(-3, 4)} for c in (0, 1))

    def slope(f):  # sixth order
        return (45.0 * (f[1] - f[-1]) - 9.0 * (f[2] - f[-2]) + f[3] - f[-3]) / (60.0 * h)

    _, there, bias = at(0.0)
    assert there == pytest.approx(slope(gap), rel=1e-8, abs=1e-8)
    assert bias == pytest.approx(slope(rate), rel=1e-7, abs=1e-7)
    assert np.linalg.norm(n) == pytest.approx(1.0, rel=1e-15)
