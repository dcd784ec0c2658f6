"""MuJoCo's stages of a step are off where a scene does not call for them, and no answer changes by a bit."""

from dataclasses import replace

import numpy as np
import pytest

from adapters.run import prepare, run, sample_times
from mechanics.effects import Drag, Force, Friction, Gravity, Hinge, Resting, Restitution, Rod, Rotation, Spring, Tether
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Sphere

mujoco = pytest.importorskip("mujoco")
from adapters.mujoco import ENGINES  # noqa: E402

FAIR = ENGINES["mujoco"]
BIT = mujoco.mjtDisableBit
FLOOR = Body("floor", HalfSpace())
POST = Body("post", Sphere(0.02), position=(0.0, 0.0, 2.0))
BOX = Body("box", Box((0.2, 0.1, 0.3)), 1.0, (0.3, 0.0, 0.5), velocity=(1.0, 0.0, 0.0))
BALL = Body("ball", Sphere(0.1), 2.0, (0.9, 0.0, 0.6))
HELD = replace(BOX, velocity=(0.0, 0.0, 0.0))
ANCHOR = (BOX, POST)
SCENES = {
    "flight": Scene((BOX,), (Gravity(), Rotation())),
    "drift": Scene((BOX,), ()),
    "drag": Scene((BOX,), (Gravity(), Drag(0.5, 0.01), Rotation())),
    "force": Scene((BOX,), (Force("box", force=(1.0, 0.0, 0.0), torque=(0.0, 0.1, 0.0)), Rotation())),
    "spring": Scene(ANCHOR, (Gravity(), Spring("post", "box", 30.0, 1.0, 0.2))),
    "undamped": Scene(ANCHOR, (Gravity(), Spring("post", "box", 30.0, 1.0))),
    "rod": Scene(ANCHOR, (Gravity(), Rod("post", "box"))),
    "tether": Scene(ANCHOR, (Gravity(), Tether("post", "box", 1.6))),
    "hinge": Scene(
        (replace(BOX, velocity=(0.0, 0.0, 0.0)), POST), (Gravity(), Rotation(), Hinge("post", "box", POST.position))
    ),
    "bounce": Scene((FLOOR, BOX, BALL), (Gravity(), Restitution(0.6), Rotation())),
    "rough": Scene((FLOOR, BOX, BALL), (Gravity(), Restitution(0.3), Friction(0.4), Resting(), Rotation())),
    "mixed": Scene((FLOOR, POST, BOX, BALL), (Gravity(), Restitution(0.6), Rod("post", "ball"), Drag(0.1))),
}


def moved(engine, scene):
    return run(engine, scene, sample_times(1.0, 0.05)).outcome


def flags(scene):
    return int(FAIR.start(prepare(FAIR, scene)[0], FAIR.defaults).model.opt.disableflags)


@pytest.mark.parametrize("name", SCENES)
def test_the_answer_is_the_same_to_the_last_bit(name):
    lean, whole = moved(FAIR, SCENES[name]), moved(FAIR.all_on, SCENES[name])
    for part in ("x", "q", "v", "w"):
        np.testing.assert_array_equal(getattr(lean, part), getattr(whole, part))


@pytest.mark.parametrize(
    ("flag", "needed"),
    [
        (BIT.mjDSBL_CONTACT, {"bounce", "rough", "mixed"}),
        (BIT.mjDSBL_EQUALITY, {"rod", "mixed"}),
        (BIT.mjDSBL_LIMIT, {"tether"}),
        (BIT.mjDSBL_SPRING, {"spring", "undamped"}),
        (BIT.mjDSBL_DAMPER, {"drag", "spring", "undamped", "mixed"}),
        (BIT.mjDSBL_GRAVITY, set(SCENES) - {"drift", "force"}),
        (BIT.mjDSBL_CONSTRAINT, {"rod", "tether", "bounce", "rough", "mixed"}),
        (BIT.mjDSBL_ACTUATION, set()),
    ],
    ids=lambda value: value.name if hasattr(value, "name") else "",
)
def test_a_stage_is_on_exactly_where_it_has_work(flag, needed):
    assert {name for name, scene in SCENES.items() if not flags(scene) & int(flag)} == needed


@pytest.mark.parametrize(
    ("flag", "name"),
    [
        (BIT.mjDSBL_CONTACT, "bounce"),
        (BIT.mjDSBL_EQUALITY, "rod"),
        (BIT.mjDSBL_LIMIT, "tether"),
        (BIT.mjDSBL_SPRING, "spring"),
        (BIT.mjDSBL_DAMPER, "drag"),
        (BIT.mjDSBL_GRAVITY, "flight"),
        (BIT.mjDSBL_CONSTRAINT, "rough"),
    ],
    ids=lambda value: getattr(value, "name", value),
)
def test_a_stage_that_has_work_changes_the_answer(monkeypatch, flag, name):
    from adapters import mujoco_model

    real = mujoco_model._without_work
    whole = moved(FAIR, SCENES[name])
    monkeypatch.setattr(mujoco_model, "_without_work", lambda *args: real(*args) | int(flag))
    assert np.abs(moved(FAIR, SCENES[name]).x - whole.x).max() > 1e-3


def test_smooth_contact_has_one_dimension_because_in_three_a_least_friction_acts(monkeypatch):
    """MuJoCo raises coefficients to 1e-5, which slows what slides by 1e-5 of what presses it."""
    from adapters import mujoco_model

    real = mujoco_model.Modeller._pair

    def rough(self, spec, scene, i, j, h):
        real(self, spec, scene, i, j, h)
        spec.pairs[-1].condim = 3

    block = replace(BOX, position=(0.3, 0.0, 0.15))
    scene = Scene((FLOOR, block), (Gravity(), Resting()))
    assert moved(FAIR, scene).v[-1, 1, 0] == pytest.approx(1.0, abs=1e-14)
    monkeypatch.setattr(mujoco_model.Modeller, "_pair", rough)
    slowed = moved(FAIR, scene).v[-1, 1, 0]
    assert 1e-6 < 1.0 - slowed < 2e-4


def test_stock_leaves_everything_on():
    stock = ENGINES["mujoco:stock"]
    world = stock.start(prepare(stock, SCENES["drift"])[0], stock.defaults)
    assert int(world.model.opt.disableflags) == int(BIT.mjDSBL_AUTORESET)
    assert stock.all_on is None
