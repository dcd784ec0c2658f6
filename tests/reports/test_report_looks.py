"""Palette, figures and SVG."""

from __future__ import annotations

import itertools
import re
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from comparisons.pareto import front
from reports.charts import cost_figures
from reports.drawing import asset, spread, svg
from reports.figures import Axis, Figure, Series
from reports.palette import HOUSE, MARKERS, THEMES, TONES, contrast, css, look, slug
from reports.series import extremes

SVG = "{http://www.w3.org/2000/svg}"
names = st.text(min_size=1, max_size=30)


def test_contrast_agrees_with_known_pairs():
    assert contrast("#000000", "#ffffff") == pytest.approx(21.0)
    assert contrast("#777777", "#ffffff") == pytest.approx(4.48, abs=0.01)  # the well-known grey that just fails


@pytest.mark.parametrize("theme", THEMES)
def test_all_text_is_legible(theme):
    colours = THEMES[theme]
    for ink, ground in itertools.product(("ink", "muted", "link", "fail-ink"), ("paper", "panel")):
        assert contrast(colours[ink], colours[ground]) >= 4.5, (ink, ground)
    for tone in TONES:
        assert contrast(colours[f"{tone}-ink"], colours[f"{tone}-bg"]) >= 4.5, tone
    assert contrast(colours["strong-rule"], colours["paper"]) >= 3.0  # borders of controls, WCAG 1.4.11


@pytest.mark.parametrize("theme", THEMES)
@pytest.mark.parametrize("engine", HOUSE)
def test_engines_of_the_house_are_legible_as_text(theme, engine):
    for ground in ("paper", "panel"):
        assert contrast(getattr(look(engine), theme), THEMES[theme][ground]) >= 4.5


@given(names)
def test_guests_are_legible_and_always_look_the_same(name):
    style = look(name)
    for theme in THEMES:
        assert contrast(getattr(style, theme), THEMES[theme]["paper"]) >= 4.5
        assert contrast(getattr(style, theme), THEMES[theme]["panel"]) >= 4.5
    look.cache_clear()
    assert look(name) == style
    assert style.marker in MARKERS


def test_no_two_engines_of_the_house_share_marker_or_colour():
    looks = [look(e) for e in HOUSE]
    assert len({s.marker for s in looks}) == len({s.light for s in looks}) == len({s.dark for s in looks}) == len(HOUSE)


def test_profiles_keep_the_hue_and_change_the_marker():
    fair, stock = look("mujoco"), look("mujoco:stock")
    assert (fair.light, fair.dark, fair.marker) == (stock.light, stock.dark, stock.marker)
    other = look("mujoco:tuned")
    assert len({fair.fill, stock.fill, other.fill}) == 3
    assert len({fair.dash, stock.dash, other.dash}) == 3


@given(names, names)
def test_slugs_are_class_names_and_differ_where_names_do(a, b):
    assert re.fullmatch(r"[a-z0-9-]+", slug(a))
    assert (slug(a) == slug(b)) == (a == b)


def test_style_sheet_holds_both_themes_and_every_engine():
    text = css(("mujoco", "ant farm"))
    for theme in THEMES.values():
        assert all(colour in text for colour in theme.values())
    assert f".hide-{slug('ant farm')} .eng-{slug('ant farm')}{{display:none}}" in text


def test_style_sheets_use_only_colours_of_the_palette():
    for name in ("page.css", "figure.css"):
        assert not re.search(r"#[0-9a-fA-F]{3,8}\b(?!\{)|rgb\(|hsl\(", asset(name))
        used = set(re.findall(r"var\(--([a-z-]+)", asset(name)))
        assert used <= set(THEMES["light"]) | {"c", "bar", "dash"}


def _points(tree: ET.Element) -> list[ET.Element]:
    return [e for e in tree.iter(f"{SVG}path") if e.get("class", "").startswith("marker")]


def test_cost_figures_have_one_mark_per_cell_and_one_label_per_engine(campaign):
    figures = cost_figures(campaign)
    costed = [c for c in campaign.cells if c.cost == c.cost and c.worst]
    assert sum(len(s.x) for f in figures for s in f.series) == len(costed)
    for figure in figures:
        tree = ET.fromstring(svg(figure, standalone=True))
        labels = [t.text for t in tree.iter(f"{SVG}text") if t.get("class") == "label"]
        assert len(labels) == len(figure.series)
        assert len(_points(tree)) == sum(len(s.x) for s in figure.series) + len(labels)
        names = [t.text for t in tree.iter(f"{SVG}text") if t.get("class") == "name"]
        assert names == ["CPU ms per simulated second (← cheaper)", "worst error / tolerance (↓ better)"]


def test_all_cost_figures_share_the_axis_of_cost(campaign):
    assert len({f.x.limits for f in cost_figures(campaign)}) == 1


@pytest.mark.parametrize("log", [False, True])
def test_odd_numbers_still_make_well_formed_drawings(log):
    odd = (0.0, float("inf"), float("nan"), 1e300, 1e-300, 5.0)
    series = Series("a<b>&\"'", (1.0,) * 6, odd, joined=True, tips=["<&>"] * 6, label="<")
    figure = Figure("<t>", Axis("<x>", log=True), Axis("y", log=log), (series,), guide=(1.0, "<"), front=True)
    tree = ET.fromstring(svg(figure, standalone=True))
    text = ET.tostring(tree, encoding="unicode")
    assert "nan" not in text.lower().replace("nance", "")
    assert "inf" not in text.lower()


def test_drawings_are_the_same_every_time(campaign):
    assert [svg(f) for f in cost_figures(campaign)] == [svg(f) for f in cost_figures(campaign)]


def test_larger_errors_are_drawn_higher_and_larger_costs_further_right():
    series = Series("mujoco", (1.0, 10.0, 100.0), (1e-6, 1e-3, 1.0))
    tree = ET.fromstring(svg(Figure("", Axis("x", log=True), Axis("y", log=True), (series,)), standalone=True))
    places = [tuple(map(float, re.findall(r"translate\(([-\d.]+) ([-\d.]+)\)", e.get("transform"))[0]))
              for e in _points(tree)[:3]]  # fmt: skip
    x, y = zip(*places, strict=True)
    assert list(x) == sorted(x)
    assert list(y) == sorted(y, reverse=True)
    assert x[1] - x[0] == pytest.approx(x[2] - x[1], abs=0.11)


@given(st.lists(st.tuples(st.integers(0, 30), st.integers(0, 30)), max_size=20))
def test_front_is_what_nothing_equals_or_betters(points):
    kept = front(points)
    assert set(kept) <= set(points)
    for p in set(points):
        beaten = any(q != p and q[0] <= p[0] and q[1] <= p[1] for q in points)
        assert (p in kept) != beaten


@given(st.lists(st.floats(0.0, 200.0), max_size=15))
def test_labels_keep_their_distance_and_order(wanted):
    places = spread(sorted(wanted), 12.0, 0.0, 200.0)
    assert all(b - a >= 12.0 - 1e-9 for a, b in itertools.pairwise(places))
    assert all(p >= -1e-9 for p in places)
    if 12.0 * len(wanted) <= 200.0:
        assert all(p <= 200.0 + 1e-9 for p in places)


@given(st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=400), st.integers(1, 20))
def test_no_peak_is_lost_in_thinning(values, buckets):
    y = np.array(values)
    kept_t, kept_y = extremes(np.arange(len(y), dtype=float), y, buckets)
    assert kept_y.min() == y.min()
    assert kept_y.max() == y.max()
    assert (np.diff(kept_t) > 0).all()
    assert len(kept_t) <= 2 * buckets + 2
    assert np.array_equal(y[kept_t.astype(int)], kept_y)
    assert (kept_t[0], kept_t[-1]) == (0, len(y) - 1)


def test_thinning_keeps_gaps():
    y = np.full(1000, np.nan)
    y[:500] = 1.0
    _, kept = extremes(np.arange(1000.0), y, 10)
    assert np.isnan(kept[-2])
    assert (kept[:5] == 1.0).all()
