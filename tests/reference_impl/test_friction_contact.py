"""Lasting contact with friction against closed forms: sliding, stopping, rolling, resting, and Painlevé's rod."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mechanics.effects import Friction, Gravity, Resting, Restitution, Rotation
from mechanics.rotation import about
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Sphere
from reference_impl.audit import kinetic_energy
from reference_impl.simulate import advance, begin, simulate
from reference_impl.world import STILL, World

G = 9.81
FLOOR = Body("floor", HalfSpace())


def slope(degrees: float, shape: Box | Sphere, height: float, velocity: float = 0.0) -> tuple[Body, Body, np.ndarray]:
    """A plane inclined downwards along x, a body of 2 kg on it, and the direction down."""
    angle = math.radians(degrees)
    normal = np.array([math.sin(angle), 0.0, math.cos(angle)])
    down = np.array([math.cos(angle), 0.0, -math.sin(angle)])
    turn = tuple(about((0.0, 1.0, 0.0), angle).tolist())
    body = Body("body", shape, 2.0, tuple((height * normal).tolist()), turn, tuple((velocity * down).tolist()))
    return Body("plane", HalfSpace(tuple(normal.tolist()))), body, down


def rough(mu: float, turning: bool = True) -> tuple:
    return (Gravity(), Friction(mu), Resting(), *((Rotation(),) if turning else ()))


@pytest.mark.parametrize("turning", [False, True])
@pytest.mark.parametrize("mu", [0.467, 0.6, 5.0])
def test_a_block_on_an_incline_below_its_threshold_is_proven_to_rest(mu, turning):
    plane, block, _ = slope(25.0, Box((0.4, 0.4, 0.1)), 0.05)
    world = begin(Scene((plane, block), rough(mu, turning)))
    start = world.state().x[1]
    advance(world, 1.0)
    assert world.mode[1] == STILL
    assert world.state().x[1] == pytest.approx(start, abs=1e-16)
    total = sum(h.force * np.array(h.normal) + np.array(h.friction) for h in world.forces)
    assert total == pytest.approx((0.0, 0.0, 2.0 * G), abs=1e-12)
    for h in world.forces:
        assert np.linalg.norm(h.friction) <= mu * h.force * (1.0 + 1e-12)


@pytest.mark.parametrize("turning", [False, True])
@pytest.mark.parametrize(("mu", "speed"), [(0.3, 0.0), (0.46, 0.0), (0.3, -4.0), (0.6, 2.0)])
def test_a_block_on_an_incline_slides_stops_and_returns(mu, speed, turning):
    plane, block, down = slope(25.0, Box((0.4, 0.4, 0.1)), 0.05, speed)
    world = begin(Scene((plane, block), rough(mu, turning)))
    pull, brake = G * math.sin(math.radians(25.0)), mu * G * math.cos(math.radians(25.0))
    first = pull - math.copysign(brake, speed)
    stop = -speed / first if speed * first < 0.0 else math.inf
    start = world.state().x[1]
    for t in (0.25, 0.5, 0.75, 1.0):
        advance(world, t - world.t)
        s, rest = min(t, stop), max(t - stop, 0.0)
        way = speed * s + 0.5 * first * s**2 + 0.5 * max(pull - brake, 0.0) * rest**2
        assert world.state().x[1] == pytest.approx(start + way * down, abs=1e-13)
    assert np.linalg.norm(world.state().w[1]) <= 1e-11  # accelerations are certified to 1e-12 of g, over 1 m


@pytest.mark.parametrize("heading", [0.0, 53.13010235415598, 45.0])
def test_a_block_stops_in_a_straight_line(heading):
    way = np.array([math.cos(math.radians(heading)), math.sin(math.radians(heading)), 0.0])
    block = Body("block", Box((0.4, 0.4, 0.1)), 2.0, (0.0, 0.0, 0.05), velocity=tuple((5.0 * way).tolist()))
    world = begin(Scene((FLOOR, block), rough(0.35, turning=False)))
    advance(world, 2.0)
    assert world.mode[1] == STILL
    assert world.state().x[1] == pytest.approx([0.0, 0.0, 0.05] + 25.0 / (0.7 * G) * way, abs=1e-13)


@pytest.mark.parametrize("ratio", [1.0, 0.8])
def test_a_block_launched_across_an_incline_curves(ratio):
    """D v = v0 tan(φ/2)^r / sin φ with φ the angle from the fall line."""
    plane, block, down = slope(20.0, Box((0.4, 0.4, 0.1)), 0.05)
    across = Body("body", block.shape, 2.0, block.position, block.orientation, (0.0, 2.0, 0.0))
    world = begin(Scene((plane, across), rough(ratio * math.tan(math.radians(20.0)), turning=False)))
    time, speed = {1.0: (0.53083278678092427, 1.0717967697244908), 0.8: (0.59916531509502103, 1.3947679307932668)}[
        ratio
    ]
    advance(world, time)
    v = world.state().v[1]
    assert np.linalg.norm(v) == pytest.approx(speed, rel=1e-11)
    assert math.degrees(math.atan2(v[1], float(v @ down))) == pytest.approx(30.0, rel=1e-10)


@pytest.mark.parametrize("backspin", [0.0, 50.0])
def test_a_sliding_ball_begins_to_roll(backspin):
    ball = Body(
        "ball", Sphere(0.108), 6.0, (0.0, 0.0, 0.108), velocity=(8.0, 0.0, 0.0), angular_velocity=(0.0, -backspin, 0.0)
    )
    world = begin(Scene((FLOOR, ball), rough(0.12)))
    slip = 8.0 + 0.108 * backspin
    time, rolls = 2.0 * slip / (7.0 * 0.12 * G), (8.0 - 0.4 * 0.108 * backspin) / 1.4
    advance(world, time + 0.5)
    after = world.state()
    way = 8.0 * time - 0.06 * G * time**2 + 0.5 * rolls
    # rounding of the slip at the start, up to 13.4 m/s
    assert after.v[1] == pytest.approx((rolls, 0.0, 0.0), abs=1e-14 * slip)
    assert after.w[1] == pytest.approx((0.0, rolls / 0.108, 0.0), abs=1e-14 * slip / 0.108)
    assert after.x[1, 0] == pytest.approx(way, abs=1e-13 * way)


@pytest.mark.parametrize("mu", [0.05, 0.2, 1.0])
def test_a_bouncing_ball_ends_rolling_at_five_sevenths(mu):
    """Past the accumulation of its bounces, whatever the friction."""
    ball = Body("ball", Sphere(0.1), 1.0, (0.0, 0.0, 0.7), velocity=(3.0, 0.0, 0.0))
    world = begin(Scene((FLOOR, ball), (*rough(mu), Restitution(0.7))))
    advance(world, 6.0)
    assert world.state().v[1] == pytest.approx((15.0 / 7.0, 0.0, 0.0), rel=1e-13, abs=1e-13)
    assert world.state().w[1, 1] == pytest.approx(150.0 / 7.0, rel=1e-13)


@pytest.mark.parametrize(("mu", "acceleration", "spin"), [
    (0.5, G * math.sin(math.radians(30.0)) / 1.4, G * math.sin(math.radians(30.0)) / 0.14),
    (0.1, 4.0554290788874657, 21.239273027813358),
])  # fmt: skip
def test_a_ball_rolls_or_slips_down_an_incline(mu, acceleration, spin):
    plane, ball, down = slope(30.0, Sphere(0.1), 0.1)
    world = begin(Scene((plane, ball), rough(mu)))
    start = world.state().x[1]
    advance(world, 1.0)
    assert world.state().x[1] == pytest.approx(start + 0.5 * acceleration * down, abs=1e-13)
    assert world.state().w[1] == pytest.approx((0.0, spin, 0.0), rel=1e-12, abs=1e-12)


def test_a_block_and_the_plank_under_it_come_to_a_common_speed():
    plank = Body("plank", Box((4.0, 0.5, 0.1)), 5.0, (0.0, 0.0, 0.05))
    block = Body("block", Box((0.2, 0.2, 0.1)), 2.0, (-1.0, 0.0, 0.15), velocity=(3.0, 0.0, 0.0))
    friction = Friction(0.0, {("block", "plank"): 0.25})
    motion = simulate(Scene((FLOOR, plank, block), (Gravity(), friction, Resting())), (0.0, 1.5))
    assert motion.v[-1, 1:, 0] == pytest.approx((6.0 / 7.0, 6.0 / 7.0), rel=1e-14)
    slide = motion.x[-1, 2, 0] - motion.x[-1, 1, 0] + 1.0
    assert slide == pytest.approx(1.3106159895150721, rel=1e-13)


@pytest.mark.parametrize(("pull", "moves"), [(2.0, 2.0), (4.0, 0.3 * G)])
def test_a_box_on_an_accelerating_base_keeps_up_or_slips(pull, moves):
    base = Body("base", Box((20.0, 2.0, 0.2)), position=(0.0, 0.0, -0.1), acceleration=(pull, 0.0, 0.0))
    box = Body("box", Box((0.4, 0.4, 0.1)), 2.0, (0.0, 0.0, 0.05))
    motion = simulate(Scene((base, box), rough(0.3, turning=False)), (0.0, 1.0))
    assert motion.x[-1, 1, 0] == pytest.approx(0.5 * moves, abs=1e-13)


def test_a_belt_takes_a_box_along():
    belt = Body("belt", HalfSpace(), velocity=(2.0, 0.0, 0.0))
    box = Body("box", Box((0.4, 0.4, 0.1)), 2.0, (0.0, 0.0, 0.05))
    motion = simulate(Scene((belt, box), rough(0.3, turning=False)), (0.0, 1.0))
    skid = 4.0 / (0.6 * G)
    assert motion.x[-1, 1, 0] == pytest.approx(2.0 - skid, abs=1e-13)
    assert motion.v[-1, 1, 0] == pytest.approx(2.0, abs=1e-14)


def _energy(world: World) -> float:
    heights = zip(world.scene.bodies, world.motion.x[:, 2], strict=True)
    return kinetic_energy(world) + sum(b.mass * G * float(z) for b, z in heights if not b.fixed)


@pytest.mark.parametrize("seed", range(4))
def test_a_thrown_box_comes_to_proven_rest_and_never_gains_energy(seed):
    rng = np.random.default_rng(seed)
    q = rng.normal(size=4)
    box = Body("box", Box(tuple(rng.uniform(0.1, 0.3, 3).tolist())), 3.0, (0.0, 0.0, 0.4),
               tuple((q / np.linalg.norm(q)).tolist()), tuple(rng.normal(size=3).tolist()),
               tuple((3.0 * rng.normal(size=3)).tolist()))  # fmt: skip
    world = begin(Scene((FLOOR, box), (*rough(0.5), Restitution(0.0))))
    energy = start = _energy(world)
    while world.mode[1] != STILL and world.t < 4.0:
        advance(world, 0.05)
        assert _energy(world) <= energy + 1e-9 * start
        energy = _energy(world)
    assert world.mode[1] == STILL
    assert world.audit.gap >= -1e-9


def test_a_pushed_rod_for_which_no_forces_exist_jams():
    """Painlevé: uniform rod at 60 degrees pushed tip first with µ = 2; an impulse stops its tip, and energy falls."""
    angle = math.radians(60.0)
    length, thick = 1.0, 1e-3
    turn = about((0.0, 1.0, 0.0), angle)
    low = -0.5 * (length * math.sin(angle) + thick * math.cos(angle))
    rod = Body("rod", Box((length, 0.05, thick)), 1.0, (0.0, 0.0, -low), tuple(turn.tolist()), (5.0, 0.0, 0.0))
    world = begin(Scene((FLOOR, rod), (*rough(2.0), Restitution(0.0))))
    start = _energy(world)
    advance(world, 0.01)
    assert world.audit.painleve >= 1
    assert _energy(world) < start
    assert world.audit.gap >= -1e-9
