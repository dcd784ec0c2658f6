"""Degenerate worlds: none and one body, motion taken up in mid-flight, interruption, budgets, very many contacts."""

from __future__ import annotations

import contextlib
from itertools import product

import numpy as np
import pytest

from mechanics.effects import Drag, Friction, Gravity, Resting, Restitution, Rotation
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Sphere
from reference_impl import simulate as loop
from reference_impl.errors import Stalled
from reference_impl.settings import Settings
from reference_impl.simulate import advance, begin, simulate
from reference_impl.world import STILL

FLOOR = Body("floor", HalfSpace())
ALL = (Gravity(), Rotation(), Restitution(0.5), Friction(0.3), Resting(), Drag(0.0))


@pytest.mark.parametrize("bodies", [(FLOOR,), (Body("ball", Sphere(0.1)),)])
def test_a_world_in_which_nothing_can_move_stands(bodies):
    world = begin(Scene(bodies, ALL))
    advance(world, 1e6)
    assert world.t == 1e6
    assert (world.state().x[0] == bodies[0].position).all()
    assert world.audit.events == 0


def test_one_body_alone_falls_under_all_effects_as_under_gravity():
    ball = Body("ball", Sphere(0.1), 1.0, (0.0, 0.0, 3.0), velocity=(1.0, 0.0, 2.0))
    ends = [simulate(Scene((ball,), effects), (0.0, 0.7)) for effects in (ALL, (Gravity(),))]
    assert (ends[0].x == ends[1].x).all()
    assert (ends[0].v == ends[1].v).all()
    assert ends[0].x[-1, 0, 2] == pytest.approx(3.0 + 1.4 - 0.5 * 9.81 * 0.49, rel=1e-15)


@pytest.mark.parametrize("duration", [0.0, -1.0, 5e-324])
def test_no_time_changes_nothing(duration):
    world = begin(Scene((FLOOR, Body("ball", Sphere(0.1), 1.0, (0.0, 0.0, 0.5))), ALL))
    advance(world, 0.2)
    before, t = world.state(), world.t
    advance(world, duration)
    assert world.t == t
    assert (world.state().x == before.x).all()


def test_an_interruption_leaves_the_world_readable_and_able_to_go_on(monkeypatch):
    """Ctrl-C between two events: the state is finite and at the time it says, and going on ends where it would have."""
    box = Body("box", Box((0.2, 0.2, 0.2)), 1.0, (0.0, 0.0, 1.1))
    scene = Scene((FLOOR, box), (Gravity(), Restitution(0.9), Resting()))
    undisturbed, world = begin(scene), begin(scene)
    advance(undisturbed, 3.0)
    real, calls = loop.settle, []

    def interrupted(world):
        calls.append(world.t)
        if len(calls) == 4:
            raise KeyboardInterrupt
        real(world)

    monkeypatch.setattr(loop, "settle", interrupted)
    with pytest.raises(KeyboardInterrupt):
        advance(world, 3.0)
    state = world.state()
    assert state.t == world.t == calls[-1]
    assert 0.0 < world.t < 3.0
    assert np.isfinite(state.x).all()
    advance(world, 3.0 - world.t)
    assert [e.time for e in world.events] == [e.time for e in undisturbed.events]
    assert (world.state().x == undisturbed.state().x).all()


@pytest.mark.parametrize("events", [1, 5, 50])
def test_a_budget_of_contacts_ends_a_run_where_it_is_spent(events):
    """What was computed is kept: as many events as were paid for, each where an unlimited run has it."""
    scene = Scene((FLOOR, Body("ball", Sphere(0.1), 1.0, (0.0, 0.0, 1.1))), (Gravity(), Restitution(1.0)))
    world, free = begin(scene, Settings(events=events)), begin(scene)
    with pytest.raises(Stalled, match=f"more than {events} contacts"):
        advance(world, 1e3)
    advance(free, world.t)
    assert [e.time for e in world.events] == [e.time for e in free.events][: len(world.events)]
    assert world.audit.events == events + 1


@pytest.mark.parametrize("steps", [1, 5])
def test_a_budget_of_steps_ends_lasting_contact_where_it_is_spent(steps):
    """A rod that falls over on a smooth floor needs many steps; the motion goes on from where the budget ended."""
    lean = 0.35
    rod = Body("rod", Box((0.1, 0.1, 1.0)), 1.0, (0.0, 0.0, 0.5 * np.cos(lean) + 0.05 * np.sin(lean)),
               (np.cos(0.5 * lean), 0.0, np.sin(0.5 * lean), 0.0))  # fmt: skip
    scene = Scene((FLOOR, rod), (Gravity(), Rotation(), Resting()))
    world, free = begin(scene, Settings(steps=steps)), begin(scene)
    with pytest.raises(Stalled, match=f"more than {steps} steps of lasting contact in one call at t = "):
        advance(world, 0.4)
    assert 0.0 < world.t < 0.4
    assert world.audit.steps + world.audit.rejected == steps + 1
    while world.t < 0.4:
        with contextlib.suppress(Stalled):
            advance(world, 0.4 - world.t)
    advance(free, 0.4)
    assert (world.state().x == free.state().x).all()


def test_boxes_side_by_side_are_as_many_islands():
    """64 boxes on a floor, 256 contacts: every one is an island, and all come to proven rest at once."""
    boxes = [
        Body(f"b{i}-{k}", Box((0.2, 0.2, 0.2)), 1.0, (0.3 * i, 0.3 * k, 0.1)) for i, k in product(range(8), repeat=2)
    ]
    world = begin(Scene((FLOOR, *boxes), (Gravity(), Rotation(), Resting())))
    advance(world, 1.0)
    assert (world.mode[1:] == STILL).all()
    assert sum(h.force for h in world.forces) == pytest.approx(64 * 9.81, rel=1e-12)
    assert world.audit.events == 64


def test_effects_that_nothing_calls_for_change_no_bit():
    """Resting where nothing rests, Drag of nothing, Rotation of smooth balls, Friction of zero, alone and together."""
    balls = [
        Body(f"b{i}", Sphere(0.1), 1.0 + i, (0.5 * i, 0.01 * i, 0.0), velocity=(1.0 - i, 0.0, 0.1 * i))
        for i in range(4)
    ]
    spare = (Resting(), Drag(0.0), Rotation(), Friction(0.0))
    plain = simulate(Scene(tuple(balls), (Restitution(0.7),)), (0.0, 0.5, 1.0))
    for more in (*((one,) for one in spare), spare):
        said = simulate(Scene(tuple(balls), (Restitution(0.7), *more)), (0.0, 0.5, 1.0))
        assert (said.x == plain.x).all()
        assert (said.v == plain.v).all()
