"""Mass properties against closed forms, meshes against the shapes they are, and what no mass can have."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mechanics.arrays import SceneError
from mechanics.inertia import check_inertia, mass_properties, principal
from mechanics.rotation import matrix, normalised
from mechanics.shapes import Box, Capsule, Cylinder, HalfSpace, Mesh, Sphere

lengths = st.floats(0.01, 10.0)

BOX_FACES = (
    (0, 2, 1), (1, 2, 3), (4, 5, 6), (5, 7, 6), (0, 1, 4), (1, 5, 4),
    (2, 6, 3), (3, 6, 7), (0, 4, 2), (2, 4, 6), (1, 3, 5), (3, 7, 5),
)  # fmt: skip


def box_mesh(size, offset=(0.0, 0.0, 0.0)):
    corners = [
        tuple(o + s * (k - 0.5) for o, s, k in zip(offset, size, (i & 1, i >> 1 & 1, i >> 2), strict=True))
        for i in range(8)
    ]
    return Mesh(tuple(corners), BOX_FACES)


TETRAHEDRON = Mesh(((1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)), ((0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)))


@given(lengths, lengths, lengths)
def test_a_mesh_of_a_box_has_the_mass_properties_of_the_box(a, b, c):
    mesh, box = mass_properties(box_mesh((a, b, c))), mass_properties(Box((a, b, c)))
    assert mesh.volume == pytest.approx(box.volume, rel=1e-13)
    assert mesh.inertia == pytest.approx(box.inertia, rel=1e-12, abs=1e-13 * max(a, b, c) ** 2)


@given(st.tuples(lengths, lengths, lengths))
def test_moving_a_mesh_moves_its_centre_and_nothing_else(offset):
    here, there = mass_properties(box_mesh((1, 2, 3))), mass_properties(box_mesh((1, 2, 3), offset))
    assert there.centre - here.centre == pytest.approx(np.array(offset), abs=1e-13)
    assert there.inertia == pytest.approx(here.inertia, abs=1e-12)
    assert mass_properties(box_mesh((1, 2, 3), offset).centred()).centre == pytest.approx(np.zeros(3), abs=1e-14)


def test_a_regular_tetrahedron():
    # edge s = 2 sqrt 2: V = s³/(6 sqrt 2), I = s²/20 about every axis
    properties = mass_properties(TETRAHEDRON)
    assert properties.volume == pytest.approx(8.0 / 3.0, rel=1e-15)
    assert properties.inertia == pytest.approx(np.eye(3) * 0.4, abs=1e-15)


@pytest.mark.parametrize(
    ("shape", "kilograms", "moments"),
    [  # density 1000 kg/m3, from the integrals of each solid
        (Box((0.1, 0.4, 0.9)), 36.0, (2.91, 2.46, 0.51)),
        (Sphere(0.2), 1000 * 4 / 3 * math.pi * 0.008, (0.5361651462126, 0.5361651462126, 0.5361651462126)),
        (Cylinder(0.1, 0.5), 5 * math.pi, (0.366519142919, 0.366519142919, 0.0785398163397)),
    ],
)
def test_solids_of_known_density(shape, kilograms, moments):
    properties = mass_properties(shape)
    assert 1000 * properties.volume == pytest.approx(kilograms, rel=1e-14)
    assert 1000 * properties.volume * np.diag(properties.inertia) == pytest.approx(moments, rel=1e-12)


@given(lengths, lengths)
def test_a_capsule_is_integrated_right(radius, length):
    # an independent route: discs stacked along z, by Gauss quadrature over the caps and the tube
    nodes, weights = np.polynomial.legendre.leggauss(40)
    volume = along = across = 0.0
    for low, high in (
        (-length / 2 - radius, -length / 2),
        (-length / 2, length / 2),
        (length / 2, length / 2 + radius),
    ):
        z = (high - low) / 2 * nodes + (high + low) / 2
        square = radius**2 - np.maximum(np.abs(z) - length / 2, 0.0) ** 2
        area = np.pi * square * weights * (high - low) / 2
        volume += area.sum()
        along += (area * square / 2).sum()
        across += (area * (square / 4 + z**2)).sum()
    properties = mass_properties(Capsule(radius, length))
    assert properties.volume == pytest.approx(volume, rel=1e-13)
    assert np.diag(properties.inertia) == pytest.approx([across / volume, across / volume, along / volume], rel=1e-12)


def test_a_long_capsule_is_a_rod_and_a_short_one_a_ball():
    assert mass_properties(Capsule(1e-6, 3.0)).inertia[0, 0] == pytest.approx(9.0 / 12.0, rel=1e-5)
    assert mass_properties(Capsule(1.0, 1e-9)).inertia[0, 0] == pytest.approx(0.4, rel=1e-8)


def test_a_half_space_has_no_mass():
    with pytest.raises(SceneError, match="can only be fixed"):
        mass_properties(HalfSpace())


@given(st.tuples(*[st.floats(-1, 1)] * 4).map(np.array).filter(lambda q: np.linalg.norm(q) > 0.1))
def test_principal_axes_restore_the_tensor(q):
    r = matrix(normalised(q))
    tensor = r @ np.diag([1.0, 2.0, 2.5]) @ r.T
    moments, turn = principal(tensor)
    axes = matrix(turn)
    assert axes @ np.diag(moments) @ axes.T == pytest.approx(tensor, abs=1e-13)


def test_a_diagonal_tensor_keeps_its_axes():
    moments, turn = principal(np.diag([3.0, 1.0, 2.5]))
    assert moments.tolist() == [3.0, 1.0, 2.5]
    assert turn.tolist() == [1.0, 0.0, 0.0, 0.0]


@pytest.mark.parametrize(
    ("tensor", "message"),
    [
        (np.diag([1.0, 1.0, 2.1]), "triangle inequality"),
        (np.diag([1.0, 1.0, -0.5]), "positive principal moments"),
        (np.array([[1.0, 0.5, 0], [0.4, 1, 0], [0, 0, 1]]), "symmetric"),
    ],
)
def test_tensors_no_mass_has_are_refused(tensor, message):
    with pytest.raises(SceneError, match=message):
        check_inertia("inertia", tensor)


def test_a_flat_plate_is_allowed():
    plate = np.diag([1.0, 2.0, 3.0])
    check_inertia("inertia", plate)
    with pytest.raises(SceneError, match="triangle inequality"):
        check_inertia("inertia", plate + np.diag([0.0, 0.0, 1e-6]))
