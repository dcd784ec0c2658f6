"""Figures as files of their own: SVG by the house, PNG and PDF by a Chromium that draws the same SVG."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from comparisons.cell import Campaign
from reports.charts import cost_figures
from reports.drawing import svg
from reports.figures import Figure
from reports.recorded import recorded
from reports.series import time_series
from reports.suite import suite_of

if TYPE_CHECKING:
    from adapters.run import Run
    from mechanics.trajectory import Trajectory
    from scenarios.scenario import Scenario

KINDS = ("svg", "png", "pdf")
WIDTH, HEIGHT = 640, 320  # [px]
SHARPNESS = 2  # pixels of a PNG per px
BROWSERS = ("chromium", "google-chrome", "chrome")
PAGE = """<!doctype html><meta charset="utf-8"><style>@page{{size:{w}px {h}px;margin:0}}html,body{{margin:0}}
svg{{display:block;width:{w}px;height:{h}px}}</style>{svg}"""
DEADLINE = 60.0  # of the browser for one figure [s]


class NoBrowser(ValueError):
    """PNG and PDF are asked for, and there is no Chromium or it could not draw."""


def figures(
    campaign: Campaign, traces: Mapping[str, Trajectory | Run], known: Mapping[str, Scenario]
) -> Iterator[tuple[str, Figure]]:
    """Name for a file and figure: accuracy against cost of every scenario, then what was recorded over time."""
    suite = suite_of(campaign)
    for figure in cost_figures(suite):
        yield file_name(figure.title, "cost"), figure
    amount = len({cell.scenario for cell in suite.cells})
    for motions in recorded(suite, traces, known, most=amount):
        for figure in time_series(motions).figures:
            yield file_name(motions.scenario, figure.title), figure


def file_name(*parts: str) -> str:
    """Parts of a name as a file name on every system, without its ending."""
    return "-".join(re.sub(r"[^a-z0-9.=]+", "-", part.lower()).strip("-") for part in parts)


def write(figure: Figure, path: Path) -> Path:
    """Write a figure as the ending of the name says, one of `KINDS`.

    Raises
    ------
    NoBrowser
        For PNG and PDF, if no Chromium is found or it fails.
    OSError
        If the file cannot be written.
    """
    drawing = svg(figure, WIDTH, HEIGHT, standalone=True)
    if path.suffix == ".svg":
        path.write_text(drawing + "\n", encoding="utf-8", errors="replace")
        return path
    with tempfile.TemporaryDirectory() as place:
        source = Path(place) / "figure.html"
        source.write_text(PAGE.format(w=WIDTH, h=HEIGHT, svg=drawing), encoding="utf-8", errors="replace")
        _draw(source, path.resolve(), Path(place))
    return path


def _draw(source: Path, target: Path, place: Path) -> None:
    browser = os.environ.get("REPORT_CHROMIUM") or next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        raise NoBrowser(f"{target.name}: PNG and PDF need Chromium ({', '.join(BROWSERS)} on the path); SVG does not")
    made = place / f"made{target.suffix}"
    if target.suffix == ".pdf":
        wanted = [f"--print-to-pdf={made}", "--no-pdf-header-footer"]
    else:
        wanted = [f"--screenshot={made}", f"--window-size={WIDTH},{HEIGHT}", f"--force-device-scale-factor={SHARPNESS}"]
    own = ["--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", f"--user-data-dir={place}/user"]
    command = [browser, *own, *wanted, source.as_uri()]
    done = subprocess.run(command, capture_output=True, text=True, timeout=DEADLINE, check=False)
    if not made.is_file():
        raise NoBrowser(f"{target.name}: {browser} drew nothing: {done.stderr.strip()[-300:]}")
    shutil.copyfile(made, target)
