"""Spheres, boxes and cylinders among each other, and everything over a half-space."""

from __future__ import annotations

import math

import numpy as np

from reference_impl.collide import primitives
from reference_impl.collide.features import REAL, WHOLE, margin
from reference_impl.collide.pair import Few, flight, place
from reference_impl.time_of_contact import parabola, spheres_meet


class Balls(Few):
    """Sphere and sphere."""

    single = True

    def _find(self, a, b, x, rotation, reach, kinds, reals):
        s = self.shapes.bodies
        return primitives.sphere_sphere(a, b, x[a], x[b], s.radius[a], s.radius[b], reach, kinds, reals, 0)

    def exact(self, a, b, t, m, tolerance, speed):
        if m.bounds[a, 3] or m.bounds[b, 3] or (m.bounds[a, :3] != m.bounds[b, :3]).any():
            return None
        (xa, va), (xb, vb) = place(m, a, t), place(m, b, t)
        r, v = xa - xb, va - vb
        if float(r @ v) >= -speed * math.sqrt(float(r @ r)):
            return math.inf
        return t + spheres_meet(r, v, self.shapes.bodies.radius[a] + self.shapes.bodies.radius[b])

    def approach(self, a, b, t, end, m, limits):
        from reference_impl.advancement_boxes import approach_sphere

        s = self.shapes.bodies
        return approach_sphere(t, end, *flight(m, a), s.radius[a], m.bounds[a], *flight(m, b), s.half[b],
                               s.radius[b], m.bounds[b], *limits[:2])  # fmt: skip

    def gap(self, a, b, t, m):
        from reference_impl.advancement_boxes import gap_sphere

        s = self.shapes.bodies
        return gap_sphere(t, *flight(m, a), s.radius[a], *flight(m, b), s.half[b], s.radius[b])


class BallBox(Balls):
    """Sphere and box."""

    bounded = True

    def _find(self, a, b, x, rotation, reach, kinds, reals):
        s = self.shapes.bodies
        return primitives.sphere_box(a, b, x[a], x[b], rotation[b], s.radius[a], s.half[b], reach, kinds, reals, 0)

    def exact(self, a, b, t, m, tolerance, speed):
        return None

    def margin(self, kinds, reals, x, rotation):
        i, j = kinds[:2].tolist()
        half = self.shapes.bodies.half
        return margin(kinds, reals, x[i], rotation[i], x[j], rotation[j], half[i], half[j])


class Boxes(Few):
    """Box and box."""

    bounded = True
    margin = BallBox.margin

    def _find(self, a, b, x, rotation, reach, kinds, reals):
        from reference_impl.collide.boxes import box_box

        half = self.shapes.bodies.half
        return box_box(
            a, b, x[a], rotation[a], half[a], x[b], rotation[b], half[b], reach, reach, kinds, reals, 0
        )[0]  # fmt: skip

    def approach(self, a, b, t, end, m, limits):
        from reference_impl.advancement_boxes import approach_boxes

        half = self.shapes.bodies.half
        return approach_boxes(t, end, *flight(m, a), half[a], m.bounds[a], *flight(m, b), half[b], m.bounds[b],
                              *limits)  # fmt: skip

    def gap(self, a, b, t, m):
        from reference_impl.advancement_boxes import gap_boxes

        half = self.shapes.bodies.half
        return gap_boxes(t, *flight(m, a), half[a], *flight(m, b), half[b])


class Grounded(Few):
    """Box or solid over a half-space."""

    def _find(self, a, b, x, rotation, reach, kinds, reals):
        s, b_ = self.shapes, self.shapes.bodies
        return primitives.corners_plane(a, b, x[a], rotation[a], s.corners_of(a), s.radius_of(a), x[b], b_.normal[b],
                                        s.local[b], reach, kinds, reals, 0)  # fmt: skip

    def contacts(self, a, b, x, rotation, reach):
        most = len(self.shapes.corners_of(a))
        kinds, reals = np.zeros((most, WHOLE), dtype=np.int64), np.zeros((most, REAL))
        count = self._find(a, b, x, rotation, reach, kinds, reals)
        return kinds[:count], reals[:count]

    def approach(self, a, b, t, end, m, limits):
        from reference_impl.advancement import approach_plane

        s = self.shapes
        return approach_plane(t, end, *flight(m, a), s.corners_of(a), s.radius_of(a), m.bounds[a], m.begin[b],
                              m.x_series[b], s.bodies.normal[b], m.bounds[b], *limits)  # fmt: skip

    def gap(self, a, b, t, m):
        from reference_impl.advancement import gap_plane

        s = self.shapes
        return gap_plane(t, *flight(m, a), s.corners_of(a), s.radius_of(a), m.begin[b], m.x_series[b],
                         s.bodies.normal[b])  # fmt: skip


class BallGround(Grounded):
    """Sphere over a half-space."""

    single = True

    def _find(self, a, b, x, rotation, reach, kinds, reals):
        s = self.shapes.bodies
        return primitives.sphere_plane(a, b, x[a], x[b], s.radius[a], s.normal[b], self.shapes.local[b], reach, kinds,
                                       reals, 0)  # fmt: skip

    def exact(self, a, b, t, m, tolerance, speed):
        if m.bounds[a, 3] or m.bounds[b, 3]:
            return None
        s = self.shapes.bodies
        n = s.normal[b]
        (xa, va), (xb, vb) = place(m, a, t), place(m, b, t)
        gap, rate = float(n @ (xa - xb)) - s.radius[a], float(n @ (va - vb))
        pull = float(n @ (m.bounds[a, :3] - m.bounds[b, :3]))
        if gap <= tolerance and abs(rate) <= speed and pull >= 0.0:
            return math.inf
        return t + parabola(gap, rate, pull)


class CylinderGround(Few):
    """Cylinder over a half-space."""

    def _find(self, a, b, x, rotation, reach, kinds, reals):
        from reference_impl.collide.cylinders import cylinder_plane

        s = self.shapes.bodies
        return cylinder_plane(a, b, x[a], rotation[a], *self.shapes.cylinder(a), x[b], s.normal[b],
                              self.shapes.local[b], s.acceleration[a] - s.acceleration[b], reach, kinds, reals,
                              0)  # fmt: skip

    def approach(self, a, b, t, end, m, limits):
        from reference_impl.advancement_rims import approach_rims_plane

        return approach_rims_plane(t, end, *flight(m, a), *self.shapes.cylinder(a), m.bounds[a], m.begin[b],
                                   m.x_series[b], self.shapes.bodies.normal[b], m.bounds[b], *limits)  # fmt: skip

    def gap(self, a, b, t, m):
        from reference_impl.advancement_rims import gap_rims_plane

        return gap_rims_plane(t, *flight(m, a), *self.shapes.cylinder(a), m.begin[b], m.x_series[b],
                              self.shapes.bodies.normal[b])  # fmt: skip


class BallCylinder(Few):
    """Sphere and cylinder."""

    single = True
    bounded = True

    def _find(self, a, b, x, rotation, reach, kinds, reals):
        from reference_impl.collide.cylinders import sphere_cylinder

        return sphere_cylinder(a, b, x[a], x[b], rotation[b], self.shapes.bodies.radius[a], *self.shapes.cylinder(b),
                               reach, kinds, reals, 0)  # fmt: skip

    def approach(self, a, b, t, end, m, limits):
        from reference_impl.advancement_rims import approach_sphere_cylinder

        return approach_sphere_cylinder(t, end, *flight(m, a), self.shapes.bodies.radius[a], m.bounds[a],
                                        *flight(m, b), *self.shapes.cylinder(b), m.bounds[b], *limits[:2])  # fmt: skip

    def gap(self, a, b, t, m):
        from reference_impl.advancement_rims import gap_sphere_cylinder

        return gap_sphere_cylinder(t, *flight(m, a), self.shapes.bodies.radius[a], *flight(m, b),
                                   *self.shapes.cylinder(b))  # fmt: skip

    def margin(self, kinds, reals, x, rotation):
        from reference_impl.collide.cylinders import cylinder_margin

        i, j = kinds[:2].tolist()
        return cylinder_margin(kinds[2], rotation[j].T @ (x[i] - x[j]), *self.shapes.cylinder(j))
