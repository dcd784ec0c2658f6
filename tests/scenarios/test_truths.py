"""Truths against numbers computed with 40 digits elsewhere, and against a second way of computing them."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from comparisons.gap import bounded_gap
from comparisons.penetration import pose
from mechanics.effects import Gravity
from scenarios.bouncing_ball import bounce, impact_times
from scenarios.catalogue import families
from scenarios.corner_drop import GAP, SPEED, corner_impact
from scenarios.head_on_collision import after_collision
from scenarios.incline import slide
from scenarios.tolerance import GRAVITY


def of(name, **parameters):
    return families()[name].of(**parameters)


def at(scenario, *times):
    return scenario.truth(np.array(times, dtype=np.float64))


def test_gravity_is_what_the_formulas_say():
    assert Gravity().acceleration == (0.0, 0.0, -GRAVITY)


def test_free_fall():
    truth = at(of("free-fall"), 1.5, 2.0192751093846089)
    assert truth.x[0, 0, 2] == pytest.approx(8.96375, abs=1e-14)
    assert truth.v[0, 0, 2] == pytest.approx(-14.715, abs=1e-14)
    assert truth.x[1, 0, 2] == pytest.approx(0.0, abs=1e-13)
    assert truth.v[1, 0, 2] == pytest.approx(-19.809088823063013, abs=1e-13)


def test_projectile():
    truth = at(of("projectile"), 3.453297672163307, 1.6380927871726283)
    assert truth.x[0, 0] == pytest.approx([66.134487304910092, 0.0, 0.0], abs=1e-12)
    assert truth.v[0, 0] == pytest.approx([19.151111077974451, 0.0, -17.807159921758558], abs=1e-13)
    assert truth.x[1, 0, 2] == pytest.approx(16.161821838893184, abs=1e-13)


def test_times_and_heights_of_bounces():
    times = impact_times(1.0, 0.8, math.inf)
    expected = [0.4515236409857309, 1.1739614665629004, 1.7519117270246359, 2.2142719353940244, 2.5841601020895351]
    np.testing.assert_allclose(times[:5], expected, rtol=1e-14)
    assert times[-1] == pytest.approx(4.0637127688715781, rel=1e-13)  # they accumulate
    apexes = times[:5] + 0.8 ** np.arange(1, 6) * math.sqrt(2 * GRAVITY) / GRAVITY
    gap, rise = bounce(apexes, 1.0, 0.8)
    np.testing.assert_allclose(gap, [0.64, 0.4096, 0.262144, 0.16777216, 0.1073741824], rtol=1e-13)
    np.testing.assert_allclose(rise, 0.0, atol=1e-13)


def test_a_ball_lies_still_after_infinitely_many_bounces():
    gap, rise = bounce(np.array([4.07, 10.0]), 1.0, 0.8)
    assert gap.tolist() == [0.0, 0.0]
    assert rise.tolist() == [0.0, 0.0]


@given(st.floats(0.2, 1.0), st.floats(0.2, 5.0), st.floats(0.0, 3.0))
def test_bounces_event_by_event(e, clearance, t):
    """Each flight solved in turn, from impact to impact."""
    z, v, left = clearance, 0.0, t
    for _ in range(200):
        landing = (v + math.sqrt(v * v + 2.0 * GRAVITY * max(z, 0.0))) / GRAVITY
        if landing > left or landing < 1e-9:
            break
        z, v, left = 0.0, -e * (v - GRAVITY * landing), left - landing
    gap, _ = bounce(np.array([t]), clearance, e)
    expected = max(z + v * left - 0.5 * GRAVITY * left**2, 0.0)
    assert gap[0] == pytest.approx(expected, abs=1e-7)


def test_head_on_collision_of_very_different_masses():
    assert after_collision(1.0, 1e6, 2.0, -0.5, 0.6) == pytest.approx((-1.999996000004, -0.499996000004), abs=1e-12)
    assert after_collision(1e6, 1.0, 2.0, -0.5, 0.6) == pytest.approx((1.999996000004, 3.499996000004), abs=1e-12)
    truth = at(of("head-on-collision", mass_ratio=1e6, e=0.6), 1.0)
    assert truth.v[0, :, 0] == pytest.approx([-1.999996000004, -0.499996000004], abs=1e-12)


@given(*[st.fractions(Fraction(1, 100), 100)] * 2, *[st.fractions(-10, 10)] * 2, st.fractions(0, 1))
def test_central_impacts_solve_the_conservation_equations(m1, m2, v1, v2, e):
    u1, u2 = after_collision(m1, m2, v1, v2, e)
    assert m1 * u1 + m2 * u2 == m1 * v1 + m2 * v2
    assert u2 - u1 == e * (v1 - v2)


def test_oblique_collision():
    truth = at(of("oblique-collision"), 1.0)
    assert truth.v[0, 0] == pytest.approx([1.575, 0.0, 0.82272413359521671], abs=1e-14)
    assert truth.v[0, 1] == pytest.approx([2.85, 0.0, -1.6454482671904334], abs=1e-14)


def test_equal_elastic_balls_part_at_right_angles():
    scenario = of("oblique-collision", e=1.0)
    first, second = at(scenario, 1.0).v[0]
    masses = [b.mass for b in scenario.scene.bodies]
    energy = 0.5 * masses[0] * first @ first + 0.5 * masses[1] * second @ second
    assert energy == pytest.approx(0.5 * masses[0] * 9.0, rel=1e-14)


@pytest.mark.parametrize("launched", [1, 2, 3, 4])
def test_the_cradle_impact_by_impact(launched):
    """Equal masses swap velocities, one impact after the other, in rational numbers."""
    scenario = of("newtons-cradle", launched=launched)
    x = [Fraction(float(p[0])) for p in scenario.scene.start().x]
    v = [Fraction(float(p[0])) for p in scenario.scene.start().v]
    now, until, count = Fraction(0), Fraction(1), 0
    while True:
        approach = [(v[i] - v[i + 1], x[i + 1] - x[i] - Fraction(1, 8), i) for i in range(4)]
        due = [(gap / speed, i) for speed, gap, i in approach if speed > 0]
        if not due or now + min(due)[0] > until:
            break
        wait, i = min(due)
        x, now, count = [p + s * wait for p, s in zip(x, v, strict=True)], now + wait, count + 1
        v[i], v[i + 1] = v[i + 1], v[i]
    x = [p + s * (until - now) for p, s in zip(x, v, strict=True)]
    truth = at(scenario, 1.0)
    np.testing.assert_allclose(truth.x[0, :, 0], [float(p) for p in x], atol=1e-13)
    assert truth.v[0, :, 0].tolist() == [float(s) for s in v] == [0.0] * (5 - launched) + [1.0] * launched
    assert count == len(scenario.events) == launched * (5 - launched)


def test_the_laws_of_the_touching_cradle_conserve_momentum_and_energy():
    for law, velocities in of("touching-cradle").laws.items():
        v = np.array(velocities)
        assert v.sum(axis=0) == pytest.approx([1.0, 0.0, 0.0], abs=1e-15), law
        assert (v**2).sum() == pytest.approx(1.0, abs=1e-15), law


def test_the_touching_cradle_touches_bit_by_bit():
    x = of("touching-cradle").scene.start().x[1:, 0]
    assert (np.diff(x) == 0.125).all()


def test_box_on_its_corner():
    scenario = of("corner-drop")
    box = scenario.scene.body("box")
    arm, v, w = corner_impact(box, 0.5)
    np.testing.assert_allclose(arm, [-0.059535489037941736, -0.13236560216237862, -0.34486935629192111], atol=1e-15)
    np.testing.assert_allclose(v, [0.0, 0.0, -0.2782349967830111], atol=1e-14)
    np.testing.assert_allclose(w, [-8.1603981458328431, 3.3270740784350307, 4.0041746509038648], atol=1e-13)
    truth = at(scenario, GAP / SPEED)
    np.testing.assert_allclose(truth.w[0, 1], w, atol=1e-13)


@pytest.mark.parametrize("e", [0.5, 0.75, 1.0])
def test_no_other_corner_comes_down_before_the_end(e):
    scenario = of("corner-drop", e=e)
    truth = scenario.truth(np.linspace(0.0, scenario.duration, 400))
    floor, box = scenario.scene.bodies
    gaps = bounded_gap(floor.shape, box.shape, pose(truth, 0), pose(truth, 1))
    hit = truth.t >= GAP / SPEED
    assert gaps.min() > -1e-12
    assert (np.diff(gaps[hit][:20]) > 0.0).all()
    assert gaps[-1] > 1e-3


def test_incline_in_numbers():
    angle = math.radians(25.0)
    way, pace, _ = slide(np.array([1.0]), angle, 0.3, 0.0)
    assert pace[0] == pytest.approx(1.4786213304274006, abs=1e-14)
    assert way[0] == pytest.approx(1.4786213304274006 / 2.0, abs=1e-14)
    way, pace, stop = slide(np.array([0.58710003562118808, 1.8473525295233966]), angle, 0.3, -4.0)
    assert stop == pytest.approx(0.58710003562118808, abs=1e-14)
    np.testing.assert_allclose(way, [-1.1742000712423762, 0.0], atol=1e-13)
    assert pace[1] == pytest.approx(1.8634362192081332, abs=1e-13)
    way, pace, stop = slide(np.array([5.0]), angle, 0.6, 3.0)
    assert stop == pytest.approx(2.5238875719664683, abs=1e-13)
    assert (way[0], pace[0]) == pytest.approx((3.7858313579497024, 0.0), abs=1e-13)


@given(st.floats(5.0, 60.0), st.floats(0.05, 1.5), st.floats(-5.0, 5.0).filter(lambda v: abs(v) > 0.05))
def test_incline_by_integration(degrees, mu, speed):
    """The equation of motion with the sign of friction switched where the block stops."""
    angle = math.radians(degrees)
    pull, brake = GRAVITY * math.sin(angle), mu * GRAVITY * math.cos(angle)
    way, pace, left = 0.0, speed, 2.0
    while left > 1e-12:
        moving = abs(pace) > 1e-12
        drive = pull - math.copysign(brake, pace) if moving else max(pull - brake, 0.0)

        def stopped(t, y):
            return y[1]

        stopped.terminal = True
        flow = solve_ivp(lambda t, y, a=drive: [y[1], a], (0.0, left), [way, pace], rtol=1e-12, atol=1e-12,
                         events=stopped if moving else None)  # fmt: skip
        way, pace, left = flow.y[0, -1], flow.y[1, -1], left - flow.t[-1]
        if moving and left > 1e-12:
            pace = 0.0
    found_way, found_pace, _ = slide(np.array([2.0]), angle, mu, speed)
    assert (found_way[0], found_pace[0]) == pytest.approx((way, pace), abs=1e-8)


def test_sliding_block_stops_in_a_straight_line():
    heading = math.degrees(math.atan2(4.0, 3.0))
    scenario = of("sliding-block", heading=heading)
    assert scenario.events[0] == pytest.approx(1.4562399883500801, abs=1e-14)
    stopped = at(scenario, 1.4562399883500801, 1.7)
    np.testing.assert_allclose(stopped.x[:, 1, 0], 2.1843599825251201, atol=1e-13)
    np.testing.assert_allclose(stopped.x[:, 1, 1], 2.9124799767001602, atol=1e-13)
    assert np.abs(stopped.v[:, 1]).max() < 1e-14


@pytest.mark.parametrize(
    ("backspin", "time", "speed", "spin", "distance"),
    [
        (0.0, 1.9416533178001068, 5.7142857142857143, -52.91005291005291, 13.314194179200732),
        (50.0, 3.2522693073151789, 4.1714285714285714, -38.624338624338624, 19.792381784518089),
    ],
)
def test_sliding_to_rolling(backspin, time, speed, spin, distance):
    scenario = of("sliding-to-rolling", speed=8.0, mu=0.12, backspin=backspin)
    assert scenario.events[0] == pytest.approx(time, abs=1e-13)
    truth = at(scenario, time)
    assert truth.v[0, 1, 0] == pytest.approx(speed, abs=1e-13)
    assert truth.w[0, 1, 1] == pytest.approx(-spin, abs=1e-12)  # counter-clockwise in x-z is -y
    assert truth.x[0, 1, 0] == pytest.approx(distance, abs=1e-12)


@given(st.floats(0.5, 8.0), st.floats(0.05, 1.0), st.floats(-40.0, 60.0))
def test_rolling_starts_when_slip_ends(speed, mu, backspin):
    """Friction against the slip until there is none, in small exact steps; angular momentum about the floor is kept."""
    scenario = of("sliding-to-rolling", speed=speed, mu=mu, backspin=backspin)
    radius = scenario.scene.bodies[1].shape.radius
    truth = at(scenario, 0.0, scenario.events[0], scenario.duration)
    v, w = truth.v[:, 1, 0], truth.w[:, 1, 1]
    np.testing.assert_allclose(v + 0.4 * radius * w, v[0] + 0.4 * radius * w[0], atol=1e-12)
    np.testing.assert_allclose(v[1:], radius * w[1:], atol=1e-12)
    assert v[1] - v[0] == pytest.approx(
        -math.copysign(mu * GRAVITY, v[0] - radius * w[0]) * scenario.events[0], abs=1e-12
    )
    assert v[2] == v[1]


def test_the_simbenchmark_scene_is_the_published_one():
    scene = of("simbenchmark-bouncing").scene
    balls = [scene.bodies[i] for i in scene.moving]
    assert len(balls) == 49
    energy = sum(b.mass * GRAVITY * b.position[2] for b in balls)
    assert energy == pytest.approx(24034.5, rel=1e-12)
    assert len({b.position[:2] for b in balls}) == 49
    period = 2.0 * math.sqrt(2.0 * 4.9 / GRAVITY)
    assert period == pytest.approx(1.99898, abs=1e-5)
    assert np.diff(of("simbenchmark-bouncing").events) == pytest.approx(period)


def test_the_gazebo_scenes_are_the_published_ones():
    for motion, energy, momentum in (("complex", 368.546416667, 3.41765), ("simple", 5.00104166667, 0.404166667)):
        box = of("gazebo-boxes", motion=motion).scene.bodies[0]
        v, w, inertia = np.array(box.velocity), np.array(box.angular_velocity), box.inertia_tensor
        assert 0.5 * box.mass * v @ v + 0.5 * w @ inertia @ w == pytest.approx(energy, rel=1e-10)
        assert np.linalg.norm(inertia @ w) == pytest.approx(momentum, rel=1e-5)


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("layout", ["spatial", "planar"])
def test_random_boxes_repeat_themselves_and_start_apart(seed, layout):
    scene = of("random-boxes", seed=seed, layout=layout).scene
    assert scene == of("random-boxes", seed=seed, layout=layout).scene
    assert scene != of("random-boxes", seed=seed + 10, layout=layout).scene
    assert (scene.out_of_plane() is None) == (layout == "planar")
