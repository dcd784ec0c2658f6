"""Cells that are compared are timed in turns, A B B A, and what one of them does is its own affair."""

import numpy as np
import pytest

from adapters.run import Failure, in_turns, run
from mechanics.effects import Gravity
from mechanics.scene import Body, Scene
from mechanics.shapes import Sphere
from mechanics.trajectory import Trajectory

SCENE = Scene((Body("a", Sphere(0.1), mass=1.0, velocity=(1.0, 0.0, 0.0)),), (Gravity(),))
TIMES = np.linspace(0.0, 1.0, 6)


@pytest.fixture
def cell(toys):
    """A function name -> cell that notes its turns; `breaks_at` is the turn in which it breaks."""

    def make(name, order, breaks_at=None):
        def once(sampled):
            order.append(name)
            engine, fault = toys["toy:faulty"], "raise" if order.count(name) == breaks_at else "none"
            return run(engine, SCENE, TIMES, {"fault": fault}, sampled=sampled)

        return once

    return make


@pytest.mark.parametrize(("repeats", "expected"), [(1, "ABC"), (2, "ABC CBA ABC"), (3, "ABC CBA ABC CBA")])
def test_turns_go_there_and_back(cell, repeats, expected):
    order = []
    runs = in_turns([cell(name, order) for name in "ABC"], repeats)
    assert "".join(order) == expected.replace(" ", "")
    assert [r.timing.wall.shape for r in runs] == [(repeats, 5)] * 3
    assert [len(r.timing.digests) for r in runs] == [repeats] * 3


def test_what_breaks_at_once_is_not_run_again(cell):
    order = []
    broken, whole = in_turns([cell("A", order, breaks_at=1), cell("B", order)], 3)
    assert "".join(order) == "ABBBB"
    assert isinstance(broken.outcome, Failure)
    assert isinstance(whole.outcome, Trajectory)
    assert whole.timing.wall.shape == (3, 5)


def test_what_breaks_in_a_repeat_is_broken_and_not_run_again(cell):
    order = []
    whole, broken = in_turns([cell("A", order), cell("B", order, breaks_at=2)], 3)
    assert "".join(order) == "ABBAAA"
    assert (broken.outcome.state, broken.outcome.stage) == ("error", "advance")
    assert isinstance(whole.outcome, Trajectory)


def test_the_motion_kept_is_that_of_the_warm_up_and_its_time_is_not_counted(toys, monkeypatch):
    toy = toys["toy"]
    begun = iter(range(10))
    calm = toy.vacuum
    monkeypatch.setattr(toy, "vacuum", lambda scene: _shifted(calm(scene), next(begun)))
    (found,) = in_turns([lambda sampled: run(toy, SCENE, TIMES, sampled=sampled)], 2)
    assert found.outcome.x[0, 0, 0] == 0.0
    assert len(set(found.timing.digests)) == 2


def test_states_are_not_read_on_the_way_when_it_is_timed(toys, monkeypatch):
    toy, read = toys["toy"], []
    look = toy.read
    monkeypatch.setattr(toy, "read", lambda world: read.append(world.clock.time) or look(world))
    found = run(toy, SCENE, TIMES, repeats=2)
    assert read == [*TIMES, 0.0, 1.0, 0.0, 1.0]
    assert len(found.outcome) == len(TIMES)
    assert found.timing.wall.shape == (2, 5)
    assert found.timing.digests == (found.outcome.digest(),) * 2
    ends = run(toy, SCENE, TIMES, sampled=False).outcome
    np.testing.assert_array_equal(ends.t, [0.0, 1.0])
    np.testing.assert_array_equal(ends.x, found.outcome.x[[0, -1]])


def _shifted(draft, by):
    draft.x = draft.x + by
    return draft
