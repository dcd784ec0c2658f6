"""Everything a page shows of recorded motions: charts that need no script, and replays, within a budget."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from comparisons.cell import Campaign
from mechanics.trajectory import Trajectory
from reports.recorded import recorded
from reports.replay import Replay, replay
from reports.series import Curves, time_series
from reports.verdict import scenarios

if TYPE_CHECKING:
    from adapters.run import Run
    from scenarios.scenario import Scenario

DRAWN = 12  # scenarios with charts that need no script
FIGURES = 2  # of each of them; the player shows all
BYTES = 1_200_000  # of all replays of a page


@dataclass(frozen=True)
class Shown:
    """What a page shows of recorded motions, in the order of every table.

    Attributes
    ----------
    curves : tuple of Curves
        Charts that need no script.
    replays : tuple of Replay
    recorded : int
        Number of scenarios with a recorded motion.
    """

    curves: tuple[Curves, ...] = ()
    replays: tuple[Replay, ...] = ()
    recorded: int = 0


def motion(
    campaign: Campaign, traces: Mapping[str, Trajectory | Run], known: Mapping[str, Scenario], budget: int = BYTES
) -> Shown:
    """Charts and replays of the scenarios that weigh most, replays of `budget` bytes in all.

    Parameters
    ----------
    traces : mapping
        Key of a cell -> its recorded motion.
    known : mapping
        Label -> Scenario, for the truth.
    """
    curves, replays = [], []
    for one in recorded(campaign, traces, known):
        drawn = time_series(one)
        if len(curves) < DRAWN:
            curves.append(replace(drawn, figures=drawn.figures[:FIGURES]))
        found = replay(one, drawn)
        if found is not None and len(found.block) <= budget:
            budget -= len(found.block)
            replays.append(found)
    place = {label: k for k, label in enumerate(scenarios(campaign))}
    curves.sort(key=lambda c: place[c.scenario])
    replays.sort(key=lambda r: place[r.scenario])
    return Shown(tuple(curves), tuple(replays), len({c.scenario for c in campaign.cells if c.key in traces}))
