"""The lecture's algorithm: right where it can be, and wrong in the ways its kind is known for."""

import math

import numpy as np
import pytest

from mechanics.effects import Friction, Gravity, Hinge, Resting, Restitution, Rotation
from mechanics.rotation import angle_between
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, Capsule, HalfSpace, Mesh, Sphere
from reference_impl import simulate
from reference_impl.errors import MissingEffect, Overlap, Stalled, Unsupported
from reference_impl.lecture import TOLERANCE, begin

G = 9.81
FLOOR = Body("floor", HalfSpace())
TETRAHEDRON = Mesh(
    ((1.0, 1.0, 1.0), (1.0, -1.0, -1.0), (-1.0, 1.0, -1.0), (-1.0, -1.0, 1.0)),
    ((0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)),
)


def ball(height, speed=0.0):
    return Body("ball", Sphere(0.1), 1.0, (0.0, 0.0, 0.1 + height), velocity=(0.0, 0.0, -speed))


def stack(masses):
    boxes = tuple(Body(f"box {i}", Box((0.2, 0.2, 0.2)), m, (0.0, 0.0, 0.1 + 0.2 * i)) for i, m in enumerate(masses))
    return Scene((FLOOR, *boxes), (Gravity(), Resting(), Rotation()))


def exact(scene, duration):
    """The state the reference engine gives."""
    return simulate.simulate(scene, [0.0, duration]).at(1)


def test_free_fall_is_exact():
    world = begin(Scene((ball(10.0),), (Gravity(),)), 1e-2)
    world.advance(1.0)
    assert world.state().x[0, 2] == pytest.approx(10.1 - 0.5 * G, abs=1e-13)
    assert world.audit.evaluations == 4 * 100


def test_free_rotation_is_fourth_order():
    brick = Body("brick", Box((0.4, 0.3, 0.1)), 2.0, angular_velocity=(3.0, 2.0, 1.0))
    scene = Scene((brick,), (Rotation(),))
    truth, errors = exact(scene, 1.0), []
    for dt in (0.02, 0.01):
        world = begin(scene, dt)
        world.advance(1.0)
        errors.append(float(angle_between(world.state().q[0], truth.q[0])))
    assert errors[0] / errors[1] == pytest.approx(16.0, rel=0.2)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-9])
@pytest.mark.parametrize("dt", [1e-2, 1e-3])
def test_a_contact_is_found_by_halving_the_step_to_the_tolerance(dt, tolerance):
    world = begin(Scene((FLOOR, ball(1.0)), (Gravity(), Restitution(0.8))), dt, tolerance)
    world.advance(0.6)
    falling = math.sqrt(2.0 / G)
    late = world.events[0].time - falling
    # it overlaps by one to two tolerances when it is stopped
    allowed = tolerance * 0.1 / math.sqrt(2.0 * G)
    assert allowed * 0.99 <= late <= 2.01 * allowed
    assert world.events[0].impulse == pytest.approx(1.8 * (math.sqrt(2.0 * G) + G * late), rel=1e-12)
    # halving a step of length dt down to the tolerance
    assert 1 <= world.audit.halvings <= math.log2(dt / allowed) + 1
    # each trial integrates once, and the step in which the contact lies is finished from there
    assert world.audit.evaluations == 4 * (round(0.6 / dt) + 1 + world.audit.halvings)


@pytest.mark.parametrize("e", [1.0, 0.8, 0.5])
def test_a_bouncing_ball_is_exact_between_impacts_that_are_exact(e):
    """Falls are parabolas, of which Runge-Kutta misses nothing: what is left is the tolerance over the speed.

    An impact that is two tolerances too deep, late by d, shifts the ball by (1 + e) v d, four tolerances at most, and
    its velocity by as much over its time of flight, 0.45 s to the next impact.  There are three at most.  And every
    step rounds the velocity by half a place of 4.4 m/s, which is carried along until the end.
    """
    scene = Scene((FLOOR, ball(1.0)), (Gravity(), Restitution(e)))
    world = begin(scene, 1e-3)
    for t in (0.4, 0.8, 1.2):
        world.advance(0.4)
        truth = exact(scene, t)
        rounding = t / 1e-3 * 4.5e-16
        assert world.state().x[1, 2] == pytest.approx(truth.x[1, 2], abs=12.0 * TOLERANCE * 0.1 + rounding * t)
        assert world.state().v[1, 2] == pytest.approx(truth.v[1, 2], abs=12.0 * TOLERANCE * 0.1 / 0.45 + rounding)


def test_far_from_the_origin_the_tolerance_is_above_the_rounding_of_places():
    """At 1e6 m places are known to 1e-10 m, a hundredth of what 1e-12 of a radius of 0.1 m would have to resolve."""
    floor = Body("floor", HalfSpace(), position=(0.0, 0.0, 1e6))
    above = Body("ball", Sphere(0.1), 1.0, (0.0, 0.0, 1e6 + 0.6))
    world = begin(Scene((floor, above), (Gravity(), Restitution(0.5))), 1e-3)
    assert world.tolerance == pytest.approx(1e-9, rel=1e-6)
    world.advance(0.5)
    assert len(world.events) == 1
    assert world.events[0].time == pytest.approx(math.sqrt(1.0 / G), abs=1e-9)


@pytest.mark.parametrize("tolerance", [0.0, 1e-14, 0.1, math.nan])
def test_a_tolerance_that_cannot_be_met_is_refused(tolerance):
    with pytest.raises(ValueError, match="allowed: a number from 1e-13 to 1e-2"):
        begin(Scene((FLOOR, ball(1.0)), (Restitution(0.5),)), 1e-3, tolerance)


@pytest.mark.parametrize("e", [1.0, 0.5])
def test_two_balls_collide_as_two_balls_do(e):
    a = Body("a", Sphere(0.1), 1.0, (-0.5, 0.0, 0.0), velocity=(2.0, 0.0, 0.0))
    b = Body("b", Sphere(0.1), 3.0, (0.5, 0.0, 0.0))
    world = begin(Scene((a, b), (Restitution(e),)), 1e-3)
    world.advance(1.0)
    first = 2.0 * (1.0 - 3.0 * e) / 4.0
    assert world.state().v[:, 0] == pytest.approx([first, 2.0 * (1.0 + e) / 4.0], abs=1e-12)
    assert len(world.events) == 1


def test_an_oblique_corner_impact_is_the_reference_s():
    box = Body("box", Box((0.3, 0.2, 0.1)), 1.0, (0.0, 0.0, 0.3), (0.8, 0.3, 0.4, 0.2), (0.5, 0.0, -2.0))
    scene = Scene((FLOOR, box), (Restitution(0.6), Rotation()))
    world = begin(scene, 1e-3)
    world.advance(0.08)
    truth = exact(scene, 0.08)
    assert len(world.events) == 1
    assert world.state().v == pytest.approx(truth.v, abs=1e-6)
    assert world.state().w == pytest.approx(truth.w, abs=1e-4)


def test_a_contact_that_comes_and_goes_within_a_step_is_missed():
    plate = Body("plate", Box((1.0, 1.0, 0.002)))
    bullet = Body("bullet", Sphere(0.005), 1.0, (0.0, 0.0, 0.05), velocity=(0.0, 0.0, -100.0))
    scene = Scene((plate, bullet), (Restitution(1.0),))
    world = begin(scene, 1e-3)
    world.advance(0.01)
    assert world.state().v[1, 2] == -100.0
    assert exact(scene, 0.01).v[1, 2] == pytest.approx(100.0)
    fine = begin(scene, 1e-5)
    fine.advance(0.01)
    assert fine.state().v[1, 2] == pytest.approx(100.0)


def test_impulses_in_turn_tip_over_a_box_that_lands_flat():
    box = Body("box", Box((0.4, 0.3, 0.2)), 1.0, (0.0, 0.0, 0.11), velocity=(0.0, 0.0, -1.0))
    scene = Scene((FLOOR, box), (Restitution(1.0), Rotation()))
    world = begin(scene, 1e-3)
    world.advance(0.02)
    assert np.abs(world.state().w[1]).max() > 0.1
    truth = exact(scene, 0.02)
    assert not np.abs(truth.w[1]).max() > 1e-12
    # what does not depend on the order is right all the same
    energy = 0.5 * (world.state().v[1] @ world.state().v[1] + world.state().w[1] @ world.y[1, 10:13])
    assert energy == pytest.approx(0.5, rel=1e-9)


def test_a_ball_comes_to_rest_below_the_threshold():
    world = begin(Scene((FLOOR, ball(0.05)), (Gravity(), Restitution(0.5), Resting())), 1e-3)
    world.advance(1.0)
    slow = [event.impulse for event in world.events if event.impulse < G * 1e-3]
    assert len(slow) == 1  # the last one takes what is left, without a bounce
    assert world.state().v[1, 2] == pytest.approx(0.0, abs=1e-12)
    # it lies where it was found: a little below the surface, or to the rounding of OSQP's answer above
    assert -3.0 * TOLERANCE * 0.1 <= world.state().x[1, 2] - 0.1 <= 1e-15
    assert [h.force for h in world.forces] == pytest.approx([G], rel=1e-12)


def test_rest_needs_its_effect():
    world = begin(Scene((FLOOR, ball(0.05)), (Gravity(), Restitution(0.5))), 1e-3)
    with pytest.raises(MissingEffect, match="does not declare Resting"):
        world.advance(1.0)


def test_a_collision_needs_its_effect():
    world = begin(Scene((FLOOR, ball(0.05)), (Gravity(), Resting())), 1e-3)
    with pytest.raises(MissingEffect, match=r"collide at 0\.99.* does not declare Restitution"):
        world.advance(1.0)


def test_a_stack_stands_and_every_layer_carries_what_is_above():
    world = begin(stack([1.0, 2.0, 3.0]), 1e-3)
    world.advance(0.1)
    assert world.state().x[1:, 2] == pytest.approx([0.1, 0.3, 0.5], abs=1e-8)
    loads = {}
    for h in world.forces:
        loads[frozenset((h.a, h.b))] = loads.get(frozenset((h.a, h.b)), 0.0) + h.force
    assert loads[frozenset((0, 1))] == pytest.approx(6.0 * G, rel=1e-6)
    assert loads[frozenset((1, 2))] == pytest.approx(5.0 * G, rel=1e-6)
    assert loads[frozenset((2, 3))] == pytest.approx(3.0 * G, rel=1e-6)
    assert world.audit.residual < 1e-8


def test_a_heavy_lid_is_too_much_for_the_square_form():
    scene = stack([1.0, 1.0, 1.0, 1e6])
    with pytest.raises(Stalled, match=r"OSQP has no answer to A f \+ b of 16 contacts"):
        begin(scene, 1e-3).advance(0.05)
    assert not np.abs(exact(scene, 0.05).v).max() > 1e-9


def test_a_thrown_box_comes_down_and_never_gains_energy():
    box = Body(
        "box", Box((0.4, 0.3, 0.2)), 1.0, (0.0, 0.0, 0.4), (1.0, 0.3, 0.2, 0.1), (0.3, 0.0, 0.0), (3.0, 2.0, 1.0)
    )
    world = begin(Scene((FLOOR, box), (Gravity(), Resting(), Restitution(0.4), Rotation())), 2e-3)
    energies = []
    for _ in range(20):
        world.advance(0.05)
        s = world.state()
        energies.append(0.5 * (s.v[1] @ s.v[1] + s.w[1] @ world.y[1, 10:13]) + G * s.x[1, 2])
    # while it rocks on its corners the gaps drift by the error of the steps: by one tolerance of 1e-6 it gained 1e-6
    assert np.diff(energies).max() <= 1e-6 * energies[0]
    assert 0.0999 < world.state().x[1, 2] < 0.2
    assert world.audit.gap > -1e-3


def test_it_repeats_itself_bit_for_bit():
    box = Body("box", Box((0.4, 0.3, 0.2)), 1.0, (0.0, 0.0, 0.25), (1.0, 0.3, 0.2, 0.1))
    scene = Scene((FLOOR, box), (Gravity(), Resting(), Restitution(0.2), Rotation()))
    states = []
    for _ in range(2):
        world = begin(scene, 2e-3)
        world.advance(0.4)
        states.append(world.y)
    assert np.array_equal(states[0], states[1])


@pytest.mark.parametrize(
    ("bodies", "effects", "said"),
    [
        ((FLOOR, Body("can", Capsule(0.1, 0.2), 1.0, (0, 0, 1))), (Restitution(0.5),), "'can', a Capsule"),
        ((FLOOR, Body("rock", TETRAHEDRON, 1.0, (0, 0, 2))), (Restitution(0.5),), "'rock', a Mesh"),
        ((FLOOR, ball(1.0)), (Friction(0.5),), "Friction with a coefficient of 0.5"),
        ((Body("a", Sphere(0.1), 1.0), Body("b", Sphere(0.1), 1.0, (1, 0, 0))), (Hinge("a", "b"),), "Hinge"),
    ],
)
def test_what_it_has_no_part_for_is_refused_by_name(bodies, effects, said):
    with pytest.raises(Unsupported, match=said):
        begin(Scene(bodies, effects), 1e-3)


def test_bodies_that_overlap_at_the_start_are_refused():
    with pytest.raises(Overlap, match="'ball' and 'floor' overlap"):
        begin(Scene((FLOOR, ball(-0.01)), (Restitution(0.5),)), 1e-3)
