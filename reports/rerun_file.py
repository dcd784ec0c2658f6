"""A scenario's recorded motions as an .rrd file for the viewer Rerun (https://rerun.io), all engines on one clock.

Display only: Rerun holds places and lines in single precision.  The package `rerun-sdk` is an extra of the project and
is imported when a file is asked for, not before.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from mechanics.rotation import rotate
from mechanics.scene import Scene
from mechanics.shapes import Box, Capsule, Cylinder, HalfSpace, Mesh, Shape, Sphere, bounding_radius
from mechanics.trajectory import Trajectory
from reports.palette import look
from reports.recorded import Recorded
from reports.replay import links
from reports.series import Curves

CLOCK = "simulated time"
GROUND = 4.0  # half edge of the patch of a half-space that is drawn, over the extent of the motion
FAINT = 60  # opacity of half-spaces, of 255


class NoRerun(ValueError):
    """The package `rerun-sdk` is not installed."""


def write(of: Recorded, curves: Curves, path: Path) -> Path:
    """Write the motions and the `curves` of one scenario, an entity for each engine and below it one for each body.

    Entities are `motion/ENGINE/BODY` and `curves/TITLE/ENGINE`, on the timeline `CLOCK` [s].  Engines have the colours
    that they have on the page; bodies that do not move are drawn once.

    Raises
    ------
    NoRerun
        If `rerun-sdk` is not installed.
    ValueError
        If the scene of the recording is not known.
    OSError
        If the file cannot be written.
    """
    try:
        import rerun
    except ImportError as error:
        raise NoRerun(f"{path.name}: .rrd files need the package rerun-sdk, an extra of this project") from error
    if of.scene is None:
        raise ValueError(f"{of.scenario}: its scene is not known, so its motion cannot be drawn")
    path.touch()  # an unwritable place is told as such; Rerun would write from a thread of its own
    stream = rerun.RecordingStream("plumbline", recording_id=of.scenario)
    stream.save(path)
    stream.log("motion", rerun.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    for engine, motion in of.motions.items():
        _motion(rerun, stream, of.scene, engine, motion.path)
    if of.true_path is not None:
        _motion(rerun, stream, of.scene, "truth", of.true_path)
    _curves(rerun, stream, curves)
    stream.flush()
    stream.disconnect()
    return path


def colour(engine: str) -> tuple[int, int, int]:
    """Red, green and blue of an engine, 0 to 255, as on the dark page: Rerun is dark; the truth is grey."""
    text = "#808080" if engine == "truth" else look(engine).dark
    return int(text[1:3], 16), int(text[3:5], 16), int(text[5:7], 16)


def _motion(rerun: Any, stream: Any, scene: Scene, engine: str, path: Trajectory) -> None:
    reach = float(np.nanmax(np.ptp(path.x, axis=0), initial=0.0)) + max(
        (2.0 * bounding_radius(b.shape) for b in scene.bodies if not isinstance(b.shape, HalfSpace)), default=1.0
    )
    root = rerun.escape_entity_path_part(engine)
    for i, body in enumerate(scene.bodies):
        place = f"motion/{root}/{rerun.escape_entity_path_part(body.name)}"
        stream.log(place, _drawn(rerun, body.shape, colour(engine), reach), static=True)
        known = np.isfinite(path.x[:, i]).all(axis=1) & np.isfinite(path.q[:, i]).all(axis=1)
        x, q = path.x[known, i], path.q[known, i][:, [1, 2, 3, 0]]  # Rerun puts the scalar last
        if not len(x):
            continue
        if not (np.ptp(x, axis=0).any() or np.ptp(q, axis=0).any()):
            stream.log(place, rerun.Transform3D(translation=x[0], quaternion=q[0]), static=True)
        else:
            columns = rerun.Transform3D.columns(translation=x, quaternion=q)
            stream.send_columns(place, [_clock(rerun, path.t[known])], columns)
    for k, ends in enumerate(_lines(scene, path)):
        strips = rerun.LineStrips3D.columns(strips=ends, colors=[colour(engine)] * len(ends))
        stream.send_columns(f"motion/{root}/link {k}", [_clock(rerun, path.t)], strips)


def _clock(rerun: Any, t: np.ndarray) -> Any:
    return rerun.TimeColumn(CLOCK, duration=t)


def _lines(scene: Scene, path: Trajectory) -> Iterator[np.ndarray]:
    """(T, 2, 3) ends of each rod, tether, spring and hinge arm [m]."""
    for link in links(scene):
        ends = [
            path.x[:, link[body]] + rotate(path.q[:, link[body]], np.array(link[anchor]))
            for body, anchor in (("a", "p"), ("b", "q"))
        ]
        yield np.stack(ends, axis=1)


def _drawn(rerun: Any, shape: Shape, ink: tuple[int, int, int], reach: float) -> Any:
    """The archetype of a shape in its body frame."""
    match shape:
        case Sphere(radius):
            return rerun.Ellipsoids3D(half_sizes=[[radius] * 3], colors=[ink], fill_mode="solid")
        case Box(size):
            return rerun.Boxes3D(sizes=[size], colors=[ink], fill_mode="solid")
        case Capsule(radius, length):  # Rerun's goes from the origin along z
            middle = [[0.0, 0.0, -0.5 * length]]
            return rerun.Capsules3D(lengths=[length], radii=[radius], translations=middle, colors=[ink])
        case Cylinder(radius, length):
            return rerun.Cylinders3D(lengths=[length], radii=[radius], colors=[ink], fill_mode="solid")
        case Mesh(vertices, triangles):
            return rerun.Mesh3D(vertex_positions=vertices, triangle_indices=triangles, albedo_factor=ink)
        case HalfSpace(normal):
            corners = _patch(np.array(normal), GROUND * reach)
            faces = [(0, 1, 2), (0, 2, 3)]
            return rerun.Mesh3D(vertex_positions=corners, triangle_indices=faces, albedo_factor=(*ink, FAINT))


def _patch(normal: np.ndarray, half: float) -> np.ndarray:
    """(4, 3) corners of a square of half edge `half` about the origin, across `normal`, counter-clockwise about it."""
    other = np.eye(3)[int(np.argmin(np.abs(normal)))]
    along = np.cross(normal, other)
    along /= np.linalg.norm(along)
    across = np.cross(normal, along)
    return half * np.array([along + across, across - along, -along - across, along - across])


def _curves(rerun: Any, stream: Any, curves: Curves) -> None:
    for figure in curves.figures:
        title = rerun.escape_entity_path_part(f"{figure.title}, {figure.y.label}")
        for series in figure.series:
            engine = series.engine or "truth"
            place = f"curves/{title}/{rerun.escape_entity_path_part(engine)}"
            x, y = np.asarray(series.x, dtype=np.float64), np.asarray(series.y, dtype=np.float64)
            known = np.isfinite(x) & np.isfinite(y)
            stream.log(place, rerun.SeriesLines(colors=[colour(engine)], names=[engine]), static=True)
            stream.send_columns(place, [_clock(rerun, x[known])], rerun.Scalars.columns(scalars=y[known]))
