"""Impacts with friction: closed forms of spheres, conservation at eccentric ones, and what may not happen to energy."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mechanics.effects import Friction, Resting, Restitution, Rotation
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Sphere
from reference_impl.audit import kinetic_energy
from reference_impl.settings import Settings
from reference_impl.simulate import advance, begin

FLOOR = Body("floor", HalfSpace())
ROUGH_LAWS = ("propagation", "sequential", "simultaneous", "reflections")  # poisson is refused with friction


def effects(e: float, mu: float) -> tuple:
    return Restitution(e), Friction(mu), Rotation()


@pytest.mark.parametrize("law", ROUGH_LAWS)
@pytest.mark.parametrize(("mu", "vx", "spin"), [(0.1, 1.46, -3.5), (0.6, 1.1428571428571429, -11.428571428571429)])
def test_a_spinning_ball_slides_or_sticks_in_its_bounce(law, mu, vx, spin):
    ball = Body(
        "ball", Sphere(0.1), 0.5, (0.0, 0.0, 0.4), velocity=(2.0, 0.0, -3.0), angular_velocity=(0.0, -10.0, 0.0)
    )
    world = begin(Scene((FLOOR, ball), effects(0.8, mu)), Settings(impact_law=law))
    advance(world, 0.2)
    after = world.state()
    assert after.v[1] == pytest.approx((vx, 0.0, 2.4), abs=1e-14)
    assert after.w[1] == pytest.approx((0.0, -spin, 0.0), abs=1e-13)
    assert world.events[0].impulse == pytest.approx(2.7, rel=1e-14)


@settings(max_examples=25, deadline=None)
@given(st.floats(0.0, 1.0), st.floats(0.0, 1.5), st.lists(st.floats(-3.0, 3.0), min_size=8, max_size=8))
def test_two_rough_spheres_obey_the_closed_form(e, mu, numbers):
    v, w1, w2 = np.array([4.0, *numbers[:2]]), np.array(numbers[2:5]) * 5.0, np.array(numbers[5:8]) * 5.0
    m1, m2, r1, r2 = 1.0, 3.0, 0.2, 0.3
    start = (-r1 - r2 - 0.5, 0.0, 0.0)
    touch = np.array(start) + v * (0.5 / 4.0)
    # aimed so that the spheres meet with their centres along x
    a = Body("a", Sphere(r1), m1, tuple((np.array(start) - (touch - [-r1 - r2, 0.0, 0.0])).tolist()),
             velocity=tuple(v.tolist()), angular_velocity=tuple(w1.tolist()))  # fmt: skip
    b = Body("b", Sphere(r2), m2, (0.0, 0.0, 0.0), angular_velocity=tuple(w2.tolist()))
    world = begin(Scene((a, b), effects(e, mu)))
    advance(world, 0.13)
    n = np.array([-1.0, 0.0, 0.0])  # from b to a
    slip = v + np.cross(w1, -r1 * n) - np.cross(w2, r2 * n)
    slip -= n * (slip @ n)
    normal = (1.0 + e) * 4.0 / (1.0 / m1 + 1.0 / m2)
    stick = 1.0 / (3.5 / m1 + 3.5 / m2)  # 1/m + r²/I = 3.5/m for solid spheres
    size = np.linalg.norm(slip)
    p = normal * n - slip * (min(mu * normal / size, stick) if size > 0.0 else 0.0)
    after = world.state()
    assert after.v[0] == pytest.approx(v + p / m1, abs=1e-11)
    assert after.v[1] == pytest.approx(-p / m2, abs=1e-11)
    assert after.w[0] == pytest.approx(w1 + np.cross(-r1 * n, p) / (0.4 * m1 * r1**2), abs=1e-10)
    assert after.w[1] == pytest.approx(w2 - np.cross(r2 * n, p) / (0.4 * m2 * r2**2), abs=1e-10)


@pytest.mark.parametrize("law", ["propagation", "simultaneous"])  # one corner after the other is another impact
def test_a_box_that_sticks_turns_about_its_edge(law):
    """Angular momentum about the edge that stops dead is kept."""
    half = np.radians(25.0) / 2.0
    turn = (np.cos(half), 0.0, np.sin(half), 0.0)
    box = Body("box", Box((0.6, 0.3, 0.2)), 2.0, (0.0, 0.0, 0.5), turn, (0.4, 0.0, -3.0),
               (0.0, 1.5, 0.0))  # fmt: skip
    world = begin(Scene((FLOOR, box), effects(0.0, 5.0)), Settings(impact_law=law))
    while not world.events:
        before = world.state()
        advance(world, 1e-3)
    time = world.events[0].time
    after, point = world.state(), np.array(world.events[0].point)
    centre = before.x[1] + before.v[1] * (time - before.t)
    inertia = 2.0 * (0.6**2 + 0.2**2) / 12.0
    arm = np.array([centre[0] - point[0], centre[2] - point[2]])
    moment = inertia * 1.5 + 2.0 * (arm[1] * 0.4 + arm[0] * 3.0)
    w = moment / (inertia + 2.0 * float(arm @ arm))
    assert after.w[1, 1] == pytest.approx(w, rel=1e-9)
    assert after.v[1, 0] == pytest.approx(w * arm[1], rel=1e-9)
    assert after.v[1, 2] == pytest.approx(-w * arm[0], rel=1e-9)


@settings(max_examples=25, deadline=None)
@given(st.lists(st.floats(-2.0, 2.0), min_size=6, max_size=6), st.lists(st.floats(-1.0, 1.0), min_size=4, max_size=4),
       st.floats(0.0, 2.0))  # fmt: skip
def test_without_restitution_friction_only_takes_energy(speeds, attitude, mu):
    q = np.array(attitude) + np.array([1.5, 0.0, 0.0, 0.0])
    box = Body("box", Box((0.5, 0.3, 0.2)), 2.0, (0.0, 0.0, 0.32), tuple((q / np.linalg.norm(q)).tolist()),
               (speeds[0], speeds[1], -3.0 + speeds[2]), tuple(speeds[3:]))  # fmt: skip
    world = begin(Scene((FLOOR, box), (*effects(0.0, mu), Resting())))
    start = kinetic_energy(world)
    while not world.events and world.t < 0.3:
        advance(world, 0.01)
    assert kinetic_energy(world) <= start * (1.0 + 1e-13)
    assert world.audit.energy_rise <= 1e-12 * start


def test_energy_that_newtons_law_makes_with_friction_is_on_record():
    """At eccentric contacts Newton's e with friction can add energy: not hidden, but recorded."""
    rng = np.random.default_rng(3)
    rises = []
    for _ in range(60):
        q = rng.normal(size=4)
        box = Body("box", Box((0.5, 0.3, 0.2)), 2.0, (0.0, 0.0, 0.32), tuple((q / np.linalg.norm(q)).tolist()),
                   tuple(rng.normal(size=3) * 3.0 + [0.0, 0.0, -1.0]), tuple(rng.normal(size=3) * 5.0))  # fmt: skip
        world = begin(Scene((FLOOR, box), effects(1.0, 0.5)))
        start = kinetic_energy(world)
        while world.audit.impacts == 0 and world.t < 0.4:
            advance(world, 2e-3)
        if world.audit.impacts == 1:
            rises.append(kinetic_energy(world) - start)
            assert max(rises[-1], 0.0) == pytest.approx(world.audit.energy_rise, abs=1e-12 * start)
    assert len(rises) > 30
    assert max(rises) > 0.0
