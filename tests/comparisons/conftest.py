"""Cases made by hand: a motion that is known, as if an engine had answered it."""

import numpy as np
import pytest

from adapters.run import Run
from comparisons.measurement import Case
from mechanics.trajectory import Trajectory
from scenarios.scenario import Check, Scenario


@pytest.fixture
def scenario_of():
    """Scenario of a scene, demanding 1e-6 of the named quantities."""

    def build(scene, duration=1.0, *demanded, **told):
        checks = told.pop("checks", tuple(Check(name, 1e-6, "by hand") for name in demanded))
        return Scenario(scene=scene, duration=duration, sampling=duration, checks=checks, source="by hand", **told)

    return build


@pytest.fixture
def case_of(scenario_of):
    """Case of a scene and its motion."""

    def build(scene, motion, *demanded, lead=0.0, settings=None, **told):
        run = Run("by-hand", "1", dict(settings or {}), motion, lead=lead)
        return Case(scenario_of(scene, float(motion.t[-1]) or 1.0, *demanded, **told), run, motion)

    return build


@pytest.fixture
def moved():
    """Trajectory of a scene: what is not given stays as it is at the start."""

    def build(scene, t, **paths):
        t = np.asarray(t, dtype=np.float64)
        start = scene.start()
        arrays = {name: np.repeat(getattr(start, name)[None], len(t), axis=0) for name in ("x", "q", "v", "w")}
        for key, path in paths.items():
            kind, _, body = key.partition("_")
            arrays[kind][:, scene.index(body)] = path
        return Trajectory(t, **arrays)

    return build


@pytest.fixture
def values():
    """Quantities of a comparison by name."""

    def measure(comparison, case):
        return {q.name: q for q in comparison.measure(case)}

    return measure
