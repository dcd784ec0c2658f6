"""What is said to be conserved survives every push that the declared effects can give, and nothing else does.

The pushes are drawn here from the physics of each effect, not from the module under test: a smooth
plane pushes along its normal at any point, a rod along the line through its fixed end, a hinge
through its point and with couples across its axis, touching bodies push each other equally and oppositely.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from comparisons.conserved import conserved
from comparisons.momentum import angular_deviation, angular_scale, linear_deviation, linear_scale
from comparisons.moving import Moving
from mechanics.effects import (
    Drag,
    Force,
    Friction,
    Gravity,
    Hinge,
    Resting,
    Restitution,
    Rod,
    Rotation,
    Spring,
    Tether,
)
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Sphere
from mechanics.trajectory import Trajectory

FLOOR = Body("floor", HalfSpace())
TILTED = Body("tilted", HalfSpace((1.0, 0.0, 2.0)))
POST = Body("post", Sphere(0.1), position=(0.0, 0.0, 3.0))
BRICKS = tuple(
    Body(f"brick{i}", Box((0.3, 0.2, 0.4)), mass=1.0 + i, position=(i, 0.3 * i, 1.0 + i), velocity=(0.2, -i, 0.5))
    for i in range(3)
)
BALLS = tuple(Body(f"ball{i}", Sphere(0.2), mass=2.0, position=(i, 0.4 * i * i, 1.0)) for i in range(3))
Z, X = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])


# Each kind of push: (body, point in the world, impulse, couple) for a state, or a pair of such.


def along(normal):
    n = np.array(normal) / np.linalg.norm(normal)
    return lambda rng, x, i: [(i, x[i] + rng.normal(size=3), rng.normal() * n, np.zeros(3))]


def through(point):
    def push(rng, x, i):
        p = x[i] + rng.normal(size=3)
        return [(i, p, rng.normal() * (p - point) / np.linalg.norm(p - point), np.zeros(3))]

    return push


def central(direction=None):
    return lambda rng, x, i: [
        (i, x[i], rng.normal(size=3) if direction is None else rng.normal() * direction, np.zeros(3))
    ]


def hinged(point, axis):
    return lambda rng, x, i: [(i, np.array(point), rng.normal(size=3), np.cross(axis, rng.normal(size=3)))]


def each_other(rng, x, i):
    j = int(rng.choice([k for k in range(len(x)) if k != i]))
    p, impulse = rng.normal(size=3), rng.normal(size=3)
    return [(i, p, impulse, np.zeros(3)), (j, p, -impulse, np.zeros(3))]


def between_centres(rng, x, i):
    j = int(rng.choice([k for k in range(len(x)) if k != i]))
    impulse = rng.normal() * (x[i] - x[j]) / np.linalg.norm(x[i] - x[j])
    return [(i, x[i], impulse, np.zeros(3)), (j, x[j], -impulse, np.zeros(3))]


def anything(rng, x, i):
    return [(i, x[i] + rng.normal(size=3), rng.normal(size=3), np.zeros(3))]


SMOOTH = Restitution(1.0)
# name: scene, kinds of push, dimensions of the conserved linear and angular momentum, fate of the energy
SCENES = {
    "free": (Scene(BRICKS, (Rotation(), SMOOTH)), [each_other], 3, 3, "conserved"),
    "falling": (Scene(BRICKS, (Gravity(), Rotation(), SMOOTH)), [each_other], 3, 3, "conserved"),
    "smooth floor": (
        Scene((FLOOR, *BRICKS), (Gravity(), Rotation(), SMOOTH)), [each_other, along(Z)], 2, 1, "conserved",
    ),
    "two smooth planes": (
        Scene((FLOOR, TILTED, *BRICKS), (Gravity(), Rotation(), SMOOTH)),
        [each_other, along(Z), along((1.0, 0.0, 2.0))], 1, 0, "conserved",
    ),
    "rough floor": (Scene((FLOOR, *BRICKS), (Rotation(), Friction(0.5))), [anything], 0, 0, "may only fall"),
    "one smooth ball": (Scene((FLOOR, BALLS[0]), (Gravity(), Rotation(), SMOOTH)), [central(Z)], 2, 3, "conserved"),
    "ball against a post": (Scene((POST, BALLS[0]), (Rotation(), SMOOTH)), [central()], 0, 3, "conserved"),
    "bricks against a post": (
        Scene((POST, *BRICKS), (Rotation(), SMOOTH)), [each_other, through(np.array(POST.position))], 0, 3, "conserved",
    ),
    "rod": (
        Scene((POST, *BRICKS), (Rotation(), Rod("post", "brick0", anchor_b=(0.1, 0.0, 0.0)))),
        [each_other, through(np.array(POST.position))], 0, 3, "conserved",
    ),
    "pendulum": (
        Scene((POST, *BRICKS), (Gravity(), Rotation(), Rod("post", "brick0", anchor_b=(0.1, 0.0, 0.0)))),
        [each_other, through(np.array(POST.position))], 0, 1, "conserved",
    ),
    "spring and tether": (
        Scene(
            (POST, Body("other", Sphere(0.1), position=(0.0, 0.0, 5.0)), *BRICKS),
            (Rotation(), Spring("post", "brick0", 3.0, 1.0, anchor_b=(0.1, 0, 0)), Tether("other", "brick1", 2.0, 1.0)),
        ),
        [each_other, through(np.array(POST.position)), through(np.array([0.0, 0.0, 5.0]))], 0, 1, "conserved",
    ),
    "hinge": (
        Scene((POST, *BRICKS), (Rotation(), Hinge("post", "brick0", (0.5, 0.5, 0.5), (1.0, 0.0, 0.0)))),
        [each_other, hinged((0.5, 0.5, 0.5), X)], 0, 1, "conserved",
    ),
    "vertical hinge in gravity": (
        Scene((POST, *BRICKS), (Gravity(), Rotation(), Hinge("post", "brick0", (0.5, 0.5, 0.5), (0.0, 0.0, 1.0)))),
        [each_other, hinged((0.5, 0.5, 0.5), Z)], 0, 1, "conserved",
    ),
    "level hinge in gravity": (
        Scene((POST, *BRICKS), (Gravity(), Rotation(), Hinge("post", "brick0", (0.5, 0.5, 0.5), (1.0, 0.0, 0.0)))),
        [each_other, hinged((0.5, 0.5, 0.5), X)], 0, 0, "conserved",
    ),
    "balls that do not turn": (Scene(BALLS, (Gravity(), SMOOTH)), [between_centres], 3, 3, "conserved"),
    "bricks that do not turn": (Scene(BRICKS, (Gravity(), SMOOTH)), [each_other], 3, 0, "conserved"),
    "balls that do not turn on a floor": (
        Scene((FLOOR, *BALLS), (Gravity(), SMOOTH)), [between_centres, along(Z)], 2, 1, "conserved",
    ),
    "drag": (Scene(BRICKS, (Rotation(), Drag(linear=0.1))), [anything], 0, 0, "may only fall"),
    "drag on spin": (Scene(BRICKS[:1], (Rotation(), Drag(angular=0.1))), [], 3, 0, "may only fall"),
}  # fmt: skip


def pushed(scene, kinds, rng, steps=20, dt=0.1):
    """Motion under gravity and random pushes; the attitudes stay, the spins carry the angular momentum."""
    start, moving = scene.start(), list(scene.moving)
    blank = Moving.of(scene, Trajectory.of([start]))
    mass, inverse = blank.mass, np.linalg.inv(blank.inertia)
    x, v, spin = start.x[moving].copy(), start.v[moving].copy(), rng.normal(size=(len(moving), 3)) * 0.1
    if Rotation not in scene.needs:
        spin[:] = 0.0
    rows = []
    for k in range(steps):
        rows.append((k * dt, x.copy(), v.copy(), np.einsum("kij,kj->ki", inverse, spin)))
        for push in kinds:
            for i, point, impulse, couple in push(rng, x, int(rng.integers(len(moving)))):
                v[i] += impulse / mass[i]
                if Rotation in scene.needs:
                    spin[i] += np.cross(point - x[i], impulse) + couple
        x += dt * v + 0.5 * dt**2 * scene.gravity
        v += dt * scene.gravity
    t, x, v, w = (np.array(column) for column in zip(*rows, strict=True))
    return Moving(scene, t, x, np.repeat(start.q[None, moving], steps, axis=0), v, w)


@pytest.mark.parametrize("name", SCENES)
def test_dimensions_and_energy(name):
    scene, _, linear, angular, energy = SCENES[name]
    kept = conserved(scene)
    assert (len(kept.linear), len(kept.angular), kept.energy) == (linear, angular, energy)
    for basis in (kept.linear, kept.angular):
        assert basis @ basis.T == pytest.approx(np.eye(len(basis)), abs=1e-14)
    assert len(kept.sentences()) == 3


@pytest.mark.parametrize("name", SCENES)
@settings(max_examples=10)
@given(seed=st.integers(0, 2**32 - 1))
def test_no_possible_push_changes_what_is_conserved(name, seed):
    scene, kinds, *_ = SCENES[name]
    moving = pushed(scene, kinds, np.random.default_rng(seed))
    kept = conserved(scene)
    # rounding of sums over 20 steps, of positions up to some 20 m
    assert linear_deviation(moving, kept).max() <= 1e-12 * linear_scale(moving)
    if len(kept.angular):
        assert angular_deviation(moving, kept).max() <= 1e-11 * angular_scale(moving, kept.pivot)


@pytest.mark.parametrize("name", [n for n, (_, kinds, *_) in SCENES.items() if kinds])
def test_every_direction_that_is_given_up_can_be_changed(name):
    """The conserved space is not too small: in every other direction some possible push does something."""
    scene, kinds, *_ = SCENES[name]
    kept = conserved(scene)
    rng = np.random.default_rng(7)
    moving = pushed(scene, kinds, rng, steps=40)
    change = np.diff(moving.momentum, axis=0) - np.diff(moving.t)[:, None] * moving.mass.sum() * scene.gravity
    assert _rank(change) == 3 - len(kept.linear)
    if len(scene.moving) > 1 and kept.angular_why and "not known" not in kept.angular_why[0]:
        total = (moving.spin + moving.orbital(kept.pivot)).sum(axis=1)
        assert _rank(np.diff(total, axis=0)) == 3 - len(kept.angular)


def _rank(changes):
    return np.linalg.matrix_rank(changes, tol=1e-10 * max(1.0, np.abs(changes).max()))


@given(seed=st.integers(0, 2**32 - 1))
def test_a_wrong_push_is_found_with_its_size(seed):
    rng = np.random.default_rng(seed)
    scene, kinds, *_ = SCENES["smooth floor"]
    moving = pushed(scene, kinds, rng)
    stolen = np.where(moving.t > 1.0, 0.02, 0.0)  # [kg m/s]
    v = moving.v.copy()
    v[:, 1, 0] -= stolen / moving.mass[1]
    w = moving.w.copy()
    w[:, 0, 2] += stolen / moving.inertia[0, 2, 2]
    found = linear_deviation(Moving(scene, moving.t, moving.x, moving.q, v, moving.w), conserved(scene)).max()
    assert found == pytest.approx(0.02, rel=1e-9)
    found = angular_deviation(Moving(scene, moving.t, moving.x, moving.q, moving.v, w), conserved(scene)).max()
    assert found == pytest.approx(0.02, rel=1e-9)


def test_known_forces_are_accounted_for():
    """A constant force at a point and a torque on one brick, switched on late: v and L grow by their impulses."""
    force, torque = np.array([3.0, 0.0, 0.0]), np.array([0.0, 0.2, 0.1])
    effects = (Gravity(), Rotation(), Force("brick0", tuple(force), tuple(torque), (0.0, 0.1, 0.0), start=0.5, end=1.5))
    scene = Scene(BRICKS[:1], effects)
    moving = pushed(scene, [], np.random.default_rng(0))
    active = np.clip(moving.t - 0.5, 0.0, 1.0)[:, None, None]
    v = moving.v + active * force / moving.mass[0]
    kept = conserved(scene)
    assert len(kept.linear) == 3
    assert kept.angular == pytest.approx(np.array([[1.0, 0.0, 0.0]]), abs=1e-15)
    driven = Moving(scene, moving.t, moving.x, moving.q, v, moving.w)
    assert linear_deviation(driven, kept).max() < 1e-12
    turned = moving.w + active * (torque / np.diag(moving.inertia[0]))
    driven = Moving(scene, moving.t, moving.x, moving.q, v, turned)
    assert angular_deviation(driven, kept).max() < 1e-12
    assert conserved(scene, 2.0).energy == "unknown"


@pytest.mark.parametrize(
    ("effects", "bodies", "energy", "word"),
    [
        ((Restitution(0.5),), (FLOOR, BALLS[0]), "may only fall", "restitution"),
        ((Restitution(1.0, {("floor", "ball0"): 0.5}),), (FLOOR, BALLS[0]), "may only fall", "restitution"),
        ((Restitution(1.0), Resting()), (FLOOR, BALLS[0]), "conserved", ""),
        ((Resting(),), (FLOOR, BALLS[0]), "may only fall", "resting"),
        ((Restitution(1.0), Friction(0.1)), (FLOOR, BALLS[0]), "may only fall", "friction"),
        ((Restitution(1.0),), (Body("lift", Box((1, 1, 1)), velocity=(0, 0, 1)), BALLS[0]), "unknown", "lift"),
        ((Gravity(),), (Body("lift", Box((1, 1, 1)), velocity=(0, 0, 1)), BALLS[0]), "conserved", ""),
        ((Force("ball0", (1.0, 0.0, 0.0)),), (BALLS[0],), "conserved", ""),
        ((Force("ball0", (1.0, 0.0, 0.0), end=0.5),), (BALLS[0],), "unknown", "switched"),
        ((Force("ball0", torque=(1.0, 0.0, 0.0)), Rotation()), (BALLS[0],), "unknown", "torque"),
        ((Spring("ball0", "ball1", 1.0, 1.0, damping=0.1),), BALLS, "may only fall", "spring"),
        ((Tether("ball0", "ball1", 1.0),), BALLS, "may only fall", "tether"),
        ((Drag(linear=0.1),), BALLS, "may only fall", "drag"),
    ],
)
def test_fate_of_the_energy(effects, bodies, energy, word):
    kept = conserved(Scene(bodies, effects), 2.0)
    assert kept.energy == energy
    assert word in " ".join(kept.energy_why)


def test_fixed_bodies_that_cannot_be_touched_take_nothing():
    scene = Scene((FLOOR, POST, *BRICKS), (Gravity(), Rotation()))
    kept = conserved(scene)
    assert (len(kept.linear), len(kept.angular), kept.energy) == (3, 3, "conserved")


def test_a_moving_pivot_is_none():
    moving_post = Body("post", Sphere(0.1), position=(0.0, 0.0, 3.0), velocity=(1.0, 0.0, 0.0))
    scene = Scene((moving_post, *BRICKS), (Rotation(), Rod("post", "brick0")))
    kept = conserved(scene)
    assert (len(kept.linear), len(kept.angular), kept.energy) == (0, 0, "unknown")


def test_the_sentences_name_directions_and_reasons():
    linear, angular, energy = conserved(SCENES["smooth floor"][0]).sentences()
    assert linear.startswith("linear momentum: conserved along x and y: gravity (its impulse is known")
    assert angular.startswith("angular momentum about the common centre of mass: conserved along z")
    assert energy == "energy: conserved"
    pendulum = conserved(SCENES["pendulum"][0])
    assert pendulum.sentences()[1].startswith("angular momentum about the point (0, 0, 3): conserved along z")
