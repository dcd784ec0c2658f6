"""Distance fields: order of convergence, exact distances of meshes, and what happens at the border."""

import math
from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mechanics.shapes import Box, Capsule, Mesh, Sphere
from reference_impl.collide.field import (
    CUBIC,
    LINEAR,
    OutsideField,
    box_distance,
    distance_of,
    field_of,
    sampled,
)
from reference_impl.collide.mesh_distance import mesh_distance
from reference_impl.errors import Unsupported

LOW, HIGH = -np.ones(3), np.ones(3)
BAND = 0.1  # [m] about the surface, where contacts look


def sphere(points):
    return np.linalg.norm(points, axis=1) - 0.6


def torus(points):
    return np.hypot(np.hypot(points[:, 0], points[:, 1]) - 0.6, points[:, 2]) - 0.25


def box(points):
    return box_distance(points, np.array([0.55, 0.45, 0.35]))


def orders(distance, method, cells):
    """Observed orders of the greatest error of gap and normal from one grid to one twice as fine."""
    coarse, fine = (sampled(distance, LOW, HIGH, n, method).deviation(distance, BAND) for n in (cells, 2 * cells))
    return math.log2(coarse.gap / fine.gap), math.log2(coarse.normal / fine.normal)


def brick(size, offset=(0.0, 0.0, 0.0), scale=1.0):
    """A box as a mesh of twelve triangles."""
    corners = np.array(list(product((-0.5, 0.5), repeat=3))) * size * scale + offset
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    return Mesh(tuple(map(tuple, corners.tolist())), tuple(triangles))


def notched():
    """An L-shaped prism: one concave edge, along y through the origin's (0, 0)."""
    outline = [(0, 0), (0, 1), (-1, 1), (-1, -1), (1, -1), (1, 0)]  # x, z
    n = len(outline)
    vertices = [(x, y, z) for y in (-1.0, 1.0) for x, z in outline]
    caps = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]
    sides = [t for i in range(n) for j in [(i + 1) % n] for t in ((i, i + n, j), (j, i + n, j + n))]
    triangles = caps + [(a + n, c + n, b + n) for a, b, c in caps] + sides
    points = np.array(vertices, dtype=float)
    corners = points[np.array(triangles)]
    if np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) < 0.0:
        triangles = [(a, c, b) for a, b, c in triangles]
    return Mesh(tuple(map(tuple, points.tolist())), tuple(triangles), convex=False)


@pytest.mark.parametrize("distance", [sphere, torus])
def test_linear_fields_of_smooth_shapes_are_second_order(distance):
    gap, normal = orders(distance, LINEAR, 32)
    assert gap == pytest.approx(2.0, abs=0.3)
    assert normal == pytest.approx(1.0, abs=0.3)


@pytest.mark.parametrize(("distance", "cells"), [(sphere, 48), (torus, 64)])
def test_cubic_fields_of_smooth_shapes_are_fourth_order(distance, cells):
    # at the least: where a shape's centre, a kink of the distance, is some cells away its ripple still dies out
    # by a factor of 3.7 per cell
    gap, normal = orders(distance, CUBIC, cells)
    assert gap > 3.5
    assert normal > 2.5


@pytest.mark.parametrize("method", [LINEAR, CUBIC])
def test_fields_are_first_order_at_the_ridges_of_a_box(method):
    gap, _ = orders(box, method, 32)
    assert gap == pytest.approx(1.0, abs=0.5)
    # the normal does not converge at all: two faces are equally near inside an edge
    assert sampled(box, LOW, HIGH, 64, method).deviation(box, BAND).normal > math.radians(30.0)


def test_a_cubic_field_is_the_better_one():
    linear, cubic = (sampled(sphere, LOW, HIGH, 64, method).deviation(sphere, BAND) for method in (LINEAR, CUBIC))
    assert linear.gap < 1e-3
    assert cubic.gap < 1e-6
    assert cubic.mean < cubic.gap
    assert cubic.normal < 1e-2 * linear.normal


@pytest.mark.parametrize("method", [LINEAR, CUBIC])
def test_a_field_takes_the_values_of_its_nodes(method):
    field = sampled(torus, LOW, HIGH, 16, method)
    nodes = np.array(list(product((0, 1, 7, 15, 16), repeat=3))) * field.spacing + field.low
    assert field.gap(nodes) == pytest.approx(torus(nodes), abs=1e-14)


def test_a_cubic_field_repeats_cubic_polynomials_up_to_its_border():
    def cubic(p):
        x, y, z = p.T
        return 1.0 + x**3 - 2.0 * y**3 * z + x * y * z**3

    field = sampled(cubic, LOW, HIGH, 8, CUBIC)
    points = np.random.default_rng(1).uniform(-1.0, 1.0, (200, 3))
    gap, gradient = field.gap_and_gradient(points)
    x, y, z = points.T
    slope = np.stack([3 * x**2 + y * z**3, -6 * y**2 * z + x * z**3, -2 * y**3 + 3 * x * y * z**2], axis=1)
    assert gap == pytest.approx(cubic(points), abs=1e-12)
    assert np.abs(gradient - slope).max() < 1e-11


@pytest.mark.parametrize("method", [LINEAR, CUBIC])
def test_the_gradient_is_that_of_the_gap(method):
    field = sampled(torus, LOW, HIGH, 24, method)
    rng = np.random.default_rng(2)
    # within a cell, where the linear one is smooth
    points = field.low + field.spacing * (rng.integers(0, 24, (100, 3)) + rng.uniform(0.1, 0.9, (100, 3)))
    _, gradient = field.gap_and_gradient(points)
    h = 1e-6
    for c in range(3):
        step = h * np.eye(3)[c]
        slope = (field.gap(points + step) - field.gap(points - step)) / (2 * h)
        assert np.abs(slope - gradient[:, c]).max() < 1e-7


def test_one_point_gives_one_value():
    field = field_of(Sphere(0.5), 16)
    gap, gradient = field.gap_and_gradient(np.array([0.5, 0.0, 0.0]))
    assert np.ndim(gap) == 0
    assert gradient.shape == (3,)
    assert gradient == pytest.approx([1.0, 0.0, 0.0], abs=1e-3)


@pytest.mark.parametrize("bad", [(1.3, 0, 0), (0, -1.0001, 0), (0, 0, math.inf), (math.nan, 0, 0)])
def test_a_point_outside_is_named_with_the_bounds(bad):
    field = sampled(sphere, LOW, HIGH, 8)
    with pytest.raises(OutsideField) as caught:
        field.gap(np.array([[0.0, 0.0, 0.0], bad]))
    text = str(caught.value)
    assert " ".join(f"{value:.6g}" for value in bad) in text
    assert "(-1 -1 -1)" in text
    assert "(1 1 1)" in text
    assert field.contains(np.array([bad])).tolist() == [False]


def test_the_border_belongs_to_the_grid():
    field = sampled(sphere, LOW, HIGH, 8)
    corners = np.array(list(product((-1.0, 1.0), repeat=3)))
    assert field.contains(corners).all()
    assert field.gap(corners) == pytest.approx(sphere(corners), abs=1e-14)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"method": "quintic"}, "linear, cubic"),
        ({"cells": 2}, "at least 4"),
        ({"low": np.ones(3)}, "low < high"),
        ({"low": np.full(3, np.nan)}, "finite corners"),
        ({"distance": lambda p: np.full(len(p), np.nan)}, "not finite"),
    ],
)
def test_impossible_fields_are_refused(change, said):
    with pytest.raises(ValueError, match=said):
        sampled(**{"distance": sphere, "low": LOW, "high": HIGH, "cells": 8, "method": CUBIC} | change)


def test_shapes_without_a_distance_are_refused_by_name():
    with pytest.raises(Unsupported, match="Capsule"):
        field_of(Capsule(0.1, 0.2))


@given(st.tuples(*[st.floats(-1.5, 1.5)] * 3), st.sampled_from([1e-6, 1.0, 1e6]))
def test_a_brick_of_triangles_has_the_distance_of_a_box(point, scale):
    size = np.array([1.0, 0.6, 0.4])
    points = scale * np.array([point])
    exact = box_distance(points, 0.5 * size * scale)
    assert mesh_distance(brick(size, scale=scale))(points) == pytest.approx(exact, abs=1e-14 * scale)


@pytest.mark.parametrize(
    ("point", "distance"),
    [
        ((0.5, 0.0, 0.0), 0.0),  # on a face
        ((0.5, 0.5, 0.5), 0.0),  # on a vertex
        ((0.5, 0.5, 0.1), 0.0),  # on an edge
        ((0.7, 0.7, 0.0), math.hypot(0.2, 0.2)),  # beyond an edge
        ((0.7, 0.7, 0.7), 0.2 * math.sqrt(3.0)),  # beyond a vertex
        ((0.0, 0.0, 0.0), -0.5),  # equally near to all faces
        ((0.4, 0.4, 0.0), -0.1),  # on a ridge
    ],
)
def test_the_regions_of_a_brick(point, distance):
    assert mesh_distance(brick(np.ones(3)))(np.array([point]))[0] == pytest.approx(distance, abs=1e-15)


def test_the_sign_is_right_about_a_concave_edge():
    distance = mesh_distance(notched())
    inside, outside, axis = np.array([[-0.1, 0.0, -0.1], [0.1, 0.0, 0.1], [0.0, 0.3, 0.0]])
    assert distance(inside[None])[0] == pytest.approx(-math.hypot(0.1, 0.1), abs=1e-15)
    assert distance(outside[None])[0] == pytest.approx(0.1, abs=1e-15)
    assert distance(axis[None])[0] == pytest.approx(0.0, abs=1e-15)


def test_the_sign_is_that_of_a_ray_for_a_body_with_a_notch():
    rng = np.random.default_rng(3)
    points = rng.uniform(-1.4, 1.4, (2000, 3))
    x, y, z = points.T
    solid = (np.abs(x) < 1) & (np.abs(y) < 1) & (np.abs(z) < 1) & ~((x > 0) & (z > 0))
    assert np.array_equal(mesh_distance(notched())(points) < 0.0, solid)


def test_a_field_of_a_mesh_is_the_field_of_its_shape():
    size = np.array([1.0, 0.6, 0.4])
    mesh = brick(size)
    field = field_of(mesh, 24)
    assert np.all(field.low < -0.5 * size)
    assert np.all(field.high > 0.5 * size)
    assert field.deviation(distance_of(mesh), BAND, 2000).gap < field.spacing
    same = field_of(Box((1.0, 0.6, 0.4)), 24)
    assert field.values == pytest.approx(same.values, abs=1e-12)
