"""The place error: one length for displacement and turning, over the scale of the motion."""

import math

import numpy as np
import pytest

from comparisons import place
from mechanics.effects import Gravity, Rotation
from mechanics.rotation import about, product
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Sphere
from mechanics.trajectory import Trajectory

T = np.linspace(0.0, 1.0, 11)
BALL = Scene((Body("ball", Sphere(0.1), mass=1.0), Body("floor", HalfSpace(), position=(0, 0, -9))), (Gravity(),))
BOX = Scene((Body("box", Box((0.6, 0.0001, 0.8)), mass=1.0),), (Rotation(),))


def truth_of(scene, moved, **paths):
    """Truth of a scene in which something moves linearly in time: path(t)."""
    return lambda t: moved(scene, t, **{key: path(np.asarray(t)) for key, path in paths.items()})


def falling(t):
    return np.stack([0.0 * t, 0.0 * t, -4.0 * t**2], axis=1)


def test_displacement_counts_over_the_way_of_the_motion(case_of, moved, values):
    motion = moved(BALL, T, x_ball=falling(T) + [[0.0, 0.003, 0.0]] * (T == 0.5)[:, None])
    case = case_of(BALL, motion, "position error", truth=truth_of(BALL, moved, x_ball=falling))
    found = values(place, case)
    assert found["place error"].value == pytest.approx(0.003)
    assert found["place error"].time == pytest.approx(0.5)
    assert found["relative place error"].value == pytest.approx(0.003 / 4.0)


@pytest.mark.parametrize("angle", [1e-6, 0.1, math.pi])
def test_turning_counts_as_far_as_the_outermost_point_moves(case_of, moved, values, angle):
    q = np.array([product(about((0.0, 1.0, 0.0), angle), BOX.start().q[0])] * len(T))
    case = case_of(BOX, moved(BOX, T, q_box=q), "orientation error", truth=truth_of(BOX, moved))
    radius = 0.5 * math.hypot(0.6, 0.8)
    # a corner of the plate, turned about y, goes the length of the chord
    assert values(place, case)["place error"].value == pytest.approx(2.0 * radius * math.sin(angle / 2.0), rel=1e-6)
    assert values(place, case)["relative place error"].value == pytest.approx(math.sin(angle / 2.0), rel=1e-6)


def test_what_is_not_known_is_not_compared(case_of, moved, values):
    def half_known(t):
        true = moved(BALL, t)
        return Trajectory(true.t, np.where(np.asarray(t)[:, None, None] > 0.5, np.nan, true.x), true.q, true.v, true.w)

    motion = moved(BALL, T, x_ball=np.where(T[:, None] > 0.55, 7.0, 0.01))
    case = case_of(BALL, motion, "position error", truth=half_known)
    assert values(place, case)["place error"].value == pytest.approx(0.01 * math.sqrt(3.0))


@pytest.mark.parametrize(("asked", "truth"), [("energy error", True), ("position error", False)])
def test_it_is_told_only_where_the_scenario_asks_where_bodies_are(case_of, moved, values, asked, truth):
    told = {"truth": truth_of(BALL, moved)} if truth else {}
    assert values(place, case_of(BALL, moved(BALL, T), asked, **told)) == {}


def test_a_scene_at_rest_is_as_long_as_its_smallest_body(scenario_of, moved):
    scene = Scene((Body("a", Sphere(0.3), mass=1.0), Body("b", Sphere(0.2), mass=1.0, position=(2, 0, 0))), ())
    assert place.scale(scenario_of(scene, truth=truth_of(scene, moved))) == pytest.approx(0.4)
    with pytest.raises(ValueError, match="no truth"):
        place.scale(scenario_of(scene))
