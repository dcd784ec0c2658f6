"""Penetration: how deep bodies overlap that must not, from their poses alone.

Computed by the house's own geometry (see `gap`), never from an engine's list of contacts: such lists
belong to the start of the step in one engine and hold points that do not touch yet in another.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from comparisons.gap import Pose, bounded_gap, unmeasurable
from comparisons.measurement import Case, Quantity
from mechanics.scene import Scene
from mechanics.shapes import bounding_radius
from mechanics.trajectory import Trajectory

QUANTITIES = {
    "penetration": ("m", "deepest overlap of two bodies that may touch, over all pairs and samples"),
}


def measure(case: Case) -> Iterator[Quantity]:
    """Deepest overlap of the case, with the pair and the time."""
    pairs = list(case.scene.pairs())
    if not pairs:
        return
    shapes, names = [b.shape for b in case.scene.bodies], case.scene.names
    blind = {pair: why for pair in pairs if (why := unmeasurable(shapes[pair[0]], shapes[pair[1]]))}
    left_out = "; ".join(f"not measured: {names[i]} and {names[j]} ({why})" for (i, j), why in blind.items())
    if len(blind) == len(pairs):
        yield Quantity("penetration", np.nan, "m", text=left_out)
        return
    depth, where, pair = 0.0, 0, None
    for i, j in close_pairs(case.scene, case.trajectory):
        if (i, j) in blind:
            continue
        gaps = bounded_gap(shapes[i], shapes[j], pose(case.trajectory, i), pose(case.trajectory, j))
        lowest = int(np.argmin(gaps))
        if gaps[lowest] < -depth:
            depth, where, pair = -float(gaps[lowest]), lowest, (i, j)
    words = [f"{names[pair[0]]} and {names[pair[1]]}"] if pair else []
    text = "; ".join([*words, *filter(None, [left_out])])
    yield Quantity("penetration", depth, "m", float(case.trajectory.t[where]) if pair else np.nan, text)


def pose(trajectory: Trajectory, i: int) -> Pose:
    """Positions and orientations of body i."""
    return Pose(trajectory.x[:, i], trajectory.q[:, i])


def close_pairs(scene: Scene, trajectory: Trajectory, margin: float = 0.0) -> Iterator[tuple[int, int]]:
    """Pairs that may touch and whose bounding balls, widened by `margin` [m], meet at some sample."""
    radius = np.array([bounding_radius(b.shape) for b in scene.bodies])
    reach = radius[:, None] + margin
    low, high = trajectory.x.min(axis=0) - reach, trajectory.x.max(axis=0) + reach
    meet = ((low[:, None] <= high[None]) & (low[None] <= high[:, None])).all(axis=2)  # the boxes they sweep
    partners: dict[int, list[int]] = {}
    for i, j in scene.pairs():
        if meet[i, j]:
            partners.setdefault(i, []).append(j)
    for i, others in partners.items():
        apart = np.linalg.norm(trajectory.x[:, others] - trajectory.x[:, i, None], axis=2).min(axis=0)
        yield from ((i, j) for j, d in zip(others, apart, strict=True) if d <= radius[i] + radius[j] + 2.0 * margin)
