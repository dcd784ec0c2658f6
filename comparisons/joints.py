"""How far apart joints have come, from the motion alone."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from mechanics.arrays import Scalars
from mechanics.effects import Hinge, Rod, Tether
from mechanics.rotation import rotate, unrotate
from mechanics.scene import Scene
from mechanics.shapes import bounding_radius
from mechanics.trajectory import Trajectory


class Joint(NamedTuple):
    """A joint on its way: by how much it is wrong, and how large it is itself."""

    name: str
    error: Scalars  # (T,) distance of a hinge's two sides, change of a rod's length, excess of a tether's [m]
    size: float  # bounding radius of a hinge's smallest moving body, length of a rod or a tether [m]


def joints(scene: Scene, trajectory: Trajectory) -> Iterator[Joint]:
    """Every hinge, rod and tether of the scene that holds a moving body."""
    for hinge in scene.all(Hinge):
        at_start = [_local(scene, name, hinge.point) for name in (hinge.a, hinge.b)]
        ends = [_path(scene, trajectory, n, p) for n, p in zip((hinge.a, hinge.b), at_start, strict=True)]
        radii = [bounding_radius(b.shape) for b in map(scene.body, (hinge.a, hinge.b)) if not b.fixed]
        if radii:
            yield Joint(f"{hinge.a} and {hinge.b}", np.linalg.norm(ends[0] - ends[1], axis=1), min(radii))
    for link in (*scene.all(Rod), *scene.all(Tether)):
        ends = [_path(scene, trajectory, n, p) for n, p in ((link.a, link.anchor_a), (link.b, link.anchor_b))]
        distance = np.linalg.norm(ends[0] - ends[1], axis=1)
        if isinstance(link, Tether):
            yield Joint(f"{link.a} and {link.b}", np.maximum(distance - link.length, 0.0), link.length)
        elif distance[0] > 0.0:
            yield Joint(f"{link.a} and {link.b}", np.abs(distance - distance[0]), float(distance[0]))


def _local(scene: Scene, name: str, point: tuple[float, ...]) -> np.ndarray:
    """A point of the world at the start, in the frame of a body."""
    body = scene.body(name)
    return unrotate(np.array(body.orientation), np.subtract(point, body.position))


def _path(scene: Scene, trajectory: Trajectory, name: str, point: np.ndarray | tuple[float, ...]) -> np.ndarray:
    """(T, 3) where a point of a body (body frame) is [m]."""
    i = scene.index(name)
    return np.asarray(trajectory.x[:, i] + rotate(trajectory.q[:, i], np.array(point)))
