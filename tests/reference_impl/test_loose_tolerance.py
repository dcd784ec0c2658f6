"""A coarser tolerance costs accuracy, and nothing else: whatever comes to rest still does."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mechanics.effects import Friction, Gravity, Resting, Restitution, Rotation
from mechanics.rotation import about, normalised
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace
from reference_impl.course import Course
from reference_impl.friction_problem import Rough, residual, solve
from reference_impl.settings import Settings
from reference_impl.simulate import advance, begin
from reference_impl.world import World

# closest where the stops of a search and of a step once disagreed
TOLERANCES = (1e-13, 1e-10, 3.2e-9, 1e-8, 1e-6, 1e-5, 1e-4)


def landing_on_an_edge() -> Scene:
    angle = math.radians(10.0)
    height = 0.5 + 0.25 * (math.cos(angle) + math.sin(angle))
    turned = tuple(about((0.0, 1.0, 0.0), angle).tolist())
    box = Body("box", Box((0.5, 0.5, 0.5)), 1.0, (0.0, 0.0, height), turned)
    return Scene((Body("floor", HalfSpace()), box), (Gravity(), Restitution(0.3), Friction(0.5), Resting(), Rotation()))


def thrown() -> Scene:
    turned = tuple(normalised(np.array((0.9, 0.3, 0.2, 0.25))).tolist())
    box = Body("box", Box((0.5, 0.4, 0.3)), 1.0, (0.0, 0.0, 1.0), turned, (0.7, 0.2, 0.5), (2.0, -1.0, 3.0))
    return Scene((Body("floor", HalfSpace()), box), (Gravity(), Restitution(0.4), Friction(0.4), Resting(), Rotation()))


def carried(scene: Scene, tolerance: float, duration: float) -> World:
    world = begin(scene, Settings(tolerance=tolerance))
    advance(world, duration)
    return world


@pytest.mark.parametrize("tolerance", TOLERANCES)
def test_a_cube_that_lands_on_an_edge_comes_to_proven_rest_at_any_tolerance(tolerance):
    world = carried(landing_on_an_edge(), tolerance, 2.0)
    length = world.scales.length
    assert world.audit.rests == 1
    assert abs(world.state().x[1, 2] - 0.25) <= 10.0 * max(tolerance, 1e-12) * length  # as deep as what touches
    assert world.audit.gap >= -10.0 * max(tolerance, 1e-12) * length
    assert world.audit.friction_residual <= max(1e-12, tolerance)


@pytest.mark.parametrize("tolerance", [1e-13, 3.2e-9, 1e-5])
def test_a_thrown_box_comes_to_proven_rest_at_any_tolerance(tolerance):
    world = carried(thrown(), tolerance, 3.0)
    assert world.audit.rests == 1
    assert world.audit.energy_rise <= 1e-12 * 9.81
    assert world.audit.friction_residual <= max(1e-12, tolerance)


@pytest.mark.parametrize("tolerance", [1e-7, 1e-4])
def test_the_end_of_a_slip_that_turns_needs_few_evaluations(tolerance, monkeypatch):
    """An implicit step beyond the stop is not found, and halving it again and again would find nothing either."""
    count, rate = 0, Course.__call__

    def counted(self, t, y):
        nonlocal count
        count += 1
        return rate(self, t, y)

    monkeypatch.setattr(Course, "__call__", counted)
    world = carried(thrown(), tolerance, 3.0)
    assert world.audit.rests == 1
    assert count <= 8_000  # with halvings it was 15,652 at 1e-7; an implicit step takes 90 to 120


def at_two_heights(shift: float) -> Rough:
    """Impulses on a cube on four corners, of which two are higher by `shift` and bounce; unit mass and moments."""
    rows, least = [], []
    for x in (-1.0, 1.0):
        for y in (-1.0, 1.0):
            arm = np.array((x, y, -1.0 + (shift if y > 0.0 else 0.0)))
            rows += [np.concatenate([t, np.cross(arm, t)]) for t in np.eye(3)[[2, 0, 1]]]
            least += [0.1 if y > 0.0 else 0.0, 0.0, 0.0]
    motion = np.array((0.0, 0.2, -0.6, 0.2, 0.0, 0.0))
    return Rough(np.array(rows), motion, np.array(least), np.full(4, 0.5), np.zeros(4, dtype=np.bool_))


@pytest.mark.parametrize("shift", [1e-3, 1e-5, 1e-7, 1e-9])
def test_contacts_at_two_heights_that_cannot_all_hold_are_solved_to_rounding(shift):
    problem = at_two_heights(shift)
    answer = solve(problem)
    assert residual(problem, answer.r.ravel()) <= 1e-12
    # one pair slides by what the turn moves it at its height
    slip = np.hypot(answer.u[:, 1], answer.u[:, 2])
    assert slip.max() == pytest.approx(0.05 * shift, rel=1e-2)
