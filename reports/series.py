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
from comparisons.momentum import angular_deviation, angular_scale, linear_deviation, linear_scale
from comparisons.moving import Moving
from comparisons.penetration import close_pairs, pose
from mechanics.rotation import angle_between
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
    """The coordinate that changes most, by the truth if there is one, else by the first engine; or how far it turns."""
    truth = of.true_path
    guide = truth if truth is not None else next(iter(of.motions.values())).path
    span = np.nanmax(guide.x, axis=0) - np.nanmin(guide.x, axis=0)
    if not np.nanmax(span) > 0.0:
        return _turning(of)
    body, axis = np.unravel_index(int(np.nanargmax(span)), span.shape)
    letter = "xyz"[axis]
    series = [_series(e, m.path.t, m.path.x[:, body, axis]) for e, m in of.motions.items()]
    if truth is not None:
        series.insert(0, _series("", truth.t, truth.x[:, body, axis]))
    what = "Height" if letter == "z" else f"Position along {letter}"
    return _figure(of, f"{what} of {_named(of, int(body))}", Axis(f"{letter} [m]"), series)


def _turning(of: Recorded) -> Figure:
    """Angle by which the body that turns most is away from its first attitude."""
    angles = {e: angle_between(m.path.q, m.path.q[:1]) for e, m in of.motions.items()}
    body = int(next(iter(angles.values())).max(axis=0).argmax())
    series = [_series(e, of.motions[e].path.t, found[:, body]) for e, found in angles.items()]
    if of.true_path is not None and not np.isnan(of.true_path.q[:, body]).any():
        q = of.true_path.q[:, body]
        series.insert(0, _series("", of.true_path.t, angle_between(q, q[:1])))
    return _figure(of, f"Turn of {_named(of, body)} from its first attitude", Axis("angle [rad]"), series)


def _named(of: Recorded, body: int) -> str:
    return of.scene.names[body] if of.scene is not None else f"body {body + 1}"


def _momentum(of: Recorded, scene: Scene, moving: Mapping[str, Moving]) -> Figure:
    """Momentum that no effect explains, linear or else angular; where there is none, the momentum itself."""
    kept = conserved(scene, of.duration)
    lost = Axis("|Δp| [N s]", log=True, better="↓ better"), Axis("|ΔL| [N m s]", log=True, better="↓ better")
    candidates = []
    if len(kept.linear):
        change = {e: linear_deviation(m, kept) for e, m in moving.items()}
        scale = max(linear_scale(m) for m in moving.values())
        candidates.append(("Momentum that no effect explains", lost[0], change, scale))
    if len(kept.angular):
        change = {e: angular_deviation(m, kept) for e, m in moving.items()}
        scale = max(angular_scale(m, kept.pivot) for m in moving.values())
        candidates.append(("Angular momentum that no effect explains", lost[1], change, scale))
    for title, axis, change, scale in candidates:
        if max(float(v.max()) for v in change.values()) > ROUNDING * scale:
            series = [_series(e, m.path.t, np.maximum(change[e], FLOOR)) for e, m in of.motions.items()]
            return _figure(of, title, axis, series)
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
    """Largest distance of a centre of mass from its true place; where all are in place, the largest angle."""
    off, turned = {}, {}
    for engine, (path, _) in of.motions.items():
        true = truth(path.t)
        off[engine] = _largest(np.linalg.norm(path.x - true.x, axis=2))
        turned[engine] = _largest(np.where(np.isnan(true.q).any(axis=2), np.nan, angle_between(true.q, path.q)))
    if all(np.nanmax(far, initial=0.0) <= FLOOR for far in off.values()):
        return _from_truth(of, "Angle from the true attitude", "angle [rad]", turned)
    return _from_truth(of, "Distance from the truth", "distance [m]", off)


def _from_truth(of: Recorded, title: str, label: str, values: Mapping[str, np.ndarray]) -> Figure:
    series = [_series(e, m.path.t, np.maximum(values[e], FLOOR)) for e, m in of.motions.items()]
    return _figure(of, title, Axis(label, log=True, better="↓ better"), series)


def _largest(values: np.ndarray) -> np.ndarray:
    """(T,) largest of (T, n) values at each time; NaN where none is known."""
    known = ~np.isnan(values).all(axis=1)
    largest = np.full(len(values), np.nan)
    largest[known] = np.nanmax(values[known], axis=1)
    return largest


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
