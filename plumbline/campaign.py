"""Runs a plan: engines in parallel, each in its own process; judges, journals and reports as answers arrive."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Protocol

from adapters import archive
from adapters.workers import MEMORY, TIMEOUT
from comparisons.cell import Cell, cell_to_json
from plumbline import run_folder
from plumbline.card import keep_cards, read_cards
from plumbline.fingerprint import fingerprint
from plumbline.judging import absent, judged, step_of
from plumbline.lanes import Lanes
from plumbline.plan import Job, described, described_engines
from plumbline.results import Results, judge_failed
from plumbline.run_folder import RunFolder
from scenarios.phase import delays

RERUN = ("none", "failed", "all")
GOOD = ("ok", "refused", "xfail")
WHOLE = ("ok", "fail", "xfail", "xpass")  # states in which the run came to its end


class Watcher(Protocol):
    """Told what a campaign is doing; called from the thread that runs it."""

    def begin(self, planned: int, reused: int) -> None:
        """The campaign begins."""

    def started(self, job: Job) -> None:
        """A cell has been given to its engine."""

    def finished(self, cell: Cell, seconds: float) -> None:
        """A cell is in the journal, `seconds` after it was given out."""


class Silence:
    """A watcher that does nothing."""

    def begin(self, planned: int, reused: int) -> None:
        """Nothing."""

    def started(self, job: Job) -> None:
        """Nothing."""

    def finished(self, cell: Cell, seconds: float) -> None:
        """Nothing."""


@dataclass(frozen=True)
class Options:
    """How a campaign is run.

    Attributes
    ----------
    jobs : int
        Engines that compute at the same time; where cost is measured, scenes (see `plumbline.lanes`).
    repeats : int
        Timed repeats of every cell, after a warm-up, in turns with the other cells on its scene; with one there is no
        warm-up and no cost.
    timeout : float
        Of one run of a cell [s]; then its process is killed.
    budget : float or None
        Of the whole campaign [s]; no cell begins after it, and what has not begun is `not-run`.
    patience : float
        How many times the deadline a run may take on a busy machine until it has had that much CPU time.
    memory : int
        Address space of one engine [bytes]; 0 = no limit.
    rerun : str
        What to run again of what the folder holds: "none", "failed" or "all".
    card : bool
        Whether the engines are asked, after the cells, what they really apply.
    """

    jobs: int = 2
    repeats: int = 1
    timeout: float = TIMEOUT
    budget: float | None = None
    memory: int = MEMORY
    rerun: str = "none"
    phases: int = 1
    card: bool = True
    patience: float = 1.0

    def __post_init__(self) -> None:
        for name, least in (("jobs", 1), ("repeats", 1), ("memory", 0), ("phases", 1)):
            value = getattr(self, name)
            if not isinstance(value, int) or value < least:
                raise ValueError(f"{name} = {value!r} is not possible: a whole number >= {least}")
        for name in ("timeout", "budget"):
            value = getattr(self, name)
            if value is not None and not 0.0 < value < float("inf"):
                raise ValueError(f"{name} = {value!r} is not possible: a finite number > 0 of seconds")
        if self.rerun not in RERUN:
            raise ValueError(f"rerun = {self.rerun!r} is not possible: one of {', '.join(RERUN)}")


@dataclass
class Execution:
    """A campaign on its way; `run` carries it through.

    Parameters
    ----------
    jobs : sequence of Job
    folder : path
        Made if it is not there; finished cells in it are used again.
    title, command : str
        For people: what is run, and the command that repeats it.
    following : function, optional
        Of a job and its finished cell: the jobs that are to be run because of it.
    told : mapping
        What else `run.json` is to hold; read anew whenever it is written.
    most : int
        Cells there may be with those that follow, where it is known.
    """

    jobs: Sequence[Job]
    folder: Path
    title: str
    command: str
    options: Options = field(default_factory=Options)
    watcher: Watcher = field(default_factory=Silence)
    following: Callable[[Job, Cell], Sequence[Job]] | None = None
    told: Mapping[str, Any] = field(default_factory=dict)
    most: int = 0

    def run(self) -> Results:
        """Run what is left to run and return everything.

        Raises
        ------
        FolderError
            If the folder cannot be written; finished cells are kept.
        KeyboardInterrupt
            After the workers are ended; the journal is valid and the next run goes on from it.
        """
        begun = time.monotonic()
        with RunFolder(self.folder) as folder:
            manifest = self._manifest()
            jobs, done = self._resumed(folder, manifest)
            folder.describe(manifest)
            left = [job for job in jobs if job.key not in done]
            self.watcher.begin(max(self.most, len(jobs)), len(jobs) - len(left))
            stopped = "the run was interrupted"
            try:
                done |= self._run(left, folder, begun, manifest)
                stopped = (
                    "" if len(done) == len(manifest["plan"]) else f"the budget of {self.options.budget:g} s was spent"
                )
            finally:
                manifest |= {"wall_seconds": manifest["wall_seconds"] + time.monotonic() - begun, "stopped": stopped}
                folder.describe(manifest)
        return Results.read(self.folder)

    def _resumed(self, folder: RunFolder, manifest: dict[str, Any]) -> tuple[list[Job], dict[str, Cell]]:
        """The jobs, with those that follow from cells that are there already, and these cells."""
        jobs, fresh, done = [], list(self.jobs), {}
        while fresh:
            found = self._reusable(folder, manifest, fresh)
            jobs, done = jobs + fresh, done | found
            fresh = [n for job in fresh if job.key in found for n in self._follow(manifest, job, found[job.key])]
        return jobs, done

    def _follow(self, manifest: dict[str, Any], job: Job, cell: Cell) -> list[Job]:
        """Jobs that a finished cell calls for, entered in the manifest."""
        new = list(self.following(job, cell)) if self.following is not None else []
        _enter(manifest, new)
        return new

    def _manifest(self) -> dict[str, Any]:
        manifest: dict[str, Any] = {
            "id": self.folder.resolve().name,
            "title": self.title,
            "command": self.command,
            "started": f"{datetime.now(UTC):%Y-%m-%dT%H:%M:%SZ}",
            "wall_seconds": 0.0,
            "stopped": "",
            "options": vars(self.options),
            "fingerprint": fingerprint(),
            "scenarios": {},
            "engines": {},
            "plan": [],
            **self.told,
        }
        _enter(manifest, self.jobs)
        return manifest

    def _reusable(self, folder: RunFolder, manifest: dict[str, Any], jobs: Sequence[Job]) -> dict[str, Cell]:
        """Finished cells of the same key whose scenario still asks the same, timed as often as is asked now.

        Runs are kept, opinions are formed anew: the motions are judged as the comparisons judge now.
        """
        cells = folder.finished()
        if not cells:
            return {}
        try:
            before = run_folder.read_manifest(self.folder)
        except run_folder.FolderError:
            return {}
        if self.options.rerun == "all":
            return {}
        manifest["wall_seconds"] = before.get("wall_seconds", 0.0)
        keep_cards(before.get("engines", {}), manifest["engines"])
        asked = {label: told.get("question") for label, told in before.get("scenarios", {}).items()}
        now = {label: told["question"] for label, told in manifest["scenarios"].items()}
        found = {job.key: self._judged_now(folder, job, cells[job.key]) for job in jobs
                 if job.key in cells and asked.get(job.scenario.name) == now[job.scenario.name]
                 and self._good_enough(job, cells[job.key])}  # fmt: skip
        return {key: cell for key, cell in found.items() if cell is not None}

    def _judged_now(self, folder: RunFolder, job: Job, cell: Cell) -> Cell | None:
        """The cell as the comparisons judge its motion now; None if the motion cannot be read any more."""
        if not cell.trace:
            return cell
        try:
            path = self.folder / cell.trace
            more = [archive.read(p) for p in run_folder.phase_paths(path, cell.phase_count)]
            new = judged(job, archive.read(path), cell.trace, more)
        except (OSError, archive.ArchiveError):
            return None
        if cell_to_json(new) != cell_to_json(cell):
            folder.append(new)
        return new

    def _good_enough(self, job: Job, cell: Cell) -> bool:
        if (
            cell.trace
            and cell.phase_count != len(delays(job.scenario, self.options.phases, step_of(job.settings)))
            and cell.state in WHOLE
        ):
            return False
        if cell.state in ("not-installed", "not-run") or judge_failed(cell):
            return False
        if self.options.rerun == "failed" and cell.state not in GOOD:
            return False
        return cell.repeats == 0 or cell.repeats >= self.options.repeats

    def _run(self, left: Sequence[Job], folder: RunFolder, begun: float, manifest: dict[str, Any]) -> dict[str, Cell]:
        """Cells of the jobs, and of those that followed, that could be begun within the budget, by key.

        Then the engines of the manifest are told their cards.
        """
        waiting = [job for job in left if job.absent is None]
        done = {job.key: self._finish(folder, absent(job), 0.0) for job in left if job.absent is not None}
        with Lanes(self.options) as lanes:
            manifest["fingerprint"] |= {"timing": lanes.told}
            while waiting or lanes.busy:
                while not self._spent(begun) and (given := lanes.give(waiting)):
                    for job in given:
                        self.watcher.started(job)
                if not lanes.busy:
                    break  # the budget is spent
                for job, run, more, seconds in lanes.finished():
                    cell = judged(job, run, folder.keep(job.key, run, more), more)
                    done[job.key] = self._finish(folder, cell, seconds)
                    if new := self._follow(manifest, job, cell):
                        waiting += new
                        folder.describe(manifest)
            if self.options.card and not self._spent(begun):
                read_cards(self.jobs, manifest["engines"], lanes.workers, lanes.threads, self.options.timeout)
        return done

    def _spent(self, begun: float) -> bool:
        return self.options.budget is not None and time.monotonic() - begun > self.options.budget

    def _finish(self, folder: RunFolder, cell: Cell, seconds: float) -> Cell:
        folder.append(cell)
        self.watcher.finished(cell, seconds)
        return cell


def _enter(manifest: dict[str, Any], jobs: Sequence[Job]) -> None:
    """Write jobs into a manifest: the plan, and what there is to say of their scenarios and engines."""
    manifest["plan"] += [
        {"key": j.key, "scenario": j.scenario.name, "engine": j.engine, "version": j.version,
         "settings": dict(j.settings), "reproduce": j.reproduce}
        for j in jobs
    ]  # fmt: skip
    fresh = {j.scenario.name: j.scenario for j in jobs if j.scenario.name not in manifest["scenarios"]}
    manifest["scenarios"] |= described(fresh.values())
    manifest["engines"] |= described_engines(j for j in jobs if j.engine not in manifest["engines"])
