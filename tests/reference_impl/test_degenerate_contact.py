"""Degenerate positions: what touches is listed whole and once, whatever coincides."""

from itertools import product

import numpy as np
import pytest

from mechanics.effects import Force, Gravity, Resting, Restitution, Rotation
from mechanics.rotation import about, matrix
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Sphere
from reference_impl.collide.detect import kinematics, rotations
from reference_impl.errors import Overlap
from reference_impl.settings import Settings
from reference_impl.simulate import advance, begin, simulate
from reference_impl.world import STILL

FLOOR = Body("floor", HalfSpace())


def touches(*bodies):
    """Points (m, 3) and normals of all contacts of these bodies as they stand [m]."""
    world = begin(Scene(bodies, (Resting(), Rotation())))
    rotation = rotations(world.motion.q)
    found = world.detector.contacts(world.motion.x, rotation, np.ones(len(bodies), dtype=bool))
    k = kinematics(found, world.motion.x, rotation, world.motion.v, world.motion.v)
    return k.point, k.normal


@pytest.mark.parametrize("swapped", [False, True])
@pytest.mark.parametrize(("hx", "hy"), [(0.2, 0.2), (0.2, 0.25), (0.25, 0.25)])
def test_boxes_face_to_face_touch_at_the_corners_of_their_common_rectangle(hx, hy, swapped):
    """Borders that coincide on none, one, two, three or four sides; a common edge; a common corner."""
    lower = Body("a", Box((2.0 * hx, 2.0 * hy, 0.2)), 1.0, (0.0, 0.0, 0.1))
    for gx, gy, x, y in product((0.2, 0.25, 0.5), (0.2, 0.25), (0.0, 0.05, 0.25, 0.45), (0.0, 0.05, 0.4, 0.45)):
        upper = Body("b", Box((2.0 * gx, 2.0 * gy, 0.4)), 1.0, (x, y, 0.4))
        low, high = (max(-hx, x - gx), max(-hy, y - gy)), (min(hx, x + gx), min(hy, y + gy))
        if high[0] - low[0] < -1e-12 or high[1] - low[1] < -1e-12:
            continue
        points, normals = touches(*((upper, lower) if swapped else (lower, upper)))
        expected = {(round(p, 9), round(q, 9)) for p in (low[0], high[0]) for q in (low[1], high[1])}
        found = [(round(p, 9), round(q, 9)) for p, q, _ in points.tolist()]
        assert sorted(found) == sorted(expected), (gx, gy, x, y)
        assert np.abs(np.abs(normals[:, 2]) - 1.0).max() == 0.0


def load(world):
    """Sum of the contact forces on the named bodies from below [N]."""
    return sum(h.force * abs(h.normal[2]) for h in world.forces)


def box(name, size, position, mass=1.0, **told):
    return Body(name, Box(size), mass, position, **told)


STANDING = {
    "a needle on its end": ((box("b", (1e-3, 1e-3, 1.0), (0.0, 0.0, 0.5)),), 1.0),
    "a stack without gravity": (tuple(box(f"b{i}", (0.4, 0.4, 0.2), (0.0, 0.0, 0.1 + 0.2 * i)) for i in range(3)), 0.0),
    "bricks half across each other": (
        (box("b0", (0.5, 0.25, 0.1), (0.0, 0.0, 0.05)), box("b1", (0.5, 0.25, 0.1), (0.5, 0.0, 0.05)),
         box("b2", (0.5, 0.25, 0.1), (0.25, 0.0, 0.15), 3.0)), 5.0,
    ),
    "a box of a micrometre": ((box("b", (1e-6, 1e-6, 1e-6), (0.0, 0.0, 0.5e-6), 1e-15),), 1e-15),
    "a box of a thousand kilometres": ((box("b", (1e6, 1e6, 1e6), (0.0, 0.0, 0.5e6), 1e12),), 1e12),
}  # fmt: skip


@pytest.mark.parametrize("name", STANDING)
def test_what_stands_stays_where_it_stands(name):
    """For ten seconds, bit by bit or to the rounding of the size; its supports carry the weight of it all."""
    bodies, mass = STANDING[name]
    gravity = Gravity() if mass else Gravity((0.0, 0.0, 0.0))
    world = begin(Scene((FLOOR, *bodies), (gravity, Rotation(), Resting(), Restitution(0.5))))
    start = world.state()
    advance(world, 10.0)
    end = world.state()
    size = min(min(b.shape.size) for b in bodies)
    assert np.abs(end.x - start.x).max() <= 1e-14 * size
    assert not end.v.any()
    floor = sum(h.force for h in world.forces if 0 in (h.a, h.b))
    assert floor == pytest.approx(9.81 * mass, rel=1e-12, abs=0.0)


@pytest.mark.parametrize("offset", [-1e-3, 1e-3])
def test_a_box_over_an_edge_stands_or_tips_by_where_its_middle_is(offset):
    """On a table that ends at x = 0: within, it stays; beyond, it turns over the edge."""
    table = Body("table", Box((2.0, 2.0, 0.2)), position=(-1.0, 0.0, -0.1))
    brick = box("b", (0.4, 0.3, 0.1), (offset, 0.0, 0.05))
    world = begin(Scene((table, brick), (Gravity(), Rotation(), Resting(), Restitution(0.0))))
    advance(world, 0.3)
    if offset < 0.0:
        assert world.mode[1] == STILL
        assert world.state().x[1] == pytest.approx((offset, 0.0, 0.05), abs=1e-15)
    else:
        assert world.state().w[1, 1] > 0.0
        assert world.state().x[1, 2] < 0.05


def test_a_box_balanced_on_an_edge_exactly_stays():
    """Its weight goes through the border of the table: the equilibrium of the books, and unstable."""
    table = Body("table", Box((2.0, 2.0, 0.2)), position=(-1.0, 0.0, -0.1))
    world = begin(Scene((table, box("b", (0.4, 0.3, 0.1), (0.0, 0.0, 0.05))), (Gravity(), Rotation(), Resting())))
    advance(world, 1.0)
    assert world.state().x[1] == pytest.approx((0.0, 0.0, 0.05), abs=1e-12)
    assert load(world) == pytest.approx(9.81, rel=1e-12)


def test_a_box_between_two_walls_rests_without_being_squeezed():
    """Both walls touch it and the floor carries it: of all the squeezes that are possible, none."""
    walls = [Body(f"w{s}", HalfSpace((-float(s), 0.0, 0.0)), position=(0.2 * s, 0.0, 0.0)) for s in (-1, 1)]
    brick = box("b", (0.4, 0.3, 0.2), (0.0, 0.0, 0.1))
    world = begin(Scene((FLOOR, *walls, brick), (Gravity(), Rotation(), Resting())))
    advance(world, 1.0)
    assert world.mode[3] == STILL
    assert load(world) == pytest.approx(9.81, rel=1e-12)
    assert sum(h.force * abs(h.normal[0]) for h in world.forces) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("legs", [3, 4, 100])
def test_a_table_stands_on_as_many_legs_as_it_has(legs):
    """A plate on `legs` fixed posts round its middle: they carry it together, however many are too many."""
    angles = 2.0 * np.pi * np.arange(legs) / legs
    posts = [
        Body(f"p{i}", Sphere(0.02), None, (0.8 * float(np.cos(t)), 0.8 * float(np.sin(t)), 0.0))
        for i, t in enumerate(angles)
    ]
    plate = box("plate", (2.0, 2.0, 0.1), (0.0, 0.0, 0.07), 5.0)
    world = begin(Scene((*posts, plate), (Gravity(), Rotation(), Resting())))
    advance(world, 1.0)
    assert world.mode[-1] == STILL
    assert load(world) == pytest.approx(5.0 * 9.81, rel=1e-12)
    moment = sum(h.force * np.array(h.point[:2]) for h in world.forces)
    assert np.abs(moment).max() <= 1e-10


def test_a_box_that_leans_on_a_smooth_wall_slides_down():
    """No equilibrium exists without friction: it slides, its energy unchanged."""
    lean = about((0.0, 1.0, 0.0), 0.4)
    half, up = np.array((0.02, 0.3, 0.5)), matrix(lean)
    low = np.abs(up[2]) @ half
    left = np.abs(up[0]) @ half
    wall = Body("wall", HalfSpace((-1.0, 0.0, 0.0)), position=(left, 0.0, 0.0))
    plank = box("plank", tuple(2.0 * half), (0.0, 0.0, low), 2.0, orientation=tuple(lean))
    scene = Scene((FLOOR, wall, plank), (Gravity(), Rotation(), Resting(), Restitution(0.0)))
    world = begin(scene)
    energy = 2.0 * 9.81 * low
    advance(world, 0.2)
    state = world.state()
    after = state.v[2] @ state.v[2] + 0.5 * state.w[2] @ world.motion.L[2] + 2.0 * 9.81 * state.x[2, 2]
    assert state.x[2, 2] < low - 0.01
    assert after == pytest.approx(energy, rel=1e-10)


@pytest.mark.parametrize("tilt", [1e-14, 1e-12, 1e-10, 1e-8, 1e-6, 1e-4])
def test_a_face_that_is_almost_parallel_touches_where_it_is_lowest(tilt):
    """Gaps of coplanar faces to rounding: where a general-purpose distance algorithm loses seven digits."""
    for shape in (HalfSpace(), Box((4.0, 4.0, 1.0))):
        ground = Body("ground", shape, None, (0.0, 0.0, 0.0 if isinstance(shape, HalfSpace) else -0.5))
        leaning = tuple(about((0.0, 1.0, 0.0), tilt))
        height = 0.1 * np.cos(tilt) + 0.2 * np.sin(tilt)
        points, normals = touches(ground, box("b", (0.4, 0.4, 0.2), (0.0, 0.0, height), orientation=leaning))
        assert len(points) == (4 if tilt < 1e-9 else 2)
        assert np.abs(points[:, 2]).max() <= 0.4 * tilt * (tilt < 1e-9) + 1e-16
        assert np.abs(normals - (0.0, 0.0, 1.0)).max() <= 2.0 * tilt


@pytest.mark.parametrize("inner", [Sphere(0.1), Box((0.1, 0.1, 0.1))])
@pytest.mark.parametrize("outer", [Sphere(1.0), Box((2.0, 2.0, 2.0)), HalfSpace()])
def test_one_body_inside_another_is_refused(inner, outer):
    outside = Body("out", outer, None)
    inside = Body("in", inner, 1.0, (0.05, 0.03, -0.3))
    with pytest.raises(Overlap, match="overlap by") as error:
        begin(Scene((outside, inside), (Resting(), Rotation())))
    assert set(error.value.bodies) == {"in", "out"}
    assert error.value.depth > 0.1


@pytest.mark.parametrize(("scale", "offset"), [(1e-6, 0.0), (1.0, 0.0), (1e6, 0.0), (1.0, 1e4), (1.0, 1e8)])
def test_a_ball_bounces_at_any_size_and_place(scale, offset):
    """Apex after one bounce e² h, at 1e8 m to the rounding of that coordinate."""
    floor = Body("floor", HalfSpace(), position=(offset, 0.0, offset))
    ball = Body("ball", Sphere(0.1 * scale), 1.0, (offset, 0.0, offset + 1.1 * scale))
    scene = Scene((floor, ball), (Gravity(), Restitution(0.5), Resting()))
    fall = np.sqrt(2.0 * scale / 9.81)
    motion = simulate(scene, (0.0, 1.5 * fall))
    grain = np.spacing(offset) / scale
    assert (motion.x[1, 1, 2] - offset) / scale == pytest.approx(0.35, abs=1e-14 + 4.0 * grain)
    assert abs(motion.v[1, 1, 2]) * fall / scale <= 1e-14 + 20.0 * grain


def test_a_plate_that_is_pulled_away_leaves_the_smooth_box_on_it_where_it_is():
    """Faces that touch to 1e-9 of their size are tilted by as much, and edges that cross at a small angle by more.

    A motion that differs between their normals only is none to brake: it would be made a spin of 500 rad/s.
    """
    plate = Body("plate", Box((1e-3, 1e-3, 1e-3)), 2.0, (0.0, 0.0, 5e-4), velocity=(0.0, 1e-3, 0.0),
                 angular_velocity=(0.0, 1.0, 0.0))  # fmt: skip
    box = Body("box", Box((2e-4, 1e-3, 1e-3)), 1.0, (0.0, 0.0, 1.5e-3), angular_velocity=(1.0, 1.0, -2.0))
    pull = Force("plate", (-6.2, -0.6, -3.6), point=(-1.2e-4, 8.4e-6, 8.4e-5), start=0.048, end=0.4)
    effects = (Gravity(), Rotation(), Restitution(0.3), Resting(), pull)
    world = begin(Scene((FLOOR, plate, box), effects), Settings(impact_law="simultaneous"))
    advance(world, 0.045)
    before = world.state()
    for _ in range(6):  # its edge has not come to the middle of the box yet
        advance(world, 3e-3)
        state = world.state()
        assert np.abs(state.v[2] - before.v[2]).max() <= 1e-9
        assert state.w[2] == pytest.approx(before.w[2], abs=1e-6)
    assert np.linalg.norm(state.x[1] - before.x[1]) > 3e-4
    assert world.audit.energy_rise <= 1e-15
