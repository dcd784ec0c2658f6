"""What is particular to the MuJoCo adapter."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from adapters.engine import Refusal, checked_settings, lead, settled
from adapters.mujoco import ENGINES
from adapters.mujoco_model import alike_and_many
from adapters.run import Failure, run
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
from mechanics.rotation import about, angle_between
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, Capsule, Cylinder, HalfSpace, Mesh, Sphere
from mechanics.trajectory import Trajectory

pytest.importorskip("mujoco")
FAIR, STOCK = ENGINES["mujoco"], ENGINES["mujoco:stock"]
FLOOR = Body("floor", HalfSpace())
POST = Body("post", Sphere(0.02))
TETRAHEDRON = Mesh(
    ((0.1, 0.1, 0.1), (0.1, -0.1, -0.1), (-0.1, 0.1, -0.1), (-0.1, -0.1, 0.1)),
    ((0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)),
)


def drive(engine, scene, duration, dt=1e-3, samples=2, **knobs):
    outcome = run(engine, scene, np.linspace(0.0, duration, samples), {"dt": dt, **knobs}).outcome
    assert isinstance(outcome, Trajectory), outcome
    return outcome


def test_integrator_is_chosen_by_whether_anything_can_touch():
    ball = Body("b", Sphere(0.1), 1.0, (0.0, 0.0, 1.0))
    free, bouncing = Scene((FLOOR, ball), (Gravity(),)), Scene((FLOOR, ball), (Gravity(), Restitution(0.5)))
    roped = Scene((FLOOR, ball), (Gravity(), Tether("floor", "b", 2.0)))
    chosen = checked_settings(FAIR, {"dt": 1e-2})
    assert settled(FAIR, chosen, free)["integrator"] == "RK4"
    assert {settled(FAIR, chosen, scene)["integrator"] for scene in (bouncing, roped)} == {"Euler"}
    assert lead(FAIR, settled(FAIR, chosen, free)) == 0.0
    assert lead(FAIR, settled(FAIR, chosen, bouncing)) == 0.005
    result = run(FAIR, free, (0.0, 1.0), {"dt": 1e-2})
    assert result.lead == 0.0
    assert any("RK4" in note for note in result.notes)
    assert result.trajectory.x[-1, 1, 2] == pytest.approx(1.0 - 0.5 * 9.81, abs=1e-12)
    assert run(FAIR, bouncing, (0.0, 0.1), {"dt": 1e-2}).lead == 0.005


def test_one_step_contacts_are_refused_to_rk4():
    scene = Scene((FLOOR, Body("b", Sphere(0.1), 1.0, (0.0, 0.0, 1.0))), (Gravity(), Restitution(0.5)))
    outcome = run(FAIR, scene, (0.0, 0.1), {"integrator": "RK4"}).outcome
    assert isinstance(outcome, Refusal)
    assert "RK4" in outcome.reason


def test_coefficients_belong_to_pairs_that_no_product_could_give():
    balls = tuple(
        Body(n, Sphere(0.1), 1.0, (x, 0.0, z), velocity=(u, 0.0, w))
        for n, x, z, u, w in (("a", 0.0, 0.153, 0.0, -1.0), ("b", 1.0, 0.153, 0.0, -1.0), ("c", 2.0, 0.153, 0.0, -1.0),
                              ("d", 5.0, 1.0, 1.0, 0.0), ("e", 5.2333, 1.0, 0.0, 0.0))
    )  # fmt: skip
    effect = Restitution(0.5, {("a", "floor"): 0.9, ("b", "floor"): 0.1, ("c", "floor"): 0.0, ("d", "e"): 1.0})
    motion = drive(FAIR, Scene((FLOOR, *balls), (effect,)), 0.12)
    assert motion.v[-1, 1:4, 2] == pytest.approx([0.9, 0.1, 0.0], abs=1e-12)
    assert motion.v[-1, 4:, 0] == pytest.approx([0.0, 1.0], abs=1e-12)


def test_bad_states_are_failures_and_leave_no_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    bodies = (POST, Body("b", Sphere(0.1), 1.0, (1.0, 0.0, 0.0), velocity=(0.0, 0.0, 1.0)))
    # a spring far stiffer than the step allows explodes
    outcome = run(FAIR, Scene(bodies, (Spring("post", "b", 1e9, 0.5),)), (0.0, 1.0), {"dt": 1e-2}).outcome
    assert isinstance(outcome, Failure)
    assert outcome.state == "diverged"
    assert "QACC" in outcome.reason or "QPOS" in outcome.reason or "QVEL" in outcome.reason
    assert not list(Path(tmp_path).iterdir())


def test_the_warning_handler_of_a_host_is_left_alone():
    import mujoco

    heard = []
    mujoco.set_mju_user_warning(heard.append)
    handler = mujoco.get_mju_user_warning()
    try:
        drive(FAIR, Scene((Body("b", Sphere(0.1), 1.0),), (Gravity(),)), 0.1)
        assert mujoco.get_mju_user_warning() is handler
    finally:
        mujoco.set_mju_user_warning(None)


@pytest.mark.parametrize(
    ("shape", "height"), [(Sphere(0.1), 0.1), (Box((0.2, 0.3, 0.4)), 0.2), (Capsule(0.1, 0.3), 0.25),
                          (Cylinder(0.1, 0.2), 0.1)]
)  # fmt: skip
def test_shapes_rest_on_a_tilted_floor_at_their_own_height(shape, height):
    up = np.array([0.3, -0.2, 1.0])
    up /= np.linalg.norm(up)
    turn = about(np.cross((0.0, 0.0, 1.0), up), math.acos(up[2]))
    floor = Body("floor", HalfSpace(tuple(up)), position=(0.5, 0.2, -0.3))
    body = Body("b", shape, 1.0, tuple(np.array(floor.position) + height * up), tuple(turn))
    motion = drive(FAIR, Scene((floor, body), (Gravity(tuple(-9.81 * up)), Resting())), 1.0)
    # g dt^2 = 10 µm of the first step fades at 1 % a step
    assert motion.x[-1, 1] == pytest.approx(np.array(body.position), abs=1e-6)
    assert angle_between(motion.q[-1, 1], np.array(turn)) < 1e-12


def test_a_hull_lies_on_its_face():
    # the tetrahedron stands on an edge of its bounding cube and topples; a face then lies flat, 0.1/sqrt(3) below
    body = Body("b", TETRAHEDRON, 1.0, (0.0, 0.0, 0.1), tuple(about((1.0, 0.3, 0.0), 0.4)))
    scene = Scene((FLOOR, body), (Gravity(), Rotation(), Friction(0.5), Restitution(0.0), Resting()))
    motion = drive(FAIR, scene, 2.0)
    assert motion.x[-1, 1, 2] == pytest.approx(0.1 / math.sqrt(3.0), abs=1e-4)


def test_free_body_that_may_not_turn_slides_along_the_axes_of_the_world():
    body = Body("b", Box((0.2, 0.3, 0.4)), 1.0, (1.0, 2.0, 3.0), tuple(about((1.0, 2.0, 3.0), 0.7)), (0.1, 0.2, 0.3))
    motion = drive(FAIR, Scene((body,)), 1.0)
    assert motion.x[-1, 0] == pytest.approx([1.1, 2.2, 3.3], abs=1e-12)
    assert (motion.q[-1, 0] == motion.q[0, 0]).all()


def test_chain_of_hinges_conserves_energy_to_fourth_order():
    bars = tuple(Body(f"bar{i}", Box((1.0, 0.1, 0.1)), 1.0, (0.5 + i, 0.0, 0.0)) for i in range(3))
    above = ("post", "bar0", "bar1")
    hinges = tuple(Hinge(above[i], f"bar{i}", (float(i), 0.0, 0.0)) for i in range(3))
    scene = Scene((POST, *bars), (*hinges, Gravity(), Rotation()))

    def drift(dt):
        motion = drive(FAIR, scene, 0.5, dt, samples=6)
        inertia = np.array([bar.inertia_tensor[1, 1] for bar in bars])
        energy = (0.5 * (motion.v[:, 1:] ** 2).sum(-1) + 0.5 * inertia * motion.w[:, 1:, 1] ** 2
                  + 9.81 * motion.x[:, 1:, 2]).sum(-1)  # fmt: skip
        ends = motion.x[:, 1:] + 0.5 * np.stack([rotated_x(q) for q in motion.q[:, 1:]])
        starts = motion.x[:, 1:] - 0.5 * np.stack([rotated_x(q) for q in motion.q[:, 1:]])
        assert np.abs(starts[:, 1:] - ends[:, :-1]).max() < 1e-12
        return np.abs(energy - energy[0]).max()

    assert drift(1e-3) < 1e-8
    assert drift(1e-2) / drift(5e-3) > 2.0**3.5


def rotated_x(quaternions):
    w, x, y, z = quaternions.T
    return np.stack([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)], axis=-1)


def test_free_pair_of_hinged_bodies_conserves_momentum():
    a = Body("a", Box((1.0, 0.1, 0.1)), 1.0, (0.0, 0.0, 0.0), velocity=(0.3, 0.0, 0.0))
    b = Body(
        "b", Box((1.0, 0.1, 0.1)), 2.0, (1.0, 0.0, 0.0), velocity=(0.3, 0.0, -1.0), angular_velocity=(0.0, 2.0, 0.0)
    )
    motion = drive(FAIR, Scene((a, b), (Hinge("a", "b", (0.5, 0.0, 0.0)), Rotation())), 1.0, samples=11)
    assert motion.v[0] == pytest.approx(np.array([a.velocity, b.velocity]), abs=1e-15)
    assert motion.w[0] == pytest.approx(np.array([a.angular_velocity, b.angular_velocity]), abs=1e-15)
    momentum = motion.v[:, 0] + 2.0 * motion.v[:, 1]
    assert np.abs(momentum - momentum[0]).max() < 1e-9


def test_drag_acts_on_hinged_bodies_too():
    bar = Body("bar", Sphere(0.1), 1.0, (0.0, 0.0, 0.0), angular_velocity=(0.0, 2.0, 0.0), inertia=(1.0, 1.0, 1.0))
    scene = Scene((POST, bar), (Hinge("post", "bar"), Drag(0.0, 0.5), Rotation()))
    motion = drive(FAIR, scene, 1.0)
    assert motion.w[-1, 1, 1] == pytest.approx(2.0 * math.exp(-0.5), rel=1e-3)


def test_constant_and_varying_forces_add_up():
    constant, late = Force("b", (1.0, 0.0, 0.0)), Force("b", (1.0, 0.0, 0.0), start=0.5)
    motion = drive(FAIR, Scene((Body("b", Sphere(0.1), 1.0),), (constant, late)), 1.0)
    assert motion.v[-1, 0, 0] == pytest.approx(1.5, abs=1e-12)


@pytest.mark.parametrize(
    ("engine", "scene", "reason"),
    [
        (FAIR, Scene((Body("belt", Box((9.0, 1.0, 0.1)), velocity=(1.0, 0.0, 0.0)),)), "belt"),
        (FAIR, Scene((POST, Body("b", Sphere(0.1), 1.0)), (Hinge("post", "b"),)), "may not turn"),
        (
            FAIR,
            Scene(
                (POST, Body("a", Sphere(0.1), 1.0, (1, 0, 0)), Body("b", Sphere(0.1), 1.0, (0, 0, 1))),
                (Hinge("post", "a"), Hinge("a", "b"), Hinge("b", "post"), Rotation()),
            ),
            "loop",
        ),
        (STOCK, Scene((POST, Body("b", Sphere(0.1), 1.0)), (Tether("post", "b", 1.0, 0.5),)), "restitution"),
        (STOCK, Scene((FLOOR, Body("b", Sphere(0.1), 1.0)), (Friction(0.5, {("floor", "b"): 0.2}),)), "larger"),
    ],
)
def test_refusals_give_their_reason(engine, scene, reason):
    outcome = run(engine, scene, (0.0, 0.1)).outcome
    assert isinstance(outcome, Refusal)
    assert reason in outcome.reason


def test_stock_says_that_it_has_no_restitution_and_rebounds_as_it_always_does():
    scene = Scene((FLOOR, Body("b", Sphere(0.1), 1.0, (0.0, 0.0, 0.2), velocity=(0.0, 0.0, -1.0))), (Restitution(0.9),))
    result = run(STOCK, scene, np.linspace(0.0, 0.3, 2))
    assert any("no coefficient of restitution" in note for note in result.notes)
    # 0.13 on average, by where in a step it lands
    assert 0.05 < result.trajectory.v[-1, 1, 2] < 0.2


def test_rods_between_free_bodies_keep_their_length():
    a, b = Body("a", Sphere(0.1), 1.0), Body("b", Sphere(0.1), 3.0, (1.0, 0.0, 0.0), velocity=(0.0, 0.0, 1.0))
    motion = drive(FAIR, Scene((a, b), (Rod("a", "b"),)), 1.0, samples=11)
    assert np.linalg.norm(motion.x[:, 1] - motion.x[:, 0], axis=1) == pytest.approx(1.0, abs=1e-6)
    assert motion.v[-1, 0] + 3.0 * motion.v[-1, 1] == pytest.approx([0.0, 0.0, 3.0], abs=1e-12)


@pytest.mark.parametrize("engine", [FAIR, STOCK], ids=lambda engine: engine.name)
def test_every_departure_from_the_defaults_has_a_reason(engine):
    assert checked_settings(engine, None) == dict(engine.defaults)
    assert engine.version
    assert all(len(reason) > 10 for reason in engine.profile.values())


def test_pairs_found_by_the_broad_phase_give_the_same_motion_as_named_ones(monkeypatch):
    rng = np.random.default_rng(3)
    balls = tuple(
        Body(f"ball-{k}", Sphere(0.1), 1.0, (0.25 * (k % 6), 0.25 * (k // 6), 0.11 + 0.1 * float(rng.random())),
             velocity=tuple(rng.normal(size=3)))
        for k in range(36)
    )  # fmt: skip
    scene = Scene((Body("floor", HalfSpace()), *balls), (Gravity(), Rotation(), Restitution(0.9)))
    named = moved(scene)
    monkeypatch.setattr("adapters.mujoco_model.MANY_PAIRS", 100)
    found = moved(scene)
    assert np.abs(np.diff(named.v, axis=0)).max() > 1.0
    np.testing.assert_allclose(found.x, named.x, atol=1e-9)
    np.testing.assert_allclose(found.v, named.v, atol=1e-8)
    apart = replace(scene, effects=(Gravity(), Rotation(), Restitution(0.9, between={("ball-0", "ball-1"): 0.2})))
    assert not alike_and_many(apart, list(apart.pairs()))
    rough = replace(scene, effects=(*scene.effects, Friction(0.2)))
    assert not alike_and_many(rough, list(rough.pairs()))
    assert alike_and_many(scene, list(scene.pairs()))


def moved(scene):
    return drive(FAIR, scene, 0.3, samples=31)
