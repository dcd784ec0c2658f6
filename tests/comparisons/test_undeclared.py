"""What a motion needs and its scene does not declare is named, with effect, bodies and time, for every engine."""

import math
from dataclasses import replace

import numpy as np
import pytest

from adapters.registry import engine
from adapters.run import Failure, Run, run, sample_times
from comparisons.judge import judge
from comparisons.measurement import Case
from comparisons.undeclared import missing
from mechanics.effects import Force, Friction, Gravity, Resting, Restitution, Rotation
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Sphere
from scenarios import catalogue
from scenarios.scenario import Check, Scenario

ENGINES = ["reference", "mujoco", "pybullet", "pymunk"]
every_engine = pytest.mark.parametrize("name", ENGINES)
FLOOR = Body("floor", HalfSpace())
BALL = Body("ball", Sphere(0.1), 1.0, (0.0, 0.0, 0.6))
FALL = math.sqrt(2.0 * 0.5 / 9.81)  # until the ball is on the floor [s]


def own(scene, duration=0.6, checks=()):
    return Scenario(scene, duration, 0.01, checks, "none: made for this test", name="own")


def ran(name, scene, duration=0.6, checks=()):
    pytest.importorskip(name if name != "reference" else "numpy")
    scenario = own(scene, duration, checks)
    return scenario, run(engine(name), scene, sample_times(duration, 0.01))


def found(name, scene, duration=0.6):
    scenario, done = ran(name, scene, duration)
    return missing(Case(scenario, done, done.trajectory))


@every_engine
def test_bodies_that_meet_without_any_contact_effect(name):
    (one,) = found(name, Scene((FLOOR, BALL), (Gravity(),)))
    assert one.effect == "Restitution or Resting"
    assert set(one.bodies) == {"ball", "floor"}
    assert one.time == pytest.approx(FALL, abs=0.011)


@every_engine
def test_such_a_scene_is_an_error_of_which_nothing_is_demanded(name):
    scenario, done = ran(name, Scene((FLOOR, BALL), (Gravity(),)))
    judged = judge(scenario, done)
    assert (judged.state, judged.stage) == ("error", "advance")
    assert "does not declare Restitution or Resting" in judged.reason
    assert "'floor' and 'ball' at t = 0.32" in judged.reason
    demanded = replace(scenario, checks=(Check("energy error", 1.0, "anything will do for this test"),))
    assert judge(demanded, done).state == "ok"


@pytest.mark.parametrize("name", ["mujoco", "pybullet", "pymunk"])
def test_a_ball_that_drops_on_a_floor_on_which_it_may_only_lie(name):
    (one,) = found(name, Scene((FLOOR, BALL), (Gravity(), Resting())))
    assert one.effect == "Restitution"
    assert one.time == pytest.approx(FALL, abs=2e-3)
    assert f"{9.81 * FALL:.1f}"[:2] in one.why


@pytest.mark.parametrize("name", ["mujoco", "pymunk"])
def test_a_ball_that_lies_where_it_may_only_bounce(name):
    """PyBullet, told so, lets it sink slowly; in the others it lies."""
    (one,) = found(name, Scene((FLOOR, replace(BALL, position=(0.0, 0.0, 0.1))), (Gravity(), Restitution(0.0))))
    assert (one.effect, one.time) == ("Resting", 0.0)


def test_the_reference_stops_there_itself_and_says_the_same():
    for effects, word in (((Gravity(), Resting()), "Restitution"), ((Gravity(), Restitution(0.0)), "Resting")):
        _, done = ran("reference", Scene((FLOOR, BALL), effects))
        assert isinstance(done.outcome, Failure)
        assert f"t = {FALL:.9g} s), but the scene does not declare {word}" in done.outcome.reason


@every_engine
def test_a_moment_on_a_body_in_flight_that_may_not_turn(name):
    scene = Scene((BALL,), (Force("ball", torque=(0.0, 0.5, 0.0), start=0.2),))
    if name == "reference":
        _, done = ran(name, scene)
        assert done.outcome.time == pytest.approx(0.2, abs=0.011)
        assert "a moment of 0.5 N m acts on a body in flight ('ball' at t = 0.2 s)" in done.outcome.reason
        assert done.outcome.reason.endswith("does not declare Rotation")
        return
    (one,) = found(name, scene)
    assert (one.effect, one.bodies) == ("Rotation", ("ball",))
    assert one.time == pytest.approx(0.2, abs=1e-9)


@every_engine
def test_a_force_beside_the_centre_is_a_moment_and_one_in_line_with_it_is_none(name):
    beside = Force("ball", force=(0.0, 0.0, 1.0), point=(0.05, 0.0, 0.0))
    scenario, done = ran(name, Scene((BALL,), (beside,)))
    said = done.outcome.reason if name == "reference" else judge(scenario, done).reason
    assert "a moment of 0.05 N m acts on a body in flight ('ball' at t = 0 s)" in said
    assert not found(name, Scene((BALL,), (replace(beside, point=(0.0, 0.0, 0.05)),)))


@every_engine
def test_what_a_box_lies_on_balances_a_moment(name):
    box = Body("box", Box((0.2, 0.2, 0.2)), 1.0, (0.0, 0.0, 0.1))
    push = Force("box", force=(1.0, 0.0, 0.0), point=(0.0, 0.0, 0.02))
    assert not found(name, Scene((FLOOR, box), (Gravity(), Friction(0.5), Resting(), push)))


@pytest.mark.parametrize("name", ["reference", "mujoco", "pymunk"])
def test_friction_turns_a_ball_that_slides(name):
    ball = replace(BALL, position=(0.0, 0.0, 0.1), velocity=(1.0, 0.0, 0.0))
    effects = (Gravity(), Friction(0.3), Resting())
    (one,) = found(name, Scene((FLOOR, ball), effects), 0.2)
    assert (one.effect, one.bodies) == ("Rotation", ("ball", "floor"))
    assert not found(name, Scene((FLOOR, ball), (*effects, Rotation())), 0.2)


def test_bodies_drawn_into_each_other_are_left_alone():
    inside = Body("pin", Sphere(0.05), position=BALL.position)
    assert not found("reference", Scene((inside, BALL), (Gravity((0.0, 0.0, -1e-3)),)))


def test_no_truth_of_the_catalogue_needs_what_its_scene_does_not_declare():
    for scenario in catalogue.suite("standard"):
        if scenario.truth is None:
            continue
        times = np.linspace(0.0, scenario.duration, 60)
        done = Run("truth", "", {"dt": 1e-9}, scenario.truth(times))
        assert not missing(Case(scenario, done, done.outcome)), scenario.name
