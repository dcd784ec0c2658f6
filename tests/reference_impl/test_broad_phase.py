"""Bounding spheres keep pairs apart: never one that meets, tightly where paths are lines, whatever the order."""

import math

import numpy as np
import pytest

from mechanics.effects import Drag, Gravity, Hinge, Restitution, Rod, Rotation
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Sphere
from reference_impl.broad_phase import NEAR, all_pairs, keep_apart
from reference_impl.simulate import begin
from reference_impl.state import PLANE

FLOOR = Body("floor", HalfSpace())
BOUNCE = (Gravity(), Restitution(0.5))


def put_off(world, limit=10.0, ahead=10.0, clear=None, hits=None, skip=None):
    """Times until which all pairs are apart, from `clear` (zero unless given) on."""
    b, m, count = world.bodies, world.motion, len(world.detector.pairs)
    clear = np.zeros(count) if clear is None else clear
    none = np.zeros(count, dtype=bool)
    static = (b.inverse_mass == 0.0) & ~m.v.any(axis=1)
    keep_apart(
        world.detector.pairs, clear, none if hits is None else hits, none if skip is None else skip, static, b.shape,
        b.normal, b.reach, m.begin, m.end, m.x_series, m.bounds, limit, ahead,
    )  # fmt: skip
    return clear


def thrown(seed, n, effects=BOUNCE):
    """Spheres and boxes of all sizes above a floor, thrown at random."""
    rng, bodies = np.random.default_rng(seed), [FLOOR]
    for k in range(n):
        shape = Sphere(rng.uniform(0.05, 0.4)) if k % 2 else Box(tuple(rng.uniform(0.1, 0.5, 3)))
        place = np.array((2.0 * (k % 4), 2.0 * (k // 4 % 4), 1.0 + 2.0 * (k // 16))) + rng.uniform(-0.3, 0.3, 3)
        bodies.append(
            Body(f"body {k}", shape, rng.uniform(0.5, 3.0), tuple(place), velocity=tuple(3.0 * rng.normal(size=3)))
        )
    return Scene(tuple(bodies), effects)


def gaps(world, t):
    """Gaps of the bounding spheres of all pairs at time t [m]."""
    m, b = world.motion, world.bodies
    powers = (t - m.begin)[:, None] ** np.arange(m.x_series.shape[1])
    x = np.einsum("nk,nkc->nc", powers, m.x_series)
    one, other = world.detector.pairs.T
    apart = x[one] - x[other]
    plane = b.shape[other] == PLANE
    distance = np.where(plane, (apart * b.normal[other]).sum(axis=1), np.linalg.norm(apart, axis=1))
    return distance - b.reach[one] - np.where(plane, 0.0, b.reach[other])


@pytest.mark.parametrize("seed", range(6))
def test_no_pair_is_apart_that_meets(seed):
    """Parabolas, and curves under drag, against 1,000 samples of the time each pair is said to be apart."""
    effects = BOUNCE if seed % 2 else (Gravity(), Drag(0.8), Restitution(0.5))
    world = begin(thrown(seed, 24, effects))
    clear = put_off(world)
    assert (clear > 0.0).sum() > 0.9 * len(clear)
    assert (clear <= np.minimum(*world.motion.end[world.detector.pairs.T]) + 1e-15).all()
    met = 0
    for t in np.linspace(0.0, float(clear[np.isfinite(clear)].max()), 1000):
        gap = gaps(world, t)
        assert (gap[t < clear] > -1e-12).all()
        met += int((gap[t > clear + 0.01] < 0.0).sum())
    assert met > 0  # there was something to miss


@pytest.mark.parametrize("seed", range(6))
def test_on_straight_lines_the_time_is_that_of_the_closed_form(seed):
    """Two spheres on the same acceleration: |r + v t| = R is a quadratic equation; those that miss are never due."""
    rng = np.random.default_rng(seed)
    reach = rng.uniform(0.1, 0.5, 2)
    r, v = 3.0 * rng.normal(size=3) + np.array((4.0, 0.0, 0.0)), rng.normal(size=3)
    v -= 3.0 * r / np.linalg.norm(r) * (1.0 if seed % 2 else 0.2)
    pair = (Body("one", Sphere(reach[0]), 1.0, tuple(r), velocity=tuple(v)), Body("other", Sphere(reach[1]), 1.0))
    clear = float(put_off(begin(Scene(pair, (Gravity(), Restitution(1.0)))), limit=50.0, ahead=50.0)[0])
    a, b, c = v @ v, r @ v, r @ r - reach.sum() ** 2
    if b * b - a * c < 0.0 or b > 0.0:
        assert clear == 50.0
        return
    meet = (-b - math.sqrt(b * b - a * c)) / a
    rate = -(b + a * meet) / reach.sum()
    assert clear <= meet * (1.0 + 1e-14)
    # it stops when the bounds are NEAR; the path is convex, so that the gap then closes no slower than at the meeting
    assert clear >= meet - NEAR * reach.sum() / rate


def test_a_ball_over_a_floor_is_apart_until_it_lands():
    ball = Body("ball", Sphere(0.25), 1.0, (0.0, 0.0, 2.25))
    clear = float(put_off(begin(Scene((FLOOR, ball), (Gravity(), Restitution(1.0)))))[0])
    assert clear == pytest.approx(math.sqrt(2.0 * 2.0 / 9.81), rel=1e-15)


def test_what_is_known_is_left_as_it_is():
    world = begin(thrown(3, 12))
    count = len(world.detector.pairs)
    known = np.random.default_rng(1).uniform(0.0, 0.4, count)
    clear = put_off(world, limit=0.2, clear=known.copy())
    assert (clear[known >= 0.2] == known[known >= 0.2]).all()
    assert (clear >= known).all()
    everything = np.ones(count, dtype=bool)
    assert (put_off(world, clear=known.copy(), hits=everything) == known).all()
    assert (put_off(world, clear=known.copy(), skip=everything) == known).all()


def test_a_time_is_put_off_no_further_than_asked():
    world = begin(thrown(5, 12, (Restitution(1.0),)))
    assert put_off(world, ahead=0.01).max() == 0.01


@pytest.mark.parametrize("seed", range(4))
def test_the_order_of_the_bodies_changes_no_bit(seed):
    scene = thrown(seed, 16, (Gravity(), Rotation(), Restitution(0.5)))
    order = np.random.default_rng(seed).permutation(len(scene.bodies))
    other = Scene(tuple(scene.bodies[i] for i in order), scene.effects)
    found = []
    for world in (begin(scene), begin(other)):
        named = [frozenset(world.names(*pair)) for pair in world.detector.pairs.tolist()]
        found.append(dict(zip(named, put_off(world).tolist(), strict=True)))
    assert found[0] == found[1]


@pytest.mark.parametrize("seed", range(4))
def test_all_pairs_are_those_of_the_scene(seed):
    """Without pairs of fixed bodies and those that a joint holds."""
    rng = np.random.default_rng(seed)
    bodies = tuple(
        Body(f"body {k}", Sphere(0.1), None if rng.random() < 0.3 else 1.0, (float(k), 0.0, 0.0)) for k in range(12)
    )
    free = [body.name for body in bodies if not body.fixed]
    joints = (Rod(free[0], free[1]),)
    if seed % 2:
        joints = (*joints, Hinge(free[2], free[1], (0.0, 0.0, 0.0), (0.0, 1.0, 0.0)))
    scene = Scene(bodies, (Rotation(), Restitution(1.0), *joints))
    assert {tuple(pair) for pair in all_pairs(scene).tolist()} == {tuple(sorted(pair)) for pair in scene.pairs()}
