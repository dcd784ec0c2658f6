"""Tables for machines: CSV, Parquet and pandas, at full precision."""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from comparisons.cell import Campaign, Cell
from comparisons.reading import dependent
from reports.card import differing, told
from reports.phases import Spread
from reports.verdict import ratio

if TYPE_CHECKING:
    import pandas as pd

IDENTITY = ("run", "cell", "scenario", "family", "version", "engine", "engine_version", "settings", "state")
MEASUREMENT = ("quantity", "value", "unit", "time", "text", "tolerance", "exact", "ratio", "verdict", "why")
PHASES = ("phase_least", "phase_median", "phase_most")
COLUMNS = (*IDENTITY, *MEASUREMENT, "cost", "not_comparable", *PHASES)
CELL = (
    *IDENTITY, "tags", "duration", "stage", "reason", "time", "cost", "repeats", "contention", "deterministic",
    "build_seconds", "digest", "impacts", "worst", "worst_ratio", "known", "notes", "trace", "reproduce",
)  # fmt: skip


def measurement_rows(campaign: Campaign) -> list[dict[str, Any]]:
    """One row per measurement: what was measured, where, and the verdict.

    A cell without measurements (refused, not run, broken before the first sample) has no row here; every
    cell has one in `cell_rows`.
    """
    rows = []
    for cell in campaign.cells:
        identity = _identity(campaign, cell)
        differs = differing(campaign, cell)
        for m in cell.measurements:
            own = {n: ratio(m) if n == "ratio" else getattr(m, n) for n in MEASUREMENT}
            reasons = [told(r) for r in differs if dependent(m.quantity, (r,))]
            spread = Spread.of(cell.phases.get(m.quantity, ()))
            extremes = (spread.least, spread.median, spread.most) if spread else (math.nan,) * 3
            told_of = {"cost": cell.cost, "not_comparable": "; ".join(reasons)}
            rows.append(_encodable(identity | own | told_of | dict(zip(PHASES, extremes, strict=True))))
    return rows


def cell_rows(campaign: Campaign) -> list[dict[str, Any]]:
    """One row per cell: state, reason, cost, worst ratio and the command that repeats it."""
    rows = []
    for cell in campaign.cells:
        worst = cell.worst
        own = {name: getattr(cell, name, None) for name in CELL if name not in IDENTITY}
        own |= {"tags": " ".join(cell.tags), "notes": "\n".join(cell.notes)}
        own |= {"worst": worst.quantity if worst else "", "worst_ratio": ratio(worst)}
        rows.append(_encodable(_identity(campaign, cell) | own))
    return rows


def _identity(campaign: Campaign, cell: Cell) -> dict[str, Any]:
    settings = json.dumps(dict(cell.settings), sort_keys=True)
    special = {"run": campaign.id, "cell": cell.key, "settings": settings}
    return {name: special[name] if name in special else getattr(cell, name) for name in IDENTITY}


def _encodable(row: dict[str, Any]) -> dict[str, Any]:
    """`row` with every text as UTF-8 can hold it: an engine may print half a character."""
    return {name: _text(value) if isinstance(value, str) else value for name, value in row.items()}


def _text(value: str) -> str:
    return value.encode("utf-8", "replace").decode()


def frame(campaign: Campaign) -> pd.DataFrame:
    """Tidy table of the campaign, one row per measurement.

    Returns
    -------
    DataFrame
        Columns `run`, `cell`, `scenario`, `family`, `version`, `engine`, `engine_version`, `settings` (JSON),
        `state`, the fields of `Measurement`, `ratio` (error over tolerance; NaN if nothing is demanded), `cost`
        (CPU seconds per simulated second), `not_comparable` (what the engine got otherwise than asked and this
        quantity depends on), `phase_least`, `phase_median`, `phase_most` (over the phases of a step) and one
        column `setting.NAME` per setting.
    """
    import pandas as pd

    rows = measurement_rows(campaign)
    table = pd.DataFrame(rows, columns=list(COLUMNS))
    return table.assign(**_setting_columns(campaign, [r["cell"] for r in rows]))


def cells_frame(campaign: Campaign) -> pd.DataFrame:
    """Table of the campaign, one row per cell; columns as in `cells.csv`."""
    import pandas as pd

    return pd.DataFrame(cell_rows(campaign), columns=list(CELL))


def _setting_columns(campaign: Campaign, keys: Sequence[str]) -> dict[str, list[Any]]:
    """One column per setting; words where any engine's value is a word, numbers otherwise."""
    by_key = {_text(c.key): c.settings for c in campaign.cells}
    columns = {}
    for name in sorted({name for settings in by_key.values() for name in settings}):
        words = any(isinstance(settings.get(name), str) for settings in by_key.values())
        values = [by_key[key].get(name) for key in keys]
        if words:
            values = [None if v is None else _text(str(v)) for v in values]
        columns[_text(f"setting.{name}")] = values if words else [math.nan if v is None else v for v in values]
    return columns


def write_csv(rows: Iterable[Mapping[str, Any]], columns: Sequence[str], path: Path) -> Path:
    """Write `rows` as CSV (RFC 4180, UTF-8); floats with all digits needed to read them back exactly."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, columns, lineterminator="\n")
        writer.writeheader()
        writer.writerows({name: _plain(row.get(name)) for name in columns} for row in rows)
    return path


def write_parquet(campaign: Campaign, path: Path) -> Path:
    """Write `frame(campaign)` as Parquet (zstd)."""
    frame(campaign).to_parquet(path, compression="zstd", index=False)
    return path


def _plain(value: Any) -> Any:
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return ""
    return repr(value) if isinstance(value, float) else value
