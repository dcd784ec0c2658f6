"""Climbing ladders: which cell is to be run next, from those that are finished."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from adapters import registry
from comparisons.cell import Cell
from comparisons.climb import Try, how, next_rung
from plumbline.plan import Job, plan
from scenarios.ladder import Ladder


@dataclass
class Climb:
    """One engine on its way up one ladder; `waiting` is the rung it stands on."""

    ladder: Ladder
    engine: str
    tries: list[Try] = field(default_factory=list)
    waiting: tuple[float, Job] | None = None


class Climbers:
    """Every engine on every ladder it can climb.

    Parameters
    ----------
    ladders : sequence of Ladder
    engines : sequence of str
        Names; those that lack the knob of a ladder, or have the one that it bars, do not climb it.
    """

    def __init__(self, ladders: Sequence[Ladder], engines: Sequence[str]) -> None:
        self._climbs = [Climb(ladder, e) for ladder in ladders for e in engines if _can(ladder, e)]
        self._cells: dict[str, Cell] = {}
        self._asked: set[str] = set()
        self.told: dict[str, Any] = {
            one.name: {
                "raises": one.raises,
                "unit": one.unit,
                "rungs": list(one.rungs),
                "monotone": one.monotone,
                "climbs": {c.engine: [] for c in self._climbs if c.ladder is one},
            }
            for one in ladders
        }

    @property
    def most(self) -> int:
        """Cells there are if every engine climbs to the top."""
        return sum(len(climb.ladder.rungs) for climb in self._climbs)

    def start(self) -> tuple[Job, ...]:
        """The jobs on the first rungs."""
        return tuple(job for climb in self._climbs for job in self._step(climb))

    def after(self, _: Job, cell: Cell) -> tuple[Job, ...]:
        """The jobs that follow from a finished cell: two ladders may stand on the same one."""
        self._cells[cell.key] = cell
        return tuple(job for climb in self._climbs for job in self._advance(climb))

    def _advance(self, climb: Climb) -> list[Job]:
        new: list[Job] = []
        while climb.waiting is not None and climb.waiting[1].key in self._cells:
            rung, job = climb.waiting
            climb.tries.append(Try(rung, how(self._cells[job.key])))
            new += self._step(climb)
        return new

    def _step(self, climb: Climb) -> list[Job]:
        """Put the climb on its next rung: the job for it, unless it is asked for already."""
        rung = next_rung(climb.ladder, climb.tries)
        climb.waiting = None
        if rung is None:
            return []
        (job,) = plan((climb.ladder.scenario(rung),), (climb.engine,), climb.ladder.settings(rung))
        climb.waiting = (rung, job)
        self.told[climb.ladder.name]["climbs"][climb.engine].append([rung, job.key])
        if job.key in self._asked:
            return []
        self._asked.add(job.key)
        return [job]


def _can(ladder: Ladder, engine: str) -> bool:
    """Whether the engine has what the ladder raises, and not what keeps it off; one not installed is shown as that."""
    try:
        knobs = registry.engine(engine).knobs
        return (not ladder.knob or ladder.knob in knobs) and ladder.lacking not in knobs
    except registry.Unavailable:
        return not ladder.knob
