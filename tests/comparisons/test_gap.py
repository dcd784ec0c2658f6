"""Gaps from poses: closed forms, an exact library for meshes, and the hull of the Minkowski difference."""

import fcl
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from comparisons import penetration
from comparisons.convex import polytope
from comparisons.gap import Pose, bounded_gap, gap, overlaps, surface_distance, unmeasurable
from mechanics.effects import Resting, Rotation
from mechanics.rotation import about, product, rotate
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, Capsule, Cylinder, HalfSpace, Mesh, Sphere
from mechanics.trajectory import Trajectory

EXACT = 1e-12  # [m], of bodies of about 1 m: thousands of roundings
UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])
seeds = st.integers(0, 2**32 - 1)


def hull_mesh(count, seed=1):
    """Convex mesh of `count` points on a ball of radius 1."""
    points = np.random.default_rng(seed).normal(size=(count, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    hull = ConvexHull(points)
    triangles = []
    for corners, plane in zip(hull.simplices, hull.equations, strict=True):
        a, b, c = points[corners]
        outward = np.cross(b - a, c - a) @ plane[:3] > 0.0
        triangles.append(tuple(int(i) for i in (corners if outward else corners[::-1])))
    return Mesh(tuple(map(tuple, points.tolist())), tuple(triangles)).centred()


SOLIDS = (Box((1.0, 0.4, 0.7)), Box((0.3, 0.3, 2.0)), Box((1.0, 1.0, 1.0)), hull_mesh(12), hull_mesh(30))
EVERY = (*SOLIDS, Sphere(0.4), Capsule(0.2, 0.9), Cylinder(0.3, 0.5))


def random_pose(rng, spread, count=1):
    q = rng.normal(size=(count, 4))
    return Pose(spread * rng.normal(size=(count, 3)), q / np.linalg.norm(q, axis=1, keepdims=True))


def surface(triangles, pose):
    """The triangles as a body of the library, posed."""
    model = fcl.BVHModel()
    points = triangles.reshape(-1, 3)
    model.beginModel(len(triangles), len(points))
    model.addSubModel(points, np.arange(len(points)).reshape(-1, 3))
    model.endModel()
    return fcl.CollisionObject(model, fcl.Transform(pose.q[0], pose.x[0]))


def library_distance(triangles_a, pose_a, triangles_b, pose_b):
    """Distance of two surfaces; not positive if they cross."""
    objects = (surface(triangles_a, pose_a), surface(triangles_b, pose_b))
    return fcl.distance(*objects, fcl.DistanceRequest(), fcl.DistanceResult())


def hull_depth(points_a, points_b):
    """Shortest translation that parts two hulls: the distance of 0 from the rim of their Minkowski difference."""
    difference = (points_a[:, None] - points_b[None]).reshape(-1, 3)
    return -ConvexHull(difference).equations[:, 3].max()


def corners(shape, pose):
    return rotate(pose.q, polytope(shape).vertices) + pose.x


@given(seeds)
def test_overlap_depth_of_polytopes_is_the_minkowski_depth(seed):
    rng = np.random.default_rng(seed)
    a, b = (SOLIDS[i] for i in rng.integers(len(SOLIDS), size=2))
    pose_a, pose_b = random_pose(rng, 0.5), random_pose(rng, 0.5)
    found = gap(a, b, pose_a, pose_b)[0]
    true = library_distance(polytope(a).triangles, pose_a, polytope(b).triangles, pose_b)
    if found < 0.0:
        assert -found == pytest.approx(hull_depth(corners(a, pose_a), corners(b, pose_b)), abs=EXACT)
    else:
        assert 0.0 < found <= true + EXACT


@given(seeds)
def test_distance_of_a_point_from_a_solid_is_the_librarys(seed):
    rng = np.random.default_rng(seed)
    solid, pose, point = SOLIDS[rng.integers(len(SOLIDS))], random_pose(rng, 0.3), 1.5 * rng.normal(size=(1, 3))
    distance, normal = surface_distance(solid, pose, point)
    origin = Pose(np.zeros((1, 3)), UPRIGHT[None])
    if distance[0] > 0.0:
        true = library_distance(np.repeat(point, 3, axis=0)[None], origin, polytope(solid).triangles, pose)
        assert distance[0] == pytest.approx(true, abs=EXACT)
        # a step along the normal takes the point away at the same rate
        further = surface_distance(solid, pose, point + 0.1 * normal)[0]
        assert further - distance == pytest.approx(0.1, abs=EXACT)
    else:
        assert -distance[0] == pytest.approx(hull_depth(corners(solid, pose), point), abs=EXACT)


@given(seeds)
def test_capsule_against_polytope_and_capsule(seed):
    rng = np.random.default_rng(seed)
    capsule, pose = Capsule(0.2, rng.uniform(0.1, 2.0)), random_pose(rng, 0.8)
    half = rotate(pose.q, np.array([0.0, 0.0, 0.5 * capsule.length]))
    axis = np.stack([pose.x - half, pose.x + half, pose.x + half], axis=1)
    origin = Pose(np.zeros((1, 3)), UPRIGHT[None])
    solid, other = SOLIDS[rng.integers(len(SOLIDS))], random_pose(rng, 0.3)
    found = gap(solid, capsule, other, pose)[0] + capsule.radius
    if found > 0.0:
        assert found == pytest.approx(library_distance(axis, origin, polytope(solid).triangles, other), abs=EXACT)
    else:
        assert -found == pytest.approx(hull_depth(axis[0, :2], corners(solid, other)), abs=EXACT)
    second = Capsule(0.3, 0.7)
    parallel = Pose(other.x, pose.q if seed % 2 else other.q)
    half = rotate(parallel.q, np.array([0.0, 0.0, 0.35]))
    line = np.stack([parallel.x - half, parallel.x + half, parallel.x + half], axis=1)
    distance = max(library_distance(axis, origin, line, origin), 0.0)
    assert gap(capsule, second, pose, parallel)[0] == pytest.approx(distance - 0.5, abs=EXACT)


@pytest.mark.parametrize("tilt", [0.0, *(10.0**-k for k in range(3, 16))])
@pytest.mark.parametrize("axis", [(0.0, 1.0, 0.0), (1.0, 1.0, 0.0), (0.3, 1.0, 0.2)])
def test_nearly_parallel_boxes(tilt, axis):
    """A box tilted a little and sunk 1 mm into a large one: its lowest corner decides, whatever the tilt."""
    size, q = np.array([0.4, 0.5, 0.2]), about(axis, tilt)
    lowest = 0.5 * np.abs(rotate(np.array([q[0], *-q[1:]]), np.array([0.0, 0.0, 1.0]))) @ size
    height = lowest - 1e-3
    pose, floor = Pose(np.array([[0.1, 0.2, height]]), q[None]), Pose(np.array([[0.0, 0.0, -1.0]]), UPRIGHT[None])
    box, mesh = Box(tuple(size)), _as_mesh(Box(tuple(size)))
    for solid in (box, mesh):
        assert gap(solid, Box((10.0, 10.0, 2.0)), pose, floor)[0] == pytest.approx(-1e-3, abs=EXACT)
    plane = Pose(np.zeros((1, 3)), UPRIGHT[None])
    assert gap(box, HalfSpace(), pose, plane)[0] == pytest.approx(-1e-3, abs=EXACT)


def _as_mesh(box):
    vertices = polytope(box).vertices
    numbers = {tuple(v): i for i, v in enumerate(vertices.tolist())}
    triangles = tuple(tuple(numbers[tuple(c)] for c in t) for t in polytope(box).triangles.tolist())
    return Mesh(tuple(map(tuple, vertices.tolist())), triangles)


@given(seeds)
def test_a_box_and_the_same_mesh_have_the_same_gap(seed):
    rng = np.random.default_rng(seed)
    box, other = SOLIDS[0], EVERY[rng.integers(len(EVERY))]
    if unmeasurable(box, other):
        other = SOLIDS[1]
    pose, place = random_pose(rng, 0.4), random_pose(rng, 0.4)
    with_box, with_mesh = gap(box, other, pose, place), gap(_as_mesh(box), other, pose, place)
    assert with_mesh == pytest.approx(with_box, abs=EXACT)


@given(seeds)
def test_gap_is_symmetric_and_does_not_mind_where_the_bodies_are(seed):
    rng = np.random.default_rng(seed)
    a, b = (EVERY[i] for i in rng.integers(len(EVERY), size=2))
    if unmeasurable(a, b):
        return
    pose_a, pose_b, move = random_pose(rng, 0.5, 7), random_pose(rng, 0.5, 7), random_pose(rng, 3.0)
    first = gap(a, b, pose_a, pose_b)
    signs = np.sign(first)
    swapped = gap(b, a, pose_b, pose_a)
    moved = gap(a, b, *(Pose(move.x + rotate(move.q, p.x), product(move.q, p.q)) for p in (pose_a, pose_b)))
    for other in (swapped, moved):
        assert (np.sign(other) == signs).all()
        assert other[first < 0.0] == pytest.approx(first[first < 0.0], abs=EXACT)


@given(seeds)
def test_a_half_space_touches_the_lowest_point(seed):
    rng = np.random.default_rng(seed)
    shape, pose, plane = EVERY[rng.integers(len(EVERY))], random_pose(rng, 1.0), random_pose(rng, 0.2)
    normal = rng.normal(size=3)
    wall = HalfSpace(tuple(normal))
    n = rotate(plane.q[0], np.array(wall.normal))
    points = _cloud(shape, rng)
    sampled = ((rotate(pose.q, points) + pose.x - plane.x) @ n).min()
    found = gap(shape, wall, pose, plane)[0]
    # the cloud lies on the surface, so its lowest point is above the true one and close to it
    assert found - EXACT <= sampled <= found + (EXACT if shape in SOLIDS else 2e-3)


def _cloud(shape, rng):
    if shape in SOLIDS:
        return polytope(shape).vertices
    directions = rng.normal(size=(20_000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    if isinstance(shape, Sphere):
        return shape.radius * directions
    ends = 0.5 * shape.length * np.sign(directions[:, 2:]) * [0.0, 0.0, 1.0]
    if isinstance(shape, Capsule):
        return shape.radius * directions + ends
    rim = directions[:, :2] / np.linalg.norm(directions[:, :2], axis=1, keepdims=True)
    return np.concatenate([shape.radius * rim, np.zeros((len(rim), 1))], axis=1) + ends


def test_spheres():
    at = np.array([[0.0, 0.0, 3.0], [0.0, 1.0, 0.0], [0.1, 0.0, 0.0]])
    poses = Pose(at, np.repeat(UPRIGHT[None], 3, axis=0)), Pose(np.zeros((3, 3)), np.repeat(UPRIGHT[None], 3, axis=0))
    assert gap(Sphere(0.5), Sphere(1.0), *poses) == pytest.approx([1.5, -0.5, -1.4], abs=EXACT)
    # beside a cylinder, above its lid, beyond its rim
    at = np.array([[1.0, 0.0, 0.1], [0.1, 0.0, 1.0], [0.6, 0.0, 0.65]])
    poses = Pose(at, poses[0].q), poses[1]
    assert gap(Sphere(0.1), Cylinder(0.3, 0.5), *poses) == pytest.approx([0.6, 0.65, 0.4], abs=EXACT)


@given(seeds)
def test_far_bodies_get_a_positive_lower_bound_and_near_ones_the_gap(seed):
    rng = np.random.default_rng(seed)
    a, b = SOLIDS[rng.integers(len(SOLIDS))], EVERY[rng.integers(5, 7)]
    pose_a, pose_b = random_pose(rng, 1.2, 9), random_pose(rng, 1.2, 9)
    bound, exact = bounded_gap(a, b, pose_a, pose_b), gap(a, b, pose_a, pose_b)
    assert (bound <= exact + EXACT).all()
    assert (np.sign(bound) == np.sign(exact)).all()
    assert bound[exact < 0.0] == pytest.approx(exact[exact < 0.0], abs=EXACT)


def test_what_cannot_be_measured_is_named():
    dented = Mesh(
        ((0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (1, 1, 0.2), (1, 1, 2)),
        ((0, 4, 1), (1, 4, 2), (2, 4, 3), (3, 4, 0), (0, 1, 5), (1, 2, 5), (2, 3, 5), (3, 0, 5)),
        convex=False,
    )
    assert "Cylinder and Box" in unmeasurable(Cylinder(1.0, 1.0), Box((1.0, 1.0, 1.0)))
    assert "Mesh that is not convex" in unmeasurable(Sphere(1.0), dented)
    assert unmeasurable(dented, HalfSpace()) is None
    pose = Pose(np.zeros((1, 3)), UPRIGHT[None])
    with pytest.raises(ValueError, match="Cylinder"):
        gap(Cylinder(1.0, 1.0), Box((1.0, 1.0, 1.0)), pose, pose)


def _two_boxes(sunk):
    lower = Body("lower", Box((1.0, 1.0, 1.0)), mass=1.0, position=(0.0, 0.0, 0.5))
    upper = Body("upper", Box((0.5, 0.5, 0.5)), mass=1.0, position=(0.1, 0.0, 1.25 - sunk))
    return Scene((Body("floor", HalfSpace()), lower, upper), (Resting(), Rotation()))


@pytest.mark.parametrize("sunk", [1e-3, 1e-6, 1e-11, 0.0, -1e-3])
def test_overlapping_starts(sunk):
    found = overlaps(_two_boxes(sunk))
    if sunk > 1e-9:
        assert [(o.a, o.b) for o in found] == [("lower", "upper")]
        assert found[0].depth == pytest.approx(sunk, abs=EXACT)
    else:
        assert found == ()


def test_penetration_finds_depth_pair_and_time(case_of, moved, values):
    scene = _two_boxes(0.0)
    t = np.linspace(0.0, 1.0, 101)
    bump = np.where(np.arange(101) == 37, 1e-3, 0.0)
    path = np.array([0.1, 0.0, 1.25]) - np.outer(bump, [0.0, 0.0, 1.0])
    found = values(penetration, case_of(scene, moved(scene, t, x_upper=path)))["penetration"]
    assert found.value == pytest.approx(1e-3, abs=EXACT)
    assert (found.time, found.text) == (t[37], "lower and upper")


@settings(max_examples=5)
@given(seeds)
def test_the_order_of_the_bodies_does_not_matter(case_of, seed):
    rng = np.random.default_rng(seed)
    pose = random_pose(rng, 0.6, len(EVERY))
    bodies = [
        Body(f"b{i}", s, mass=1.0, position=tuple(pose.x[i]), orientation=tuple(pose.q[i])) for i, s in enumerate(EVERY)
    ]
    depths = []
    for order in (np.arange(len(bodies)), rng.permutation(len(bodies))):
        scene = Scene(tuple(bodies[i] for i in order), (Resting(), Rotation()))
        case = case_of(scene, Trajectory.of([scene.start()]))
        depths.append(next(iter(penetration.measure(case))).value)
    assert depths[0] == pytest.approx(depths[1], abs=EXACT)


def test_many_poses_in_one_call_give_what_many_calls_give():
    rng = np.random.default_rng(3)
    pose_a, pose_b = random_pose(rng, 0.4, 200), random_pose(rng, 0.4, 200)
    together = gap(SOLIDS[3], SOLIDS[4], pose_a, pose_b)
    one_by_one = [gap(SOLIDS[3], SOLIDS[4], pose_a.at(rows), pose_b.at(rows))[0] for rows in np.arange(200)[:, None]]
    assert together == pytest.approx(one_by_one, abs=EXACT)
