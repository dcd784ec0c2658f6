"""Solids (meshes and capsules) among each other, and with boxes and spheres."""

from __future__ import annotations

import numpy as np

from mechanics.scene import Body
from mechanics.shapes import Mesh
from reference_impl.collide.features import REAL, WHOLE
from reference_impl.collide.pair import MOST, Pair, flight
from reference_impl.state import BOX

DEEP = 1e-4  # overlap up to which features of solids count as touching [size of the smaller]


class Solids(Pair):
    """Solid and solid, box or sphere."""

    bounded = True

    def contacts(self, a, b, x, rotation, reach):
        from reference_impl.collide.solid_contacts import near_cells, solid_solid

        sa, sb = self.shapes.solid(a), self.shapes.solid(b)
        cells = np.empty((256, 2), dtype=np.int64)
        while (near := near_cells(sa, sb, x[a], rotation[a], x[b], rotation[b], reach, cells)) > len(cells):
            cells = np.empty((near, 2), dtype=np.int64)
        size = DEEP * min(self.shapes.bodies.reach[a], self.shapes.bodies.reach[b])
        most = MOST
        while True:
            kinds, reals = np.zeros((most, WHOLE), dtype=np.int64), np.zeros((most, REAL))
            points, normals = np.empty((most, 4)), np.empty((most, 3))
            count = solid_solid(a, b, sa, x[a], rotation[a], sb, x[b], rotation[b], reach, size, reach, cells[:near],
                                kinds, reals, np.empty(most, dtype=np.bool_), points, normals)  # fmt: skip
            if count < most:
                break
            most *= 4
        if sa.convex and sb.convex and sa.radius + sb.radius == 0.0 and count > 1:
            # each normal alone separates the two: that of the most contacts is the face they share
            same = normals[:count] @ normals[:count].T > 1.0 - 1e-12
            chosen = same[int(np.argmax(same.sum(axis=1)))]
            return kinds[:count][chosen], reals[:count][chosen]
        return kinds[:count], reals[:count]

    def approach(self, a, b, t, end, m, limits):
        from reference_impl.advancement_solids import approach_solids

        s = self.shapes
        return approach_solids(t, end, *flight(m, a), s.solid(a), m.bounds[a], *flight(m, b), s.solid(b),
                               m.bounds[b], *limits)  # fmt: skip

    def gap(self, a, b, t, m):
        from reference_impl.advancement_solids import gap_solids

        return gap_solids(t, *flight(m, a), self.shapes.solid(a), *flight(m, b), self.shapes.solid(b))

    def margin(self, kinds, reals, x, rotation):
        from reference_impl.collide.solid_contacts import solid_margin

        i, j = kinds[:2].tolist()
        s = self.shapes
        return solid_margin(kinds, reals, s.solid(i), x[i], rotation[i], s.solid(j), x[j], rotation[j])

    def overlap(self, a, b, x, rotation, slack):
        from reference_impl.advancement_solids import separation

        sa, sb, zero = self.shapes.solid(a), self.shapes.solid(b), np.zeros(3)
        gap, _ = separation(x[a] - x[b], zero, rotation[a], zero, sa, rotation[b], zero, sb)
        if gap < -slack:
            return -gap
        return max(self._inside(a, b, x, rotation), self._inside(b, a, x, rotation))

    def _inside(self, a: int, b: int, x: np.ndarray, rotation: np.ndarray) -> float:
        """How deep a point of a is within b while the surfaces do not cross [m]."""
        from reference_impl.collide.field import distance_of

        body: Body = self.shapes.scene.bodies[b]
        if not isinstance(body.shape, Mesh) and self.shapes.bodies.shape[b] != BOX:
            return 0.0
        point = rotation[b].T @ (x[a] + rotation[a] @ self.shapes.solid(a).points[0] - x[b])
        depth = -float(distance_of(body.shape)(point[None])[0])
        return depth if depth > self.shapes.bodies.reach[a] * DEEP else 0.0
