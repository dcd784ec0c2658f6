"""Figures as files: one SVG for every format, the same figure in each."""

from __future__ import annotations

import shutil
import struct
from xml.etree import ElementTree as ET

import pytest

from reports import figure_files
from reports.figures import Axis, Figure, Series

SVG = "{http://www.w3.org/2000/svg}"
BROWSER = next(filter(None, map(shutil.which, figure_files.BROWSERS)), None)


def test_cost_and_curves_of_every_scenario_have_names_of_their_own(campaign, traces, falling):
    found = dict(figure_files.figures(campaign, traces, {"free-fall": falling}))
    named = [name for name, _ in figure_files.figures(campaign, traces, {"free-fall": falling})]
    assert len(found) == len(named)
    assert "bouncing-ball-e=0.3-cost" in found
    assert "free-fall-distance-from-the-truth" in found
    assert all(name == name.lower() and not set(name) & set("[]/: ") for name in found)


def test_a_file_is_whole_and_shows_every_engine(campaign, traces, falling, tmp_path):
    for name, figure in figure_files.figures(campaign, traces, {"free-fall": falling}):
        root = ET.parse(figure_files.write(figure, tmp_path / f"{name}.svg")).getroot()
        assert root.tag == f"{SVG}svg"
        assert root.find(f"{SVG}style") is not None  # it needs no page around it
        titles = [e.text for e in root.iter(f"{SVG}text") if "title" in (e.get("class") or "")]
        assert titles == [figure.title]


@pytest.fixture
def line():
    return Figure("A line", Axis("t [s]"), Axis("x [m]"), (Series("reference", (0.0, 1.0), (0.0, 1.0), joined=True),))


@pytest.mark.skipif(BROWSER is None, reason="no Chromium is found")
def test_chromium_draws_png_and_pdf_of_the_right_size(line, tmp_path):
    png = figure_files.write(line, tmp_path / "line.png").read_bytes()
    assert png.startswith(b"\x89PNG")
    sharp = figure_files.SHARPNESS
    assert struct.unpack(">II", png[16:24]) == (figure_files.WIDTH * sharp, figure_files.HEIGHT * sharp)
    pdf = figure_files.write(line, tmp_path / "line.pdf").read_bytes()
    assert pdf.startswith(b"%PDF")
    assert pdf.count(b"/Type /Page\n") == 1
    assert b"/MediaBox [0 0 480 240]" in pdf  # 640 x 320 px in points


def test_without_a_browser_it_says_what_is_needed(line, tmp_path, monkeypatch):
    monkeypatch.delenv("REPORT_CHROMIUM", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(figure_files.NoBrowser, match="need Chromium"):
        figure_files.write(line, tmp_path / "line.png")
    assert figure_files.write(line, tmp_path / "line.svg").is_file()
    monkeypatch.setenv("REPORT_CHROMIUM", "/bin/false")
    with pytest.raises(figure_files.NoBrowser, match="/bin/false drew nothing"):
        figure_files.write(line, tmp_path / "line.pdf")
