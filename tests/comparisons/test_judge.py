"""The judge: answer keys pass their own exam, broken answers do not, real engines get what they deserve."""

import sys
from dataclasses import replace
from types import ModuleType

import numpy as np
import pytest

import comparisons.judge as judge_module
from adapters import registry
from adapters.engine import Refusal
from adapters.run import Failure, Run, Timing, run, sample_times
from comparisons.cell import STATES, cell_from_json, cell_to_json
from comparisons.judge import describe_quantities, judge, to_cell
from comparisons.measurement import Case, Quantity
from mechanics.scene import Scene
from mechanics.trajectory import Trajectory
from scenarios.catalogue import families, find
from scenarios.scenario import Check

PUBLISHED = ("gazebo-boxes", "simbenchmark-bouncing")  # long runs at every step: in the table of published figures
KEYS = [s for name, f in families().items() if name not in PUBLISHED for s in f.all() if s.truth is not None]


def answer(scenario, motion=None, **told):
    if motion is None:
        motion = scenario.truth(sample_times(scenario.duration, scenario.sampling))
    return Run("key", "1", {}, motion, **told)


@pytest.mark.parametrize("scenario", KEYS, ids=lambda s: s.name)
def test_every_answer_key_passes_its_own_exam_to_rounding(scenario):
    said = judge(scenario, answer(scenario))
    assert said.state == "ok", said.reason
    assert {m.verdict for m in said.measurements} <= {"exact", "info"}
    for m in said.measurements:
        if m.quantity.startswith(("energy error", "energy rise", "linear momentum", "angular momentum", "penetration")):
            assert m.value < 1e-12, m


@pytest.mark.parametrize("name", ["bouncing-ball", "tumbling-box", "newtons-cradle", "sliding-to-rolling", "flat-drop"])
def test_a_wrong_answer_fails(name):
    """The key a tenth of a second late is no answer."""
    scenario = find(name)[0]
    t = sample_times(scenario.duration, scenario.sampling)
    late = scenario.truth(np.maximum(t - 0.1, 0.0))
    said = judge(scenario, answer(scenario, Trajectory(t, late.x, late.q, late.v, late.w)))
    assert (said.state, said.stage) == ("fail", "judge")
    assert "exceeds" in said.reason


@pytest.mark.parametrize("field", ["x", "q", "v", "w"])
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_nan_never_passes(field, bad):
    scenario = find("free-fall")[0]
    motion = scenario.truth(sample_times(scenario.duration, scenario.sampling))
    arrays = {name: np.array(getattr(motion, name)) for name in ("x", "q", "v", "w")}
    arrays[field][40, 0, 1] = bad
    said = judge(scenario, answer(scenario, Trajectory(motion.t, **arrays)))
    assert (said.state, said.stage) == ("diverged", "read")
    assert "0.4 s" in said.reason
    assert {m.verdict for m in said.measurements} == {"info"}
    arrays[field][0] = bad
    assert judge(scenario, answer(scenario, Trajectory(motion.t, **arrays))).measurements == ()


@pytest.mark.parametrize("state", ["diverged", "error", "crash", "timeout", "oom"])
def test_a_broken_run_is_measured_as_far_as_it_got(state):
    scenario = find("bouncing-ball")[0]
    partial = scenario.truth(sample_times(scenario.duration, scenario.sampling)).until(30)
    broken = Run("key", "1", {}, Failure(state, "advance", 0.29, "because"), partial=partial)
    cell = to_cell(scenario, broken)
    assert (cell.state, cell.stage, cell.reason, cell.time) == (state, "advance", "because", 0.29)
    assert cell.of("position error").verdict == "info"
    nothing = Run("key", "1", {}, Failure(state, "build", 0.0, "because"))
    assert to_cell(scenario, nothing).measurements == ()
    one = Run("key", "1", {}, Failure(state, "advance", 0.0, "because"), partial=partial.until(1))
    assert judge(scenario, one).state == state


def test_a_refusal_is_an_outcome():
    cell = to_cell(find("bouncing-ball")[0], Run("key", "1", {}, Refusal("no such thing")))
    assert (cell.state, cell.reason, cell.measurements) == ("refused", "no such thing", ())


def test_verdicts(scenario_of):
    scenario = find("free-fall")[0]
    t = sample_times(1.0, 0.1)
    true = scenario.truth(t)
    off = Trajectory(t, true.x + 1e-3 * np.array([0.0, 1.0, 0.0]), true.q, true.v, true.w)
    for tolerance, exact, verdict in ((1e-2, 1e-2, "exact"), (1e-2, 1e-9, "ok"), (1e-4, 1e-9, "fail")):
        check = Check("position error", tolerance, "by hand", exact)
        demanding = scenario_of(scenario.scene, 1.0, truth=scenario.truth, checks=(check,))
        cell = to_cell(demanding, answer(demanding, off))
        assert cell.of("position error").verdict == verdict
        assert cell.of("position error").why == "by hand"
        assert cell.of("velocity error").verdict == "info"
        assert cell.state == ("fail" if verdict == "fail" else "ok")
    assert cell.state in STATES


@pytest.mark.parametrize(
    ("quantity", "word"),
    [("no such thing", "no such quantity"), ("penetration", "does not apply"), ("angular momentum error", "not turn")],
)
def test_what_cannot_be_measured_is_the_houses_fault(scenario_of, quantity, word):
    scenario = find("free-fall")[0]
    demanding = scenario_of(scenario.scene, 1.0, quantity, truth=scenario.truth)
    cell = to_cell(demanding, answer(scenario))
    assert (cell.state, cell.stage, cell.of(quantity).verdict) == ("error", "judge", "unmeasured")
    assert word in cell.reason


@pytest.fixture
def another_comparison(monkeypatch):
    """A comparison added by putting one module into the package."""

    def add(measure, **quantities):
        module = ModuleType("comparisons.invented")
        module.QUANTITIES, module.measure = quantities, measure
        monkeypatch.setitem(sys.modules, "comparisons.invented", module)
        found = (*judge_module._comparisons(), module)
        monkeypatch.setattr(judge_module, "_comparisons", lambda: found)
        describe_quantities.cache_clear()

    yield add
    describe_quantities.cache_clear()


def test_a_comparison_that_breaks_breaks_what_it_was_asked_for_only(another_comparison, scenario_of):
    def measure(case):
        yield Quantity("luck", 1.0, "1")
        raise ZeroDivisionError("of all things")

    another_comparison(measure, luck=("1", "pure"), fate=("1", "what will be"))
    scenario = find("free-fall")[0]
    assert judge(scenario, answer(scenario)).state == "ok"
    demanding = scenario_of(scenario.scene, 1.0, "fate", truth=scenario.truth)
    said = judge(demanding, answer(scenario))
    assert (said.state, said.stage) == ("error", "judge")
    assert "ZeroDivisionError: of all things" in said.reason
    assert next(m for m in said.measurements if m.quantity == "luck").value == 1.0


def test_two_comparisons_cannot_define_the_same_quantity(another_comparison):
    another_comparison(lambda case: iter(()), penetration=("m", "again"))
    with pytest.raises(ValueError, match="'penetration' is defined by"):
        describe_quantities()


def test_every_quantity_says_what_it_is():
    rows = describe_quantities()
    assert {"position error", "energy error, synchronised", "restitution error", "penetration"} <= {
        r.name for r in rows
    }
    assert all(row.meaning and row.comparison for row in rows)


def test_what_is_measured_is_described():
    units = {row.name: row.unit for row in describe_quantities()}
    for scenario in KEYS[:: len(KEYS) // 6]:
        for m in judge(scenario, answer(scenario)).measurements:
            assert units[m.quantity] == m.unit


def test_a_cell_holds_what_the_run_was(scenario_of):
    scenario = find("bouncing-ball")[0]
    timing = Timing(np.full((3, 10), 1_000_000), np.array([10_000_000] * 3), ("a", "a", "a"))
    cell = to_cell(scenario, answer(scenario, timing=timing), trace="traces/x.npz", reproduce="plumbline run x")
    assert cell.cost == pytest.approx(0.01 / scenario.duration, rel=1e-2)
    assert (cell.repeats, cell.deterministic, cell.impacts) == (3, True, -1)
    assert (cell.trace, cell.reproduce, cell.family) == ("traces/x.npz", "plumbline run x", "bouncing-ball")
    again = cell_from_json(cell_to_json(cell))
    assert (again.key, again.state, len(again.measurements)) == (cell.key, "ok", len(cell.measurements))


@pytest.mark.parametrize("name", ["newtons-cradle", "head-on-collision", "stack", "oblique-collision"])
def test_the_order_of_the_bodies_changes_nothing(name):
    """A seeded defect is measured alike whatever the order in which the bodies are listed."""
    scenario = find(name)[0]
    motion = scenario.truth(sample_times(scenario.duration, scenario.sampling))
    rng = np.random.default_rng(5)
    noise = 1e-3 * rng.normal(size=motion.x.shape)
    noise[:, [i for i, b in enumerate(scenario.scene.bodies) if b.fixed]] = 0.0
    order = list(reversed(range(len(scenario.scene.bodies))))
    found = []
    for rows in (list(range(len(order))), order):
        scene = Scene(tuple(scenario.scene.bodies[i] for i in rows), scenario.scene.effects)
        arrays = [getattr(motion, kind)[:, rows] for kind in "xqvw"]
        arrays[0], arrays[2] = arrays[0] + noise[:, rows], arrays[2] + noise[:, rows]
        case = Case(_reordered(scenario, scene, rows), answer(scenario), Trajectory(motion.t, *arrays))
        found.append({q.name: q.value for q in judge_module._measured(case)})
    assert found[0].keys() == found[1].keys()
    for quantity, value in found[0].items():
        assert found[1][quantity] == pytest.approx(value, rel=1e-9, abs=1e-12, nan_ok=True)


def _reordered(scenario, scene, rows):
    def truth(t):
        known = scenario.truth(t)
        return Trajectory(t, *(getattr(known, kind)[:, rows] for kind in "xqvw"))

    return replace(scenario, scene=scene, truth=truth)


# Real engines.  One cell each: that the figures are those of the facts measured before this code was written.


def measured(engine, selector, settings=None):
    pytest.importorskip(engine.partition(":")[0])
    scenario = find(selector)[0]
    times = sample_times(scenario.duration, max(scenario.sampling, 0.005))
    outcome = run(registry.engine(engine), scenario.scene, times, settings)
    return {m.quantity: m for m in judge(scenario, outcome).measurements}


def test_the_gazebo_figures_of_explicit_euler():
    """Published for ODE at a step of 1 ms: energy 0.012462, angular momentum 0.0130708, position 0.049 m."""
    found = measured("mujoco", "gazebo-boxes", {"dt": 1e-3, "integrator": "Euler"})
    assert found["relative energy error"].value == pytest.approx(0.012462, abs=5e-7)
    assert found["relative angular momentum error"].value == pytest.approx(0.0130708, rel=1e-4)
    assert found["position error"].value == pytest.approx(0.049, rel=1e-6)
    assert found["predicted position error"].value == pytest.approx(0.049, rel=1e-9)


def test_stock_pybullet_loses_restitution_and_the_fair_profile_does_not():
    fair, stock = measured("pybullet", "bouncing-ball"), measured("pybullet:stock", "bouncing-ball[e=0.5]")
    assert fair["restitution error"].verdict == "ok"
    assert stock["restitution error"].verdict == "fail"


def test_a_spring_contact_without_restitution_rebounds_with_an_eighth():
    found = measured("mujoco:stock", "bouncing-ball")
    assert found["restitution"].value == pytest.approx(0.125, abs=0.01)


def test_touching_balls_in_pybullet_follow_the_simultaneous_law():
    assert measured("pybullet", "touching-cradle")["impact law"].text == "simultaneous"
