"""What a campaign found: cells, a tidy table, and the report."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import reports
from adapters.archive import ArchiveError
from adapters.run import Run
from comparisons.cell import Campaign, Cell
from comparisons.regression import FINDINGS, changes
from plumbline import own_files, run_folder
from plumbline.run_folder import FolderError, Traces

if TYPE_CHECKING:
    import pandas as pd

    from scenarios.scenario import Scenario

BROKE = ("error", "crash", "timeout", "oom")
FOUND = ("fail", "diverged", "xpass")
FAIL_ON = (*FOUND, *BROKE, *FINDINGS)
SENTENCES = {
    0: "everything is within tolerance, refused with a reason, or on record",
    1: "findings: an answer is out of tolerance, or worse than in the baseline",
    3: "an engine crashed, raised, ran out of memory or was killed at its deadline",
    4: "the harness failed: it could not judge or could not write",
    5: "nothing was selected, or nothing of it could run",
    130: "interrupted",
}


@dataclass(frozen=True)
class Results:
    """A campaign and where it lies.

    Attributes
    ----------
    campaign : Campaign
    folder : Path
        Where journal and traces are.
    """

    campaign: Campaign
    folder: Path
    known: tuple[Scenario, ...] = ()

    @staticmethod
    def read(folder: str | Path, known: Sequence[Scenario] = ()) -> Results:
        """Results of a run on disk, as they were judged then.

        Raises
        ------
        FolderError
            If the folder is not a run.
        """
        return Results(run_folder.read_campaign(folder), Path(folder), tuple(known))

    @property
    def cells(self) -> tuple[Cell, ...]:
        """Every cell, in the order of the plan."""
        return self.campaign.cells

    @property
    def traces(self) -> Traces:
        """Cell key -> archived run, read when asked for."""
        return Traces(self.folder, self.cells)

    def run_of(self, cell: Cell) -> Run:
        """The archived run of a cell: its motion and what the engine reported.

        Raises
        ------
        KeyError
            If none is kept: the engine refused, or broke before the first sample.
        """
        return self.traces[cell.key]

    def frame(self) -> pd.DataFrame:
        """Tidy table, one row per measurement."""
        from reports.tables import frame

        return frame(self.campaign)

    def report(self, folder: str | Path | None = None) -> dict[str, Path]:
        """Write page, tables and summaries, by default beside the journal; name -> path.

        Raises
        ------
        FolderError
            If the folder cannot be written.
        """
        from reports.recorded import look_up

        known = look_up(self.campaign) | {s.name: s for s in self.known}
        try:
            return reports.write(self.campaign, folder or self.folder, self.traces, known)
        except OSError as error:
            raise FolderError(f"cannot write the report to {folder or self.folder}: {error}") from error

    def judged_again(self) -> tuple[Results, list[str]]:
        """Results with every cell judged anew from its archived motion, and remarks on what could not be.

        Cells without a motion, and cells whose scenario the catalogue does not have any more in the
        version that was run, keep their verdict.
        """
        from plumbline.judging import judged_again
        from reports.recorded import look_up

        own = {name: own_files.scenario_again(name, told) for name, told in self.campaign.scenarios.items()}
        known = look_up(self.campaign) | {n: s for n, s in own.items() if s} | {s.name: s for s in self.known}
        remarks: list[str] = []
        traces, cells = self.traces, []
        for cell in self.cells:
            try:
                new = cell
                if cell.scenario in known:
                    new = judged_again(known[cell.scenario], traces[cell.key], cell, traces.others(cell.key))
            except KeyError:
                new = cell
            except ArchiveError as error:
                remarks.append(str(error))
                new = cell
            cells.append(new)
        unknown = sorted({c.scenario for c in self.cells} - set(known))
        if unknown:
            remarks.append(f"not judged again, because the catalogue does not have them: {', '.join(unknown)}")
        kept = (*self.known, *(s for s in own.values() if s))
        return replace(self, campaign=replace(self.campaign, cells=tuple(cells)), known=kept), remarks

    def exit_code(self, fail_on: Sequence[str] = FAIL_ON) -> int:
        """0, 1, 3, 4 or 5, the worst of what the cells ask for; `fail_on` lists the states and outcomes that count.

        To break is what ladders are for, and to be inaccurate what coarse settings of a sweep are for: their cells
        count only where the harness failed.
        """
        from reports.suite import suite_of

        counted = [c for c in suite_of(self.campaign).cells if c.state in fail_on]
        if any(judge_failed(c) for c in self.cells):
            return 4
        if all(c.state in ("not-installed", "not-run") for c in self.cells):
            return 5
        if any(c.state not in FOUND for c in counted):
            return 3
        return 1 if counted or any(c.outcome in fail_on for c in changes(self.campaign)) else 0


def judge_failed(cell: Cell) -> bool:
    """Whether the house, and not the engine, is at fault: a demanded quantity could not be computed."""
    return cell.state == "error" and cell.stage == "judge"


def merged(results: Sequence[Results]) -> Results:
    """Several runs as one: of a cell that more than one of them finished, the last counts.

    Runs of one title are parts of one whole: their scenarios come in the order they have in the whole.

    Raises
    ------
    ValueError
        For no results.
    """
    if not results:
        raise ValueError("no run was given")
    if len(results) == 1:
        return results[0]
    last = results[-1].campaign
    cells: dict[str, Cell] = {}
    for cell in (replace(cell, trace=_absolute(r, cell)) for r in results for cell in r.cells):
        if cell.state != "not-run" or cell.key not in cells:
            cells[cell.key] = cell
    order = _order([r.campaign for r in results])
    joined = replace(
        last,
        id="+".join(r.campaign.id for r in results),
        title=", ".join(dict.fromkeys(r.campaign.title for r in results)),
        command=" && ".join(dict.fromkeys(r.campaign.command for r in results)),
        wall_seconds=sum(r.campaign.wall_seconds for r in results),
        scenarios={k: v for r in results for k, v in r.campaign.scenarios.items()},
        engines={k: v for r in results for k, v in r.campaign.engines.items()},
        cells=tuple(sorted(cells.values(), key=lambda cell: order[cell.scenario])),
        ladders={k: v for r in results for k, v in r.campaign.ladders.items()},
        sweep={k: v for r in results for k, v in r.campaign.sweep.items()},
        baseline=_baseline([r.campaign for r in results]),
        effects=_joined([r.campaign.effects for r in results]),
    )
    return Results(joined, results[0].folder, tuple(s for r in results for s in r.known))


def _order(campaigns: Sequence[Campaign]) -> dict[str, int]:
    """Scenario -> its place in the whole: parts hold every n-th, other runs come one after the other."""
    labels = [list(dict.fromkeys(c.scenario for c in campaign.cells)) for campaign in campaigns]
    rows = [(n, k, label) for n, part in enumerate(labels) for k, label in enumerate(part)]
    if len({campaign.title for campaign in campaigns}) == 1:
        rows.sort(key=lambda row: (row[1], row[0]))
    return {label: place for place, label in enumerate(dict.fromkeys(row[2] for row in rows))}


def _baseline(campaigns: Sequence[Campaign]) -> dict[str, Any]:
    """The records of all, if all were compared with the same baseline on one platform class."""
    told = [campaign.baseline for campaign in campaigns]
    if not all(told) or len({(b["name"], b["platform"]) for b in told}) > 1:
        return {}
    records = {json.dumps(record, sort_keys=True): record for b in told for record in b["records"]}
    return {**told[-1], "records": list(records.values())}


def _joined(told: Sequence[Mapping[str, Any]]) -> dict[str, dict[str, Any]]:
    """Engine -> scenario -> what its effects do; of one that is there more than once, the last."""
    names = dict.fromkeys(engine for one in told for engine in one)
    return {name: {k: v for one in told for k, v in one.get(name, {}).items()} for name in names}


def _absolute(results: Results, cell: Cell) -> str:
    return str((results.folder / cell.trace).resolve()) if cell.trace else ""
