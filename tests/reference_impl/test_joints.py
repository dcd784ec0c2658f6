"""Rods and hinges against closed forms, Lagrange's equations and the laws of momentum and energy."""

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ellipj, ellipk

from mechanics.effects import Force, Gravity, Hinge, Resting, Restitution, Rod, Rotation
from mechanics.rotation import about, exponential, matrix, normalised, product, rotate, unrotate
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Sphere
from reference_impl.collide.detect import Contacts
from reference_impl.effects.joint import AXIS, all_of, hinge, rod
from reference_impl.effects.resting import Island, Pose
from reference_impl.errors import Unsupported
from reference_impl.links import Links
from reference_impl.parts import Parts
from reference_impl.reactions import joint_forces
from reference_impl.simulate import advance, begin, simulate
from reference_impl.state import bodies_of
from reference_impl.world import HELD, STILL

G = 9.81
PIVOT = Body("pivot", Sphere(0.01))
UP = (0.0, 0.0, 1.0)
NOTHING = Contacts(np.zeros((0, 5), dtype=np.int64), np.zeros((0, 14)), np.zeros(0, dtype=np.int64))


def bob(name, place, velocity=(0.0, 0.0, 0.0), mass=1.0, radius=0.05):
    return Body(name, Sphere(radius), mass, tuple(float(c) for c in place), velocity=tuple(float(c) for c in velocity))


def down(angle, length=1.0):
    """Place at this angle from straight down, towards x."""
    return np.array((length * math.sin(angle), 0.0, -length * math.cos(angle)))


def swing(amplitude, rate, t):
    """Angle of a pendulum of small-amplitude frequency `rate`, released from rest at `amplitude`: 2 asin(k cd(ω t))."""
    k = math.sin(0.5 * amplitude)
    sn = ellipj(ellipk(k * k) - rate * t, k * k)[0]
    return 2.0 * math.asin(k * sn)


def energy(scene, state):
    """Kinetic energy and that in gravity [J]."""
    total = 0.0
    for i in scene.moving:
        body = scene.bodies[i]
        total += 0.5 * body.mass * state.v[i] @ state.v[i] + body.mass * G * state.x[i, 2]
        w = unrotate(state.q[i], state.w[i])
        total += 0.5 * w @ body.inertia_tensor @ w
    return total


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


@pytest.mark.parametrize("degrees", [5.0, 120.0, 179.0])
def test_a_pendulum_swings_by_elliptic_functions(degrees):
    amplitude = math.radians(degrees)
    scene = Scene((PIVOT, bob("bob", down(amplitude))), (Gravity(), Rod("pivot", "bob")))
    world = begin(scene)
    for t in (1.0, 2.5, 5.0):
        advance(world, t - world.t)
        # near the top the period changes with the energy as 1 / (1 + cos): 1e-12 of energy is that much of angle
        allowed = 1e-12 * (1.0 + 1.0 / (1.0 + math.cos(amplitude)))
        assert world.state().x[1] == pytest.approx(down(swing(amplitude, math.sqrt(G), t)), abs=allowed)
    assert world.audit.drift <= 1e-15


def test_the_published_pendulum():
    """From horizontal, after 10 s (IFToMM library of benchmarks, problem A01)."""
    motion = simulate(Scene((PIVOT, bob("bob", (1.0, 0.0, 0.0))), (Gravity(), Rod("pivot", "bob"))), (0.0, 10.0))
    assert math.atan2(motion.x[1, 1, 0], -motion.x[1, 1, 2]) == pytest.approx(0.27868067356998295, abs=1e-12)


def test_a_rod_pulls_as_newton_says():
    """m (v² / l + g cos θ) along the rod, at three times the angle of release where it hangs down: 4 m g."""
    amplitude = math.radians(120.0)
    world = begin(Scene((PIVOT, bob("bob", down(amplitude), mass=2.0)), (Gravity(), Rod("bob", "pivot"))))
    for _ in range(5):
        advance(world, 0.3)
        state = world.state()
        angle = math.atan2(state.x[1, 0], -state.x[1, 2])
        (f,) = joint_forces(world)
        expected = 2.0 * (state.v[1] @ state.v[1] + G * math.cos(angle))
        assert np.array(f.force) == pytest.approx(-expected * state.x[1], rel=1e-12, abs=1e-11)
        assert (f.a, f.b, f.joint) == (1, 0, 0)


def test_a_conical_pendulum_goes_round():
    rate = math.sqrt(G / math.cos(math.radians(40.0)))
    start = down(math.radians(40.0))
    scene = Scene((PIVOT, bob("bob", start, (0.0, rate * start[0], 0.0))), (Gravity(), Rod("pivot", "bob")))
    world = begin(scene)
    for t in (1.0, 10.0):
        advance(world, t - world.t)
        turned = rotate(about(UP, rate * t), start)
        assert world.state().x[1] == pytest.approx(turned, abs=1e-12)
    (f,) = joint_forces(world)
    assert np.linalg.norm(f.force) == pytest.approx(G / math.cos(math.radians(40.0)), rel=1e-13)


def test_a_body_on_a_hinge_swings_by_its_inertia_about_the_axis():
    """A tumbled box with an inertia that is not diagonal: I = a·I a + m d² about the axis a, at distance d."""
    q = normalised(np.array((0.7, 0.4, -0.3, 0.5)))
    inertia = ((0.9, 0.1, -0.05), (0.1, 0.7, 0.08), (-0.05, 0.08, 0.5))
    amplitude, distance, along = math.radians(70.0), 0.8, 0.35
    place = down(amplitude, distance)
    body = Body(
        "body", Box((0.5, 0.4, 0.3)), 3.0, tuple(place + np.array((0.0, along, 0.0))), tuple(q), inertia=inertia
    )
    scene = Scene((PIVOT, body), (Gravity(), Rotation(), Hinge("pivot", "body", axis=(0.0, 1.0, 0.0))))
    axis = unrotate(q, np.array((0.0, 1.0, 0.0)))
    whole = axis @ np.array(inertia) @ axis + 3.0 * distance**2
    rate = math.sqrt(3.0 * G * distance / whole)
    world = begin(scene)
    before = energy(scene, world.state())
    for t in (1.0, 5.0):
        advance(world, t - world.t)
        state = world.state()
        angle = swing(amplitude, rate, t)
        assert state.x[1] == pytest.approx(down(angle, distance) + np.array((0.0, along, 0.0)), abs=1e-12)
        turned = rotate(about((0.0, 1.0, 0.0), amplitude - angle), rotate(q, np.eye(3)))
        assert rotate(state.q[1], np.eye(3)) == pytest.approx(turned, abs=1e-12)
        assert energy(scene, state) == pytest.approx(before, abs=1e-12 * 3.0 * G)
    assert world.audit.drift <= 1e-15


def test_a_rod_hinged_at_its_end_presses_its_pivot():
    """Force at the pivot of a uniform rod: m g (5 cos θ - 3 cos θ0) / 2 along it and m g sin θ / 4 across (Routh)."""
    amplitude = math.radians(120.0)
    body = Body("rod", Box((0.02, 0.02, 1.0)), 1.0, tuple(down(amplitude, 0.5)),
                tuple(about((0.0, 1.0, 0.0), -amplitude)), inertia=(1 / 12, 1 / 12, 1e-4))  # fmt: skip
    world = begin(Scene((PIVOT, body), (Gravity(), Rotation(), Hinge("rod", "pivot"))))
    for _ in range(4):
        advance(world, 0.4)
        place = world.state().x[1]
        angle = math.atan2(place[0], -place[2])
        (f,) = joint_forces(world)
        out, across = down(angle), np.array((math.cos(angle), 0.0, math.sin(angle)))
        assert -np.array(f.force) @ out == pytest.approx(
            G * (2.5 * math.cos(angle) - 1.5 * math.cos(amplitude)), abs=1e-11
        )
        assert np.array(f.force) @ across == pytest.approx(0.25 * G * math.sin(angle), abs=1e-11)
        assert np.abs(f.torque).max() <= 1e-12


def test_a_double_pendulum_obeys_lagrange():
    masses, lengths, angles = (1.0, 0.6), (1.0, 0.7), (0.7, -0.4)
    times = np.array((0.0, 5.0, 10.0))
    expected = lagrange(masses, lengths, angles, times)
    scene = chain(masses, lengths, angles)
    motion = simulate(scene, times)
    # not chaotic at this energy; both integrations have local errors near 1e-13 that add up over 10 s
    assert motion.x[:, 1:] == pytest.approx(expected, abs=2e-11)
    energies = [energy(scene, motion.at(k)) for k in range(len(times))]
    assert np.ptp(energies) <= 1e-12 * abs(energies[0])


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
    motion = simulate(scene, times)
    assert motion.x[:, 1:] == pytest.approx(lagrange((0.5,) * n, (0.3,) * n, angles, times), abs=1e-10)
    energies = [energy(scene, motion.at(k)) for k in range(len(times))]
    assert np.ptp(energies) <= 1e-12 * abs(energies[0])


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


def test_a_thrown_dumbbell():
    """Its centre flies on a parabola, its line turns evenly, and the rod pulls with μ ω² l."""
    centre, speed, spin = np.array((0.0, 0.0, 5.0)), np.array((2.0, 0.3, 4.0)), 4.0
    masses, length = (1.0, 2.0), 1.5
    arms = np.array((-2.0 / 3.0, 1.0 / 3.0)) * length
    bodies = [bob(f"b{i}", centre + np.array((arm, 0.0, 0.0)), speed + np.array((0.0, spin * arm, 0.0)), m)
              for i, (arm, m) in enumerate(zip(arms, masses, strict=True))]  # fmt: skip
    world = begin(Scene(tuple(bodies), (Gravity(), Rod("b0", "b1"))))
    for t in (0.7, 7.3):
        advance(world, t - world.t)
        state = world.state()
        line = np.array((math.cos(spin * t), math.sin(spin * t), 0.0))
        for x, arm in zip(state.x, arms, strict=True):
            expected = centre + speed * t - np.array((0.0, 0.0, 0.5 * G * t * t)) + arm * line
            assert x == pytest.approx(expected, abs=1e-12 * max(1.0, 0.5 * G * t * t))
    (f,) = joint_forces(world)
    assert np.linalg.norm(f.force) == pytest.approx(2.0 / 3.0 * spin**2 * length, rel=1e-12)


def test_two_bodies_on_a_hinge_keep_their_momenta_and_energy():
    rng = np.random.default_rng(3)
    w = np.array((0.5, -1.0, 2.0))
    point, axis = np.array((0.1, 0.2, -0.1)), np.array((0.3, 0.5, 0.8))
    places = ((-0.4, 0.1, 0.0), (0.5, 0.0, 0.2))
    q = [tuple(normalised(rng.normal(size=4))) for _ in places]
    v = [tuple(np.cross(w, np.array(x) - point)) for x in places]
    extra = axis / np.linalg.norm(axis) * 3.0
    first = Body("a", Box((0.6, 0.3, 0.2)), 2.0, places[0], q[0], v[0], tuple(w))
    second = Body("b", Box((0.5, 0.2, 0.4)), 1.0, places[1], q[1],
                  tuple(np.cross(w + extra, np.array(places[1]) - point)), tuple(w + extra))  # fmt: skip
    scene = Scene((first, second), (Rotation(), Hinge("a", "b", tuple(point), tuple(axis))))
    world = begin(scene)

    def totals():
        s, m = world.state(), world.motion
        masses = np.array((2.0, 1.0))
        spin = (np.cross(s.x, masses[:, None] * s.v) + m.L).sum(axis=0)
        return np.concatenate([(masses[:, None] * s.v).sum(axis=0), spin, [energy(scene, s)]])

    def gravityless(values):
        values[-1] -= G * (2.0 * world.state().x[0, 2] + world.state().x[1, 2])
        return values

    before = gravityless(totals())
    for _ in range(4):
        advance(world, 1.0)
        assert gravityless(totals()) == pytest.approx(before, abs=1e-11)
        s = world.state()
        ends = [rotate(s.q[i], unrotate(np.array(q[i]), point - np.array(places[i]))) + s.x[i] for i in (0, 1)]
        lines = [rotate(s.q[i], unrotate(np.array(q[i]), axis)) for i in (0, 1)]
        assert ends[0] == pytest.approx(ends[1], abs=1e-15)
        assert lines[0] == pytest.approx(lines[1], abs=2e-15)
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
        assert world.state().x[3] == pytest.approx(np.array((0.5 * base, 0, 0)) + down(angle, l), abs=5e-12)
        assert world.state().x[1] == pytest.approx(down(angle, 0.5 * l), abs=5e-12)
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


def test_a_steady_top_on_a_rod_of_no_length():
    """Slow precession of a heavy top, I1 Ω² cos θ - I3 w3 Ω + m g l = 0 (Goldstein, section 5.7).

    A rod between coinciding anchors keeps them together: a ball joint.
    """
    m, l, about_pivot, i3, tilt = 0.5, 0.04, 1.2e-3, 2.5e-4, math.radians(30.0)
    slow = 6.3491511714623878
    lean = about((0.0, 1.0, 0.0), tilt)
    spin = np.array((72.250736896522922, 0.0, 131.49109836053139))
    centre = rotate(lean, np.array((0.0, 0.0, l)))
    i1 = about_pivot - m * l * l
    top = Body("top", Sphere(0.03), m, tuple(centre), tuple(lean), tuple(np.cross(spin, centre)), tuple(spin),
               inertia=(i1, i1, i3))  # fmt: skip
    world = begin(Scene((PIVOT, top), (Gravity(), Rotation(), Rod("pivot", "top", anchor_b=(0.0, 0.0, -l)))))
    for t in (0.1, 1.0):
        advance(world, t - world.t)
        axis = matrix(world.state().q[1])[:, 2]
        expected = rotate(about(UP, slow * t), centre / l)
        # after 25 turns; the nutation that rounding of the start excites is not damped
        assert axis == pytest.approx(expected, abs=1e-11)
    assert world.state().x[1] == pytest.approx(l * axis, abs=1e-16)


def test_a_struck_rod_and_its_centre_of_percussion():
    """A ball hits a hanging rod at x below its hinge; at 2 l / 3 the hinge feels nothing (E11 of any book)."""
    length, m, mass, speed = 1.2, 3.0, 0.2, 10.0
    for x, e in ((0.9, 0.5), (0.9, 0.0), (0.8, 0.5)):
        body = Body("rod", Box((0.02, 0.02, length)), m, (0.0, 0.0, -0.5 * length),
                    inertia=(m * length**2 / 12, m * length**2 / 12, 1e-3))  # fmt: skip
        ball = bob("ball", (-0.11, 0.0, -x), (speed, 0.0, 0.0), mass)
        scene = Scene((PIVOT, body, ball), (Rotation(), Restitution(e), Resting(), Hinge("rod", "pivot")))
        world = begin(scene)
        advance(world, 0.005 + 1e-11)
        i = m * length**2 / 3.0
        spin = (1.0 + e) * mass * speed * x / (i + mass * x * x)
        assert len(world.events) == 1
        assert world.events[0].time == pytest.approx(0.005, rel=1e-13)
        assert world.events[0].impulse == pytest.approx(i * spin / x, rel=1e-13)
        state = world.state()
        assert -state.w[1, 1] == pytest.approx(spin, rel=1e-12)
        assert state.v[2, 0] == pytest.approx(speed - i * spin / (mass * x), rel=1e-12)
        assert np.linalg.norm(state.v[1] - np.cross(state.w[1], state.x[1])) <= 1e-13


def test_a_pendulum_bounces_off_a_wall():
    """From rest at 60 degrees it meets a wall where it hangs, and again at e times the speed."""
    amplitude, e = math.radians(60.0), 0.7
    wall = Body("wall", HalfSpace((1.0, 0.0, 0.0)), position=(-0.05, 0.0, 0.0))
    scene = Scene((PIVOT, wall, bob("bob", down(amplitude))), (Gravity(), Restitution(e), Rod("pivot", "bob")))
    world = begin(scene)

    def quarter(angle):
        return float(ellipk(math.sin(0.5 * angle) ** 2)) / math.sqrt(G)

    advance(world, 3.0)
    time = quarter(amplitude)
    speed = 2.0 * math.sqrt(G) * math.sin(0.5 * amplitude)
    for event in world.events[:3]:
        assert event.time == pytest.approx(time, abs=1e-11)
        assert event.impulse == pytest.approx((1.0 + e) * speed, rel=1e-11)
        speed *= e
        time += 2.0 * quarter(2.0 * math.asin(speed / (2.0 * math.sqrt(G))))
    assert world.audit.energy_rise <= 1e-14


def test_a_door_meets_a_stop():
    """A door on a vertical hinge turns evenly and strikes a fixed ball: Newton's law at its edge, e ω back."""
    e, spin = 0.6, 2.0
    door = Body("door", Box((0.9, 0.04, 2.0)), 20.0, (0.45, 0.0, 1.0), velocity=(0.0, 0.45 * spin, 0.0),
                angular_velocity=(0.0, 0.0, spin))  # fmt: skip
    stop = Body("stop", Sphere(0.05), None, (0.0, 0.8, 1.0))
    scene = Scene((PIVOT, door, stop), (Gravity(), Rotation(), Restitution(e), Hinge("pivot", "door", axis=UP)))
    world = begin(scene)
    advance(world, 1.0)
    # the face, 0.02 m off the hinge's plane, is 0.05 m from the ball's centre when 0.8 cos θ = 0.07
    time = math.acos(0.07 / 0.8) / spin
    # ten steps of 1e-13 each in the quaternion, at 0.8 m: 1e-12 m or so
    assert [event.time for event in world.events] == pytest.approx([time], abs=1e-11)
    assert world.state().w[1] == pytest.approx((0.0, 0.0, -e * spin), abs=1e-11)
    turned = rotate(about(UP, spin * time - e * spin * (1.0 - time)), np.array((0.45, 0.0, 0.0)))
    assert world.state().x[1] == pytest.approx(turned + np.array((0.0, 0.0, 1.0)), abs=1e-11)
    (f,) = joint_forces(world)
    assert f.force[2] == pytest.approx(-20.0 * G, rel=1e-13)  # on the pivot


def test_a_hinged_bar_lies_on_its_other_end():
    """A bar on a hinge and on a ball under its far end: each carries half, and all of it rests."""
    bar = Body("bar", Box((1.0, 0.1, 0.1)), 2.0, (0.5, 0.0, 0.0))
    prop = Body("prop", Sphere(0.2), None, (1.0, 0.0, -0.25))
    scene = Scene((PIVOT, bar, prop), (Gravity(), Rotation(), Resting(), Hinge("bar", "pivot")))
    world = begin(scene)
    advance(world, 1.0)
    assert [h.force for h in world.forces] == [pytest.approx(G, rel=1e-13)]
    (f,) = joint_forces(world)
    assert np.array(f.force) == pytest.approx((0.0, 0.0, G), abs=1e-13)
    assert world.mode[1] == STILL
    assert (world.state().x[1] == (0.5, 0.0, 0.0)).all()


def test_what_hangs_at_rest_is_at_rest_until_it_is_hit():
    bobs = (bob("upper", (0.0, 0.0, -1.0)), bob("lower", (0.0, 0.0, -2.0)))
    ball = bob("ball", (-2.0, 0.0, -2.0), (2.0, 0.0, 4.905 * 0.95))
    effects = (Gravity(), Restitution(1.0), Rod("pivot", "upper"), Rod("upper", "lower"))
    world = begin(Scene((PIVOT, *bobs, ball), effects))
    advance(world, 0.5)
    assert (world.mode[1:3] == STILL).all()
    assert (world.state().x[1:3] == ((0.0, 0.0, -1.0), (0.0, 0.0, -2.0))).all()
    steps = world.audit.steps
    assert steps == 0
    advance(world, 0.46)
    assert world.events
    assert (world.mode[1:3] == HELD).all()
    assert world.state().v[2, 0] > 1.0
    assert world.audit.energy_rise <= 1e-14


def test_a_pivot_that_accelerates_tilts_gravity():
    """In a lift that accelerates upwards by a, a pendulum swings as under g + a."""
    amplitude, pull = math.radians(80.0), 3.0
    lift = Body("pivot", Sphere(0.01), velocity=(0.2, 0.0, -0.5), acceleration=(0.0, 0.0, pull))
    hung = bob("bob", down(amplitude), (0.2, 0.0, -0.5))
    world = begin(Scene((lift, hung), (Gravity(), Rod("pivot", "bob"))))
    advance(world, 3.0)
    expected = down(swing(amplitude, math.sqrt(G + pull), 3.0)) + np.array((0.6, 0.0, -1.5 + 0.5 * pull * 9.0))
    assert world.state().x[1] == pytest.approx(expected, abs=1e-11)


def test_without_rotation_hinged_bodies_move_as_one():
    bodies = (bob("a", (0.0, 0.0, 0.0), mass=1.0), bob("b", (1.0, 0.0, 0.0), mass=3.0))
    push = Force("a", (8.0, 0.0, 0.0))
    motion = simulate(Scene(bodies, (Hinge("a", "b"), push)), (0.0, 1.0))
    assert motion.x[1] == pytest.approx(np.array(((1.0, 0.0, 0.0), (2.0, 0.0, 0.0))), abs=1e-14)


def test_a_joint_keeps_what_flies_beside_it_apart():
    """A ball that has nothing to do with a pendulum flies on the same bits with and without it."""
    ball = bob("ball", (5.0, 0.0, 0.0), (1.0, 0.0, 3.0))
    floor = Body("floor", HalfSpace(), position=(0.0, 0.0, -3.0))
    effects = (Gravity(), Restitution(0.8))
    alone = simulate(Scene((floor, ball), effects), (0.0, 0.5, 2.0))
    scene = Scene((floor, ball, PIVOT, bob("bob", (1.0, 0.0, 0.0))), (*effects, Rod("pivot", "bob")))
    assert simulate(scene, (0.0, 0.5, 2.0)).x[:, 1] == pytest.approx(alone.x[:, 1], abs=1e-13)


@pytest.mark.parametrize("seconds", [4.0, pytest.param(100.0, marks=pytest.mark.long)])
def test_energy_and_length_last(seconds):
    """Energy within 1e-12 and the rod within 1e-15 of what they were, after many wide swings."""
    scene = Scene((PIVOT, bob("bob", down(2.0))), (Gravity(), Rod("pivot", "bob")))
    world = begin(scene)
    before = energy(scene, world.state())
    advance(world, seconds)
    assert energy(scene, world.state()) == pytest.approx(before, abs=1e-12 * abs(before))
    assert np.linalg.norm(world.state().x[1]) == pytest.approx(np.linalg.norm(down(2.0)), rel=1e-15)


@pytest.mark.parametrize(("effects", "match"), [
    ((Rod("a", "b"),), r"Rod between 'a' and 'b': its ends part at 1 m/s"),
    ((Rotation(), Hinge("a", "b")), r"Hinge between 'a' and 'b': its ends part at 1 m/s"),
    ((Rod("f", "g"),), r"Rod between 'f' and 'g': its ends part at 2 m/s"),
    ((Hinge("f", "h"),), r"Hinge between 'f' and 'h': both are fixed and move against each other"),
])  # fmt: skip
def test_joints_that_cannot_hold_are_refused(effects, match):
    bodies = (
        bob("a", (0.0, 0.0, 0.0), (1.0, 0.0, 0.0)), bob("b", (2.0, 0.0, 0.0)), Body("f", Sphere(0.1)),
        Body("g", Sphere(0.1), position=(1.0, 0.0, 0.0), velocity=(2.0, 0.0, 0.0)),
        Body("h", Sphere(0.1), position=(0.0, 3.0, 0.0), acceleration=(0.0, 1.0, 0.0)),
    )  # fmt: skip
    with pytest.raises(Unsupported, match=match):
        begin(Scene(bodies, effects))


def test_a_joint_between_fixed_bodies_holds_nothing():
    world = begin(Scene((PIVOT, Body("f", Sphere(0.1), position=(1.0, 0.0, 0.0))), (Rod("pivot", "f"),)))
    assert world.links is None
    assert not joint_forces(world)


def test_rows_are_the_derivatives_of_their_gaps():
    """Along random motions gap' is the slope of the gap and gap'' = J·accelerations + bias that of gap'."""
    rng = np.random.default_rng(1)
    for _ in range(20):
        bodies = tuple(
            Body(f"b{i}", Box(tuple(rng.uniform(0.2, 1.0, 3))), float(rng.uniform(0.5, 2.0)),
                 tuple(rng.normal(size=3)), tuple(normalised(rng.normal(size=4))))
            for i in range(2)
        )  # fmt: skip
        effects = (Rod("b0", "b1", tuple(rng.normal(size=3)), tuple(rng.normal(size=3))),
                   Hinge("b1", "b0", tuple(rng.normal(size=3)), tuple(rng.normal(size=3))))  # fmt: skip
        scene = Scene(bodies, (Rotation(), *effects))
        b = bodies_of(scene)
        joints = all_of(rod(scene, effects[0]).joints + hinge(scene, effects[1]).joints)
        island = Island(np.array((0, 1)), NOTHING, np.array((0, 1)),
                        Links.of(Parts(joints=(joints,)), np.ones(2, dtype=bool)))  # fmt: skip
        x, v, a, w, alpha = rng.normal(size=(5, 2, 3))
        q0 = normalised(rng.normal(size=(2, 4)))

        def at(t, x=x, v=v, a=a, w=w, alpha=alpha, q0=q0, b=b):
            # turns w t + ½ alpha t² about the world's axes, to second order in t
            q = product(exponential(w * t + 0.5 * alpha * t * t), q0)
            spin = w + alpha * t
            rotation = np.array([matrix(one) for one in q])
            momentum = np.array([r @ i @ r.T @ s for r, i, s in zip(rotation, b.inertia, spin, strict=True)])
            return Pose(x + v * t + 0.5 * a * t * t, rotation, v + a * t, spin, momentum)

        h = 1e-5
        low, middle, high = (island.rows(at(t), b) for t in (-h, 0.0, h))
        assert (high.gap - low.gap) / (2.0 * h) == pytest.approx(middle.rate, abs=1e-8)
        y = np.concatenate([np.concatenate([a[i] / math.sqrt(b.inverse_mass[i]),
                                            np.linalg.solve(b.root[i], at(0.0).rotation[i].T @ alpha[i])])
                            for i in (0, 1)])  # fmt: skip
        second = middle.j @ y - middle.target
        assert (high.rate - low.rate) / (2.0 * h) == pytest.approx(second, abs=1e-7)
        assert (joints.kinds[:, 0] == AXIS).sum() == 2
