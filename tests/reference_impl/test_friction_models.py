"""Cones that are not Coulomb's, and what they change: closed forms of blocks and balls under a pyramid."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mechanics.effects import Friction, Gravity, Resting, Restitution, Rotation
from mechanics.rotation import normalised
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Sphere
from reference_impl.contact_problem import NoSolution
from reference_impl.friction_polygon import nearest
from reference_impl.friction_problem import Rough, solve
from reference_impl.settings import Settings
from reference_impl.simulate import advance, begin
from reference_impl.world import STILL

G, MU = 9.81, 0.35
FLOOR = Body("floor", HalfSpace())


def sliding(heading: float, sides: int, turning: bool, speed: float = 3.0) -> tuple:
    """A block on the floor, whose polygon has corners along both axes, and the direction it slides in."""
    way = np.array([math.cos(heading), math.sin(heading), 0.0])
    block = Body("block", Box((0.4, 0.4, 0.1)), 2.0, (0.0, 0.0, 0.05), velocity=tuple((speed * way).tolist()))
    effects = (Gravity(), Friction(MU), Resting(), *((Rotation(),) if turning else ()))
    return begin(Scene((FLOOR, block), effects), Settings(friction="pyramid", sides=sides)), way


@pytest.mark.parametrize("turning", [False, True])
@pytest.mark.parametrize("sides", [4, 8, 16])
@pytest.mark.parametrize("share", [0.0, 0.2, 0.7, 1.0])
def test_a_block_turns_away_from_the_corner_and_stops_midway(share, sides, turning):
    """Friction -µ f e_1 until the slip is midway between two corners, then µ f cos(π/N) against it."""
    half, speed, brake = math.pi / sides, 3.0, MU * G
    heading = share * half
    world, _ = sliding(heading, sides, turning)
    met = speed * math.sin(heading) / math.sin(half)  # speed when it is midway
    first = (speed * math.cos(heading) - met * math.cos(half)) / brake
    last = met / (brake * math.cos(half))
    corner, across = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
    middle = np.array([math.cos(half), math.sin(half), 0.0])
    for t in (0.4 * first, first, first + 0.3 * last, first + last + 0.1):
        if t > world.t:
            advance(world, t - world.t)
        s, rest = min(world.t, first), min(max(world.t - first, 0.0), last)
        x = (speed * math.cos(heading) * s - 0.5 * brake * s * s) * corner + speed * math.sin(heading) * s * across
        x = x + (met * rest - 0.5 * brake * math.cos(half) * rest**2) * middle
        assert world.state().x[1] == pytest.approx(x + np.array([0.0, 0.0, 0.05]), abs=2e-13)
    assert world.mode[1] == STILL
    assert world.audit.residual <= 1e-12


def test_the_error_of_a_polygon_falls_with_the_square_of_its_sides():
    """Midway between corners the brake is µ g cos(π/N) for µ g, whatever is not exact shows nowhere else."""
    for sides in (4, 8, 16, 32):
        world, way = sliding(math.pi / sides, sides, False)
        advance(world, 0.3)
        missing = 1.0 - float((3.0 * way - world.state().v[1]) @ way) / (0.3 * MU * G)
        assert missing == pytest.approx(1.0 - math.cos(math.pi / sides), abs=1e-14)
        # the square is right to its next term, (π/N)⁴/24
        assert missing == pytest.approx(0.5 * (math.pi / sides) ** 2, rel=0.09 * (math.pi / sides) ** 2)


@pytest.mark.parametrize(("seed", "sides"), [(0, 4), (2, 4), (2, 6), (3, 6)])
def test_a_block_holds_on_a_slope_where_the_polygon_says(seed, sides):
    """Gravity along the slope within µ times the polygon of its normal part, or not."""
    rng = np.random.default_rng(seed)
    azimuth, tilt = rng.uniform(0.0, 2.0 * math.pi), math.atan(MU * rng.uniform(0.75, 1.1))
    n = np.array([math.sin(tilt) * math.cos(azimuth), math.sin(tilt) * math.sin(azimuth), math.cos(tilt)])
    first = np.cross(n, np.eye(3)[np.argmin(np.abs(n))])
    first /= np.linalg.norm(first)
    pull = np.array([0.0, 0.0, -G]) + G * n[2] * n
    angles = math.pi / sides * (2.0 * np.arange(sides) + 1.0)  # of the middles of the sides
    reach = max(np.cos(a) * pull @ first + np.sin(a) * pull @ np.cross(n, first) for a in angles)
    inside = reach <= MU * G * n[2] * math.cos(math.pi / sides)
    half = 0.5 * math.acos(n[2])
    axis = np.cross([0.0, 0.0, 1.0], n) / math.sin(2.0 * half)
    turn = (math.cos(half), *(math.sin(half) * axis).tolist())
    block = Body("block", Box((0.4, 0.4, 0.1)), 2.0, tuple((0.05 * n).tolist()), turn)
    scene = Scene(
        (Body("slope", HalfSpace(tuple(n.tolist()))), block), (Gravity(), Friction(MU), Resting(), Rotation())
    )
    world = begin(scene, Settings(friction="pyramid", sides=sides))
    advance(world, 0.2)
    assert (world.mode[1] == STILL) == inside
    moved = world.state().x[1] - 0.05 * n
    # friction is some point of the polygon and takes the most power: what is left is the distance from it
    size = MU * G * n[2]
    along = nearest(size, float(pull @ first), float(pull @ np.cross(n, first)), sides)
    left = pull - along[0] * first - along[1] * np.cross(n, first)
    assert moved == pytest.approx(0.02 * left, abs=1e-12)


def test_a_ball_that_slides_and_rolls_obeys_the_polygon():
    """Midway between corners a ball brakes as if µ were µ cos(π/N): it rolls at 5/7 of its speed, later."""
    brake = MU * G * math.cos(math.pi / 4.0)
    way = np.array([math.sqrt(0.5), math.sqrt(0.5), 0.0])
    ball = Body("ball", Sphere(0.1), 1.0, (0.0, 0.0, 0.1), velocity=tuple((2.0 * way).tolist()))
    scene = Scene((FLOOR, ball), (Gravity(), Friction(MU), Resting(), Rotation()))
    world = begin(scene, Settings(friction="pyramid", sides=4))
    rolls = 2.0 * 2.0 / (7.0 * brake)
    advance(world, 0.9 * rolls)
    assert world.state().v[1] == pytest.approx((2.0 - brake * 0.9 * rolls) * way, abs=1e-13)
    advance(world, 0.5)
    assert world.state().v[1] == pytest.approx(2.0 * 5.0 / 7.0 * way, abs=1e-13)


def test_a_box_thrown_on_a_polygon_comes_to_rest_and_gains_nothing():
    rng = np.random.default_rng(0)
    box = Body("box", Box((0.5, 0.3, 0.2)), 2.0, (0.0, 0.0, 0.5), tuple(normalised(rng.normal(size=4)).tolist()),
               tuple(rng.normal(size=3).tolist()), tuple((3.0 * rng.normal(size=3)).tolist()))  # fmt: skip
    scene = Scene((FLOOR, box), (Gravity(), Rotation(), Friction(0.5), Restitution(0.0), Resting()))
    world = begin(scene, Settings(friction="pyramid", sides=8))
    advance(world, 4.0)
    assert world.mode[1] == STILL
    assert max(world.audit.step_rise, world.audit.energy_rise) <= 1e-9
    assert world.audit.residual <= 1e-9


@pytest.mark.parametrize("mu", [0.1, 0.4, 0.8])
def test_hops_of_the_convex_law_end_when_and_where_coulomb_stops(mu):
    """The convex law makes what slides part at µ times its slip, so that it lasts in no contact: it hops.

    With s the slip and e = 0 an impact at the speed w takes p = (w + µ s) / (1 + µ²), so that all after the first
    have p = 2 µ s / (1 + µ²) and the slip falls by the factor (1 - µ²) / (1 + µ²), and a hop takes 2 µ s / g.  The
    sums of these times and ways are s/µg and s²/2µg, as if it had slid since it was put down.
    """
    s0, fall = 2.0, 0.01
    block = Body("block", Box((0.4, 0.4, 0.1)), 2.0, (0.0, 0.0, 0.05), velocity=(s0, 0.0, -fall))
    world = begin(Scene((FLOOR, block), (Gravity(), Friction(mu), Restitution(0.0), Resting())),
                  Settings(friction="convex"))  # fmt: skip
    advance(world, 1e-9)
    parted = s0 - mu * (fall + mu * s0) / (1.0 + mu * mu)
    after = world.state()
    assert (after.v[1, 0], after.v[1, 2] + 1e-9 * G) == pytest.approx((parted, mu * parted), rel=1e-12)
    # the impulse of the fall itself is friction's, too: what is left slides like under Coulomb's law
    slip = s0 - mu * fall
    stop = slip / (mu * G)
    highest = 0.0
    while world.t < 1.001 * stop:
        advance(world, 1.001 * stop / 50.0)
        highest = max(highest, float(world.state().x[1, 2]) - 0.05)
    assert world.mode[1] == STILL
    # hops of 5e-6 of the time scale and less are skipped: the place of the last one remains open by its width
    assert world.state().x[1, 0] == pytest.approx(0.5 * slip * stop, rel=1e-5)
    assert highest <= (mu * parted) ** 2 / (2.0 * G) * (1.0 + 1e-9)


@pytest.mark.parametrize("sides", [4, 8])
def test_every_answer_with_a_polygon_is_certified(sides):
    """Forces within the polygon that take the most power from the slip, at 250 random problems each."""
    rng = np.random.default_rng(sides)
    angles = 2.0 * np.pi * np.arange(sides) / sides
    corners = np.stack([np.cos(angles), np.sin(angles)])
    solved = 0
    for _ in range(250):
        m = int(rng.integers(1, 5))
        g = rng.normal(size=(3 * m, 6 * int(rng.integers(1, 4))))
        p = Rough(g, rng.normal(size=g.shape[1]), np.zeros(3 * m), rng.uniform(0.0, 1.0, m), rng.uniform(size=m) < 0.2)
        p = p._replace(across=np.where(p.slides & (rng.uniform(size=m) < 0.5), 0.4 * p.mu, 0.0))
        try:
            answer = solve(p, "pyramid", sides)
        except NoSolution:
            assert p.slides.any()  # only contacts that slide already can be without forces
            continue
        solved += 1
        assert answer.residual <= 1e-9
        for i in range(m):
            f, u, limit = answer.r[i], answer.u[i], p.mu[i] * answer.r[i, 0]
            assert abs(min(f[0], u[0])) <= 1e-8 * (1.0 + abs(f[0]))
            if p.slides[i]:
                assert f[1] == pytest.approx(-limit, abs=1e-9)
                most = -p.across[i] * f[0] * abs(u[2])
                assert f[2] * u[2] == pytest.approx(most, abs=1e-6 * (1.0 + abs(f[0])))
            else:
                assert f[1:] @ u[1:] == pytest.approx((limit * u[1:] @ corners).min(), abs=1e-6 * (1.0 + abs(f[0])))
    assert solved >= 225
