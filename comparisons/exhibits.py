"""Single figures that speak for themselves, measured where the label of an exhibit names them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from comparisons.measurement import Case, Quantity
from mechanics.scene import Scene
from mechanics.shapes import Box
from mechanics.trajectory import Trajectory

QUANTITIES = {
    "final speed": ("m/s", "speed of the fastest moving body at the last sample"),
    "final velocities": ("", "velocities along x of all moving bodies at the last sample [m/s]"),
    "creep speed": ("m/s", "way of the body that moved most in the second half of the run, over its time"),
    "stopping distance": ("m", "distance of the body that moved farthest from where it started, at the last sample"),
    "turned aside": ("deg", "angle from the velocity at the start to the way of that body, positive to the left"),
    "passed through": ("1", "number of moving bodies that ended on the other side of a fixed box in their way"),
}


def measure(case: Case) -> Iterator[Quantity]:
    """The figures that the label of the scenario names and that are not measured elsewhere."""
    label, moving = case.scenario.exhibit, case.moving
    wanted = [name for name in QUANTITIES if case.asks(name) or (label is not None and name in label.figures)]
    if not wanted or not len(moving.mass):
        return
    way, end = moving.x[-1] - moving.x[0], float(moving.t[-1])
    farthest = int(np.argmax(np.linalg.norm(way, axis=1)))
    for name in wanted:
        unit, text, value = QUANTITIES[name][0], "", np.nan
        match name:
            case "final speed":
                value = np.linalg.norm(moving.v[-1], axis=1).max()
            case "final velocities":
                text = " ".join(f"{v + 0.0:.3g}" for v in np.round(moving.v[-1, :, 0], 3))
            case "creep speed":
                middle = len(moving.t) // 2
                steady = np.linalg.norm(moving.x[-1] - moving.x[middle], axis=1)
                value = steady.max() / (moving.t[-1] - moving.t[middle])
            case "stopping distance":
                value = np.linalg.norm(way[farthest])
            case "turned aside":
                value = _aside(moving.v[0, farthest], way[farthest])
            case "passed through":
                value = len(passed(case.scene, case.trajectory))
        yield Quantity(name, float(value), unit, end, text)


def passed(scene: Scene, trajectory: Trajectory) -> list[str]:
    """Moving bodies whose straight way from start to end leads through a fixed, unturned box, not beside it."""
    found = []
    for i in scene.moving:
        start, end = trajectory.x[0, i], trajectory.x[-1, i]
        for body in scene.bodies:
            if body.fixed and isinstance(body.shape, Box) and _crosses(start, end, np.array(body.position), body.shape):
                found.append(scene.names[i])
                break
    return found


def _crosses(start: np.ndarray, end: np.ndarray, centre: np.ndarray, box: Box) -> bool:
    """Whether the way leads in at one thin face and out at the other; the box stands along the world's axes."""
    axis = int(np.argmin(box.size))
    before, after = start[axis] - centre[axis], end[axis] - centre[axis]
    if before * after >= 0.0 or min(abs(before), abs(after)) <= 0.5 * box.size[axis]:
        return False
    where = start + (end - start) * before / (before - after) - centre
    return bool((np.abs(np.delete(where, axis)) <= 0.5 * np.delete(box.size, axis)).all())


def _aside(pushed: np.ndarray, way: np.ndarray) -> float:
    """Angle from the push to the way, seen from above [deg]; 0 if it did not move."""
    across = pushed[0] * way[1] - pushed[1] * way[0]
    return float(np.degrees(np.arctan2(across, pushed[:2] @ way[:2])))
