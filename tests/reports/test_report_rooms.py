"""What the page says of cards, phases and exhibits, from the record of a run alone."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from comparisons.cell import Campaign
from comparisons.reading import Reading, to_plain
from mechanics.scene_file import scene_to_dict
from reports.card import at_stake, differing, incomparable, lines
from reports.markdown import markdown
from reports.museum import rooms
from reports.page import page
from reports.tables import measurement_rows
from scenarios import catalogue

BOUNCE = Reading("restitution", "1", 0.8, 0.1, 0.02, about=("Restitution",), bears_on=("restitution", "energy"))
SPIN = Reading("spin cap", "rad/s", math.inf, 100.0, 0.0, about=("Rotation",), bears_on=("energy",))


@pytest.fixture
def told(campaign: Campaign) -> Campaign:
    """The made-up campaign, whose bouncing ball is an exhibit and whose MuJoCo differs in restitution and spin."""
    (ball,) = catalogue.find("vanishing-bounce[]")
    remedy = {"engine": "mujoco:stock", "settings": {}, "words": "stiffer", "source": "the manual"}
    label = {"number": 2, "title": "The bounce", "shown": "A ball.", "truth": "It comes back.",
             "origin": ["https://a/b"], "figures": {"energy error": 0.0}, "remedies": [remedy]}  # fmt: skip
    scenarios = {k: dict(v) for k, v in campaign.scenarios.items()}
    scenarios["bouncing-ball"] |= {"exhibit": label, "scene": scene_to_dict(ball.scene)}
    settings = next(dict(c.settings) for c in campaign.cells if c.engine == "mujoco")
    card = {"settings": settings, "needs": [], "readings": [to_plain(BOUNCE), to_plain(SPIN)]}
    engines = {k: dict(v) for k, v in campaign.engines.items()}
    engines["mujoco"]["card"] = card
    cells = tuple(
        replace(c, phases=dict.fromkeys(("energy error", "restitution"), (0.1, 0.3, 0.2)))
        if c.scenario == "bouncing-ball"
        else c
        for c in campaign.cells
    )
    return replace(campaign, scenarios=scenarios, engines=engines, cells=cells)


def cell_of(campaign, scenario, engine):
    return next(c for c in campaign.cells if (c.scenario, c.engine) == (scenario, engine))


def test_a_mismatch_marks_the_cells_that_depend_on_it_and_no_others(told):
    ball = cell_of(told, "bouncing-ball", "mujoco")
    assert [r.name for r in differing(told, ball)] == ["restitution"]
    assert "asked 0.8, got 0.1" in incomparable(told, ball)
    assert incomparable(told, cell_of(told, "bouncing-ball", "pymunk")) == ""
    assert incomparable(told, cell_of(told, "free-fall", "mujoco")) == ""
    assert list(at_stake(told)) == ["mujoco"]
    marked = [r for r in measurement_rows(told) if r["not_comparable"]]
    assert {(r["scenario"], r["engine"]) for r in marked} == {("bouncing-ball", "mujoco")}
    assert all("energy" in r["quantity"] or "restitution" in r["quantity"] for r in marked)
    assert len(measurement_rows(told)) == len(measurement_rows(replace(told, engines={})))


def test_other_settings_have_no_card(told):
    ball = cell_of(told, "bouncing-ball", "mujoco")
    assert differing(told, replace(ball, settings={"dt": 0.5})) == ()


def test_the_table_shows_asked_and_got(told):
    (bounce, spin) = lines({"mujoco": (BOUNCE, SPIN)})
    assert (bounce.asked, bounce.entries[0].text) == ("0.8", "≠ 0.1")
    assert (spin.name, spin.asked, spin.entries[0].text) == ("spin cap [rad/s]", "none", "≠ 100")


def test_a_room_has_its_rows_by_kind(told):
    (room,) = rooms(told)
    (table,) = room.tables
    kinds = [row.kind for row in table.rows]
    assert kinds == sorted(kinds, key=["reference", "stock", "fair", "recommended"].index)
    remedied = next(row for row in table.rows if row.kind == "recommended")
    assert (remedied.engine, remedied.remedy) == ("mujoco:stock", "stiffer (the manual)")
    assert {row.figures for row in table.rows} == {("0.1 · 0.2 · 0.3",)}


def test_page_and_summary_tell_all_of_it(told):
    document = page(told)
    for section in ('id="museum"', 'id="phases"', 'id="card"', "It comes back.", "≠ 0.1", "0.1 · 0.2 · 0.3"):
        assert section in document
    assert "asked 0.8, got 0.1" in markdown(told)
