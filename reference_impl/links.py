"""What ties bodies together whether they touch or not: joints and springs.

Bodies that are tied are never in free flight: they are under forces for as long as the scene lasts, or at rest.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from reference_impl.effects import joint, spring
from reference_impl.effects.joint import Joints
from reference_impl.effects.spring import Springs
from reference_impl.parts import Parts


class Links(NamedTuple):
    """Rows of joints, and springs, some or all of a scene."""

    joints: Joints
    springs: Springs
    free: np.ndarray  # (n,) whether each body of the scene has a mass

    @staticmethod
    def of(parts: Parts, free: np.ndarray) -> Links | None:
        """All joints and springs of a scene; None if there are none."""
        links = Links(joint.all_of(parts.joints), spring.all_of(parts.springs), free)
        return links if len(links.ends) else None

    @property
    def ends(self) -> np.ndarray:
        """The two bodies of every row, (rows, 2)."""
        return np.concatenate([self.joints.kinds[:, 1:3], self.springs.ends])

    def chosen(self, which: np.ndarray) -> Links | None:
        """The rows selected, by a boolean array in the order of `ends`; None if there are none."""
        if not which.any():
            return None
        rows = len(self.joints.kinds)
        return self._replace(joints=self.joints.chosen(which[:rows]), springs=self.springs.chosen(which[rows:]))

    def within(self, bodies: np.ndarray) -> Links | None:
        """The rows of the moving bodies among `bodies` (boolean); None if there are none."""
        return self.chosen((bodies & self.free)[self.ends].any(axis=1))

    def spread(self, bodies: np.ndarray) -> bool:
        """Add to `bodies` (boolean) every moving body tied to one of them, and so on; whether any was added."""
        before = int(bodies.sum())
        ends = self.ends
        while True:
            tied = ends[(bodies & self.free)[ends].any(axis=1)].ravel()
            new = tied[self.free[tied] & ~bodies[tied]]
            if not len(new):
                return int(bodies.sum()) > before
            bodies[new] = True
