"""Degenerate positions: what touches is listed whole and once, whatever coincides."""

from itertools import product

import numpy as np
import pytest

from mechanics.effects import Resting, Rotation
from mechanics.scene import Body, Scene
from mechanics.shapes import Box
from reference_impl.collide.detect import kinematics, rotations
from reference_impl.simulate import begin


def touches(*bodies):
    """Points (m, 3) and normals of all contacts of these bodies as they stand [m]."""
    world = begin(Scene(bodies, (Resting(), Rotation())))
    rotation = rotations(world.motion.q)
    found = world.detector.contacts(world.motion.x, rotation, np.ones(len(bodies), dtype=bool))
    k = kinematics(found, world.motion.x, rotation, world.motion.v, world.motion.v)
    return k.point, k.normal


@pytest.mark.parametrize("swapped", [False, True])
@pytest.mark.parametrize(("hx", "hy"), [(0.2, 0.2), (0.2, 0.25), (0.25, 0.25)])
def test_boxes_face_to_face_touch_at_the_corners_of_their_common_rectangle(hx, hy, swapped):
    """Borders that coincide on none, one, two, three or four sides; a common edge; a common corner."""
    lower = Body("a", Box((2.0 * hx, 2.0 * hy, 0.2)), 1.0, (0.0, 0.0, 0.1))
    for gx, gy, x, y in product((0.2, 0.25, 0.5), (0.2, 0.25), (0.0, 0.05, 0.25, 0.45), (0.0, 0.05, 0.4, 0.45)):
        upper = Body("b", Box((2.0 * gx, 2.0 * gy, 0.4)), 1.0, (x, y, 0.4))
        low, high = (max(-hx, x - gx), max(-hy, y - gy)), (min(hx, x + gx), min(hy, y + gy))
        if high[0] - low[0] < -1e-12 or high[1] - low[1] < -1e-12:
            continue
        points, normals = touches(*((upper, lower) if swapped else (lower, upper)))
        expected = {(round(p, 9), round(q, 9)) for p in (low[0], high[0]) for q in (low[1], high[1])}
        found = [(round(p, 9), round(q, 9)) for p, q, _ in points.tolist()]
        assert sorted(found) == sorted(expected), (gx, gy, x, y)
        assert np.abs(np.abs(normals[:, 2]) - 1.0).max() == 0.0
