"""The page: every cell once, nothing from outside, nothing executable but its own script."""

from __future__ import annotations

import base64
import re
import time
from collections import Counter
from dataclasses import replace
from hashlib import sha256
from html.parser import HTMLParser
from urllib.parse import parse_qs

import pytest

import reports
from adapters.archive import ArchiveError
from reports.method import data_hash
from reports.motion import motion
from reports.page import page
from reports.recorded import declared_restitution, recorded
from reports.sections import SECTIONS
from reports.series import time_series
from reports.verdict import anchor, mark, sentence

VOID = {"meta", "input", "br", "img", "link", "hr", "path", "rect"}


class Document(HTMLParser):
    """Elements of a page, its text by element, and whether tags nest."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.open: list[str] = []
        self.faults: list[str] = []
        self.texts: dict[str, list[str]] = {}
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        if tag in VOID:
            return
        if not self.open or self.open.pop() != tag:
            self.faults.append(f"</{tag}> at {self.getpos()}")

    def handle_data(self, data):
        if self.open:
            self.texts.setdefault(self.open[-1], []).append(data)

    def of(self, tag: str, **wanted: str) -> list[dict[str, str | None]]:
        return [a for t, a in self.elements if t == tag and all(a.get(k) == v for k, v in wanted.items())]


@pytest.fixture(scope="session")
def html(campaign, traces, falling) -> str:
    known = {"free-fall": falling}
    return page(campaign, motion(campaign, traces, known), declared_restitution(known))


@pytest.fixture(scope="session")
def document(html) -> Document:
    return Document(html)


def test_tags_nest_and_identifiers_are_unique(document):
    assert document.faults == []
    assert document.open == []
    names = Counter(a["id"] for _, a in document.elements if a.get("id"))
    assert [n for n, k in names.items() if k > 1] == []


def test_every_cell_has_one_entry_and_every_verdict_links_to_it(document, campaign):
    fragments = set(anchor(campaign).values())
    assert len(fragments) == len(campaign.cells)
    entries = [a["id"] for _, a in document.elements if (a.get("id") or "").startswith("cell-")]
    assert sorted(entries) == sorted(fragments)
    targets = [a["href"].removeprefix("#") for a in document.of("a") if a.get("title")]
    assert sorted(targets) == sorted(fragments)


def test_every_link_leads_somewhere_inside_the_page(document):
    names = {a["id"] for _, a in document.elements if a.get("id")}
    scenes = {a["data-scene"] for a in document.of("script") if "data-scene" in a}
    links = [a["href"] for a in document.of("a")]
    moments = [parse_qs(link[1:]) for link in links if link.startswith("#scene=")]
    assert len(moments) == 7
    assert all(m["scene"][0] in scenes and 0.0 <= float(m["t"][0]) <= 2.0 for m in moments)
    assert all(link[1:] in names for link in links if not link.startswith("#scene="))


def test_nothing_is_asked_from_outside(html, document):
    assert not re.search(r"https?://|//[a-z]+\.|url\(|@import", html)
    for tag, attributes in document.elements:
        assert tag not in ("img", "link", "iframe", "object", "embed", "base", "video", "audio")
        assert "src" not in attributes
        assert not any(name.startswith("on") for name in attributes)


def test_policy_allows_this_script_and_no_other(html, document):
    (policy,) = (a["content"] for a in document.of("meta") if a.get("http-equiv") == "Content-Security-Policy")
    assert policy.startswith("default-src 'none'")
    (script,) = re.findall(r"<script>(.*?)</script>", html, re.DOTALL)
    digest = base64.b64encode(sha256(script.encode()).digest()).decode()
    assert f"script-src 'sha256-{digest}'" in policy


def test_hostile_texts_stay_texts(hostile):
    html = page(hostile)
    document = Document(html)
    assert document.faults == []
    assert [a for a in document.of("script") if a.get("type") != "text/plain"] == [{}]
    assert document.of("img") == []
    assert len(document.of("style")) == 1
    assert "<script>alert" not in html
    assert "&lt;script&gt;alert(1)&lt;/script&gt;" in html
    shown = [a for a in document.of("details") if "cell" in (a.get("class") or "").split()]
    assert len(shown) == len(hostile.cells)


def test_hostile_texts_can_be_written_to_files(hostile, tmp_path):
    paths = reports.write(hostile, tmp_path)
    assert all(path.stat().st_size > 0 for path in paths.values())


def test_every_state_has_glyph_word_and_reason(every_state):
    html = page(every_state)
    for cell in every_state.cells:
        sign = mark(cell)
        assert sign.glyph
        assert sign.word
        assert f'<span aria-hidden="true">{sign.glyph}</span> {sign.word}' in html
        assert sentence(cell)


def test_table_headers_have_scope(document):
    headers = document.of("th")
    assert headers
    assert all(a.get("scope") in ("col", "row", "colgroup", "rowgroup") for a in headers)


def test_there_is_a_way_past_the_header_and_a_language(document):
    assert document.of("html", lang="en")
    first_link = document.of("a")[0]
    assert first_link["href"] == "#main"
    assert document.of("main", id="main")
    assert len(document.of("h1")) == 1


def test_sections_are_there_and_named_by_their_headings(document):
    wanted = ["verdicts", "cost", "replay", "balance", "findings", "cells", "method"]
    sections = [a["id"] for a in document.of("section") if a.get("id")]
    assert sections == wanted
    headings = {a.get("id") for tag in ("h1", "h2") for a in document.of(tag)}
    assert all(a["aria-labelledby"] in headings for a in document.of("section"))


def test_reproduce_command_of_every_cell_stands_in_code(document, campaign):
    codes = document.texts["code"]
    assert all(cell.reproduce in codes for cell in campaign.cells)
    assert campaign.command in codes


def test_cost_is_never_shown_without_accuracy(html):
    rows = re.findall(r"<summary>(.*?)</summary>", html, re.DOTALL)
    costed = [row for row in rows if re.search(r"\d ms/s", row)]
    assert costed
    assert all(" tol" in row for row in costed)


def test_tolerances_and_sources_are_told(html, campaign):
    assert "Goldstein, Classical Mechanics" in html
    for told in campaign.scenarios.values():
        assert all(check["why"] in html for check in told["checks"])


def test_data_hash_is_of_the_data_and_not_of_their_order(campaign):
    turned = replace(campaign, cells=campaign.cells[::-1], title="another")
    assert data_hash(turned) == data_hash(campaign)
    changed = replace(campaign.cells[0], cost=1.0)
    assert data_hash(replace(campaign, cells=(changed, *campaign.cells[1:]))) != data_hash(campaign)


def test_a_hundred_and_twenty_cells_stay_below_two_megabytes(campaign, traces, falling):
    again = [replace(c, scenario=c.scenario + " again", key=c.key[::-1]) for c in campaign.cells]
    many = replace(campaign, cells=(*campaign.cells, *again)[:120])
    busy = [replace(falling, name=s) for s in {c.scenario for c in many.cells}][:12]
    path = next(iter(traces.values()))
    begun = time.process_time()
    shown = motion(many, {c.key: path for c in many.cells}, {s.name: s for s in busy})
    assert (len(shown.curves), len(shown.replays)) == (12, 12)
    size = len(page(many, shown).encode())
    print(f"{size / 1e6:.2f} MB built in {time.process_time() - begun:.2f} s")
    assert size < 2_000_000


def test_a_lost_recording_costs_one_curve_and_is_told(campaign, traces, falling):
    class Half(dict):
        def __getitem__(self, key):
            if key == lost:
                raise ArchiveError("free-fall.npz is truncated")
            return super().__getitem__(key)

    lost = next(c.key for c in campaign.cells if (c.scenario, c.engine) == ("free-fall", "mujoco"))
    curves = time_series(recorded(campaign, Half(traces), {"free-fall": falling})[0])
    assert curves.remark == "mujoco is not drawn: free-fall.npz is truncated"
    drawn = {s.engine for f in curves.figures for s in f.series}
    assert "mujoco" not in drawn
    assert "pybullet" in drawn


def test_synchronised_energy_of_a_stepping_engine_is_level(campaign, traces, falling):
    energy, height, *_ = time_series(recorded(campaign, traces, {"free-fall": falling})[0]).figures
    assert "synchronised" in energy.title
    assert {s.engine for s in energy.series} == {c.engine for c in campaign.cells}
    # m g v h/2 would be 0.7 J at a step of 20 ms
    assert max(abs(y) for s in energy.series for y in s.y) < 1e-10
    assert height.series[0].engine == ""
    assert "ball" in height.title


def test_an_empty_campaign_makes_a_page(campaign):
    empty = replace(campaign, cells=(), scenarios={}, engines={})
    assert Document(page(empty)).faults == []


def test_every_template_is_a_section_and_every_section_has_one():
    from importlib.resources import files

    templates = {p.name for p in (files("reports") / "assets" / "sections").iterdir()}
    assert templates == {"macros.html", *(f"{section.name}.html" for section in SECTIONS)}
    assert len({a.name for a in SECTIONS}) == len(SECTIONS)
