"""Capsules and cylinders: kinematics of their contacts to forty digits, times of contact, rolling in closed form."""

import math

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mechanics.effects import Friction, Gravity, Resting, Restitution, Rotation
from mechanics.rotation import about, matrix, normalised, product
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, Capsule, Cylinder, HalfSpace, Sphere
from reference_impl.collide.features import EDGES, FACE, LINE, POINT, REAL, RIM, RING, kinematics
from reference_impl.effects.friction import _travel
from reference_impl.simulate import advance, begin, simulate

FLOOR = Body("floor", HalfSpace())
LYING = tuple(about((1.0, 0.0, 0.0), math.pi / 2).tolist())
SMOOTH = (Gravity(), Rotation(), Restitution(0.5), Resting())


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b, strict=True))


def turned(w, t, v):
    """v turned by the angular velocity w during t."""
    size = mp.sqrt(dot(w, w))
    k = [c / size for c in w]
    c, s, along, across = mp.cos(size * t), mp.sin(size * t), dot(k, v), cross(k, v)
    return [v[i] * c + across[i] * s + k[i] * along * (1 - c) for i in range(3)]


def closed_form(kind, r, ua, ub, row):
    """Gap of two features whose points are r apart, with directions ua and ub."""
    if kind == FACE:
        return dot(ub, r) - row[12]
    if kind == EDGES:
        c = cross(ua, ub)
        return dot(c, r) / mp.sqrt(dot(c, c)) - row[12]
    if kind == POINT:
        return mp.sqrt(dot(r, r)) - row[12]
    if kind == RIM:
        return dot(ub, r) - row[13] * mp.sqrt(1 - dot(ub, ua) ** 2)
    h = dot(r, ub)
    rho = mp.sqrt(dot(r, r) - h * h)
    return rho - row[12] if kind == LINE else mp.sqrt((rho - row[3]) ** 2 + h * h) - row[12]


@pytest.mark.parametrize("kind", [FACE, EDGES, POINT, LINE, RIM, RING])
@pytest.mark.parametrize("seed", range(3))
def test_kinematics_of_every_kind_against_forty_digits(kind, seed):
    rng = np.random.default_rng(seed)
    xa, va, wa, xb, vb, wb = rng.normal(size=(6, 3))
    xa[2] += 3.0
    ra, rb = (matrix(q) for q in normalised(rng.normal(size=(2, 4))))
    row = np.zeros(REAL)
    row[0:3], row[6:9] = 0.3 * rng.normal(size=(2, 3))
    for at in (3, 9):
        row[at : at + 3] = rng.normal(size=3)
        row[at : at + 3] /= np.linalg.norm(row[at : at + 3])
    row[12], row[13] = (0.4, 0.4) if kind == RIM else (0.7, 0.3)
    if kind == RING:
        row[3:6] = 0.5, 0.0, 0.0
    n, point, kinds = np.empty(3), np.empty(3), np.array((0, 1, kind, 0, 0))
    gap, rate, bias = kinematics(kinds, row, xa, ra, va, wa, xb, rb, vb, wb, n, point)
    with mp.workdps(40):
        exact = [[mp.mpf(float(c)) for c in v] for v in (row, xa, va, wa, xb, vb, wb)]
        numbers, place_a, speed_a, spin_a, place_b, speed_b, spin_b = exact
        arms = [[dot(map(mp.mpf, r[i].tolist()), numbers[k : k + 3]) for i in range(3)]
                for r, k in ((ra, 0), (ra, 3), (rb, 6), (rb, 9))]  # fmt: skip

        def truth(t):
            pa, ua = (turned(spin_a, t, v) for v in arms[:2])
            pb, ub = (turned(spin_b, t, v) for v in arms[2:])
            r = [place_a[i] - place_b[i] + (speed_a[i] - speed_b[i]) * t + pa[i] - pb[i] for i in range(3)]
            return closed_form(kind, r, ua, ub, numbers)

        assert abs(truth(0) - gap) < 1e-14
        assert abs(mp.diff(truth, 0) - rate) < 1e-13
        assert abs(mp.diff(truth, 0, 2) - bias) < 1e-13 * (1.0 + abs(bias))
    # the gap changes as the material points at the contact move along the normal, whichever point it is
    assert n @ (va + np.cross(wa, point - xa) - vb - np.cross(wb, point - xb)) == pytest.approx(rate, abs=1e-13)
    h = 1e-4
    places = []
    for t in (-2 * h, -h, h, 2 * h):
        qa, qb = (np.array([turned(w, t, v) for v in r.T], dtype=float).T for w, r in ((wa, ra), (wb, rb)))
        place = np.empty(3)
        kinematics(kinds, row, xa + va * t, qa, va, wa, xb + vb * t, qb, vb, wb, np.empty(3), place)
        places.append(place)
    travel = (places[0] - 8.0 * places[1] + 8.0 * places[2] - places[3]) / (12.0 * h)
    assert _travel(kind, row, n, xa, ra, va, wa, xb, rb, vb, wb) == pytest.approx(travel, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("shape", [Cylinder(0.3, 0.8), Capsule(0.3, 0.8)])
@pytest.mark.parametrize("slope", [20.0, 35.0])
def test_it_rolls_down_an_incline(shape, slope):
    """Without sliding s = g sin / (1 + k) t² / 2 with k = I / (m R²), 1/2 for a cylinder."""
    up = np.array((math.sin(math.radians(slope)), 0.0, math.cos(math.radians(slope))))
    down = np.array((up[2], 0.0, -up[0]))
    body = Body("log", shape, 2.0, tuple((0.3 * up).tolist()), LYING)
    k = body.inertia_tensor[2][2] / (2.0 * 0.3**2)
    if isinstance(shape, Cylinder):
        assert k == pytest.approx(0.5, rel=1e-15)
    effects = (Gravity(), Rotation(), Friction(1.0), Resting())
    path = simulate(Scene((Body("incline", HalfSpace(tuple(up.tolist()))), body), effects), np.linspace(0.0, 1.0, 5))
    pull = 9.81 * math.sin(math.radians(slope)) / (1.0 + k)
    assert np.abs((path.x[:, 1] - path.x[0, 1]) @ down - 0.5 * pull * path.t**2).max() < 1e-12
    assert np.abs(path.v[:, 1] @ down - pull * path.t).max() < 1e-12
    assert np.abs(path.x[:, 1] @ up - 0.3).max() < 1e-14
    assert np.abs(path.w[:, 1, 1] - pull / 0.3 * path.t).max() < 1e-11


@pytest.mark.parametrize(("shape", "height"), [(Cylinder(0.3, 0.4), 0.2), (Capsule(0.2, 0.5), 0.45)])
def test_it_lands_upright_at_the_time_of_fall(shape, height):
    body = Body("b", shape, 1.0, (0.0, 0.0, height + 1.0))
    world = begin(Scene((FLOOR, body), (Gravity(), Rotation(), Restitution(0.5))))
    advance(world, 0.6)
    assert world.events[0].time == pytest.approx(math.sqrt(2.0 / 9.81), rel=1e-15)
    assert world.state().v[1, 2] == pytest.approx(0.5 * math.sqrt(2.0 * 9.81) - 9.81 * (0.6 - world.t), abs=9.81 * 0.2)
    bounce = sum(e.impulse for e in world.events if e.time == world.events[0].time)
    assert bounce == pytest.approx(1.5 * math.sqrt(2.0 * 9.81), rel=1e-14)


def test_a_cylinder_dropped_on_its_base_comes_to_proven_rest():
    world = begin(Scene((FLOOR, Body("b", Cylinder(0.3, 0.4), 1.0, (0.0, 0.0, 1.2))), SMOOTH))
    advance(world, 4.0)
    assert world.audit.rests == 1
    assert world.state().x[1, 2] == pytest.approx(0.2, rel=1e-15)
    assert sum(h.force for h in world.forces) == pytest.approx(9.81, rel=1e-13)


def lowest(shape, x, q):
    """Height of the lowest point over the floor."""
    up = matrix(np.array(q))[2]
    if isinstance(shape, Capsule):
        return x[2] - 0.5 * shape.length * abs(up[2]) - shape.radius
    return x[2] - 0.5 * shape.length * abs(up[2]) - shape.radius * math.hypot(up[0], up[1])


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 100_000), st.sampled_from([0.0, 4.0, 60.0]), st.booleans())
def test_no_first_contact_with_the_floor_is_passed(seed, spin, capsule):
    rng = np.random.default_rng(seed)
    shape = Capsule(0.1, 0.7) if capsule else Cylinder(float(rng.uniform(0.1, 0.6)), float(rng.uniform(0.05, 1.0)))
    q = tuple(normalised(rng.normal(size=4)).tolist())
    body = Body("b", shape, 1.0, (0.0, 0.0, 2.0), q, angular_velocity=tuple((spin * rng.normal(size=3)).tolist()))
    world = begin(Scene((FLOOR, body), (Gravity(), Rotation(), Restitution(1.0))))
    while not world.events:
        advance(world, 0.2)
    free = simulate(Scene((body,), (Gravity(), Rotation())), np.linspace(0.0, world.events[0].time, 400))
    low = [lowest(shape, x, q) for x, q in zip(free.x[:, 0], free.q[:, 0], strict=True)]
    assert min(low[:-1]) > -1e-12
    assert abs(low[-1]) < 1e-12


def distance_to_cylinder(p, ring, half):
    wide, high = math.hypot(p[0], p[1]) - ring, abs(p[2]) - half
    return math.hypot(max(wide, 0.0), max(high, 0.0)) if max(wide, high) > 0.0 else max(wide, high)


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 100_000))
def test_a_ball_meets_a_tumbling_cylinder_and_never_before(seed):
    rng = np.random.default_rng(seed)
    q = tuple(normalised(rng.normal(size=4)).tolist())
    spin = tuple((8.0 * rng.normal(size=3)).tolist())
    can = Body("can", Cylinder(0.4, 0.6), 2.0, orientation=q, angular_velocity=spin)
    aim = 0.3 * rng.normal(size=3)
    ball = Body("ball", Sphere(0.1), 1.0, (3.0, *aim[1:].tolist()), velocity=(-2.0, 0.0, 0.0))
    world = begin(Scene((ball, can), (Rotation(), Restitution(1.0))))
    advance(world, 2.5)
    hit = world.events[0].time if world.events else 2.5
    free = simulate(Scene((can,), (Rotation(),)), np.linspace(0.0, hit, 400))
    gaps = []
    for t, turn in zip(free.t, free.q[:, 0], strict=True):
        centre = np.array(ball.position) + t * np.array(ball.velocity)
        gaps.append(distance_to_cylinder(matrix(turn).T @ centre, 0.4, 0.3) - 0.1)
    assert min(gaps[:-1]) > -1e-12
    if world.events:
        assert abs(gaps[-1]) < 1e-12
        before = 0.5 * 1.0 * 4.0 + 0.5 * np.array(spin) @ can_inertia(can) @ np.array(spin)
        state = world.state()
        rotation = matrix(state.q[1])
        inertia = rotation @ np.array(can.inertia_tensor) @ rotation.T
        after = 0.5 * state.v[0] @ state.v[0] + state.v[1] @ state.v[1] + 0.5 * state.w[1] @ inertia @ state.w[1]
        assert after == pytest.approx(before, rel=1e-12)


def can_inertia(can):
    rotation = matrix(np.array(can.orientation))
    return rotation @ np.array(can.inertia_tensor) @ rotation.T


def test_two_capsules_that_cross_touch_once_and_parallel_ones_at_both_ends():
    for turn, count in ((math.pi / 2, 1), (0.0, 2)):
        log = Body("log", Capsule(0.1, 1.0), None, orientation=LYING)
        q = tuple((about((0.0, 0.0, 1.0), turn)).tolist())

        rod = Body(
            "rod", Capsule(0.1, 0.4), 1.0, (0.0, 0.0, 0.2), tuple(product(np.array(q), np.array(LYING)).tolist())
        )
        world = begin(Scene((log, rod), SMOOTH))
        advance(world, 0.01)
        assert len(world.forces) == count
        assert sum(h.force for h in world.forces) == pytest.approx(9.81, rel=1e-12)


def test_a_capsule_lies_on_a_box_as_on_a_floor():
    table = Body("table", Box((2.0, 2.0, 0.2)), None, (0.0, 0.0, -0.1))
    rod = Body("rod", Capsule(0.1, 0.4), 1.0, (0.0, 0.0, 0.5), LYING)
    paths = [simulate(Scene((under, rod), SMOOTH), np.linspace(0.0, 2.0, 9)).x[:, 1] for under in (table, FLOOR)]
    assert np.abs(paths[0] - paths[1]).max() < 1e-12
