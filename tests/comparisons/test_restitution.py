"""Impacts made by hand with a known coefficient are measured back, and doubtful ones are left out."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from comparisons import restitution
from comparisons.restitution import impacts
from mechanics.effects import Gravity, Resting, Restitution, Rotation
from mechanics.rotation import about
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Sphere
from mechanics.trajectory import Trajectory

G = 9.81
FLOOR = Body("floor", HalfSpace())
coefficients = st.one_of(st.just(0.0), st.floats(0.15, 1.0))  # hops in between are too short for these samples


def bounces(t, height, e):
    """Gap and speed of a ball dropped from `height`, bouncing with e, by adding one flight after the other."""
    gap, v = height - 0.5 * G * t**2, -G * t
    at, up = np.sqrt(2.0 * height / G), e * np.sqrt(2.0 * G * height)
    while at < t[-1] and up > 1e-4:
        s = t - at
        gap, v = np.where(s >= 0.0, up * s - 0.5 * G * s**2, gap), np.where(s >= 0.0, up - G * s, v)
        at, up = at + 2.0 * up / G, e * up
    rests = t >= at
    return np.where(rests, 0.0, gap), np.where(rests, 0.0, v)


def dropped(shape, clearance, height, asked, t, e):
    scene = Scene(
        (FLOOR, Body("body", shape, 2.0, (0.0, 0.0, clearance + height))), (Gravity(), Restitution(asked), Resting())
    )
    gap, v = bounces(t, height, e)
    up = np.array([0.0, 0.0, 1.0])
    start = scene.start()
    x, q = (np.repeat(a[None], len(t), axis=0) for a in (start.x, start.q))
    velocity = np.zeros_like(x)
    x[:, 1], velocity[:, 1] = np.outer(clearance + gap, up), np.outer(v, up)
    return scene, Trajectory(t, x, q, velocity, np.zeros_like(x))


@pytest.mark.parametrize(("shape", "clearance"), [(Sphere(0.1), 0.1), (Box((0.2, 0.3, 0.4)), 0.2)])
@given(e=coefficients, height=st.floats(0.5, 3.0), interval=st.floats(2e-3, 1e-2))
def test_bounces_on_a_floor(shape, clearance, e, height, interval):
    """Whatever the sampling, e is measured back to rounding; the tail of ever smaller hops is left out."""
    t = np.arange(0.0, 2.5, interval)
    found = impacts(*dropped(shape, clearance, height, e, t, e))
    assert len(found) == 1
    good = found[0].clear
    first = np.sqrt(2.0 * height / G)
    assert np.abs(found[0].time - first).min() < 1e-9
    assert found[0].e[good] == pytest.approx(np.full(good.sum(), e), abs=1e-9)
    assert good.any()


@given(asked=coefficients, e=coefficients)
def test_a_wrong_coefficient_is_found_with_its_size(case_of, asked, e):
    t = np.arange(0.0, 1.2, 0.01)
    scene, motion = dropped(Sphere(0.1), 0.1, 1.0, asked, t, e)
    found = {q.name: q for q in restitution.measure(case_of(scene, motion, "restitution error"))}
    assert found["restitution error"].value == pytest.approx(abs(e - asked), abs=1e-9)
    assert found["restitution"].value == pytest.approx(e, abs=1e-9)
    assert found["impacts seen"].value >= 1.0


@given(
    st.floats(1e-3, 1e3),
    st.tuples(*[st.floats(-3.0, 3.0)] * 3),
    st.floats(-0.7, 0.7),
    st.floats(0.0, 2.0 * np.pi),
    coefficients,
)
def test_two_smooth_balls_in_free_space(mass_ratio, drift, offset, angle, e):
    """Oblique and head-on, seen from any frame: Newton's law along the line of centres."""
    masses, radii, meet = np.array([1.0, mass_ratio]), (0.3, 0.2), 0.437
    n = np.array([np.sqrt(1.0 - offset**2), offset * np.cos(angle), offset * np.sin(angle)])
    before = np.array([[-1.5, 0.0, 0.0], [0.5, 0.0, 0.0]])  # b is ahead, a runs into it: n points from b to a
    u = n @ (before[0] - before[1])
    impulse = -(1.0 + e) * u / (1.0 / masses).sum()
    after = before + np.outer([1.0, -1.0], impulse * n) / masses[:, None]
    at = np.array([0.25 * n, -0.25 * n])
    t = np.arange(0.0, 1.0, 0.01)
    s = (t - meet)[:, None, None]
    v = np.where(s < 0.0, before, after) + np.array(drift)
    x = at + s * v
    bodies = [Body(name, Sphere(r), m) for name, r, m in zip("ab", radii, masses.tolist(), strict=True)]
    scene = Scene(tuple(bodies), (Restitution(e),))
    motion = Trajectory(t, x, np.tile([1.0, 0.0, 0.0, 0.0], (len(t), 2, 1)), v, np.zeros_like(x))
    (found,) = impacts(scene, motion)
    assert found.time == pytest.approx([meet], abs=1e-9)
    assert found.e == pytest.approx([e], abs=1e-9)
    assert found.clear.all()


def test_a_ball_between_the_faces_of_fixed_boxes():
    """Back and forth between two walls that are fixed boxes, without gravity, losing a tenth each time."""
    walls = [Body(f"wall{s}", Box((1.0, 4.0, 4.0)), position=(1.5 * s, 0.0, 0.0)) for s in (-1, 1)]
    ball = Body("ball", Sphere(0.1), mass=1.0, velocity=(2.0, 0.3, 0.0))
    scene = Scene((*walls, ball), (Restitution(0.9), Rotation()))
    t = np.arange(0.0, 4.0, 0.01)
    x, v, place, speed, clock = np.zeros(len(t)), np.zeros(len(t)), 0.0, 2.0, 0.0
    while clock < 4.0:
        duration = (np.sign(speed) * 0.9 - place) / speed
        rows = t >= clock
        x[rows], v[rows] = place + speed * (t[rows] - clock), speed
        place, clock, speed = np.sign(speed) * 0.9, clock + duration, -0.9 * speed
    paths = np.zeros((len(t), 3, 3))
    paths[:, 0, 0], paths[:, 1, 0] = -1.5, 1.5
    velocities = np.zeros_like(paths)
    paths[:, 2, 0], paths[:, 2, 1], velocities[:, 2, 0], velocities[:, 2, 1] = x, 0.3 * t, v, 0.3
    motion = Trajectory(t, paths, np.tile([1.0, 0.0, 0.0, 0.0], (len(t), 3, 1)), velocities, np.zeros_like(paths))
    found = impacts(scene, motion)
    e = np.concatenate([f.e for f in found])
    assert e == pytest.approx(np.full(4, 0.9), abs=1e-9)


def cradle_motion(gap, interval):
    """Three equal elastic balls: the first hits the second, which hits the third `gap` later."""
    t = np.arange(0.0, 1.0, interval)
    first, second = 0.4037, 0.4037 + gap
    x = np.zeros((len(t), 3, 3))
    v = np.zeros_like(x)
    v[:, 0, 0], v[:, 1, 0], v[:, 2, 0] = t < first, (t >= first) & (t < second), t >= second
    x[:, 0, 0] = np.minimum(t - first, 0.0)
    x[:, 1, 0] = 0.2 + np.clip(t - first, 0.0, gap)
    x[:, 2, 0] = 0.4 + gap + np.maximum(t - second, 0.0)
    scene = Scene(tuple(Body(f"b{i}", Sphere(0.1), 1.0, tuple(x[0, i])) for i in range(3)), (Restitution(1.0),))
    return scene, Trajectory(t, x, np.tile([1.0, 0.0, 0.0, 0.0], (len(t), 3, 1)), v, np.zeros_like(x))


def test_a_cradle_is_measured_where_the_samples_tell_its_impacts_apart():
    apart = impacts(*cradle_motion(gap=0.05, interval=0.01))
    assert np.concatenate([f.e for f in apart]) == pytest.approx([1.0, 1.0], abs=1e-9)
    together = impacts(*cradle_motion(gap=1e-4, interval=0.01))
    assert sum(len(f.e) for f in together) == 0
    assert sum(f.skipped for f in together) >= 1


def test_a_soft_contact_of_many_samples_is_one_impact():
    """Half a period of a stiff spring: in at 2 m/s, out at 2 m/s, in contact for 0.1 s."""
    t = np.arange(0.0, 1.0, 0.005)
    w, touch = np.pi / 0.1, 0.3
    s = t - touch
    v = np.where(s < 0.0, -2.0, np.where(s < 0.1, -2.0 * np.cos(w * s), 2.0))
    z = np.where(s < 0.0, -2.0 * s, np.where(s < 0.1, -2.0 / w * np.sin(w * s), 2.0 * (s - 0.1)))
    scene = Scene((FLOOR, Body("ball", Sphere(0.1), 1.0, (0.0, 0.0, 0.7))), (Restitution(0.5),))
    x = np.zeros((len(t), 2, 3))
    velocity = np.zeros_like(x)
    x[:, 1, 2], velocity[:, 1, 2] = 0.1 + z, v
    motion = Trajectory(t, x, np.tile([1.0, 0.0, 0.0, 0.0], (len(t), 2, 1)), velocity, np.zeros_like(x))
    (found,) = impacts(scene, motion)
    assert found.e == pytest.approx([1.0], abs=0.02)  # the ends of the contact push too little to be told from flight


@pytest.mark.parametrize("interval", [1e-2, 2e-3, 2.5e-4])
def test_a_soft_contact_under_gravity_gives_back_what_came_in(interval):
    """A ball on an undamped spring of 100 rad/s, 31 ms in contact: z'' = -g - w² z below the surface.

    It leaves as fast as it came (energy), however many samples fall into the contact; the end of the push is
    told to a hundredth of the speed, and gravity changes the speed by as much in an interval.
    """
    w, u = 100.0, 4.43
    lowest = np.arctan2(u, G / w) / w  # z' = -(u² + (g/w)²)^½ cos(...) is zero
    stay = 2.0 * lowest
    t = np.arange(0.0, 0.5, interval)
    s = t - 0.2
    inside = -u / w * np.sin(w * s) - G / w**2 * (1.0 - np.cos(w * s))
    rate = -u * np.cos(w * s) - G / w * np.sin(w * s)
    off = s - stay
    z = np.where(s < 0.0, -u * s - 0.5 * G * s**2, np.where(off < 0.0, inside, u * off - 0.5 * G * off**2))
    v = np.where(s < 0.0, -u - G * s, np.where(off < 0.0, rate, u - G * off))
    scene = Scene((FLOOR, Body("ball", Sphere(0.1), 1.0, (0.0, 0.0, 1.0))), (Gravity(), Restitution(1.0)))
    x = np.zeros((len(t), 2, 3))
    velocity = np.zeros_like(x)
    x[:, 1, 2], velocity[:, 1, 2] = 0.1 + z, v
    motion = Trajectory(t, x, np.tile([1.0, 0.0, 0.0, 0.0], (len(t), 2, 1)), velocity, np.zeros_like(x))
    (found,) = impacts(scene, motion)
    assert found.e == pytest.approx([1.0], abs=0.01 + G * interval / u)


@pytest.mark.parametrize("interval", [1e-2, 2e-3])
def test_a_contact_damped_too_much_to_part_is_measured_where_it_is_fastest(interval):
    """Critically damped, z = -u s exp(-w s) for ever: fastest up at s = 2/w, with e = exp(-2), and never out again."""
    w, u = 100.0, 4.43
    t = np.arange(0.0, 0.6, interval)
    s = t - 0.1003
    z = np.where(s < 0.0, -u * s, -u * s * np.exp(-w * np.maximum(s, 0.0)))
    v = np.where(s < 0.0, -u, -u * (1.0 - w * s) * np.exp(-w * np.maximum(s, 0.0)))
    scene = Scene((FLOOR, Body("ball", Sphere(0.1), 1.0, (0.0, 0.0, 1.0))), (Restitution(1.0),))
    x = np.zeros((len(t), 2, 3))
    velocity = np.zeros_like(x)
    x[:, 1, 2], velocity[:, 1, 2] = 0.1 + z, v
    motion = Trajectory(t, x, np.tile([1.0, 0.0, 0.0, 0.0], (len(t), 2, 1)), velocity, np.zeros_like(x))
    (found,) = impacts(scene, motion)
    assert found.e[:1] == pytest.approx([np.exp(-2.0)], abs=0.02)


def test_a_landing_that_stays_has_no_restitution():
    t = np.arange(0.0, 1.0, 0.01)
    (found,) = impacts(*dropped(Sphere(0.1), 0.1, 1.0, 0.8, t, 0.0))
    assert found.e == pytest.approx([0.0], abs=1e-9)
    assert found.error == pytest.approx([0.8], abs=1e-9)


def test_a_box_on_its_corner_is_not_measured():
    """It must turn after the impact, and the point it lands on is another body's business."""
    t = np.arange(0.0, 0.6, 0.01)
    scene, motion = dropped(Box((0.2, 0.3, 0.4)), 0.2, 1.0, 0.5, t, 0.5)
    w = np.array(motion.w)
    w[t > np.sqrt(2.0 / G), 1, 1] = 5.0
    flat = impacts(scene, Trajectory(motion.t, motion.x, motion.q, motion.v, w))
    assert flat[0].e == pytest.approx([0.5], abs=1e-9)
    q = np.array(motion.q)
    q[:, 1] = about((0.0, 1.0, 0.0), 0.2)
    x = np.array(motion.x)
    x[:, 1, 2] += 0.2 * np.cos(0.2) + 0.1 * np.sin(0.2) - 0.2
    tilted = impacts(scene, Trajectory(motion.t, x, q, motion.v, w))
    assert [len(f.e) for f in tilted] == [0]
    assert tilted[0].skipped == 1


def test_no_impact_where_one_was_due_is_an_infinite_error_and_a_doubtful_one_is_unmeasured(case_of):
    t = np.arange(0.0, 0.3, 0.01)
    scene, motion = dropped(Sphere(0.1), 0.1, 1.0, 0.5, t, 0.5)  # still in the air
    found = {q.name: q for q in restitution.measure(case_of(scene, motion, "restitution error"))}
    assert (found["restitution error"].value, found["restitution error"].text) == (np.inf, "no impact seen")
    doubtful = {q.name: q for q in restitution.measure(case_of(*cradle_motion(1e-4, 0.01), "restitution error"))}
    assert np.isnan(doubtful["restitution error"].value)
    assert "not alone" in doubtful["restitution error"].text


def test_a_stepped_engine_is_measured_as_well_as_its_step_allows():
    """Semi-implicit Euler with the impact at a step: e within (1 + e) g h/u of the asked one, better synchronised."""
    h, e = 1e-3, 0.8
    z, v, rows = 1.0, 0.0, []
    for k in range(1500):
        rows.append((k * h, z, v))
        hit = z + h * (v - G * h) < 0.0 and v < 0.0
        v = -e * v if hit else v - G * h
        z += h * v
    t, z, v = np.array(rows[::10]).T
    scene, motion = dropped(Sphere(0.1), 0.1, 1.0, e, t, e)
    x, velocity = np.array(motion.x), np.array(motion.v)
    x[:, 1, 2], velocity[:, 1, 2] = 0.1 + z, v
    (found,) = impacts(scene, Trajectory(t, x, motion.q, velocity, motion.w), lead=0.5 * h, step=h)
    assert len(found.e) >= 2
    assert (found.error[found.clear] <= (1.0 + e) * G * h / found.speed[found.clear]).all()


@given(st.lists(st.sampled_from([-1.0, 0.0, 1.0, math.nan]), min_size=1, max_size=30))
def test_an_overlap_is_left_at_the_nearest_sample_without_one(values):
    before, after = restitution._outside(np.array(values))
    for k in range(len(values)):
        first = last = k
        while first > 0 and values[first] < 0.0:
            first -= 1
        while last < len(values) - 1 and values[last] < 0.0:
            last += 1
        assert (before[k], after[k]) == (first, last)
