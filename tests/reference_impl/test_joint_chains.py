"""Chains and loops of rods and hinges against Lagrange's equations and closed forms."""

import math
from itertools import pairwise

import numpy as np
import pytest
from pendulums import PIVOT, G, allowed, bob, down, energy, swing
from scipy.integrate import solve_ivp

from mechanics.effects import Force, Gravity, Hinge, Rod, Rotation
from mechanics.rotation import about
from mechanics.scene import Body, Scene
from mechanics.shapes import Box
from reference_impl.reactions import joint_forces
from reference_impl.simulate import advance, begin, simulate


def chain(masses, lengths, angles):
    """Bobs on rods, the first hung from the origin, at these angles from straight down."""
    places = np.cumsum([down(angle, length) for angle, length in zip(angles, lengths, strict=True)], axis=0)
    bobs = [bob(f"b{i}", place, mass=m) for i, (place, m) in enumerate(zip(places, masses, strict=True))]
    names = ["pivot", *(b.name for b in bobs)]
    rods = [Rod(a, b) for a, b in pairwise(names)]
    return Scene((PIVOT, *bobs), (Gravity(), *rods))


def lagrange(masses, lengths, angles, times):
    """Places (times, n, 3) of the same chain by Lagrange's equations in its angles, from rest.

    With μ_ij the mass at and below both joints, Σ_j μ_ij l_j (θ''_j cos(θ_i - θ_j) + θ'_j² sin(θ_i - θ_j)) =
    -μ_ii g sin θ_i.
    """
    n, l = len(masses), np.array(lengths)
    below = np.cumsum(np.array(masses)[::-1])[::-1]
    mu = below[np.maximum.outer(np.arange(n), np.arange(n))]

    def rate(_, y):
        theta, omega = y[:n], y[n:]
        d = theta[:, None] - theta[None, :]
        right = -mu.diagonal() * G * np.sin(theta) - (mu * np.sin(d) * l) @ omega**2
        return np.concatenate([omega, np.linalg.solve(mu * np.cos(d) * l, right)])

    start = np.concatenate([angles, np.zeros(n)])
    y = solve_ivp(rate, (0.0, times[-1]), start, "DOP853", times, rtol=1e-13, atol=1e-13).y.T
    steps = np.stack([l * np.sin(y[:, :n]), np.zeros((len(times), n)), -l * np.cos(y[:, :n])], axis=2)
    return np.cumsum(steps, axis=1)


def test_a_double_pendulum_obeys_lagrange():
    masses, lengths, angles = (1.0, 0.6), (1.0, 0.7), (0.7, -0.4)
    times = np.array((0.0, 5.0, 10.0))
    expected = lagrange(masses, lengths, angles, times)
    scene = chain(masses, lengths, angles)
    world = begin(scene)
    before = energy(scene, world.state())
    for time, places in zip(times[1:], expected[1:], strict=True):
        advance(world, time - world.t)
        # not chaotic at this energy: errors grow with time and no faster
        assert world.state().x[1:] == pytest.approx(places, abs=allowed(world, sum(lengths)))
        assert energy(scene, world.state()) == pytest.approx(before, abs=1e-12 * abs(before))


def test_the_double_pendulum_of_point_bobs():
    """Angles 120 and -10 degrees at rest, after 2 s: Lagrange's equations by extrapolation to 20 digits."""
    world = begin(chain((1.0, 1.0), (1.0, 1.0), (math.radians(120.0), math.radians(-10.0))))
    advance(world, 2.0)
    x = world.state().x
    angles = [math.atan2(r[0], -r[2]) for r in (x[1], x[2] - x[1])]
    assert angles == pytest.approx((1.152801671979644, -0.46715839071399935), abs=1e-11)


def test_ten_rods_in_a_chain():
    n = 10
    angles = 0.3 * np.cos(np.arange(n))
    times = np.array((0.0, 0.5, 1.0, 2.0))
    scene = chain((0.5,) * n, (0.3,) * n, angles)
    world = begin(scene)
    before = energy(scene, world.state())
    for time, places in zip(times[1:], lagrange((0.5,) * n, (0.3,) * n, angles, times)[1:], strict=True):
        advance(world, time - world.t)
        assert world.state().x[1:] == pytest.approx(places, abs=allowed(world, n * 0.3))
        assert energy(scene, world.state()) == pytest.approx(before, abs=1e-12 * abs(before))


@pytest.mark.parametrize("masses", [(1.0, 1e6), (1e6, 1.0), (1e3, 1e-3, 1e3), (1.0, 1e-6, 1.0)])
def test_a_million_to_one_along_a_chain(masses):
    n = len(masses)
    # a light bob above a heavy one oscillates a thousand times faster than they swing
    lengths, angles, times = (0.5,) * n, np.full(n, 0.4), np.array((0.0, 0.02, 0.04))
    world = begin(chain(masses, lengths, angles))
    for t, expected in zip(times[1:], lagrange(masses, lengths, angles, times)[1:], strict=True):
        advance(world, t - world.t)
        assert world.state().x[1:] == pytest.approx(expected, abs=1e-13)
    assert world.audit.drift <= 2e-15


def test_a_parallelogram_of_hinges_is_a_pendulum():
    """Four-bar loop in space: 20 rows on 18 motions that leave one free, so three of them repeat the others.

    Cranks of length l and mass c and a coupler of mass m have l² (2 c / 3 + m) θ'' = -g l (c + m) sin θ.
    """
    l, base, c, m, amplitude = 0.6, 1.0, 0.7, 1.3, math.radians(50.0)
    lean = tuple(about((0.0, 1.0, 0.0), -amplitude))
    feet = [np.array((0.0, 0.0, 0.0)), np.array((base, 0.0, 0.0))]
    cranks = [Body(f"c{i}", Box((0.05, 0.05, l)), c, tuple(foot + down(amplitude, 0.5 * l)), lean,
                   inertia=(c * l * l / 12,) * 2 + (1e-3,)) for i, foot in enumerate(feet)]  # fmt: skip
    tips = [foot + down(amplitude, l) for foot in feet]
    coupler = Body("coupler", Box((base, 0.05, 0.05)), m, tuple(0.5 * (tips[0] + tips[1])))
    hinges = [Hinge("pivot", f"c{i}", tuple(foot)) for i, foot in enumerate(feet)]
    hinges += [Hinge(f"c{i}", "coupler", tuple(tip)) for i, tip in enumerate(tips)]
    scene = Scene((PIVOT, *cranks, coupler), (Gravity(), Rotation(), *hinges))
    rate = math.sqrt(G * (c + m) / (l * (2.0 * c / 3.0 + m)))
    world = begin(scene)
    for t in (0.5, 4.0):
        advance(world, t - world.t)
        angle = swing(amplitude, rate, t)
        assert world.state().x[3] == pytest.approx(np.array((0.5 * base, 0, 0)) + down(angle, l), abs=allowed(world, l))
        assert world.state().x[1] == pytest.approx(down(angle, 0.5 * l), abs=allowed(world, l))
    assert world.audit.drift <= 2e-15
    forces = joint_forces(world)
    # the pivots carry the weight and what the masses need: Newton for the whole linkage
    held = np.sum([f.force for f in forces if f.a == 0], axis=0)
    state = world.state()
    spin = (state.v[1, 0] * math.cos(angle) + state.v[1, 2] * math.sin(angle)) / (0.5 * l)
    pull = -(rate**2) * math.sin(angle)
    across, out = np.array((math.cos(angle), 0.0, math.sin(angle))), down(angle)
    moving = (c + m) * l * (pull * across - spin**2 * out)
    assert -held == pytest.approx(moving + np.array((0.0, 0.0, (2.0 * c + m) * G)), abs=1e-10)


def test_without_rotation_hinged_bodies_move_as_one():
    bodies = (bob("a", (0.0, 0.0, 0.0), mass=1.0), bob("b", (1.0, 0.0, 0.0), mass=3.0))
    push = Force("a", (8.0, 0.0, 0.0))
    motion = simulate(Scene(bodies, (Hinge("a", "b"), push)), (0.0, 1.0))
    assert motion.x[1] == pytest.approx(np.array(((1.0, 0.0, 0.0), (2.0, 0.0, 0.0))), abs=1e-14)
