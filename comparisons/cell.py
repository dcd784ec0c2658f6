"""Cell: one scenario in one engine with one setting, judged; Campaign: all cells of a run and where they came from.

These records are what the journal holds, what reports are made of and what `Results.frame()` tabulates.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from hashlib import blake2b
from typing import Any

from comparisons.measurement import Measurement

STATES = (
    "ok",  # every demanded quantity within its tolerance
    "fail",  # some quantity beyond its tolerance
    "diverged",  # NaN, infinity, or the engine's own warning
    "error",  # an exception
    "crash",  # the process died of a signal
    "timeout",  # killed at the deadline
    "oom",  # out of memory
    "refused",  # the engine says it cannot, and why
    "not-installed",
    "not-run",  # budget spent, or interrupted
    "xfail",  # fails, and the reason is on record
    "xpass",  # on record as failing, but does not
)


@dataclass(frozen=True)
class Cell:
    """One finished cell of the matrix.

    Attributes
    ----------
    key : str
        Hash of what identifies the cell (see `cell_key`).
    scenario, family, version, tags
        The scenario's label with parameters, its name without, its version, its tags.
    engine, engine_version, settings
        As in `Run`.
    state : str
        One of `STATES`.
    stage, reason : str
        Where and why, for every state but ok.
    time : float
        Simulated time reached [s]; duration : what was asked [s].
    measurements : tuple of Measurement
    cost : float
        Seconds of CPU per simulated second (the envelope); NaN if not measured.
    repeats, contention, deterministic
        Of the timing.
    build_seconds : float
    digest : str
        Hash of the final state.
    impacts : int
        Number of collisions the engine reported; -1 if it does not know.
    notes : tuple of str
        Approximations and remarks.
    known : str
        Explanation on record of a failure (state xfail).
    output : str
        What the engine printed (its end).
    trace : str
        Path of the recorded motion, relative to the run's folder; "" if none is kept.
    reproduce : str
        The one-line command that runs this cell again.
    audit : dict
        What the engine reports of its own soundness.
    phases : dict
        Quantity -> its value at each phase of a step, the first being `trace`; empty if one phase was run.
    """

    key: str
    scenario: str
    family: str
    version: int
    tags: tuple[str, ...]
    engine: str
    engine_version: str
    settings: Mapping[str, float | str]
    state: str
    duration: float
    stage: str = ""
    reason: str = ""
    time: float = 0.0
    measurements: tuple[Measurement, ...] = ()
    cost: float = math.nan
    repeats: int = 0
    contention: float = math.nan
    deterministic: bool = True
    build_seconds: float = math.nan
    digest: str = ""
    impacts: int = -1
    notes: tuple[str, ...] = ()
    known: str = ""
    output: str = ""
    trace: str = ""
    reproduce: str = ""
    audit: Mapping[str, float] = field(default_factory=dict)
    phases: Mapping[str, tuple[float, ...]] = field(default_factory=dict)

    @property
    def phase_count(self) -> int:
        """Phases of a step at which it was run."""
        return max((len(values) for values in self.phases.values()), default=1)

    @property
    def worst(self) -> Measurement | None:
        """The demanded measurement with the largest ratio to its tolerance, or None."""
        judged = [m for m in self.measurements if not math.isnan(m.tolerance)]
        return max(judged, key=lambda m: math.inf if math.isnan(m.value) else m.value / m.tolerance, default=None)

    @property
    def exact(self) -> bool:
        """Whether everything demanded is met to rounding."""
        judged = [m for m in self.measurements if not math.isnan(m.tolerance)]
        return self.state == "ok" and bool(judged) and all(m.verdict == "exact" for m in judged)

    def of(self, quantity: str) -> Measurement | None:
        """The measurement of that name, or None."""
        return next((m for m in self.measurements if m.quantity == quantity), None)


@dataclass(frozen=True)
class Campaign:
    """A run of the harness.

    Attributes
    ----------
    id : str
        Name of its folder.
    title : str
        For people: the suite or the selectors.
    command : str
        The command line that repeats it.
    started : str
        UTC, ISO 8601.
    wall_seconds : float
        Of the whole campaign.
    fingerprint : dict
        Machine, Python, versions of everything that computes.
    scenarios : dict
        Label -> {"summary", "source", "tags", "effects", "checks": [...]}: what a reader needs beside the numbers.
    engines : dict
        Name -> {"version", "settings": {name: value}, "knobs": {name: [values, coarse to fine]},
        "profile": {setting: why}}.
    cells : tuple of Cell
    ladders : dict
        Name -> {"raises", "unit", "rungs", "monotone", "climbs": {engine: [[rung, key of its cell], ...]}}, where
        ladders were climbed: these cells are steps on the way to a frontier, and no verdicts of a suite.
    sweep : dict
        {"knobs": "main" or "all"} if knobs were swept for accuracy against time: then cells at other than the default
        settings are points of curves, and no verdicts of a suite.
    baseline : dict
        What the cells are to be compared with, as `comparisons.regression.Baseline` has it; empty if nothing is.
    effects : dict
        Engine -> scenario -> what its effects do, as `comparisons.effects.to_plain` wrote it, where that was tried.
    """

    id: str
    title: str
    command: str
    started: str
    wall_seconds: float
    fingerprint: Mapping[str, Any]
    scenarios: Mapping[str, Any]
    engines: Mapping[str, Any]
    cells: tuple[Cell, ...]
    ladders: Mapping[str, Any] = field(default_factory=dict)
    sweep: Mapping[str, Any] = field(default_factory=dict)
    baseline: Mapping[str, Any] = field(default_factory=dict)
    effects: Mapping[str, Any] = field(default_factory=dict)


def cell_key(scenario: str, version: int, engine: str, engine_version: str, settings: Mapping[str, Any]) -> str:
    """Hash of what identifies a cell: no metrics, timing or host, so that new metrics judge old runs."""
    identity = [scenario, version, engine, engine_version, dict(sorted(settings.items()))]
    return blake2b(json.dumps(identity, sort_keys=True).encode(), digest_size=8).hexdigest()


def cell_to_json(cell: Cell) -> str:
    """One journal line; NaN and infinity are written as null, "inf" and "-inf"."""
    return json.dumps(_strict(asdict(cell)), sort_keys=True, allow_nan=False)


def cell_from_json(line: str) -> Cell:
    """Cell of a journal line.

    Raises
    ------
    ValueError
        If the line is truncated or not a cell.
    """
    data = json.loads(line)
    known = {f.name for f in fields(Cell)}
    if not isinstance(data, dict) or not {"key", "scenario", "engine", "state"} <= set(data):
        raise ValueError("not a cell")
    rows = tuple(_measurement(m) for m in data.pop("measurements", ()))
    data = {name: _number(value) for name, value in data.items() if name in known}
    for name in ("tags", "notes"):
        data[name] = tuple(data.get(name, ()))
    data["phases"] = {
        quantity: tuple(math.nan if v is None else _number(v) for v in values)
        for quantity, values in data.get("phases", {}).items()
    }
    for name in ("cost", "contention", "build_seconds"):
        data[name] = math.nan if data.get(name) is None else data[name]
    return Cell(**data, measurements=rows)


def _measurement(row: Mapping[str, Any]) -> Measurement:
    numbers = ("value", "time", "tolerance", "exact")
    return Measurement(**{k: (math.nan if v is None else _number(v)) if k in numbers else v for k, v in row.items()})


def _strict(value: Any) -> Any:
    if isinstance(value, float):
        if math.isnan(value):
            return None
        return str(value) if math.isinf(value) else value
    if isinstance(value, Mapping):
        return {k: _strict(v) for k, v in value.items()}
    return [_strict(v) for v in value] if isinstance(value, (list, tuple)) else value


def _number(value: Any) -> Any:
    return float(value) if value in ("inf", "-inf") else value
