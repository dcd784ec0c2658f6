"""Stability: every defect that is put into a sound motion is named, and nothing else is."""

import numpy as np
import pytest

from adapters import registry
from adapters.run import Failure, Run, run, sample_times
from comparisons.judge import judge
from comparisons.measurement import Case
from comparisons.stability import BREAKS, STABLE, breaks, inner_radius, words
from mechanics.effects import Effect, Force, Friction, Gravity, Hinge, Resting, Restitution, Rod, Rotation, Tether
from mechanics.rotation import about
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, Capsule, Cylinder, HalfSpace, Mesh, Sphere
from mechanics.trajectory import Trajectory
from scenarios.catalogue import families, find
from scenarios.scenario import Check

G = 9.81
T = np.linspace(0.0, 1.0, 101)
FLOOR = Body("floor", HalfSpace())
BALL = Body("ball", Sphere(0.1), mass=2.0, position=(0.0, 0.0, 20.0))
STAND = Check("drift", 0.01, "it must stand, so it says")


def words_of(case):
    return [b.word for b in breaks(case)]


def falling(t=T):
    z = 20.0 - 0.5 * G * t**2
    return np.stack([0 * t, 0 * t, z], 1), np.stack([0 * t, 0 * t, -G * t], 1)


@pytest.fixture
def fall(case_of, moved):
    """Case of a ball that falls, its motion changed by a function of (x, v)."""

    def build(change=lambda x, v: None, **told):
        scene = Scene((FLOOR, BALL), (Gravity(), Restitution(1.0)))
        x, v = falling()
        change(x, v)
        return case_of(scene, moved(scene, T, x_ball=x, v_ball=v), **told)

    return build


def test_a_sound_motion_is_stable(fall, values):
    from comparisons import stability

    assert words_of(fall()) == []
    quantity = values(stability, fall())["stability"]
    assert (quantity.value, quantity.text) == (0.0, STABLE)
    assert words(quantity.text) == ()


def test_a_motion_that_begins_anew_is_named(fall, values):
    from comparisons import stability

    def again(x, v):
        x[60:], v[60:] = x[:41].copy(), v[:41].copy()

    case = fall(again)
    assert words_of(case) == ["reset"]
    quantity = values(stability, case)["stability"]
    assert (quantity.value, quantity.time) == (1.0, pytest.approx(0.6))
    assert words(quantity.text) == ("reset",)


def test_a_reset_within_an_interval_is_named_too(fall):
    def again(x, v):
        later, fast = falling(T[:41] + 0.0037)
        x[60:], v[60:] = later, fast

    assert words_of(fall(again)) == ["reset"]


def test_coming_back_is_no_reset(case_of, moved):
    """An elastic ball is where it began, as fast as it was, after every period."""
    scenario = find("bouncing-ball[e=1]")[0]
    t = sample_times(scenario.duration, scenario.sampling)
    motion = scenario.truth(t)
    assert words_of(Case(scenario, Run("key", "1", {}, motion), motion)) == []


@pytest.mark.parametrize("limit", [3.0, 7.0])
def test_a_speed_that_stops_growing_is_named(fall, limit):
    def cap(x, v):
        v[:, 2] = np.maximum(v[:, 2], -limit)
        late = limit / G < T
        x[late, 2] = 20.0 - 0.5 * limit**2 / G - limit * (T[late] - limit / G)

    assert words_of(fall(cap)) == ["speed cap"]


def test_a_spin_that_is_cut_at_the_start_is_named(case_of, moved):
    ball = Body("ball", Sphere(0.1), mass=2.0, angular_velocity=(0.0, 1000.0, 3.0))
    scene = Scene((ball,), (Rotation(),))
    t = T[:20]
    w = np.repeat([[0.0, 1000.0, 3.0]], len(t), axis=0)
    sound = case_of(scene, moved(scene, t, w_ball=w))
    w[1:, 1] = 100.0
    cut = case_of(scene, moved(scene, t, w_ball=w))
    assert words_of(sound) == []
    assert words_of(cut) == ["speed cap"]
    assert "from 1000 to 100.045 rad/s" in breaks(cut)[0].text
    w[1:, 1] = 1000.0 / (1.0 + 400.0 * t[1:])  # quadratic drag loses most of it in the first interval, too
    assert words_of(case_of(scene, moved(scene, t, w_ball=w))) == []


def test_a_ball_that_is_slower_after_a_wall_has_no_speed_cap(case_of, moved):
    """e = 1/2 leaves a constant speed below that at the start, without anything but the wall."""
    wall = Body("wall", Box((0.2, 2.0, 2.0)), position=(1.0, 0.0, 0.0))
    ball = Body("ball", Sphere(0.1), mass=1.0, velocity=(20.0, 0.0, 0.0))
    scene = Scene((wall, ball), (Restitution(0.5),))
    hit = 0.8 / 20.0
    x = np.where(hit > T, 20.0 * T, 0.8 - 10.0 * (T - hit))
    v = np.where(hit > T, 20.0, -10.0)
    zero = 0.0 * T
    motion = moved(scene, T, x_ball=np.stack([x, zero, zero], 1), v_ball=np.stack([v, zero, zero], 1))
    assert words_of(case_of(scene, motion)) == []


@pytest.mark.parametrize("wall", [Box((0.02, 2.0, 2.0)), Sphere(0.04)])
@pytest.mark.parametrize("speed", [3.0, 30.0, 300.0])
def test_a_ball_beyond_the_wall_is_named(case_of, moved, wall, speed):
    ball = Body("ball", Sphere(0.05), mass=1.0, position=(-1.0, 0.0, 0.0), velocity=(speed, 0.0, 0.0))
    scene = Scene((Body("wall", wall), ball), (Restitution(0.0), Resting()))
    t = np.linspace(0.0, 2.0 / speed, 8)  # steps of 0.29 m over a wall of 0.02 to 0.08 m
    zero = 0.0 * t
    through = moved(scene, t, x_ball=np.stack([speed * t - 1.0, zero, zero], 1))
    stopped = np.minimum(speed * t - 1.0, -0.05 - inner_radius(wall))
    speeds = np.where(stopped == speed * t - 1.0, speed, 0.0)
    held = moved(scene, t, x_ball=np.stack([stopped, zero, zero], 1), v_ball=np.stack([speeds, zero, zero], 1))
    assert words_of(case_of(scene, through)) == ["tunnelled"]
    assert words_of(case_of(scene, held)) == []


def test_a_body_that_sinks_into_the_floor_is_named(case_of, moved):
    box = Body("box", Box((1.0, 1.0, 1.0)), mass=2.0, position=(0.0, 0.0, 0.5))
    scene = Scene((FLOOR, box), (Gravity(), Resting()))
    z = 0.5 - 0.4 * T
    assert words_of(case_of(scene, moved(scene, T, x_box=np.stack([0 * T, 0 * T, z], 1)))) == ["sank"]
    z = 0.5 - 0.2 * T
    assert words_of(case_of(scene, moved(scene, T, x_box=np.stack([0 * T, 0 * T, z], 1)))) == []


def test_an_overlap_that_was_there_at_the_start_is_not_charged(case_of, moved):
    """Nor is the height to which undoing it lifts; being thrown up by it is."""
    box = Body("box", Box((1.0, 1.0, 1.0)), mass=2.0, position=(0.0, 0.0, 0.2))
    scene = Scene((FLOOR, box), (Gravity(), Resting()))
    still = moved(scene, T)
    lifted = moved(scene, T, x_box=np.stack([0 * T, 0 * T, 0.2 + np.minimum(T, 0.3)], 1))
    thrown = moved(scene, T, x_box=np.stack([0 * T, 0 * T, 0.2 + 2.0 * T], 1))
    assert words_of(case_of(scene, still)) == []
    assert words_of(case_of(scene, lifted)) == []
    assert words_of(case_of(scene, thrown)) == ["energy gained"]


def test_energy_from_nowhere_is_named(fall):
    def faster(x, v):
        v[50:] *= 1.2

    def slower(x, v):
        v[50:] *= 0.8

    assert words_of(fall(faster)) == ["energy gained"]
    assert words_of(fall(slower)) == []  # inaccurate, and a matter of the energy error


@pytest.mark.parametrize(("start", "end"), [(0.0, np.inf), (0.25, 0.75), (0.0, 0.5)])
def test_what_loads_give_is_not_from_nowhere(case_of, moved, start, end):
    """A push along x and a torque about y; the same motion without them comes from nowhere."""
    push = Force("ball", (6.0, 0.0, 0.0), (0.0, 0.08, 0.0), start=start, end=end)
    ball = Body("ball", Sphere(0.1), mass=2.0)
    spun = 0.08 / float(ball.inertia_tensor[1, 1])
    acting = np.clip(T, start, min(end, 1.0)) - start
    after = np.maximum(T - min(end, 1.0), 0.0)
    x = 3.0 * (0.5 * acting**2 + acting * after)
    zero = 0.0 * T
    scenes = [Scene((ball,), (Rotation(), *some)) for some in ((push,), ())]
    found = []
    for scene in scenes:
        motion = moved(
            scene, T, x_ball=np.stack([x, zero, zero], 1), v_ball=np.stack([3.0 * acting, zero, zero], 1),
            w_ball=np.stack([zero, spun * acting, zero], 1),
        )  # fmt: skip
        found.append(words_of(case_of(scene, motion)))
    assert found == [[], ["energy gained"]]


def test_what_must_stand_and_does_not_is_named(case_of, moved):
    """Only a scenario that demands something of the drift says that its bodies must stand."""
    box = Body("box", Box((1.0, 1.0, 1.0)), mass=2.0, position=(0.0, 0.0, 0.5))
    scene = Scene((FLOOR, box), (Gravity(), Resting(), Rotation(), Friction(0.5)))
    aside = moved(scene, T, x_box=np.stack([T, 0 * T, 0 * T + 0.5], 1))
    turned = moved(scene, T, q_box=np.array([about((0.0, 0.0, 1.0), a) for a in T]))
    for motion in (aside, turned):
        assert words_of(case_of(scene, motion, checks=(STAND,))) == ["fell"]
        assert words_of(case_of(scene, motion)) == []
    assert words_of(case_of(scene, moved(scene, T), checks=(STAND,))) == []


@pytest.mark.parametrize(
    ("effect", "held", "broken"),
    [
        # two arms of 1 m, hinged half way: half the bounding radius is 0.255 m
        (Hinge("left", "right", point=(0.5, 0.0, 0.0)), 0.25, 0.26),
        # a rod of 1 m may change by half of that
        (Rod("left", "right"), 0.49, 0.51),
        # a string of 1.2 m that has 0.2 m to go may be 0.6 m longer
        (Tether("left", "right", length=1.2), 0.79, 0.81),
    ],
    ids=lambda e: type(e).__name__ if isinstance(e, Effect) else "",
)
@pytest.mark.parametrize("turned", [0.0, 0.7])
def test_a_joint_that_comes_apart_is_named(case_of, moved, effect, held, broken, turned):
    """The right-hand body is drawn away along x; turning about y with the other, it takes the joint along."""
    arms = [Body(n, Box((1.0, 0.2, 0.1)), 1.0, (x, 0.0, 0.0)) for n, x in (("left", 0.0), ("right", 1.0))]
    scene = Scene(tuple(arms), (Rotation(), effect))
    turn = np.tile(about((0.0, 1.0, 0.0), turned), (len(T), 1))
    along = np.array([np.cos(turned), 0.0, -np.sin(turned)])

    def drawn(by):
        away = (1.0 + by * T)[:, None] * along
        away[0], q = (1.0, 0.0, 0.0), turn.copy()
        q[0] = 1.0, 0.0, 0.0, 0.0
        speed = np.tile(by * along, (len(T), 1))
        return case_of(scene, moved(scene, T, x_right=away, v_right=speed, q_left=q, q_right=q))

    assert "came apart" not in words_of(drawn(held))
    (found,) = (b for b in breaks(drawn(broken)) if b.word == "came apart")
    assert "left and right, by up to" in found.text


def test_a_quaternion_that_is_none_is_named(case_of, moved):
    scene = Scene((BALL,), (Rotation(),))
    off = np.ones((len(T), 1)) * [1.0, 0.0, 0.0, 0.0]
    assert words_of(case_of(scene, moved(scene, T, q_ball=off * (1.0 + 1e-7)))) == []
    assert words_of(case_of(scene, moved(scene, T, q_ball=off * (1.0 + 1e-5)))) == ["not normalised"]


def test_what_is_not_finite_is_named(fall):
    case = fall()
    x = np.array(case.trajectory.x)
    x[70:] = np.nan
    motion = Trajectory(case.trajectory.t, x, case.trajectory.q, case.trajectory.v, case.trajectory.w)
    said = judge(case.scenario, Run("key", "1", {}, motion))
    row = next(m for m in said.measurements if m.quantity == "stability")
    assert (said.state, words(row.text)) == ("diverged", ("not finite",))
    stopped = Failure("diverged", "read", 0.69, "the state holds NaN or infinity")
    partial = Run("key", "1", {}, stopped, partial=case.trajectory.until(70))
    assert words_of(Case(case.scenario, partial, partial.trajectory)) == ["not finite"]
    said_so = Failure("diverged", "advance", 0.69, "the engine's own warning")
    loud = Run("key", "1", {}, said_so, partial=case.trajectory.until(70))
    assert words_of(Case(case.scenario, loud, loud.trajectory)) == []


@pytest.mark.parametrize("seed", range(6))
def test_every_defect_is_found_wherever_it_happens(fall, seed):
    """A reset, a limit and a gain at a random sample; and all three together, the worst first."""
    k = int(np.random.default_rng(seed).integers(25, 60))

    def all_at_once(x, v):
        v[k:] *= 2.0
        x[k + 30 :], v[k + 30 :] = x[: 71 - k].copy(), v[: 71 - k].copy()

    assert words_of(fall(all_at_once)) == ["reset", "energy gained"]


SUITE = [s for f in families().values() for s in f.all() if s.truth is not None and "published" not in s.suites]


@pytest.mark.parametrize("scenario", SUITE, ids=lambda s: s.name)
def test_every_truth_is_stable(scenario):
    motion = scenario.truth(sample_times(scenario.duration, scenario.sampling))
    assert words_of(Case(scenario, Run("key", "1", {}, motion), motion)) == []


@pytest.mark.parametrize("shape", [
    Sphere(0.3), Box((1.0, 0.4, 0.6)), Capsule(0.2, 1.0), Cylinder(0.5, 0.3),
    Mesh(((1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)), ((0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2))),
], ids=lambda s: type(s).__name__)  # fmt: skip
def test_the_inner_ball_touches_the_surface_and_stays_inside(shape):
    from comparisons.gap import Pose, surface_distance

    rng = np.random.default_rng(3)
    points = rng.normal(size=(4000, 3))
    points *= inner_radius(shape) / np.linalg.norm(points, axis=1, keepdims=True)
    still = Pose(np.zeros((len(points), 3)), np.tile([1.0, 0.0, 0.0, 0.0], (len(points), 1)))
    distance, _ = surface_distance(shape, still, points)
    assert distance.max() <= 1e-12
    assert distance.max() > -0.01 * inner_radius(shape)


def test_the_vocabulary_is_closed():
    text = "; ".join(f"{word}: this and that, from t = 1 s on" for word in BREAKS)
    assert words(text) == tuple(BREAKS)


def test_a_stock_engine_that_limits_its_spin_is_caught():
    """PyBullet's multibody solver cuts every component at 100 rad/s, and says nothing."""
    ball = Body("ball", Sphere(0.1), mass=1.0, angular_velocity=(0.0, 500.0, 0.0))
    scene = Scene((ball,), (Rotation(),))
    found = {}
    for name in ("reference", "pybullet:stock"):
        answer = run(registry.engine(name), scene, sample_times(0.1, 0.005))
        scenario = find("free-fall")[0]
        case = Case(type(scenario)(scene, 0.1, 0.005, (), "by hand"), answer, answer.trajectory)
        found[name] = words_of(case)
    assert found == {"reference": [], "pybullet:stock": ["speed cap"]}


def test_a_stock_chain_under_a_heavy_load_comes_apart():
    """Twenty links of 1 kg hold 100 kg; sequential impulses at 1/60 s do not, and the hinges open."""
    (scenario,) = find("hanging-chain[links=20]")
    times = sample_times(scenario.duration, scenario.sampling)
    found = {}
    for name in ("mujoco", "pymunk:stock"):
        answer = run(registry.engine(name), scenario.scene, times)
        found[name] = words_of(Case(scenario, answer, answer.trajectory))
    assert found["mujoco"] == []
    assert "came apart" in found["pymunk:stock"]
