"""What the engine notes of its own soundness: energy, momentum, Painlevé's case, chatter; and that it is not blind."""

from __future__ import annotations

import math

import numpy as np
import pytest

from adapters.reference import ENGINES
from adapters.run import run
from mechanics.effects import Force, Friction, Gravity, Resting, Restitution, Rotation
from mechanics.rotation import about, normalised
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Sphere
from reference_impl import audit
from reference_impl.bounces import exchange, line, queue
from reference_impl.settings import Settings
from reference_impl.simulate import advance, begin
from reference_impl.world import STILL

G = 9.81
FLOOR = Body("floor", HalfSpace())


def thrown(e: float, mu: float = 0.0, *more) -> Scene:
    q = tuple(normalised(np.array((0.8, 0.3, 0.4, -0.3))).tolist())
    box = Body("box", Box((0.5, 0.3, 0.2)), 2.0, (0.0, 0.0, 0.7), q, (0.5, 0.0, 0.0), (2.0, 1.0, -3.0))
    return Scene((FLOOR, box), (Gravity(), Rotation(), Restitution(e), Friction(mu), Resting(), *more))


def pushed_rod(degrees: float, mu: float, speed: float = 5.0) -> Scene:
    """A rod of 1 m on its tip, which is pushed towards the side on which the centre lies."""
    angle, thick = math.radians(degrees), 1e-3
    low = -0.5 * (math.sin(angle) + thick * math.cos(angle))
    turn = tuple(about((0.0, 1.0, 0.0), angle).tolist())
    rod = Body("rod", Box((1.0, 0.05, thick)), 1.0, (0.0, 0.0, -low), turn, (speed, 0.0, 0.0))
    return Scene((FLOOR, rod), (Gravity(), Friction(mu), Resting(), Rotation(), Restitution(0.0)))


def test_the_energy_of_a_thrown_box_is_followed_between_events():
    world = begin(thrown(0.4))
    advance(world, 3.0)
    assert world.audit.steps > 3
    assert 0.0 <= world.audit.step_rise <= 1e-10  # of 14 J; steps in lasting contact are good to 1e-12 of a metre
    assert 0.0 <= world.audit.energy_rise <= 1e-11
    assert world.audit.imbalance <= 1e-14


def test_energy_that_comes_from_nowhere_is_seen():
    world = begin(thrown(0.4))
    advance(world, 0.6)
    assert world.audit.impacts > 0
    world.motion.v[1] *= 1.001
    world.launch(1)
    advance(world, 0.6)
    assert world.audit.step_rise > 1e-4


def test_the_work_of_an_applied_force_is_no_rise():
    world = begin(thrown(0.4, 0.0, Force("box", (3.0, 0.0, 0.0), point=(0.0, 0.0, 0.1))))
    advance(world, 1.0)
    assert world.audit.impacts > 3
    assert world.audit.step_rise <= 1e-10


def test_where_the_work_is_not_known_nothing_is_claimed():
    twisted = thrown(0.4, 0.0, Force("box", torque=(0.0, 0.5, 0.0)))
    assert not audit.knows_work(twisted)
    world = begin(twisted)
    advance(world, 0.6)
    assert world.audit.step_rise == 0.0


def test_momentum_that_an_impact_loses_is_seen():
    members, kinds = np.array([0, 1]), np.array([[0, 1]])
    x, point = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]), np.array([[0.5, 0.0, 0.0]])
    v0, momentum = np.array([[1.0, 0.2, 0.0], [0.0, 0.0, 0.0]]), np.zeros((2, 3))
    world = begin(Scene((Body("a", Sphere(0.5), 1.0, (0.0, 0.0, 0.0)), Body("b", Sphere(0.5), 2.0, (1.0, 0.0, 0.0))),
                        (Restitution(1.0), Rotation())))  # fmt: skip
    world.motion.x[:] = x
    for lost, expected in ((0.0, 0.0), (0.1, 0.01)):
        world.motion.v[:] = v0 + np.array([[-4.0 / 3.0, 0.0, 0.0], [2.0 / 3.0 - lost, 0.0, 0.0]])
        impulses = np.array([[-4.0 / 3.0, 0.0, 0.0]])
        found = audit.imbalance(world, members, kinds, point, impulses, v0, momentum)
        assert found <= 1e-16 if expected == 0.0 else found > expected


def rough_gas(mu: float, *more) -> Scene:
    """Twelve spinning spheres of four masses between six walls and round a fixed sphere, no two at the same height."""
    rng = np.random.default_rng(8)
    walls = [Body(f"wall {k}", HalfSpace(tuple(n)), position=tuple(-np.array(n)))
             for k, n in enumerate(np.vstack([np.eye(3), -np.eye(3)]).tolist())]  # fmt: skip
    places = [0.6 * np.array(p) for p in np.ndindex(3, 2, 2)]
    balls = [Body(f"ball {k}", Sphere(0.12 + 0.01 * (k % 3)), 1.0 + k % 4,
                  tuple((p - (0.6, 0.5, 0.4) + 0.02 * rng.normal(size=3)).tolist()),
                  velocity=tuple(rng.normal(size=3).tolist()), angular_velocity=tuple(rng.normal(0, 9, 3).tolist()))
             for k, p in enumerate(places)]  # fmt: skip
    post = Body("post", Sphere(0.1), position=(0.0, -0.2, 0.75))
    return Scene((*walls, post, *balls), (Restitution(0.9), Rotation(), Friction(mu), *more))


@pytest.mark.parametrize("mu", [0.0, 0.4])
def test_isolated_bounces_keep_momentum_to_rounding(mu):
    """Some flops of 1e-16 each for every impact, at most; and never nothing at all, which would be no measurement."""
    world = begin(rough_gas(mu, Gravity()))
    advance(world, 1.0)
    assert world.flock is not None
    assert len(world.events) > 30
    assert 0.0 < world.audit.imbalance <= 1e-15


def test_balls_on_a_line_keep_momentum_to_rounding():
    """Over a stretch of 3141 impacts each rounds by some 1e-16 of what all of them exchange, with either sign."""
    balls = (Body("small", Sphere(0.1), 1.0, (1.0, 0.0, 0.0)),
             Body("great", Sphere(0.1), 1e6, (2.0, 0.0, 0.0), velocity=(-1.0, 0.0, 0.0)))  # fmt: skip
    world = begin(Scene((Body("wall", HalfSpace((1.0, 0.0, 0.0))), *balls), (Restitution(1.0),)))
    advance(world, 10.0)
    assert len(world.events) == 3141
    assert 0.0 < world.audit.imbalance <= 3141**0.5 * 1e-16 * 3.0


def bounced(push, twist):
    """What `exchange.imbalance` says of two spheres that got the impulses ±j of 1 N s along z and, wrongly, more."""
    real, whole = np.zeros((2, queue.REALS)), np.array([0.0, 0.0, 1.0])
    real[:, queue.LIGHT], real[:, queue.RADIUS], real[:, queue.TURN] = (1.0, 0.5), 0.5, 10.0
    was = np.array([[1.0, 2.0, -1.0, 0.1, 0.0, 0.2], [0.0, 1.0, 0.0, 0.0, 0.3, 0.0]])
    real[:, queue.L : queue.L + 3] = was[:, 3:] + np.array([[0.0, 0.0, 0.0], twist])
    at = np.zeros((2, 6))
    at[:, 3:] = was[:, :3] + np.array([whole, -0.5 * whole]) + np.array([[0.0, 0.0, 0.0], push])
    return exchange.imbalance(real, 0, 1, at[0], at[1], whole, whole, was)


def test_momentum_that_an_isolated_bounce_loses_is_seen():
    nothing = (0.0, 0.0, 0.0)
    assert bounced(nothing, nothing) <= 1e-16
    # 2 kg times what was added, of 12 kg m/s before and after; of 6 kg m2/s about the contact and 0.6 of spin
    assert bounced((0.0, 0.0, 0.01), nothing) == pytest.approx(0.02 / 11.98, rel=1e-12)
    assert bounced(nothing, (0.0, 0.01, 0.0)) == pytest.approx(0.01 / 6.6, rel=1e-12)


def test_momentum_that_is_lost_on_a_line_is_seen():
    """Bodies of 1 and 2 kg and a wall, with 3 and 1 N s between them; then the first body is a little off."""
    row, pace = np.zeros((3, line.ROW)), np.array([5.0, 0.0, 0.0])
    row[:, line.MASS], row[:, line.PACE] = (1.0, 0.5, 0.0), (2.0, 1.0, 0.0)
    exchanged = np.array([0.0, 3.0, 1.0, 0.0])
    assert line.lost(row, pace, exchanged) == 0.0
    row[0, line.PACE] += 0.09
    assert line.lost(row, pace, exchanged) == pytest.approx(0.09 / 9.0, rel=1e-14)


def test_bodies_that_come_to_rest_again_are_counted_once():
    box = Body("box", Box((1.0, 1.0, 0.5)), 2.0, (0.0, 0.0, 0.25))
    lifts = [Force("box", (0.0, 0.0, 30.0), start=k + 0.5, end=k + 0.6) for k in range(3)]
    world = begin(Scene((FLOOR, box), (Gravity(), Rotation(), Resting(), Restitution(0.0), *lifts)))
    advance(world, 4.0)
    assert world.mode[1] == STILL
    assert world.audit.rests == 1


def test_painleves_rod_is_on_record_with_names_and_time():
    """At 60 degrees no forces exist beyond µ = (1 + 3 cos²) / (3 sin cos) = 1.347 (Genot and Brogliato 1999)."""
    limit = (1.0 + 3.0 * 0.25) / (3.0 * math.sin(math.radians(60.0)) * 0.5)
    for mu, jams in ((0.98 * limit, False), (1.02 * limit, True), (2.0, True)):
        world = begin(pushed_rod(60.0, mu))
        advance(world, 1e-4)
        found = [i for i in world.incidents if i.what == "painleve"]
        assert bool(found) == jams
        assert world.audit.painleve == len(found)
        if jams:
            assert set(found[0].bodies) == {"rod", "floor"}
            assert found[0].time == 0.0
            assert world.audit.energy_rise <= 1e-12
    told = run(ENGINES["reference"], pushed_rod(60.0, 2.0), (0.0, 1e-3)).audit
    assert told["painleve"] >= 1.0
    assert any(name.startswith("painleve of ") and "rod" in name for name in told)


def test_chatter_is_stopped_and_recorded(monkeypatch):
    """With a budget so small that an ordinary box exceeds it: it still comes to rest, and energy does not rise."""
    monkeypatch.setattr(audit, "CHATTER", 3)
    world = begin(thrown(0.7, 0.4))
    advance(world, 6.0)
    assert world.audit.chatter >= 1
    assert next(i.bodies for i in world.incidents if i.what == "chatter") == ("box",)
    assert world.mode[1] == STILL
    assert world.state().x[1, 2] == pytest.approx(0.1, abs=1e-9)


def test_impacts_are_no_chatter():
    """An elastic ball in a narrow gap: thousands of impacts in a moment."""
    walls = (Body("left", HalfSpace((1.0, 0.0, 0.0)), position=(-0.1001, 0.0, 0.0)),
             Body("right", HalfSpace((-1.0, 0.0, 0.0)), position=(0.1001, 0.0, 0.0)))  # fmt: skip
    ball = Body("ball", Sphere(0.1), 1.0, velocity=(1.0, 0.0, 0.0))
    world = begin(Scene((*walls, ball), (Restitution(1.0), Resting())))
    advance(world, 0.2)
    assert len(world.events) == 1000
    assert world.audit.chatter == 0
    assert abs(world.state().v[2, 0]) == 1.0


@pytest.mark.parametrize("model", ["pyramid", "convex"])
def test_simpler_cones_show_their_error_at_an_impact(model):
    """A ball that lands sliding at 37 degrees from the corners of a square, e = 0, µ = 0.2."""
    speed, fall = 3.0, 2.0
    way = np.array([math.cos(math.radians(37.0)), math.sin(math.radians(37.0)), 0.0])
    ball = Body("ball", Sphere(0.1), 1.0, (0.0, 0.0, 0.3), velocity=tuple((speed * way - [0.0, 0.0, fall]).tolist()))
    scene = Scene((FLOOR, ball), (Restitution(0.0), Friction(0.2), Resting()))
    ends = {}
    for choice in ("exact", model):
        world = begin(scene, Settings(friction=choice))
        advance(world, 0.11)
        ends[choice] = world.state().v[1]
        assert world.audit.friction_residual <= 1e-12
    assert ends["exact"] == pytest.approx((speed - 0.2 * fall) * way, abs=1e-14)
    if model == "pyramid":  # friction along a corner alone: slip turns away from it
        assert ends[model] == pytest.approx(speed * way - [0.2 * fall, 0.0, 0.0], abs=1e-12)
    else:  # what slides lifts off at µ times its slip, v = (s - µ w) / (1 + µ²)
        slip = (speed - 0.2 * fall) / 1.04
        assert ends[model] == pytest.approx(slip * way + [0.0, 0.0, 0.2 * slip], abs=1e-12)
