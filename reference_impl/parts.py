"""What effects bring to the engine, and how the contributions of several effects are put together.

loads     summed while they act; springs, whose pull follows the motion, are summed where the motion is known
joints    rows that hold, stacked
cords     touches that are no contact of shapes: the slack of a tether is its gap
law       what happens at a touch, put together field by field
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mechanics.effects import Friction, Restitution
from reference_impl.state import SPHERE, Bodies

if TYPE_CHECKING:
    from reference_impl.effects.joint import Joints
    from reference_impl.effects.spring import Springs
    from reference_impl.effects.tether import Cords


@dataclass(frozen=True)
class Load:
    """Forces and torques on n bodies while start <= t < end: constant, or linear in the velocities.

    Attributes are those of the same name in `Bodies`; None stands for zero.
    """

    acceleration: np.ndarray | None = None
    torque: np.ndarray | None = None
    lever: np.ndarray | None = None
    drag: np.ndarray | None = None
    spin_drag: np.ndarray | None = None
    start: float = 0.0
    end: float = math.inf


@dataclass(frozen=True)
class Law:
    """What happens at a touch.

    Attributes
    ----------
    touching : bool
        Whether bodies touch at all; without any contact effect they pass through each other.
    restitution : Restitution or None
        None: no impact may happen.
    resting : bool
        Whether contact may last.
    friction : Friction or None
        None: contact is smooth.
    """

    touching: bool = False
    restitution: Restitution | None = None
    resting: bool = False
    friction: Friction | None = None

    def __or__(self, other: Law) -> Law:
        return Law(
            self.touching or other.touching,
            self.restitution or other.restitution,
            self.resting or other.resting,
            self.friction or other.friction,
        )


@dataclass(frozen=True)
class Parts:
    """The parts of one effect, or of all of them together."""

    loads: tuple[Load, ...] = ()
    law: Law = Law()
    joints: tuple[Joints, ...] = ()
    springs: tuple[Springs, ...] = ()
    cords: tuple[Cords, ...] = ()

    def __add__(self, other: Parts) -> Parts:
        return Parts(
            self.loads + other.loads,
            self.law | other.law,
            self.joints + other.joints,
            self.springs + other.springs,
            self.cords + other.cords,
        )

    def switches(self) -> list[float]:
        """Times at which a load begins or ends [s], in order."""
        times = {t for load in self.loads for t in (load.start, load.end) if 0.0 < t < math.inf}
        return sorted(times)

    def loaded(self, bodies: Bodies, t: float) -> Bodies:
        """`bodies` with the sum of the loads that act from time t on."""
        names = ("acceleration", "torque", "lever", "drag", "spin_drag")
        sums = {name: getattr(bodies, name).copy() for name in names}
        for load in self.loads:
            if load.start <= t < load.end:
                for name, total in sums.items():
                    part = getattr(load, name)
                    if part is not None:
                        total += part
        still = ~(bodies.quickness > 0.0)
        for name in ("torque", "lever", "spin_drag"):
            sums[name][still] = 0.0
        twisted = (
            np.any(sums["torque"] != 0.0, axis=1) | np.any(sums["lever"] != 0.0, axis=(1, 2)) | (sums["spin_drag"] > 0)
        )
        return bodies._replace(**sums, twisted=twisted, plain=_plain(bodies) & ~twisted)


def _plain(bodies: Bodies) -> np.ndarray:
    """Spheres with an isotropic inertia: their angular velocity is constant in flight."""
    diagonal = np.einsum("ijj->ij", bodies.inertia)
    isotropic = (bodies.unevenness == 0.0) & np.all(bodies.inertia == diagonal[:, :, None] * np.eye(3), axis=(1, 2))
    return (bodies.shape == SPHERE) & isotropic & (bodies.quickness > 0.0)
