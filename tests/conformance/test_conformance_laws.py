"""The laws of `check_engine`: kept by every fair profile, and each of them able to fail."""

import importlib.util
import os
import random
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest

import adapters.mujoco
import adapters.pybullet
import adapters.pymunk
from adapters.conformance import LAWS, check_engine
from adapters.engine import Clock, Refusal
from mechanics.effects import Force, Gravity, Rotation
from mechanics.inertia import mass_properties
from mechanics.rotation import conjugate, exponential, matrix, product, rotate
from mechanics.shapes import Capsule
from mechanics.trajectory import State

INSTALLED = [
    engine
    for module in (adapters.pybullet, adapters.mujoco, adapters.pymunk)
    for engine in module.ENGINES.values()
    if importlib.util.find_spec(engine.name.partition(":")[0])
]


@pytest.mark.parametrize("engine", INSTALLED, ids=lambda engine: engine.name)
def test_engine_breaks_exactly_the_laws_on_record(engine):
    broken = {law.name: law.explanation for law in check_engine(engine) if not law.passed}
    assert set(broken) == set(engine.known), broken


@pytest.mark.parametrize("engine", INSTALLED, ids=lambda engine: engine.name)
def test_fair_profiles_have_nothing_on_record(engine):
    assert set(engine.known) <= set(LAWS)
    assert not engine.known or engine.stock
    assert all(name in engine.knobs for name in engine.defaults)


@pytest.mark.parametrize("module", ["pybullet", "mujoco", "pymunk"])
def test_engine_is_imported_when_used_and_not_before(module):
    program = f"import sys, adapters.{module} as a; list(a.ENGINES); sys.exit({module!r} in sys.modules)"
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == 0


@pytest.mark.parametrize("engine", [e for e in INSTALLED if ":" not in e.name], ids=lambda engine: engine.name)
def test_first_use_of_an_engine_prints_nothing(engine):
    program = (
        f"import adapters.{engine.name} as a; from adapters.engine import *; from adapters.run import run\n"
        "from mechanics.scene import *; from mechanics.shapes import *; from mechanics.effects import *\n"
        "bodies = Body('floor', HalfSpace()), Body('b', Sphere(0.1), 1.0, (0, 0, 1))\n"
        "scene = Scene(bodies, (Gravity(), Friction(0.5)))\n"
        f"assert run(a.ENGINES[{engine.name!r}], scene, (0.0, 0.1)).trajectory is not None"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout + done.stderr == ""


class Sound:
    """A small engine that keeps every law: semi-implicit Euler, and attitude from a constant angular momentum."""

    name, version = "sound", "1"

    def __init__(self):
        self.knobs, self.defaults = {"dt": (1 / 60, 1 / 120, 1 / 240)}, {"dt": 1 / 120}
        self.effects = {Gravity: self.gravity, Rotation: self.rotation, Force: self.force}

    def gravity(self, draft, effect):
        draft.g = np.array(effect.acceleration)

    def rotation(self, draft, _):
        draft.turns = True

    def force(self, draft, effect):
        i = draft.scene.index(effect.body)
        draft.force[i] += effect.force
        draft.torque[i] += effect.torque

    def vacuum(self, scene):
        s, n = scene.start(), len(scene.bodies)
        return SimpleNamespace(
            scene=scene, x=s.x.copy(), q=s.q.copy(), v=s.v.copy(), w=s.w.copy(), g=np.zeros(3), turns=False,
            force=np.zeros((n, 3)), torque=np.zeros((n, 3)),
        )  # fmt: skip

    def inertia(self, body):
        return body.inertia_tensor

    def start(self, draft, knobs):
        draft.clock = Clock(knobs["dt"])
        draft.momentum = np.zeros_like(draft.w)
        draft.tensors = {i: self.inertia(draft.scene.bodies[i]) for i in draft.scene.moving}
        for i, tensor in draft.tensors.items():
            draft.momentum[i] = self.spread(draft.q[i], tensor) @ draft.w[i]
        return draft

    def spread(self, q, tensor):
        return matrix(q) @ tensor @ matrix(q).T

    def spin(self, world, i, q):
        return np.linalg.solve(self.spread(q, world.tensors[i]), world.momentum[i])

    def advance(self, world, duration):
        h = world.clock.dt
        for _ in range(world.clock.steps(duration)):
            for i in world.scene.moving:
                world.v[i] += h * (world.g + world.force[i] / world.scene.bodies[i].mass)
                world.x[i] += h * world.v[i]
                if world.turns:
                    world.momentum[i] += h * world.torque[i]
                    middle = product(exponential(0.5 * h * self.spin(world, i, world.q[i])), world.q[i])
                    world.q[i] = product(exponential(h * self.spin(world, i, middle)), world.q[i])
                    world.w[i] = self.spin(world, i, world.q[i])

    def read(self, world):
        return State(world.clock.time, world.x.copy(), world.q.copy(), world.v.copy(), world.w.copy())

    def lead(self, settings):
        return 0.5 * settings["dt"]


class Misreads(Sound):
    def read(self, world):
        state = super().read(world)
        return State(state.t, state.x, conjugate(state.q), state.v, state.w)


class Reorders(Sound):
    def read(self, world):
        state = super().read(world)
        order = np.argsort(world.scene.names)
        return State(state.t, *(a[order] for a in (state.x, state.q, state.v, state.w)))


class Clamps(Sound):
    def advance(self, world, duration):
        super().advance(world, duration)
        np.clip(world.v, -100.0, 100.0, out=world.v)


class AlwaysTurns(Sound):
    def vacuum(self, scene):
        draft = super().vacuum(scene)
        draft.turns = True
        return draft


class NeverTurns(Sound):
    def rotation(self, draft, _):
        draft.turns = False


class FallsByHabit(Sound):
    def gravity(self, draft, effect):
        draft.g = np.array([0.0, 0.0, -9.81])


class HidesItsLead(Sound):
    def lead(self, settings):
        return 0.0


class FallsByWeight(Sound):
    def advance(self, world, duration):
        before = world.force.copy()
        world.force -= [[0.0, 0.0, 1e-9]] * len(world.force)
        super().advance(world, duration)
        world.force[:] = before


class SpinsInBodyFrame(Sound):
    def start(self, draft, knobs):
        draft.w[:] = rotate(draft.q, draft.w)
        return super().start(draft, knobs)


class KnowsInertiaBetter(Sound):
    def inertia(self, body):
        return body.mass * mass_properties(body.shape).inertia


class Everything(dict):
    """A table that claims to hold every effect."""

    def __contains__(self, _):
        return True

    def __missing__(self, _):
        return lambda draft, effect: None


class Pretends(Sound):
    def __init__(self):
        super().__init__()
        self.effects = Everything(self.effects)


class ChokesOnCapsules(Sound):
    def vacuum(self, scene):
        if any(isinstance(body.shape, Capsule) for body in scene.bodies):
            raise KeyError("capsule")
        return super().vacuum(scene)


class Jitters(Sound):
    def advance(self, world, duration):
        super().advance(world, duration)
        world.x += 1e-15 * random.random()


class WorseWhenFiner(Sound):
    def advance(self, world, duration):
        super().advance(world, duration)
        world.x[:, 2] -= 1e-6 / world.clock.dt**2


class DislikesBigSteps(Sound):
    def start(self, draft, knobs):
        if knobs["dt"] > 1 / 100:
            raise ValueError("too coarse")
        return super().start(draft, knobs)


class SharesItsGravity(Sound):
    last = np.zeros(3)

    def vacuum(self, scene):
        type(self).last = np.zeros(3)
        return super().vacuum(scene)

    def gravity(self, draft, effect):
        type(self).last = np.array(effect.acceleration)

    def advance(self, world, duration):
        world.g = type(self).last
        super().advance(world, duration)


class Chats(Sound):
    def start(self, draft, knobs):
        os.write(1, b"hello\n")
        return super().start(draft, knobs)


class RefusesAll(Sound):
    def vacuum(self, scene):
        raise Refusal("not today")


BROKEN = {
    "reads back the initial state": Misreads,
    "keeps the order of the bodies": Reorders,
    "keeps every velocity in a vacuum": Clamps,
    "turns nothing without Rotation": AlwaysTurns,
    "spins with Rotation": NeverTurns,
    "falls with g": FallsByHabit,
    "declares its time levels": HidesItsLead,
    "lets mass drop out of free fall": FallsByWeight,
    "turns in the scene's frames": SpinsInBodyFrame,
    "honours explicit inertia": KnowsInertiaBetter,
    "refuses what it does not list": Pretends,
    "simulates every shape or refuses it": ChokesOnCapsules,
    "repeats itself bit for bit": Jitters,
    "a finer step is no worse": WorseWhenFiner,
    "accepts its knobs at both ends": DislikesBigSteps,
    "keeps two worlds apart": SharesItsGravity,
    "says nothing on stdout": Chats,
}


def test_a_sound_engine_keeps_every_law():
    laws = check_engine(Sound())
    assert [law.name for law in laws] == list(LAWS)
    assert not [law for law in laws if not law.passed]


def test_every_law_has_its_offender():
    assert set(BROKEN) == set(LAWS)


@pytest.mark.parametrize("name", list(LAWS))
def test_each_law_can_fail(name):
    (law,) = check_engine(BROKEN[name](), [name])
    assert not law.passed
    assert law.explanation


def test_an_engine_that_refuses_a_vacuum_breaks_laws_and_one_that_says_so_may_jitter():
    (refused,) = check_engine(RefusesAll(), ["keeps every velocity in a vacuum"])
    assert not refused.passed
    assert "not today" in refused.explanation
    honest = Jitters()
    honest.repeats = False
    (law,) = check_engine(honest, ["repeats itself bit for bit"])
    assert law.passed
    assert "not applicable" in law.explanation


def test_a_module_is_an_engine_too():
    sound = Sound()
    module = SimpleNamespace(**{n: getattr(sound, n) for n in dir(sound) if not n.startswith("_")})
    assert all(law.passed for law in check_engine(module, ["falls with g", "declares its time levels"]))


def test_a_law_that_does_not_exist_is_named_with_those_that_do():
    with pytest.raises(ValueError, match="falls with g"):
        check_engine(Sound(), ["falls upwards"])
