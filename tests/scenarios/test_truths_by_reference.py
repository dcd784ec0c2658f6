"""Every truth beyond the standard suite by a second route: the reference engine, which shares no code with it."""

from __future__ import annotations

import pytest

from adapters.registry import engine
from adapters.run import run, sample_times
from comparisons.judge import judge
from mechanics.effects import Friction, Resting
from scenarios import catalogue

STANDARD = {s.family for name in ("standard", "published") for s in catalogue.suite(name)}
REFERENCE = engine("reference")
MORE = [s for s in catalogue.suite("full") if s.family not in STANDARD and s.scene.needs <= set(REFERENCE.effects)]


def costly(scenario):
    """Whether contacts with friction last, which the engine solves step by step."""
    return {Friction, Resting} <= scenario.scene.needs


def exactly(scenario):
    """Every check that the reference does not pass to rounding, with its value."""
    result = run(REFERENCE, scenario.scene, sample_times(scenario.duration, scenario.sampling), repeats=1)
    said = judge(scenario, result)
    assert said.state == "ok", said.reason
    demanded = [m for m in said.measurements if m.verdict != "info"]
    assert len(demanded) == len(scenario.checks)
    return {m.quantity: m.value for m in demanded if m.verdict != "exact"}


@pytest.mark.parametrize("scenario", [s for s in MORE if not costly(s)], ids=lambda s: s.name)
def test_the_reference_is_exact(scenario):
    assert exactly(scenario) == {}


@pytest.mark.long
@pytest.mark.parametrize("scenario", [s for s in MORE if costly(s)], ids=lambda s: s.name)
def test_the_reference_is_exact_where_contacts_with_friction_last(scenario):
    assert exactly(scenario) == {}
