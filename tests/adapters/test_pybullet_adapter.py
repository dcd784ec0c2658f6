"""What is particular to the PyBullet adapter."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from adapters.engine import Refusal, checked_settings
from adapters.pybullet import ENGINES
from adapters.run import Failure, prepare, run
from adapters.translate import factors
from mechanics.effects import Force, Friction, Gravity, Hinge, Resting, Restitution, Rod, Rotation
from mechanics.rotation import about, angle_between, matrix, rotate
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, Capsule, Cylinder, HalfSpace, Mesh, Sphere

bullet = pytest.importorskip("pybullet")
FAIR, MULTIBODY, STOCK = (ENGINES[name] for name in ("pybullet", "pybullet:multibody", "pybullet:stock"))
FLOOR = Body("floor", HalfSpace())
TETRAHEDRON = Mesh(
    ((0.1, 0.1, 0.1), (0.1, -0.1, -0.1), (-0.1, 0.1, -0.1), (-0.1, -0.1, 0.1)),
    ((0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)),
)


def drive(engine, scene, duration, dt=1e-3, samples=2):
    outcome = run(engine, scene, np.linspace(0.0, duration, samples), {"dt": dt}).outcome
    assert not isinstance(outcome, (Failure, Refusal)), outcome
    return outcome


def test_first_step_turns_with_the_inertia_of_the_scene():
    # btRigidBody keeps the inertia of its shape for one step unless it has been carried through one before
    body = Body("b", Box((0.2, 0.4, 0.6)), 2.0, orientation=tuple(about((1.0, 2.0, 3.0), 0.8)), inertia=(1.0, 2.0, 3.0))
    motion = drive(FAIR, Scene((body,), (Rotation(), Force("b", torque=(0.0, 1.0, 1.0)))), 1e-3)
    turn = matrix(np.array(body.orientation))
    expected = turn @ np.diag([1.0, 0.5, 1.0 / 3.0]) @ turn.T @ [0.0, 1e-3, 1e-3]
    assert motion.w[-1, 0] == pytest.approx(expected, abs=1e-9)


def test_contact_of_a_body_with_a_full_tensor_happens_in_the_scene_s_frames():
    tensor = ((0.02, 0.004, 0.002), (0.004, 0.03, 0.001), (0.002, 0.001, 0.04))
    box = Body("box", Box((0.2, 0.3, 0.4)), 2.0, (0.0, 0.0, 0.5), tuple(about((1.0, 1.0, 0.3), 0.9)),
               velocity=(0.0, 0.0, -1.0), inertia=tensor)  # fmt: skip
    corners = [np.array(c) / 2 * box.shape.size for c in itertools.product((-1, 1), repeat=3)]
    arm = min((rotate(np.array(box.orientation), c) for c in corners), key=lambda r: r[2])
    turn = matrix(np.array(box.orientation))
    inverse = np.linalg.inv(turn @ box.inertia_tensor @ turn.T)
    lever = np.cross(arm, (0.0, 0.0, 1.0))
    impulse = 1.5 / (0.5 + lever @ inverse @ lever)
    landing = 0.5 + arm[2]
    motion = drive(FAIR, Scene((FLOOR, box), (Rotation(), Restitution(0.5))), landing + 1e-3, 1e-4)
    assert motion.v[-1, 1] == pytest.approx([0.0, 0.0, -1.0 + impulse / 2.0], abs=1e-9)
    # the free spin after the impact turns by 1e-3 of itself
    assert motion.w[-1, 1] == pytest.approx(inverse @ lever * impulse, rel=5e-3, abs=5e-3)


@pytest.mark.parametrize("shape", [Sphere(0.1), Box((0.2, 0.3, 0.2)), Capsule(0.1, 0.3), Cylinder(0.1, 0.2)])
def test_shapes_rest_on_a_tilted_floor_at_their_own_height(shape):
    up = np.array([0.3, -0.2, 1.0])
    up /= np.linalg.norm(up)
    turn = about(np.cross((0.0, 0.0, 1.0), up), math.acos(up[2]))
    height = {Sphere: 0.1, Box: 0.1, Capsule: 0.25, Cylinder: 0.1}[type(shape)]
    floor = Body("floor", HalfSpace(tuple(up)), position=(0.5, 0.2, -0.3))
    body = Body("b", shape, 1.0, tuple(np.array(floor.position) + height * up + (0.0, 0.0, 0.0)), tuple(turn))
    motion = drive(FAIR, Scene((floor, body), (Gravity(tuple(-9.81 * up)), Resting())), 0.5)
    # Bullet's iterative distance of a cylinder is right to 1e-6 m
    assert motion.x[-1, 1] == pytest.approx(np.array(body.position), abs=1e-5)
    assert angle_between(motion.q[-1, 1], motion.q[0, 1]) < 1e-12


@pytest.mark.parametrize(("engine", "margin"), [(FAIR, 1e-5), (MULTIBODY, 1e-5), (STOCK, 1e-3)])
@pytest.mark.parametrize("inertia", [None, ((0.02, 0.004, 0.002), (0.004, 0.03, 0.001), (0.002, 0.001, 0.04))])
def test_hull_touches_its_margin_early_and_says_so(engine, margin, inertia):
    # a point downwards: it is deepest below the middle, whatever the frame of the inertia is
    point = about((1.0, -1.0, 0.0), math.acos(-1.0 / math.sqrt(3.0)))
    low = min(rotate(point, np.array(v))[2] for v in TETRAHEDRON.vertices)
    start = Body("b", TETRAHEDRON, 1.0, (0.0, 0.0, 0.01 - low), tuple(point), (0.0, 0.0, -1.0), inertia=inertia)
    result = run(engine, Scene((FLOOR, start), (Resting(), Rotation())), np.linspace(0.0, 0.03, 31))
    assert any(f"{1e3 * margin:g} mm" in note and "b" in note for note in result.notes)
    if engine is STOCK:  # its contacts also brake bodies that come near
        return
    corners = rotate(result.outcome.q[:, 1, None], np.array(TETRAHEDRON.vertices))[..., 2].min(axis=1)
    lowest = (result.outcome.x[:, 1, 2] + corners).min()
    assert lowest == pytest.approx(margin, abs=2e-5)


def test_stock_resting_profile_and_impact_profile_differ():
    # only Restitution says that bodies collide; without it stacks are held by velocity correction
    boxes = tuple(Body(f"b{i}", Box((0.5, 0.5, 0.5)), 1.0, (0.0, 0.0, 0.25 + 0.5 * i)) for i in range(5))
    effects = (Gravity(), Rotation(), Friction(0.5), Resting())
    resting = drive(FAIR, Scene((FLOOR, *boxes), effects), 1.0, samples=21)
    bouncing = drive(FAIR, Scene((FLOOR, *boxes), (*effects, Restitution(0.0))), 1.0, samples=21)
    drift = [np.abs(m.x - m.x[0]).max() for m in (resting, bouncing)]
    assert drift[0] < 1e-5 < drift[1] < 1e-3


def test_an_inelastic_drop_does_not_bounce_however_it_meets_the_steps():
    for phase in np.linspace(0.0, 0.9, 4):
        box = Body("box", Box((0.2, 0.2, 0.2)), 1.0, (0.0, 0.0, 0.6 + 0.003 * phase))
        effects = (Gravity(), Rotation(), Friction(0.5), Resting(), Restitution(0.0))
        motion = drive(FAIR, Scene((FLOOR, box), effects), 0.6, samples=601)
        assert motion.v[:, 1, 2].max() < 1e-9


@pytest.mark.parametrize("engine", [FAIR, MULTIBODY])
def test_hinges_of_other_axes_hold_and_others_are_refused(engine):
    post, axis = Body("post", Sphere(0.02)), np.array([1.0, 1.0, 0.5]) / 1.5
    rod = Body("rod", Box((0.2, 0.2, 0.2)), 1.0, (0.5, -0.2, 0.1), inertia=(0.02, 0.03, 0.04))
    scene = Scene((post, rod), (Hinge("post", "rod", axis=tuple(axis)), Gravity(), Rotation()))
    if engine is MULTIBODY:
        with pytest.raises(Refusal, match="links"):
            prepare(engine, scene)
        return
    motion = drive(engine, scene, 1.0, samples=101)
    off_axis = motion.w[:, 1] - np.outer(motion.w[:, 1] @ axis, axis)
    assert np.linalg.norm(motion.w[:, 1], axis=1).max() > 1.0
    assert np.linalg.norm(off_axis, axis=1).max() < 0.02
    assert np.abs(motion.x[:, 1] @ axis - motion.x[0, 1] @ axis).max() < 1e-4


@pytest.mark.parametrize(
    ("scene", "reason"),
    [
        (Scene((Body("belt", Box((9.0, 1.0, 0.1)), velocity=(1.0, 0.0, 0.0)),)), "belt"),
        (Scene((FLOOR, Body("b", Sphere(0.1), 1.0, (0, 0, 1))), (Rod("floor", "b"),)), "no Rod"),
        (Scene((FLOOR, Body("b", Sphere(0.1), 1.0, (0, 0, 1))), (Hinge("floor", "b"),)), "may not turn"),
        (
            Scene(
                (FLOOR, Body("b", Sphere(0.1), 1.0, (0, 0, 1), velocity=(1, 0, 0))), (Hinge("floor", "b"), Rotation())
            ),
            "part at 1 m/s",
        ),
    ],
)
def test_refusals_give_their_reason(scene, reason):
    outcome = run(FAIR, scene, (0.0, 0.1)).outcome
    assert isinstance(outcome, Refusal)
    assert reason in outcome.reason


def test_pairs_that_no_product_of_factors_gives_are_refused_by_name():
    bodies = tuple(Body(name, Sphere(0.1), 1.0, (i, 0.0, 0.0)) for i, name in enumerate("abcd"))
    between = {("a", "b"): 0.5, ("b", "c"): 0.5, ("c", "d"): 0.5, ("a", "d"): 0.1}
    with pytest.raises(Refusal, match=r"'[abcd]' and '[abcd]'"):
        prepare(FAIR, Scene(bodies, (Restitution(0.5, between),)))


def test_each_pair_gets_its_own_restitution_where_a_product_exists():
    balls = [Body(n, Sphere(0.1), 1.0, (x, 0.0, z), velocity=(0.0, 0.0, v))
             for n, x, z, v in (("a", 0.0, 0.15, -1.0), ("b", 5.0, 0.15, -1.0), ("c", 9.0, 0.15, -1.0))]  # fmt: skip
    effect = Restitution(0.5, {("floor", "a"): 0.8, ("a", "b"): 0.2, ("a", "c"): 0.2})
    scene = Scene((FLOOR, *balls), (effect,))
    with pytest.raises(Refusal):
        prepare(FAIR, scene)  # b-c would have to be 0.5 with both at 0.5 of the floor
    scene = Scene((FLOOR, *balls[:2]), (Restitution(0.5, {("floor", "a"): 0.8, ("a", "b"): 0.2}),))
    motion = drive(FAIR, scene, 0.1)
    assert motion.v[-1, :, 2] == pytest.approx([0.0, 0.8, 0.5], abs=1e-12)


@given(st.lists(st.floats(0.1, 2.0), min_size=3, max_size=5), st.booleans())
def test_factors_are_found_wherever_they_exist(values, fixed):
    bodies = tuple(
        Body(f"b{i}", Sphere(0.1), None if fixed and i == 0 else 1.0, (float(i), 0.0, 0.0)) for i in range(len(values))
    )
    between = {(f"b{i}", f"b{j}"): values[i] * values[j] for i, j in itertools.combinations(range(len(values)), 2)}
    effect = Friction(1.0, between)
    scene = Scene(bodies, (effect,))
    found = factors(scene, effect)
    for i, j in scene.pairs():
        assert found[i] * found[j] == pytest.approx(effect.of(f"b{i}", f"b{j}"), rel=1e-12)


def test_factor_of_a_frictionless_body_is_zero_and_the_floor_keeps_its_own():
    bodies = (FLOOR, Body("ice", Sphere(0.1), 1.0, (0, 0, 1)), Body("wood", Sphere(0.1), 1.0, (1, 0, 1)))
    effect = Friction(0.4, {("floor", "ice"): 0.0, ("ice", "wood"): 0.0})
    found = factors(Scene(bodies, (effect,)), effect)
    assert found[1] == 0.0
    assert found[0] * found[2] == pytest.approx(0.4, rel=1e-15)


def test_clients_are_given_back():
    scene = Scene((FLOOR, Body("b", Sphere(0.1), 1.0, (0.0, 0.0, 1.0))), (Gravity(),))
    before = bullet.connect(bullet.DIRECT)
    bullet.disconnect(before)
    for _ in range(3):
        drive(FAIR, scene, 0.01)
    after = bullet.connect(bullet.DIRECT)
    bullet.disconnect(after)
    assert after == before


def test_position_leads_by_half_a_substep():
    scene = Scene((Body("b", Sphere(0.1), 1.0),), (Gravity(),))
    result = run(FAIR, scene, (0.0, 1.0), {"dt": 1e-2, "substeps": 4})
    assert result.lead == pytest.approx(1.25e-3)
    assert result.trajectory.x[-1, 0, 2] == pytest.approx(-0.5 * 9.81 - 9.81 * result.lead, rel=1e-12)


@pytest.mark.parametrize("speed", [10.0, 1000.0])
def test_stock_slows_and_clamps_what_moves_freely(speed):
    scene = Scene((Body("b", Sphere(0.1), 1.0, velocity=(speed, 0.0, 0.0)),))
    assert drive(STOCK, scene, 1.0, 1 / 240).v[-1, 0, 0] < min(0.75 * speed, 100.0)
    assert drive(FAIR, scene, 1.0).v[-1, 0, 0] == pytest.approx(speed, rel=1e-12)


def test_stock_loses_the_restitution_it_is_asked_for():
    ball = Body("ball", Sphere(0.1), 1.0, (0.0, 0.0, 1.1))
    scene = Scene((FLOOR, ball), (Gravity(), Restitution(0.8)))
    rebounds = [drive(engine, scene, 0.6, samples=601).v[:, 1, 2].max() for engine in (FAIR, STOCK)]
    assert rebounds[0] == pytest.approx(0.8 * math.sqrt(2.0 * 9.81), rel=5e-3)
    # brakes in the air, up to 20 mm above the floor, by how much depends on where the last step before ends
    assert rebounds[1] < 0.7 * rebounds[0]


@pytest.mark.parametrize("engine", list(ENGINES.values()), ids=list(ENGINES))
def test_defaults_are_possible_settings_and_every_departure_has_a_reason(engine):
    assert checked_settings(engine, None) == {name: float(value) for name, value in engine.defaults.items()}
    assert engine.version == "3.2.7" or engine.version
    assert all(len(reason) > 10 for reason in engine.profile.values())
    assert bool(engine.profile) == (engine is not STOCK)


def test_a_turned_body_reads_back_the_way_it_was_put():
    body = Body("b", Box((0.2, 0.3, 0.4)), 1.0, orientation=tuple(about((1.0, 2.0, 3.0), 1.2)), inertia=np.array(
        ((1.0, 0.1, 0.2), (0.1, 2.0, 0.3), (0.2, 0.3, 2.5))), angular_velocity=(0.5, -1.0, 2.0))  # fmt: skip
    state = drive(FAIR, Scene((body,), (Rotation(),)), 0.01).at(0)
    assert angle_between(state.q[0], np.array(body.orientation)) < 1e-14
    assert state.w[0] == pytest.approx([0.5, -1.0, 2.0], abs=1e-15)


@pytest.mark.parametrize(("moving", "fixed"), [(1, 1), (1, 2), (2, 0), (2, 1), (2, 2), (4, 1)])
def test_equal_coefficients_of_all_pairs_have_factors(moving, fixed):
    bodies = tuple(
        Body(f"b{i}", Sphere(0.1), None if i < fixed else 1.0, (float(i), 0.0, 0.0)) for i in range(moving + fixed)
    )
    effect = Friction(0.3)
    scene = Scene(bodies, (effect,))
    found = factors(scene, effect)
    assert all(found[i] * found[j] == pytest.approx(0.3, rel=1e-15) for i, j in scene.pairs())
    if moving == 1:
        assert found[:fixed] == (1.0,) * fixed
