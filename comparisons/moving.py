"""The bodies that have a mass, with their motion: what momentum, energy and their scales are summed over."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mechanics.effects import Force
from mechanics.rotation import rotate, unrotate
from mechanics.scene import Scene
from mechanics.shapes import bounding_radius
from mechanics.trajectory import Trajectory


@dataclass(frozen=True)
class Moving:
    """The k bodies with a mass at T times.

    Attributes
    ----------
    scene : Scene
    t : (T,) array [s]
    x, v, w : (T, k, 3) arrays; q : (T, k, 4) array
        As in `Trajectory`.
    """

    scene: Scene
    t: np.ndarray
    x: np.ndarray
    q: np.ndarray
    v: np.ndarray
    w: np.ndarray

    @staticmethod
    def of(scene: Scene, trajectory: Trajectory) -> Moving:
        """The moving bodies of `scene` as they move in `trajectory`."""
        rows = list(scene.moving)
        motion = (getattr(trajectory, name)[:, rows] for name in ("x", "q", "v", "w"))
        return Moving(scene, trajectory.t, *motion)

    @cached_property
    def mass(self) -> np.ndarray:
        """(k,) [kg]."""
        return np.array([self.scene.bodies[i].mass for i in self.scene.moving], dtype=np.float64)

    @cached_property
    def inertia(self) -> np.ndarray:
        """(k, 3, 3) about the centres of mass, body frames [kg m2]."""
        return np.array([self.scene.bodies[i].inertia_tensor for i in self.scene.moving]).reshape(-1, 3, 3)

    @cached_property
    def radius(self) -> np.ndarray:
        """(k,) radii of the balls that hold the bodies [m]."""
        return np.array([bounding_radius(self.scene.bodies[i].shape) for i in self.scene.moving])

    @cached_property
    def gyration(self) -> np.ndarray:
        """(k,) radii of gyration, √(trace I / 2m) [m]."""
        return np.asarray(np.sqrt(0.5 * np.trace(self.inertia, axis1=1, axis2=2) / self.mass))

    @cached_property
    def pull(self) -> np.ndarray:
        """(k,) magnitude of the acceleration by gravity and constant forces, added up without sign [m/s2]."""
        forces = np.zeros(len(self.mass))
        for force in self.scene.all(Force):
            forces[self.scene.moving.index(self.scene.index(force.body))] += np.linalg.norm(force.force)
        return np.asarray(np.linalg.norm(self.scene.gravity) + forces / self.mass)

    @cached_property
    def speed_scale(self) -> np.ndarray:
        """(k,) the largest speed of each body, or what it would gain falling its own radius if that is more [m/s].

        The second keeps the creep of a body at rest from being measured against itself.
        """
        fastest = np.linalg.norm(self.v, axis=2).max(axis=0)
        return np.asarray(np.maximum(fastest, np.sqrt(2.0 * self.pull * self.radius)))

    @cached_property
    def spin(self) -> np.ndarray:
        """(T, k, 3) angular momenta about the bodies' own centres of mass, I ω, world frame [kg m2/s]."""
        if not self.w.any():
            return np.zeros_like(self.w)
        body = np.einsum("kij,tkj->tki", self.inertia, unrotate(self.q, self.w))
        return np.asarray(rotate(self.q, body))

    @cached_property
    def kinetic(self) -> np.ndarray:
        """(T,) kinetic energy ½ m v² + ½ ω·I ω, summed over the bodies [J]."""
        translation = np.einsum("k,tki,tki->t", self.mass, self.v, self.v)
        return np.asarray(0.5 * (translation + np.einsum("tki,tki->t", self.w, self.spin)))

    @cached_property
    def momentum(self) -> np.ndarray:
        """(T, 3) linear momentum [kg m/s]."""
        return np.asarray(np.einsum("k,tki->ti", self.mass, self.v))

    @cached_property
    def centre(self) -> np.ndarray:
        """(T, 3) common centre of mass [m]."""
        return np.asarray(np.einsum("k,tki->ti", self.mass / self.mass.sum(), self.x))

    def orbital(self, pivot: np.ndarray | None) -> np.ndarray:
        """(T, k, 3) angular momenta m r × v of the centres of mass [kg m2/s].

        About the fixed point `pivot` [m], or about the common centre of mass (None), there with
        velocities relative to it.
        """
        if pivot is None:
            away, speed = self.x - self.centre[:, None], self.v - (self.momentum / self.mass.sum())[:, None]
        else:
            away, speed = self.x - np.asarray(pivot), self.v
        return np.asarray(self.mass[:, None] * np.cross(away, speed))
