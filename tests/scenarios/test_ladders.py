"""Ladders are data: every rung is a scenario or a setting, with its own label and a demand that can fail."""

import pytest

from scenarios import catalogue, ladder
from scenarios.ladder import STABLE, Ladder
from scenarios.scenario import Scenario

EVERY = tuple(ladder.ladders().values())
ASKED = (
    "mass-ratio", "stack-height", "stack-height-small", "step-size", "spin", "wall-speed", "tumbling-time", "overlap",
    "units-smaller", "units-larger", "landing-tilt", "chain-length", "near-elastic", "friction-margin",
)  # fmt: skip


def test_every_difficulty_that_is_asked_for_is_there():
    assert set(ASKED) <= set(ladder.ladders())


@pytest.mark.parametrize("one", EVERY, ids=lambda one: one.name)
class TestEveryLadder:
    def test_rungs_are_scenarios_that_demand_stability(self, one):
        for rung in one.rungs:
            scenario = one.scenario(rung)
            assert isinstance(scenario, Scenario)
            assert STABLE in scenario.checks
            (found,) = catalogue.find(scenario.name if "[" in scenario.name else f"{scenario.name}[]")
            assert found.scene == scenario.scene

    def test_rungs_differ(self, one):
        asked = {(one.scenario(r).name, *one.settings(r).items()) for r in one.rungs}
        assert len(asked) == len(one.rungs)

    def test_ratios_of_rungs_are_no_leap(self, one):
        steps = [max(a / b, b / a) for a, b in zip(one.rungs, one.rungs[1:], strict=False)]
        assert all(1.5 <= step <= 1000.0 for step in steps)
        assert len(one.rungs) >= 4

    def test_rungs_between_are_scenarios_too(self, one):
        for a, b in zip(one.rungs, one.rungs[1:], strict=False):
            middle = one.between(a, b)
            if middle is not None:
                assert one.scenario(middle).name not in (
                    {one.scenario(r).name for r in (a, b)} if one.parameter else ()
                )

    def test_it_says_what_it_raises(self, one):
        assert len(one.raises) > 10
        assert one.unit in ("1", "s", "m/s", "rad/s", "deg")


def test_finding():
    assert [one.name for one in ladder.find(["stack-*"])] == ["stack-height", "stack-height-small"]
    assert ladder.find() == EVERY
    with pytest.raises(catalogue.UnknownName, match="did you mean mass-ratio"):
        ladder.find(["mas-ratio"])


@pytest.mark.parametrize("wrong", [
    {"parameter": "count", "knob": "dt"}, {"parameter": ""}, {"rungs": (1, 3, 2)}, {"rungs": (0, 1, 2)},
], ids=str)  # fmt: skip
def test_a_ladder_that_cannot_be_climbed_cannot_be_made(wrong):
    told = {"name": "x", "raises": "y", "unit": "1", "family": "tower", "rungs": (1, 2), "parameter": "count"}
    with pytest.raises(ValueError, match="ladder 'x'"):
        Ladder(**(told | wrong))
