"""Motions whose events or passes would go on for ever, each brought to its end."""

import math

import numpy as np
import pytest

from mechanics.effects import Force, Gravity, Resting, Restitution, Rotation
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Sphere
from reference_impl.effects.impact import TURNS, Collision, sequential
from reference_impl.settings import Settings
from reference_impl.simulate import advance, begin

FLOOR = Body("floor", HalfSpace())


def test_bounces_on_a_box_that_lies_end_as_on_a_floor():
    """The box is borne, so the ball falls towards it with g and not with the little that its own load adds."""
    fall, e, more = 0.05, 0.5, 1.5e-4
    box = Body("box", Box((0.5, 0.5, 0.25)), 2.0, (0.0, 0.0, 0.125))
    ball = Body("ball", Sphere(0.1), 1.0, (0.0, 0.0, 0.35 + fall))
    effects = (Gravity(), Rotation(), Restitution(e), Resting(), Force("ball", (0.0, 0.0, -more)))
    world = begin(Scene((FLOOR, box, ball), effects), Settings(impact_law="simultaneous"))
    last = math.sqrt(2.0 * fall / (9.81 + more)) * (1.0 + e) / (1.0 - e)
    advance(world, last + 1e-3)
    state = world.state()
    assert np.abs(state.v).max() == 0.0
    assert state.x[2, 2] == pytest.approx(0.35, abs=1e-12)
    assert world.audit.events < 30  # each bounce takes half of the speed: from 1 m/s, thirty would leave 1e-9


@pytest.mark.parametrize("angle", [0.5, 0.1, 0.01])
def test_turns_of_contacts_that_do_not_bounce_end_in_one_solve(angle):
    """Two contacts that push into each other: every turn leaves cos 2θ of the speed, until one solve stops both."""
    rows = np.array([[math.sin(angle), math.cos(angle)], [math.sin(angle), -math.cos(angle)]])
    motion = np.array([-1.0, -0.2])
    collision = Collision(rows, motion, np.zeros(2), lambda u: np.zeros(2), 1e-12)
    outcome = sequential(collision)
    assert outcome.passes <= 2 * TURNS + 1
    assert np.abs(collision.speeds(outcome.impulses)).max() <= 1e-12
    assert (outcome.impulses >= 0.0).all()
