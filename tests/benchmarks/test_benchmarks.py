"""Every benchmark runs and returns a row that can be printed; what it measures is not asserted, speed least of all."""

import io
import math

import numpy as np
import pytest
from mpmath import mpf
from rich.console import Console

from benchmarks.__main__ import NAMES, PAGE, measured
from benchmarks.page import number, show, written
from benchmarks.row import Beside, Figure, Row
from benchmarks.truths import agreed, between, tumble, tumble_closed
from mechanics.rotation import product
from scenarios.free_rotation import free_rotation


@pytest.mark.parametrize("name", NAMES)
def test_every_benchmark_returns_a_row(name):
    row = measured(name, tiny=True)
    assert row.name == name
    assert row.figures
    assert len({figure.what for figure in row.figures}) == len(row.figures)
    for figure in row.figures:
        assert math.isfinite(figure.target)
        assert math.isfinite(figure.value), figure
    for beside in row.beside:
        assert math.isfinite(beside.error) == math.isfinite(beside.seconds), beside
        assert math.isfinite(beside.seconds) or beside.note
    assert bool(row.judged) == bool(row.beside)
    out = io.StringIO()
    show(row, Console(file=out, width=200))
    assert row.subject in out.getvalue()
    page = written(PAGE.read_text(encoding="utf-8"), row)
    assert all(figure.what in page for figure in row.figures)


def test_a_number_that_could_not_be_measured_meets_no_promise():
    assert not Figure("error", math.nan, 1.0).met
    assert not Figure("speed", math.nan, 1.0, at_least=True).met
    assert Figure("error", 1.0, 1.0).met
    assert not Figure("error", 1.1, 1.0).met
    assert not Figure("speed", 0.9, 1.0, at_least=True).met
    row = Row("x", "x", (Figure("a", 0.0, 1.0), Figure("b", 2.0, 1.0)), "so")
    assert not row.met


def test_the_page_keeps_everything_but_the_row_that_is_written():
    page = PAGE.read_text(encoding="utf-8")
    one = written(page, Row("gas", "a gas", (Figure("energy", 0.5, 1.0),), "so", "error", (Beside("b", note="why"),)))
    two = written(one, Row("gas", "another gas", (Figure("energy", 2.0, 1.0),), "so", missed="too hot"))
    assert "| energy | 0.5 | at most 1 | met |" in one
    assert "| b | none | none | why |" in one
    assert "| energy | 2 | at most 1 | **missed** |" in two
    assert "Missed: too hot." in two
    assert "a gas." not in two.lower().replace("another gas", "")
    assert two.count("<!--") == page.count("<!--")
    with pytest.raises(ValueError, match="needs"):
        written("no markers", Row("gas", "a gas", (), "so"))


def test_numbers_are_printed_with_their_units():
    assert number(math.nan, "s") == "none"
    assert number(5000.0, "") == "5,000"
    assert number(0.0, "m") == "0 m"


@pytest.mark.parametrize("seed", range(3))
def test_the_truth_of_a_tumbling_body_has_two_routes_and_is_right(seed):
    rng = np.random.default_rng(seed)
    q = rng.normal(size=4)
    q /= np.linalg.norm(q)
    w = np.array([0.1, 2.0, 3.0]) * rng.normal(size=3)
    w[2] = 1.0 + abs(w[2]) + abs(w[1])
    moments = (1.0, 2.0, 3.0)
    truth = agreed(tumble_closed(moments, q, w, 3.0), tumble(moments, q, w, 3.0))
    r = product(product(q, np.append(0.0, w)), q * [1, -1, -1, -1])[1:]
    known, _ = free_rotation(np.array(moments), q, r, np.array([3.0]))
    assert between(known[0], truth) < 1e-13


def test_routes_that_disagree_are_no_truth():
    with pytest.raises(ArithmeticError, match="apart"):
        agreed([mpf(1), mpf(0), mpf(0), mpf(0)], [mpf(1), mpf("1e-25"), mpf(0), mpf(0)])
    with pytest.raises(ValueError, match="not of the kind"):
        tumble_closed((3.0, 2.0, 1.0), (1.0, 0.0, 0.0, 0.0), (1.0, 2.0, 3.0), 1.0)
