"""What a machine's timings are worth is told from ratios of identical work and of work that is a tenth more."""

import math

import numpy as np
import pytest

from plumbline.noise import ENVELOPES, GATES, STATISTICS, Noise, sitting

SMALL, MIDDLE, LARGE = (envelope.name for envelope in ENVELOPES)


def noise(same, more, contention=0.0, **better):
    """As measured, the same by every statistic but those given otherwise."""
    ratios = [{statistic.name: np.array(values, dtype=float) for statistic in STATISTICS} for values in (same, more)]
    for name, values in better.items():
        ratios[0][{"middle": MIDDLE, "large": LARGE}[name]] = np.array(values, dtype=float)
    return Noise(*ratios, contention)


def test_the_gate_is_the_smallest_that_identical_work_never_passes():
    assert noise([1.0, 1.004, 0.996], [1.1] * 3).gate(SMALL) == GATES[0]
    assert noise([1.0, 1.04, 0.98], [1.1] * 3).gate(SMALL) == 0.05
    assert noise([1.0, 1.0, 1.0 / 1.04], [1.1] * 3).gate(SMALL) == 0.05
    assert noise([1.0, 2.0], [1.1] * 2).gate(SMALL) == math.inf


def test_rates_are_shares_of_the_trials():
    found = noise([1.0, 1.06, 1.0 / 1.06, 1.0], [1.1, 1.04, 1.2, 0.9])
    assert found.alarms(SMALL, 0.05) == 0.5
    assert found.alarms(SMALL, 0.1) == 0.0
    assert found.seen(SMALL, 0.05) == 0.5
    assert found.trials == 4


def test_the_verdict_names_the_gate_what_it_sees_and_the_repeats_it_takes():
    assert "gate of 1 % with --repeats 3: a real +10% is seen in 100%" in noise([1.0], [1.1]).verdict()
    assert "gate of 2 % with --repeats 9" in noise([1.12], [1.1], large=[1.011]).verdict()
    assert "gate of 5 % with --repeats 5" in noise([1.12], [1.1], middle=[1.04], large=[1.0]).verdict()
    assert "busy" in noise([1.0], [1.1], contention=0.5).verdict()
    assert "do not trust" in noise([1.12], [1.1]).verdict()


@pytest.fixture
def clock(monkeypatch):
    """A clock on which a unit of work takes 1000 ns, and now and then an interval is interrupted."""
    now, intervals = [0], [0]

    def work(state):
        now[0] += 1000
        return state

    def read():
        intervals[0] += 1
        now[0] += 10**6 if intervals[0] % 1001 == 7 else 0
        return now[0]

    monkeypatch.setattr("plumbline.noise.unit", work)
    monkeypatch.setattr("plumbline.noise.time.perf_counter_ns", read)


def test_a_sitting_times_each_piece_of_work(clock):
    a, b, c = sitting((10, 10, 11))
    assert a.wall.shape == (9, 50)
    assert b.seconds == a.seconds
    assert c.seconds / a.seconds == pytest.approx(1.1)
    assert max(t.wall.sum(axis=1).max() * 1e-9 / t.seconds for t in (a, b, c)) > 1.5  # interruptions there were
