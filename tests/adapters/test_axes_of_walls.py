"""A wall across an axis returns balls along it, without rounding: what is left over grows with each collision."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from adapters.engine import checked_settings
from adapters.registry import engine
from adapters.run import prepare, run
from adapters.translate import shortest
from mechanics.effects import Restitution
from mechanics.rotation import rotate
from mechanics.scene import Body, Scene
from mechanics.shapes import HalfSpace, Sphere

AXES = [tuple(s * k for k in row) for s, row in itertools.product((1.0, -1.0), np.eye(3).tolist())]


# of the others PyBullet's iterative distance rounds the normal itself
SQUARE = [*itertools.product(["mujoco"], AXES), *itertools.product(["pybullet", "pybullet:multibody"], AXES[0:3:2])]


@pytest.mark.parametrize(("name", "axis"), SQUARE, ids=str)
def test_two_balls_before_a_wall_stay_on_their_line(name, axis):
    # the hundred collisions of masses 1 and 1000 would blow an offset of 1e-16 m up to the size of the balls
    pytest.importorskip(name.partition(":")[0])
    along = np.array(axis)
    light = Body("light", Sphere(0.05), 1.0, tuple(0.5 * along))
    heavy = Body("heavy", Sphere(0.05), 1000.0, tuple(along), velocity=tuple(-1.0 * along))
    scene = Scene((Body("wall", HalfSpace(axis)), light, heavy), (Restitution(1.0),))
    motion = run(engine(name), scene, np.linspace(0.0, 3.0, 31), {"dt": 1e-3}).outcome
    assert motion.v[-1, 2] @ along > 0.99
    assert not (motion.v[:, 1:] * (along == 0.0)).any()


@pytest.mark.parametrize("axis", AXES, ids=str)
def test_pybullets_ground_is_not_turned_where_one_of_its_faces_lies_right(axis):
    bullet = pytest.importorskip("pybullet")
    wall, ball = Body("wall", HalfSpace(axis)), Body("ball", Sphere(0.1), 1.0, tuple(2.0 * c for c in axis))
    fair = engine("pybullet")
    world = fair.start(prepare(fair, Scene((wall, ball), (Restitution(1.0),)))[0], checked_settings(fair, {}))
    middle, turned = bullet.getBasePositionAndOrientation(world.ids[0], world.client)
    nearest = bullet.getClosestPoints(world.ids[0], world.ids[1], 10.0, physicsClientId=world.client)
    fair.close(world)
    assert turned == (0.0, 0.0, 0.0, 1.0)
    assert np.cross(middle, axis) == pytest.approx(0.0)
    assert nearest[0][8] == pytest.approx(1.9, abs=1e-6)


@given(*[st.tuples(*[st.floats(-1.0, 1.0)] * 3).filter(lambda v: np.linalg.norm(v) > 0.1)] * 2)
def test_the_shortest_rotation_carries_one_into_the_other_by_the_angle_between_them(start, end):
    start, end = (np.array(v) / np.linalg.norm(v) for v in (start, end))
    turn = shortest(start, end)
    assert rotate(turn, start) == pytest.approx(end, abs=1e-11)
    assert turn[0] == pytest.approx(np.sqrt(max(0.0, 0.5 * (1.0 + start @ end))), abs=1e-7)


@pytest.mark.parametrize("start", AXES, ids=str)
def test_opposite_vectors_are_carried_into_each_other(start):
    assert rotate(shortest(np.array(start), -np.array(start)), np.array(start)) == pytest.approx(-np.array(start))
