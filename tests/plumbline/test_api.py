"""The public names: there when they are used, and not before."""

import ast
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import plumbline
from plumbline import (
    Body,
    Gravity,
    NotInstalled,
    Refusal,
    Restitution,
    Scene,
    Sphere,
    Trajectory,
    UnknownName,
    simulate,
)

BALL = Body("ball", Sphere(0.1), mass=1.0, position=(0.0, 0.0, 5.0))
SCENE = Scene((BALL,), (Gravity(),))


def test_importing_plumbline_imports_nothing_else():
    script = "import sys, plumbline; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert not {"numpy", "click", "mechanics", "adapters"} & set(done.stdout.split())


@pytest.mark.parametrize("name", plumbline.__all__)
def test_every_public_name_is_there_and_documented(name):
    value = getattr(plumbline, name)
    assert value.__doc__
    assert name in dir(plumbline)


def test_type_checkers_see_the_same_names():
    stub = ast.parse(Path(plumbline.__file__).with_suffix(".pyi").read_text())
    homes = {
        node.module: {alias.name for alias in node.names} for node in stub.body if isinstance(node, ast.ImportFrom)
    }
    assert homes == {module: set(names) for module, names in plumbline._HOMES.items()}
    (names,) = (node.value for node in stub.body if isinstance(node, ast.Assign))
    assert sorted(ast.literal_eval(names)) == plumbline.__all__


def test_a_name_that_is_not_there_lists_those_that_are():
    with pytest.raises(AttributeError, match=r"no attribute 'simulat'; it has .*simulate"):
        plumbline.simulat  # noqa: B018


def test_the_version_is_that_of_the_package():
    assert plumbline.__version__ == "0.1.0"


@pytest.mark.usefixtures("toys")
def test_simulate_answers_with_the_motion():
    run = simulate(SCENE, engine="toy", times=[0.0, 0.5, 1.0])
    assert isinstance(run.outcome, Trajectory)
    np.testing.assert_allclose(run.outcome.x[:, 0, 2], [5.0, 5.0 - 9.81 / 8, 5.0 - 9.81 / 2])
    assert len(simulate(SCENE, "toy", times=2.0).outcome) == 101
    assert simulate(SCENE, "toy", times=1.0, settings={"dt": 0.1}).settings == {"dt": 0.1}


def test_simulate_takes_an_engine_as_well_as_its_name(toys):
    by_name, by_value = (simulate(SCENE, engine, times=1.0) for engine in ("toy", toys["toy"]))
    assert by_name.outcome.digest() == by_value.outcome.digest()


@pytest.mark.usefixtures("toys")
def test_an_isolated_crash_is_a_failure_and_not_ours():
    run = simulate(SCENE, "toy:faulty", times=1.0, settings={"fault": "segv"}, isolated=True)
    assert (run.outcome.state, run.outcome.stage) == ("crash", "advance")
    assert len(run.trajectory) > 1


def test_an_isolated_engine_needs_a_name(toys):
    with pytest.raises(ValueError, match="register it first"):
        simulate(SCENE, toys["toy"], times=1.0, isolated=True)


@pytest.mark.usefixtures("toys")
def test_overlapping_starts_are_noted_with_pair_and_depth():
    other = Body("other", Sphere(0.1), mass=1.0, position=(0.0, 0.0, 5.15))
    scene = Scene((BALL, other), (Gravity(), Restitution(0.5)))
    run = simulate(scene, "toy", times=1.0)
    assert isinstance(run.outcome, Refusal)
    assert run.notes == ("ball and other overlap by 0.05 m at the start",)


@pytest.mark.usefixtures("toys")
def test_wrong_calls_are_told_what_is_allowed():
    with pytest.raises(UnknownName, match="no engine 'toi'"):
        simulate(SCENE, "toi", times=1.0)
    with pytest.raises(ValueError, match="duration = -1"):
        simulate(SCENE, "toy", times=-1.0)
    with pytest.raises(TypeError, match="times"):
        simulate(SCENE, "toy")
    with pytest.raises(ValueError, match="no scenario 'nothing'"):
        plumbline.run("nothing")
    with pytest.raises(ValueError, match="is no scenario"):
        plumbline.run([SCENE])
    with pytest.raises(ValueError, match="needs a name"):
        plumbline.run(plumbline.Scenario(SCENE, 1.0, 0.1, (), "none"))


def test_an_engine_that_is_not_installed_says_how_to_install_it(tmp_path):
    from adapters import registry

    (tmp_path / "ghost.py").write_text("import no_such_physics")
    registry.register("ghost", str(tmp_path / "ghost.py"))
    try:
        with pytest.raises(NotInstalled, match="pip install no_such_physics"):
            simulate(SCENE, "ghost", times=1.0)
    finally:
        registry.unregister("ghost")
