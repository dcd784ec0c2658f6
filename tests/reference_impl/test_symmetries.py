"""Symmetries of mechanics that hold for every scene, over random ones.

What a symmetry only renames must come out bitwise; what it recomputes, to rounding.  Rounding grows by the distance
flown over the size of the bodies at each impact: over the scenes here it reaches 2e-13 in flight and 1e-11 where
bodies come to rest, whose steps are accurate to 1e-12.
"""

import numpy as np
import pytest

from mechanics.effects import Drag, Force, Friction, Gravity, Resting, Restitution, Rotation
from mechanics.rotation import about, angle_between, product, rotate
from mechanics.scene import Body, Scene
from mechanics.shapes import Box
from reference_impl.simulate import advance, begin, simulate

FLIGHT, REST = 1e-12, 1e-10  # [m, m/s, rad, rad/s] of scenes of size 1 m and 1 s
Q = tuple(about((1.0, -2.0, 0.5), 2.1))
SHIFT = np.array((1.0, 2.0, -3.0))
SLAB = Body("floor", Box((8.0, 8.0, 1.0)), position=(0.0, 0.0, -0.5))

KINDS = {
    "spheres that collide": ("cloud", {"boxes": False, "e": 1.0}, 1.0, FLIGHT),
    "boxes and spheres that collide": ("cloud", {"e": 0.8}, 1.0, FLIGHT),
    "rough boxes and spheres that collide": ("cloud", {"e": 0.5, "effects": (Friction(0.3),)}, 1.0, FLIGHT),
    "spheres that bounce to rest": ("pile", {"boxes": False, "e": 0.3}, 0.8, REST),
    "a body thrown on the floor": ("pile", {"count": 1, "e": 0.0}, 0.5, REST),
    "a rough body thrown on the floor": ("pile", {"count": 1, "e": 0.0, "mu": 0.4}, 0.5, REST),
    "spheres under drag and a force": (
        "cloud", {"boxes": False, "effects": (Drag(0.3, 0.001), Force("b1", (1.0, 2.0, 0.5), (0.01, 0.0, 0.02)))}, 1.0,
        FLIGHT,
    ),
}  # fmt: skip


@pytest.fixture(
    params=[(kind, seed) for kind in KINDS for seed in range(2 if KINDS[kind][0] == "cloud" else 1)],
    ids=lambda p: f"{p[0]}-{p[1]}",
)
def case(request, scenes):
    """A scene, when it ends [s], and by how much rounding may change its end."""
    kind, seed = request.param
    make, told, end, tolerance = KINDS[kind]
    return getattr(scenes, make)(seed, **told), end, tolerance


def apart(x, q, v, w, motion):
    """Greatest difference of a last state from that of `motion`."""
    differences = [np.abs(one - other[-1]).max() for one, other in ((x, motion.x), (v, motion.v), (w, motion.w))]
    return max(*differences, float(np.max(angle_between(q, motion.q[-1]))))


def same(motion, other):
    """Whether two motions are equal bit by bit (0.0 equals -0.0)."""
    return all((getattr(motion, name) == getattr(other, name)).all() for name in ("x", "q", "v", "w"))


def test_a_scene_turned_and_moved_moves_turned_and_moved(case, scenes):
    scene, end, tolerance = case
    motion, other = simulate(scene, (0.0, end)), simulate(scenes.turned(scene, Q, SHIFT), (0.0, end))
    back = np.array(Q) * (1.0, -1.0, -1.0, -1.0)
    x, v, w = (rotate(back, a) for a in (other.x[-1] - SHIFT, other.v[-1], other.w[-1]))
    assert apart(x, product(back, other.q[-1]), v, w, motion) <= tolerance


def test_the_mirror_image_of_a_motion_is_a_motion(case, scenes):
    scene, end, tolerance = case
    motion, other = simulate(scene, (0.0, end)), simulate(scenes.mirrored(scene), (0.0, end))
    m = scenes.MIRROR
    assert apart(m * other.x[-1], other.q[-1] * (1.0, -1.0, 1.0, -1.0), m * other.v[-1], -m * other.w[-1],
                 motion) <= tolerance  # fmt: skip


@pytest.mark.parametrize(("length", "time", "mass"), [(1e3, 1.0, 1.0), (1.0, 1e-3, 1.0), (1e-3, 10.0, 1e6)])
def test_units_do_not_matter(case, scenes, length, time, mass):
    scene, end, tolerance = case
    motion = simulate(scene, (0.0, end))
    other = simulate(scenes.scaled(scene, length, time, mass), (0.0, end * time))
    speed = length / time
    assert apart(other.x[-1] / length, other.q[-1], other.v[-1] / speed, other.w[-1] * time, motion) <= tolerance


@pytest.mark.parametrize("seed", range(6))
def test_units_that_are_powers_of_two_change_no_bit(scenes, seed):
    scene = scenes.cloud(seed, boxes=False)
    motion, other = simulate(scene, (0.0, 1.0)), simulate(scenes.scaled(scene, 4.0, 2.0, 16.0), (0.0, 2.0))
    assert (other.x == 4.0 * motion.x).all()
    assert (other.v == 2.0 * motion.v).all()
    assert (other.w == 0.5 * motion.w).all()
    assert (other.q == motion.q).all()


def test_the_order_of_the_bodies_does_not_matter(case, scenes):
    scene, end, tolerance = case
    order = np.arange(len(scene.bodies))[::-1]
    motion, other = simulate(scene, (0.0, end)), simulate(scenes.permuted(scene, order), (0.0, end))
    assert apart(*(getattr(other, name)[-1, order] for name in ("x", "q", "v", "w")), motion) <= tolerance


@pytest.mark.parametrize("told", [{"e": 0.0}, {"e": 0.3}, {"e": 0.0, "mu": 0.4}])
def test_where_the_floor_stands_in_the_list_changes_no_bit(scenes, told):
    scene = scenes.pile(1, count=1, **told)
    motion, other = simulate(scene, (0.0, 0.5)), simulate(scenes.permuted(scene, (1, 0)), (0.0, 0.5))
    assert all((getattr(other, name)[-1, ::-1] == getattr(motion, name)[-1]).all() for name in ("x", "q", "v", "w"))


@pytest.mark.parametrize("boost", [(0.3, -0.2, 0.1), (4.0, 0.0, 2.0)])
def test_a_steady_motion_of_everything_is_not_felt(case, scenes, boost):
    scene, end, tolerance = case
    if Drag in scene.needs:
        pytest.skip("the air would have to move along")
    bodies = tuple(SLAB if b.name == "floor" else b for b in scene.bodies)
    scene = Scene(bodies, scene.effects)
    motion, other = simulate(scene, (0.0, end)), simulate(scenes.turned(scene, boost=boost), (0.0, end))
    x, v = other.x[-1] - np.array(boost) * end, other.v[-1] - boost
    assert apart(x, other.q[-1], v, other.w[-1], motion) <= 10.0 * tolerance


@pytest.mark.parametrize("boxes", [False, True])
@pytest.mark.parametrize("seed", range(6))
def test_elastic_motion_runs_back_where_it_came_from(scenes, seed, boxes):
    scene = scenes.cloud(seed, boxes=boxes, effects=(Gravity((0.3, 0.2, -1.0)),))
    end = simulate(scene, (0.0, 1.0)).at(1)
    back = simulate(scenes.continued(scene, end, -1.0), (0.0, 1.0)).at(1)
    start = scene.start()
    assert np.abs(back.x - start.x).max() <= FLIGHT
    assert np.abs(back.v + start.v).max() <= 10.0 * FLIGHT
    assert np.abs(back.w + start.w).max() <= 100.0 * FLIGHT
    assert np.max(angle_between(back.q, start.q)) <= 10.0 * FLIGHT


def test_a_motion_can_be_taken_up_where_it_stood(case, scenes):
    scene, end, tolerance = case
    motion = simulate(scene, (0.0, 0.4 * end, end))
    other = simulate(scenes.continued(scene, motion.at(1)), (0.0, 0.6 * end))
    assert apart(other.x[-1], other.q[-1], other.v[-1], other.w[-1], motion) <= 10.0 * tolerance


def test_looking_more_often_changes_nothing(case):
    scene, end, tolerance = case
    motion, often = simulate(scene, (0.0, end)), simulate(scene, np.linspace(0.0, end, 38))
    assert apart(often.x[-1], often.q[-1], often.v[-1], often.w[-1], motion) <= tolerance


def test_twice_the_same_bits(case):
    scene, end, _ = case
    times = (0.0, 0.3 * end, end)
    assert same(simulate(scene, times), simulate(scene, times))


UNNEEDED = {
    "friction of zero": (Friction(0.0),),
    "drag of zero": (Drag(0.0, 0.0),),
    "gravity of zero": (Gravity((0.0, 0.0, 0.0)),),
    "rest where nothing rests": (Resting(),),
    "a force of zero": (Force("b0"),),
    "all of them": (Friction(0.0), Drag(), Gravity((0.0, 0.0, 0.0)), Resting(), Force("b1")),
}


@pytest.mark.parametrize("name", UNNEEDED)
@pytest.mark.parametrize("boxes", [False, True])
def test_an_effect_that_is_not_needed_changes_no_bit(scenes, name, boxes):
    for seed in range(3):
        scene = scenes.cloud(seed, boxes=boxes, e=0.9)
        more = Scene(scene.bodies, scene.effects + UNNEEDED[name])
        assert same(simulate(scene, (0.0, 1.0)), simulate(more, (0.0, 1.0)))


@pytest.mark.parametrize("seed", range(4))
def test_smooth_spheres_need_no_rotation(scenes, seed):
    for scene in (scenes.cloud(seed, boxes=False, turning=False), scenes.pile(seed, boxes=False)):
        bodies = tuple(Body(b.name, b.shape, b.mass, b.position, velocity=b.velocity) for b in scene.bodies)
        still = tuple(e for e in scene.effects if not isinstance(e, Rotation))
        without, with_it = Scene(bodies, still), Scene(bodies, (*still, Rotation()))
        assert same(simulate(without, (0.0, 0.8)), simulate(with_it, (0.0, 0.8)))


def test_friction_of_zero_changes_no_bit_of_a_body_that_comes_to_rest(scenes):
    scene = scenes.pile(2, e=0.3)
    assert same(simulate(scene, (0.0, 0.6)), simulate(Scene(scene.bodies, (*scene.effects, Friction(0.0))), (0.0, 0.6)))


def elsewhere(scene, shift):
    """The moving bodies of a scene moved, and called anew."""
    return tuple(
        Body(f"other {b.name}", b.shape, b.mass, tuple(np.add(b.position, shift)), b.orientation, b.velocity,
             b.angular_velocity)
        for b in scene.bodies if not b.fixed
    )  # fmt: skip


def beside(scene, other, shift):
    """Both scenes in one, the other one moved."""
    return Scene(scene.bodies + elsewhere(other, shift), scene.effects)


@pytest.mark.parametrize("seed", range(3))
def test_two_clouds_far_apart_do_not_change_a_bit_of_each_other(scenes, seed):
    """Equal sizes and speeds, so that the tolerances of both are those of each.

    Each is compared with itself at its own place: coordinates of 8 m are rounded ten times as coarsely as those of a
    metre, which some impacts make 5e-12 rad/s of the motion near the origin.
    """
    a = scenes.cloud(seed, e=0.9)
    mirror, shift = scenes.mirrored(a), (0.0, 8.0, 0.0)
    both = simulate(beside(a, mirror, shift), (0.0, 1.0))
    alone = simulate(a, (0.0, 1.0))
    image = simulate(Scene(elsewhere(mirror, shift), a.effects), (0.0, 1.0))
    n = len(a.bodies)
    for name in ("x", "q", "v", "w"):
        assert (getattr(both, name)[-1, :n] == getattr(alone, name)[-1]).all()
        assert (getattr(both, name)[-1, n:] == getattr(image, name)[-1]).all()


def test_two_piles_far_apart_do_not_know_of_each_other(scenes):
    a, b = scenes.pile(0, count=1, e=0.0, boxes=False), scenes.pile(2, count=1, e=0.0)
    both = simulate(beside(a, b, (40.0, 0.0, 0.0)), (0.0, 0.6))
    for scene, rows, shift in ((a, slice(0, 2), 0.0), (b, slice(2, 3), 40.0)):
        alone = simulate(scene, (0.0, 0.6))
        moving = slice(0, 2) if rows.stop == 2 else slice(1, 2)
        x = both.x[-1, rows] - (shift, 0.0, 0.0)
        end = [getattr(alone, name)[:, moving] for name in ("x", "q", "v", "w")]
        assert np.abs(x - end[0][-1]).max() <= REST
        assert np.max(angle_between(both.q[-1, rows], end[1][-1])) <= REST
        assert np.abs(both.v[-1, rows] - end[2][-1]).max() <= REST


INELASTIC = [(0.6, 0.0, True), (0.0, 0.0, False), (0.0, 0.5, False), (0.7, 0.3, False)]


@pytest.mark.parametrize(("e", "mu", "boxes"), [(1.0, 0.0, True), *INELASTIC])
def test_what_collides_keeps_its_momentum_and_makes_no_energy(scenes, e, mu, boxes):
    """Through the whole engine; friction with e > 0 on spheres, where Newton's law is safe."""
    impacts = 0
    for seed in range(25 if e else 4):
        scene = scenes.cloud(seed, e=e, boxes=boxes, count=6, effects=(Friction(mu),) if mu else (Resting(),))
        world = begin(scene)
        start = world.state()
        advance(world, 1.2)
        end = world.state()
        impacts += len(world.events)
        (p, spin), (q, turned) = scenes.momentum(scene, start), scenes.momentum(scene, end)
        before, after = scenes.energy(scene, start), scenes.energy(scene, end)
        push = sum(scene.bodies[i].mass * np.linalg.norm(start.v[i]) for i in scene.moving)
        assert np.abs(q - p).max() <= 1e-13 * push
        assert np.abs(turned - spin).max() <= 1e-13 * push
        assert after <= before * (1.0 + 1e-13)
        if e == 1.0:
            assert after == pytest.approx(before, rel=1e-13)
    assert impacts > (50 if e else 8)


@pytest.mark.parametrize("e", [0.2, 0.5, 1.0])
def test_two_bodies_part_at_e_times_their_speed_of_approach(scenes, e):
    """At the point and along the normal that the engine names, whatever the shapes."""
    for seed in range(40):
        rng = np.random.default_rng(seed)
        a = scenes.body(rng, "a", (-1.0, 0.0, 0.0), velocity=(1.5, *rng.normal(size=2) * 0.1), spin=4.0)
        b = scenes.body(rng, "b", (1.0, 0.05, 0.05), velocity=(-1.5, *rng.normal(size=2) * 0.1), spin=4.0)
        scene = Scene((a, b), (Rotation(), Restitution(e), Resting()))
        world = begin(scene)
        while not world.events and world.t < 2.0:
            advance(world, 0.05)
        if not world.events:
            continue
        hit = world.events[0]
        before = simulate(scene, (0.0, np.nextafter(hit.time, 0.0))).at(1)
        after = simulate(scene, (0.0, np.nextafter(hit.time, 9.0))).at(1)

        def closing(state, hit=hit):
            points = [state.v[i] + np.cross(state.w[i], np.array(hit.point) - state.x[i]) for i in (hit.a, hit.b)]
            return np.array(hit.normal) @ (points[0] - points[1])

        assert closing(after) == pytest.approx(-e * closing(before), abs=1e-11)
        assert closing(before) < 0.0
