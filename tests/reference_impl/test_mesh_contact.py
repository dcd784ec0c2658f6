"""Meshes in contact: the whole contact set, degenerate positions, the same motion as boxes, first contacts."""

import math
from itertools import product as combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mechanics.arrays import SceneError
from mechanics.effects import Gravity, Resting, Restitution, Rotation
from mechanics.rotation import about, matrix, normalised, product
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, Capsule, HalfSpace, Mesh, Sphere
from reference_impl.collide.detect import kinematics, rotations
from reference_impl.collide.mesh_distance import mesh_distance
from reference_impl.errors import Overlap
from reference_impl.simulate import advance, begin, simulate

STRAIGHT = (1.0, 0.0, 0.0, 0.0)
QUADS = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
FLOOR = Body("floor", HalfSpace())


def brick(size, convex=True):
    """A box as a mesh of twelve triangles."""
    corners = 0.5 * np.array(size) * np.array(list(combinations((-1.0, 1.0), repeat=3)))
    triangles = [t for a, b, c, d in QUADS for t in ((a, b, c), (a, c, d))]
    return Mesh(tuple(map(tuple, corners.tolist())), tuple(triangles), convex)


def notch(width=1.0):
    """An L-shaped prism along y: floor z = 0 for x > 0 beside a wall x = 0 up to z = 1."""
    outline = [(0.0, 0.0), (0.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0), (1.0, 0.0)]
    n = len(outline)
    vertices = [(x, y, z) for y in (-width, width) for x, z in outline]
    caps = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]
    sides = [t for i in range(n) for j in [(i + 1) % n] for t in ((i, i + n, j), (j, i + n, j + n))]
    triangles = caps + [(a + n, c + n, b + n) for a, b, c in caps] + sides
    corners = np.array(vertices)[np.array(triangles)]
    if np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) < 0.0:
        triangles = [(a, c, b) for a, b, c in triangles]
    return Mesh(tuple(vertices), tuple(triangles), convex=False)


def hull(points):
    """Convex mesh around points."""
    from scipy.spatial import ConvexHull

    made = ConvexHull(points)
    number = {v: k for k, v in enumerate(made.vertices.tolist())}
    corners = points[made.simplices]
    turn = np.einsum("ij,ij->i", np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]),
                     made.equations[:, :3]) < 0.0  # fmt: skip
    triangles = [[number[v] for v in t] for t in made.simplices.tolist()]
    triangles = [(a, c, b) if flip else (a, b, c) for (a, b, c), flip in zip(triangles, turn, strict=True)]
    return Mesh(tuple(map(tuple, points[made.vertices].tolist())), tuple(triangles)).centred()


def contacts(a, b):
    """Contacts of two bodies: kind, normal towards a, point, gap."""
    world = begin(Scene((a, b), (Rotation(), Restitution(1.0))))
    m = world.motion
    found = world.detector.contacts(m.x, rotations(m.q), np.ones(2, dtype=bool))
    k = kinematics(found, m.x, rotations(m.q), np.zeros_like(m.v), np.zeros_like(m.v))
    sign = np.where(found.kinds[:, 0] == 0, 1.0, -1.0)[:, None]
    return found.kinds[:, 2], sign * k.normal, k.point, k.gap


def places(point):
    return sorted(tuple(round(float(c), 9) + 0.0 for c in p) for p in point)


def above(shape, place, q=STRAIGHT, under=None):
    """Contacts of a moving body over the unit cube, or over `under`."""
    return contacts(
        Body("a", shape, 1.0, place, tuple(float(c) for c in q)), Body("b", under or brick((1, 1, 1)), None)
    )


@pytest.mark.parametrize("tilt", [0.0, 1e-14, 1e-12, 1e-10])
@pytest.mark.parametrize("shape", [brick((1, 1, 1)), Box((1.0, 1.0, 1.0)), brick((1, 1, 1), convex=False)])
def test_coplanar_faces_touch_at_four_corners(tilt, shape):
    _, n, point, gap = above(shape, (0, 0, 1.0), about((1.0, 2.0, 0.0), tilt))
    assert len(gap) == 4
    assert np.abs(gap).max() <= 2.0 * tilt + 1e-15
    assert np.abs(n - (0, 0, 1)).max() <= 2.0 * tilt + 1e-15
    assert places(point)[0] == (-0.5, -0.5, 0.5)


@pytest.mark.parametrize("shape", [brick((1, 1, 1)), Box((1.0, 1.0, 1.0)), brick((1, 1, 1), convex=False)])
def test_faces_that_overlap_touch_at_the_corners_of_their_common_polygon(shape):
    _, _, point, gap = above(shape, (0, 0, 1.0), about((0.0, 0.0, 1.0), 0.3))
    assert len(set(places(point))) == 8
    assert np.abs(gap).max() < 1e-15
    _, _, point, _ = above(shape, (0.3, 0.2, 1.0))
    assert places(point) == [(-0.2, -0.3, 0.5), (-0.2, 0.5, 0.5), (0.5, -0.3, 0.5), (0.5, 0.5, 0.5)]
    _, _, point, _ = above(brick((4, 4, 0.2)), (0, 0, 0.6), under=shape)
    assert places(point) == [(x, y, 0.5) for x in (-0.5, 0.5) for y in (-0.5, 0.5)]


def test_an_edge_on_a_face_touches_at_its_ends_or_where_it_leaves():
    q, height = about((0.0, 1.0, 0.0), math.pi / 4), 0.5 + math.sqrt(0.5)
    for length, end in ((1.4, 0.5), (0.6, 0.3)):
        _, n, point, _ = above(brick((1, length, 1)), (0, 0, height), q)
        assert places(point) == [(0.0, -end, 0.5), (0.0, end, 0.5)]
        assert np.abs(n - (0, 0, 1)).max() < 1e-15


UPRIGHT = product(about((0.0, 1.0, 0.0), -math.atan(math.sqrt(0.5))), about((1.0, 0.0, 0.0), math.pi / 4))


@pytest.mark.parametrize("place", [(0.1, 0.2), (0.0, 0.0), (0.25, -0.25), (0.5, 0.2), (0.5, 0.5)])
def test_a_corner_touches_once_wherever_it_stands(place):
    """In a face, on the cut between its triangles, on an edge of the body below, on its corner."""
    _, n, point, gap = above(brick((1, 1, 1)), (*place, 0.5 + math.sqrt(0.75)), UPRIGHT)
    assert places(point) == [(*place, 0.5)]
    assert abs(gap[0]) < 1e-15
    assert n[0, 2] > 0.5


def test_crossing_edges_and_parallel_edges():
    ridge = tuple(about((0.0, 1.0, 0.0), math.pi / 4))
    low = Body("b", brick((1, 1, 1)), None, orientation=ridge)
    across = tuple(product(about((0.0, 0.0, 1.0), math.pi / 2), np.array(ridge)))
    _, n, point, _ = contacts(Body("a", brick((1, 1, 1)), 1.0, (0, 0, math.sqrt(2.0)), across), low)
    assert places(point) == [(0.0, 0.0, round(math.sqrt(0.5), 9))]
    assert np.abs(n - (0, 0, 1)).max() < 1e-15
    _, _, point, _ = contacts(Body("a", brick((1, 0.4, 1)), 1.0, (0, 0, math.sqrt(2.0)), ridge), low)
    assert places(point) == [(0.0, y, round(math.sqrt(0.5), 9)) for y in (-0.2, 0.2)]


def test_a_notch_holds_from_two_sides():
    """Every contact of a cube in the corner of an L, with both normals at the concave edge."""
    _, n, _, gap = above(brick((0.5, 0.5, 0.5)), (0.25, 0, 0.25), under=notch())
    assert np.abs(gap).max() < 1e-15
    assert {tuple(np.round(v, 9) + 0.0) for v in n} == {(0.0, 0.0, 1.0), (1.0, 0.0, 0.0)}
    for normal, count in (((0, 0, 1), 4), ((1, 0, 0), 4)):
        assert (np.abs(n - normal).max(axis=1) < 1e-12).sum() == count
    # the same by a ball, which touches both walls at once
    _, n, _, _ = above(Sphere(0.2), (0.2, 0.1, 0.2), under=notch())
    assert {tuple(np.round(v, 9) + 0.0) for v in n} == {(0.0, 0.0, 1.0), (1.0, 0.0, 0.0)}


@pytest.mark.parametrize("tilt", [0.0, 1e-14, 1e-12, 1e-9, 1e-6, 1e-3])
@pytest.mark.parametrize(("scale", "offset"), [(1.0, 0.0), (1e-6, 0.0), (1e6, 0.0), (1.0, 1e8)])
def test_the_separation_of_nearly_parallel_faces(tilt, scale, offset):
    """A tilted cube over another: the gap of its lowest corner in closed form."""
    gap, c, s = 1e-3, math.cos(tilt), math.sin(tilt)
    far = np.array((offset, -offset, 0.0))
    height = (0.5 + gap + 0.5 * (c + s)) * scale
    q = tuple(about((0.0, 1.0, 0.0), tilt))
    size = 3 * (scale,)
    a = Body("a", brick(size), 1.0, (offset, -offset, height), q)
    world = begin(Scene((a, Body("b", brick(size), None, tuple(far.tolist()))), (Rotation(), Restitution(1.0))))
    found, _ = world.detector.gap(0, 0.0, world.motion)
    assert found == pytest.approx(gap * scale, abs=2e-15 * scale)


def pair(kinds, seed):
    """Two turning bodies on their way to each other, as boxes (b) or meshes (m)."""
    rng = np.random.default_rng(seed)
    q, sizes, spins = normalised(rng.normal(size=(2, 4))), rng.uniform(0.2, 0.6, (2, 3)), 4.0 * rng.normal(size=(2, 3))
    make = {"b": lambda size: Box(tuple(size.tolist())), "m": brick}
    a, b = (make[kind](size) for kind, size in zip(kinds, sizes, strict=True))
    first = Body("a", a, 1.0, (-1.0, 0.0, 0.0), tuple(q[0].tolist()), (2.0, 0.0, 0.0), tuple(spins[0].tolist()))
    second = Body("b", b, 2.0, (1.0, 0.05, -0.05), tuple(q[1].tolist()), (-2.0, 0.1, 0.0), tuple(spins[1].tolist()))
    return Scene((first, second), (Rotation(), Restitution(1.0)))


@pytest.mark.parametrize("seed", range(6))
def test_a_mesh_moves_like_the_box_it_is(seed):
    worlds = [begin(pair(kinds, seed)) for kinds in ("bb", "bm", "mm")]
    for world in worlds:
        advance(world, 0.6)
    box = worlds[0]
    assert box.events
    for world in worlds[1:]:
        assert [e.time for e in world.events] == pytest.approx([e.time for e in box.events], rel=1e-14)
        assert np.abs(world.state().x - box.state().x).max() < 1e-12
        assert np.abs(world.state().w - box.state().w).max() < 1e-11


@pytest.mark.parametrize("under", [brick((1.0, 1.0, 0.2)), Box((1.0, 1.0, 0.2))])
def test_a_stack_of_meshes_rests_and_carries_its_weight(under):
    low = Body("low", under, 3.0, (0.0, 0.0, 0.1))
    top = Body("top", brick((0.4, 0.4, 0.4)), 2.0, (0.1, 0.05, 0.4))
    world = begin(Scene((FLOOR, low, top), (Gravity(), Rotation(), Restitution(0.5), Resting())))
    advance(world, 10.0)
    assert world.audit.rests == 2
    assert np.abs(world.state().x[1:] - ((0, 0, 0.1), (0.1, 0.05, 0.4))).max() < 1e-15
    for names, load in (((0, 1), 5.0), ((1, 2), 2.0)):
        total = sum(h.force for h in world.forces if {h.a, h.b} == set(names))
        assert total == pytest.approx(9.81 * load, rel=1e-13)


def test_a_ball_rolls_over_the_cuts_of_a_face_as_over_a_box():
    """Flat edges inside a face are none: the same path as on a box, across the diagonal."""
    paths = []
    for under in (Box((2.0, 2.0, 0.2)), brick((2.0, 2.0, 0.2))):
        ball = Body("ball", Sphere(0.1), 1.0, (-0.5, 0.2, 0.1), velocity=(0.7, -0.3, 0.0))
        scene = Scene(
            (Body("table", under, None, (0, 0, -0.1)), ball), (Gravity(), Rotation(), Restitution(0.5), Resting())
        )
        paths.append(simulate(scene, np.linspace(0.0, 1.5, 7)).x[:, 1])
    assert np.abs(paths[0] - paths[1]).max() < 1e-12
    assert paths[1][-1] == pytest.approx((-0.5 + 1.05, 0.2 - 0.45, 0.1), abs=1e-12)


def test_a_ball_leaves_a_table_at_its_edge():
    """It rolls over the edge of a mesh as over that of a box."""
    states = []
    for under in (Box((1.0, 1.0, 0.2)), brick((1.0, 1.0, 0.2))):
        ball = Body("ball", Sphere(0.1), 1.0, (0.3, 0.0, 0.1), velocity=(0.5, 0.0, 0.0))
        scene = Scene(
            (Body("table", under, None, (0, 0, -0.1)), ball), (Gravity(), Rotation(), Restitution(0.5), Resting())
        )
        states.append(simulate(scene, np.linspace(0.0, 0.8, 9)).x[:, 1])
    assert states[0][-1, 2] < 0.0
    assert np.abs(states[0] - states[1]).max() < 1e-9


ROCKS = {
    "rocks": lambda rng: (hull(rng.normal(size=(12, 3)) * 0.25), hull(rng.normal(size=(12, 3)) * 0.25)),
    "notch": lambda rng: (notch(0.6).centred(), hull(rng.normal(size=(8, 3)) * 0.2)),
    "capsule": lambda rng: (notch(0.6).centred(), Capsule(0.1, 0.5)),
}


@settings(max_examples=6, deadline=None)
@given(st.integers(0, 100_000), st.sampled_from(sorted(ROCKS)))
def test_no_first_contact_of_tumbling_meshes_is_passed(seed, name):
    """Until the first impact no point of one is within the other; there they touch, and energy and momentum stay."""
    rng = np.random.default_rng(seed)
    shapes = ROCKS[name](rng)
    q, spins = normalised(rng.normal(size=(2, 4))), 6.0 * rng.normal(size=(2, 3))
    bodies = tuple(
        Body(n, shape, mass, (x, 0.0, 0.0), tuple(turn.tolist()), (-x, 0.0, 0.0), tuple(spin.tolist()))
        for n, shape, mass, x, turn, spin in zip("ab", shapes, (1.0, 2.0), (-1.5, 1.5), q, spins, strict=True)
    )
    world = begin(Scene(bodies, (Rotation(), Restitution(1.0))))
    while not world.events and world.t < 2.0:
        advance(world, 0.1)
    end = world.events[0].time if world.events else 2.0
    free = simulate(Scene(bodies, (Rotation(),)), np.linspace(0.0, end, 200))
    deepest = [_deepest(shapes, x, turn) for x, turn in zip(free.x[::2], free.q[::2], strict=True)]
    assert min(deepest) > -1e-12
    if world.events:
        gap, rate = world.detector.gap(0, end, begin_at(bodies, end))
        assert abs(gap) < 1e-12
        assert rate < 0.0


def begin_at(bodies, end):
    """Flight of the bodies alone, which goes on through each other, up to `end`."""
    world = begin(Scene(bodies, (Rotation(),)))
    advance(world, end)
    world.arrive()
    return world.motion


def _deepest(shapes, x, q):
    """Least distance of a vertex (or point of a capsule's axis) of one body from the surface of the other."""
    least = math.inf
    for i, j in ((0, 1), (1, 0)):
        if isinstance(shapes[j], Capsule):
            continue
        if isinstance(shapes[i], Capsule):
            along = np.linspace(-0.5, 0.5, 41) * shapes[i].length
            points, radius = np.stack([0 * along, 0 * along, along], axis=1), shapes[i].radius
        else:
            points, radius = np.array(shapes[i].vertices), 0.0
        world = points @ matrix(q[i]).T + x[i]
        least = min(least, float(mesh_distance(shapes[j])((world - x[j]) @ matrix(q[j])).min()) - radius)
    return least


@pytest.mark.parametrize(("inner", "place"), [
    (brick((0.2, 0.2, 0.2)), (0.0, 0.0, 0.0)), (Sphere(0.1), (0.2, 0.0, 0.0)),
    (brick((0.2, 3.0, 0.2)), (0.3, 0.0, 0.3)),
    (Capsule(0.1, 0.3), (0.0, 0.2, 0.0)), (brick((1, 1, 1)), (0.9, 0.9, 0.9)),
])  # fmt: skip
def test_bodies_in_each_other_are_refused(inner, place):
    """Within, through, and corner in corner."""
    with pytest.raises(Overlap, match=r"'a' and 'b'|'b' and 'a'"):
        above(inner, place)


def test_a_hole_is_not_inside():
    _, n, _, _ = above(brick((0.5, 0.5, 0.5)), (0.4, 0.0, 0.25), under=notch())
    assert np.abs(n - (0, 0, 1)).max() < 1e-15


def test_meshes_that_are_no_solid_are_refused_with_the_reason():
    good = brick((1, 1, 1))
    flat = (*good.vertices, (0.5, 0.0, 1e-12 - 0.5))
    split = [t for t in good.triangles if set(t) != {4, 6, 7}]
    for vertices, triangles, why in (
        (good.vertices, good.triangles[1:], "open"),
        (good.vertices, [(a, c, b) for a, b, c in good.triangles], "inverted"),
        (good.vertices, (*good.triangles, good.triangles[0]), "manifold"),
        ((*good.vertices[:7], good.vertices[0]), good.triangles, "repeated"),
        (flat, [*split, (4, 6, 8), (6, 7, 8), (7, 4, 8)], "sliver"),
    ):
        with pytest.raises(SceneError, match=why):
            Mesh(tuple(vertices), tuple(triangles), convex=False)
    # two tetrahedra with one vertex in common
    points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (-1, 0, 0), (0, -1, 0), (0, 0, -1)]
    one = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
    other = [tuple((0, 4, 5, 6)[k] for k in t[::-1]) for t in one]
    with pytest.raises(SceneError, match="two parts"):
        Mesh(tuple(points), tuple(one + other), convex=False)
