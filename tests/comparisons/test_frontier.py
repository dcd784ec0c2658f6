"""Accuracy against time: orders, brackets, fronts, alarms, and who is cheaper than whom, on ladders made by hand."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from comparisons.cell import Campaign, Cell, cell_key
from comparisons.frontier import ERROR, frontiers
from comparisons.measurement import Measurement
from comparisons.order import ROUNDING, alarms, observed_order
from comparisons.pareto import front, front_places, reach
from comparisons.wins import duel, share

STEPS = [1.0 / (60 * 2**k) for k in range(9)]
positive = st.floats(1e-9, 1e3)


# --- order


@given(st.sampled_from([0.5, 1.0, 2.0, 4.0]), st.floats(1e-3, 1e3))
def test_a_power_law_has_its_order(order, factor):
    found = observed_order(STEPS, [factor * h**order for h in STEPS])
    assert found.slope == pytest.approx(order, abs=1e-9)
    assert found.first == STEPS[0]
    assert math.isnan(found.stalls)


def test_the_order_is_that_of_the_asymptotic_stretch_and_the_plateau_is_named():
    errors = [h + 1e-3 for h in STEPS]  # first order down to what never goes away
    found = observed_order(STEPS, errors)
    assert found.slope == pytest.approx(0.9, abs=0.15)
    assert found.last > STEPS[-1]
    assert found.stalls == pytest.approx(1e-3, rel=0.1)


def test_rounding_is_no_plateau():
    errors = [max(0.1 * h**4, 3e-13) for h in STEPS]
    found = observed_order(STEPS, errors)
    assert found.slope == pytest.approx(4.0, abs=1e-6)
    assert math.isnan(found.stalls)


@pytest.mark.parametrize("errors", [[1.0, 0.5], [1.0, 0.5, 0.01, 0.1, 0.002, 3.0, 0.1], [0.0] * 9, [math.nan] * 9])
def test_no_order_is_read_where_slopes_do_not_agree(errors):
    assert math.isnan(observed_order(STEPS[: len(errors)], errors).slope)


def test_steps_must_get_finer():
    with pytest.raises(ValueError, match="do not get finer"):
        observed_order([0.1, 0.2, 0.05], [1.0, 1.0, 1.0])


def test_a_finer_rung_that_is_worse_raises_the_alarm_with_its_step():
    errors = [1e-2, 5e-3, 2.5e-3, 0.9, math.inf, 6e-4]
    found = alarms(STEPS[:6], errors)
    assert [(a.coarse, a.fine) for a in found] == [(STEPS[3], STEPS[4]), (STEPS[2], STEPS[3])]
    assert found[1].growth == pytest.approx(360.0)
    assert alarms(STEPS[:3], [1e-13, 1e-14, 0.9 * ROUNDING]) == ()


# --- fronts and targets


@given(st.lists(st.tuples(positive, positive), min_size=1, max_size=20))
def test_nothing_betters_the_front_and_it_betters_everything_else(points):
    kept = front(points)
    assert kept == sorted(kept)
    for point in points:
        assert any(cost <= point[0] and error <= point[1] for cost, error in kept)
    for one in kept:
        assert not any(p != one and p[0] <= one[0] and p[1] <= one[1] for p in points)
    assert [points[k] for k in front_places(points)] == kept


@given(st.floats(0.5, 4.0), st.floats(1e-2, 1e2), st.floats(1.1, 200.0))
def test_between_neighbours_of_a_power_law_the_cost_is_the_power_law(order, factor, part):
    # error h^order at a cost of factor / h: to reach an error e it costs factor e^(-1/order)
    ladder = [(factor / h, h**order) for h in STEPS]
    target = (STEPS[0] / part) ** order
    found = reach(ladder, target)
    assert found.how in ("between", "at")  # on a rung of the ladder there is nothing to interpolate
    assert found.cost == pytest.approx(factor * target ** (-1.0 / order), rel=1e-9)
    assert ladder[found.place][1] <= target < ladder[found.place - 1][1]


def test_nothing_is_extrapolated():
    ladder = [(1.0, 1e-2), (2.0, 5e-3)]
    assert reach(ladder, 1e-3).how == ""
    assert math.isnan(reach(ladder, 1e-3).cost)
    assert reach(ladder, 0.5) == (1.0, "below", 0)
    assert reach([], 1.0).how == ""


def test_across_a_setting_that_did_worse_the_measured_point_counts():
    ladder = [(1.0, 1e-1), (2.0, 3e-1), (4.0, 1e-3)]
    assert reach(ladder, 1e-2) == (4.0, "at", 2)


def test_an_error_of_zero_can_be_bracketed():
    found = reach([(1.0, 1e-2), (4.0, 0.0)], 1e-9)
    assert found.how == "between"
    assert found.cost == pytest.approx(4.0**0.5)  # half way down to 1e-16 in the logarithm


# --- cells to frontiers


def cell(scenario, engine, error, cost, state="ok", phases=(), **settings):
    rows = () if error is None else (Measurement(ERROR, error, "1", 0.0, "", math.nan, math.nan, "", "info"),)
    return Cell(
        key=cell_key(scenario, 1, engine, "1", settings), scenario=scenario, family=scenario, version=1, tags=(),
        engine=engine, engine_version="1", settings=settings, state=state, duration=1.0, measurements=rows,
        cost=1e-3 * cost, repeats=3, phases={ERROR: phases} if phases else {},
    )  # fmt: skip


def campaign(*cells):
    told = {"knobs": {"dt": STEPS, "iterations": [10.0, 50.0, 200.0]}, "settings": {"dt": 1e-3, "iterations": 50.0}}
    return Campaign("id", "", "", "", 0.0, {}, {}, {c.engine: told for c in cells}, cells)


def ladder(scenario, engine, factor, order=1.0, **other):
    return [cell(scenario, engine, h**order, factor / h, dt=h, iterations=50.0, **other) for h in STEPS]


def test_ladders_are_found_in_the_cells_and_joined_coarse_to_fine():
    cells = ladder("fall", "a", 1.0) + [cell("fall", "a", 0.5, 5.0, dt=1e-3, iterations=n) for n in (200.0, 50.0, 10.0)]
    (found,) = frontiers(campaign(*reversed(cells)))
    dt, iterations = found.curves
    assert (dt.knob, iterations.knob) == ("dt", "iterations")
    assert [p.cell.settings["dt"] for p in dt.points] == STEPS
    assert [p.cell.settings["iterations"] for p in iterations.points] == [10.0, 50.0, 200.0]
    assert dt.order.slope == pytest.approx(1.0)
    assert iterations.order is None
    assert found.default.cell.settings == {"dt": 1e-3, "iterations": 50.0}
    assert len(found.points) == 12


def test_the_worst_phase_is_the_error_and_all_are_told():
    (found,) = frontiers(campaign(*[cell("drop", "a", 0.1, 1.0, phases=(0.1, 0.3, 0.2), dt=h) for h in STEPS]))
    assert found.points[0].error == 0.3
    assert found.points[0].spread == (0.1, 0.2, 0.3)


def test_a_run_that_ended_early_has_no_error_and_is_not_dropped():
    cells = ladder("fall", "a", 1.0)
    cells[-1] = cell("fall", "a", 1e-12, 0.1, state="diverged", dt=STEPS[-1], iterations=50.0)
    (found,) = frontiers(campaign(*cells))
    assert math.isnan(found.points[-1].error)
    assert found.points[-1].broke
    assert found.best.cell.settings["dt"] == STEPS[-2]
    assert found.main.alarms[0].fine == STEPS[-1]


def test_across_a_setting_that_broke_nothing_is_interpolated():
    cells = ladder("fall", "a", 1.0)
    cells[4] = cell("fall", "a", None, math.nan, state="crash", dt=STEPS[4], iterations=50.0)
    reached, point = frontiers(campaign(*cells))[0].reach(1e-3)  # 1/480 s errs by 2.1e-3, 1/1920 s by 5.2e-4
    assert (reached.how, reached.cost) == ("at", pytest.approx(1920.0))
    assert point.cell.settings["dt"] == STEPS[5]


def test_a_refusal_is_no_failure_and_scenarios_without_place_have_no_frontier():
    refused = cell("fall", "b", None, math.nan, state="refused", dt=1e-3)
    other = cell("energy", "a", None, 1.0, dt=1e-3)
    found = frontiers(campaign(*ladder("fall", "a", 1.0), refused, other))
    assert [(f.scenario, f.engine, f.absent[0]) for f in found] == [("fall", "a", ""), ("fall", "b", "refused")]


def test_the_cheapest_curve_reaches_the_target():
    cells = ladder("fall", "a", 1.0)
    cells += [cell("fall", "a", 1e-3, 7.0 * n, dt=1e-3, iterations=n) for n in (10.0, 50.0, 200.0)]
    (found,) = frontiers(campaign(*cells))
    cost, point = found.reach(2e-3)
    assert (cost.cost, cost.how) == (70.0, "below")
    assert point.cell.settings["iterations"] == 10.0
    assert found.cheapest(1e-3).cost == pytest.approx(70.0)
    assert found.cheapest(1e-9) is None


# --- many scenarios


def test_shares_are_absolute_and_do_not_change_when_an_engine_is_added():
    alone = frontiers(campaign(*ladder("fall", "a", 1.0)))
    both = frontiers(campaign(*ladder("fall", "a", 1.0), *ladder("fall", "b", 1e-3)))
    targets = (1e-2, 1e-3, 1e-6)
    assert share(alone, "a", targets) == share(both, "a", targets)
    found = share(alone, "a", targets)
    assert (found.asked, len(found.costs)) == (3, 2)
    assert found.costs == pytest.approx((100.0, 1000.0))
    assert [found.within(c) for c in (99.0, 101.0, 1e9)] == pytest.approx([0.0, 1 / 3, 2 / 3])


def test_refusals_are_counted_and_not_asked():
    found = frontiers(campaign(*ladder("fall", "a", 1.0), cell("roll", "a", None, 1.0, state="refused", dt=1e-3),
                               *ladder("roll", "b", 1.0)))  # fmt: skip
    assert (share(found, "a").asked, share(found, "a").refused) == (4, 1)


def test_what_was_not_run_to_the_end_counts_neither_for_nor_against_anyone():
    cells = ladder("fall", "a", 1.0) + ladder("fall", "b", 1.0)
    cells[8] = cell("fall", "a", None, math.nan, state="not-run", dt=STEPS[8], iterations=50.0)
    found = frontiers(campaign(*cells))
    assert (share(found, "a").asked, share(found, "a").unfinished, share(found, "b").asked) == (0, 1, 4)
    assert duel(found, "a", "b", 1e-3).common == 0


def test_duels_are_fought_on_common_ground_only():
    cells = [
        *ladder("one", "a", 1.0), *ladder("one", "b", 2.0),  # a is cheaper
        *ladder("two", "a", 1.0), *ladder("two", "b", 1.1),  # a draw within the noise of the clock
        *ladder("three", "a", 1.0, order=0.2), *ladder("three", "b", 9.0),  # only b gets there
        *ladder("four", "a", 1.0, order=0.2), *ladder("four", "b", 1.0, order=0.2),
        *ladder("five", "a", 1e-3),
    ]  # fmt: skip
    found = frontiers(campaign(*cells))
    assert duel(found, "a", "b", 1e-3) == (mine := duel(found, "a", "b", 1e-3))
    assert (mine.wins, mine.draws, mine.losses, mine.neither, mine.common) == (1, 1, 1, 1, 4)
    other = duel(found, "b", "a", 1e-3)
    assert (other.wins, other.losses) == (mine.losses, mine.wins)
