"""Effects in words and numbers: what a row says, what a column comes to, and that the page shows both."""

import math
from dataclasses import replace

import pytest

from comparisons.effects import ALL, VERDICTS, Proof, Row, from_plain, to_plain
from reports.effects import Saving, factor, finding, ledgers
from reports.page import page

NAN = math.nan
ROWS = (
    Row("Gravity", True, "changes", 0.5, 0.01),
    Row("Rotation", False, "same", 3e-16, 1.0, 1.25, 5),
    Row("Drag", False, "same", 0.0, 1.0, 0.8, 1),
    Row("Resting", True, "missing", NAN, 0.25, text="bodies stay in contact"),
    Row("Friction", False, "broke", NAN, 0.1, text="the run failed"),
    Row(ALL, False, "same until", 1e-12, 0.5, text="cut short: 4 times slower than the scene as declared"),
)
PROOF = Proof("made[e=1]", "reference", "1.0", 1.0, 1.0, 0.02, ROWS)


def test_a_row_is_a_sentence():
    said = [finding(row) for row in ROWS]
    assert said[0] == "left out, the motion is another one from t = 0.01 s on"
    assert said[1].startswith(
        "switched on, the motion is the same to 3e-16 of the motion; with it a run takes 1.25 times"
    )
    assert "to the last bit" in said[2]
    assert said[3].endswith("names the effect: bodies stay in contact")
    assert "until t = 0.5 s" in said[5]
    assert [factor(row) for row in ROWS] == ["acts", "1.25", "0.80", "acts", "broke", "> 4"]
    assert all(finding(Row("Drag", False, verdict)) for verdict in VERDICTS)


def test_a_proof_survives_json():
    again = from_plain(to_plain(PROOF))
    assert repr(again) == repr(PROOF)  # NaN is not equal to itself
    assert all(value is not NAN for row in to_plain(PROOF)["rows"] for value in row.values())


def test_a_saving_is_the_geometric_mean_of_the_scenes_in_which_nothing_changed():
    rows = [Row("Drag", False, "same", d, 1.0, r, 1) for d, r in ((1e-15, 2.0), (1e-12, 0.5), (0.0, 8.0))]
    saving = Saving.of([*rows, Row("Drag", False, "changes", 1.0, 0.0, 100.0, 1)])
    assert (saving.scenes, saving.same, saving.worst) == (4, 3, 1e-12)
    assert saving.middle == pytest.approx(2.0)
    assert saving.text == "2.00 (0.5 to 8)"
    assert Saving.of([]).text == "–"


def test_a_ledger_counts_effects_and_not_all_of_them_at_once():
    (ledger,) = ledgers({"reference": {PROOF.scenario: to_plain(PROOF) | {"scene": 1}}})
    assert ledger.count(False, *VERDICTS) == 3
    assert ledger.count(False, "same", "same until") == 2
    assert "of 3 effects that are not declared 2 change nothing" in ledger.sentence
    assert "of 2 that are declared 2 change the motion" in ledger.sentence


def test_a_declared_effect_that_does_nothing_is_shown_with_its_reason(campaign):
    idle = replace(PROOF, rows=(*ROWS, Row("Spring", True, "same", 0.0, 1.0)))
    told = {"reference": {idle.scenario: to_plain(idle) | {"scene": 1, "because": {"Spring": "it is taut <later>"}}}}
    (ledger,) = ledgers(told)
    assert "2 change the motion" in ledger.sentence
    assert "1 are declared for a reason that is given" in ledger.sentence
    html = page(replace(campaign, effects=told))
    assert "declared because: it is taut &lt;later&gt;" in html
    assert html.count("declared because") == 1


def test_the_page_shows_what_was_found_and_what_was_refused(campaign):
    refused = replace(PROOF, scenario="other", rows=(), reason="it has <no> floor")
    told = {"reference": {p.scenario: to_plain(p) | {"scene": 1} for p in (PROOF, refused)}}
    html = page(replace(campaign, effects=told))
    assert 'id="effects"' in html
    assert "made[e=1]" in html
    assert "same in 1 of 1 scene" in html
    assert "other: it has &lt;no&gt; floor" in html
    assert 'id="effects"' not in page(campaign)


def test_what_another_version_wrote_is_left_out(campaign):
    told = {"reference": {"old": {"scene": 1, "rows": [], "unheard": 3}}}
    (ledger,) = ledgers(told)
    assert ledger.proofs == ()
