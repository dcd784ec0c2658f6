"""Scene files load to the same scene that Python writes, and their errors say where."""

import pytest
import tomli_w

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
from mechanics.scene_file import load_scene, scene_digest, scene_from_dict, scene_to_dict
from mechanics.shapes import Box, Capsule, Cylinder, HalfSpace, Mesh, Sphere

TETRAHEDRON = Mesh(((1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)), ((0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)))

EVERYTHING = Scene(
    (
        Body("floor", HalfSpace((0.6, 0.0, 0.8)), velocity=(1, 0, 0), acceleration=(0, 0, 1)),
        Body("ball", Sphere(0.1), mass=1.5, position=(0, 0, 1), velocity=(0, 0, -1), inertia=(0.1, 0.1, 0.15)),
        Body("box", Box((1, 2, 3)), mass=2.0, orientation=(0.8, 0, 0.6, 0), angular_velocity=(0.1, 5, 0.1)),
        Body("pill", Capsule(0.1, 0.4), mass=1.0, inertia=((1, 0.1, 0), (0.1, 1, 0), (0, 0, 1))),
        Body("can", Cylinder(0.1, 0.4), mass=1.0),
        Body("tetra", TETRAHEDRON, mass=1.0),
    ),
    (
        Gravity((0, 0, -9.8)),
        Rotation(),
        Drag(linear=0.1, bodies=("ball",)),
        Force("ball", force=(1, 0, 0), start=0.5),
        Spring("ball", "box", stiffness=10.0, length=1.0, anchor_a=(0, 0, 0.1)),
        Restitution(0.5, {("ball", "box"): 0.25}),
        Friction(0.3),
        Resting(),
        Rod("ball", "pill"),
        Tether("box", "can", length=3.0),
        Hinge("pill", "can", point=(0, 0, 0.5), axis=(0, 0, 2)),
    ),
)


def test_a_scene_survives_the_file(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(tomli_w.dumps(scene_to_dict(EVERYTHING)))
    again = load_scene(path)
    assert again == EVERYTHING
    assert scene_digest(again) == scene_digest(EVERYTHING)


def test_a_file_written_by_hand(tmp_path):
    path = tmp_path / "ball.toml"
    path.write_text("""
        [[body]]
        name = "floor"
        shape = { type = "HalfSpace" }
        [[body]]
        name = "ball"
        shape = { type = "Sphere", radius = 0.1 }
        mass = 1
        position = [0, 0, 1.1]
        [[effect]]
        type = "Gravity"
        [[effect]]
        type = "Restitution"
        coefficient = 0.8
        between = [ { a = "ball", b = "floor", coefficient = 0.5 } ]
    """)
    ball = Body("ball", Sphere(0.1), mass=1.0, position=(0, 0, 1.1))
    assert load_scene(path) == Scene(
        (Body("floor", HalfSpace()), ball), (Gravity(), Restitution(0.8, {("ball", "floor"): 0.5}))
    )


def ball(**change):
    return {"name": "ball", "shape": {"type": "Sphere", "radius": 0.1}, "mass": 1.0} | change


@pytest.mark.parametrize(
    ("data", "field", "allowed"),
    [
        ({"body": [ball(), ball(name="b", mass=-1.0)]}, "body[1].mass", "> 0"),
        ({"body": [ball(shape={"type": "Sphere", "radius": -1.0})]}, "body[0].shape.radius", "> 0"),
        ({"body": [ball(shape={"type": "Ball"})]}, "body[0].shape.type", "Sphere"),
        ({"body": [ball(shape={"type": "Sphere"})]}, "body[0].shape.radius", "needs it"),
        ({"body": [ball(shape="Sphere")]}, "body[0].shape", "table"),
        ({"body": [ball(colour="red")]}, "body[0].colour", "no such field"),
        ({"body": [ball()], "effect": [{"type": "Wind"}]}, "effect[0].type", "Gravity"),
        ({"body": [ball()], "effect": [{"type": "Restitution", "coefficient": 2.0}]}, "effect[0].coefficient", "<= 1"),
        ({"body": [ball()], "effect": [{"type": "Restitution", "coefficient": 1, "between": [{"a": "b"}]}]},
         "effect[0].between[0]", "a, b and coefficient"),
        ({"body": [ball()], "bodies": []}, "bodies", "no such field"),
        ({"body": {"name": "x"}}, "body", "array of tables"),
        ({}, "bodies", "at least one body"),
    ],
)  # fmt: skip
def test_errors_carry_the_key_path(data, field, allowed):
    with pytest.raises(SceneError) as caught:
        scene_from_dict(data)
    assert caught.value.field == field
    assert allowed in caught.value.allowed


def test_broken_toml_names_file_and_line(tmp_path):
    path = tmp_path / "broken.toml"
    path.write_text('[[body]]\nname = "ball\n')
    with pytest.raises(SceneError, match=r"broken\.toml.*line 2"):
        load_scene(path)


def test_errors_of_a_file_start_with_the_file(tmp_path):
    path = tmp_path / "heavy.toml"
    path.write_text(tomli_w.dumps({"body": [ball(mass=float("nan"))]}))
    with pytest.raises(SceneError, match=r"heavy\.toml: body\[0\]\.mass = nan"):
        load_scene(path)
