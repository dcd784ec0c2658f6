"""Every truth beyond the standard suite by a second route: the reference engine, which shares no code with it."""

from __future__ import annotations

import pytest

from adapters.registry import engine
from adapters.run import run, sample_times
from comparisons.judge import judge
from mechanics.effects import Friction, Hinge, Resting, Rod
from mechanics.shapes import Mesh
from scenarios import catalogue

STANDARD = {s.family for name in ("standard", "published") for s in catalogue.suite(name)}
REFERENCE = engine("reference")
MORE = [s for s in catalogue.suite("full") if s.family not in STANDARD and s.scene.needs <= set(REFERENCE.effects)]


def costly(scenario):
    """Whether contacts with friction last, or joints hold: motion that the engine integrates step by step."""
    return {Friction, Resting} <= scenario.scene.needs or bool({Rod, Hinge, Mesh} & _parts(scenario.scene))


def _parts(scene):
    return scene.needs | {type(body.shape) for body in scene.bodies}


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
def test_the_reference_is_exact_where_it_integrates(scenario):
    assert exactly(scenario) == {}
