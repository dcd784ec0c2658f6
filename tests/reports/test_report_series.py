"""Curves over time against closed forms."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mechanics.effects import Gravity, Restitution, Rotation
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Sphere
from mechanics.trajectory import Trajectory
from reports.drawing import BOTTOM, FLOOR, TOP, svg
from reports.figures import Axis, Figure, Series
from reports.recorded import Motion, Recorded
from reports.series import time_series

HEIGHT = 236.0
TIMES = np.linspace(0.0, 2.0, 151)


def _recorded(scene: Scene, x: np.ndarray, q: np.ndarray | None = None, v=0.0, w=0.0, truth=None) -> Recorded:
    """One engine that moves the second body of a scene so."""
    n = len(scene.bodies)
    places = np.repeat(np.array([b.position for b in scene.bodies])[None], len(TIMES), axis=0)
    places[:, n - 1] = x
    turns = np.tile([1.0, 0.0, 0.0, 0.0], (len(TIMES), n, 1))
    if q is not None:
        turns[:, n - 1] = q
    speeds, spins = np.zeros_like(places), np.zeros_like(places)
    speeds[:, n - 1], spins[:, n - 1] = v, w
    path = Trajectory(TIMES, places, turns, speeds, spins)
    return Recorded("s", scene, 2.0, truth, {}, {"mujoco": Motion(path, 0.0)})


def _of(recorded: Recorded, title: str) -> np.ndarray:
    figure = next(f for f in time_series(recorded).figures if f.title.startswith(title))
    return np.array(next(s.y for s in figure.series if s.engine))


def test_a_ball_thrown_up_keeps_its_energy_and_gains_the_momentum_of_gravity():
    scene = Scene((Body("ball", Sphere(0.1), mass=2.0, velocity=(0.0, 0.0, 5.0)),), (Gravity(),))
    height, speed = 5.0 * TIMES - 0.5 * 9.81 * TIMES**2, 5.0 - 9.81 * TIMES
    none = np.zeros_like(TIMES)
    thrown = _recorded(scene, np.stack([none, none, height], axis=1), v=np.stack([none, none, speed], axis=1))
    assert np.abs(_of(thrown, "Energy")).max() < 1e-12
    assert _of(thrown, "Momentum of all bodies") == pytest.approx(2.0 * np.abs(speed), abs=1e-12)


def test_what_gravity_does_not_explain_is_shown():
    scene = Scene((Body("ball", Sphere(0.1), mass=2.0),), (Gravity(),))
    none = np.zeros_like(TIMES)
    still = _recorded(scene, np.zeros((len(TIMES), 3)), v=np.stack([none, none, none], axis=1))
    assert _of(still, "Momentum that no effect explains") == pytest.approx(np.maximum(2.0 * 9.81 * TIMES, FLOOR))


def test_a_body_that_only_turns_shows_its_angle_and_the_spin_it_loses():
    spin = np.array([0.0, 0.0, 1.0])
    scene = Scene((Body("box", Box((0.2, 0.3, 0.4)), mass=1.0, angular_velocity=(0.0, 0.0, 1.0)),), (Rotation(),))
    q = np.stack([np.cos(TIMES / 2), 0 * TIMES, 0 * TIMES, np.sin(TIMES / 2)], axis=1)
    slowed = spin * (1.0 - 0.25 * TIMES[:, None])
    turned = _recorded(scene, np.zeros((len(TIMES), 3)), q=q, w=slowed)
    assert _of(turned, "Turn of box") == pytest.approx(TIMES, abs=1e-12)
    inertia = (0.2**2 + 0.3**2) / 12.0
    assert _of(turned, "Angular momentum") == pytest.approx(np.maximum(inertia * 0.25 * TIMES, FLOOR), abs=1e-15)


def test_overlap_is_minus_the_gap():
    bodies = (Body("floor", HalfSpace()), Body("ball", Sphere(0.1), mass=1.0, position=(0.0, 0.0, 0.5)))
    scene = Scene(bodies, (Gravity(), Restitution(0.5)))
    height = 0.5 - 0.3 * TIMES
    sunk = _recorded(scene, np.stack([0 * TIMES, 0 * TIMES, height], axis=1))
    assert _of(sunk, "Deepest overlap") == pytest.approx(np.maximum(0.1 - height, FLOOR))


def test_where_all_are_in_place_the_attitude_is_compared():
    scene = Scene((Body("box", Box((0.2, 0.3, 0.4)), mass=1.0, angular_velocity=(0.0, 0.0, 1.0)),), (Rotation(),))

    def truth(t: np.ndarray) -> Trajectory:
        q = np.stack([np.cos(t / 2), 0 * t, 0 * t, np.sin(t / 2)], axis=1)[:, None]
        return Trajectory(t, np.zeros((len(t), 1, 3)), q, np.zeros((len(t), 1, 3)), np.zeros((len(t), 1, 3)))

    still = _recorded(scene, np.zeros((len(TIMES), 3)), truth=truth)
    assert _of(still, "Angle from the true attitude") == pytest.approx(np.maximum(TIMES, FLOOR))
    shifted = replace(still, truth=lambda t: replace(truth(t), x=np.full((len(t), 1, 3), 1.0)))
    assert _of(shifted, "Distance from the truth") == pytest.approx(np.full(len(TIMES), math.sqrt(3.0)))


@given(st.lists(st.one_of(st.integers(0, 5).map(float), st.just(math.nan)), min_size=2, max_size=40))
def test_a_path_goes_through_every_point_and_stops_where_there_is_none(values):
    line = Series("mujoco", tuple(map(float, range(len(values)))), tuple(values), joined=True, marked=False)
    figure = Figure("", Axis("", limits=(0.0, 40.0)), Axis("", limits=(0.0, 5.0)), (line,))
    drawn = svg(figure, height=HEIGHT)
    (path,) = re.findall(r'class="line" d="([^"]*)" style', drawn)
    start, end, *_ = map(float, re.search(r'data-span="([^"]*)"', drawn)[1].split())
    strokes: list[list[np.ndarray]] = []
    for command, text in re.findall(r"([Mlh])([-\d. ]+)", path):
        step = np.array([*map(float, text.split()), 0.0][:2])
        if command == "M":
            strokes.append([step])
        else:
            strokes[-1].append(strokes[-1][-1] + step)
    known = [k for k, v in enumerate(values) if not math.isnan(v)]
    assert len(strokes) == sum(k - 1 not in known for k in known)
    for k in known:
        x, y = start + k / 40.0 * (end - start), HEIGHT - BOTTOM - values[k] / 5.0 * (HEIGHT - BOTTOM - TOP)
        (stroke,) = (np.array(s).T for s in strokes if s[0][0] - 0.1 <= x <= s[-1][0] + 0.1)
        assert np.interp(x, *stroke) == pytest.approx(
            y, abs=2.5
        )  # a tenth of a pixel across, on an edge of at most 188 px in 6
