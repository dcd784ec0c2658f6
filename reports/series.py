"""Energy and motion over time, from recorded motions.

Display only: at most two points per pixel, the least and the largest value that fall on it, so that no
peak is lost.  Verdicts never come from here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from adapters.archive import ArchiveError
from comparisons.cell import Campaign, Cell
from mechanics.effects import Restitution
from mechanics.trajectory import Trajectory
from reports.figures import Axis, Figure, Series
from reports.palette import profile
from reports.verdict import RED, chosen, engines, first_of_family, scenarios

if TYPE_CHECKING:
    from adapters.run import Run
    from scenarios.scenario import Scenario

BUCKETS = 160
MOST_SCENES = 12


@dataclass(frozen=True)
class Curves:
    """Figures of one scenario over time, and a remark on motions that could not be read."""

    scenario: str
    figures: tuple[Figure, ...]
    remark: str = ""


def time_series(
    campaign: Campaign,
    traces: Mapping[str, Trajectory | Run],
    known: Mapping[str, Scenario],
    most: int = MOST_SCENES,
) -> list[Curves]:
    """Figures of energy and of the body that travels farthest, per scenario.

    Parameters
    ----------
    traces : mapping
        Key of a cell -> its motion; a `Run` brings also the time by which its positions run ahead of its
        velocities, so that energy is synchronised.
    known : mapping
        Label -> Scenario: without one a scenario has neither energy nor truth.
    most : int
        Scenarios to show at most: the first of each family before variants, and among equals those in which a
        fair profile has a red cell.

    Returns
    -------
    list of Curves, in the order of every table.
    """
    table = {place: cell for place, cell in chosen(campaign).items() if cell.key in traces}
    labels = [s for s in scenarios(campaign) if any(place[0] == s for place in table)]
    red = {s for (s, engine), cell in table.items() if cell.state in RED and not profile(engine)}
    leading = first_of_family(campaign, labels)
    kept = set(sorted(labels, key=lambda s: (s not in leading, s not in red))[:most])
    shown = []
    for label in labels:
        cells = [table[label, e] for e in engines(campaign) if (label, e) in table]
        if label in kept:
            shown.append(_curves(label, cells, traces, known.get(label)))
    return shown


def declared_restitution(known: Mapping[str, Scenario]) -> dict[str, float]:
    """Label -> coefficient of restitution, of scenarios that declare one and the same for every pair."""
    effects = {label: s.scene.effect(Restitution) for label, s in known.items()}
    return {label: effect.coefficient for label, effect in effects.items() if effect and not effect.between}


def look_up(campaign: Campaign) -> dict[str, Scenario]:
    """Scenarios of the catalogue that the campaign ran, in the version it ran; unknown labels are left out."""
    from scenarios.catalogue import find

    versions = {c.scenario: c.version for c in campaign.cells}
    found = {}
    for label, version in versions.items():
        try:
            candidates = find(label)
        except ValueError:
            continue  # a user's own scene, or one that has left the catalogue
        found |= {s.name: s for s in candidates if s.name == label and s.version == version}
    return found


def _curves(
    label: str, cells: Sequence[Cell], traces: Mapping[str, Trajectory | Run], known: Scenario | None
) -> Curves:
    motions, lost = {}, []
    for cell in cells:
        try:
            motion, lead = _motion(traces[cell.key])
        except (ArchiveError, OSError) as error:  # one lost recording must not cost the report
            lost.append(f"{cell.engine} is not drawn: {error}")
            continue
        if len(motion):
            motions[cell.engine] = (motion, lead)
    return Curves(label, tuple(_figures(motions, known)) if motions else (), "; ".join(lost))


def _figures(motions: Mapping[str, tuple[Trajectory, float]], known: Scenario | None) -> list[Figure]:
    truth = None
    if known is not None and known.truth is not None:
        longest = max((m[0].t for m in motions.values()), key=len)
        truth = known.truth(longest)
    figures = [_travel(motions, truth, known)]
    if known is not None:
        figures.insert(0, _energy(motions, known))
    return figures


def _motion(trace: Trajectory | Run) -> tuple[Trajectory, float]:
    """Trajectory and the time by which its positions run ahead of its velocities [s]."""
    if isinstance(trace, Trajectory):
        return trace, 0.0
    found = trace.trajectory
    return (found if found is not None else _nothing(), trace.lead)


def _nothing() -> Trajectory:
    none = np.zeros((0, 0, 3))
    return Trajectory(np.zeros(0), none, np.zeros((0, 0, 4)), none, none)


def _energy(motions: Mapping[str, tuple[Trajectory, float]], known: Scenario) -> Figure:
    values = {e: _mechanical_energy(known, m, lead) for e, (m, lead) in motions.items()}
    series = [_series(e, motions[e][0].t, values[e] - values[e][0]) for e in motions]
    synchronised = any(lead for _, lead in motions.values())
    title = "Energy gained since the start" + (", synchronised" if synchronised else "")
    size = max(float(np.abs(v).max()) for v in values.values())
    return _figure(title, "E − E(0) [J]", series, least_span=1e-6 * size)


def _mechanical_energy(known: Scenario, motion: Trajectory, lead: float) -> np.ndarray:
    """Kinetic plus potential energy at every sample, positions carried back by `lead` [J]."""
    from comparisons.energy import potential_energy
    from comparisons.moving import Moving

    moving = Moving.of(known.scene, motion)
    return moving.kinetic + potential_energy(moving, motion, lead, known.duration)


def _travel(
    motions: Mapping[str, tuple[Trajectory, float]], truth: Trajectory | None, known: Scenario | None
) -> Figure:
    """The coordinate that changes most, by the truth if there is one, else by the first engine."""
    guide = truth if truth is not None and np.isfinite(truth.x).any() else next(iter(motions.values()))[0]
    span = np.nanmax(guide.x, axis=0) - np.nanmin(guide.x, axis=0)
    body, axis = np.unravel_index(int(np.nanargmax(span)), span.shape)
    name = known.scene.names[body] if known is not None else f"body {body + 1}"
    letter = "xyz"[axis]
    series = [_series(e, m.t, m.x[:, body, axis]) for e, (m, _) in motions.items()]
    if truth is not None:
        series.insert(0, _series("", truth.t, truth.x[:, body, axis]))
    what = "Height" if letter == "z" else f"Position along {letter}"
    return _figure(f"{what} of {name}", f"{letter} [m]", series)


def _figure(title: str, label: str, series: Sequence[Series], least_span: float = 0.0) -> Figure:
    y = Axis(label, least_span=least_span)
    return Figure(title, Axis("time [s]"), y, tuple(series), summary=f"{title} over time")


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
    keep = [0, len(t) - 1]
    edges = np.linspace(0, len(t), buckets + 1).astype(int)
    for start, end in pairwise(edges):
        part = y[start:end]
        if np.isnan(part).all():
            keep.append(start)
        else:
            keep += [start + int(np.nanargmin(part)), start + int(np.nanargmax(part))]
    places = np.unique(keep)
    return t[places], y[places]
