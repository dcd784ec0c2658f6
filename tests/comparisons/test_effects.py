"""An effect that is switched on idly changes nothing, one that is left out does; and the comparison can tell."""

from dataclasses import replace

import numpy as np
import pytest

from adapters.registry import engine
from adapters.run import run, sample_times
from comparisons import variants
from comparisons.effects import ALL, CHANGED, SAME, SWITCHES, VERDICTS, prove
from comparisons.variants import HOW, VALUED, Room, idle, shaken, without
from mechanics.effects import EFFECTS, Drag, Friction, Gravity, Resting, Restitution, Rotation
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Sphere
from scenarios.scenario import Scenario

REFERENCE = engine("reference")
FLOOR = Body("floor", HalfSpace())
BALL = Body("ball", Sphere(0.1), 2.0, (0.3, 0.0, 5.0), velocity=(1.0, 0.0, 2.0))


def scenario(scene, duration=0.5):
    return Scenario(scene, duration, duration / 20.0, (), "none: made for this test", name="made")


def rows(scene, duration=0.5, engine=REFERENCE):
    proof = prove(engine, scenario(scene, duration), clock=0.0)
    assert proof.whole, proof.reason
    return {row.effect: row for row in proof.rows}


def test_idle_effects_leave_a_thrown_ball_on_its_parabola():
    scene = Scene((BALL,), (Gravity(),))
    times = sample_times(0.5, 0.025)
    room = Room.of(scene, run(REFERENCE, scene, times).outcome)
    parabola = np.add(BALL.position, np.outer(times, BALL.velocity)) - np.outer(0.5 * times**2, (0.0, 0.0, 9.81))
    for kind in set(EFFECTS.values()) - {Gravity}:
        motion = run(REFERENCE, idle(scene, kind, room), times).outcome
        np.testing.assert_allclose(motion.x[:, 0], parabola, atol=4e-15, err_msg=kind.__name__)


def test_every_effect_has_a_row_and_everything_else_together():
    found = rows(Scene((BALL,), (Gravity(),)))
    assert list(found) == [*EFFECTS, ALL]
    assert {row.verdict for row in found.values()} == {"same", "changes"} <= set(VERDICTS)
    assert [row.effect for row in found.values() if row.declared] == ["Gravity"]
    assert set(HOW) == set(EFFECTS.values()) == {*VALUED, Rotation, Restitution, Friction, Resting}


def test_the_difference_without_gravity_is_the_fall_over_the_way():
    row = rows(Scene((replace(BALL, velocity=(0.0, 0.0, 0.0)),), (Gravity(),)))["Gravity"]
    assert row.verdict == "changes"
    assert row.time == pytest.approx(0.025)
    first = 0.5 * 9.81 * 0.025**2 / (0.5 * 9.81 * 0.5**2 + 0.1), 9.81 * 0.025 / (9.81 * 0.5 + (2 * 9.81 * 0.1) ** 0.5)
    assert row.difference == pytest.approx(max(first), rel=1e-12)


def test_a_law_that_is_missing_is_named_by_the_engine():
    block = Body("block", Box((0.2, 0.2, 0.2)), 1.0, (0.0, 0.0, 0.1), velocity=(1.0, 0.0, 0.0))
    found = rows(Scene((FLOOR, block), (Gravity(), Friction(0.3), Resting())))
    assert found["Resting"].verdict == "missing"
    assert "'block' and 'floor' at t = 0 s" in found["Resting"].text
    ball = rows(Scene((FLOOR, replace(BALL, position=(0.0, 0.0, 0.2))), (Gravity(), Restitution(0.5), Resting())))
    assert ball["Restitution"].verdict == "missing"
    assert ball["Restitution"].time == pytest.approx((2.0 + (4.0 + 2 * 9.81 * 0.1) ** 0.5) / 9.81, abs=0.025)


def test_a_spin_at_the_start_demands_rotation():
    row = rows(Scene((replace(BALL, angular_velocity=(0.0, 1.0, 0.0)),), (Gravity(), Rotation())))["Rotation"]
    assert (row.verdict, row.time) == ("demanded", 0.0)
    assert "angular_velocity" in row.text


def test_a_declared_effect_that_does_nothing_is_found():
    assert rows(Scene((BALL,), (Gravity(), Rotation())))["Rotation"].verdict == "same"


@pytest.mark.parametrize("drag", [1e-3, 1e-8])
def test_an_effect_that_is_not_idle_is_found(monkeypatch, drag):
    monkeypatch.setitem(variants._IDLE, Drag, lambda scene, room: Drag(drag))
    row = rows(Scene((BALL,), (Gravity(),)))["Drag"]
    assert row.verdict == ("changes" if drag > CHANGED else "differs")
    assert row.difference > SAME


def test_rotation_that_a_scene_withholds_changes_its_motion():
    """A box that slides on a rough floor and would fall over if it might turn."""
    tall = Body("box", Box((0.1, 0.1, 0.6)), 1.0, (0.0, 0.0, 0.3), velocity=(2.0, 0.0, 0.0))
    row = rows(Scene((FLOOR, tall), (Gravity(), Friction(0.8), Resting())), 0.2)["Rotation"]
    assert (row.declared, row.verdict) == (False, "changes")


def test_two_runs_are_the_same_only_as_long_as_rounding_lets_them():
    """Balls between walls that curve outwards: every collision multiplies what rounding did to the last."""
    posts = [Body(f"post {i}", Sphere(0.5), position=(x, 0.0, z)) for i, (x, z) in
             enumerate([(-1.0, 0.0), (1.0, 0.0), (0.0, -1.0), (0.0, 1.0)])]  # fmt: skip
    ball = Body("ball", Sphere(0.2), 1.0, (0.02, 0.0, 0.05), velocity=(3.0, 0.0, 1.7))
    scene = Scene((*posts, ball), (Restitution(1.0),))
    found = rows(scene, 20.0)
    parted = [row for row in found.values() if row.verdict == "same until"]
    assert parted
    assert all("rounding" in row.text and row.time < 20.0 and row.difference <= SAME for row in parted)


def test_shaking_is_a_matter_of_rounding():
    scene = Scene((FLOOR, BALL), (Gravity(),))
    room = Room.of(scene, run(REFERENCE, scene, (0.0, 0.1)).outcome)
    shift = np.subtract(shaken(scene, room).body("ball").position, BALL.position)
    assert 0.0 < np.abs(shift).max() < 1e-15
    assert shaken(scene, room).body("floor") == FLOOR


def test_effects_are_left_out_by_type():
    scene = Scene((FLOOR, BALL), (Gravity(), Restitution(0.5)))
    assert without(scene, Gravity).effects == (Restitution(0.5),)
    with pytest.raises(ValueError, match="declares Gravity"):
        idle(scene, Gravity, Room(1.0, 1.0, 1.0, (0.0, 0.0), 1.0))


def test_an_engine_with_switches_of_its_own_is_compared_with_all_of_them_on():
    pytest.importorskip("mujoco")
    found = rows(Scene((BALL,), (Gravity(),)), engine=engine("mujoco"))
    assert (found[SWITCHES].verdict, found[SWITCHES].difference) == ("same", 0.0)
    assert SWITCHES not in rows(Scene((BALL,), (Gravity(),)))


def test_a_force_that_is_rounding_is_no_contact_that_lasts():
    """Balls that stick after a plastic collision push each other with a drag of 1e-17, of which nothing is left."""
    balls = [Body(f"ball {i}", Sphere(0.1), 1.0, (0.3 * i, 0.0, 0.0), velocity=(1.0 - i, 0.0, 0.0)) for i in range(3)]
    found = rows(Scene(tuple(balls), (Restitution(0.0),)), 1.0)
    assert {row.verdict for row in found.values() if not row.declared} == {"same"}
