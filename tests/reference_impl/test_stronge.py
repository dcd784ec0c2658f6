"""Single rough impacts through compression and expansion: closed forms, an independent integration, and energy."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mpmath import mp, mpf, sqrt

from mechanics.effects import Friction, Gravity, Resting, Restitution, Rotation
from mechanics.rotation import about
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Sphere
from reference_impl.effects.phases import ENERGETIC, POISSON, strike
from reference_impl.friction_problem import Rough, solve
from reference_impl.settings import Settings
from reference_impl.simulate import advance, begin

FLOOR = Body("floor", HalfSpace())
SLIDES, STICKS, REVERSES = "slides", "slides, sticks", "slides, reverses"


def struck(w, u, mu, e, hypothesis=ENERGETIC) -> np.ndarray:
    """Impulse (3,)."""
    r = np.empty(3)
    assert strike(np.array(w, dtype=float), np.array(u, dtype=float), float(mu), float(e), hypothesis, r)
    return r


def random_contact(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Mobility and relative velocity of a body of random inertia that strikes a fixed one at a random point."""
    axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    sides = rng.uniform(0.1, 1.0, 3)
    inertia = (sides @ sides - sides**2) / 12.0
    x, y, z = 0.5 * sides * rng.uniform(-1.0, 1.0, 3)
    lever = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    u = rng.normal(size=3)
    u[0] = -abs(u[0])
    return np.eye(3) + axes @ (lever.T @ np.diag(1.0 / inertia) @ lever) @ axes.T, u


def energy(w: np.ndarray, u: np.ndarray) -> float:
    """Kinetic energy that the contact can take, per unit."""
    return 0.5 * float(u @ np.linalg.solve(w, u))


def planar(w, u, mu, e, poisson=False) -> tuple[list, str]:
    """The same in a plane with forty digits: each piece is linear in the impulse (Wang and Mason, 1992)."""
    mp.dps = 40
    a, b, c = (mpf(float(x)) for x in (w[0][0], w[0][1], w[1][1]))
    n, s, mu, e = mpf(float(u[0])), mpf(float(u[1])), mpf(float(mu)), mpf(float(e))
    p = t = work = depth = end = mpf(0)
    f = -mu if s > 0 else mu
    story = [SLIDES]
    while True:
        up, along = a + b * f, b + c * f
        stop = -s / along if s * along < 0 else mpf("inf")
        if n < 0:
            ends = -n / up if up > 0 else mpf("inf")
        elif poisson:
            ends = (1 + e) * end - p
        else:
            more = e * e * depth - work
            ends = 2 * more / (n + sqrt(n * n + 2 * up * more))
        q = min(stop, ends)
        work += q * (n + up * q / 2)
        p, t, n, s = p + q, t + q * f, n + up * q, s + along * q
        if stop < ends:
            s, hold = mpf(0), -b / c
            sticks = abs(hold) <= mu
            f = hold if sticks else (mu if hold > 0 else -mu)
            story.append("sticks" if sticks else "reverses")
            if sticks:  # slip stays zero: w s-row is satisfied exactly
                c, b, a = mpf(1), mpf(0), a + b * f
                f, kept = mpf(0), f
                up = a
                # what follows has friction `kept` per normal impulse
                return _stuck(a, n, p, t, kept, work, depth, end, e, poisson), ", ".join(story)
        elif n <= mpf(10) ** -35 and end == 0:
            n, depth, end, work = mpf(0), -work, p, mpf(0)
            if e == 0:
                return [p, t], ", ".join(story)
        else:
            return [p, t], ", ".join(story)


def _stuck(up, n, p, t, f, work, depth, end, e, poisson) -> list:
    """The rest of an impact that sticks."""
    if end == 0:
        q = -n / up
        work += q * n / 2
        p, t, n, depth, end, work = p + q, t + q * f, mpf(0), -work, p + q, mpf(0)
    if e == 0:
        return [p, t]
    if poisson:
        q = (1 + e) * end - p
    else:
        more = e * e * depth - work
        q = 2 * more / (n + sqrt(n * n + 2 * up * more))
    return [p + q, t + q * f]


def rod(lean: float) -> np.ndarray:
    """Planar mobility at the tip of a uniform rod of 1 kg and 1 m, `lean` from the floor; moments are L²/12."""
    x, z = 0.5 * math.cos(lean), 0.5 * math.sin(lean)
    return np.array([[1.0 + 12.0 * x * x, 12.0 * x * z, 0.0], [12.0 * x * z, 1.0 + 12.0 * z * z, 0.0], [0.0, 0.0, 1.0]])


@pytest.mark.parametrize("poisson", [False, True])
@pytest.mark.parametrize("e", [0.0, 0.3, 0.7, 1.0])
@pytest.mark.parametrize(("lean", "slip", "mu"), [
    (0.4, 3.0, 0.2), (0.4, 0.2, 0.2), (0.4, -0.2, 0.2), (0.8, 0.1, 0.9), (0.8, -0.1, 0.9), (1.2, -1.0, 0.4),
    (1.1, 1.0, 1.6), (1.1, -1.0, 1.6), (0.2, 0.05, 0.05), (1.5, 0.3, 0.3),
])  # fmt: skip
def test_a_rod_through_every_phase(lean, slip, mu, e, poisson):
    """Slip that goes on, stops for good or reverses, also where friction first drives the tip in (1.1, -1, 1.6)."""
    w, u = rod(lean), np.array([-1.0, slip, 0.0])
    exact, _ = planar(w, u, mu, e, poisson)
    r = struck(w, u, mu, e, POISSON if poisson else ENERGETIC)
    assert r[:2] == pytest.approx([float(x) for x in exact], rel=4e-15)
    assert r[2] == 0.0


def test_the_phases_all_happen():
    rng, seen = np.random.default_rng(5), set()
    for _ in range(300):
        w, u = rod(rng.uniform(0.05, 1.5)), np.array([-1.0, rng.normal(), 0.0])
        mu, e = rng.uniform(0.0, 1.5), rng.uniform(0.0, 1.0)
        exact, story = planar(w, u, mu, e)
        seen.add(story)
        assert struck(w, u, mu, e)[:2] == pytest.approx([float(x) for x in exact], rel=1e-13, abs=1e-15)
    assert seen == {SLIDES, STICKS, REVERSES}


def test_without_friction_all_three_laws_are_newtons():
    rng = np.random.default_rng(1)
    for _ in range(200):
        w, u = random_contact(rng)
        e = rng.uniform(0.0, 1.0)
        newton = -(1.0 + e) * u[0] / w[0, 0]
        for hypothesis in (ENERGETIC, POISSON):
            assert struck(w, u, 0.0, e, hypothesis) == pytest.approx((newton, 0.0, 0.0), rel=1e-15)


def test_where_slip_neither_stops_nor_turns_the_three_laws_agree():
    """A single straight piece: the normal velocity is linear in the impulse, and so e means the same."""
    w, u, mu = rod(0.4), np.array([-1.0, 30.0, 0.0]), 0.2
    for e in (0.0, 0.4, 1.0):
        expected = (1.0 + e) / (w[0, 0] - mu * w[0, 1])
        for hypothesis in (ENERGETIC, POISSON):
            assert struck(w, u, mu, e, hypothesis)[0] == pytest.approx(expected, rel=1e-15)


@pytest.mark.parametrize("hypothesis", [ENERGETIC, POISSON])
def test_ten_thousand_random_impacts_only_lose_energy(hypothesis):
    """Slip that turns in space, stops, starts: bodies part, friction stays in its cone, and no energy is made."""
    rng = np.random.default_rng(7)
    for _ in range(9_000 if hypothesis == ENERGETIC else 1_000):
        w, u = random_contact(rng)
        mu, e = rng.uniform(0.0, 1.5), rng.choice([0.0, 0.5, 1.0, rng.uniform()])
        r = struck(w, u, mu, e, hypothesis)
        v = u + w @ r
        scale = float(np.abs(u).max() + np.abs(w).max() * np.abs(r).max())
        assert v[0] >= -1e-15 * scale
        assert math.hypot(r[1], r[2]) <= mu * r[0] * (1.0 + 1e-14)
        assert energy(w, v) <= energy(w, u) * (1.0 + 1e-14)


def test_newtons_law_makes_energy_where_stronges_does_not():
    """At e = 1 in several of a hundred random impacts with friction."""
    rng, made, worst = np.random.default_rng(3), 0, 0.0
    for _ in range(400):
        w, u = random_contact(rng)
        mu = rng.uniform(0.0, 1.5)
        root = np.linalg.cholesky(w)
        c = np.linalg.solve(root, u)
        answer = solve(Rough(root, c, np.array([-u[0], 0.0, 0.0]), np.array([mu]), np.zeros(1, dtype=bool)))
        gain = float(answer.x @ answer.x / (c @ c)) - 1.0
        made, worst = made + (gain > 1e-12), max(worst, gain)
    assert 0.03 < made / 400 < 0.13
    assert worst > 0.1


def test_turning_slip_agrees_with_a_small_step_integration():
    """Runge-Kutta 4 in the impulse, to where slip has fallen to a tenth or expansion begins."""
    rng = np.random.default_rng(11)
    w, mu = random_contact(rng)[0], 0.4
    u = np.array([-1.0, 0.5, 0.8])

    def rate(v):
        s = v[1:] / math.hypot(v[1], v[2])
        return w @ np.array([1.0, *(-mu * s)])

    v, p, h = u.copy(), 0.0, 1e-4
    while v[0] < 0.0:
        last, before = v.copy(), p
        k1 = rate(v)
        k2 = rate(v + 0.5 * h * k1)
        k3 = rate(v + 0.5 * h * k2)
        v = v + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + rate(v + h * k3))
        p += h
    turn = before + h * last[0] / (last[0] - v[0])
    assert math.hypot(v[1], v[2]) > 0.1
    assert abs(last[1] * u[2] - last[2] * u[1]) > 0.01  # it did turn
    assert struck(w, u, mu, 0.0)[0] == pytest.approx(turn, abs=1e-8)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10_000), st.floats(0.0, 2.0 * math.pi))
def test_the_tangents_may_be_chosen_as_one_likes(seed, angle):
    rng = np.random.default_rng(seed)
    w, u = random_contact(rng)
    mu, e = rng.uniform(0.0, 1.5), rng.uniform(0.0, 1.0)
    c, s = math.cos(angle), math.sin(angle)
    turn = np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
    there = struck(turn @ w @ turn.T, turn @ u, mu, e)
    assert turn.T @ there == pytest.approx(struck(w, u, mu, e), rel=1e-9, abs=1e-11)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10_000), st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
def test_masses_and_speeds_have_no_scale(seed, mass, speed):
    rng = np.random.default_rng(seed)
    w, u = random_contact(rng)
    mu, e = rng.uniform(0.0, 1.5), rng.uniform(0.0, 1.0)
    m, v = 10.0**mass, 10.0**speed
    assert struck(w / m, u * v, mu, e) / (m * v) == pytest.approx(struck(w, u, mu, e), rel=1e-10, abs=1e-12)


def effects(e: float, mu: float) -> tuple:
    return Restitution(e), Friction(mu), Rotation()


@pytest.mark.parametrize("law", ["energetic", "poisson"])
@pytest.mark.parametrize(("mu", "vx", "spin"), [(0.1, 1.46, -3.5), (0.6, 1.1428571428571429, -11.428571428571429)])
def test_a_spinning_ball_bounces_as_under_newtons_law(law, mu, vx, spin):
    """At a sphere normal and tangents do not act on each other (Routh)."""
    ball = Body("ball", Sphere(0.1), 0.5, (0.0, 0.0, 0.4), velocity=(2.0, 0.0, -3.0),
                angular_velocity=(0.0, -10.0, 0.0))  # fmt: skip
    world = begin(Scene((FLOOR, ball), effects(0.8, mu)), Settings(restitution=law))
    advance(world, 0.2)
    assert world.state().v[1] == pytest.approx((vx, 0.0, 2.4), abs=1e-14)
    assert world.state().w[1] == pytest.approx((0.0, -spin, 0.0), abs=1e-13)


def test_a_rod_that_sticks_as_it_lands():
    """2 kg and 1 m, 30 degrees from the floor, at (0.4, -3) m/s and 1.5 rad/s: its tip stops dead (e = 0)."""
    lean = tuple(about((0.0, 1.0, 0.0), -math.pi / 6.0))
    thin = 1e-9
    body = Body("rod", Box((1.0, thin, thin)), 2.0, (0.0, 0.0, 0.25), lean, (0.4, 0.0, -3.0), (0.0, -1.5, 0.0),
                inertia=(1e-3, 2.0 / 12.0, 2.0 / 12.0))  # fmt: skip
    floor = Body("floor", HalfSpace(), position=(0.0, 0.0, -1e-6))
    world = begin(Scene((floor, body), effects(0.0, 10.0)), Settings(restitution="energetic"))
    advance(world, 1e-6)
    # from the angular momentum about the tip; thickness and the fall of 1e-6 s shift the tip by 1e-5 at most
    assert world.state().w[1, 1] == pytest.approx(3.8221143170299739, rel=1e-5)
    assert world.state().v[1] == pytest.approx((0.95552857925749348, 0.0, -1.6550240473580836), abs=3e-5)
    assert world.events[0].impulse == pytest.approx(2.6899519052838329, rel=1e-5)


@pytest.mark.parametrize("e", [0.5, 1.0])
def test_thrown_boxes_never_gain_energy_under_stronges_law(e):
    """What Newton's law adds to the same boxes is in the audit."""
    made = {}
    for law in ("newton", "energetic"):
        rng, rises = np.random.default_rng(3), []
        for _ in range(12):
            q = rng.normal(size=4)
            box = Body("box", Box((0.5, 0.3, 0.2)), 2.0, (0.0, 0.0, 0.32), tuple((q / np.linalg.norm(q)).tolist()),
                       tuple(rng.normal(size=3) * 3.0 + [0.0, 0.0, -1.0]), tuple(rng.normal(size=3) * 5.0))  # fmt: skip
            world = begin(Scene((FLOOR, box), (*effects(e, 0.5), Gravity(), Resting())), Settings(restitution=law))
            advance(world, 0.4)
            rises.append(world.audit.energy_rise)
            assert world.audit.imbalance <= 1e-13
        made[law] = max(rises)
    assert made["energetic"] <= 1e-13 * 20.0  # of about 20 J
    if e == 1.0:
        assert made["newton"] > 1e-3


def test_a_box_that_lands_flat_gives_its_corners_their_turn():
    """The stated rule for several contacts at once; without restitution all stop at once and the box stays level."""
    for e in (0.0, 0.5):
        box = Body("box", Box((0.4, 0.4, 0.2)), 2.0, (0.0, 0.0, 0.3), velocity=(1.0, 0.0, 0.0))
        scene = Scene((FLOOR, box), (Gravity(), *effects(e, 0.3), Resting()))
        world = begin(scene, Settings(restitution="energetic"))
        advance(world, 3.0)
        assert world.audit.energy_rise <= 1e-12
        assert world.state().x[1, 2] == pytest.approx(0.1, abs=1e-9)
        if e == 0.0:
            assert len(world.events) == 4
            fall = math.sqrt(2.0 * 9.81 * 0.2)
            assert sum(i.impulse for i in world.events) == pytest.approx(2.0 * fall, rel=1e-12)


@pytest.mark.parametrize(("choice", "match"), [
    ({"restitution": "magic"}, "newton, energetic, poisson"), ({"friction": "magic"}, "exact, pyramid, convex"),
    ({"sides": 5}, "even"), ({"restitution": "energetic", "friction": "convex"}, "exact where restitution"),
])  # fmt: skip
def test_choices_that_do_not_exist_or_do_not_go_together(choice, match):
    with pytest.raises(ValueError, match=match):
        Settings(**choice)
