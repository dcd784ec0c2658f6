"""Truths of tops, pendula, springs, slipping and rolling bodies by a second route: their equations integrated."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.optimize import linprog

from mechanics.rotation import angle_between, product, rotate, unrotate
from scenarios import card_house, heavy_top, loop_on_a_string, pile_of_logs, rimless_wheel, slipping_rod, sprung_plate
from scenarios import spinning_top as top
from scenarios import struck_pendulum as hinged
from scenarios import wheel_and_step as step
from scenarios.catalogue import families
from scenarios.damped_spring import Damped
from scenarios.rolling_off_the_sphere import RATE as ROLLING
from scenarios.rolling_off_the_sphere import RATIO, grip_lost
from scenarios.swing import fall_speed, passing, passing_time, whirl, whirl_time
from scenarios.tolerance import GRAVITY, STEP

UP = np.array([0.0, 0.0, 1.0])


def integrated(rate, start, t, events=None):
    """States (T, n) at times t, by Runge-Kutta of order 8, and the times of the events."""
    flow = solve_ivp(rate, (0.0, t[-1]), start, "DOP853", t, rtol=1e-13, atol=1e-13, events=events)
    return flow.y.T, flow.t_events


@pytest.mark.parametrize(("tilt", "spin", "precession"), [(0.5, 150.0, 0.0), (1.2, -90.0, 10.0), (2.5, 60.0, -5.0)])
def test_a_top_by_the_equations_of_euler_about_its_foot(tilt, spin, precession):
    release = top.released(tilt, spin, precession)
    moments, t = np.array([top.ACROSS, top.ACROSS, top.ALONG]), np.linspace(0.0, 0.12, 4)

    def rate(_, y):
        weight = top.MASS * GRAVITY * top.ARM * np.cross(UP, unrotate(y[:4] / np.linalg.norm(y[:4]), UP))
        return [
            *(0.5 * product(y[:4], np.append(0.0, y[4:]))),
            *((np.cross(moments * y[4:], y[4:]) - weight) / moments),
        ]

    def turned():
        return heavy_top.attitude(heavy_top.axis(release, t))

    q, w = turned()
    y, _ = integrated(rate, [*q[0], *unrotate(q[0], w[0])], t)
    found = y[:, :4] / np.linalg.norm(y[:, :4], axis=1)[:, None]
    assert np.max(angle_between(q, found)) < 1e-9
    np.testing.assert_allclose(w, rotate(found, y[:, 4:]), atol=1e-9 * (1.0 + abs(spin)))


@pytest.mark.parametrize(("name", "key"), [("steady-top", "steady"), ("nutating-top", "nutating")])
def test_what_linearly_implicit_euler_errs_by_on_a_top(name, key):
    scenario = families()[name].of()
    body, h = scenario.scene.body("top"), STEP
    moments, q = np.array([top.ACROSS, top.ACROSS, top.ALONG]), np.array(body.orientation)
    w = unrotate(q, np.array(body.angular_velocity))
    states = [(q, w)]
    for _ in range(round(scenario.duration / h)):
        weight = -top.MASS * GRAVITY * top.ARM * np.cross(UP, unrotate(q, UP))
        gyro = np.cross(w, moments * w)
        jacobian = np.cross(w[:, None], np.diag(moments), axis=0) - np.cross((moments * w)[:, None], np.eye(3), axis=0)
        w = w - h * np.linalg.solve(np.diag(moments) + h * jacobian, gyro) + h * weight / moments
        half = 0.5 * h * np.linalg.norm(w)
        q = product(q, np.append(math.cos(half), math.sin(half) * w / np.linalg.norm(w)))
        states.append((q, w))
    q, w = (np.array(column) for column in zip(*states, strict=True))
    w, out = rotate(q, w), rotate(q, top.ARM * UP)
    truth = scenario.truth(h * np.arange(len(q)))
    off = (out - truth.x[:, 1], np.cross(w, out) - truth.v[:, 1], angle_between(q, truth.q[:, 1]), w - truth.w[:, 1])
    worst = [np.max(np.abs(a) if a.ndim == 1 else np.linalg.norm(a, axis=1)) for a in off]
    np.testing.assert_allclose(worst, top.EULER[key], rtol=6e-3)


@pytest.mark.parametrize(("angle", "speed"), [(0.1, 0.3), (1.0, 1.0), (2.0, 3.0), (2.9, 0.5)])
def test_a_bob_by_the_pull_of_its_rod(angle, speed):
    scenario = families()["spherical-pendulum"].of(angle=min(170.0, max(5.0, math.degrees(angle))), speed=speed)
    t = np.linspace(0.0, 3.0, 4)
    truth, weight = scenario.truth(t), np.array([0.0, 0.0, -GRAVITY])

    def rate(_, y):
        x, v = y[:3], y[3:]
        return [*v, *(weight - x * (v @ v + weight @ x) / (x @ x))]

    y, _ = integrated(rate, [*truth.x[0, 1], *truth.v[0, 1]], t)
    np.testing.assert_allclose(truth.x[:, 1], y[:, :3], atol=1e-8)
    np.testing.assert_allclose(truth.v[:, 1], y[:, 3:], atol=1e-7)


@pytest.mark.parametrize(("rate", "spin"), [(3.0, 1.0), (3.0, 5.9), (3.0, 6.1), (2.0, 15.0)])
def test_whirling_by_the_pendulum_equation(rate, spin):
    t = np.linspace(0.0, 2.0, 5)
    y, _ = integrated(lambda _, y: [y[1], -(rate**2) * math.sin(y[0])], [0.0, spin], t)
    np.testing.assert_allclose(whirl(t, rate, spin), y.T, atol=1e-8)
    reach = math.pi if spin > 2.0 * rate else 2.0 * math.asin(0.5 * spin / rate)
    time = whirl_time(rate, spin, 0.9 * reach)
    assert whirl(np.array([time]), rate, spin)[0][0] == pytest.approx(0.9 * reach, abs=1e-9)
    over = 0.3 * spin
    assert passing(np.array([passing_time(rate, over, -0.7)]), rate, over)[0][0] == pytest.approx(-0.7, abs=1e-10)
    np.testing.assert_allclose(passing(np.zeros(1), rate, over), [[0.0], [over]], atol=1e-9)


@pytest.mark.parametrize("height", [0.6, 0.9, 1.1])
def test_a_string_goes_slack_where_its_pull_vanishes(height):
    r = loop_on_a_string.RADIUS
    spin = math.sqrt(2.0 * GRAVITY * height) / r

    def slack(_, y):
        return y[1] ** 2 * r + GRAVITY * math.cos(y[0])

    slack.terminal = True
    _, events = integrated(lambda _, y: [y[1], -GRAVITY / r * math.sin(y[0])], [0.0, spin], np.array([0.0, 2.0]), slack)
    leaves, ends = loop_on_a_string.times(height, math.sqrt(GRAVITY / r), spin)
    assert events[0][0] == pytest.approx(leaves, abs=1e-11)
    scenario = families()["loop-on-a-string"].of(height=height)
    flown = np.linspace(leaves + 1e-3, leaves + (ends - leaves) / 0.975, 50)
    away = np.linalg.norm(scenario.truth(flown).x[:, 1], axis=1)
    assert (away[:-1] < r).all()
    assert away[-1] == pytest.approx(r, abs=1e-12)


@given(st.floats(0.0, 1.0), st.floats(0.2, 1.1))
def test_a_struck_pendulum_with_the_impulse_of_its_hinge(e, depth):
    """Rod and ball free, hinge and contact as impulses: velocities (rod x, spin forwards, ball) and two multipliers."""
    mass, moment, half = hinged.ROD, hinged.ROD * hinged.LENGTH**2 / 12.0, 0.5 * hinged.LENGTH
    matrix = np.zeros((5, 5))
    matrix[:3, :3] = np.diag([mass, moment, hinged.BALL])
    hinge, contact = np.array([1.0, -half, 0.0]), np.array([1.0, depth - half, -1.0])
    matrix[:3, 3], matrix[:3, 4], matrix[3, :3], matrix[4, :3] = -hinge, -contact, hinge, contact
    before = hinged.BALL * hinged.SPEED
    found = np.linalg.solve(matrix, [0.0, 0.0, before, 0.0, e * hinged.SPEED])
    blow = hinged.struck(e, depth)
    np.testing.assert_allclose(found[1:], [blow.spin, blow.ball, blow.hinge, blow.impulse], atol=1e-12)


def stands(contacts, weights, mu):
    """Whether forces in the friction cones balance the weights of planar bodies.

    `contacts`: (body below or None, body above, place, normal from below to above); `weights`: body -> (weight, place).
    """
    names = list(weights)
    balance = np.zeros((3 * len(names), 2 * len(contacts)))
    for k, (below, above, place, normal, _) in enumerate(contacts):
        for j, force in enumerate((np.array(normal), np.array([-normal[1], normal[0]]))):
            for name, sign in ((below, -1.0), (above, 1.0)):
                if name is not None:
                    arm, row = np.array(place) - weights[name][1], 3 * names.index(name)
                    balance[row : row + 3, 2 * k + j] += sign * np.array(
                        [*force, arm[0] * force[1] - arm[1] * force[0]]
                    )
    load = np.array([a for name in names for a in (0.0, weights[name][0], 0.0)])
    cone = np.zeros((2 * len(contacts), 2 * len(contacts)))
    for k, contact in enumerate(contacts):
        cone[2 * k : 2 * k + 2, 2 * k], cone[2 * k : 2 * k + 2, 2 * k + 1] = -mu * contact[4], [1.0, -1.0]
    bounds = [(0.0, None), (None, None)] * len(contacts)
    return linprog(np.zeros(2 * len(contacts)), cone, np.zeros(len(cone)), balance, load, bounds).status == 0


def threshold(contacts, weights):
    """Least factor of friction with which they stand, by bisection."""
    low, high = 0.0, 8.0
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if stands(contacts, weights, middle) else (middle, high)
    return high


def test_what_holds_logs_and_cards():
    root, (between, floor) = math.sqrt(3.0), pile_of_logs.thresholds()
    weights = {"left": (1.0, (-1.0, 1.0)), "right": (1.0, (1.0, 1.0)), "top": (1.0, (0.0, 1.0 + root))}
    # friction in proportion to the two thresholds: they hold from a factor of 1 on
    logs = [(None, "left", (-1.0, 0.0), (0.0, 1.0), floor), (None, "right", (1.0, 0.0), (0.0, 1.0), floor),
            ("left", "top", (-0.5, 1.0 + root / 2.0), (0.5, root / 2.0), between),
            ("right", "top", (0.5, 1.0 + root / 2.0), (-0.5, root / 2.0), between),
            ("left", "right", (0.0, 1.0), (1.0, 0.0), between)]  # fmt: skip
    assert threshold(logs, weights) == pytest.approx(1.0, abs=1e-6)
    lean, radius, long = math.radians(25.0), card_house.RADIUS, card_house.LENGTH
    foot, head = radius + long * math.sin(lean), radius + long * math.cos(lean)
    centre = radius + 0.5 * long * math.sin(lean), radius + 0.5 * long * math.cos(lean)
    weights = {"left": (1.0, (-centre[0], centre[1])), "right": (1.0, centre)}
    cards = [(None, "left", (-foot, 0.0), (0.0, 1.0), 1.0), (None, "right", (foot, 0.0), (0.0, 1.0), 1.0),
             ("left", "right", (0.0, head), (1.0, 0.0), 1.0)]  # fmt: skip
    needed = card_house.apex_force(lean, radius) / (card_house.MASS * GRAVITY)
    assert threshold(cards, weights) == pytest.approx(needed, abs=1e-6)


def test_rolling_off_a_ball_with_the_forces_at_the_contact():
    """Forces along and across from Newton and Euler for the rolling ball, as a linear system at each instant."""
    start = math.radians(20.0)

    def forces(angle, rate):
        # ρ ψ̈ = g sin ψ - F, ρ ψ̇² = g cos ψ - N, and k ρ ψ̈ = F: the spin keeps pace
        along, friction = np.linalg.solve([[1.0, 1.0], [RATIO, -1.0]], [GRAVITY * math.sin(angle), 0.0])
        return along, friction, GRAVITY * math.cos(angle) - rate**2

    def slips(_, y):
        _, friction, press = forces(*y)
        return press - friction

    slips.terminal = True
    _, events = integrated(lambda _, y: [y[1], forces(*y)[0]], [start, 0.0], np.array([0.0, 2.0]), slips)
    last = grip_lost(start, 1.0)
    scenario = families()["rolling-off-the-sphere"].of()
    assert scenario.duration < events[0][0] < scenario.duration + 0.04
    place = scenario.truth(np.array([events[0][0]]))
    assert math.atan2(place.x[0, 1, 0], place.x[0, 1, 2]) == pytest.approx(last, abs=1e-10)
    assert np.linalg.norm(place.v[0, 1]) == pytest.approx(fall_speed(ROLLING, start, last), abs=1e-10)
    assert place.w[0, 1, 1] * 0.125 == pytest.approx(np.linalg.norm(place.v[0, 1]), rel=1e-12)


@given(st.floats(1.0, 50.0), st.floats(0.0, 0.95))
def test_a_damped_spring_obeys_its_equation(rate, zeta):
    way, t, d = Damped(rate, zeta), np.linspace(0.01, 1.0, 7), 1e-5 / rate
    x, v = way.struck(t, 1.0)
    (_, after), (_, before) = way.struck(t + d, 1.0), way.struck(t - d, 1.0)
    np.testing.assert_allclose((after - before) / (2.0 * d), -2.0 * zeta * rate * v - rate**2 * x, atol=1e-7 * rate)
    assert way.struck(np.array([way.farthest()]), 1.0)[1][0] == pytest.approx(0.0, abs=1e-12)
    force = [2.0 * zeta * rate * v + rate**2 * x for x, v in [way.struck(np.array([way.unloaded()]), 1.0)]]
    assert force[0][0] == pytest.approx(0.0, abs=1e-11 * rate)


@pytest.mark.parametrize("amplitude", [0.035, 0.05])
def test_a_plate_and_its_box_integrated_apart(amplitude):
    """Until the spring is slack they are one body; then two, until they meet."""
    share, rate = 0.25, sprung_plate.RATE
    way = sprung_plate.thrown(amplitude, rate, share)
    stiffness, plate = rate**2, 1.0 - share  # of a whole mass of 1
    slack = GRAVITY / rate**2

    def pace(_, y):
        return [y[2], y[3], stiffness / plate * (slack - y[0]) - GRAVITY, -GRAVITY]

    def meet(t, y):
        return y[1] - y[0] + (1e-6 if t < 0.05 else 0.0)

    meet.terminal = True
    start = [way.height, way.height, way.speed, way.speed]
    _, events = integrated(pace, start, np.linspace(0.0, 0.4, 3), meet)
    assert way.height == pytest.approx(slack, rel=1e-14)
    assert way.leaves + events[0][0] == pytest.approx(way.meets, abs=1e-10)


def balance(angle, rate, drag, stays):
    """Newton and Euler for the rod: accelerations of centre and angle, and forces, with the foot on the floor."""
    half, sine, cosine = slipping_rod.HALF, math.sin(angle), math.cos(angle)
    matrix, right = np.zeros((5, 5)), np.zeros(5)  # x'', z'', θ'', N, F
    matrix[0, [0, 4]], matrix[1, [1, 3]] = [1.0, -1.0], [1.0, -1.0]
    matrix[2, 2:] = [slipping_rod.MOMENT, -half * sine, half * cosine]
    matrix[3, [1, 2]] = [1.0, half * sine]  # the foot's height stays
    right[1], right[3] = -GRAVITY, -half * cosine * rate**2
    if stays:
        matrix[4, [0, 2]], right[4] = [1.0, -half * cosine], -half * sine * rate**2
    else:
        matrix[4, [3, 4]] = [drag, 1.0]
    return np.linalg.solve(matrix, right)


@given(st.floats(0.05, 1.2), st.floats(0.0, 4.0), st.floats(-0.6, 1.6))
def test_a_slipping_rod_by_newton_and_euler(angle, rate, drag):
    if slipping_rod.contact_mobility(angle, drag) > 0.05:
        assert slipping_rod.push(angle, rate, drag) == pytest.approx(balance(angle, rate, drag, False)[3], abs=1e-9)
    if angle > 0.1:
        rate = fall_speed(slipping_rod.RATE, 0.1, angle)
        forces = balance(angle, rate, 0.0, True)[3:] / GRAVITY
        np.testing.assert_allclose(slipping_rod.foot_forces(angle, 0.1), forces, atol=1e-12)


def test_a_sliding_rod_integrated_with_all_its_coordinates():
    tilt, mu, t = math.radians(60.0), 1.6, np.linspace(0.0, 0.1, 5)

    def rate(_, y):
        x, z, turn, *_ = balance(y[2], y[5], -mu, False)
        return [*y[3:], x, z, turn]

    half = slipping_rod.HALF
    y, _ = integrated(rate, [half * math.sin(tilt), half * math.cos(tilt), tilt, -2.0, 0.0, 0.0], t)
    truth = families()["painleve-rod"].of().truth(t)
    np.testing.assert_allclose(truth.x[:, 1, ::2], y[:, :2], atol=1e-12)
    np.testing.assert_allclose(truth.w[:, 1, 1], y[:, 5], atol=1e-10)
    with pytest.raises(ValueError, match="no single answer"):
        slipping_rod.push(math.radians(30.0), 0.0, -1.6)


@given(st.floats(1.03, 3.0), st.floats(0.01, 0.06))
def test_a_wheel_at_a_step_by_the_impulses_of_its_edge(speed, height):
    """The edge stops the wheel's surface: two impulses, through the mobility of the touching point."""
    r, mass, moment = step.RADIUS, 1.0, step.RATIO * step.RADIUS**2
    arm = np.array([math.sqrt(r**2 - (r - height) ** 2), height - r])  # from the centre to the edge
    lever = np.array([arm[1], -arm[0]])  # ω about y moves the edge's place by ω (z, -x)
    mobility = np.eye(2) / mass + np.outer(lever, lever) / moment
    surface = np.array([speed, 0.0]) + speed / r * lever
    impulse = np.linalg.solve(mobility, -surface)
    assert speed / r + lever @ impulse / moment == pytest.approx(step.bumped(speed, height), rel=1e-12)
    fast = step.on_top(speed, height)
    kinetic = 0.5 * (1.0 + step.RATIO) * ((step.bumped(speed, height) * r) ** 2 - fast)
    assert kinetic == pytest.approx(GRAVITY * height, rel=1e-10)
    assert step.on_top(step.least_speed(height), height) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("ratio", [0.0, 0.5])
def test_a_rimless_wheel_comes_to_its_steady_walk(ratio):
    """Arc after arc from another speed, each integrated up to the next foot."""
    slope, rate, angle = 0.08, rimless_wheel.pace(ratio), rimless_wheel.STEP_ANGLE
    cycle, spin = rimless_wheel.walk(slope, ratio), 1.5

    def lands(_, y):
        return y[0] - slope - angle

    lands.terminal = True
    for _ in range(60):
        flow = solve_ivp(lambda _, y: [y[1], rate**2 * math.sin(y[0])], (0.0, 5.0), [slope - angle, spin], "DOP853",
                         rtol=1e-12, atol=1e-12, events=lands)  # fmt: skip
        before, time = flow.y[1, -1], flow.t[-1]
        # angular momentum about the new foot: m l² cos 2α of the hub, and the spin
        spin = before * (math.cos(2.0 * angle) + ratio) / (1.0 + ratio)
    np.testing.assert_allclose([before, spin, time], [cycle.before, cycle.after, cycle.period], rtol=1e-8)
