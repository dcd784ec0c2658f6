"""The section of predicted errors: what was foretold, what was measured, and what is left."""

import math
from dataclasses import replace

import pytest

from comparisons.measurement import Measurement
from comparisons.predicted import CONTACT, LEFT, SOLVER, STEPPING
from reports.content import Content
from reports.ledger import explained, foretold, ledger, shown, summary
from reports.sections import rendered


def row(quantity, value):
    return Measurement(quantity, value, "m", 0.0, "", math.nan, math.nan, "", "info")


@pytest.fixture
def told(campaign):
    """The made-up campaign, in which pymunk's error on two scenarios is its scheme's, and PyBullet's on one of them."""
    known = {
        ("free-fall", "pybullet"): {"position error": 1e-3, STEPPING: 1e-3, LEFT: 1e-9},
        ("bouncing-ball", "pybullet"): {
            "position error": 2e-2,
            STEPPING: 1e-3,
            LEFT: 1e-2,
            CONTACT: 1e-2,
            SOLVER: 1e-2,
        },
        ("free-fall", "pymunk"): {"position error": 1e-3, STEPPING: 1e-3, LEFT: 1e-9},
        ("bouncing-ball", "pymunk"): {"position error": 2e-2, STEPPING: 1e-3, LEFT: 1e-2, CONTACT: 2e-2, SOLVER: 1e-15},
        ("free-fall", "reference"): {"position error": 1e-15, STEPPING: 0.0},
    }
    cells = []
    for cell in campaign.cells:
        rows = known.get((cell.scenario, cell.engine), {})
        kept = tuple(m for m in cell.measurements if m.quantity not in rows)
        cells.append(replace(cell, measurements=(*kept, *(row(q, v) for q, v in rows.items()))))
    return replace(campaign, cells=tuple(cells))


def test_engines_without_an_error_of_first_order_are_not_listed(told):
    assert foretold(told) == ["pybullet", "pymunk"]


def test_what_is_left_is_compared_with_what_was_measured(told):
    cells = {(c.scenario, c.engine): c for c in told.cells}
    assert explained(cells["free-fall", "pybullet"], LEFT)
    assert not explained(cells["bouncing-ball", "pybullet"], SOLVER)
    assert explained(cells["bouncing-ball", "pymunk"], SOLVER)
    assert summary(told, foretold(told)).endswith("to 1 %: pybullet 1 of 2 and pymunk 2 of 2.")


def test_an_account_has_a_row_for_everything_that_is_known(told):
    accounts = {a.scenario: a for a in ledger(told, foretold(told))}
    assert set(accounts) == {"free-fall", "bouncing-ball"}
    rows = {r.name: r for r in accounts["bouncing-ball"].rows}
    assert rows["· by the scheme with an ideal contact"].values == ("0.01", "0.02")
    assert rows["· left beyond scheme and contact: solver"].explained == (False, True)
    assert "· by the scheme with an ideal contact" not in {r.name for r in accounts["free-fall"].rows}


def test_the_page_has_the_section_only_if_something_was_foretold(campaign, told):
    assert shown(Content(campaign)) == {}
    assert "ledger" not in {part.name for part in rendered(Content(campaign))}
    (part,) = (part for part in rendered(Content(told)) if part.name == "ledger")
    assert "✓ 1×10⁻¹⁵" in part.html
    assert "pymunk 2 of 2" in part.html
