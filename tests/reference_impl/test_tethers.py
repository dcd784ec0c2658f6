"""Tethers: slack, going taut, taut, and slack again."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq
from scipy.special import ellipj, ellipk, ellipkinc

from mechanics.effects import Gravity, Resting, Restitution, Rotation, Tether
from mechanics.rotation import normalised, rotate
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Sphere
from reference_impl.errors import Unsupported
from reference_impl.simulate import advance, begin
from reference_impl.world import FLYING, HELD, STILL

G = 9.81
POST = Body("post", Sphere(0.01))


def ball(name, place, velocity=(0.0, 0.0, 0.0), mass=1.0, radius=0.05):
    return Body(name, Sphere(radius), mass, tuple(float(c) for c in place), velocity=tuple(float(c) for c in velocity))


@pytest.mark.parametrize(("e", "after", "impulse"), [(0.0, (-0.54, 0.72), 1.3), (0.5, (-1.06, 0.33), 1.95)])
def test_a_ball_runs_into_its_string(e, after, impulse):
    """|r| = 2 m at 0.8 s; the radial speed of 1.3 m/s turns to -e times itself, the rest of the velocity stays."""
    scene = Scene((POST, ball("ball", (1.2, 0.0, 0.0), (0.5, 0.0, 1.5))), (Tether("post", "ball", 2.0, e),))
    world = begin(scene)
    advance(world, 0.8 + 1e-9)
    (event,) = world.events
    assert event.time == pytest.approx(0.8, rel=1e-15)
    assert event.impulse == pytest.approx(impulse, rel=1e-14)
    assert world.state().v[1] == pytest.approx((after[0], 0.0, after[1]), abs=2e-9)
    assert world.mode[1] == (HELD if e == 0.0 else FLYING)
    advance(world, 3.0 - world.t)
    if e == 0.0:  # round the post at 0.9 m/s
        start = math.atan2(1.2, 1.6) + 0.9 * 2.2 / 2.0
        assert world.state().x[1] == pytest.approx((2.0 * math.cos(start), 0.0, 2.0 * math.sin(start)), abs=1e-12)
        assert [h.force for h in world.forces] == [pytest.approx(0.405, rel=1e-12)]
        assert world.forces[0].normal == pytest.approx(world.state().x[1] / 2.0, abs=1e-1)


def test_two_thrown_bodies_on_a_slack_tether_fall_freely():
    """Of equal acceleration: when it goes taut follows from one square root, and their centre never notices."""
    a = ball("a", (0.0, 0.0, 2.0), (0.1, 0.0, 3.0), 1.0)
    b = ball("b", (0.3, 0.0, 2.0), (1.1, 0.4, 2.5), 3.0)
    world = begin(Scene((a, b), (Gravity(), Tether("a", "b", 1.5, 1.0))))
    advance(world, 2.5)
    r, v = np.array((0.3, 0.0, 0.0)), np.array((1.0, 0.4, -0.5))
    time = (-r @ v + math.sqrt((r @ v) ** 2 + v @ v * (1.5**2 - r @ r))) / (v @ v)
    assert world.events[0].time == pytest.approx(time, rel=1e-15)
    assert world.audit.steps == 0  # never under forces: it springs back
    state = world.state()
    centre = (state.x[0] + 3.0 * state.x[1]) / 4.0
    start, speed = np.array((0.225, 0.0, 2.0)), np.array((0.85, 0.3, 2.625))
    assert centre == pytest.approx(start + 2.5 * speed - (0.0, 0.0, 0.5 * G * 6.25), abs=1e-13)
    assert 0.5 * (state.v[0] @ state.v[0] + 3.0 * state.v[1] @ state.v[1]) + 4.0 * G * centre[2] == pytest.approx(
        0.5 * (9.01 + 3.0 * (1.21 + 0.16 + 6.25)) + 8.0 * G, rel=1e-14
    )


def test_a_ball_falls_into_its_string_and_swings():
    """Dropped beside its post: parabola, jerk that keeps the tangential velocity, then a pendulum."""
    length, aside = 1.0, 0.6
    scene = Scene((POST, ball("ball", (aside, 0.0, 0.0))), (Gravity(), Tether("post", "ball", length)))
    world = begin(scene)
    advance(world, 3.0)
    depth = 0.8
    time, speed = math.sqrt(2.0 * depth / G), math.sqrt(2.0 * depth * G)
    (event,) = world.events
    assert event.time == pytest.approx(time, abs=1e-13)
    assert event.impulse == pytest.approx(speed * depth, rel=1e-12)
    # tangential speed v sin θ0 at sin θ0 = 0.6: energy sets the amplitude, and the phase follows
    angle, spin = math.asin(aside), -speed * aside / length
    k = math.sqrt(math.sin(0.5 * angle) ** 2 + spin**2 / (4.0 * G))
    rate = math.sqrt(G)
    phase = brentq(lambda u: 2.0 * math.asin(k * ellipj(u, k * k)[0]) - angle, 0.0, float(ellipk(k * k)), xtol=1e-15)
    # θ falls first: backwards in time it comes from the other side
    later = 2.0 * math.asin(k * ellipj(phase - rate * (3.0 - time), k * k)[0])
    assert world.state().x[1] == pytest.approx((math.sin(later), 0.0, -math.cos(later)), abs=1e-11)
    assert world.mode[1] == HELD


def test_a_swing_that_goes_slack_flies_and_comes_back():
    """Struck at the bottom with v² = 3.5 g l the string goes slack at cos θ = -1/2: a parabola to the next jerk."""
    v0 = math.sqrt(3.5 * G)
    world = begin(
        Scene((POST, ball("ball", (0.0, 0.0, -1.0), (v0, 0.0, 0.0))), (Gravity(), Tether("post", "ball", 1.0)))
    )
    advance(world, 0.3)
    while world.mode[1] != FLYING:
        advance(world, 0.01)
    start = np.array((math.sin(2.0 * math.pi / 3.0), 0.0, 0.5))
    speed = math.sqrt(0.5 * G)  # v² = g l / 2 there
    # the slack begins as the cube of the time and is told from none at 1e-9 m/s
    state = world.state()
    velocity = speed * np.array((-0.5, 0.0, start[0]))
    flown = (state.x[1, 0] - start[0]) / velocity[0]
    assert state.x[1] == pytest.approx(start + velocity * flown - (0.0, 0.0, 0.5 * G * flown**2), abs=1e-10)
    while not world.events:
        advance(world, 0.05)

    def excess(t):
        return np.linalg.norm(start + velocity * t - np.array((0.0, 0.0, 0.5 * G * t * t))) - 1.0

    again = brentq(excess, 0.2, 2.0, xtol=1e-15)
    # sin(θ / 2) = k sin φ and t = F(φ, k²) / sqrt(g / l) up to θ = 2π/3
    k = v0 / (2.0 * math.sqrt(G))
    begun = float(ellipkinc(math.asin(math.sin(math.pi / 3.0) / k), k * k)) / math.sqrt(G)
    # what parts by less than 1e-9 of the speed scale, here 7e-10 m/s, is held: that much flies on for 0.8 s
    assert world.events[0].time == pytest.approx(begun + again, abs=1e-9)


def test_a_ball_on_a_string_hangs_at_rest_and_its_string_carries_it():
    world = begin(Scene((POST, ball("ball", (0.0, 0.0, -2.0), mass=3.0)), (Gravity(), Tether("ball", "post", 2.0))))
    advance(world, 10.0)
    assert world.mode[1] == STILL
    (held,) = world.forces
    assert held.force == pytest.approx(3.0 * G, rel=1e-15)
    assert held.normal == (0.0, 0.0, 1.0)  # pulls the ball, which is its body a, up
    assert (world.state().x[1] == (0.0, 0.0, -2.0)).all()


def test_a_dropped_ball_bounces_on_its_string_to_rest():
    """Straight down from the post with e = 1/2: falls of height e² of the one before, then it hangs."""
    world = begin(Scene((POST, ball("ball", (0.0, 0.0, -0.5))), (Gravity(), Tether("post", "ball", 2.0, 0.5))))
    advance(world, 4.0)
    time, speed = math.sqrt(3.0 / G), math.sqrt(3.0 * G)
    for event in world.events[:6]:
        assert event.time == pytest.approx(time, rel=1e-13)
        assert event.impulse == pytest.approx(1.5 * speed, rel=1e-12)
        speed *= 0.5
        time += 2.0 * speed / G
    assert world.mode[1] == STILL
    assert world.state().x[1] == pytest.approx((0.0, 0.0, -2.0), abs=1e-14)


def test_a_box_on_a_tether_and_a_floor():
    """A tether too short to let a box lie flat holds up one of its sides; floor and string share the weight."""
    floor = Body("floor", HalfSpace())
    hook = Body("hook", Sphere(0.01), position=(0.5, 0.0, 1.1))
    box = Body("box", Box((1.0, 0.4, 0.2)), 2.0, (0.0, 0.0, 0.1))
    tether = Tether("hook", "box", 1.0, anchor_b=(0.5, 0.0, 0.0))
    world = begin(Scene((floor, hook, box), (Gravity(), Rotation(), Resting(), tether)))
    advance(world, 1.0)
    assert sum(h.force for h in world.forces) == pytest.approx(2.0 * G, rel=1e-13)
    assert world.mode[2] == STILL


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 10_000), st.sampled_from([0.0, 0.5, 1.0]))
def test_tumbling_boxes_on_a_tether_keep_their_momenta(seed, e):
    """Two boxes thrown apart, tied off their centres: momentum, spin and, for e = 1, energy; never too long."""
    rng = np.random.default_rng(seed)
    boxes = [
        Body(f"b{i}", Box(tuple(rng.uniform(0.2, 0.6, 3))), float(rng.uniform(0.5, 3.0)),
             (1.2 * i, *rng.uniform(-0.2, 0.2, 2)), tuple(normalised(rng.normal(size=4))),
             tuple(rng.normal(size=3) + np.array((2.0 * i - 1.0, 0.0, 0.0))), tuple(2.0 * rng.normal(size=3)))
        for i in range(2)
    ]  # fmt: skip
    anchors = rng.uniform(-0.2, 0.2, (2, 3))
    scene = Scene(tuple(boxes), (Rotation(), Tether("b0", "b1", 2.0, e, tuple(anchors[0]), tuple(anchors[1]))))
    world = begin(scene)

    def totals():
        s, m, masses = world.state(), world.motion, np.array([b.mass for b in boxes])
        spin = (np.cross(s.x, masses[:, None] * s.v) + m.L).sum(axis=0)
        return np.array((*(masses[:, None] * s.v).sum(axis=0), *spin)), 0.5 * (
            masses @ (s.v**2).sum(axis=1) + (m.L * s.w).sum()
        )

    before, energy = totals()
    for _ in range(10):
        advance(world, 0.1)
        now, left = totals()
        assert now == pytest.approx(before, abs=1e-11)
        assert left <= energy + 1e-11
        if e == 1.0:
            assert left == pytest.approx(energy, rel=1e-11)
        s = world.state()
        ends = [x + rotate(q, p) for x, q, p in zip(s.x, s.q, anchors, strict=True)]
        assert np.linalg.norm(ends[0] - ends[1]) <= 2.0 + 1e-10


def test_an_impact_passes_through_taut_strings():
    """Three balls on straight taut strings, the first struck away from the others with e = 0: all move as one."""
    balls = [ball(f"b{i}", (float(i), 0.0, 0.0)) for i in range(3)]
    cue = ball("cue", (0.5, 0.0, 0.0), (-2.0, 0.0, 0.0), radius=0.05)
    tethers = tuple(Tether(f"b{i}", f"b{i + 1}", 1.0) for i in range(2))
    world = begin(Scene((*balls, cue), (Restitution(0.0), Resting(), *tethers)))
    advance(world, 0.5)
    assert world.state().v[:, 0] == pytest.approx((-0.5,) * 4, abs=1e-12)


@pytest.mark.parametrize(("effect", "match"), [
    (Tether("post", "ball", 0.5), r"Tether between 'post' and 'ball': its anchors are 1\.2 m apart at the start"),
    (Tether("post", "cart", 5.0), r"Tether between 'post' and 'cart': both are fixed and one of them moves"),
])  # fmt: skip
def test_a_tether_that_is_too_short_is_refused(effect, match):
    cart = Body("cart", Sphere(0.1), position=(1.0, 0.0, 0.0), velocity=(1.0, 0.0, 0.0))
    with pytest.raises(Unsupported, match=match):
        begin(Scene((POST, ball("ball", (1.2, 0.0, 0.0)), cart), (effect,)))


def test_a_tether_pulled_by_a_moving_body_goes_taut():
    """A cart that drives away with 1 m/s² takes its load along from the moment the string is taut."""
    cart = Body("cart", Sphere(0.1), position=(0.0, 0.0, 0.0), acceleration=(1.0, 0.0, 0.0))
    scene = Scene((cart, ball("load", (-1.0, 0.0, 0.0), mass=2.0)), (Tether("cart", "load", 3.0),))
    world = begin(scene)
    advance(world, 3.0)
    assert world.events[0].time == pytest.approx(2.0, rel=1e-14)
    assert world.state().x[1] == pytest.approx((1.5, 0.0, 0.0), abs=1e-12)
    assert [h.force for h in world.forces] == [pytest.approx(2.0, rel=1e-12)]


def test_a_slack_tether_changes_nothing():
    bodies = (POST, ball("ball", (1.0, 0.0, 0.0), (1.0, 0.0, 2.0)), Body("floor", HalfSpace(), position=(0, 0, -2.0)))
    effects = (Gravity(), Restitution(0.7))
    tied, free, bouncing = (
        begin(Scene(bodies, more)) for more in ((*effects, Tether("post", "ball", 50.0)), effects, effects)
    )
    free.flock = None  # the loop of bounces, which knows no tethers, rounds otherwise
    for world in (tied, free, bouncing):
        advance(world, 1.0)
    for name in ("x", "q", "v", "w"):
        assert np.array_equal(getattr(tied.state(), name), getattr(free.state(), name))
        assert getattr(bouncing.state(), name) == pytest.approx(getattr(free.state(), name), abs=1e-15)
