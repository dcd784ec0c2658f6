"""Energy, momentum, gap and distance from the truth over time, from recorded motions.

Display only: the least and the largest value of each short stretch of time, so that no peak is lost.  Verdicts
never come from here.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from comparisons.conserved import conserved
from comparisons.energy import potential_energy
from comparisons.gap import bounded_gap, unmeasurable
from comparisons.momentum import linear_deviation, linear_scale
from comparisons.moving import Moving
from comparisons.penetration import close_pairs, pose
from mechanics.scene import Scene
from reports.drawing import FLOOR
from reports.figures import Axis, Figure, Series
from reports.recorded import Recorded
from scenarios.scenario import Truth

BUCKETS = 100
ROUNDING = 1e-14  # of the momentum scale
MOST_GAPS = 20_000  # of one motion, pairs times samples: what is slower to compute is not drawn


@dataclass(frozen=True)
class Curves:
    """Figures of one scenario over time, and a remark on motions that could not be read."""

    scenario: str
    figures: tuple[Figure, ...]
    remark: str = ""


def time_series(of: Recorded) -> Curves:
    """Energy, position, momentum, gap and distance from the truth of one scenario, as far as it has them."""
    return Curves(of.scenario, tuple(_figures(of)) if of.motions else (), of.remark)


def _figures(of: Recorded) -> Iterator[Figure]:
    if of.scene is None:
        yield _travel(of)
        return
    moving = {e: Moving.of(of.scene, m.path) for e, m in of.motions.items()}
    yield _energy(of, moving)
    yield _travel(of)
    yield _momentum(of, of.scene, moving)
    yield from _gap(of, of.scene)
    if of.truth is not None and of.true_path is not None:
        yield _error(of, of.truth)


def _energy(of: Recorded, moving: Mapping[str, Moving]) -> Figure:
    """Kinetic plus potential energy gained, positions carried back to the time of the velocities."""
    values = {}
    for engine, (path, lead) in of.motions.items():
        own = moving[engine]
        values[engine] = own.kinetic + potential_energy(own, path, lead, of.duration)
    series = [_series(e, m.path.t, values[e] - values[e][0]) for e, m in of.motions.items()]
    synchronised = any(m.lead for m in of.motions.values())
    title = "Energy gained since the start" + (", synchronised" if synchronised else "")
    size = max(float(np.abs(v).max()) for v in values.values())
    return _figure(of, title, Axis("E − E(0) [J]", least_span=1e-6 * size), series)


def _travel(of: Recorded) -> Figure:
    """The coordinate that changes most, by the truth if there is one, else by the first engine."""
    truth = of.true_path
    guide = truth if truth is not None else next(iter(of.motions.values())).path
    span = np.nanmax(guide.x, axis=0) - np.nanmin(guide.x, axis=0)
    body, axis = np.unravel_index(int(np.nanargmax(span)), span.shape)
    name = of.scene.names[body] if of.scene is not None else f"body {body + 1}"
    letter = "xyz"[axis]
    series = [_series(e, m.path.t, m.path.x[:, body, axis]) for e, m in of.motions.items()]
    if truth is not None:
        series.insert(0, _series("", truth.t, truth.x[:, body, axis]))
    what = "Height" if letter == "z" else f"Position along {letter}"
    return _figure(of, f"{what} of {name}", Axis(f"{letter} [m]"), series)


def _momentum(of: Recorded, scene: Scene, moving: Mapping[str, Moving]) -> Figure:
    """Linear momentum that no effect explains; if there is no such thing beyond rounding, the momentum itself."""
    kept = conserved(scene, of.duration)
    if len(kept.linear):
        lost = {e: linear_deviation(m, kept) for e, m in moving.items()}
        scale = max(linear_scale(m) for m in moving.values())
        if max(float(v.max()) for v in lost.values()) > ROUNDING * scale:
            series = [_series(e, m.path.t, np.maximum(lost[e], FLOOR)) for e, m in of.motions.items()]
            axis = Axis("|Δp| [N s]", log=True, better="↓ better")
            return _figure(of, "Momentum that no effect explains", axis, series)
    series = [_series(e, m.path.t, np.linalg.norm(moving[e].momentum, axis=1)) for e, m in of.motions.items()]
    return _figure(of, "Momentum of all bodies", Axis("|p| [kg m/s]"), series)


def _gap(of: Recorded, scene: Scene) -> Iterator[Figure]:
    """Minus the smallest gap of all pairs that may touch; none where that takes long or none can be measured."""
    shapes = [b.shape for b in scene.bodies]
    series = []
    for engine, (path, _) in of.motions.items():
        pairs = [p for p in close_pairs(scene, path) if not unmeasurable(shapes[p[0]], shapes[p[1]])]
        if len(pairs) * len(path) > MOST_GAPS:
            return
        gaps = [bounded_gap(shapes[i], shapes[j], pose(path, i), pose(path, j)) for i, j in pairs]
        if gaps:
            series.append(_series(engine, path.t, np.maximum(-np.min(gaps, axis=0), FLOOR)))
    if series:
        yield _figure(of, "Deepest overlap of two bodies", Axis("− gap [m]", log=True, better="↓ better"), series)


def _error(of: Recorded, truth: Truth) -> Figure:
    """Largest distance of a centre of mass from its true place."""
    series = []
    for engine, (path, _) in of.motions.items():
        off = np.linalg.norm(path.x - truth(path.t).x, axis=2)
        known = ~np.isnan(off).all(axis=1)
        far = np.full(len(off), np.nan)
        far[known] = np.maximum(np.nanmax(off[known], axis=1), FLOOR)
        series.append(_series(engine, path.t, far))
    return _figure(of, "Distance from the truth", Axis("distance [m]", log=True, better="↓ better"), series)


def _figure(of: Recorded, title: str, y: Axis, series: list[Series]) -> Figure:
    x = Axis("time [s]", limits=(0.0, of.duration) if of.duration > 0.0 else None)
    return Figure(title, x, y, tuple(series), summary=f"{title} over time")


def _series(engine: str, t: np.ndarray, y: np.ndarray) -> Series:
    kept_t, kept_y = extremes(t, y, BUCKETS)
    return Series(engine, kept_t.tolist(), kept_y.tolist(), joined=True, marked=False)


def extremes(t: np.ndarray, y: np.ndarray, buckets: int) -> tuple[np.ndarray, np.ndarray]:
    """The least and the largest value of each of `buckets` equal stretches, and both ends, in order of time.

    Curves of at most 2 `buckets` points come back as they are.  NaN are kept out of the comparison; a
    stretch of nothing else gives one NaN.
    """
    if len(t) <= 2 * buckets:
        return t, y
    width = -(-len(t) // buckets)
    stretches = np.append(y, np.full(-len(t) % width, np.nan)).reshape(-1, width)
    starts = width * np.arange(len(stretches))
    nothing = np.isnan(stretches)
    least = np.where(nothing, np.inf, stretches).argmin(axis=1)
    largest = np.where(nothing, -np.inf, stretches).argmax(axis=1)
    places = np.unique([0, len(t) - 1, *(starts + least), *(starts + largest)])
    return t[places], y[places]
