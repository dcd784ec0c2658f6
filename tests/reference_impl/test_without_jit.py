"""The same code runs without compilation, as NUMBA_DISABLE_JIT=1 asks, and gives the same answers.

This file is also the programme that the test starts: it writes the ends of its scenes to a file.
"""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from mechanics.effects import Drag, Force, Friction, Gravity, Resting, Restitution, Rotation
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, HalfSpace, Sphere
from reference_impl.simulate import simulate

FLOOR = Body("floor", HalfSpace())
TILTED = (0.9, 0.3, -0.2, 0.1)

SCENES = {
    "tumbling under drag and a force": (
        Scene(
            (Body("b", Box((0.1, 0.2, 0.3)), 1.0, orientation=TILTED, angular_velocity=(1.0, 5.0, -2.0)),),
            (Gravity(), Rotation(), Drag(0.2, 1e-3), Force("b", (1.0, 0.0, 0.5), point=(0.02, 0.0, 0.1))),
        ), 0.5,
    ),
    "spheres that collide": (
        Scene(
            (Body("a", Sphere(0.1), 1.0, (-1.0, 0.03, 0.0), velocity=(2.0, 0.0, 0.0)), Body("b", Sphere(0.2), 3.0)),
            (Rotation(), Restitution(0.7), Friction(0.3)),
        ), 1.0,
    ),
    "boxes that collide": (
        Scene(
            (Body("a", Box((0.2, 0.3, 0.4)), 1.0, (-0.6, 0.05, 0.0), TILTED, (2.0, 0.0, 0.0), (3.0, 1.0, 0.0)),
             Body("b", Box((0.3, 0.3, 0.3)), 2.0, angular_velocity=(0.0, 1.0, 2.0))),
            (Rotation(), Restitution(0.5)),
        ), 0.5,
    ),
    "a ball that comes to rest": (
        Scene((FLOOR, Body("b", Sphere(0.1), 1.0, (0.0, 0.0, 0.12))), (Gravity(), Restitution(0.2), Resting())), 0.3,
    ),
    "a box that slides": (
        Scene(
            (FLOOR, Body("b", Box((0.4, 0.4, 0.2)), 1.0, (0.0, 0.0, 0.1), velocity=(0.3, 0.1, 0.0))),
            (Gravity(), Rotation(), Resting(), Friction(0.4)),
        ), 0.05,
    ),
}  # fmt: skip


def ends():
    """The last state of each scene as one row of numbers."""
    rows = {}
    for name, (scene, end) in SCENES.items():
        last = simulate(scene, (0.0, end)).at(1)
        rows[name] = np.concatenate([last.x.ravel(), last.q.ravel(), last.v.ravel(), last.w.ravel()])
    return rows


@pytest.fixture(scope="module")
def interpreted(tmp_path_factory):
    """The ends without compilation."""
    file = tmp_path_factory.mktemp("interpreted") / "ends.npz"
    paths = [str(Path(__file__).parents[2]), os.environ.get("PYTHONPATH", "")]
    told = os.environ | {"NUMBA_DISABLE_JIT": "1", "PYTHONPATH": os.pathsep.join(filter(None, paths))}
    subprocess.run([sys.executable, __file__, str(file)], env=told, check=True, timeout=110)
    return np.load(file)


@pytest.fixture(scope="module")
def compiled():
    """The ends as they are by default."""
    return ends()


@pytest.mark.parametrize("name", SCENES)
def test_the_interpreted_engine_agrees_with_the_compiled_one(name, interpreted, compiled):
    """To 1e-13: LLVM may join a product and a sum into one rounding, Python never does."""
    assert np.abs(interpreted[name] - compiled[name]).max() <= 1e-13


if __name__ == "__main__":
    np.savez(sys.argv[1], **ends())
