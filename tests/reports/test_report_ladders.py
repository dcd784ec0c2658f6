"""The ladders of the page: every engine on its own line, told by glyph and word, and no verdict of a suite."""

from dataclasses import replace

import pytest

from comparisons.cell import Campaign, Cell
from comparisons.measurement import Measurement
from reports.ladders import chapters, climbs, glyph
from reports.markdown import markdown
from reports.page import page
from reports.suite import without_ladders

WAYS = {"reference": "", "mujoco": "sank", "pybullet": "crash", "pymunk": "timeout", "pymunk:stock": "refused"}


def cell(engine, rung, state, stability=""):
    row = Measurement("stability", float(bool(stability)), "1", 0.5, stability, 0.5, 0.25, "none", "info")
    return Cell(f"{engine.replace(':', '')}{rung:g}", f"tower[count={rung:g}]", "tower", 1, (), engine, "1", {}, state,
                1.0, "advance", f"because of {state}", measurements=(row,))  # fmt: skip


@pytest.fixture(scope="module")
def campaign():
    cells, tried = [], {}
    for engine, way in WAYS.items():
        tried[engine] = []
        for rung in (1.0, 10.0, 100.0):
            broke = way and rung == 100.0
            state = "ok" if not broke else "fail" if way == "sank" else way
            text = "sank: a and b, 1 m, from t = 0.5 s on" if broke and way == "sank" else "stable"
            cells.append(cell(engine, rung, state, text))
            tried[engine].append([rung, cells[-1].key])
    told = {"raises": "cubes", "unit": "m/s", "rungs": [1.0, 10.0, 100.0], "monotone": True, "climbs": tried}
    return Campaign("id", "Ladders", "plumbline ladder", "now", 1.0, {}, {}, {}, tuple(cells), {"towers": told})


def test_a_frontier_for_each_engine(campaign):
    found = {c.engine: c.frontier for c in climbs(campaign)}
    assert {e: (f.good, f.bad, f.word) for e, f in found.items()} == {
        "reference": (100.0, None, ""),
        "mujoco": (10.0, 100.0, "sank"),
        "pybullet": (10.0, 100.0, "crashed"),
        "pymunk": (10.0, 100.0, "too slow"),
        "pymunk:stock": (10.0, 100.0, "refused"),
    }
    assert [e for e, f in found.items() if f.silent] == ["mujoco"]


def test_every_break_has_its_glyph_and_its_word(campaign):
    (chapter,) = chapters(campaign)
    for word, sign in (("holds", "●"), ("sank", "✕"), ("crashed", "!"), ("too slow", "◷"), ("refused", "–")):
        assert f">{word}</text>" in chapter.drawing
        assert glyph("" if word == "holds" else word) == sign
        assert sign == "●" or f">{sign}</text>" in chapter.drawing
    assert "mujoco holds to 10 m/s, sank at 100 m/s" in chapter.drawing
    assert all(engine in chapter.drawing for engine in WAYS)


def test_the_page_without_a_suite_has_ladders_alone(campaign):
    html = page(campaign)
    assert "How far each engine goes" in html
    assert 'id="verdicts"' not in html
    assert html.count('<figure class="ladder">') == 1
    assert "because of crash" in html


def test_steps_on_a_ladder_are_no_verdicts_of_the_suite(campaign):
    other = replace(campaign.cells[0], key="other", scenario="free-fall", family="free-fall")
    both = replace(campaign, cells=(*campaign.cells, other))
    assert without_ladders(both).cells == (other,)
    html = page(both)
    assert 'id="verdicts"' in html
    assert 'id="ladders"' in html
    matrix = html[html.index('<table class="matrix">') : html.index("</table>")]
    assert "free-fall" in matrix
    assert "tower" not in matrix


def test_a_rung_that_was_not_run_is_no_step(campaign):
    cut = replace(campaign, cells=campaign.cells[:2])
    found = {c.engine: c for c in climbs(cut)}
    assert found["reference"].frontier.good == 10.0
    assert found["reference"].word == "not run beyond"
    assert found["mujoco"].tries == ()
    assert "was not run" in chapters(cut)[0].drawing


def test_the_summary_tells_frontiers_and_no_steps(campaign):
    alone = markdown(campaign)
    assert "| towers | mujoco | 10 m/s | 100 m/s | sank |" in alone
    assert "| towers | reference | 100 m/s | – | holds |" in alone
    assert "tower" not in alone.replace("towers", "")
    other = replace(campaign.cells[0], key="other", scenario="free-fall", family="free-fall", engine="other")
    both = markdown(replace(campaign, cells=(*campaign.cells, other)))
    assert "| free-fall |" in both
    assert "| scenario | decides | other |" in both
    assert "tower" not in both.replace("towers", "")
