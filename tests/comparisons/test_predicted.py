"""What a scheme costs is known before it runs, and what is left is the doing of something else."""

from dataclasses import replace

import numpy as np
import pytest

from adapters import registry
from adapters.run import run, sample_times
from comparisons import accuracy, energy, predicted
from comparisons.measurement import Case
from comparisons.textbook import drop_of, mean_square_energy_error, stepped
from mechanics.effects import Gravity, Resting, Restitution
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Sphere
from mechanics.trajectory import Trajectory
from scenarios import catalogue

FLOOR = Body("floor", HalfSpace())
BALL = Body("ball", Sphere(0.1), 1.0, (0.0, 0.0, 1.1))


def ledger(engine, selector, settings=None):
    if engine != "reference":
        pytest.importorskip(engine.partition(":")[0])
    (scenario,) = catalogue.find(selector)
    found = run(registry.engine(engine), scenario.scene, sample_times(scenario.duration, scenario.sampling), settings)
    case = Case(scenario, found, found.trajectory)
    return {q.name: q.value for part in (accuracy, energy, predicted) for q in part.measure(case)}


# engines whose scheme is a textbook one: their whole error is foretold, to rounding


@pytest.mark.parametrize("dt", [1e-2, 1e-3])
@pytest.mark.parametrize("engine", ["pybullet", "pymunk"])
@pytest.mark.parametrize("e", ["0.3", "0.8", "1.0"])
def test_stepping_engines_bounce_as_their_scheme_must(engine, e, dt):
    found = ledger(engine, f"bouncing-ball[e={e}]", {"dt": dt})
    assert found["position error"] == pytest.approx(found[predicted.CONTACT], abs=1e-13)
    assert found[predicted.SOLVER] < 1e-13
    assert found["position error"] > 1e-4


def test_the_contact_of_mujoco_is_not_quite_ideal():
    found = ledger("mujoco", "bouncing-ball[]")
    assert 1e-8 < found[predicted.SOLVER] < 1e-5
    assert found["position error"] == pytest.approx(found[predicted.CONTACT], rel=1e-3)


@pytest.mark.parametrize("engine", ["pybullet", "pymunk"])
def test_what_a_sliding_block_is_off_by_is_time_stepping(engine):
    found = ledger(engine, "sliding-block[]")
    assert found["position error"] == pytest.approx(found[predicted.STEPPING], rel=1e-3)
    assert found[predicted.LEFT] < 1e-3 * found["position error"]


@pytest.mark.parametrize(
    ("engine", "settings"), [("pybullet", None), ("pymunk", None), ("mujoco", {"integrator": "Euler"})]
)
def test_energy_that_comes_and_goes_is_that_of_the_time_levels(engine, settings):
    found = ledger(engine, "projectile[]", settings)
    assert found["energy error"] == pytest.approx(found[predicted.ENERGY], rel=1e-2)
    assert found["energy error, synchronised"] < 1e-10
    assert found["position error"] == pytest.approx(found[predicted.STEPPING], rel=1e-9)


def test_runge_kutta_and_the_reference_have_nothing_to_foretell():
    for engine in ("mujoco", "reference"):
        found = ledger(engine, "free-fall[]")
        assert found[predicted.STEPPING] == 0.0
        assert found["position error"] < 1e-12
        assert predicted.LEFT not in found


def test_damping_is_no_error_of_time_stepping():
    found = ledger("pybullet:stock", "free-fall[]")
    assert found[predicted.LEFT] > 10.0 * found[predicted.STEPPING]


# the textbook itself


@pytest.mark.parametrize("drift_first", [False, True])
def test_a_stepped_drop_falls_as_its_sums_say(drift_first):
    drop, h, n = drop_of(Scene((FLOOR, BALL), (Gravity(), Restitution(0.5)))), 1e-3, np.arange(400)
    gap, rise = stepped(drop, h, drift_first, n)
    ahead = -1.0 if drift_first else 1.0
    np.testing.assert_allclose(gap, 1.0 - 9.81 * h**2 * n * (n + ahead) / 2.0, atol=1e-12)
    np.testing.assert_allclose(rise, -9.81 * h * n, atol=1e-12)


@pytest.mark.parametrize("drift_first", [False, True])
def test_the_mean_square_of_an_elastic_drop_is_that_of_the_formula(drift_first):
    drop, h, lead = drop_of(Scene((FLOOR, BALL), (Gravity(), Restitution(1.0)))), 1e-3, -5e-4 if drift_first else 5e-4
    n = np.arange(40_000)
    gap, rise = stepped(drop, h, drift_first, n)
    error = 0.5 * rise**2 + 9.81 * (gap - drop.clearance)
    assert np.mean(error**2) == pytest.approx(mean_square_energy_error(drop, h), rel=0.01)
    assert abs(np.mean(0.5 * rise**2 + 9.81 * (gap - lead * rise - drop.clearance))) < 1e-3 * np.abs(error).max()


def test_a_later_impact_or_another_coefficient_is_seen():
    scene = Scene((FLOOR, BALL), (Gravity(), Restitution(0.8)))
    drop, n = drop_of(scene), np.arange(1500)
    right, _ = stepped(drop, 1e-3, False, n)
    for wrong in (drop._replace(e=0.801), drop._replace(clearance=1.001)):
        assert np.abs(stepped(wrong, 1e-3, False, n)[0] - right).max() > 1e-4


@pytest.mark.parametrize(
    "other",
    [
        Scene((FLOOR, replace(BALL, velocity=(0.0, 0.0, 1.0))), (Gravity(), Restitution(0.8))),
        Scene((FLOOR, replace(BALL, shape=Box((0.2, 0.2, 0.2)))), (Gravity(), Restitution(0.8))),
        Scene((FLOOR, BALL), (Gravity(), Restitution(0.8), Resting())),
        Scene((FLOOR, BALL), (Gravity((1.0, 0.0, -9.81)), Restitution(0.8))),
        Scene((FLOOR, BALL, replace(BALL, name="other", position=(0.15, 0.0, 1.1))), (Gravity(), Restitution(0.8))),
        Scene((FLOOR, BALL, replace(BALL, name="other", position=(3.0, 0.0, 1.2))), (Gravity(), Restitution(0.8))),
        Scene((BALL,), (Gravity(), Restitution(0.8))),
    ],
)
def test_only_drops_on_a_level_floor_are_foretold(other):
    assert drop_of(other) is None


def test_a_motion_without_truth_is_not_foretold(case_of):
    scene = Scene((BALL, Body("post", Sphere(0.1))), (Gravity(), Restitution(0.5)))
    start = scene.start()
    still = Trajectory.of([start, replace(start, t=1.0)])
    assert list(predicted.measure(case_of(scene, still, lead=5e-4))) == []
