"""Every scenario: what it does not declare changes nothing, and what it declares does, or it says what that is for."""

import pytest

from adapters.registry import engine
from comparisons.effects import prove
from comparisons.variants import VALUED
from mechanics.effects import CONTACT_EFFECTS, EFFECTS, Rotation
from reports.effects import ACTS
from scenarios import catalogue

REFERENCE = engine("reference")
SAME = ("same", "same until")


def wrong(scenario, budget):
    """What speaks against the declaration of a scenario, in words; from as much of it as the budget allows."""
    proof = prove(REFERENCE, scenario, budget, clock=0.0)
    assert not proof.reason, proof.reason
    found = []
    for row in proof.rows:
        kind = EFFECTS.get(row.effect)
        told = kind in scenario.because
        later = row.verdict == "same until" and not proof.whole
        if row.declared and row.verdict not in ACTS and not (told or later):
            found.append(f"{row.effect} is declared and does nothing: {row}")
        if not row.declared and row.verdict not in SAME:
            found.append(f"{row.effect} is not declared and changes the motion: {row}")
    return found


@pytest.mark.parametrize("scenario", catalogue.suite("smoke"), ids=lambda s: s.name)
def test_the_smoke_suite_declares_what_it_needs(scenario):
    assert not wrong(scenario, budget=0.1)


@pytest.mark.long
@pytest.mark.parametrize("scenario", catalogue.suite("full"), ids=lambda s: s.name)
def test_every_scenario_declares_what_it_needs(scenario):
    assert not wrong(scenario, budget=2.0)


def test_every_effect_is_idle_by_its_value_or_for_a_reason():
    assert set(VALUED) | {Rotation, *CONTACT_EFFECTS} == set(EFFECTS.values())


def test_reasons_are_given_for_effects_that_a_variant_declares():
    for family in catalogue.families().values():
        declared = set().union(*(s.scene.needs for s in family.all()))
        assert set(family.because) <= declared, family.name
        assert all(len(why) > 40 for why in family.because.values())
