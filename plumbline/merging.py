"""Several runs joined to one folder, which is a run like any other: it can be reported, compared and gone on with."""

from __future__ import annotations

import os
import shutil
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from comparisons.cell import Cell
from plumbline.results import Results, merged
from plumbline.run_folder import FolderError, RunFolder, phase_paths

HARDWARE = ("system", "machine", "processor", "processors")


def merge(results: Sequence[Results], out: str | Path) -> tuple[Results, list[str]]:
    """The runs as one in a new folder, and remarks on what their machines and packages have not in common.

    Raises
    ------
    FolderError
        If the folder is a run already or cannot be written, or a recorded motion cannot be read.
    """
    out = Path(out)
    if (out / "cells.jsonl").exists():
        raise FolderError(f"{out} is a run already: merge into a new folder")
    whole = merged(results)
    with RunFolder(out) as folder:
        for cell in whole.cells:
            if cell.state != "not-run":
                folder.append(replace(cell, trace=_copied(results[0].folder, cell, out)))
        folder.describe(_manifest(whole, out))
    return Results.read(out, whole.known), differences(results)


def differences(results: Sequence[Results]) -> list[str]:
    """What runs that are put together do not share, in sentences."""
    facts = [r.campaign.fingerprint for r in results]
    remarks = []
    if len({tuple(str(f.get(name)) for name in HARDWARE) for f in facts}) > 1:
        remarks.append("the runs come from different machines: their times are not to be compared")
    packages = [dict(f.get("packages", {})) for f in facts]
    for name in sorted({name for p in packages for name in p}):
        versions = list(dict.fromkeys(str(p.get(name, "none")) for p in packages))
        if len(versions) > 1:
            remarks.append(f"{name} in versions {', '.join(versions)}")
    if len({str(f.get("source")) for f in facts}) > 1:
        remarks.append("the runs were made by different commits of plumbline")
    return remarks


def _copied(first: Path, cell: Cell, out: Path) -> str:
    """The recorded motion of a cell in the new folder, relative to it; a link where the file system has them."""
    if not cell.trace:
        return ""
    source, name = first / cell.trace, f"traces/{cell.key}.npz"
    pairs = zip([source, *phase_paths(source, cell.phase_count)],
                [out / name, *phase_paths(out / name, cell.phase_count)], strict=True)  # fmt: skip
    for old, new in pairs:
        try:
            os.link(old, new)
        except OSError:
            try:
                shutil.copyfile(old, new)
            except OSError as error:
                raise FolderError(f"cannot copy {old} to {new}: {error.strerror or error}") from error
    return name


def _manifest(whole: Results, out: Path) -> dict[str, Any]:
    campaign = whole.campaign
    names = ("title", "command", "started", "wall_seconds", "fingerprint", "scenarios", "engines", "ladders", "sweep",
             "baseline")  # fmt: skip
    plan = [
        {"key": c.key, "scenario": c.scenario, "engine": c.engine, "version": c.engine_version,
         "settings": dict(c.settings), "reproduce": c.reproduce}
        for c in campaign.cells
    ]  # fmt: skip
    return {"id": out.resolve().name, "stopped": "", "plan": plan} | {name: getattr(campaign, name) for name in names}
