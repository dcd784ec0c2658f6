"""The reference engine as the house sees it: names, refusals, failures, what it reports."""

from importlib.metadata import version

import numpy as np
import pytest

from adapters.conformance import check_engine
from adapters.engine import Refusal
from adapters.reference import ENGINES
from adapters.run import Failure, run
from mechanics.effects import Friction, Gravity, Hinge, Resting, Restitution, Rod, Rotation, Spring, Tether
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, Cylinder, HalfSpace, Sphere
from mechanics.trajectory import Trajectory
from reference_impl.errors import Stalled
from reference_impl.settings import Settings
from reference_impl.simulate import advance, begin

FLOOR = Body("floor", HalfSpace())
TABLE = Body("table", Box((1.0, 1.0, 0.2)))
BALL = Body("ball", Sphere(0.1), 1.0, (0.0, 0.0, 1.1))
OTHER = Body("other", Sphere(0.1), 1.0, (1.0, 0.0, 1.1))
GOING = Body("going", Sphere(0.1), 1.0, (1.0, 0.0, 1.1), velocity=(1.0, 0.0, 0.0))
REFERENCE = ENGINES["reference"]
NAMES = ("reference", "reference:sequential", "reference:simultaneous")


@pytest.mark.parametrize("name", NAMES)
def test_it_keeps_every_law_of_an_engine(name):
    broken = [law for law in check_engine(ENGINES[name]) if not law.passed]
    assert not broken
    assert ENGINES[name].name == name
    assert ENGINES[name].version == version("plumbline")


@pytest.mark.parametrize(("scene", "match"), [
    (Scene((BALL, GOING), (Rod("ball", "going"),)), "Rod between 'ball' and 'going': its ends part at 1 m/s"),
    (Scene((BALL, OTHER), (Tether("ball", "other", 0.5),)), "Tether between 'ball' and 'other': its anchors are 1 m"),
    (Scene((BALL, OTHER), (Spring("ball", "other", 1.0, 1.0, anchor_a=(1.0, 0.0, 0.0)),)), "its anchors coincide"),
    (Scene((TABLE, Body("can", Cylinder(0.1, 0.2), 1.0, (0.0, 0.0, 1.0))), (Restitution(0.5),)), "'can', a Cylinder"),
    (Scene((FLOOR, Body("low", Sphere(0.1), 1.0)), (Restitution(0.5),)), r"'low' and 'floor' overlap by 0\.1 m"),
])  # fmt: skip
def test_what_it_cannot_do_is_refused_with_the_reason(scene, match):
    outcome = run(REFERENCE, scene, (0.0, 0.1)).outcome
    assert isinstance(outcome, Refusal)
    with pytest.raises(Refusal, match=match):
        raise outcome


@pytest.mark.parametrize("name", ["reference:lecture", "reference:penalty"])
@pytest.mark.parametrize("effect", [Spring("ball", "other", 1.0, 1.0), Rod("ball", "other"),
                                    Tether("ball", "other", 2.0), Hinge("ball", "other")])  # fmt: skip
def test_the_older_methods_have_no_part_for_joints(name, effect):
    outcome = run(ENGINES[name], Scene((BALL, OTHER), (Rotation(), effect)), (0.0, 0.1)).outcome
    assert isinstance(outcome, Refusal)
    with pytest.raises(Refusal, match=type(effect).__name__):
        raise outcome


def test_joints_are_among_its_effects():
    scene = Scene((BALL, OTHER), (Gravity(), Rotation(), Rod("ball", "other"), Spring("ball", "other", 1.0, 1.0)))
    made = run(REFERENCE, scene, (0.0, 1.0))
    assert isinstance(made.outcome, Trajectory)
    assert made.outcome.x[1, :, 2] == pytest.approx(1.1 - 4.905, abs=1e-12)
    assert 0.0 <= made.audit["drift"] <= 1e-15


def test_smooth_friction_is_no_friction():
    scene = Scene((FLOOR, BALL), (Gravity(), Restitution(0.8), Friction(0.0)))
    bare = Scene((FLOOR, BALL), (Gravity(), Restitution(0.8)))
    first, second = (run(REFERENCE, s, (0.0, 1.0)).outcome for s in (scene, bare))
    assert isinstance(first, Trajectory)
    assert first.digest() == second.digest()


@pytest.mark.parametrize(("effects", "match"), [
    ((Gravity(), Restitution(0.5)), r"'ball' and 'floor' at t = 1\.354.*does not declare Resting"),
    ((Gravity(), Resting()), r"collide at 4\.4294.*'ball' and 'floor'.*does not declare Restitution"),
])  # fmt: skip
def test_a_missing_effect_is_an_error_that_names_effect_bodies_and_time(effects, match):
    made = run(REFERENCE, Scene((FLOOR, BALL), effects), np.linspace(0.0, 2.0, 21))
    assert isinstance(made.outcome, Failure)
    assert made.outcome.state == "error"
    with pytest.raises(AssertionError, match=match):
        raise AssertionError(made.outcome.reason)
    assert len(made.partial) > 1


def test_a_run_reports_impacts_contacts_and_its_own_soundness():
    box = Body("box", Box((0.4, 0.4, 0.2)), 2.0, (0.0, 0.0, 0.5))
    scene = Scene((FLOOR, box), (Gravity(), Rotation(), Restitution(0.3), Resting()))
    made = run(REFERENCE, scene, (0.0, 2.0), repeats=2)
    assert made.knows_events
    first = made.events[0]
    assert (first.a, first.b, first.normal) == ("box", "floor", (0.0, 0.0, 1.0))
    assert first.time == pytest.approx((0.8 / 9.81) ** 0.5, rel=1e-12)
    assert sum(c.force[2] for c in made.contacts) == pytest.approx(2.0 * 9.81, rel=1e-13)
    assert made.timing.deterministic
    assert made.audit["rests"] == 1.0
    assert made.audit["energy_rise"] <= 1e-12
    assert made.audit["gap"] >= -1e-11
    assert 0.0 <= made.audit["residual"] <= 1e-10


def test_a_budget_ends_what_would_take_for_ever_and_keeps_the_time():
    world = begin(Scene((FLOOR, BALL), (Gravity(), Restitution(1.0))), Settings(events=10))
    with pytest.raises(Stalled, match="more than 10 contacts in one call at t = "):
        advance(world, 1e9)
    assert len(world.events) == 11
    assert world.t >= world.events[-1].time
    assert world.state().x[1, 2] == pytest.approx(0.1, abs=1e-13)  # where it got to: back on the floor


def test_the_laws_differ_where_contacts_are_simultaneous_and_only_there():
    cue = Body("cue", Sphere(0.5), 1.0, (-1.5, 0.0, 0.0), velocity=(1.0, 0.0, 0.0))
    balls = tuple(Body(f"b{i}", Sphere(0.5), 1.0, (float(i), 0.0, 0.0)) for i in range(2))
    chain, pair = (Scene((cue, *balls[:k]), (Restitution(1.0),)) for k in (2, 1))
    ends = [
        {n: run(e, s, (0.0, 1.0)).outcome.digest() for n, e in ENGINES.items() if n in NAMES} for s in (chain, pair)
    ]
    assert len(set(ends[0].values())) == 2  # propagation and one at a time agree in a line
    assert len(set(ends[1].values())) == 1
