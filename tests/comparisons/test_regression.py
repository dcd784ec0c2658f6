"""A cell beside its record: identical bit by bit, inside a band, or news of a kind with a name."""

import math
from dataclasses import replace

import pytest

from comparisons.cell import Campaign, Cell
from comparisons.measurement import Measurement
from comparisons.regression import (
    FINDINGS,
    OTHER,
    OUTCOMES,
    SAME,
    Baseline,
    changes,
    compare,
    from_plain,
    record,
    tally,
    to_plain,
)

HERE, ELSEWHERE = "linux-x86_64-v3", "linux-x86_64-v4"


def measured(quantity, value, tolerance=math.nan, exact=math.nan, text=""):
    verdict = "info" if math.isnan(tolerance) else "ok" if value <= tolerance else "fail"
    return Measurement(quantity, value, "" if text else "m", 1.0, text, tolerance, exact, "", verdict)


def cell(*rows, state="ok", engine="toy", scenario="drop", digest="d0", **more):
    rows = rows or (measured("position error", 0.01, 0.1, 1e-9), measured("energy kept", 0.5))
    told = {"version": 1, "settings": {"dt": 0.1}, "engine_version": "1"} | more
    version, settings, release = told.pop("version"), told.pop("settings"), told.pop("engine_version")
    return Cell("k", scenario, scenario, version, (), engine, release, settings, state, 1.0, measurements=rows,
                digest=digest, **told)  # fmt: skip


def kept(one=None, question="q", platform=HERE):
    return record(one or cell(), question, platform, "first")


def beside(now, before=None, platform=HERE, question="q"):
    return compare(before or kept(), now, question, platform)


def test_the_same_cell_is_identical():
    assert beside(cell()).outcome == "identical"


@pytest.mark.parametrize("least", [math.nextafter(0.01, 1.0), math.nextafter(0.01, 0.0)])
def test_one_bit_is_enough_not_to_be_identical_and_not_enough_to_be_news(least):
    change = beside(cell(measured("position error", least, 0.1, 1e-9), measured("energy kept", 0.5)))
    assert (change.outcome, change.quantity, change.now) == ("in band", "position error", least)


def test_another_last_state_is_not_identical_though_every_number_is():
    assert beside(cell(digest="d1")).outcome == "in band"


def test_a_quantity_that_is_measured_since_then_only_changes_nothing():
    assert beside(cell(*cell().measurements, measured("brand new", 3.0))).outcome == "identical"


@pytest.mark.parametrize(
    ("platform", "value", "half"),
    [(HERE, 0.01, SAME * 0.01), (HERE, 0.4, SAME * 0.4), (ELSEWHERE, 0.05, OTHER * 0.1), (ELSEWHERE, 0.4, OTHER * 0.4)],
)
def test_the_edge_of_the_band_is_a_share_of_the_record_or_elsewhere_of_the_tolerance(platform, value, half):
    state = "ok" if value < 0.1 else "fail"
    before = kept(cell(measured("position error", value, 0.1, 1e-9), state=state))

    def outcome(change):
        return beside(
            cell(measured("position error", value + change, 0.1, 1e-9), state=state), before, platform
        ).outcome

    assert outcome(0.99 * half) == "in band"
    assert outcome(1.01 * half) == "regressed"
    assert outcome(-0.99 * half) == "in band"
    assert outcome(-1.01 * half) == "improved"


def test_rounding_is_never_news():
    before = kept(cell(measured("position error", 1e-14, 0.1, 1e-9)))
    assert beside(cell(measured("position error", 9e-10, 0.1, 1e-9)), before).outcome == "in band"
    assert beside(cell(measured("position error", 1.1e-9, 0.1, 1e-9)), before).outcome == "regressed"


def test_what_nothing_is_demanded_of_moves():
    change = beside(cell(measured("position error", 0.01, 0.1, 1e-9), measured("energy kept", 0.4)))
    assert (change.outcome, change.quantity, change.before, change.now) == ("moved", "energy kept", 0.5, 0.4)


@pytest.mark.parametrize("value", [0.4, 0.0, math.nan, math.inf])
def test_what_nothing_is_demanded_of_is_not_judged_where_rounding_differs(value):
    now = cell(measured("position error", 0.01, 0.1, 1e-9), measured("energy kept", value))
    assert beside(now, platform=ELSEWHERE).outcome == "in band"
    assert beside(now).outcome == "moved"


def test_a_demand_weighs_more_than_what_only_moves():
    change = beside(cell(measured("position error", 0.011, 0.1, 1e-9), measured("energy kept", 0.1)))
    assert (change.outcome, change.quantity) == ("regressed", "position error")


def test_the_worst_of_several_demands_decides():
    before = kept(cell(measured("a", 0.01, 1.0, 1e-9), measured("b", 0.01, 1.0, 1e-9)))
    change = beside(cell(measured("a", 0.02, 1.0, 1e-9), measured("b", 0.03, 1.0, 1e-9)), before)
    assert (change.outcome, change.quantity) == ("regressed", "b")


def test_another_impact_law_moves():
    before = kept(cell(measured("impact law", math.nan, text="sequential")))
    change = beside(cell(measured("impact law", math.nan, text="simultaneous")), before)
    assert (change.outcome, change.why) == ("moved", "impact law: sequential → simultaneous")


def test_a_remark_on_what_could_not_be_measured_is_no_answer():
    before, now = (replace(measured("restitution", math.nan), text=text) for text in ("too slow", "much too slow"))
    assert beside(cell(now), kept(cell(before))).outcome == "identical"


def test_a_demand_that_is_not_measured_any_more_is_gone():
    change = beside(cell(measured("energy kept", 0.5)))
    assert (change.outcome, change.why) == ("gone", "position error is not measured any more")


@pytest.mark.parametrize(
    ("before", "now", "outcome"),
    [("ok", "fail", "regressed"), ("ok", "crash", "regressed"), ("xfail", "timeout", "regressed"),
     ("refused", "crash", "regressed"), ("fail", "ok", "improved"), ("refused", "ok", "improved"),
     ("diverged", "refused", "improved"), ("ok", "refused", "gone"), ("xfail", "refused", "gone"),
     ("ok", "not-installed", "gone"), ("fail", "not-run", "gone"), ("fail", "xfail", "in band"),
     ("xfail", "fail", "in band"), ("crash", "timeout", "in band"), ("refused", "refused", "identical")],
)  # fmt: skip
def test_states_stand_in_an_order(before, now, outcome):
    rows = cell().measurements
    assert beside(cell(*rows, state=now), kept(cell(*rows, state=before))).outcome == outcome


def test_a_wrong_answer_that_was_wrong_before_is_judged_by_its_numbers():
    before = kept(cell(measured("position error", 0.2, 0.1, 1e-9), state="xfail"))
    assert beside(cell(measured("position error", 0.21, 0.1, 1e-9), state="fail"), before).outcome == "regressed"


def test_an_infinite_error_is_worse_and_a_finite_one_better():
    finite, infinite = (cell(measured("a", v, 1.0, 1e-9), state="fail") for v in (2.0, math.inf))
    assert beside(infinite, kept(finite)).outcome == "regressed"
    assert beside(finite, kept(infinite)).outcome == "improved"
    assert beside(infinite, kept(infinite)).outcome == "identical"


def test_a_number_that_became_none_is_worse():
    lost = replace(measured("a", math.nan, 1.0, 1e-9), verdict="unmeasured")
    assert beside(cell(lost), kept(cell(measured("a", 0.1, 1.0, 1e-9)))).outcome == "regressed"


def test_another_question_is_not_comparable():
    assert beside(cell(version=2)).outcome == "not comparable"
    assert beside(cell(), question="another scene").outcome == "not comparable"


def test_a_scene_rounded_elsewhere_is_the_same_question():
    assert beside(cell(), question="rounded elsewhere", platform=ELSEWHERE).outcome == "identical"


def test_another_version_of_the_engine_is_what_the_comparison_is_for():
    assert beside(cell(engine_version="2")).outcome == "identical"


def test_records_survive_the_file():
    one = kept(cell(measured("a", math.inf, 1.0, 1e-9), measured("b", 0.1 + 0.2), measured("law", math.nan, text="x")))
    assert from_plain(to_plain(one)) == one
    with pytest.raises(ValueError, match="digest too much or too little"):
        from_plain({name: value for name, value in to_plain(one).items() if name != "digest"})


def campaign(cells, records, platform=HERE):
    told = {c.scenario: {"question": "q"} for c in cells}
    return Campaign("id", "t", "c", "", 0.0, {}, told, {}, tuple(cells),
                    baseline=Baseline("standard", platform, tuple(records)).to_plain())  # fmt: skip


def outcomes(cells, records):
    return [c.outcome for c in changes(campaign(cells, records))]


def test_a_campaign_is_compared_cell_by_cell_and_what_is_missing_is_gone():
    cells = [cell(scenario=name) for name in ("a", "b", "d")]
    records = [kept(cell(scenario=name)) for name in ("b", "c", "d")]
    assert outcomes(cells, records) == ["new", "identical", "identical", "gone"]
    assert tally(changes(campaign(cells, records))) == {"identical": 2, "gone": 1, "new": 1}


def test_without_a_baseline_nothing_is_compared():
    assert changes(replace(campaign([cell()], []), baseline={})) == ()


def test_what_was_refused_is_not_missed():
    assert outcomes([], [kept(cell(state="refused")), kept(cell(state="crash", scenario="b"))]) == []


def test_a_setting_that_was_added_does_not_part_cell_and_record():
    (change,) = changes(campaign([cell(settings={"dt": 0.1, "knob": 1.0})], [kept()]))
    assert (change.outcome, change.record.settings) == ("in band", {"dt": 0.1})


def test_settings_are_told_apart_where_there_are_several():
    cells = [cell(settings={"dt": dt}) for dt in (0.1, 0.2)]
    records = [kept(cell(settings={"dt": dt})) for dt in (0.3, 0.1)]
    assert outcomes(cells, records) == ["identical", "in band"]
    records = [kept(cell(settings={"dt": dt})) for dt in (0.3, 0.4)]
    assert outcomes(cells, records) == ["new", "new", "gone", "gone"]


def test_every_finding_is_an_outcome():
    assert set(FINDINGS) < set(OUTCOMES)
