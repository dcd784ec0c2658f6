"""Rods and hinges against closed forms and the laws of momentum and energy."""

import math

import numpy as np
import pytest
from pendulums import PIVOT, UP, G, bob, down, energy, swing

from mechanics.effects import Gravity, Hinge, Rod, Rotation
from mechanics.rotation import about, matrix, normalised, rotate, unrotate
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, Sphere
from reference_impl.reactions import joint_forces
from reference_impl.simulate import advance, begin, simulate


@pytest.mark.parametrize("degrees", [5.0, 120.0, 179.0])
def test_a_pendulum_swings_by_elliptic_functions(degrees):
    amplitude = math.radians(degrees)
    scene = Scene((PIVOT, bob("bob", down(amplitude))), (Gravity(), Rod("pivot", "bob")))
    world = begin(scene)
    for t in (1.0, 2.5, 5.0):
        advance(world, t - world.t)
        # near the top the period changes with the energy as 1 / (1 + cos): 1e-12 of energy is that much of angle
        allowed = 1e-12 * (1.0 + 1.0 / (1.0 + math.cos(amplitude)))
        assert world.state().x[1] == pytest.approx(down(swing(amplitude, math.sqrt(G), t)), abs=allowed)
    assert world.audit.drift <= 1e-15


def test_the_published_pendulum():
    """From horizontal, after 10 s (IFToMM library of benchmarks, problem A01)."""
    motion = simulate(Scene((PIVOT, bob("bob", (1.0, 0.0, 0.0))), (Gravity(), Rod("pivot", "bob"))), (0.0, 10.0))
    assert math.atan2(motion.x[1, 1, 0], -motion.x[1, 1, 2]) == pytest.approx(0.27868067356998295, abs=1e-12)


def test_a_rod_pulls_as_newton_says():
    """m (v² / l + g cos θ) along the rod, at three times the angle of release where it hangs down: 4 m g."""
    amplitude = math.radians(120.0)
    world = begin(Scene((PIVOT, bob("bob", down(amplitude), mass=2.0)), (Gravity(), Rod("bob", "pivot"))))
    for _ in range(5):
        advance(world, 0.3)
        state = world.state()
        angle = math.atan2(state.x[1, 0], -state.x[1, 2])
        (f,) = joint_forces(world)
        expected = 2.0 * (state.v[1] @ state.v[1] + G * math.cos(angle))
        assert np.array(f.force) == pytest.approx(-expected * state.x[1], rel=1e-12, abs=1e-11)
        assert (f.a, f.b, f.joint) == (1, 0, 0)


def test_a_conical_pendulum_goes_round():
    rate = math.sqrt(G / math.cos(math.radians(40.0)))
    start = down(math.radians(40.0))
    scene = Scene((PIVOT, bob("bob", start, (0.0, rate * start[0], 0.0))), (Gravity(), Rod("pivot", "bob")))
    world = begin(scene)
    for t in (1.0, 10.0):
        advance(world, t - world.t)
        turned = rotate(about(UP, rate * t), start)
        assert world.state().x[1] == pytest.approx(turned, abs=1e-12)
    (f,) = joint_forces(world)
    assert np.linalg.norm(f.force) == pytest.approx(G / math.cos(math.radians(40.0)), rel=1e-13)


def test_a_body_on_a_hinge_swings_by_its_inertia_about_the_axis():
    """A tumbled box with an inertia that is not diagonal: I = a·I a + m d² about the axis a, at distance d."""
    q = normalised(np.array((0.7, 0.4, -0.3, 0.5)))
    inertia = ((0.9, 0.1, -0.05), (0.1, 0.7, 0.08), (-0.05, 0.08, 0.5))
    amplitude, distance, along = math.radians(70.0), 0.8, 0.35
    place = down(amplitude, distance)
    body = Body(
        "body", Box((0.5, 0.4, 0.3)), 3.0, tuple(place + np.array((0.0, along, 0.0))), tuple(q), inertia=inertia
    )
    scene = Scene((PIVOT, body), (Gravity(), Rotation(), Hinge("pivot", "body", axis=(0.0, 1.0, 0.0))))
    axis = unrotate(q, np.array((0.0, 1.0, 0.0)))
    whole = axis @ np.array(inertia) @ axis + 3.0 * distance**2
    rate = math.sqrt(3.0 * G * distance / whole)
    world = begin(scene)
    before = energy(scene, world.state())
    for t in (1.0, 5.0):
        advance(world, t - world.t)
        state = world.state()
        angle = swing(amplitude, rate, t)
        assert state.x[1] == pytest.approx(down(angle, distance) + np.array((0.0, along, 0.0)), abs=1e-12)
        turned = rotate(about((0.0, 1.0, 0.0), amplitude - angle), rotate(q, np.eye(3)))
        assert rotate(state.q[1], np.eye(3)) == pytest.approx(turned, abs=1e-12)
        assert energy(scene, state) == pytest.approx(before, abs=1e-12 * 3.0 * G)
    assert world.audit.drift <= 1e-15


def test_a_rod_hinged_at_its_end_presses_its_pivot():
    """Force at the pivot of a uniform rod: m g (5 cos θ - 3 cos θ0) / 2 along it and m g sin θ / 4 across (Routh)."""
    amplitude = math.radians(120.0)
    body = Body("rod", Box((0.02, 0.02, 1.0)), 1.0, tuple(down(amplitude, 0.5)),
                tuple(about((0.0, 1.0, 0.0), -amplitude)), inertia=(1 / 12, 1 / 12, 1e-4))  # fmt: skip
    world = begin(Scene((PIVOT, body), (Gravity(), Rotation(), Hinge("rod", "pivot"))))
    for _ in range(4):
        advance(world, 0.4)
        place = world.state().x[1]
        angle = math.atan2(place[0], -place[2])
        (f,) = joint_forces(world)
        out, across = down(angle), np.array((math.cos(angle), 0.0, math.sin(angle)))
        assert -np.array(f.force) @ out == pytest.approx(
            G * (2.5 * math.cos(angle) - 1.5 * math.cos(amplitude)), abs=1e-11
        )
        assert np.array(f.force) @ across == pytest.approx(0.25 * G * math.sin(angle), abs=1e-11)
        assert np.abs(f.torque).max() <= 1e-12


def test_a_thrown_dumbbell():
    """Its centre flies on a parabola, its line turns evenly, and the rod pulls with μ ω² l."""
    centre, speed, spin = np.array((0.0, 0.0, 5.0)), np.array((2.0, 0.3, 4.0)), 4.0
    masses, length = (1.0, 2.0), 1.5
    arms = np.array((-2.0 / 3.0, 1.0 / 3.0)) * length
    bodies = [bob(f"b{i}", centre + np.array((arm, 0.0, 0.0)), speed + np.array((0.0, spin * arm, 0.0)), m)
              for i, (arm, m) in enumerate(zip(arms, masses, strict=True))]  # fmt: skip
    world = begin(Scene(tuple(bodies), (Gravity(), Rod("b0", "b1"))))
    for t in (0.7, 7.3):
        advance(world, t - world.t)
        state = world.state()
        line = np.array((math.cos(spin * t), math.sin(spin * t), 0.0))
        for x, arm in zip(state.x, arms, strict=True):
            expected = centre + speed * t - np.array((0.0, 0.0, 0.5 * G * t * t)) + arm * line
            assert x == pytest.approx(expected, abs=1e-12 * max(1.0, 0.5 * G * t * t))
    (f,) = joint_forces(world)
    assert np.linalg.norm(f.force) == pytest.approx(2.0 / 3.0 * spin**2 * length, rel=1e-12)


def test_two_bodies_on_a_hinge_keep_their_momenta_and_energy():
    rng = np.random.default_rng(3)
    w = np.array((0.5, -1.0, 2.0))
    point, axis = np.array((0.1, 0.2, -0.1)), np.array((0.3, 0.5, 0.8))
    places = ((-0.4, 0.1, 0.0), (0.5, 0.0, 0.2))
    q = [tuple(normalised(rng.normal(size=4))) for _ in places]
    v = [tuple(np.cross(w, np.array(x) - point)) for x in places]
    extra = axis / np.linalg.norm(axis) * 3.0
    first = Body("a", Box((0.6, 0.3, 0.2)), 2.0, places[0], q[0], v[0], tuple(w))
    second = Body("b", Box((0.5, 0.2, 0.4)), 1.0, places[1], q[1],
                  tuple(np.cross(w + extra, np.array(places[1]) - point)), tuple(w + extra))  # fmt: skip
    scene = Scene((first, second), (Rotation(), Hinge("a", "b", tuple(point), tuple(axis))))
    world = begin(scene)

    def totals():
        s, m = world.state(), world.motion
        masses = np.array((2.0, 1.0))
        spin = (np.cross(s.x, masses[:, None] * s.v) + m.L).sum(axis=0)
        return np.concatenate([(masses[:, None] * s.v).sum(axis=0), spin, [energy(scene, s)]])

    def gravityless(values):
        values[-1] -= G * (2.0 * world.state().x[0, 2] + world.state().x[1, 2])
        return values

    before = gravityless(totals())
    for _ in range(4):
        advance(world, 1.0)
        assert gravityless(totals()) == pytest.approx(before, abs=1e-11)
        s = world.state()
        ends = [rotate(s.q[i], unrotate(np.array(q[i]), point - np.array(places[i]))) + s.x[i] for i in (0, 1)]
        lines = [rotate(s.q[i], unrotate(np.array(q[i]), axis)) for i in (0, 1)]
        assert ends[0] == pytest.approx(ends[1], abs=1e-15)
        assert lines[0] == pytest.approx(lines[1], abs=2e-15)
    assert world.audit.drift <= 2e-15


def test_a_steady_top_on_a_rod_of_no_length():
    """Slow precession of a heavy top, I1 Ω² cos θ - I3 w3 Ω + m g l = 0 (Goldstein, section 5.7).

    A rod between coinciding anchors keeps them together: a ball joint.
    """
    m, l, about_pivot, i3, tilt = 0.5, 0.04, 1.2e-3, 2.5e-4, math.radians(30.0)
    slow = 6.3491511714623878
    lean = about((0.0, 1.0, 0.0), tilt)
    spin = np.array((72.250736896522922, 0.0, 131.49109836053139))
    centre = rotate(lean, np.array((0.0, 0.0, l)))
    i1 = about_pivot - m * l * l
    top = Body("top", Sphere(0.03), m, tuple(centre), tuple(lean), tuple(np.cross(spin, centre)), tuple(spin),
               inertia=(i1, i1, i3))  # fmt: skip
    world = begin(Scene((PIVOT, top), (Gravity(), Rotation(), Rod("pivot", "top", anchor_b=(0.0, 0.0, -l)))))
    for t in (0.1, 1.0):
        advance(world, t - world.t)
        axis = matrix(world.state().q[1])[:, 2]
        expected = rotate(about(UP, slow * t), centre / l)
        # after 25 turns; the nutation that rounding of the start excites is not damped
        assert axis == pytest.approx(expected, abs=1e-11)
    assert world.state().x[1] == pytest.approx(l * axis, abs=1e-16)


def test_a_pivot_that_accelerates_tilts_gravity():
    """In a lift that accelerates upwards by a, a pendulum swings as under g + a."""
    amplitude, pull = math.radians(80.0), 3.0
    lift = Body("pivot", Sphere(0.01), velocity=(0.2, 0.0, -0.5), acceleration=(0.0, 0.0, pull))
    hung = bob("bob", down(amplitude), (0.2, 0.0, -0.5))
    world = begin(Scene((lift, hung), (Gravity(), Rod("pivot", "bob"))))
    advance(world, 3.0)
    expected = down(swing(amplitude, math.sqrt(G + pull), 3.0)) + np.array((0.6, 0.0, -1.5 + 0.5 * pull * 9.0))
    assert world.state().x[1] == pytest.approx(expected, abs=1e-11)


@pytest.mark.parametrize("seconds", [4.0, pytest.param(100.0, marks=pytest.mark.long)])
def test_energy_and_length_last(seconds):
    """Energy within 1e-12 and the rod within 1e-15 of what they were, after many wide swings."""
    scene = Scene((PIVOT, bob("bob", down(2.0))), (Gravity(), Rod("pivot", "bob")))
    world = begin(scene)
    before = energy(scene, world.state())
    advance(world, seconds)
    assert energy(scene, world.state()) == pytest.approx(before, abs=1e-12 * abs(before))
    assert np.linalg.norm(world.state().x[1]) == pytest.approx(np.linalg.norm(down(2.0)), rel=1e-15)
