"""Degenerate geometry: triangles that are hardly any, folded and broken meshes, fields where they are not smooth."""

from itertools import product as combinations

import numpy as np
import pytest

from mechanics.arrays import SceneError
from mechanics.effects import Gravity, Resting, Restitution, Rotation
from mechanics.rotation import about
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Mesh
from reference_impl.collide.field import CUBIC, LINEAR, sampled
from reference_impl.simulate import advance, begin
from reference_impl.world import STILL

FLOOR = Body("floor", HalfSpace())
SIZE = (0.4, 0.3, 0.2)
QUADS = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def brick(cut=None):
    """A box as a mesh; its edge from (-x, -y, -z) to (x, -y, -z) may be cut at a distance from its first end [m]."""
    corners = [tuple(c) for c in (0.5 * np.array(SIZE) * np.array(list(combinations((-1.0, 1.0), repeat=3)))).tolist()]
    triangles = [t for a, b, c, d in QUADS for t in ((a, b, c), (a, c, d))]
    if cut is None:
        return Mesh(tuple(corners), tuple(triangles))
    corners.append((corners[0][0] + cut, *corners[0][1:]))
    halves = []
    for t in triangles:
        if {0, 4} <= set(t):  # both triangles at that edge become two
            k = next(k for k in range(3) if {t[k], t[(k + 1) % 3]} == {0, 4})
            a, b, c = t[k], t[(k + 1) % 3], t[(k + 2) % 3]
            halves += [(a, 8, c), (8, b, c)]
        else:
            halves.append(t)
    return Mesh(tuple(corners), tuple(halves))


def dropped(shape):
    """Where a body of this shape is after it has fallen on an edge and come to rest, and how many impacts that took."""
    q = tuple(about((0.0, 1.0, 0.0), 0.3).tolist())
    world = begin(Scene((FLOOR, Body("b", shape, 2.0, (0.0, 0.0, 0.4), q)), (Gravity(), Rotation(), Restitution(0.3),
                                                                            Resting())))  # fmt: skip
    advance(world, 0.25)
    return world.state()


@pytest.mark.parametrize("cut", [0.1, 1e-3, 1e-6])
def test_slivers_of_a_face_change_nothing(cut):
    """A vertex on an edge, as near to its end as 1e-6 m: the mesh moves like the box it is."""
    box, mesh = dropped(Box(SIZE)), dropped(brick(cut))
    assert mesh.x[1] == pytest.approx(box.x[1], abs=1e-11)
    assert mesh.v[1] == pytest.approx(box.v[1], abs=1e-10)
    assert mesh.w[1] == pytest.approx(box.w[1], abs=1e-9)


@pytest.mark.parametrize("cut", [None, 1e-6])
def test_a_mesh_with_a_sliver_rests_flat(cut):
    world = begin(Scene((FLOOR, Body("b", brick(cut), 2.0, (0.0, 0.0, 0.1))), (Gravity(), Rotation(), Resting())))
    advance(world, 1.0)
    assert world.mode[1] == STILL
    assert sum(h.force for h in world.forces) == pytest.approx(2.0 * 9.81, rel=1e-12)
    assert world.state().x[1] == pytest.approx((0.0, 0.0, 0.1), abs=1e-15)


@pytest.mark.parametrize(("change", "why"), [
    (lambda v, t: (v, [*t[1:], (t[0][0], t[0][1], t[0][1])]), "triangles"),  # a vertex named twice
    (lambda v, t: ([*v, v[0]], t), "repeated"),
    (lambda v, t: ([*v, (9.0, 9.0, 9.0)], t), "every vertex used"),
    (lambda v, t: (v, t[2:]), "open"),
    (lambda v, t: (v, [t[0][::-1], *t[1:]]), "winding"),
    (lambda v, t: (v, [x[::-1] for x in t]), "inverted"),
    (lambda v, t: ([(x, y, 0.0) for x, y, _ in v[:1]] + v[1:], []), "at least 4"),
    (lambda v, t: ([(x, y, np.nan) for x, y, _ in v], t), "vertices"),
])  # fmt: skip
def test_what_is_no_solid_is_refused_with_its_reason(change, why):
    good = brick()
    vertices, triangles = change(list(good.vertices), list(good.triangles))
    with pytest.raises(SceneError, match=why):
        Mesh(tuple(vertices), tuple(triangles), convex=False)


def test_a_triangle_without_area_is_refused():
    """A vertex on an edge of one face only, joined by a flat triangle: closed and oriented, but degenerate."""
    corners, triangles = list(brick().vertices), list(brick().triangles)
    corners.append(tuple(0.5 * (np.array(corners[0]) + np.array(corners[4]))))
    at = next(i for i, t in enumerate(triangles) if {0, 4} <= set(t))
    t = triangles[at]
    k = next(k for k in range(3) if {t[k], t[(k + 1) % 3]} == {0, 4})
    a, b, c = t[k], t[(k + 1) % 3], t[(k + 2) % 3]
    triangles[at : at + 1] = [(a, 8, c), (8, b, c), (a, b, 8)]
    with pytest.raises(SceneError, match="degenerate triangle"):
        Mesh(tuple(corners), tuple(triangles), convex=False)


@pytest.mark.parametrize("method", [LINEAR, CUBIC])
def test_a_field_at_a_ridge_and_on_a_node_has_one_finite_normal(method):
    """In the middle of a ball, where every direction is as good, and on nodes, from whichever cell they are taken."""
    low, high = np.full(3, -1.0), np.full(3, 1.0)
    field = sampled(lambda p: np.linalg.norm(p, axis=1) - 0.5, low, high, 16, method)
    gap, normal = field.gap_and_gradient(np.zeros(3))
    assert gap == pytest.approx(-0.5, abs=1e-14)
    assert np.isfinite(normal).all()
    assert np.abs(normal).max() <= 1.0 + 1e-12
    for node in np.array(list(combinations((-0.5, 0.25, 1.0), repeat=3))):
        beside = np.clip(node + 1e-13 * np.array(list(combinations((-1, 1), repeat=3))), low, high)
        assert field.gap(beside) == pytest.approx(np.full(8, float(field.gap(node))), abs=1e-12)
