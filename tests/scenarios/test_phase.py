"""A scenario begun later by part of a step is the same motion, met at another phase of the steps."""

from __future__ import annotations

import numpy as np
import pytest

from adapters import registry
from adapters.run import run, sample_times
from comparisons.judge import judge
from scenarios import catalogue
from scenarios.phase import delays, has_phase, later

STEP = 1e-3
IMPACTS = [s for f in catalogue.families().values() for s in f.all()[:1] if has_phase(s)]


@pytest.mark.parametrize("scenario", IMPACTS, ids=lambda s: s.name)
def test_it_begins_on_its_own_path(scenario):
    for delay in delays(scenario, 4, STEP)[1:]:
        begun, start = later(scenario, delay), scenario.scene.start()
        assert begun.scene.effects == scenario.scene.effects
        moved = begun.scene.start().x - start.x - delay * start.v
        # gravity and whatever else acts: an acceleration of at most 100 m/s2 in these scenes
        assert np.abs(moved).max() <= 0.5 * 100.0 * delay**2 + 1e-15
        if scenario.truth is not None:
            t = np.linspace(0.0, 0.5 * scenario.duration, 7)
            np.testing.assert_array_equal(begun.truth(t).x, scenario.truth(t + delay).x)
            np.testing.assert_allclose(begun.truth(np.zeros(1)).x[0], begun.scene.start().x, atol=1e-15)
        assert begun.events == tuple(t - delay for t in scenario.events)


def test_delays_spread_over_one_step():
    (ball,) = catalogue.find("bouncing-ball[]")
    assert delays(ball, 8, STEP) == tuple(k / 8 * STEP for k in range(8))
    (box,) = catalogue.find("resting-box[]")
    assert delays(box, 8, STEP) == (0.0,)
    assert later(box, 0.0) is box
    with pytest.raises(ValueError, match="resting-box"):
        later(box, STEP)
    # an impact within the delay leaves nothing to begin with
    assert delays(ball, 8, 2.0) == (0.0,)
    with pytest.raises(ValueError, match="impact at"):
        later(ball, 1.0)


@pytest.mark.parametrize("name", ["bouncing-ball[]", "head-on-collision[]", "newtons-cradle[]", "touching-cradle[]"])
def test_the_reference_answers_alike_at_every_phase(name):
    (scenario,) = catalogue.find(name)
    reference = registry.engine("reference")
    for delay in delays(scenario, 8, STEP):
        begun = later(scenario, delay)
        said = judge(begun, run(reference, begun.scene, sample_times(scenario.duration, scenario.sampling)))
        demanded = [m for m in said.measurements if not np.isnan(m.tolerance)]
        assert demanded
        assert {m.verdict for m in demanded} == {"exact"}
