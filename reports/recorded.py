"""Recorded motions of a run, scenario by scenario, read once for charts and replay."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from adapters.archive import ArchiveError
from comparisons.cell import Campaign, Cell
from mechanics.arrays import SceneError
from mechanics.effects import Restitution
from mechanics.scene import Scene
from mechanics.scene_file import scene_from_dict
from mechanics.trajectory import Trajectory
from reports.palette import profile
from reports.verdict import RED, chosen, description, engines, first_of_family, scenarios

if TYPE_CHECKING:
    from adapters.run import Run
    from scenarios.scenario import Scenario, Truth

MOST = 48  # scenarios


class Motion(NamedTuple):
    """What one engine recorded, and the time by which its positions run ahead of its velocities [s]."""

    path: Trajectory
    lead: float


@dataclass(frozen=True)
class Recorded:
    """The motions of one scenario.

    Attributes
    ----------
    scenario : str
    scene : Scene or None
        None if neither the run nor the catalogue knows it.
    duration : float
        [s]
    truth : function of times -> Trajectory, or None
    cells : mapping
        Engine -> the cell that stands for it, of those with a motion; the order is that of every table.
    motions : mapping
        Engine -> its motion.
    remark : str
        On motions that could not be read.
    """

    scenario: str
    scene: Scene | None
    duration: float
    truth: Truth | None
    cells: Mapping[str, Cell]
    motions: Mapping[str, Motion]
    remark: str = ""

    @cached_property
    def true_path(self) -> Trajectory | None:
        """The truth at the times of the longest recording; None where nothing of it is known."""
        if self.truth is None or not self.motions:
            return None
        path = self.truth(max((m.path.t for m in self.motions.values()), key=len))
        return path if np.isfinite(path.x).any() else None


def recorded(
    campaign: Campaign,
    traces: Mapping[str, Trajectory | Run],
    known: Mapping[str, Scenario],
    most: int = MOST,
) -> list[Recorded]:
    """Motions of at most `most` scenarios, in the order of their weight.

    Those in which a fair profile has a red cell come first, and the first of a family before its variants.

    Parameters
    ----------
    traces : mapping
        Key of a cell -> its motion; a `Run` brings also its lead.
    known : mapping
        Label -> Scenario: without one a scenario has no truth.
    """
    table = {place: cell for place, cell in chosen(campaign).items() if cell.key in traces}
    labels = [s for s in scenarios(campaign) if any(place[0] == s for place in table)]
    red = {s for (s, engine), cell in table.items() if cell.state in RED and not profile(engine)}
    leading = first_of_family(campaign, labels)
    order = engines(campaign)
    kept = sorted(labels, key=lambda s: (s not in red, s not in leading))[:most]
    return [_read(campaign, s, [table[s, e] for e in order if (s, e) in table], traces, known.get(s)) for s in kept]


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


def _read(
    campaign: Campaign,
    label: str,
    cells: Sequence[Cell],
    traces: Mapping[str, Trajectory | Run],
    known: Scenario | None,
) -> Recorded:
    motions, lost = {}, []
    for cell in cells:
        try:
            motion = _motion(traces[cell.key])
        except (ArchiveError, OSError) as error:  # one lost recording must not cost the report
            lost.append(f"{cell.engine} is not drawn: {error}")
            continue
        if motion is not None:
            motions[cell.engine] = motion
    scene, told = known.scene if known else None, description(campaign, label).get("scene")
    if scene is None and told:
        try:
            scene = scene_from_dict(told)
        except SceneError as error:  # of another version
            lost.append(f"the scene is not drawn: {error}")
    duration = max((c.duration for c in cells), default=0.0)
    held = {c.engine: c for c in cells if c.engine in motions}
    return Recorded(label, scene, duration, known.truth if known else None, held, motions, "; ".join(lost))


def _motion(trace: Trajectory | Run) -> Motion | None:
    """The motion and its lead; None if nothing was recorded."""
    if isinstance(trace, Trajectory):
        return Motion(trace, 0.0) if len(trace) else None
    path = trace.trajectory
    return Motion(path, trace.lead) if path is not None and len(path) else None
