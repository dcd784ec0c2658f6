"""The driver of engines: what an engine does ends as a Run; only the caller's mistakes raise."""

import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from adapters import registry
from adapters.engine import BadScene, Diverged, Refusal, checked_settings
from adapters.run import Failure, Timing, checked_times, prepare, run, sample_times
from mechanics.arrays import SceneError
from mechanics.effects import Drag, Force, Gravity, Rotation
from mechanics.scene import Body, Scene
from mechanics.shapes import Sphere
from mechanics.trajectory import Trajectory

BALL = Body("a", Sphere(0.1), mass=2.0, position=(0.0, 0.0, 5.0), velocity=(3.0, 0.0, 1.0))
SCENE = Scene((BALL, Body("b", Sphere(0.1))), (Gravity(),))
TIMES = np.linspace(0.0, 1.0, 11)


@pytest.fixture
def toy(toys):
    return toys["toy"]


@pytest.fixture
def faulty(toys):
    return toys["toy:faulty"]


def test_a_ball_in_free_flight_flies_along_the_parabola(toy):
    motion = run(toy, SCENE, TIMES).outcome
    t = TIMES[:, None]
    fall = np.array([3.0, 0.0, 1.0]) * t + 0.5 * np.array([0.0, 0.0, -9.81]) * t**2
    np.testing.assert_allclose(motion.x[:, 0], np.array([0.0, 0.0, 5.0]) + fall, atol=1e-13)
    np.testing.assert_array_equal(motion.x[:, 1], 0.0)
    np.testing.assert_allclose(motion.t, TIMES)


def test_only_what_the_scene_declares_is_switched_on(toy):
    motion = run(toy, Scene((BALL,)), TIMES).outcome
    np.testing.assert_allclose(motion.v[:, 0], np.tile(BALL.velocity, (11, 1)))


def test_an_effect_the_engine_does_not_list_is_refused_by_the_house(toy):
    outcome = run(toy, Scene((BALL,), (Drag(linear=1.0),)), TIMES).outcome
    assert isinstance(outcome, Refusal)
    assert outcome.reason == "toy has no Drag; it has Gravity, Rotation"


def test_an_engine_refuses_with_its_own_reason(toys):
    outcome = run(toys["toy:shy"], Scene((BALL,), (Force("a"),)), TIMES).outcome
    assert isinstance(outcome, Refusal)
    assert outcome.reason == "forces hurt"


def test_approximations_become_notes(toy):
    scene = Scene((BALL,), (Gravity(), Rotation()))
    assert prepare(toy, scene)[1] == ("rotation is read, not integrated",)
    assert run(toy, scene, TIMES).notes == ("rotation is read, not integrated",)


@pytest.mark.parametrize(("fault", "state", "stage"), [("raise", "error", "advance"), ("nan", "diverged", "read"),
                                                       ("oom", "oom", "advance")])  # fmt: skip
def test_a_failure_keeps_what_was_computed(toy, faulty, fault, state, stage):
    broken = run(faulty, SCENE, TIMES, {"fault": fault})
    assert isinstance(broken.outcome, Failure)
    assert (broken.outcome.state, broken.outcome.stage) == (state, stage)
    assert broken.outcome.time == pytest.approx(0.5)
    np.testing.assert_array_equal(broken.trajectory.x, run(toy, SCENE, TIMES).outcome.x[:6])


ERRORS = [
    (Diverged("solver warns"), "diverged"),
    (BadScene("they touch"), "error"),
    (SceneError("mass", 0, "> 0"), "error"),
    (MemoryError(), "oom"),
]


@pytest.mark.parametrize(("error", "state"), ERRORS)
@pytest.mark.parametrize("stage", ["build", "start", "read"])
def test_each_stage_reports_itself(toy, error, state, stage, monkeypatch):
    def fail(*_):
        raise error

    monkeypatch.setattr(toy, {"build": "vacuum", "start": "start", "read": "read"}[stage], fail)
    outcome = run(toy, SCENE, TIMES).outcome
    assert (outcome.state, outcome.stage, outcome.time) == (state, stage, 0.0)


def test_repeats_are_timed_and_compared(toy):
    timing = run(toy, SCENE, TIMES, repeats=3).timing
    assert timing.wall.shape == (3, 10)
    assert timing.cpu.shape == (3,)
    assert timing.deterministic
    assert timing.seconds == pytest.approx(timing.wall.min(axis=0).sum() * 1e-9)
    assert run(toy, SCENE, TIMES).timing.wall.shape == (1, 10)


def test_a_long_run_is_not_repeated_and_says_so(toy, monkeypatch):
    monkeypatch.setattr("adapters.run.LONG", 0)
    long = run(toy, SCENE, TIMES, repeats=3)
    assert long.timing.wall.shape[0] == 1
    assert long.notes[-1].startswith("run twice, not timed")


def test_an_engine_that_is_slow_only_in_its_first_run_is_timed(toy, monkeypatch):
    swift, first = toy.advance, [True]

    def compiles_itself_first(world, duration):
        if first[0]:
            time.sleep(0.02)
        swift(world, duration)

    def closes(world):
        first[0] = False

    monkeypatch.setattr("adapters.run.LONG", 100_000_000)  # ns; ten intervals of the first run take 0.2 s
    monkeypatch.setattr(toy, "advance", compiles_itself_first)
    monkeypatch.setattr(toy, "close", closes, raising=False)
    timed = run(toy, SCENE, TIMES, repeats=2)
    assert timed.timing.wall.shape == (2, 10)
    assert not timed.notes


def test_a_run_that_does_not_repeat_itself_says_so(toy, monkeypatch):
    calm, noise = toy.vacuum, iter(np.linspace(0.0, 1e-12, 20))

    def restless(scene):
        draft = calm(scene)
        draft.x = draft.x + next(noise)
        return draft

    monkeypatch.setattr(toy, "vacuum", restless)
    timing = run(toy, SCENE, TIMES, repeats=3).timing
    assert not timing.deterministic
    assert timing.seconds == pytest.approx(timing.cpu.min() * 1e-9)


@given(st.lists(st.lists(st.integers(1, 10**6), min_size=4, max_size=4), min_size=1, max_size=5))
def test_the_envelope_is_never_above_the_fastest_repeat(rows):
    wall = np.array(rows, dtype=np.int64)
    timing = Timing(wall, wall.sum(axis=1), ("same",) * len(rows))
    assert timing.seconds <= wall.sum(axis=1).min() * 1e-9 * (1 + 1e-12)
    assert timing.contention >= 0.0


def test_what_the_engine_knows_is_kept(toy):
    said = run(toy, SCENE, TIMES)
    assert said.knows_events
    assert said.events[0].impulse == 2.0
    assert said.audit == {"steps": 20.0}
    assert type(said.audit["steps"]) is float


def test_settings_are_the_engines_defaults_overlaid(toy, faulty):
    assert run(toy, SCENE, TIMES).settings == {"dt": 0.05}
    assert run(toy, SCENE, TIMES, {"dt": 0.025}).settings == {"dt": 0.025}
    assert checked_settings(faulty, {"fault": "nan"}) == {"dt": 0.05, "fault": "nan"}


@pytest.mark.parametrize(
    ("settings", "message"),
    [({"steps": 3}, "has no knob 'steps'; its knobs are dt, fault"), ({"dt": -1.0}, "a finite number > 0"),
     ({"dt": float("nan")}, "a finite number > 0"), ({"dt": "small"}, "a finite number > 0"),
     ({"fault": "flood"}, "allowed: none, segv")],
)  # fmt: skip
def test_impossible_settings_name_what_is_allowed(faulty, settings, message):
    with pytest.raises(ValueError, match=message):
        run(faulty, SCENE, TIMES, settings)


@pytest.mark.parametrize("times", [[0.0], [], [0.0, 0.0], [1.0, 0.5], [0.0, float("nan")], [-1.0, 1.0], [[0.0, 1.0]]])
def test_impossible_times_are_refused(toy, times):
    with pytest.raises(ValueError, match="at least two finite, increasing times"):
        run(toy, SCENE, times)


def test_times_that_begin_later_get_the_start(toy):
    assert checked_times([0.5, 1.0]).tolist() == [0.0, 0.5, 1.0]
    assert run(toy, SCENE, [0.5, 1.0]).outcome.t.tolist() == pytest.approx([0.0, 0.5, 1.0])


@given(st.floats(1e-3, 1e3), st.floats(1e-3, 1e2))
def test_samples_begin_at_zero_end_at_the_duration_and_never_lie_further_apart(duration, sampling):
    if duration / sampling > 1e4:
        sampling = duration / 1e4
    times = sample_times(duration, sampling)
    assert times[0] == 0.0
    assert times[-1] == pytest.approx(duration, rel=2e-9)
    steps = np.diff(times)
    assert (steps > 0.0).all()
    assert steps.max() <= sampling * (1 + 1e-6) or len(times) == 2


@pytest.mark.parametrize("bad", [0.0, -1.0, float("inf"), float("nan")])
def test_impossible_durations_are_refused(bad):
    with pytest.raises(ValueError, match="duration"):
        sample_times(bad, 0.1)
    with pytest.raises(ValueError, match="sampling"):
        sample_times(1.0, bad)


def test_the_world_is_closed_whatever_happens(faulty, monkeypatch):
    closed = []
    monkeypatch.setattr(type(faulty), "close", lambda self, world: closed.append(world), raising=False)
    run(faulty, SCENE, TIMES, {"fault": "raise"})
    run(faulty, SCENE, TIMES, repeats=2)
    assert len(closed) == 4


def test_a_world_that_cannot_be_closed_does_not_cost_the_run(toy, monkeypatch):
    monkeypatch.setattr(type(toy), "close", lambda self, world: 1 / 0, raising=False)
    assert isinstance(run(toy, SCENE, TIMES).outcome, Trajectory)


def test_registry_and_driver_agree_on_what_an_engine_is(toys):
    for name in toys:
        assert isinstance(run(registry.engine(name), SCENE, TIMES).trajectory, Trajectory)
