"""Climbing: a threshold that is put in is found, as closely as the bisections allow, and named by its word."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from comparisons.cell import STATES, Cell
from comparisons.climb import ABSENT, BISECTIONS, INACCURATE, LOUD, UNJUDGED, Frontier, Try, frontier, how, next_rung
from comparisons.measurement import Measurement
from comparisons.stability import BREAKS
from scenarios.ladder import Ladder

RISING = Ladder("rising", "speed", "m/s", "thin-wall", (1.0, 10.0, 100.0, 1e3, 1e4), "speed")
FALLING = Ladder("falling", "margin", "1", "near-slipping", (1.0, 0.1, 0.01, 1e-3), "margin")
COUNTED = Ladder("counted", "cubes", "1", "tower", (1, 2, 5, 10, 20, 50, 100), "count")
HOLEY = replace(RISING, monotone=False)


def climbed(ladder, breaks):
    """Tries of an engine that breaks where `breaks` says how, climbing until there is nothing left to try."""
    tries = []
    while (rung := next_rung(ladder, tries)) is not None:
        assert rung not in [t.rung for t in tries]
        tries.append(Try(rung, breaks(rung)))
        assert len(tries) <= len(ladder.rungs) + BISECTIONS
    return tries


@given(st.floats(1.5, 9e3))
def test_a_threshold_is_found_on_a_rising_ladder(threshold):
    edge = frontier(climbed(RISING, lambda r: "sank" if r > threshold else ""))
    assert edge.good <= threshold < edge.bad
    assert (edge.word, edge.again) == ("sank", ())
    assert edge.bad / edge.good < 10.0 ** (1.0 / 2.0**BISECTIONS) * 1.02  # rungs are rounded to three digits


@given(st.floats(1.1e-3, 0.9))
def test_a_threshold_is_found_on_a_falling_ladder(threshold):
    edge = frontier(climbed(FALLING, lambda r: "fell" if r < threshold else ""), falling=True)
    assert edge.bad < threshold <= edge.good
    assert edge.good / edge.bad < 10.0 ** (1.0 / 2.0**BISECTIONS) * 1.02


@pytest.mark.parametrize("most", range(1, 100))
def test_a_threshold_of_a_number_of_things_is_a_whole_number(most):
    edge = frontier(climbed(COUNTED, lambda r: "fell" if r > most else ""))
    assert edge.good <= most < edge.bad
    assert {edge.good % 1, edge.bad % 1} == {0}
    assert edge.bad - edge.good == 1 or edge.bad / edge.good < 2.5 ** (1.0 / 4.0)


def test_who_never_breaks_tries_every_rung_once():
    tries = climbed(RISING, lambda r: "")
    assert tuple(t.rung for t in tries) == RISING.rungs
    assert frontier(tries) == Frontier(1e4, None, "")


def test_who_breaks_on_the_first_rung_is_not_bisected():
    tries = climbed(RISING, lambda r: "fell")
    assert frontier(tries) == Frontier(None, 1.0, "fell")
    assert len(tries) == 1


@pytest.mark.parametrize("word", [LOUD["timeout"], LOUD["refused"]])
def test_deadlines_and_refusals_are_not_bisected(word):
    tries = climbed(RISING, lambda r: word if r > 50.0 else "")
    assert [t.rung for t in tries] == [1.0, 10.0, 100.0]
    assert frontier(tries) == Frontier(10.0, 100.0, word)


@pytest.mark.parametrize("word", [*ABSENT.values(), UNJUDGED])
def test_who_is_not_there_does_not_climb_on(word):
    assert len(climbed(HOLEY, lambda r: word)) == 1


def test_where_harder_is_not_worse_every_rung_is_tried():
    edge = frontier(climbed(HOLEY, lambda r: "fell" if r in (10.0, 1e3) else ""))
    assert edge == Frontier(1.0, 10.0, "fell", (100.0, 1e4))


def cell(state, stability="", stage="advance"):
    row = Measurement("stability", float(bool(stability)), "1", 0.0, stability, 0.5, 0.25, "", "info")
    return Cell("key", "s", "s", 1, (), "e", "1", {}, state, 1.0, stage, "because", measurements=(row,))


def test_every_state_has_a_word():
    said = {state: how(cell(state)) for state in STATES}
    assert {state for state, word in said.items() if not word} == {"ok", "xpass"}
    known = {*LOUD.values(), *ABSENT.values(), INACCURATE}
    assert {word for word in said.values() if word} == known


def test_a_silent_break_is_named_by_what_is_worst_in_it():
    assert how(cell("fail", "tunnelled: a crosses b, from t = 1 s on; fell: c, from t = 2 s on")) == "tunnelled"
    assert how(cell("xfail", "fell: c, from t = 2 s on")) == "fell"
    assert how(cell("fail")) == INACCURATE
    assert how(cell("diverged", "not finite: NaN, from t = 1 s on")) == "not finite"
    assert how(cell("diverged", "sank: a and b, 1 m, from t = 1 s on")) == LOUD["diverged"]
    assert how(cell("error", stage="judge")) == UNJUDGED


def test_what_says_so_is_not_silent():
    assert all(Frontier(None, 1.0, word).silent for word in (*BREAKS, INACCURATE))
    assert not any(Frontier(None, 1.0, word).silent for word in (*LOUD.values(), *ABSENT.values(), UNJUDGED, ""))


def test_between_is_in_between_and_ends():
    for ladder in (RISING, COUNTED):
        good, bad = 1.0, 100.0
        while (middle := ladder.between(good, bad)) is not None:
            assert good < middle < bad
            rounded = 1.1 / middle if ladder is COUNTED else 0.011  # twice half a unit of the last digit kept
            assert math.log(middle / good) == pytest.approx(math.log(bad / middle), abs=rounded)
            good = middle
        assert bad - good <= (1.0 if ladder is COUNTED else 0.6)
