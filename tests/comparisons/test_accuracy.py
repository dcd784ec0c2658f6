"""Distance from a truth, rest, and the name of the impact law."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from comparisons import accuracy, impact_law, rest
from mechanics.effects import Gravity, Resting, Restitution, Rotation
from mechanics.rotation import about, product
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Sphere
from mechanics.trajectory import Trajectory

T = np.linspace(0.0, 1.0, 101)
SCENE = Scene((Body("a", Box((1.0, 2.0, 3.0)), mass=1.0), Body("b", Sphere(0.1), mass=1.0)), (Rotation(),))


@given(
    st.integers(0, 100),
    st.sampled_from("ab"),
    st.floats(1e-9, 3.0),
    st.floats(1e-9, 3.0),
    st.sampled_from([1.0, -1.0]),
)
def test_each_error_is_found_with_its_size_and_time(case_of, moved, values, k, body, size, angle, sign):
    here = np.zeros((101, 1))
    here[k] = 1.0
    direction = np.array([[0.6, 0.0, 0.8]])
    q = np.array(SCENE.start().q[0]) * np.ones((101, 1))
    q[k] = sign * product(about((1.0, 2.0, 0.5), angle), q[k])  # -q is the same attitude
    wrong = {f"{kind}_{body}": size * here * direction for kind in "xvw"}
    motion = moved(SCENE, T, **wrong, **{f"q_{body}": q})
    found = values(accuracy, case_of(SCENE, motion, truth=lambda t: moved(SCENE, t)))
    for name in ("position error", "velocity error", "angular velocity error"):
        assert found[name].value == pytest.approx(size, rel=1e-12)
        assert found[name].time == T[k]
    assert found["orientation error"].value == pytest.approx(angle, rel=1e-6)
    assert found["final position error"].value == pytest.approx(size if k == 100 else 0.0, rel=1e-12)


def test_what_the_truth_leaves_open_is_not_compared(case_of, moved, values):
    def truth(t):
        known = moved(SCENE, t)
        x, v, q = (np.array(getattr(known, name)) for name in "xvq")
        x[:, 0], x[t > 0.5, 1], v[...], q[...] = np.nan, np.nan, np.nan, np.nan
        v[:, 1, 2] = 0.0  # of this velocity only the height is known
        return Trajectory(t, x, q, v, known.w)

    far = moved(SCENE, T, x_a=5.0, x_b=np.where(T > 0.3, 2.0, 0.0)[:, None], v_b=np.array([7.0, 0.0, 0.5]))
    found = values(accuracy, case_of(SCENE, far, truth=truth))
    assert found["position error"].value == pytest.approx(2.0 * np.sqrt(3.0))
    assert found["final position error"].time == pytest.approx(0.5)
    assert found["velocity error"].value == pytest.approx(0.5)
    assert "orientation error" not in found


def test_velocities_are_not_compared_beside_an_impact(case_of, moved, values):
    late = np.where((T > 0.4) & (T < 0.42), 3.0, 0.0)[:, None] * [1.0, 0.0, 0.0]
    case = case_of(SCENE, moved(SCENE, T, v_a=late), truth=lambda t: moved(SCENE, t), events=(0.41,), guard=0.005)
    assert values(accuracy, case)["velocity error"].value == 0.0
    case = case_of(SCENE, moved(SCENE, T, v_a=late), truth=lambda t: moved(SCENE, t), events=(0.41,), guard=1e-4)
    assert values(accuracy, case)["velocity error"].value == 0.0
    case = case_of(SCENE, moved(SCENE, T, v_a=late), truth=lambda t: moved(SCENE, t), events=(0.43,), guard=0.005)
    assert values(accuracy, case)["velocity error"].value == 3.0


def test_the_truth_is_asked_for_the_times_that_were_reached(case_of, moved, values):
    def truth(t):
        return moved(SCENE, t, x_a=np.outer(t, [10.0, 0.0, 0.0]))

    reached = T + 0.004
    assert values(accuracy, case_of(SCENE, truth(reached), truth=truth))["position error"].value == 0.0


def test_no_truth_no_errors(case_of, moved, values):
    assert values(accuracy, case_of(SCENE, moved(SCENE, T))) == {}


def test_rest(case_of, moved, values):
    scene = Scene(
        (Body("floor", HalfSpace()), Body("box", Box((0.6, 0.8, 1.0)), 1.0, (0.0, 0.0, 0.5))),
        (Gravity(), Resting(), Rotation()),
    )
    away = np.where(T[:, None] > 0.5, [3e-3, 4e-3, 0.0], 0.0) + np.array([0.0, 0.0, 0.5])
    lean = np.where(T[:, None] > 0.715, about((0.0, 1.0, 0.0), 0.02), about((0.0, 1.0, 0.0), 0.0))
    motion = moved(scene, T, x_box=away, q_box=lean, v_box=np.array([0.1, 0.0, 0.0]), w_box=np.array([0.0, 0.2, 0.0]))
    found = values(rest, case_of(scene, motion, "drift", "tilt"))
    assert (found["drift"].value, found["drift"].time) == (pytest.approx(5e-3), pytest.approx(0.51))
    assert (found["tilt"].value, found["tilt"].time) == (pytest.approx(0.02), pytest.approx(0.72))
    assert found["rest speed"].value == pytest.approx(0.1 + 0.2 * np.sqrt(0.5))
    assert found["out of plane"].value == pytest.approx(4e-3)
    assert "drift" not in values(rest, case_of(scene, motion))


LAWS = {
    "sequential": ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (1.0, 0.0, 0.0)),
    "simultaneous": ((-1.0 / 3.0, 0.0, 0.0), (2.0 / 3.0, 0.0, 0.0), (2.0 / 3.0, 0.0, 0.0)),
}


@pytest.mark.parametrize(
    ("final", "word"),
    [
        ((0.0, 0.0, 1.0), "sequential"),
        ((0.04, 0.0, 0.96), "sequential"),
        ((-1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0), "simultaneous"),
        ((-0.1, 0.1, 1.0), "unknown (nearest sequential, off by 10%)"),
    ],
)
def test_the_impact_law_is_named(case_of, moved, values, final, word):
    scene = Scene(tuple(Body(f"b{i}", Sphere(0.1), 1.0, (0.2 * i, 0.0, 0.0)) for i in range(3)), (Restitution(1.0),))
    speeds = {f"v_b{i}": np.array([v, 0.0, 0.0]) for i, v in enumerate(final)}
    found = values(impact_law, case_of(scene, moved(scene, T, **speeds), laws=LAWS))
    assert found["impact law"].text == word
    assert np.isnan(found["impact law"].value)
    assert values(impact_law, case_of(scene, moved(scene, T))) == {}
