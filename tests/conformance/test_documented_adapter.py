"""The adapter printed in the documentation works as it stands there."""

import re
import types
from pathlib import Path

import numpy as np
import pytest

from adapters.conformance import check_engine
from adapters.run import run, sample_times
from comparisons.judge import judge
from scenarios.catalogue import find

PAGE = Path(__file__).parents[2] / "docs" / "writing_an_adapter.md"


@pytest.fixture(scope="module")
def drifters():
    code = re.search(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)[1]
    module = types.ModuleType("drifters")
    exec(compile(code, str(PAGE), "exec"), module.__dict__)
    return module


def test_it_keeps_every_law(drifters):
    laws = check_engine(drifters)
    assert [law.name for law in laws if not law.passed] == []


def test_it_falls_as_its_scheme_predicts_and_is_judged_like_any_engine(drifters):
    scenario = find("free-fall[]")[0]
    answer = run(drifters, scenario.scene, sample_times(scenario.duration, scenario.sampling), {"dt": 1e-3})
    judgement = judge(scenario, answer)
    assert judgement.state == "ok"
    error = next(m.value for m in judgement.measurements if m.quantity == "position error")
    assert error == pytest.approx(9.81 * 1e-3 * scenario.duration / 2, rel=1e-9)


def test_what_it_does_not_list_is_refused(drifters):
    scenario = find("bouncing-ball[]")[0]
    answer = run(drifters, scenario.scene, np.array([0.0, 0.1]))
    assert "drifters has no Restitution" in str(answer.outcome)
