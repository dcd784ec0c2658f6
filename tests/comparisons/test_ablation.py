"""Shares of the way from one error to another."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from comparisons.ablation import explained

errors = st.floats(1e-9, 1e-1)


@given(st.dictionaries(st.sampled_from("abcde"), st.floats(1.1, 1e3), min_size=1), errors)
def test_settings_that_each_divide_the_error_explain_all_of_it_whichever_way(factors, second):
    product = math.prod(factors.values())
    parts = explained(
        second * product, second, {n: second * product / f for n, f in factors.items()},
        {n: second * f for n, f in factors.items()},
    )  # fmt: skip
    assert sum(p.alone for p in parts) == pytest.approx(1.0)
    for part in parts:
        assert part.alone == pytest.approx(part.last)
        assert part.alone == pytest.approx(math.log(factors[part.setting]) / math.log(product))


def test_settings_that_act_only_together_show_last_and_not_alone():
    parts = explained(1e-1, 1e-3, {"a": 1e-1, "b": 1e-1}, {"a": 1e-1, "b": 1e-1})
    assert [(p.alone, p.last) for p in parts] == [(0.0, pytest.approx(1.0))] * 2


def test_what_explains_most_stands_first_and_what_broke_last():
    parts = explained(1e-1, 1e-3, {"a": 5e-2, "b": 1e-2, "c": math.nan}, {"a": 1e-3, "b": 1e-3, "c": math.inf})
    assert [p.setting for p in parts] == ["b", "a", "c"]
    assert math.isnan(parts[-1].alone)


@pytest.mark.parametrize(("first", "second"), [(1e-3, 1.01e-3), (math.nan, 1e-3), (1e-3, math.inf)])
def test_without_a_distance_there_is_nothing_to_explain(first, second):
    with pytest.raises(ValueError, match="there is no distance"):
        explained(first, second, {}, {})
