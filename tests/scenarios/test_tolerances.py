"""Tolerances: textbook schemes of first order lie within them, and what is wrong lies far outside."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mechanics.rotation import angle_between, rotate, unrotate
from scenarios import catalogue
from scenarios.catalogue import families
from scenarios.gazebo_boxes import ENERGY_PER_STEP, MOMENTUM_PER_STEP
from scenarios.simbenchmark_bouncing import mean_square_theory
from scenarios.tolerance import GRAVITY, SAFETY, STEP
from scenarios.tumbling_box import EULER


def tolerance(scenario, quantity):
    return next(check.tolerance for check in scenario.checks if check.quantity == quantity)


def cross(a, b):
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def explicit(moments, w, h):
    torque = cross([i * c for i, c in zip(moments, w, strict=True)], w)
    return tuple(c + h * m / i for c, m, i in zip(w, torque, moments, strict=True))


def implicit(moments, w, h):
    """One Newton step of backward Euler from the old spin: what Bullet and MuJoCo's implicitfast do."""
    a, b, c = moments
    x, y, z = w
    rows = (
        (a, h * z * (c - b), h * y * (c - b)),
        (h * z * (a - c), b, h * x * (a - c)),
        (h * y * (b - a), h * x * (b - a), c),
    )
    residual = [h * m for m in cross(w, (a * x, b * y, c * z))]
    columns = tuple(zip(*rows, strict=True))
    volume = sum(p * q for p, q in zip(columns[0], cross(columns[1], columns[2]), strict=True))
    pick = (cross(columns[1], columns[2]), cross(columns[2], columns[0]), cross(columns[0], columns[1]))
    return tuple(
        s - sum(p * r for p, r in zip(row, residual, strict=True)) / volume for s, row in zip(w, pick, strict=True)
    )


def multiplied(p, q):
    """Quaternion product p q of tuples."""
    v = cross(p[1:], q[1:])
    return (
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
        *(p[0] * b + q[0] * a + c for a, b, c in zip(p[1:], q[1:], v, strict=True)),
    )


def exact_turn(q, w, h):
    speed = math.hypot(*w)
    return multiplied(q, (math.cos(0.5 * h * speed), *(math.sin(0.5 * h * speed) * c / speed for c in w)))


def ode_turn(q, w, h):
    """What ODE does: q + h ω q/2, made a unit quaternion."""
    turned = [a + 0.5 * h * b for a, b in zip(q, multiplied(q, (0.0, *w)), strict=True)]
    norm = math.hypot(*turned)
    return tuple(c / norm for c in turned)


def stepped(body, duration, spin_rule, turn_rule=exact_turn, h=STEP):
    """Attitudes and angular velocities (world) of a free body at every step."""
    moments, q = np.diag(body.inertia_tensor).tolist(), body.orientation
    w = tuple(unrotate(np.array(q), np.array(body.angular_velocity)).tolist())
    attitudes, spins = [q], [w]
    for _ in range(round(duration / h)):
        w = spin_rule(moments, w, h)  # in the body frame of the old attitude
        before, q = q, turn_rule(q, w, h)
        if turn_rule is ode_turn:  # turns about the same axis, but by another angle: carry ω over in the world
            w = tuple(unrotate(np.array(q), rotate(np.array(before), np.array(w))).tolist())
        attitudes.append(q)
        spins.append(w)
    turned = np.array(attitudes)
    return turned, rotate(turned, np.array(spins))


def rotation_errors(body, duration, spin_rule, truth):
    q, w = stepped(body, duration, spin_rule)
    moments = np.diag(body.inertia_tensor)
    body_spin = unrotate(q, w)
    energy, momentum = 0.5 * (moments * body_spin**2).sum(axis=1), rotate(q, moments * body_spin)
    return (
        angle_between(q, truth.q[:, 0]).max(),
        np.linalg.norm(w - truth.w[:, 0], axis=1).max(),
        np.abs(energy / energy[0] - 1.0).max(),
        np.linalg.norm(momentum - momentum[0], axis=1).max() / np.linalg.norm(momentum[0]),
    )


TUMBLING = [
    *((families()["tumbling-box"].of(axis=axis), axis) for axis in ("middle", "largest", "smallest")),
    (families()["symmetric-top"].of(), "symmetric"),
]


@pytest.mark.parametrize(("scenario", "key"), TUMBLING, ids=lambda value: value if isinstance(value, str) else "")
def test_what_eulers_method_errs_by_when_a_body_tumbles(scenario, key):
    t = np.arange(round(scenario.duration / STEP) + 1) * STEP
    body, truth = scenario.scene.bodies[0], scenario.truth(t)
    both = [rotation_errors(body, scenario.duration, rule, truth) for rule in (explicit, implicit)]
    np.testing.assert_allclose(np.max(both, axis=0), EULER[key], rtol=6e-3)


def test_textbook_schemes_give_the_published_errors_of_the_gazebo_boxes():
    """The digits that ODE and Bullet published follow from their formulas alone."""
    scenario = families()["gazebo-boxes"].of()
    body, h = scenario.scene.bodies[0], STEP
    t = np.arange(10001) * h
    fall = 0.5 * body.mass * ((np.array(body.velocity) + t[:, None] * scenario.scene.gravity) ** 2).sum(axis=1)
    lift = (
        -body.mass * scenario.scene.gravity[2] * (body.velocity[2] * t + 0.5 * scenario.scene.gravity[2] * t * (t + h))
    )
    published = {}
    for name, rule, turn in (
        ("ODE", explicit, ode_turn),
        ("euler", explicit, exact_turn),
        ("Bullet", implicit, exact_turn),
    ):
        q, w = stepped(body, 10.0, rule, turn)
        moments, spin = np.diag(body.inertia_tensor), unrotate(q, w)
        energy = 0.5 * (moments * spin**2).sum(axis=1) + fall + lift
        momentum = rotate(q, moments * spin)
        off = np.linalg.norm(momentum - momentum[0], axis=1).max() / np.linalg.norm(momentum[0])
        published[name] = np.abs(energy / energy[0] - 1.0).max(), off
    assert published["ODE"] == pytest.approx((0.012462, 0.0130708), abs=1e-7)
    assert published["Bullet"] == pytest.approx((0.0135771, 0.0124501), abs=1e-7)
    assert published["euler"] == pytest.approx((0.012462, 0.0130699), abs=1e-7)
    worst = max(e for e, _ in published.values()), max(m for _, m in published.values())
    assert (ENERGY_PER_STEP * h, MOMENTUM_PER_STEP * h) == pytest.approx(worst, rel=1e-4)


def bouncing(clearance, e, duration, h, keep_overlap, gravity_first):
    """Semi-implicit Euler with a contact that is noticed at the end of the step; heights and velocities."""
    z, v, heights, speeds = clearance, 0.0, [clearance], [0.0]
    for _ in range(round(duration / h)):
        before, v = v, v - GRAVITY * h
        if z <= 0.0 and v < 0.0:
            v = -e * (v if gravity_first else before)
            z = z if keep_overlap else 0.0
        z += h * v
        heights.append(z)
        speeds.append(v)
    return np.array(heights), np.array(speeds)


# The scheme left out, which lifts bodies out of their overlap at once and adds gravity first, gains energy
# twice over at each impact: more than a first-order error.
SCHEMES = [(True, False), (True, True), (False, False)]


@given(st.sampled_from([0.3, 0.5, 0.7, 0.8, 0.9, 1.0]), st.floats(0.9, 1.1), st.sampled_from(SCHEMES))
def test_a_first_order_engine_bounces_within_the_tolerances(e, clearance, scheme):
    scenario = families()["bouncing-ball"].of(e=e, clearance=clearance)
    heights, speeds = bouncing(clearance, e, scenario.duration, STEP, *scheme)
    t = np.arange(len(heights)) * STEP
    truth = scenario.truth(t)
    away = (np.abs(t[:, None] - np.array(scenario.events)) > scenario.guard).all(axis=1)
    radius = scenario.scene.bodies[1].shape.radius
    assert np.abs(truth.x[:, 1, 2] - radius - heights).max() <= tolerance(scenario, "position error")
    assert np.abs(truth.v[:, 1, 2] - speeds)[away].max() <= tolerance(scenario, "velocity error")


@pytest.mark.parametrize("e", [0.3, 0.5, 0.7, 0.8, 0.9, 1.0])
@pytest.mark.parametrize("wrong", [-0.05, 0.05])
def test_a_wrong_restitution_does_not_pass(e, wrong):
    scenario = families()["bouncing-ball"].of(e=e)
    heights, speeds = bouncing(1.0, min(e + wrong, 1.0), scenario.duration, STEP, True, False)
    if e + wrong > 1.0:
        return
    t = np.arange(len(heights)) * STEP
    away = (np.abs(t[:, None] - np.array(scenario.events)) > scenario.guard).all(axis=1)
    assert np.abs(scenario.truth(t).v[:, 1, 2] - speeds)[away].max() > tolerance(scenario, "velocity error")
    assert abs(wrong) > tolerance(scenario, "restitution error")


def test_default_damping_does_not_pass():
    """PyBullet's default takes 4 % of the speed per second: far beyond what rounding may do."""
    for scenario in (*catalogue.find("free-fall"), *catalogue.find("projectile")):
        assert 0.04 * GRAVITY * scenario.duration**2 / 2.0 > 10.0 * tolerance(scenario, "velocity error")
        assert 0.04 * GRAVITY * scenario.duration**3 / 6.0 > 2.0 * tolerance(scenario, "position error") / SAFETY


@given(st.floats(0.0, 1.0), st.sampled_from(catalogue.find("oblique-collision")))
def test_a_late_oblique_impact_stays_within_the_tolerance(phase, scenario):
    """Let the balls overlap for part of a step, then apply the exact impulse along their centres."""
    e, (a, b) = scenario.parameters["e"], scenario.scene.bodies
    meeting = scenario.events[0]
    x = np.array(a.position) + (meeting + phase * STEP) * np.array(a.velocity)
    n = (x - np.array(b.position)) / np.linalg.norm(x - np.array(b.position))
    j = -(1.0 + e) * a.mass * b.mass / (a.mass + b.mass) * np.dot(a.velocity, n)
    truth = scenario.truth(np.array([scenario.duration]))
    off = (
        np.linalg.norm(np.array(a.velocity) + j / a.mass * n - truth.v[0, 0]),
        np.linalg.norm(-j / b.mass * n - truth.v[0, 1]),
    )
    assert max(off) <= tolerance(scenario, "velocity error")


def test_the_theory_of_the_bouncing_energy_error_is_the_published_one():
    assert mean_square_theory(1e-3) == pytest.approx(185.116, abs=1e-3)
    assert mean_square_theory(1e-2) == pytest.approx(18511.6, abs=0.1)
    heights, speeds = bouncing(4.9, 1.0, 20.0, STEP, True, False)
    energy = 490.0 * (GRAVITY * heights + 0.5 * speeds**2)[:-1]
    assert np.mean((energy - energy[0]) ** 2) == pytest.approx(185.027, abs=5e-4)


def test_tolerances_scale_with_first_order_terms():
    fall = families()["free-fall"].of()
    assert tolerance(fall, "position error") == pytest.approx(SAFETY * GRAVITY * 1.5 * STEP / 2.0)
    slide = families()["sliding-block"].of(speed=2.0)
    assert tolerance(slide, "position error") == pytest.approx(SAFETY * 2.0 * STEP / 2.0)
    assert math.isclose(tolerance(families()["stack"].of(count=10), "drift"), SAFETY * 100.0 * GRAVITY * STEP**2)
