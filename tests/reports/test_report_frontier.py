"""Accuracy against time in the report: words, figures and the section of the page, on ladders made by hand."""

import math
import re

import pytest

from comparisons.cell import Campaign, Cell, cell_key
from comparisons.frontier import ERROR
from comparisons.measurement import Measurement
from reports.drawing import svg
from reports.frontier import accuracy, advice_text, target_text
from reports.frontier_figures import panels, shares
from reports.markdown import markdown
from reports.page import page
from reports.suite import suite_of

STEPS = [1.0 / (60 * 2**k) for k in range(9)]
SETTINGS = {"dt": 1e-3}


def cell(engine, error, cost, state="ok", phases=(), dt=1e-3, reason=""):
    rows = [
        ("place error", 2.0 * error, "m", math.nan),
        (ERROR, error, "1", math.nan),
        ("position error", error, "m", 0.1),
    ]
    measured = tuple(Measurement(n, v, u, 0.0, "", tol, tol / 1e9, "", "info" if math.isnan(tol) else "ok")
                     for n, v, u, tol in rows) if state == "ok" else ()  # fmt: skip
    return Cell(
        key=cell_key("drop", 1, engine, "1", {"dt": dt}), scenario="drop", family="drop", version=1, tags=(),
        engine=engine, engine_version="1", settings={"dt": dt}, state=state, reason=reason, duration=1.0,
        measurements=measured, cost=1e-3 * cost, repeats=3, phases={ERROR: phases} if phases else {},
        contention=0.5 if engine == "pybullet" else 0.0,
    )  # fmt: skip


@pytest.fixture
def swept():
    """MuJoCo of first order with a break, PyBullet that gets worse, pymunk that refuses, disturbed clocks."""
    cells = [cell("mujoco", h, 0.01 / h, phases=(0.5 * h, h), dt=h) for h in STEPS[:-1]]
    cells += [cell("mujoco", math.nan, math.nan, "diverged", dt=STEPS[-1], reason="NaN"), cell("mujoco", 1e-3, 10.0)]
    cells += [cell("pybullet", 1e-2 if h > 1e-3 else 0.5, 0.01 / h, dt=h) for h in STEPS] + [
        cell("pybullet", 0.5, 10.0)
    ]
    cells += [cell("pymunk", math.nan, math.nan, "refused", reason="the scene is not planar")]
    told = {c.engine: {"version": "1", "settings": SETTINGS, "knobs": {"dt": STEPS}, "profile": {}} for c in cells}
    scenarios = {"drop": {"checks": [{"quantity": "position error", "tolerance": 0.1, "exact": 1e-9, "why": ""}]}}
    return Campaign(
        "id", "a sweep", "plumbline sweep", "", 1.0, {}, scenarios, told, tuple(cells), sweep={"knobs": "main"}
    )


def test_rows_say_what_it_takes_or_how_near_it_got(swept):
    (section,) = accuracy(swept).sections
    rows = {row.engine: row for row in section.rows}
    # first order: 0.01 / h ms/s at an error h, so 1 ms/s at 1e-2 and 100 ms/s at 1e-4, just within the ladder
    assert [e.text for e in rows["mujoco"].entries[:2]] == ["1 ms/s", "10 ms/s"]
    assert rows["mujoco"].entries[3].text.startswith("not reached (best 1.3×10⁻⁴)")
    assert rows["mujoco"].order == "1.00 (1/60 to 1/7680)"
    assert rows["mujoco"].alarm == "▲ finer is worse: dt 1/7680 to 1/15360: broke"
    assert rows["mujoco"].failures == "1 of 10 settings broke (diverged)"
    assert rows["pybullet"].entries[0].text == "≤ 0.6 ms/s †"
    assert rows["pybullet"].alarm == "▲ finer is worse: dt 1/960 to 1/1920: 0.01 to 0.5"
    assert section.absent == (("pymunk", "refused: the scene is not planar"),)


def test_every_entry_has_a_glyph_and_a_word(swept):
    for row in accuracy(swept).sections[0].rows:
        assert all(e.glyph in "✓✕" and e.text and e.tone in ("pass", "fail") for e in row.entries)


def test_the_figure_draws_every_rung_the_break_on_the_rail_and_the_phases_as_a_band(swept):
    ((title, figure),) = panels(accuracy(swept), swept)
    assert title == "drop"
    mujoco, rail = figure.series[:2]
    assert (len(mujoco.x), rail.engine, list(rail.y)) == (len(STEPS) - 1, "mujoco", [math.inf])
    assert rail.x[0] == mujoco.x[-1]
    assert (mujoco.joined, rail.joined) == (True, False)
    assert list(mujoco.low) == [0.5 * y for y in mujoco.y]
    assert figure.guide == (0.05, "tolerance")  # 0.1 m over the scale of 2 m
    drawn = svg(figure)
    assert drawn.count('class="band"') == 1
    assert "real time" in drawn
    assert len(re.findall(r"<title>mujoco", drawn)) == len(STEPS) + 1


def test_stairs_of_shares_rise_to_what_is_reached(swept):
    stairs = shares(accuracy(swept))
    by_engine = {s.engine: s for s in stairs.series}
    assert by_engine["mujoco"].y[-1] == 0.5  # two of four targets
    assert by_engine["pybullet"].y[-1] == 0.25
    assert "pymunk" not in by_engine  # it was asked nothing
    for one in stairs.series:
        assert list(one.x) == sorted(one.x)
        assert list(one.y) == sorted(one.y)


def test_advice_says_all_that_was_measured(swept):
    text = " ".join(advice_text(accuracy(swept).sections[0].advice))
    assert text.startswith("Use mujoco (its default settings): error 0.001 at 10 ms/s.")
    assert "pybullet does not get there: best 0.01 at 0.6 ms/s (dt = 1/60)." in text
    assert text.endswith("pymunk: refused: the scene is not planar.")


def test_the_page_and_the_summary_tell_it_and_verdicts_are_of_the_defaults(swept):
    html, text = page(swept), markdown(swept)
    assert 'id="frontier"' in html
    assert "not reached (best" in html
    assert "the scene is not planar" in html
    assert "What accuracy costs in time" in text
    assert {dict(c.settings)["dt"] for c in suite_of(swept).cells} == {1e-3}


def test_a_campaign_that_swept_nothing_says_nothing_of_it(swept):
    plain = Campaign("id", "", "", "", 1.0, {}, {}, swept.engines, swept.cells)
    assert accuracy(plain).sections == ()
    assert 'id="frontier"' not in page(plain)
    assert suite_of(plain).cells == plain.cells


@pytest.mark.parametrize(("target", "text"), [(1e-3, "10⁻³"), (1e-6, "10⁻⁶"), (2e-3, "0.002"), (0.1, "0.1")])
def test_targets_are_powers_of_ten(target, text):
    assert target_text(target) == text
