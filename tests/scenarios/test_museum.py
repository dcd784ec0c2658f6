"""Every exhibit has a truth, an origin and figures that are measured; its remedies exist and differ from stock."""

from __future__ import annotations

import re

import numpy as np
import pytest

from adapters import registry
from adapters.engine import checked_settings
from adapters.run import Run, run, sample_times
from comparisons.exhibits import QUANTITIES, measure, passed
from comparisons.judge import describe_quantities, judge
from comparisons.measurement import Case
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, Sphere
from mechanics.trajectory import State, Trajectory
from plumbline.plan import plan
from scenarios import catalogue
from scenarios.museum import floor_that_trips

MUSEUM = catalogue.suite("museum")


def figures(name, engine, **settings):
    (scenario,) = catalogue.find(name)
    times = sample_times(scenario.duration, scenario.sampling)
    said = judge(scenario, run(registry.engine(engine), scenario.scene, times, settings))
    return {m.quantity: m.value for m in said.measurements}


def test_there_are_ten_exhibits():
    assert {s.exhibit.number for s in MUSEUM} == set(range(1, 11))
    titles = {(s.exhibit.number, s.exhibit.title) for s in MUSEUM}
    assert len(titles) == 10


@pytest.mark.parametrize("scenario", MUSEUM, ids=lambda s: s.name)
def test_a_label_says_whence_and_what(scenario):
    label = scenario.exhibit
    assert label.origin
    assert all(re.fullmatch(r"https://\S+/\S+", link) for link in label.origin)
    assert set(label.figures) <= {q.name for q in describe_quantities()}
    assert len(label.shown) > 80
    # numbers of engines are measured, never written down: only what is asked and true stands on a label
    assert not re.search(r"\d\.\d", label.shown.replace("(-.6, .4, .4, .4, .4)", "").replace("3.11.0", ""))


@pytest.mark.parametrize("scenario", MUSEUM, ids=lambda s: s.name)
def test_remedies_are_settings_that_can_be_run(scenario):
    for remedy in scenario.exhibit.remedies:
        engine = registry.engine(remedy.engine)
        assert dict(remedy.settings).items() <= checked_settings(engine, remedy.settings).items()
        assert len(remedy.source) > 10
    told = [(r.engine, tuple(r.settings.items())) for r in scenario.exhibit.remedies]
    assert len(set(told)) == len(told)


@pytest.mark.parametrize("scenario", [s for s in MUSEUM if s.truth], ids=lambda s: s.name)
def test_the_figures_of_the_truth_are_those_on_the_label(scenario):
    truth = scenario.truth(sample_times(scenario.duration, scenario.sampling))
    found = {q.name: q for q in measure(Case(scenario, Run("truth", "", {}, truth), truth))}
    for name, value in scenario.exhibit.figures.items():
        if name in QUANTITIES:
            assert (found[name].text or found[name].value) == (
                value if isinstance(value, str) else pytest.approx(value, abs=1e-9)
            )


def test_remedies_run_beside_the_engines_of_their_library_only():
    (wall,) = catalogue.find("wall-that-must-stop[]")
    names = [job.engine for job in plan((wall,), ["mujoco"])]
    assert sorted(set(names)) == ["mujoco", "mujoco:speculative", "mujoco:stock"]
    assert "pymunk:stock" in {job.engine for job in plan((wall,), ["mujoco", "pymunk"])}


def test_passing_through_is_told_from_passing_by():
    wall = Body("wall", Box((0.02, 2.0, 2.0)), None, (1.0, 0.0, 0.0))
    scene = Scene((wall, Body("ball", Sphere(0.05), 1.0)))

    def ends(x, y=0.0):
        places = np.array([[[1.0, 0.0, 0.0], [0.0, 0.0, 0.0]], [[1.0, 0.0, 0.0], [x, y, 0.0]]])
        still = np.zeros((2, 2, 3))
        turns = np.tile([1.0, 0.0, 0.0, 0.0], (2, 2, 1))
        return Trajectory.of([State(float(k), places[k], turns[k], still[k], still[k]) for k in range(2)])

    assert passed(scene, ends(2.0)) == ["ball"]
    assert passed(scene, ends(0.9)) == []
    assert passed(scene, ends(-1.0)) == []
    assert passed(scene, ends(2.0, y=4.0)) == []


class TestExhibits:
    """The short ones, measured: figures as published in the reports they come from, or the law behind them."""

    def test_damping_has_a_terminal_speed_and_its_remedy_has_none(self):
        stock = figures("vacuum-with-a-speed-limit[]", "pybullet:stock")["final speed"]
        assert stock == pytest.approx((-1.0 + np.sqrt(1.0 + 4.0 * 9.81 / 0.04)) / 2.0, rel=1e-3)  # c (v + v²) = g
        for engine in ("pybullet:undamped", "pybullet", "mujoco:stock", "pymunk:stock", "reference"):
            assert figures("vacuum-with-a-speed-limit[]", engine)["final speed"] == pytest.approx(8.0 * 9.81, rel=1e-9)

    def test_creep_is_halved_by_the_cone_and_ended_by_noslip(self):
        pyramid, cone, noslip = (
            figures("restless-block[]", f"mujoco:{name}")["creep speed"] for name in ("stock", "elliptic", "noslip")
        )
        assert pyramid == pytest.approx(887.5e-6, rel=1e-3)
        assert cone == pytest.approx(0.5 * pyramid, rel=1e-3)
        assert noslip < 1e-6

    def test_a_pyramid_turns_a_block_aside_and_a_cone_does_not(self):
        pyramid, cone = (figures("which-way-did-you-push[heading=22.5]", f"mujoco:{n}") for n in ("stock", "elliptic"))
        assert pyramid["turned aside"] > 10.0
        assert abs(cone["turned aside"]) < 1e-6
        assert cone["stopping distance"] == pytest.approx(0.917, rel=0.01)

    def test_looking_along_the_path_stops_the_ball(self):
        assert figures("wall-that-must-stop[speed=100]", "mujoco:stock")["passed through"] == 1.0
        for engine in ("mujoco:speculative", "pybullet:ccd", "reference"):
            assert figures("wall-that-must-stop[speed=100]", engine)["passed through"] == 0.0


@pytest.mark.parametrize("step", [1 / 60, 1 / 240, 2e-3, 1e-3, 5e-4, 2.5e-4])
@pytest.mark.parametrize("edge", [0.2, 0.3])
def test_no_usual_step_carries_the_tripping_box_onto_a_seam(step, edge):
    """A face that meets the side of a tile to the last bit is stopped, or not, by rounding; at 2 m/s it would."""
    seams = np.arange(floor_that_trips.TILES - 1) + 0.5

    def nearest(speed):
        meetings = np.concatenate([seams - 0.5 * edge, seams + 0.5 * edge]) / (speed * step)
        return np.abs(meetings - np.round(meetings)).min()

    assert nearest(floor_that_trips.SPEED) > 1e-4
    assert nearest(2.0) < 1e-9 or step > 1e-3
