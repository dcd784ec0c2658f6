"""What changed against a baseline is said in page, summary and JUnit, by the same words and in the same number."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import replace
from xml.etree import ElementTree as ET

import pytest

from comparisons.regression import FINDINGS, OUTCOMES, Baseline, changes, record
from reports.content import Content
from reports.junit import junit
from reports.markdown import LIMIT, markdown
from reports.page import page
from reports.regressions import LEADS, MARKS, chapters, lead_sentence, shown, told

PLATFORM = "linux-x86_64-v3"


def against(campaign, *other):
    """The campaign with a baseline in which every tenth demanded number was half as large, and the records `other`."""
    records = []
    for n, cell in enumerate(campaign.cells):
        worst = cell.worst
        made = record(cell, "", PLATFORM, "first")
        if n % 10 == 0 and worst is not None and worst.quantity in made.values:
            made = replace(made, values={**made.values, worst.quantity: 0.5 * worst.value - 1e-6})
        records.append(made)
    return replace(campaign, baseline=Baseline("standard", PLATFORM, (*records, *other)).to_plain())


@pytest.fixture(scope="module")
def compared(campaign):
    lost = replace(record(campaign.cells[0], "", PLATFORM), scenario="vanished <scene>", engine="lost-engine")
    return against(campaign, lost)


def test_every_outcome_has_a_mark_and_every_one_but_identical_a_sentence():
    assert set(MARKS) == set(OUTCOMES)
    assert set(LEADS) == set(OUTCOMES) - {"identical"}
    assert len({mark.glyph for mark in MARKS.values()}) == len(OUTCOMES)


def test_all_forms_tell_the_same_findings(compared):
    amount = Counter(c.outcome for c in changes(compared))
    assert amount["regressed"] > 3
    assert amount["gone"] == 1
    html, text, root = page(compared), markdown(compared), ET.fromstring(junit(compared).encode())
    begun = html.index('<section id="regressions"')
    section = html[begun : html.index("</section>", begun)]
    for word in ("regressed", "gone"):
        assert f"### {MARKS[word].glyph} {word} ({amount[word]} cell" in text
        assert len([line for line in text.splitlines() if line.startswith("- **")]) >= amount[word]
        news = [c for c in root.iter("testcase") if f"against the baseline: {word}" in (c.findtext("system-out") or "")]
        lost = [f for f in root.iter("failure") if f.get("type") == word and f.get("message").startswith(word)]
        assert len(news) + (len(lost) if word == "gone" else 0) == amount[word]
    assert section.count("<li>") == amount["regressed"] + amount["gone"]
    assert lead_sentence(compared, changes(compared)) in text.replace("\\", "")


def test_a_cell_that_is_right_and_regressed_is_a_failure_in_junit(compared):
    found = {(c.scenario, c.engine): c for c in changes(compared) if c.outcome in FINDINGS and c.cell}
    right = [place for place, change in found.items() if change.cell.state == "ok"]
    assert right
    root = ET.fromstring(junit(compared).encode())
    for case in root.iter("testcase"):
        engine = case.get("name").split(" ")[0]
        if (case.get("classname"), engine) in right:
            assert case.find("failure").get("type") == "regressed"
            assert case.find("failure").get("message").startswith("regressed: ")


def test_counts_of_junit_agree_with_its_cases(compared):
    root = ET.fromstring(junit(compared).encode())
    assert int(root.get("tests")) == len(compared.cells) + 1
    for suite in [root, *root.findall("testsuite")]:
        for noun, tag in (("failures", "failure"), ("errors", "error"), ("skipped", "skipped")):
            assert int(suite.get(noun)) == len(list(suite.iter(tag)))


def test_links_lead_to_the_cells_and_what_has_none_has_no_link(compared):
    made = shown(Content(compared))
    html = page(compared)
    for chapter in made["chapters"]:
        for line in chapter.lines:
            assert (line.fragment == "") == (line.engine == "lost-engine")
            assert not line.fragment or f'id="{line.fragment}"' in html
    assert "vanished &lt;scene&gt;" in html


def test_a_summary_with_ten_thousand_regressions_keeps_its_limit_and_tells_them_first(campaign):
    cells = [replace(cell, scenario=f"{cell.scenario}-{n}", key=f"{cell.key}{n}")
             for n in range(1500) for cell in campaign.cells[:7]]  # fmt: skip
    many = against(replace(campaign, cells=tuple(cells)))
    was = [record(c, "", PLATFORM) for c in cells]
    half = [replace(r, values={name: 0.1 * value for name, value in r.values.items()}) for r in was]
    many = replace(many, baseline=Baseline("standard", PLATFORM, tuple(half)).to_plain())
    text = markdown(many)
    assert len(text.encode()) < LIMIT
    assert "regressed (" in text
    assert text.index("## Against the baseline") < text.index("Cut to")


def test_hostile_texts_stay_texts(hostile):
    campaign = against(hostile)
    assert any(c.outcome == "regressed" for c in changes(campaign))
    html = page(campaign)
    assert "<script>alert" not in html
    assert html.count("<script>") == 1
    ET.fromstring(junit(campaign).encode())
    text = markdown(campaign)
    section = text[text.index("## Against the baseline") : text.index("| scenario |")]
    assert "img src=x" in section
    assert not re.search(r"(?<!\\)[<>|`]", section)


def test_what_decided_is_told_with_enough_digits_to_differ(campaign):
    cell = next(c for c in campaign.cells if c.worst is not None)
    name, value = cell.worst.quantity, cell.worst.value
    row = replace(cell.of(name), value=value * (1.0 + 1e-9) + 1e-30)
    others = tuple(m for m in cell.measurements if m.quantity != name)
    near = replace(campaign, cells=(replace(cell, measurements=(row, *others)),))
    near = replace(near, baseline=Baseline("b", PLATFORM, (record(cell, "", PLATFORM),)).to_plain())
    (change,) = changes(near)
    before, now = told(change).removeprefix(f"{name} ").split(" (")[0].split(" → ")
    assert before != now


def test_without_a_baseline_there_is_no_section(campaign):
    assert shown(Content(campaign)) == {}
    assert 'id="regressions"' not in page(campaign)
    assert "Against the baseline" not in markdown(campaign)
    assert chapters(campaign, ()) == ()
