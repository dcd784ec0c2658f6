"""Results to what people and machines read: page, tables, summaries.

Runs no engine and judges nothing: everything shown comes from a `comparisons.cell.Campaign`.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from adapters.run import Run
    from comparisons.cell import Campaign
    from mechanics.trajectory import Trajectory
    from scenarios.scenario import Scenario


def write(
    campaign: Campaign,
    folder: str | Path,
    traces: Mapping[str, Trajectory | Run] | None = None,
    known: Mapping[str, Scenario] | None = None,
) -> dict[str, Path]:
    """Write every form of the report into `folder`, which is made if it is not there.

    Parameters
    ----------
    traces : mapping, optional
        Key of a cell -> its recorded motion, for the curves over time.
    known : mapping, optional
        Label -> Scenario, for truth and energy in those curves and the restitution that was asked for; without
        it the catalogue is asked.

    Returns
    -------
    dict
        Name of each file -> its path: index.html, summary.md, junit.xml, measurements.csv,
        measurements.parquet, cells.csv.

    Raises
    ------
    OSError
        If the folder cannot be written.
    """
    from reports import tables
    from reports.junit import junit
    from reports.markdown import markdown
    from reports.motion import motion
    from reports.page import page
    from reports.recorded import declared_restitution, look_up
    from reports.suite import suite_of

    place = Path(folder)
    place.mkdir(parents=True, exist_ok=True)
    paths = {name: place / name for name in (
        "index.html", "summary.md", "junit.xml", "measurements.csv", "measurements.parquet", "cells.csv"
    )}  # fmt: skip
    known = look_up(campaign) if known is None else known
    suite = suite_of(campaign)
    html = page(campaign, motion(suite, traces or {}, known), declared_restitution(known))
    texts = {"index.html": html, "summary.md": markdown(campaign), "junit.xml": junit(suite)}
    for name, text in texts.items():
        paths[name].write_bytes(text.encode("utf-8", "replace"))
    tables.write_csv(tables.measurement_rows(campaign), tables.COLUMNS, paths["measurements.csv"])
    tables.write_csv(tables.cell_rows(campaign), tables.CELL, paths["cells.csv"])
    tables.write_parquet(campaign, paths["measurements.parquet"])
    return paths
