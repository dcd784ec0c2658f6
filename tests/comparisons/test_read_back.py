"""The card tells what an engine did, and names each fault of a toy that has it."""

from __future__ import annotations

import json
import math
from types import SimpleNamespace

import numpy as np
import pytest

from adapters import registry
from adapters.engine import Clock, Refusal, defaults
from adapters.run import run
from comparisons.read_back import PROBES, read_back
from comparisons.reading import Reading, dependent, facts, fastest, from_plain, to_plain
from mechanics.effects import Force, Friction, Gravity, Resting, Restitution, Rotation
from mechanics.rotation import exponential, matrix, product
from mechanics.scene_file import scene_to_dict
from mechanics.shapes import HalfSpace
from mechanics.trajectory import State
from scenarios import catalogue

STEP = 5e-3  # of the toy [s]
HEALTHY = SimpleNamespace(
    gravity=1.0, damping=0.0, spin_damping=0.0, cap=math.inf, spin_cap=math.inf, asleep=False, inertia=1.0,
    gyroscopic=True, e=1.0, threshold=0.0, rule=None, mu=1.0, stiction=1.0, creep=0.0, square=False,
)  # fmt: skip


class Toy:
    """Bodies over a floor, or two by two in rows, with the steps of an engine and one fault at a time.

    Balls strike when their next step would touch; blocks stay on what they lie on and feel Coulomb friction.
    """

    version = "1"
    knobs = {"dt": (STEP,)}  # noqa: RUF012
    effects = dict.fromkeys((Gravity, Rotation, Force, Restitution, Friction, Resting), lambda draft, effect: None)

    def __init__(self, **faults):
        self.name, self.fault = "toy", SimpleNamespace(**vars(HEALTHY) | faults)

    def vacuum(self, scene):
        s = scene.start()
        return SimpleNamespace(scene=scene, x=s.x.copy(), q=s.q.copy(), v=s.v.copy(), w=s.w.copy())

    def start(self, draft, knobs):
        draft.clock = Clock(knobs["dt"])
        draft.pairs = np.array(list(draft.scene.pairs())).reshape(-1, 2)
        return draft

    def advance(self, world, duration):
        for _ in range(world.clock.steps(duration)):
            self.step(world, world.clock.dt)

    def step(self, world, h):
        scene, fault = world.scene, self.fault
        for i in scene.moving:
            self.push(world, i, h)
            world.v[i] /= 1.0 + h * fault.damping
            world.v[i] *= min(1.0, fault.cap / (np.linalg.norm(world.v[i]) or 1.0))
            if fault.asleep and world.clock.time > 2.0 and np.linalg.norm(world.v[i]) < 0.01:
                world.v[i] = 0.0
        if Restitution in scene.needs:
            self.strike(world, h)
        world.x += h * world.v
        if Rotation in scene.needs:
            for i in scene.moving:
                self.turn(world, i, h)

    def push(self, world, i, h):
        scene, fault, body = world.scene, self.fault, world.scene.bodies[i]
        world.v[i] += h * fault.gravity * scene.gravity
        pull = sum((np.array(f.force) for f in scene.all(Force) if f.body == body.name), np.zeros(3))
        if Friction not in scene.needs:
            world.v[i] += h * pull / body.mass
            return
        world.v[i, 2] = 0.0  # what lies stays
        below = min((j for j, b in enumerate(scene.bodies) if b.fixed),
                    key=lambda j: 0.0 if isinstance(scene.bodies[j].shape, HalfSpace)
                    else abs(scene.bodies[j].position[0] - world.x[i, 0]))  # fmt: skip
        mu = fault.mu * scene.friction(i, below)
        if fault.rule:
            mu = fault.rule(*(scene.friction(*pair) for pair in self.alike(scene, i, below)))
        push = (world.v[i] + h * pull / body.mass)[:2]
        most = mu * 9.81 * h
        if np.linalg.norm(world.v[i, :2]) < 1e-12 and np.linalg.norm(h * pull) <= fault.stiction * most * body.mass:
            world.x[i, 0] += h * fault.creep * np.sign(pull[0])
            world.v[i, :2] = 0.0
        elif fault.square:
            world.v[i, :2] = np.sign(push) * np.maximum(np.abs(push) - most, 0.0)
        else:
            size = np.linalg.norm(push)
            world.v[i, :2] = push / size * max(size - most, 0.0)

    @staticmethod
    def alike(scene, i, j):
        """For each of two bodies the pair of it and one of its own kind."""
        kin = {b.name[0]: [k for k, c in enumerate(scene.bodies) if c.name[0] == b.name[0]] for b in scene.bodies}
        found = [kin[scene.names[k][0]] for k in (i, j)]
        return [(own[0], own[1]) for own in found] if all(len(own) > 1 for own in found) else [(i, j), (i, j)]

    def strike(self, world, h):
        scene, (first, second) = world.scene, world.pairs.T
        apart = world.x[first] - world.x[second]
        floored = np.array([isinstance(b.shape, HalfSpace) for b in scene.bodies])[first]
        apart[floored] = -world.x[second[floored]] * (0.0, 0.0, 1.0)
        distance = np.linalg.norm(apart, axis=1)
        normals, gaps = apart / distance[:, None], distance - np.where(floored, 0.1, 0.2)
        speeds = np.einsum("ij,ij->i", normals, world.v[first] - world.v[second])
        for k in np.flatnonzero((speeds < 0.0) & (gaps + speeds * h < 0.0)):
            i, j, n, u = *world.pairs[k].tolist(), normals[k], speeds[k]
            a, b = scene.bodies[i], scene.bodies[j]
            e = self.fault.e * scene.restitution(i, j) if -u > self.fault.threshold else 0.0
            if self.fault.rule and not floored[k]:
                e = self.fault.rule(*(scene.restitution(*pair) for pair in self.alike(scene, i, j)))
            weights = [0.0 if c.fixed else 1.0 / c.mass for c in (a, b)]
            impulse = -(1.0 + e) * u / sum(weights)
            world.v[i] += impulse * weights[0] * n
            world.v[j] -= impulse * weights[1] * n

    def turn(self, world, i, h):
        body, fault = world.scene.bodies[i], self.fault
        tensor = body.inertia_tensor * (1.0 if body.inertia is not None else fault.inertia)
        torque = sum((np.array(f.torque) for f in world.scene.all(Force) if f.body == body.name), np.zeros(3))
        turn = matrix(world.q[i])
        momentum = turn @ tensor @ turn.T @ world.w[i] + h * torque
        middle = product(exponential(h / 2.0 * world.w[i]), world.q[i])
        if fault.gyroscopic:
            # the midpoint of the attitude keeps the momentum to second order
            spin = np.linalg.solve(matrix(middle) @ tensor @ matrix(middle).T, momentum)
        else:
            spin = world.w[i] + h * np.linalg.solve(turn @ tensor @ turn.T, torque)
        world.q[i] = product(exponential(h * spin), world.q[i])
        if fault.gyroscopic:
            end = matrix(world.q[i])
            spin = np.linalg.solve(end @ tensor @ end.T, momentum)
        world.w[i] = spin / (1.0 + h * fault.spin_damping)
        world.w[i] *= min(1.0, fault.spin_cap / (np.linalg.norm(world.w[i]) or 1.0))

    def read(self, world):
        return State(world.clock.time, world.x.copy(), world.q.copy(), world.v.copy(), world.w.copy())


def card(engine, needs=None):
    step = defaults(engine).get("dt", 1e-3)
    return {r.name: r for r in read_back(lambda scene, times: run(engine, scene, times), needs, step)}


def differing(readings):
    return {name for name, reading in readings.items() if reading.verdict == "differs"}


def test_a_healthy_engine_gets_everything_it_is_asked_for():
    readings = card(Toy())
    assert {r.verdict for r in readings.values()} == {"same"}
    assert len(readings) == sum(len(p.readings) for p in PROBES) == 22


@pytest.mark.parametrize(
    ("fault", "named"),
    [
        ({"gravity": 1.002}, {"gravity"}),
        ({"damping": 0.04}, {"linear damping at 0.01 m/s", "linear damping at 10 m/s"}),
        ({"spin_damping": 0.04}, {"angular damping at 0.01 rad/s", "angular damping at 10 rad/s"}),
        ({"cap": 100.0}, {"speed cap"}),
        ({"spin_cap": 500.0}, {"spin cap"}),
        ({"asleep": True}, {"asleep"}),
        ({"inertia": 1.25}, {"inertia of a sphere", "inertia of a box", "inertia of a capsule"}),
        ({"gyroscopic": False}, {"gyroscopic term"}),
        ({"e": 0.9}, {"restitution at 1 m/s", "restitution at 0.05 m/s", "restitution of two bodies",
                      "restitution, unlike materials"}),
        ({"threshold": 0.2}, {"restitution at 0.05 m/s"}),
        ({"mu": 1.1}, {"kinetic friction", "static friction", "kinetic friction, diagonal",
                       "friction, unlike materials"}),
        ({"stiction": 1.05}, {"static friction"}),
        ({"creep": 9e-4}, {"creep at half the cone"}),
        ({"square": True}, {"kinetic friction, diagonal"}),
    ],
    ids=lambda value: next(iter(value)) if isinstance(value, dict) else "",
)  # fmt: skip
def test_each_fault_is_named_and_nothing_else(fault, named):
    assert differing(card(Toy(**fault))) == named


@pytest.mark.parametrize(
    ("rule", "value", "said"),
    [
        (max, 0.9, "the larger"),
        (min, 0.4, "the smaller"),
        (lambda a, b: 0.5 * (a + b), 0.65, "the mean"),
        (lambda a, b: math.sqrt(a * b), 0.6, "the product"),
    ],
)
def test_the_rule_that_combines_two_materials_is_named(rule, value, said):
    readings = card(Toy(rule=rule))
    for name in ("restitution, unlike materials", "friction, unlike materials"):
        assert readings[name].verdict == "differs"
        assert readings[name].got == pytest.approx(value, abs=1e-9)
        assert said in readings[name].said


def test_an_engine_with_one_coefficient_per_body_is_asked_what_a_product_can_make():
    class Multiplying(Toy):
        def start(self, draft, knobs):
            effect = draft.scene.effect(Restitution)
            if effect and effect.exceptions and effect.coefficient != pytest.approx(0.6):
                raise Refusal("the engine multiplies")
            return super().start(draft, knobs)

    reading = card(Multiplying(), {"Restitution"})["restitution, unlike materials"]
    assert (reading.verdict, reading.asked) == ("same", pytest.approx(0.6))
    assert "product" in reading.said
    assert "0.5 is refused" in reading.said


def test_only_what_the_scenes_depend_on_is_read():
    assert set(card(Toy(), {"Gravity"})) == {
        "gravity", "linear damping at 0.01 m/s", "linear damping at 10 m/s", "speed cap", "asleep"
    }  # fmt: skip


def test_what_cannot_be_read_says_why():
    class Wreck(Toy):
        def advance(self, world, duration):
            raise ArithmeticError("singular")

    readings = card(Wreck(), {"Gravity"})
    assert {r.verdict for r in readings.values()} == {"unread"}
    assert all("singular" in r.said for r in readings.values())


def test_a_reading_survives_json():
    for reading in (*card(Toy(cap=100.0)).values(), Reading("x", "1", math.inf, math.nan, 0.0, refused=True)):
        again = from_plain(json.loads(json.dumps(to_plain(reading), allow_nan=False)))
        assert repr(again) == repr(reading)


def test_a_mismatch_matters_where_a_scene_depends_on_it():
    slow, fast = ({"m/s": v} for v in (99.0, 101.0))
    cap = Reading("speed cap", "m/s", math.inf, 100.0, 0.0)
    assert not cap.matters((), slow)
    assert cap.matters((), fast)
    (dropped,) = catalogue.find("bouncing-ball[]")
    scene = scene_to_dict(dropped.scene)
    assert facts(scene) == {"Gravity", "Restitution", "HalfSpace", "Sphere"}
    assert fastest(scene, 2.0)["m/s"] == pytest.approx(19.62)
    bounce = Reading("restitution", "1", 0.8, 0.1, 0.02, about=("Restitution",), bears_on=("restitution", "energy"))
    assert bounce.matters(facts(scene))
    assert not bounce.matters({"Gravity"})
    assert dependent("energy error", (bounce,))
    assert not dependent("penetration", (bounce,))


@pytest.mark.parametrize("name", ["reference", "pybullet", "mujoco", "pymunk"])
def test_fair_profiles_get_what_they_are_asked_for(name):
    readings = card(registry.engine(name))
    assert differing(readings) == set()
    assert {r.name for r in readings.values() if r.verdict == "unread"} == set()


def test_stock_profiles_are_told_apart_by_their_own_numbers():
    bullet, mujoco = (card(registry.engine(f"{name}:stock")) for name in ("pybullet", "mujoco"))
    assert bullet["linear damping at 0.01 m/s"].got == pytest.approx(0.04 * 1.01, rel=1e-2)
    assert bullet["linear damping at 10 m/s"].got == pytest.approx(0.04 * 11.0, rel=2e-2)
    assert bullet["speed cap"].got == pytest.approx(100.0)
    assert mujoco["kinetic friction, diagonal"].got == pytest.approx(0.5 / math.sqrt(2.0), rel=1e-3)
    assert mujoco["restitution at 1 m/s"].got < 0.2
    assert differing(card(registry.engine("pymunk:stock"))) == {"inertia of a sphere"}


def test_the_inertia_asked_for_is_that_of_a_ball():
    ball = next(r for p in PROBES for r in p.readings if r.name == "inertia of a sphere")
    assert ball.asked == pytest.approx(0.4 * 1.0 * 0.1**2)
