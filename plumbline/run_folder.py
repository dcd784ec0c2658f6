"""The folder of a run: `run.json`, the journal `cells.jsonl`, and `traces/`.

The journal is the truth: one line per finished cell, flushed as it is finished, so that whatever
happens to this process costs nothing that was done.  Reports and tables are made from it.
"""

from __future__ import annotations

import fcntl
import json
import os
import secrets
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import IO, Any

from adapters import archive
from adapters.run import Run
from comparisons.cell import Campaign, Cell, cell_from_json, cell_to_json

SCHEMA = 1


class FolderError(Exception):
    """A folder that cannot be written or is no run; the message says which, why, and what is kept."""


def phase_paths(trace: Path, phases: int) -> list[Path]:
    """Where the runs of all phases of a step but the first are archived: beside the first."""
    return [trace.with_suffix(f".{k}.npz") for k in range(1, phases)]


def new_id(now: datetime | None = None) -> str:
    """Name of a new run: UTC and four digits at random."""
    return f"{(now or datetime.now(UTC)):%Y%m%dT%H%M%SZ}-{secrets.token_hex(2)}"


class RunFolder:
    """A run on disk, opened for writing; a context manager.

    Raises
    ------
    FolderError
        If it cannot be made or written, or another process is writing to it.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self._journal: IO[str] | None = None
        with self._guarded():
            (self.path / "traces").mkdir(parents=True, exist_ok=True)
            self._journal = (self.path / "cells.jsonl").open("a+", encoding="utf-8")
        try:
            fcntl.flock(self._journal, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            self._journal.close()
            raise FolderError(f"{self.path}: another process is writing to this run") from None
        with self._guarded():
            self._mend()

    def __enter__(self) -> RunFolder:
        return self

    def __exit__(self, *_: object) -> None:
        if self._journal is not None:
            with self._guarded():  # what a full disk did not take is still in the buffer, and is tried once more
                self._journal.close()

    def append(self, cell: Cell) -> None:
        """Write a finished cell to the journal, at once."""
        assert self._journal is not None
        with self._guarded():
            self._journal.write(cell_to_json(cell) + "\n")
            self._journal.flush()

    def keep(self, key: str, run: Run, more: Sequence[Run] = ()) -> str:
        """Archive what was recorded; the path relative to the folder, "" if there is no motion to keep.

        `more` are the runs of the other phases of a step; they stand beside the first (`phase_paths`).
        """
        if run.trajectory is None:
            return ""
        name = f"traces/{key}.npz"
        with self._guarded():
            archive.write(self.path / name, run)
            for path, other in zip(phase_paths(self.path / name, 1 + len(more)), more, strict=True):
                archive.write(path, other)
        return name

    def describe(self, manifest: Mapping[str, Any]) -> None:
        """Write `run.json`, whole or not at all."""
        part = self.path / "run.json.part"
        with self._guarded():
            part.write_text(json.dumps({"schema": SCHEMA, **manifest}, indent=1) + "\n", encoding="utf-8")
            os.replace(part, self.path / "run.json")

    def finished(self) -> dict[str, Cell]:
        """Cells of the journal by key; of a key written twice, the last."""
        return read_cells(self.path)

    def _mend(self) -> None:
        """Cut off a last line that a kill left unfinished, so that the next one begins on its own."""
        with (self.path / "cells.jsonl").open("rb+") as file:
            data = file.read()
            whole = data.rfind(b"\n") + 1
            if whole < len(data):
                file.truncate(whole)

    @contextmanager
    def _guarded(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            kept = "; cells that are in the journal are kept" if self._journal is not None else ""
            raise FolderError(f"cannot write to {self.path}: {error.strerror or error}{kept}") from error


def read_cells(path: Path) -> dict[str, Cell]:
    """Cells of the journal of a run by key; lines that cannot be read (cut short by a kill) are left out.

    Raises
    ------
    FolderError
        If there is no journal.
    """
    try:
        lines = (path / "cells.jsonl").read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError as error:
        raise FolderError(f"{path} is not a run: cells.jsonl: {error.strerror or error}") from None
    cells = {}
    for line in lines:
        with suppress(ValueError, TypeError, KeyError):
            cell = cell_from_json(line)
            cells[cell.key] = cell
    return cells


def read_manifest(path: Path) -> dict[str, Any]:
    """What `run.json` of a run says.

    Raises
    ------
    FolderError
        If it is not there, damaged, or of a newer version.
    """
    try:
        manifest = json.loads((path / "run.json").read_text(encoding="utf-8"))
    except OSError as error:
        raise FolderError(f"{path} is not a run: run.json: {error.strerror or error}") from None
    except ValueError as error:
        raise FolderError(f"{path}/run.json is damaged: {error}") from None
    if not isinstance(manifest, dict) or manifest.get("schema", 0) > SCHEMA:
        raise FolderError(f"{path}/run.json was written by a newer version; this one reads schema {SCHEMA}")
    return manifest


def read_campaign(path: str | Path) -> Campaign:
    """The campaign a folder holds; what was planned and not finished is `not-run`.

    Raises
    ------
    FolderError
        If the folder is not a run.
    """
    path = Path(path)
    manifest, cells = read_manifest(path), read_cells(path)
    reason = manifest.get("stopped") or "the run was interrupted"
    planned = [_not_run(entry, manifest, reason) for entry in manifest.get("plan", ())]
    ordered = tuple(cells.get(cell.key, cell) for cell in planned)
    return campaign(manifest, ordered)


def campaign(manifest: Mapping[str, Any], cells: tuple[Cell, ...]) -> Campaign:
    """Campaign of a manifest and cells in the order of its plan."""
    names = ("id", "title", "command", "started", "wall_seconds", "fingerprint", "scenarios", "engines")
    more = {name: manifest.get(name, {}) for name in ("ladders", "sweep", "baseline", "effects")}
    return Campaign(**{name: manifest[name] for name in names}, cells=cells, **more)


def _not_run(entry: Mapping[str, Any], manifest: Mapping[str, Any], reason: str) -> Cell:
    told = manifest["scenarios"].get(entry["scenario"], {})
    return Cell(
        key=entry["key"],
        scenario=entry["scenario"],
        family=entry["scenario"].partition("[")[0],
        version=told.get("version", 1),
        tags=tuple(told.get("tags", ())),
        engine=entry["engine"],
        engine_version=entry["version"],
        settings=entry["settings"],
        state="not-run",
        duration=told.get("duration", 0.0),
        reason=reason,
        reproduce=entry["reproduce"],
    )


class Traces(Mapping[str, Run]):
    """Recorded motions of a run by cell key, read when they are asked for."""

    def __init__(self, path: Path, cells: tuple[Cell, ...]) -> None:
        self._paths = {c.key: path / c.trace for c in cells if c.trace and (path / c.trace).is_file()}
        self._phases = {c.key: c.phase_count for c in cells}

    def __getitem__(self, key: str) -> Run:
        return archive.read(self._paths[key])

    def others(self, key: str) -> list[Run]:
        """Runs of the other phases of a step, in order."""
        return [archive.read(path) for path in phase_paths(self._paths[key], self._phases[key])]

    def __contains__(self, key: object) -> bool:
        return key in self._paths  # without reading it

    def __iter__(self) -> Iterator[str]:
        return iter(self._paths)

    def __len__(self) -> int:
        return len(self._paths)
