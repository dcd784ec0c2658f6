"""Finding scenarios: selectors, suites, parameters and the errors that name what there is."""

from __future__ import annotations

import pytest

from scenarios import catalogue
from scenarios.catalogue import UnknownName


def test_a_bare_name_gives_every_variant_the_default_first():
    found = catalogue.find("bouncing-ball")
    assert found[0].name == "bouncing-ball"
    assert {s.parameters["e"] for s in found} == {0.3, 0.5, 0.7, 0.8, 0.9, 1.0}


def test_a_glob_gives_every_family_it_matches():
    assert {s.family for s in catalogue.find("*cradle*")} == {"newtons-cradle", "three-cradles", "touching-cradle"}


def test_parameters_give_one_scenario_with_its_own_scene():
    (found,) = catalogue.find("head-on-collision[mass_ratio=50, e=0.25]")
    assert found.name == "head-on-collision[mass_ratio=50,e=0.25]"
    assert [b.mass for b in found.scene.bodies] == [1.0, 50.0]
    assert found.parameters == {"mass_ratio": 50.0, "e": 0.25}


@pytest.mark.parametrize(
    ("selector", "said"),
    [
        ("bouncing-bal", "did you mean bouncing-ball"),
        ("bouncing-ball[e=2]", "allowed: 0.1 to 1.0"),
        ("bouncing-ball[bounce=0.5]", "no parameter 'bounce'; it has e, clearance"),
        ("bouncing-ball[0.5]", "not of the form parameter=value"),
        ("tumbling-box[axis=short]", "allowed: middle, largest, smallest"),
    ],
)
def test_selectors_that_select_nothing_say_what_there_is(selector, said):
    with pytest.raises(ValueError, match=said.replace("[", r"\[")):
        catalogue.find(selector)


def test_suites():
    assert set(catalogue.suites()) >= {"smoke", "standard", "published"}
    smoke = catalogue.suite("smoke")
    assert all("[" not in s.name for s in smoke)  # the default variant of each family only
    with pytest.raises(UnknownName, match="standard"):
        catalogue.suite("standart")


def test_the_families_everybody_expects_are_there():
    wanted = """free-fall projectile bouncing-ball head-on-collision oblique-collision newtons-cradle touching-cradle
        tumbling-box flat-drop corner-drop random-boxes sliding-block incline sliding-to-rolling resting-box stack
        simbenchmark-bouncing gazebo-boxes"""
    assert set(wanted.split()) <= set(catalogue.families())
