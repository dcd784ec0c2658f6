"""Impacts against closed forms and published sequences, and the laws of momentum and energy over random ones."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mechanics.effects import Friction, Gravity, Resting, Restitution, Rotation
from mechanics.rotation import about, matrix, normalised
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Sphere
from reference_impl.effects.impact import LAWS, Collision, normal_impulse
from reference_impl.errors import MissingEffect, Overlap
from reference_impl.settings import Settings
from reference_impl.simulate import advance, begin, simulate

FLOOR = Body("floor", HalfSpace())
BALL = Body("ball", Sphere(0.1), 1.0, (0.0, 0.0, 1.1))


def collision(j, masses, velocities, e):
    """Contacts with Jacobian j of point masses."""
    root = np.sqrt(np.array(masses, dtype=float))
    g = np.array(j, dtype=float) / root
    return Collision(g, root * velocities, np.zeros(len(g)), lambda u: np.full(len(g), e), 1e-12), root


def after(law, j, masses, velocities, e):
    c, root = collision(j, masses, np.array(velocities, dtype=float), e)
    outcome = LAWS[law](c)
    return (c.motion + c.rows.T @ outcome.impulses) / root, outcome.passes


def line(n):
    return [[-1.0 if k == i else 1.0 if k == i + 1 else 0.0 for k in range(n)] for i in range(n - 1)]


# rows: velocities before, masses, e, after by each law; Herrmann and Seitz (1982), exact rationals
CRADLES = [
    ((1, 0, 0), (1, 1, 1), 1.0, {"propagation": (0, 0, 1), "simultaneous": (-1 / 3, 2 / 3, 2 / 3)}),
    ((1, 0, 0, 0), (1,) * 4, 1.0, {"propagation": (0, 0, 0, 1), "simultaneous": (-0.5, 0.5, 0.5, 0.5)}),
    ((1, 0, 0, 0, 0), (1,) * 5, 1.0, {"propagation": (0, 0, 0, 0, 1), "simultaneous": (-0.6, 0.4, 0.4, 0.4, 0.4)}),
    ((1, 1, 0, 0, 0), (1,) * 5, 1.0, {"propagation": (0, 0, 0, 1, 1), "simultaneous": (-0.2, -0.2, 0.8, 0.8, 0.8)}),
    ((1, 0, 0, 0), (3, 1, 1, 1), 1.0, {"propagation": (0.125, 0.375, 0.75, 1.5), "simultaneous": (0, 1, 1, 1)}),
    ((1, 0, 0), (1, 3, 1), 1.0, {"propagation": (-0.5, 0.25, 0.75), "simultaneous": (-0.6, 0.4, 0.4)}),
    ((1, 0, 0, 0, 0), (1,) * 5, 0.9,
     {"propagation": (11142421 / 256e6, 11615479 / 256e6, 605397 / 12.8e6, 157757 / 3.2e6, 130321 / 160e3)}),
    ((1, 0, 0, 0, 0), (1,) * 5, 0.0, {"propagation": (0.2,) * 5, "simultaneous": (0.2,) * 5}),
]  # fmt: skip


@pytest.mark.parametrize(("before", "masses", "e", "answers"), CRADLES)
def test_balls_in_a_line(before, masses, e, answers):
    for law, expected in {**answers, "sequential": answers["propagation"]}.items():
        found, _ = after(law, line(len(masses)), masses, before, e)
        assert found == pytest.approx(expected, abs=1e-11 if (law, e) == ("sequential", 0.0) else 1e-15), law


def test_ten_pairwise_impacts_of_the_damped_cradle():
    assert after("sequential", line(5), (1,) * 5, (1, 0, 0, 0, 0), 0.9)[1] == 10


@pytest.mark.parametrize("e", [1.0, 0.5])
def test_symmetric_break(e):
    """One ball between two touching ones, normals at ±30 degrees (Ivanov 1995)."""
    n1, n2 = np.array((math.sqrt(3.0) / 2.0, 0.5)), np.array((math.sqrt(3.0) / 2.0, -0.5))
    j = np.zeros((2, 6))
    j[0, :2], j[0, 2:4], j[1, :2], j[1, 4:] = -n1, n1, -n2, n2
    p = (1.0 + e) * math.sqrt(0.75) / 2.5
    together = (1.0 - 2.0 * p * math.sqrt(0.75), 0.0, *(p * n1), *(p * n2))
    pairwise = {
        1.0: (-0.125, -0.21650635094610966, *(0.86602540378443865 * n1), *(0.43301270189221932 * n2)),
        0.5: (0.0859375, -0.12178482240718668, *(0.64951905283832899 * n1), *(0.40594940802395562 * n2)),
    }[e]
    start = (1.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    assert after("propagation", j, (1,) * 6, start, e)[0] == pytest.approx(together, abs=1e-15)
    assert after("simultaneous", j, (1,) * 6, start, e)[0] == pytest.approx(together, abs=1e-15)
    assert after("sequential", j, (1,) * 6, start, e) == (pytest.approx(pairwise, abs=1e-15), 2)


@pytest.mark.parametrize(("e", "pairwise"), [(1.0, (1.9120700183187462, 1.8172196214125789)),
                                             (0.5, (0.75010177081213108, 0.50193364543049054))])  # fmt: skip
def test_flat_landing_in_the_plane(e, pairwise):
    """A box of 1 m x 0.5 m at 2 m/s on its two corners."""
    j = [[1.0, -0.5], [1.0, 0.5]]
    masses = (1.0, 1.25 / 12.0)
    for law in ("propagation", "simultaneous"):
        assert after(law, j, masses, (-2.0, 0.0), e)[0] == pytest.approx((2.0 * e, 0.0), abs=1e-14)
    found, passes = after("sequential", j, masses, (-2.0, 0.0), e)
    assert passes == 3
    assert found == pytest.approx(pairwise, abs=1e-14)


@given(st.floats(-10.0, 10.0), st.floats(0.1, 10.0), st.floats(0.0, 1.0))
def test_bodies_part_at_e_times_the_approach_speed(u, mobility, e):
    assert u + normal_impulse(u, mobility, e) * mobility == pytest.approx(max(u, -e * u), abs=1e-12)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10_000), st.floats(0.0, 1.0), st.sampled_from(sorted(LAWS)))
def test_no_law_makes_energy_or_leaves_an_approach(seed, e, law):
    rng = np.random.default_rng(seed)
    m, k = int(rng.integers(1, 8)), 12
    c = Collision(rng.normal(size=(m, k)), rng.normal(size=k), np.zeros(m), lambda u: np.full(m, e), 1e-12)
    impulses = LAWS[law](c).impulses
    motion = c.motion + c.rows.T @ impulses
    assert (impulses >= 0.0).all()
    assert c.speeds(impulses).min() >= -1e-9
    assert motion @ motion <= c.motion @ c.motion * (1.0 + 1e-12)


def test_bouncing_ball_to_fifteen_digits():
    """h₀ = 1 m, e = 0.8: heights e^2n, times of Goldsmith's series, and the point of accumulation."""
    world = begin(Scene((FLOOR, BALL), (Gravity(), Restitution(0.8), Resting())))
    advance(world, 3.0)
    times = (0.4515236409857309, 1.1739614665629004, 1.7519117270246359, 2.2142719353940244, 2.5841601020895351)
    assert [e.time for e in world.events[:5]] == pytest.approx(times, rel=1e-15)
    impulses = [e.impulse for e in world.events[:5]]
    v = math.sqrt(2.0 * 9.81)
    assert impulses == pytest.approx([1.8 * v * 0.8**k for k in range(5)], rel=4e-15)
    advance(world, 2.0)
    assert world.audit.last_bounce == pytest.approx(4.0637127688715781, rel=1e-14)
    assert world.state().x[1, 2] == pytest.approx(0.1, abs=1e-14)
    assert world.state().v[1].tolist() == [0.0, 0.0, 0.0]
    assert sum(h.force for h in world.forces) == pytest.approx(9.81, rel=1e-15)


def test_apex_heights_of_the_bouncing_ball():
    t1 = math.sqrt(2.0 / 9.81)
    rise = [t1 * 0.8**n for n in range(1, 6)]
    impacts = [t1 + 2.0 * sum(rise[: n - 1]) for n in range(1, 6)]
    motion = simulate(
        Scene((FLOOR, BALL), (Gravity(), Restitution(0.8))),
        (0.0, *(t + r for t, r in zip(impacts, rise, strict=True))),
    )
    assert motion.x[1:, 1, 2] - 0.1 == pytest.approx([0.64**n for n in range(1, 6)], rel=1e-14)


def test_an_elastic_ball_bounces_for_ever():
    world = begin(Scene((FLOOR, BALL), (Gravity(), Restitution(1.0))))
    advance(world, 300.0)
    assert len(world.events) == 332
    assert world.events[-1].impulse == pytest.approx(2.0 * math.sqrt(2.0 * 9.81), rel=1e-13)


def test_accumulation_without_resting_is_an_error_of_the_scene():
    world = begin(Scene((FLOOR, BALL), (Gravity(), Restitution(0.5))))
    with pytest.raises(MissingEffect, match="Resting") as error:
        advance(world, 3.0)
    assert error.value.bodies == ("ball", "floor")
    assert error.value.time == pytest.approx(3.0 * math.sqrt(2.0 / 9.81), abs=1e-6)
    assert world.t == pytest.approx(error.value.time)


def test_a_collision_without_restitution_is_an_error_of_the_scene():
    with pytest.raises(MissingEffect, match="Restitution"):
        simulate(Scene((FLOOR, BALL), (Gravity(), Resting())), (0.0, 1.0))


def test_without_contact_effects_bodies_pass_through_each_other():
    motion = simulate(Scene((FLOOR, BALL), (Gravity(),)), (0.0, 1.0))
    assert motion.x[-1, 1, 2] == pytest.approx(1.1 - 0.5 * 9.81)


@pytest.mark.parametrize(("m1", "v1", "m2", "v2", "first", "second"), [
    (1.0, 2.0, 1e6, -0.5, -1.999996000004, -0.499996000004),
    (1e6, 2.0, 1.0, -0.5, 1.999996000004, 3.499996000004),
])  # fmt: skip
def test_head_on_at_a_million_to_one(m1, v1, m2, v2, first, second):
    scene = Scene(
        (Body("a", Sphere(0.1), m1, (-1.0, 0.0, 0.0), velocity=(v1, 0.0, 0.0)),
         Body("b", Sphere(0.1), m2, (1.0, 0.0, 0.0), velocity=(v2, 0.0, 0.0))),
        (Restitution(0.6),),
    )  # fmt: skip
    world = begin(scene)
    advance(world, 1.0)
    # exact rationals with thirteen digits
    assert world.state().v[:, 0] == pytest.approx((first, second), rel=1e-15 * 10)
    assert world.events[0].impulse == pytest.approx(3.999996000004, rel=1e-14)


def test_oblique_collision_of_smooth_spheres():
    scene = Scene(
        (Body("a", Sphere(0.3), 2.0, (-2.0, 0.25, 0.0), velocity=(3.0, 0.0, 0.0)), Body("b", Sphere(0.2), 1.0)),
        (Restitution(0.9), Friction(0.0), Rotation()),
    )
    motion = simulate(scene, (0.0, 1.0))
    assert motion.v[-1, 0] == pytest.approx((1.575, 0.82272413359521671, 0.0), rel=1e-14)
    assert motion.v[-1, 1] == pytest.approx((2.85, -1.6454482671904334, 0.0), rel=1e-14)
    assert not motion.w.any()


def test_a_box_falls_on_its_corner():
    q = normalised(np.array((0.8, 0.3, 0.4, -0.33)))
    corner = matrix(q) @ np.array([[x, y, z] for x in (-0.3, 0.3) for y in (-0.2, 0.2) for z in (-0.1, 0.1)]).T
    box = Body("box", Box((0.6, 0.4, 0.2)), 3.0, (0.0, 0.0, 0.5 - corner[2].min()), tuple(q), (0.0, 0.0, -2.0))
    world = begin(Scene((FLOOR, box), (Rotation(), Restitution(0.5))))
    advance(world, 0.25 + 1e-9)
    assert world.events[0].impulse == pytest.approx(5.1652950096509667, rel=1e-14)
    state = world.state()
    assert state.v[1] == pytest.approx((0.0, 0.0, -0.2782349967830111), abs=1e-14)
    # a nanosecond after the impact the free spin has turned ω by its rate, 100 rad/s², times 1e-9 s
    assert state.w[1] == pytest.approx((-8.1603981458328431, 3.3270740784350307, 4.0041746509038648), abs=1e-6)


def test_a_leaning_rod_strikes_the_floor():
    """The plate 1 m x 0 x 0: a thin box whose inertia about y is that of the rod, m L²/12, at 30 degrees."""
    lean = tuple(about((0.0, 1.0, 0.0), -math.pi / 6.0))
    thin = 1e-9
    rod = Body("rod", Box((1.0, thin, thin)), 2.0, (0.0, 0.0, 0.25), lean, (0.4, 0.0, -3.0), (0.0, -1.5, 0.0),
               inertia=(1e-3, 2.0 / 12.0, 2.0 / 12.0))  # fmt: skip
    world = begin(Scene((Body("floor", HalfSpace(), position=(0.0, 0.0, -1e-6)), rod), (Rotation(), Restitution(0.6))))
    advance(world, 1e-6)
    # the thickness of 1e-9 m shifts the point of contact by as much
    assert sum(e.impulse for e in world.events) == pytest.approx(3.5933726058715855, rel=1e-5)
    assert world.state().v[1] == pytest.approx((0.4, 0.0, -1.2033136970642073), abs=1e-5)
    assert world.state().w[1, 1] == pytest.approx(7.8358558858436409, abs=1e-4)


def momentum(scene, motion, k):
    p, s = np.zeros(3), np.zeros(3)
    energy = 0.0
    for i, body in enumerate(scene.bodies):
        if body.fixed:
            continue
        r = matrix(motion.q[k, i])
        spin = r @ body.inertia_tensor @ r.T @ motion.w[k, i]
        p += body.mass * motion.v[k, i]
        s += body.mass * np.cross(motion.x[k, i], motion.v[k, i]) + spin
        energy += 0.5 * body.mass * motion.v[k, i] @ motion.v[k, i] + 0.5 * motion.w[k, i] @ spin
    return p, s, energy


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 100_000), st.floats(0.0, 1.0))
def test_random_collisions_conserve_what_they_must(seed, e):
    """Two to four boxes and balls thrown at each other: momentum, angular momentum, and energy that never rises."""
    rng = np.random.default_rng(seed)
    bodies = []
    for i in range(int(rng.integers(2, 5))):
        place = 1.2 * np.array((math.cos(1.6 * i), math.sin(1.6 * i), 0.0)) + 0.1 * rng.normal(size=3)
        shape = Box(tuple(rng.uniform(0.2, 0.6, 3).tolist())) if rng.random() < 0.6 else Sphere(rng.uniform(0.1, 0.3))
        bodies.append(
            Body(f"b{i}", shape, float(10.0 ** rng.uniform(-1, 1)), tuple(place.tolist()),
                 tuple(normalised(rng.normal(size=4)).tolist()), tuple((-2.0 * place).tolist()),
                 tuple(rng.normal(size=3).tolist()))
        )  # fmt: skip
    scene = Scene(tuple(bodies), (Rotation(), Restitution(e), Resting()))
    motion = simulate(scene, np.linspace(0.0, 1.5, 16))
    p0, s0, energy = momentum(scene, motion, 0)
    scale = sum(b.mass for b in bodies) * 3.0
    for k in range(1, 16):
        p, s, now = momentum(scene, motion, k)
        assert np.abs(p - p0).max() < 1e-13 * scale
        assert np.abs(s - s0).max() < 1e-12 * scale
        assert now <= energy + 1e-12 * scale
        energy = now
    if e == 1.0:
        assert energy == pytest.approx(momentum(scene, motion, 0)[2], rel=1e-12)


def test_an_elastic_box_keeps_its_energy_through_many_impacts():
    box = Body("box", Box((0.6, 0.4, 0.2)), 3.0, (0.0, 0.0, 1.2), tuple(normalised(np.array((0.8, 0.3, 0.4, -0.3)))),
               angular_velocity=(3.0, 2.0, 5.0))  # fmt: skip
    scene = Scene((FLOOR, box), (Gravity(), Rotation(), Restitution(1.0)))
    world = begin(scene)
    energy = []
    for _ in range(41):
        m, state = world.motion, world.state()
        energy.append(1.5 * state.v[1] @ state.v[1] + 0.5 * state.w[1] @ m.L[1] + 3.0 * 9.81 * state.x[1, 2])
        advance(world, 0.5)
    assert len(world.events) > 40
    assert np.ptp(energy) <= 1e-12 * energy[0]


@pytest.mark.parametrize("law", sorted(LAWS))
def test_the_touching_cradle_is_decided_by_the_law(law):
    balls = tuple(Body(f"b{i}", Sphere(0.5), 1.0, (i + (0.0 if i else -1.0), 0.0, 0.0),
                       velocity=(0.0 if i else 1.0, 0.0, 0.0)) for i in range(5))  # fmt: skip
    world = begin(Scene(balls, (Restitution(1.0),)), Settings(impact_law=law))
    advance(world, 2.0)
    at_once = law in ("simultaneous", "poisson")
    expected = (-0.6, 0.4, 0.4, 0.4, 0.4) if at_once else (0.0, 0.0, 0.0, 0.0, 1.0)
    assert world.state().v[:, 0] == pytest.approx(expected, abs=1e-14)


def test_a_train_that_collapses_without_gravity():
    """McNamara and Young (1992): at e = 0.05 three points meet infinitely often by t = 5/9 s and go on as one."""
    radius = 1e-6
    starts = (("a", 0.0, 2.0), ("b", 1.0 + 2 * radius, 0.0), ("c", 1.6 + 4 * radius, -1.0))
    balls = tuple(Body(n, Sphere(radius), 1.0, (x, 0.0, 0.0), velocity=(v, 0.0, 0.0)) for n, x, v in starts)
    world = begin(Scene(balls, (Restitution(0.05),)))
    advance(world, 1.0)
    assert world.state().v[:, 0] == pytest.approx((1 / 3,) * 3, abs=1e-9)
    # the last 2e-12 m, in which they count as touching, would take another 1e-8 s
    assert world.events[-1].time == pytest.approx(5.0 / 9.0, abs=1e-7)


@pytest.mark.parametrize(("gap", "speed"), [(0.0, 1.0), (0.0, 0.0), (0.0, -1.0), (1e-16, -1.0), (1e-12, 1e-17)])
def test_starts_in_contact(gap, speed):
    ball = Body("ball", Sphere(0.1), 1.0, (0.0, 0.0, 0.1 + gap), velocity=(0.0, 0.0, speed))
    motion = simulate(Scene((FLOOR, ball), (Gravity(), Restitution(1.0), Resting())), (0.0, 0.05))
    v = abs(speed)
    assert motion.x[-1, 1, 2] - 0.1 == pytest.approx(v * 0.05 - 0.5 * 9.81 * 0.05**2 if v > 1e-3 else 0.0, abs=2e-12)


def test_without_gravity_a_touch_is_nothing():
    ball = Body("ball", Sphere(0.1), 1.0, (0.0, 0.0, 0.1), velocity=(1.0, 0.0, 0.0))
    world = begin(Scene((FLOOR, ball), (Restitution(0.5),)))
    advance(world, 2.0)
    assert not world.events
    assert world.state().x[1] == pytest.approx((2.0, 0.0, 0.1), abs=1e-15)


def test_a_moving_wall_gives_its_velocity():
    """An elastic ball met by a wall at V leaves at 2 V - v."""
    wall = Body("wall", Box((1.0, 1.0, 1.0)), None, (-0.5, 0.0, 0.0), velocity=(2.0, 0.0, 0.0))
    ball = Body("ball", Sphere(0.1), 1.0, (1.0, 0.0, 0.0), velocity=(-3.0, 0.0, 0.0))
    world = begin(Scene((wall, ball), (Restitution(1.0),)))
    advance(world, 0.5)
    assert world.state().v[1] == pytest.approx((7.0, 0.0, 0.0), abs=1e-14)
    assert world.events[0].time == pytest.approx(0.9 / 5.0, rel=1e-13)


def test_an_overlapping_start_is_reported_with_pair_and_depth():
    ball = Body("ball", Sphere(0.1), 1.0, (0.0, 0.0, 0.07))
    with pytest.raises(Overlap, match=r"'ball' and 'floor' overlap by 0\.03 m"):
        begin(Scene((FLOOR, ball), (Restitution(1.0),)))


def test_the_same_run_gives_the_same_bits():
    q = tuple(normalised(np.array((0.8, 0.3, 0.4, -0.3))))
    scene = Scene(
        (FLOOR, Body("box", Box((0.6, 0.4, 0.2)), 3.0, (0.0, 0.0, 1.2), q),
         Body("ball", Sphere(0.2), 1.0, (0.1, 0.0, 2.0))),
        (Gravity(), Rotation(), Restitution(0.4), Resting()),
    )  # fmt: skip
    times = np.linspace(0.0, 1.5, 7)
    assert simulate(scene, times).digest() == simulate(scene, times).digest()
