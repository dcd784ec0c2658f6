"""Motions as .rrd files: what is read back from a file is what was recorded."""

from __future__ import annotations

import builtins

import numpy as np
import pytest

from mechanics.effects import Gravity, Rod, Rotation
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, Capsule, Cylinder, HalfSpace, Mesh, Sphere
from mechanics.trajectory import Trajectory
from reports import rerun_file
from reports.recorded import Motion, Recorded
from reports.series import time_series

WEDGE = Mesh(
    ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)), ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2))
).centred()
SHAPES = (Sphere(0.1), Box((0.1, 0.2, 0.3)), Capsule(0.1, 0.3), Cylinder(0.1, 0.2), WEDGE)


@pytest.fixture
def falling() -> Recorded:
    """One body of each shape above a floor, all of them turning, two of them tied to each other."""
    bodies = tuple(
        Body(f"body {k}", shape, 1.0, (3.0 * k, 0.0, 2.0), angular_velocity=(0.0, 1.0, 0.0))
        for k, shape in enumerate(SHAPES)
    )
    floor = Body("floor", HalfSpace(), position=(0.0, 0.0, -50.0))
    scene = Scene((floor, *bodies), (Gravity(), Rotation(), Rod("body 0", "body 1")))
    t = np.linspace(0.0, 1.0, 11)
    x = np.tile(np.array([b.position for b in scene.bodies]), (11, 1, 1))
    x[:, 1:, 2] -= 0.5 * 9.81 * t[:, None] ** 2
    q = np.tile([1.0, 0.0, 0.0, 0.0], (11, len(scene.bodies), 1))
    q[:, 1:] = np.stack([np.cos(0.5 * t), 0.0 * t, np.sin(0.5 * t), 0.0 * t], axis=1)[:, None]
    path = Trajectory(t, x, q, np.zeros_like(x), np.zeros_like(x))
    return Recorded("falling", scene, 1.0, None, {}, {"mujoco:stock": Motion(path, 0.0)})


def test_a_file_holds_every_place_and_turn(falling, tmp_path):
    pytest.importorskip("rerun")
    from rerun.chunk import RrdReader

    file = rerun_file.write(falling, time_series(falling), tmp_path / "falling.rrd")
    path = falling.motions["mujoco:stock"].path
    found = {}
    for chunk in RrdReader(file).stream():
        found.setdefault(str(chunk.entity_path), []).append(chunk.to_record_batch())
    for k in range(len(SHAPES)):
        batches = [b for name, b in found.items() if name.replace("\\", "").endswith(f"stock/body {k}")]
        assert len(batches) == 1
        columns = {n: c for batch in batches[0] for n, c in zip(batch.schema.names, batch.columns, strict=True)}
        x = np.array(columns["Transform3D:translation"].to_pylist()).reshape(-1, 3)
        q = np.array(columns["Transform3D:quaternion"].to_pylist()).reshape(-1, 4)
        assert np.abs(x - path.x[:, k + 1]).max() < 1e-6 * np.abs(path.x).max()  # single precision
        assert np.abs(q[:, [3, 0, 1, 2]] - path.q[:, k + 1]).max() < 1e-6
    assert sum("link" in name for name in found) == 1
    assert any(name.replace("\\", "").startswith("/curves/Energy") for name in found)


def test_without_the_package_it_says_what_is_missing(falling, tmp_path, monkeypatch):
    real = builtins.__import__

    def bare(name, *rest):
        if name == "rerun":
            raise ImportError(name)
        return real(name, *rest)

    monkeypatch.setattr(builtins, "__import__", bare)
    with pytest.raises(rerun_file.NoRerun, match="rerun-sdk"):
        rerun_file.write(falling, time_series(falling), tmp_path / "falling.rrd")
    assert not (tmp_path / "falling.rrd").exists()


def test_a_half_space_is_drawn_on_its_own_plane():
    for normal in np.random.default_rng(0).normal(size=(50, 3)):
        normal /= np.linalg.norm(normal)
        patch = rerun_file._patch(normal, 3.0)
        assert np.abs(patch @ normal).max() < 1e-14
        assert np.allclose(np.cross(patch[1] - patch[0], patch[2] - patch[0]), 36.0 * normal)
        assert np.allclose(np.linalg.norm(patch, axis=1), 3.0 * np.sqrt(2.0))
