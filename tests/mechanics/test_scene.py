"""An ill-posed scene cannot be constructed, and the error names field, value and what is allowed."""

import math
import pickle

import numpy as np
import pytest

from mechanics.arrays import SceneError
from mechanics.effects import (
    Drag,
    Force,
    Friction,
    Gravity,
    Hinge,
    Resting,
    Restitution,
    Rod,
    Rotation,
    Spring,
    Tether,
)
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, Capsule, Cylinder, HalfSpace, Mesh, Sphere, bounding_radius

BALL = Body("ball", Sphere(0.1), mass=1.0, position=(0, 0, 1))
FLOOR = Body("floor", HalfSpace())
CUBE = ((0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0), (0, 0, 1), (1, 0, 1), (0, 1, 1), (1, 1, 1))
FACES = (
    (0, 2, 1), (1, 2, 3), (4, 5, 6), (5, 7, 6), (0, 1, 4), (1, 5, 4),
    (2, 6, 3), (3, 6, 7), (0, 4, 2), (2, 4, 6), (1, 3, 5), (3, 7, 5),
)  # fmt: skip
NAN, INF = math.nan, math.inf


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"mass": -1.0}, "mass"),
        ({"mass": 0.0}, "mass"),
        ({"mass": NAN}, "mass"),
        ({"mass": INF}, "mass"),
        ({"mass": "heavy"}, "mass"),
        ({"mass": True}, "mass"),
        ({"inertia": (1.0, 0.0, 1.0)}, "inertia"),
        ({"inertia": (1.0, -1.0, 1.0)}, "inertia"),
        ({"inertia": (1.0, 1.0, 3.0)}, "inertia"),
        ({"inertia": (1.0, 1.0)}, "inertia"),
        ({"inertia": ((1, 0, 0), (0, 1, 0), (0, 0, NAN))}, "inertia"),
        ({"position": (0, 0, NAN)}, "position"),
        ({"position": (0, 0)}, "position"),
        ({"position": "abc"}, "position"),
        ({"velocity": (INF, 0, 0)}, "velocity"),
        ({"angular_velocity": (0, 0, -INF)}, "angular_velocity"),
        ({"orientation": (0, 0, 0, 0)}, "orientation"),
        ({"orientation": (1, 0, 0)}, "orientation"),
        ({"orientation": (NAN, 0, 0, 0)}, "orientation"),
        ({"acceleration": (1, 0, 0)}, "acceleration"),
        ({"shape": HalfSpace()}, "mass"),
        ({"shape": "Sphere"}, "shape"),
        ({"name": ""}, "name"),
    ],
)
def test_a_body_that_cannot_be_is_refused_by_field(change, field):
    values = {"name": "ball", "shape": Sphere(0.1), "mass": 1.0, "position": (0, 0, 1)} | change
    with pytest.raises(SceneError) as caught:
        Body(**values)
    assert field in caught.value.field
    assert caught.value.allowed
    assert caught.value.field in str(caught.value)


@pytest.mark.parametrize(
    "make",
    [
        lambda: Sphere(0.0),
        lambda: Sphere(-1.0),
        lambda: Sphere(NAN),
        lambda: Box((1, 1, 0)),
        lambda: Box((1, 1)),
        lambda: Capsule(0.1, 0.0),
        lambda: Cylinder(0.0, 1.0),
        lambda: HalfSpace((0, 0, 0)),
        lambda: Restitution(1.1),
        lambda: Restitution(-0.1),
        lambda: Restitution(NAN),
        lambda: Restitution(0.5, {("a", "a"): 0.1}),
        lambda: Restitution(0.5, {("a", "b"): 2.0}),
        lambda: Restitution(0.5, ((("a", "b"), 0.1), (("b", "a"), 0.2))),
        lambda: Friction(-0.5),
        lambda: Friction(INF),
        lambda: Gravity((0, 0)),
        lambda: Drag(linear=-1.0),
        lambda: Force("ball", start=2.0, end=1.0),
        lambda: Spring("a", "b", stiffness=-1.0, length=1.0),
        lambda: Tether("a", "b", length=0.0),
        lambda: Hinge("a", "b", axis=(0, 0, 0)),
        lambda: Body("wall", Box((1, 1, 1)), inertia=(1, 1, 1)),
        lambda: Body("wall", Box((1, 1, 1)), angular_velocity=(0, 0, 1)),
    ],
)
def test_values_out_of_range_are_refused(make):
    with pytest.raises(SceneError):
        make()


@pytest.mark.parametrize(
    ("bodies", "effects", "message"),
    [
        ((), (), "at least one body"),
        ((BALL, BALL), (), "every body name once"),
        ((BALL,), (Gravity(), Gravity()), "one Gravity at most"),
        ((BALL,), (Force("bal"),), "a body of the scene: ball"),
        ((BALL,), (Restitution(0.5, {("ball", "flor"): 0.1}),), "a body of the scene: ball"),
        ((BALL, FLOOR), (Rod("ball", "ball"),), "two different bodies"),
        ((BALL, FLOOR), (Force("floor", (1, 0, 0)),), "a body with a mass"),
        ((Body("top", Sphere(1.0), mass=1.0, angular_velocity=(0, 0, 1)),), (), "Rotation"),
        (("ball",), (), "a Body"),
        ((BALL,), ("gravity",), "a Effect"),
    ],
)
def test_a_scene_that_cannot_be_is_refused(bodies, effects, message):
    with pytest.raises(SceneError, match=message):
        Scene(bodies, effects)


@pytest.mark.parametrize(
    ("vertices", "triangles", "message"),
    [
        (CUBE, FACES[:-1], "open mesh"),
        (CUBE, tuple(t[::-1] for t in FACES), "inverted"),
        (CUBE, (FACES[0][::-1], *FACES[1:]), "winding"),
        ((*CUBE, (0.5, 0.5, 0.5)), FACES, "every vertex used"),
        ((*CUBE[:-1], CUBE[0]), FACES, "every vertex once"),
        (CUBE, (*FACES[:-1], (3, 7, 7)), "three different vertex indices"),
        (CUBE, (*FACES[:-1], (3, 7, 8)), "three different vertex indices"),
        (((0, 0, 0), (1, 0, 0), (2, 0, 0), (0, 0, 1)), ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)), "degenerate"),
    ],
)
def test_open_inverted_and_degenerate_meshes_are_refused(vertices, triangles, message):
    with pytest.raises(SceneError, match=message):
        Mesh(vertices, triangles)


def test_a_notched_mesh_is_not_convex():
    dented = [list(v) for v in CUBE]
    dented[7] = [0.3, 0.3, 0.3]
    with pytest.raises(SceneError, match="convex=False"):
        Mesh(tuple(map(tuple, dented)), FACES)
    assert not Mesh(tuple(map(tuple, dented)), FACES, convex=False).convex


def test_a_moving_mesh_must_have_its_centre_of_mass_at_the_origin():
    with pytest.raises(SceneError, match="centred"):
        Body("cube", Mesh(CUBE, FACES), mass=1.0)
    assert Body("cube", Mesh(CUBE, FACES).centred(), mass=1.0).inertia_tensor == pytest.approx(np.eye(3) / 6, abs=1e-14)


def test_an_error_survives_a_process_boundary():
    error = SceneError("body 'ball'.mass", -1.0, "a finite number > 0")
    again = pickle.loads(pickle.dumps(error))
    assert (again.field, again.value, again.allowed, str(again)) == (error.field, -1.0, error.allowed, str(error))


def test_quaternions_become_units_and_units_stay_bitwise():
    assert Body("b", Sphere(1), 1.0, orientation=(2, 0, 0, 0)).orientation == (1.0, 0.0, 0.0, 0.0)
    unit = (0.8, 0.0, 0.6, 0.0)
    assert Body("b", Sphere(1), 1.0, orientation=unit).orientation == unit


def test_coefficients_belong_to_the_pair_in_either_order():
    scene = Scene(
        (BALL, FLOOR, Body("wall", Box((1, 1, 1)))), (Restitution(0.8, {("floor", "ball"): 0.2}), Friction(0.3))
    )
    assert scene.restitution(0, 1) == scene.restitution(1, 0) == 0.2
    assert scene.restitution(0, 2) == 0.8
    assert scene.friction(0, 1) == 0.3
    assert Scene((BALL, FLOOR)).friction(0, 1) == 0.0


def test_only_bodies_that_may_touch_make_pairs():
    wall = Body("wall", Box((1, 1, 1)))
    other = Body("other", Sphere(0.1), mass=1.0, position=(1, 0, 1))
    bodies = (FLOOR, wall, BALL, other)
    assert list(Scene(bodies, (Gravity(),)).pairs()) == []
    assert list(Scene(bodies, (Resting(),)).pairs()) == [(0, 2), (0, 3), (1, 2), (1, 3), (2, 3)]
    assert (2, 3) not in list(Scene(bodies, (Resting(), Rod("ball", "other"))).pairs())


def test_needs_are_the_effects_that_stand_there():
    scene = Scene((BALL,), (Gravity(), Rotation()))
    assert scene.needs == {Gravity, Rotation}
    assert scene.gravity.tolist() == [0.0, 0.0, -9.81]
    assert Scene((BALL,)).gravity.tolist() == [0.0, 0.0, 0.0]


@pytest.mark.parametrize(
    ("body", "effects", "word"),
    [
        (Body("b", Box((1, 1, 1)), 1.0, orientation=(0.8, 0.6, 0, 0)), (), "about y"),
        (Body("b", Sphere(1), 1.0, velocity=(0, 1, 0)), (), "velocity"),
        (Body("b", Sphere(1), 1.0, angular_velocity=(1, 0, 0)), (Rotation(),), "along y"),
        (Body("b", Sphere(1), 1.0), (Gravity((0, -9.81, 0)),), "Gravity"),
        (Body("b", HalfSpace((0, 1, 0))), (), "normal"),
        (Body("b", Sphere(1), 1.0, position=(0, 1, 0)), (), "y = 1"),
    ],
)
def test_what_leaves_the_plane_is_named(body, effects, word):
    reason = Scene((BALL, body), effects).out_of_plane()
    assert reason is not None
    assert word in reason


def test_a_planar_scene_is_planar():
    tilted = Body("box", Box((1, 1, 1)), 1.0, orientation=(0.8, 0, 0.6, 0), angular_velocity=(0, 3, 0))
    assert Scene((BALL, tilted, FLOOR), (Gravity(), Rotation(), Restitution(0.5))).out_of_plane() is None


@pytest.mark.parametrize(
    ("shape", "radius"),
    [(Sphere(2), 2), (Box((2, 4, 4)), 3), (Capsule(1, 2), 2), (Cylinder(3, 8), 5), (HalfSpace(), INF),
     (Mesh(CUBE, FACES), math.sqrt(3))],
)  # fmt: skip
def test_bounding_radius(shape, radius):
    assert bounding_radius(shape) == pytest.approx(radius)
