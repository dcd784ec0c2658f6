"""What a scene calls for is told from the scene alone, and certain where it says so."""

import math
from dataclasses import replace

import pytest

from comparisons.calls import ACTS, CANNOT, MAY, calls, first_meeting
from mechanics.effects import (
    EFFECTS,
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
from mechanics.rotation import about
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Sphere
from scenarios import catalogue

FLOOR = Body("floor", HalfSpace())
BALL = Body("ball", Sphere(0.1), 1.0, (0.0, 0.0, 1.1))
OTHER = Body("other", Sphere(0.1), 1.0, (1.2, 0.0, 1.1))
CUBE = Body("cube", Box((0.2, 0.2, 0.2)), 1.0, (0.0, 0.0, 1.1))


def told(scene, effect, duration=math.inf):
    return next(call for call in calls(scene, duration) if call.effect == effect.__name__)


def test_there_is_an_answer_for_every_effect():
    assert [call.effect for call in calls(Scene((BALL,)))] == list(EFFECTS)
    assert {call.answer for call in calls(Scene((BALL,)))} == {CANNOT}


@pytest.mark.parametrize("turn", [0.0, 0.7])
def test_a_ball_falls_on_a_floor_at_the_time_of_free_fall(turn):
    """Also if the floor is a half-space turned about y: then it is met where its normal says."""
    slope = Body("floor", HalfSpace(), orientation=tuple(about((0.0, 1.0, 0.0), turn)))
    meeting = first_meeting(Scene((slope, BALL), (Gravity(),)))
    height = 1.1 * math.cos(turn) - 0.1
    assert meeting.time == pytest.approx(math.sqrt(2.0 * height / (9.81 * math.cos(turn))), rel=1e-12)
    assert meeting.certain
    assert told(Scene((FLOOR, BALL), (Gravity(), Restitution(0.5))), Restitution).answer == ACTS
    assert told(Scene((FLOOR, BALL), (Gravity(), Restitution(0.5))), Restitution, 0.4).answer == CANNOT


def test_two_balls_meet_when_their_centres_are_two_radii_apart():
    fast = replace(BALL, velocity=(2.0, 0.0, 0.0))
    for effects in ((), (Gravity(),)):  # gravity pulls both alike
        assert first_meeting(Scene((fast, OTHER), effects)).time == pytest.approx(0.5, rel=1e-12)
    assert isinstance(first_meeting(Scene((replace(BALL, velocity=(2.0, 0.0, 1.0)), OTHER))), str)


def test_a_thrown_ball_may_miss_a_fixed_one():
    thrown = replace(BALL, velocity=(1.0, 0.0, 0.0))
    fixed = replace(OTHER, mass=None)
    assert isinstance(first_meeting(Scene((thrown, fixed), (Gravity(),))), str)
    assert first_meeting(Scene((thrown, fixed))).time == pytest.approx(1.0, rel=1e-12)


def test_a_lone_body_meets_nobody():
    for kind in (Restitution(0.5), Friction(0.5), Resting()):
        call = told(Scene((BALL,), (Gravity(), kind)), type(kind))
        assert (call.declared, call.answer, call.why) == (True, CANNOT, "there is one body")
        assert "could be left out" in call.sentence


def test_turning_needs_a_force_beside_the_centre():
    smooth = Scene((FLOOR, BALL), (Gravity(), Restitution(0.5)))
    assert told(smooth, Rotation).answer == CANNOT
    rough = Scene((FLOOR, BALL), (Gravity(), Restitution(0.5), Friction(0.1)))
    assert told(rough, Rotation).answer == MAY
    assert told(Scene((FLOOR, CUBE), smooth.effects), Rotation).answer == MAY
    assert told(Scene((BALL,), (Force("ball", torque=(0.0, 1.0, 0.0)),)), Rotation).answer == ACTS
    beside = Force("ball", force=(0.0, 0.0, 1.0), point=(0.1, 0.0, 0.0))
    assert told(Scene((BALL,), (beside,)), Rotation).answer == ACTS
    assert told(Scene((BALL,), (replace(beside, point=(0.0, 0.0, 0.1)),)), Rotation).answer == CANNOT
    assert told(Scene((BALL,), (replace(beside, start=3.0),)), Rotation, 2.0).answer == CANNOT
    spinning = replace(BALL, angular_velocity=(0.0, 1.0, 0.0))
    assert told(Scene((spinning,), (Rotation(),)), Rotation).answer == ACTS
    assert told(Scene((BALL, OTHER), (Rod("ball", "other"),)), Rotation).answer == CANNOT
    assert told(Scene((BALL, OTHER), (Rod("ball", "other", anchor_a=(0.1, 0.0, 0.0)),)), Rotation).answer == MAY
    assert told(Scene((FLOOR, BALL), (Rotation(), Hinge("ball", "floor"))), Rotation).answer == ACTS


def test_nothing_lies_where_nothing_presses():
    pair = (replace(BALL, velocity=(2.0, 0.0, 0.0)), OTHER)
    assert told(Scene(pair, (Restitution(0.0), Resting())), Resting).answer == CANNOT
    assert told(Scene((FLOOR, *pair), (Gravity(), Restitution(0.0), Resting())), Resting).answer == MAY


@pytest.mark.parametrize(
    "effect",
    [
        Gravity((0.0, 0.0, 0.0)),
        Drag(),
        Drag(angular=0.1),
        Force("ball"),
        Force("ball", force=(1.0, 0.0, 0.0), start=5.0),
        Spring("ball", "other", 0.0, 1.0),
        Friction(0.0),
        Rod("floor", "post"),
        Tether("floor", "post", 1.0),
        Spring("floor", "post", 10.0, 1.0),
    ],
    ids=repr,
)
def test_an_effect_without_consequence_is_called_that(effect):
    post = Body("post", Sphere(0.1), position=(5.0, 0.0, 1.0))
    assert told(Scene((FLOOR, post, BALL, OTHER), (effect,)), type(effect), 2.0).answer == CANNOT


def test_of_several_effects_of_a_kind_one_that_acts_is_enough():
    scene = Scene((BALL,), (Force("ball"), Force("ball", force=(1.0, 0.0, 0.0))))
    assert told(scene, Force).answer == ACTS


def test_the_catalogue_declares_nothing_that_cannot_act_and_all_that_must():
    odd = {
        (scenario.name, call.effect)
        for scenario in catalogue.suite("full")
        for call in calls(scenario.scene, scenario.duration)
        if (call.declared, call.answer) in ((True, CANNOT), (False, ACTS))
    }
    # a ladder of tunnelling: balls that an engine leaves in the wall are to be allowed to stay there
    assert odd == {("thin-wall", "Resting")}
