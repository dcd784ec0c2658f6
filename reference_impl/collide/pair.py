"""What every combination of two shapes provides, and what it needs of the bodies."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from functools import cached_property
from typing import Any

import numpy as np

from mechanics.scene import Scene
from mechanics.shapes import Cylinder
from reference_impl.collide import primitives
from reference_impl.collide.features import REAL, WHOLE
from reference_impl.collide.solids import Solid, solid_of
from reference_impl.state import BOX, SOLID, Bodies, Motion

MOST = 40  # contacts of one pair of boxes: eight corners of a common polygon and room to spare

Found = tuple[np.ndarray, np.ndarray]  # kinds and reals of contacts
Limits = tuple[float, float, bool, float, float]  # tolerance, speed, touching, reach, parting


class Shapes:
    """What the routines need of the bodies of a scene, made when it is asked for."""

    def __init__(self, scene: Scene, bodies: Bodies) -> None:
        self.scene, self.bodies = scene, bodies
        self.local = np.array([getattr(body.shape, "normal", (0.0, 0.0, 0.0)) for body in scene.bodies])
        self._solids: dict[int, Solid] = {}
        self.kinds, self.reals = np.zeros((MOST, WHOLE), dtype=np.int64), np.zeros((MOST, REAL))

    def solid(self, i: int) -> Solid:
        """Body i as a solid."""
        if i not in self._solids:
            self._solids[i] = solid_of(self.scene.bodies[i].shape)
        return self._solids[i]

    def cylinder(self, i: int) -> tuple[float, float]:
        """Radius and half length of body i [m]."""
        shape = self.scene.bodies[i].shape
        assert isinstance(shape, Cylinder)
        return shape.radius, 0.5 * shape.length

    @cached_property
    def corners(self) -> dict[int, np.ndarray]:
        """Corners of boxes and solids, the centre of spheres; filled by `corners_of`."""
        return {}

    def corners_of(self, i: int) -> np.ndarray:
        """Points whose hull, widened by `radius_of`, body i is (k, 3) [m]."""
        if i not in self.corners:
            if self.bodies.shape[i] == SOLID:
                solid = self.solid(i)
                self.corners[i] = np.ascontiguousarray(solid.points[solid.sharp])
            else:
                out = np.zeros((8 if self.bodies.shape[i] == BOX else 1, 3))
                for j in range(len(out)):
                    primitives.corner(self.bodies.half[i], j, out[j])
                self.corners[i] = out
        return self.corners[i]

    def radius_of(self, i: int) -> float:
        """See `corners_of` [m]."""
        return self.solid(i).radius if self.bodies.shape[i] == SOLID else float(self.bodies.radius[i])


class Pair(ABC):
    """Two shapes a and b; methods take the bodies' numbers in the order of the pair.

    Attributes
    ----------
    single : bool
        Whether they touch at one place at most.
    bounded : bool
        Whether a contact can slide off its features.
    """

    single = False
    bounded = False

    def __init__(self, shapes: Shapes) -> None:
        self.shapes = shapes

    @abstractmethod
    def contacts(self, a: int, b: int, x: np.ndarray, rotation: np.ndarray, reach: float) -> Found:
        """Touching features with a gap of at most `reach` [m]."""

    def exact(self, a: int, b: int, t: float, m: Motion, tolerance: float, speed: float) -> float | None:
        """Time of contact where there is a closed form [s], else None."""
        return None

    @abstractmethod
    def approach(self, a: int, b: int, t: float, end: float, m: Motion, limits: Limits) -> tuple[float, int, int]:
        """Conservative advancement, as `advancement.approach_plane`."""

    @abstractmethod
    def gap(self, a: int, b: int, t: float, m: Motion) -> tuple[float, float]:
        """Gap [m] and its rate [m/s]."""

    def margin(self, kinds: np.ndarray, reals: np.ndarray, x: np.ndarray, rotation: np.ndarray) -> float:
        """How far inside its features a contact lies [m]."""
        return math.inf

    def overlap(self, a: int, b: int, x: np.ndarray, rotation: np.ndarray, slack: float) -> float:
        """Overlap that `contacts` does not see [m]."""
        return 0.0


class Few(Pair):
    """Two shapes that touch at `MOST` places at most."""

    def contacts(self, a: int, b: int, x: np.ndarray, rotation: np.ndarray, reach: float) -> Found:
        s = self.shapes
        count = self._find(a, b, x, rotation, reach, s.kinds, s.reals)
        return s.kinds[:count].copy(), s.reals[:count].copy()

    @abstractmethod
    def _find(self, a: int, b: int, x: np.ndarray, rotation: np.ndarray, reach: float, kinds: Any, reals: Any) -> int:
        """Write the touching features into `kinds` and `reals`; returns how many there are."""


def flight(m: Motion, i: int) -> tuple[float, np.ndarray, np.ndarray]:
    """When the segment of body i begins [s], and its series of position and attitude."""
    return m.begin[i], m.x_series[i], m.q_series[i]


def place(m: Motion, i: int, t: float) -> tuple[np.ndarray, np.ndarray]:
    """Position and velocity of a body on a parabola at time t."""
    s = t - m.begin[i]
    series = m.x_series[i]
    return series[0] + s * (series[1] + s * series[2]), series[1] + 2.0 * s * series[2]
