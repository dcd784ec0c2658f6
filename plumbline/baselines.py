"""Baselines on disk: text in version control, one file for each suite, engine and scenario.

    baselines/standard/mujoco/sliding-block.json

holds, for every setting that was run, one row for each platform class, and says which of them stands for all other
classes (`generic`).  Keys are sorted and numbers have the digits that read back to the last bit (17 at most), so that
a change of physics is a difference that can be reviewed line by line.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from comparisons.cell import Cell
from comparisons.regression import Baseline, Change, Record, compare, from_plain, pairs, record, to_plain
from plumbline.fingerprint import platform_class
from plumbline.results import Results
from plumbline.run_folder import FolderError
from scenarios.catalogue import unknown

FOLDER = "baselines"
SCHEMA = 1
FIRST = "first recorded"  # reason of a row that replaces none
UNASKED = ("not-run", "not-installed")  # nobody was asked, so there is nothing to keep
OUTSIDE = ("scenario", "engine", "settings", "platform")  # of a record: said once for all rows of a file


class BaselineError(FolderError):
    """A baseline that cannot be read or written; the message names the file."""


class Store:
    """The baseline of one name.

    Parameters
    ----------
    name : str
        Usually that of a suite.
    folder : path
        Where baselines live.
    platform : str, optional
        Platform class; that of this machine if it is not given.
    """

    def __init__(self, name: str, folder: str | Path = FOLDER, platform: str = "") -> None:
        self.name, self.folder = name, Path(folder) / _file_name(name)
        self.platform = platform or platform_class()

    def baseline(self) -> Baseline:
        """The records for this platform: its own where there are any, the generic ones elsewhere.

        Raises
        ------
        UnknownName
            If there is no such baseline; names those there are.
        BaselineError
            If a file is damaged.
        """
        paths = sorted(self.folder.glob("*/*.json"))
        if not paths:
            raise unknown(f"baseline in {self.folder.parent}", self.name, names(self.folder.parent))
        return Baseline(self.name, self.platform, tuple(r for path in paths for r in self._records(path)))

    def save(self, results: Results) -> tuple[int, list[Change]]:
        """Record cells that have no row of this platform yet; the number of new rows, and what differs from its row.

        Rows that are there stay as they are: to replace them takes `accept`.
        """
        new, differing = [], []
        for old, cell in self._beside(results.cells):
            change = compare(old, cell, _question(results, cell), self.platform)
            if old is None:
                new.append((None, cell))
            elif change.outcome != "identical":
                differing.append(change)
        return self._write(results, new, FIRST), differing

    def accept(self, results: Results, chosen: Iterable[Cell], reason: str) -> int:
        """Make the `chosen` cells the rows of this platform, whatever was there; the number of rows that changed."""
        changed = [
            (old, cell)
            for old, cell in self._beside(chosen)
            if compare(old, cell, _question(results, cell), self.platform).outcome != "identical"
        ]
        return self._write(results, changed, reason)

    def _beside(self, cells: Iterable[Cell]) -> list[tuple[Record | None, Cell]]:
        """Cells that were asked, each with the record of this very platform."""
        asked = [cell for cell in cells if cell.state not in UNASKED]
        paths = dict.fromkeys(self._path(cell) for cell in asked)
        return pairs((r for path in paths for r in self._records(path) if r.platform == self.platform), asked)[0]

    def _write(self, results: Results, rows: Iterable[tuple[Record | None, Cell]], reason: str) -> int:
        """Write cells as rows; one whose record has other settings takes its place."""
        written = 0
        for old, cell in rows:
            path = self._path(cell)
            data = _read(path) if path.is_file() else {"schema": SCHEMA, "baseline": self.name, "cells": [],
                                                       "scenario": cell.scenario, "engine": cell.engine}  # fmt: skip
            if old is not None and dict(old.settings) != dict(cell.settings):
                data["cells"] = [entry for entry in data["cells"] if entry["settings"] != dict(old.settings)]
            made = to_plain(record(cell, _question(results, cell), self.platform, reason))
            row = {name: value for name, value in made.items() if name not in OUTSIDE}
            _entry(data, cell.settings, self.platform)["rows"][self.platform] = row
            _replace(path, data)
            written += 1
        return written

    def _path(self, cell: Cell) -> Path:
        return self.folder / _file_name(cell.engine) / f"{_file_name(cell.scenario)}.json"

    def _records(self, path: Path) -> list[Record]:
        """One record for each setting in a file; none if there is no file."""
        if not path.is_file():
            return []
        data, found = _read(path), []
        try:
            for entry in data["cells"]:
                platform = self.platform if self.platform in entry["rows"] else entry["generic"]
                told = {"scenario": data["scenario"], "engine": data["engine"], "settings": entry["settings"]}
                found.append(from_plain({**entry["rows"][platform], **told, "platform": platform}))
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            raise BaselineError(f"{path} is damaged: {type(error).__name__}: {error}") from None
        return found


def names(folder: str | Path = FOLDER) -> list[str]:
    """Baselines that a folder holds."""
    return sorted({path.parents[1].name for path in Path(folder).glob("*/*/*.json")})


def _question(results: Results, cell: Cell) -> str:
    return str(results.campaign.scenarios.get(cell.scenario, {}).get("question", ""))


def _entry(data: dict[str, Any], settings: Mapping[str, Any], platform: str) -> dict[str, Any]:
    """The part of a file that is about these settings; a new one has the first platform stand for all others."""
    for entry in data["cells"]:
        if entry["settings"] == dict(settings):
            return entry
    data["cells"].append({"settings": dict(settings), "generic": platform, "rows": {}})
    data["cells"].sort(key=lambda entry: json.dumps(entry["settings"], sort_keys=True))
    return _entry(data, settings, platform)


def _read(path: Path) -> dict[str, Any]:
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise BaselineError(f"cannot read {path}: {error.strerror or error}") from None
    except ValueError as error:
        raise BaselineError(f"{path} is damaged: {error}") from None
    if not isinstance(data, dict) or data.get("schema") != SCHEMA:
        raise BaselineError(f"{path} is no baseline of schema {SCHEMA}")
    return data


def _replace(path: Path, data: Mapping[str, Any]) -> None:
    """Write a file whole or not at all."""
    part = path.with_name(path.name + ".part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        part.write_text(json.dumps(data, indent=1, sort_keys=True, allow_nan=False) + "\n", encoding="utf-8")
        os.replace(part, path)
    except OSError as error:
        raise BaselineError(f"cannot write {path}: {error.strerror or error}") from None


def _file_name(label: str) -> str:
    """`label` as a file name on every system: "mujoco:stock" -> "mujoco.stock"."""
    return re.sub(r"[^A-Za-z0-9._=,\[\]+-]", "_", label.replace(":", "."))
