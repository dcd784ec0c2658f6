"""Verdict words, sentences of comparison, Markdown and terminal."""

from __future__ import annotations

import io
import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console

from reports.markdown import LIMIT, markdown
from reports.matrix import matrix
from reports.numbers import listed, rounded, short, unit_text, with_unit
from reports.standing import groups, lead_sentence
from reports.terminal import show
from reports.verdict import (
    chosen,
    engine_order,
    failure_text,
    mark,
    ratio,
    scenarios,
    sentence,
    times_tolerance,
)


@given(st.floats(-1e307, 1e307))
def test_short_numbers_are_right_to_three_digits(value):
    superscript = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹−", "-0123456789-")
    text = short(value).translate(superscript).replace("×10", "e")
    assert float(text) == pytest.approx(value, rel=5.001e-3, abs=0.0)
    digits = text.partition("e")[0].replace(".", "").replace("-", "").lstrip("0")
    assert len(digits.rstrip("0")) <= 3


def test_numbers_and_units_as_printed():
    assert short(0.04249) == "0.0425"
    assert short(2.1e-10) == "2.1×10⁻¹⁰"
    assert short(99999.0) == "1×10⁵"
    assert short(-math.inf) == "−∞"
    assert with_unit(0.5, "1") == "0.5"
    assert with_unit(0.5, "kg.m2/s") == "0.5 kg m²/s"
    assert unit_text("J2") == "J²"
    assert times_tolerance(0.42) == "0.42× tol"
    assert times_tolerance(2.4e-12) == "2×10⁻¹² tol"
    assert (
        rounded("q = (0.8004403633330706, -0.30016513624990143, 1.5), v7.3.1") == "q = (0.8004, -0.3002, 1.5), v7.3.1"
    )
    assert listed(["a", "b", "c"]) == "a, b and c"


def test_failure_says_value_ratio_tolerance_and_time(campaign):
    row = next(c for c in campaign.cells if c.state == "fail").worst
    assert failure_text(row) == "position error 0.298 m is 14.2× the tolerance 0.021 m (worst at t = 0.8 s)"
    lost = replace(row, value=math.nan, text="no impact seen", verdict="unmeasured")
    assert failure_text(lost) == "position error could not be measured: no impact seen"
    assert ratio(lost) == math.inf


def test_a_fault_of_the_harness_is_charged_to_nobody(campaign):
    label = "bouncing-ball"
    blamed = [
        replace(c, state="error", stage="judge", reason="no gap between meshes")
        if (c.scenario, c.engine) == (label, "pybullet") else c for c in campaign.cells
    ]  # fmt: skip
    faulty = replace(campaign, cells=tuple(blamed))
    cell = chosen(faulty)[label, "pybullet"]
    assert mark(cell).word == "not judged"
    assert sentence(cell) == "the harness could not judge it: no gap between meshes"
    fair, before = groups(faulty)[0], groups(campaign)[0]
    assert label in before.common
    assert set(fair.common) == set(before.common) - {label}


def test_fair_profiles_come_first_and_guests_last():
    names = ["pymunk", "zebra", "mujoco:stock", "reference", "ant", "mujoco", "reference:penalty", "pybullet"]
    assert engine_order(names) == [
        "reference", "mujoco", "pybullet", "pymunk", "ant", "zebra", "mujoco:stock", "reference:penalty"
    ]  # fmt: skip


def test_counts_are_compared_on_common_scenarios_only(campaign):
    fair, stock = groups(campaign)
    table = chosen(campaign)
    assert [c.engine for c in fair.cards] == ["reference", "mujoco", "pybullet", "pymunk"]
    for label in fair.common:
        assert all(table[label, c.engine].state != "refused" for c in fair.cards)
    assert "sliding-block" not in fair.common  # the reference refuses it
    assert "sliding-block" in stock.common
    assert "cradle-touching" not in fair.common  # nothing is demanded there
    assert all(c.right_common <= len(fair.common) for c in fair.cards)


def test_cost_is_compared_only_where_all_are_right(campaign):
    fair, _ = groups(campaign)
    table = chosen(campaign)
    assert fair.shared_right
    for label in fair.shared_right:
        assert all(table[label, c.engine].state == "ok" for c in fair.cards)
    for card in fair.cards:
        logs = [math.log(1e3 * table[label, card.engine].cost) for label in fair.shared_right]
        assert card.cost == pytest.approx(math.exp(sum(logs) / len(logs)))
    assert min(c.relative for c in fair.cards) == 1.0


def test_being_fast_and_wrong_earns_nothing(campaign):
    """An engine that fails everything at no cost leaves no scenario on which costs are compared."""
    cells = tuple(
        replace(c, state="fail", cost=1e-9) if c.engine == "mujoco" and c.state == "ok" else c for c in campaign.cells
    )
    fair = groups(replace(campaign, cells=cells))[0]
    assert fair.shared_right == ()
    assert all(math.isnan(c.cost) for c in fair.cards)
    assert "no cost is compared" in lead_sentence(fair, 9)


def test_the_leading_sentence(campaign):
    fair, _ = groups(campaign)
    assert lead_sentence(fair, len(scenarios(campaign))) == (
        "On the 5 of 9 scenarios that every engine can run, reference, mujoco and pymunk are right on all 5, "
        "pybullet on 3. On the 3 scenarios where all are right, reference takes the least CPU time, mujoco 2.6×, "
        "pybullet 4.7×, pymunk 7× as much."
    )


def test_absent_engines_do_not_empty_the_common_scenarios(campaign):
    gone = tuple(
        replace(c, state="not-installed", measurements=()) if c.engine == "pymunk" else c for c in campaign.cells
    )
    fair = groups(replace(campaign, cells=gone))[0]
    assert len(fair.common) >= 5
    (card,) = (c for c in fair.cards if c.engine == "pymunk")
    assert (card.marked, card.absent) == (0, 9)


def test_matrix_shows_default_settings_and_counts_the_others(campaign):
    first = campaign.cells[0]
    finer = replace(first, key="f" * 16, settings={"dt": 1e-4})
    shown = matrix(replace(campaign, cells=(finer, *campaign.cells)))
    entry = shown.rows[0].entries[0]
    assert entry.cell == first
    assert entry.others == 1


def test_every_refusal_and_every_record_has_a_footnote(campaign):
    shown = matrix(campaign)
    for row in shown.rows:
        for entry in row.entries:
            if entry.cell.state not in ("ok", "fail"):
                told = shown.footnotes[entry.note - 1]
                assert entry.cell.engine in told
                assert (entry.cell.known or entry.cell.reason) in told


def test_markdown_has_every_verdict_and_reproduce_line(campaign):
    text = markdown(campaign)
    for entry in (e for row in matrix(campaign).rows for e in row.entries):
        assert f"{entry.mark.glyph} {entry.mark.word}" in text
    red = [c for c in campaign.cells if c.state in ("fail", "diverged", "crash", "timeout", "error", "xpass")]
    assert all(c.reproduce in text for c in red)
    rows = [line for line in text.splitlines() if line.startswith("|")]
    assert len({line.count("|") for line in rows}) == 1
    assert len(rows) == 2 + 9


def test_markdown_keeps_its_limit_and_says_what_is_missing(campaign):
    many = tuple(replace(c, scenario=f"{c.scenario} {n}", key=f"{n}{c.key}") for n in range(60) for c in campaign.cells)
    large = replace(campaign, cells=many)
    assert len(markdown(large).encode()) < LIMIT
    for limit in (5_000, 50_000, 200_000):
        text = markdown(large, limit)
        assert len(text.encode()) <= limit
        assert "left out" in text.splitlines()[-1]
        assert text.count("```") % 2 == 0
    assert "left out" not in markdown(campaign)


def test_markdown_of_hostile_texts_has_no_markup_of_theirs(hostile):
    text = markdown(hostile)
    outside = "".join(text.split("```")[::2])
    assert "<script>" not in outside.replace("\\<", "")
    assert {line.count("|") - line.count("\\|") for line in outside.splitlines() if line.startswith("| ")} == {10}


@pytest.mark.parametrize("width", [60, 100, 200])
def test_terminal_shows_every_verdict_at_any_width(campaign, width):
    out = io.StringIO()
    show(campaign, Console(file=out, width=width, color_system=None))
    text = out.getvalue()
    assert "\x1b" not in text
    for word in ("✓ exact", "✓ ok 0.42×", "✕ fail 14.2×", "– refused", "! crash", "~ known", "▲ now passes"):
        assert word in text
    assert all(len(line) <= width for line in text.splitlines())
    for note in matrix(campaign).footnotes:
        assert note.split()[0] in text
