"""Run to file and back: one ``.npz`` file a run.

The arrays are those of the trajectory and of the timing; everything else stands in a JSON header.
Nothing in the file is pickled, so an archive from elsewhere can be opened without running it.
"""

from __future__ import annotations

import json
import os
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from adapters.engine import ContactForce, Impact, Refusal
from adapters.run import Failure, Run, Timing
from mechanics.trajectory import Trajectory

SCHEMA = 1
MOTION = ("t", "x", "q", "v", "w")
PLAIN = ("engine", "version", "settings", "knows_events", "build_seconds", "notes", "lead", "audit", "output")


class ArchiveError(ValueError):
    """A file that is not a readable run; the message names the file and what is wrong with it."""


def write(path: str | Path, run: Run) -> Path:
    """Write `run` to `path` and return the path.

    The file appears under its name only when it is whole: a process that is killed leaves no half
    archive behind.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    path = Path(path)
    arrays: dict[str, np.ndarray] = {"header": np.array(json.dumps(_header(run), default=_plain))}
    if run.trajectory is not None:
        arrays |= {name: getattr(run.trajectory, name) for name in MOTION}
    if run.timing is not None:
        arrays |= {"wall": run.timing.wall, "cpu": run.timing.cpu}
    part = path.with_name(path.name + ".part")
    try:
        with part.open("wb") as file:
            np.savez_compressed(file, **arrays)
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)
    return path


def read(path: str | Path) -> Run:
    """The run a file holds.

    Raises
    ------
    ArchiveError
        If the file is not a run, is damaged, or was written by a newer version.
    OSError
        If it cannot be opened.
    """
    try:
        with np.load(path, allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in archive.files}
        header = json.loads(str(arrays["header"]))
        if header["schema"] > SCHEMA:
            raise ArchiveError(f"{path} has schema {header['schema']}; this version reads up to {SCHEMA}")
        return _run(header, arrays)
    except FileNotFoundError:
        raise
    except KeyError as error:
        raise ArchiveError(f"{path} is not an archived run: it lacks {error}") from None
    except (ValueError, TypeError, EOFError, AttributeError, zipfile.BadZipFile) as error:
        if isinstance(error, ArchiveError):
            raise
        raise ArchiveError(f"{path} is not an archived run: {error}") from None


def _header(run: Run) -> dict[str, Any]:
    said = {name: getattr(run, name) for name in PLAIN}
    outcome: dict[str, Any] = {"kind": "trajectory"}
    if isinstance(run.outcome, Refusal):
        outcome = {"kind": "refusal", "reason": run.outcome.reason}
    elif isinstance(run.outcome, Failure):
        outcome = {"kind": "failure", **vars(run.outcome)}
    return {
        "schema": SCHEMA,
        **said,
        "outcome": outcome,
        "events": [list(e) for e in run.events],
        "contacts": [list(c) for c in run.contacts],
        "digests": list(run.timing.digests) if run.timing else [],
    }


def _run(header: dict[str, Any], arrays: dict[str, np.ndarray]) -> Run:
    said = {name: header[name] for name in PLAIN} | {"notes": tuple(header["notes"])}
    motion = Trajectory(*(arrays[name] for name in MOTION)) if "t" in arrays else None
    timing = Timing(arrays["wall"], arrays["cpu"], tuple(header["digests"])) if "wall" in arrays else None
    kind, told = header["outcome"]["kind"], {k: v for k, v in header["outcome"].items() if k != "kind"}
    if kind == "trajectory" and motion is None:
        raise KeyError("t")
    outcome = {"refusal": Refusal, "failure": Failure}[kind](**told) if kind != "trajectory" else motion
    return Run(
        **said,
        outcome=outcome,
        partial=None if kind == "trajectory" else motion,
        events=tuple(Impact(*_tuples(e)) for e in header["events"]),
        contacts=tuple(ContactForce(*_tuples(c)) for c in header["contacts"]),
        timing=timing,
    )


def _plain(value: Any) -> Any:
    """Numbers and arrays of numpy, which engines report freely, as what JSON can say."""
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    raise TypeError(f"{value!r} cannot be archived")


def _tuples(row: list[Any]) -> list[Any]:
    return [tuple(item) if isinstance(item, list) else item for item in row]
