"""What two shapes do together: one class for each combination.

A pair is put in the order sphere, box, cylinder, solid, half-space.  A solid is a mesh or capsule; a sphere or
box becomes one beside it.
"""

from __future__ import annotations

import numpy as np

from mechanics.scene import Scene
from reference_impl.broad_phase import all_pairs
from reference_impl.collide.pair import Pair, Shapes
from reference_impl.collide.simple_pairs import (
    BallBox,
    BallCylinder,
    BallGround,
    Balls,
    Boxes,
    CylinderGround,
    Grounded,
)  # fmt: skip
from reference_impl.collide.solid_pairs import Solids
from reference_impl.errors import Unsupported
from reference_impl.state import BOX, CYLINDER, PLANE, SOLID, SPHERE

ORDER = (SPHERE, BOX, CYLINDER, SOLID, PLANE)

TABLE: dict[tuple[int, int], type[Pair]] = {
    (SPHERE, SPHERE): Balls,
    (SPHERE, BOX): BallBox,
    (SPHERE, CYLINDER): BallCylinder,
    (SPHERE, SOLID): Solids,
    (SPHERE, PLANE): BallGround,
    (BOX, BOX): Boxes,
    (BOX, SOLID): Solids,
    (BOX, PLANE): Grounded,
    (CYLINDER, PLANE): CylinderGround,
    (SOLID, SOLID): Solids,
    (SOLID, PLANE): Grounded,
}


class Routines:
    """The routine of each pair, of which there may be millions."""

    def __init__(self, made: list[Pair], which: np.ndarray) -> None:
        self._made, self._which = made, which

    def __getitem__(self, p: int) -> Pair:
        return self._made[self._which[p]]

    def __add__(self, others: list[Pair]) -> Routines:
        """These and, after them, one for each of others."""
        if not others:
            return self
        numbers = len(self._made) + np.arange(len(others))
        return Routines(self._made + others, np.concatenate([self._which, numbers]))


def pairs_of(scene: Scene, shapes: Shapes) -> tuple[Routines, np.ndarray]:
    """Pairs of bodies that may touch: the routine of each, and their numbers (p, 2) in its order.

    Raises
    ------
    Unsupported
        If there is no routine for two shapes.
    """
    pairs, shape = all_pairs(scene), shapes.bodies.shape
    rank = np.argsort(ORDER)[shape]
    swapped = rank[pairs[:, 0]] > rank[pairs[:, 1]]
    pairs[swapped] = pairs[swapped, ::-1]
    which = np.full(len(pairs), -1, dtype=np.int8)
    for number, (first, second) in enumerate(TABLE):
        which[(shape[pairs[:, 0]] == first) & (shape[pairs[:, 1]] == second)] = number
    for ends in pairs[which < 0].tolist():
        a, b = (f"{scene.bodies[k].name!r}, a {type(scene.bodies[k].shape).__name__}" for k in ends)
        raise Unsupported(f"contact of {a}, with {b}: a Cylinder touches only Sphere and HalfSpace")
    return Routines([kind(shapes) for kind in TABLE.values()], which), pairs
