"""Laws that hold for every scenario of the catalogue, in every variant."""

from __future__ import annotations

import inspect
import math

import numpy as np
import pytest

from adapters.run import Run, sample_times
from comparisons import accuracy, energy, exhibits, momentum, penetration, rest, restitution, stability
from comparisons.measurement import Case
from mechanics.rotation import angle_between
from scenarios import catalogue
from scenarios.scenario import Scenario
from scenarios.tolerance import STEP

EVERY = [s for family in catalogue.families().values() for s in family.all()]
KNOWN = [s for s in EVERY if s.truth is not None]
JUDGES = (accuracy, energy, exhibits, momentum, penetration, rest, restitution, stability)


def label(scenario: Scenario) -> str:
    return scenario.name


def times(scenario: Scenario) -> np.ndarray:
    """Sample times, thinned out where every step of a long run is sampled."""
    return sample_times(scenario.duration, max(scenario.sampling, scenario.duration / 1000.0))


@pytest.mark.parametrize("scenario", EVERY, ids=label)
class TestEveryScenario:
    def test_is_found_by_its_label(self, scenario):
        label = scenario.name if "[" in scenario.name else f"{scenario.name}[]"
        (found,) = catalogue.find(label)
        assert found.name == scenario.name
        assert found.scene == scenario.scene

    def test_says_what_it_is_about(self, scenario):
        first, *rest_of_it = scenario.summary.splitlines()
        assert first.endswith((".", "?"))
        assert any(line.strip() for line in rest_of_it), "one line does not tell a newcomer what is at stake"
        assert len(scenario.source) > 15
        assert set(scenario.about) <= scenario.scene.needs
        assert scenario.about

    def test_gives_a_reason_for_every_tolerance(self, scenario):
        assert scenario.checks
        for check in scenario.checks:
            assert len(check.why) > 20
            assert 0.0 < check.exact < check.tolerance < math.inf
        quantities = [check.quantity for check in scenario.checks]
        assert len(set(quantities)) == len(quantities)

    def test_demands_only_quantities_that_are_measured(self, scenario):
        measured = {name for judge in JUDGES for name in judge.QUANTITIES}
        assert {check.quantity for check in scenario.checks} <= measured

    def test_starts_without_overlap(self, scenario):
        start = scenario.scene.start()
        still = Run("start", "", {}, _repeated(scenario, start))
        for quantity in penetration.measure(Case(scenario, still, still.outcome)):
            assert quantity.value == pytest.approx(0.0, abs=1e-15)

    def test_samples_at_least_ten_times(self, scenario):
        assert scenario.duration >= 10.0 * scenario.sampling

    def test_events_lie_within_it(self, scenario):
        assert all(0.0 < t < scenario.duration for t in scenario.events)


@pytest.mark.parametrize("scenario", KNOWN, ids=label)
class TestEveryTruth:
    def test_starts_as_the_scene_does(self, scenario):
        truth, start = scenario.truth(np.array([0.0])), scenario.scene.start()
        for name in ("x", "v", "w"):
            np.testing.assert_allclose(getattr(truth, name)[0], getattr(start, name), atol=1e-12)
        assert np.max(angle_between(truth.q[0], start.q)) < 1e-12

    def test_is_finite_with_unit_quaternions(self, scenario):
        truth = scenario.truth(times(scenario))
        assert all(np.isfinite(getattr(truth, name)).all() for name in ("x", "q", "v", "w"))
        np.testing.assert_allclose(np.linalg.norm(truth.q, axis=-1), 1.0, atol=1e-14)

    def test_velocities_are_the_derivatives_of_places(self, scenario):
        d = 1e-5
        t = np.linspace(2 * d, scenario.duration - 2 * d, 101)
        t = t[(np.abs(t[:, None] - np.array([*scenario.events, -1.0])) > 2 * d).all(axis=1)]
        before, now, after = (scenario.truth(s) for s in (t - d, t, t + d))
        np.testing.assert_allclose((after.x - before.x) / (2 * d), now.v, atol=1e-6)
        turned = angle_between(before.q, after.q) / (2 * d)
        np.testing.assert_allclose(turned, np.linalg.norm(now.w, axis=-1), atol=1e-5)

    def test_stays_in_the_plane_of_a_planar_scene(self, scenario):
        if scenario.scene.out_of_plane() is None:
            truth = scenario.truth(times(scenario))
            level = scenario.scene.start().x[:, 1]
            assert np.array_equal(truth.x[:, :, 1], np.broadcast_to(level, truth.x.shape[:2]))
            assert not truth.v[:, :, 1].any()
            assert not truth.w[:, :, [0, 2]].any()

    def test_is_judged_exact(self, scenario):
        """Handed in as if an engine had computed it, the truth passes every check to rounding."""
        t = times(scenario)
        case = Case(scenario, Run("truth", "", {"dt": STEP}, scenario.truth(t)), scenario.truth(t))
        found = {q.name: q.value for judge in JUDGES for q in judge.measure(case)}
        for check in scenario.checks:
            assert found[check.quantity] <= check.exact, f"{check.quantity} = {found[check.quantity]}"

    def test_keeps_what_its_scene_keeps(self, scenario):
        """Energy and momenta, as far as the declared effects leave them alone, whether they are demanded or not."""
        t = times(scenario)
        case = Case(scenario, Run("truth", "", {"dt": STEP}, scenario.truth(t)), scenario.truth(t))
        found = {q.name: q.value for judge in (energy, momentum) for q in judge.measure(case)}
        for law in ("energy error", "energy rise", "linear momentum error", "angular momentum error"):
            assert not found.get(law, 0.0) > 1e-9, law


def test_builders_are_short_and_names_are_whole_words():
    for name, family in catalogue.families().items():
        assert len(inspect.getsource(family.build).splitlines()) <= 40, f"{name} is longer than 40 lines"
        assert name == family.build.__name__.replace("_", "-")


def test_the_standard_suite_is_affordable():
    suite = catalogue.suite("standard")
    assert len({s.family for s in suite}) >= 15
    assert sum(s.duration * len(s.scene.moving) for s in suite) < 400.0  # body seconds
    assert all(s.duration / s.sampling <= 500 for s in suite)


def test_the_smoke_suite_touches_every_effect_that_the_standard_suite_touches():
    def effects(name):
        return set().union(*(s.scene.needs for s in catalogue.suite(name)))

    assert effects("smoke") == effects("standard")
    assert sum(s.duration for s in catalogue.suite("smoke")) < 20.0


def test_most_of_the_standard_suite_is_planar():
    suite = catalogue.suite("standard")
    assert sum(s.scene.out_of_plane() is None for s in suite) > 0.7 * len(suite)


def _repeated(scenario, state):
    from mechanics.trajectory import State, Trajectory

    return Trajectory.of([State(t, state.x, state.q, state.v, state.w) for t in (0.0, 1.0)])
