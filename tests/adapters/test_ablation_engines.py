"""Engines between stock and fair: none of the settings is stock, all of them are fair, bit by bit."""

import pytest

from adapters import registry
from adapters.ablation import ENGINES, LIBRARIES, between, settings
from adapters.run import run, sample_times
from mechanics.trajectory import Trajectory
from scenarios import catalogue

SCENES = ("bouncing-ball[e=0.5]", "sliding-block[]", "pendulum[]", "tumbling-box[]", "stack[]")


def answer(engine, scenario, settings):
    done = run(engine, scenario.scene, sample_times(0.5 * scenario.duration, scenario.duration / 20), settings)
    return done.outcome.digest() if isinstance(done.outcome, Trajectory) else type(done.outcome).__name__


@pytest.mark.parametrize("library", LIBRARIES)
@pytest.mark.parametrize("label", SCENES)
def test_the_ends_are_the_two_profiles(library, label):
    (scenario,) = catalogue.find(label)
    for name, on in ((f"{library}:stock", set()), (library, set(settings(library)))):
        profile, made = registry.engine(name), between(library, "made", on)
        assert answer(made, scenario, None) == answer(profile, scenario, None)


def test_one_setting_is_one_setting():
    for name, engine in ENGINES.items():
        library, _, kind = name.partition(":")
        setting = kind.partition("+")[2] if "+" in kind else kind.partition("-")[2]
        every = set(settings(library))
        assert setting in every
        assert engine.departures == ({setting} if kind.startswith("stock+") else every - {setting})


def test_a_setting_changes_what_it_is_about():
    (ball,) = catalogue.find("bouncing-ball[e=0.5]")
    one = {"dt": 1.0 / 240.0}
    stock = answer(between("pybullet", "made", set()), ball, one)
    assert answer(ENGINES["pybullet:stock+damping"], ball, one) != stock
    assert answer(ENGINES["pybullet:stock+collisionMargin"], ball, one) == stock  # there is no convex hull


def test_they_are_on_no_list_of_engines():
    assert not set(ENGINES) & set(registry.names())
