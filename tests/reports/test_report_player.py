"""The replay in a browser: one clock for panels and plots, with and without WebGL, by hand, by key and by link."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import reports
from mechanics.effects import Gravity, Rod, Rotation, Tether
from mechanics.scene import Body, Scene
from mechanics.shapes import Box, Capsule, Cylinder, HalfSpace, Mesh, Sphere
from mechanics.trajectory import Trajectory
from reports.packing import unpacked

pytestmark = pytest.mark.browser

ENGINES = ("reference", "mujoco", "pybullet")
SCENE = "every-shape"
WEDGE = Mesh(((-0.2, -0.2, -0.1), (0.2, -0.2, -0.1), (0.0, 0.2, -0.1), (0.0, 0.0, 0.3)),
             ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3))).centred()  # fmt: skip
SHAPES = (Sphere(0.2), Box((0.3, 0.2, 0.4)), Capsule(0.1, 0.3), Cylinder(0.15, 0.3), WEDGE)


def _scene() -> Scene:
    bodies = tuple(
        Body(type(s).__name__, s, mass=1.0, position=(0.7 * k - 1.4, 0.0, 1.5)) for k, s in enumerate(SHAPES)
    )
    links = (Rod("Sphere", "Box"), Tether("Cylinder", "Mesh", 2.0))
    return Scene((Body("floor", HalfSpace()), *bodies), (Gravity(), Rotation(), *links))


def _path(scene: Scene, rate: float) -> Trajectory:
    """Every body sinks and turns about its own axis; `rate` tells engines apart."""
    t = np.linspace(0.0, 1.0, 101)
    x = np.repeat(np.array([b.position for b in scene.bodies])[None], len(t), axis=0)
    q = np.zeros((len(t), len(scene.bodies), 4))
    q[..., 0] = 1.0
    x[:, 1:, 2] -= rate * t[:, None] ** 2
    angle = rate * t[:, None] * np.arange(1, 6) / 2.0
    q[:, 1:, 0], q[:, 1:, 1], q[:, 1:, 3] = np.cos(angle), 0.6 * np.sin(angle), 0.8 * np.sin(angle)
    return Trajectory(t, x, q, np.zeros_like(x), np.zeros_like(x))


@pytest.fixture(scope="module")
def recordings() -> dict[str, Trajectory]:
    paths = {e: _path(_scene(), rate) for e, rate in zip(ENGINES, (1.0, 1.1, 0.8), strict=True)}
    return paths | {"pybullet": paths["pybullet"].until(61)}


@pytest.fixture(scope="module")
def page_path(campaign, recordings, falling, tmp_path_factory) -> Path:
    """A page of one scenario in three engines: MuJoCo fails at 0.8 s, PyBullet's recording ends at 0.6 s."""
    drop = [c for c in campaign.cells if c.scenario == "bouncing-ball" and c.engine in ENGINES]
    cells = [replace(c, scenario=SCENE, family=SCENE, duration=1.0) for c in drop]
    fails = [m for m in cells[1].measurements if m.tolerance == m.tolerance]
    cells[1] = replace(cells[1], state="fail", measurements=(replace(fails[0], value=3.0, verdict="fail"),))
    known = replace(falling, scene=_scene(), duration=1.0, truth=None, name=SCENE)
    told = {SCENE: campaign.scenarios["bouncing-ball"]}
    small = replace(campaign, cells=tuple(cells), scenarios=told)
    traces = {c.key: recordings[c.engine] for c in cells}
    return reports.write(small, tmp_path_factory.mktemp("player"), traces, {SCENE: known})["index.html"]


@pytest.fixture
def watch(chromium, page_path):
    """Opens the page at the replay, offline; afterwards nothing may have been requested and nothing may have failed."""
    contexts, outside, errors = [], [], []

    def open_page(fragment: str = "", query: str = "", browser=None, **options):
        context = (browser or chromium).new_context(reduced_motion="reduce", **options)
        contexts.append(context)
        context.set_offline(True)
        page = context.new_page()
        page.on("request", lambda r: None if r.url.startswith(("file:", "blob:")) else outside.append(r.url))
        page.on("pageerror", lambda e: errors.append(str(e)))
        page.on("console", lambda m: errors.append(m.text) if m.type == "error" else None)
        page.goto(page_path.as_uri() + query + fragment)
        page.wait_for_selector(f"html[data-replays={SCENE}]")
        page.locator("#replay .stage").scroll_into_view_if_needed()
        return page

    yield open_page
    for context in contexts:
        context.close()
    assert outside == []
    assert errors == []


def _settle(page) -> None:
    """Until what was asked for is drawn: two frames."""
    page.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")


def _panels(page) -> list[bytes]:
    """Pixels of each panel, below the names."""
    _settle(page)
    boxes = [tag.bounding_box() for tag in page.locator(".tags .tag").all()]
    clips = [{"x": b["x"] + 3, "y": b["y"] + 60, "width": b["width"] - 6, "height": b["height"] - 64} for b in boxes]
    return [page.screenshot(clip=clip) for clip in clips]


def _cursors(page) -> list[float]:
    _settle(page)
    return [c.bounding_box()["x"] for c in page.locator(".cursor").all()]


def _clock(page) -> str:
    _settle(page)
    return page.locator(".clock").inner_text()


def _slide(page, thousandths: int) -> None:
    page.locator(".track input").fill(str(thousandths))
    _settle(page)


@pytest.mark.parametrize("query", ["", "?canvas"])
def test_the_slider_moves_every_panel_and_every_cursor(watch, query):
    page = watch(query=query)
    before, lines = _panels(page), _cursors(page)
    assert len(before) == 3
    assert len(lines) >= 3
    _slide(page, 500)
    after, moved = _panels(page), _cursors(page)
    assert all(a != b for a, b in zip(before, after, strict=True))
    assert all(b - a > 50 for a, b in zip(lines, moved, strict=True))
    assert _clock(page) == "0.50 s"
    assert page.locator(".track input").get_attribute("aria-valuetext") == "0.50 s"
    _slide(page, 0)
    assert _panels(page) == before


def test_without_webgl_the_page_starts_and_draws_by_hand(chromium_without_webgl, watch):
    page = watch(browser=chromium_without_webgl)
    assert page.evaluate("document.documentElement.dataset.painter") == "canvas"
    before = _panels(page)
    _slide(page, 700)
    assert all(a != b for a, b in zip(before, _panels(page), strict=True))


def test_a_lost_context_is_replaced(watch):
    page = watch()
    assert page.evaluate("document.documentElement.dataset.painter") == "webgl"
    page.evaluate("""() => {
      const gl = document.querySelector(".stage canvas").getContext("webgl2");
      gl.getExtension("WEBGL_lose_context").loseContext();
    }""")
    page.wait_for_selector("html[data-painter=canvas]")
    before = _panels(page)
    _slide(page, 600)
    assert all(a != b for a, b in zip(before, _panels(page), strict=True))


def test_poses_in_the_browser_are_the_recorded_ones_within_half_a_quantum(watch, recordings, page_path):
    page = watch()
    header, _ = unpacked(page.locator(f"[data-scene={SCENE}]").text_content())
    found = page.evaluate("""async () => (await player.scene()).engines.map((e) => ({
      name: e.name, t: [...e.t], x: e.x.map((b) => b.map((a) => [...a])), q: e.q.map((b) => b.map((c) => [...c])),
    }))""")
    assert [e["name"] for e in found] == list(ENGINES)
    for engine in found:
        path = recordings[engine["name"]]
        assert np.abs(np.array(engine["t"]) - path.t).max() <= header["tick"]
        x = np.moveaxis(np.array(engine["x"]), 2, 0)
        assert np.abs(x - path.x[:, 1:]).max() <= 0.5 * header["quantum"] * (1 + 1e-6)
        q = np.moveaxis(np.array(engine["q"]), 2, 0)
        signs = np.sign((q * path.q[:, 1:]).sum(axis=2))[..., None]
        assert np.abs(signs * q - path.q[:, 1:]).max() <= 0.5 * header["turn"] * (1 + 1e-6)


def test_between_samples_bodies_move_on_straight_lines_and_stay_rigid(watch, recordings):
    page = watch()
    pose = page.evaluate(
        "async () => { const s = await player.scene(); return Blocks.poses(s, s.engines[0], 0.505)[2]; }"
    )
    a, b = recordings["reference"].at(50), recordings["reference"].at(51)
    assert pose[:3] == pytest.approx(0.5 * (a.x[2] + b.x[2]), abs=1e-3)
    assert np.linalg.norm(pose[3:]) == pytest.approx(1.0, abs=1e-12)


def test_the_engine_switch_acts_on_panels_and_plots(watch):
    page = watch()
    page.click(".engines > summary")
    page.uncheck("[data-engine=mujoco]")
    assert page.locator(".tags .tag").count() == 2
    assert page.locator(".plots .eng-mujoco:visible").count() == 0
    assert page.locator(".plots .eng-pybullet:visible").count() > 0
    assert page.locator("#amount").inner_text() == "2 of 3"
    page.check("[data-engine=mujoco]")
    assert page.locator(".tags .tag").count() == 3
    page.keyboard.press("Escape")
    assert page.locator(".engines .switch").is_hidden()


def test_by_keyboard_only(watch):
    page = watch()
    page.locator(".stage canvas").focus()
    before = _panels(page)
    page.keyboard.press(".")
    assert _clock(page) == "0.01 s"
    page.keyboard.press(",")
    assert _clock(page) == "0.00 s"
    page.keyboard.press("ArrowLeft")
    assert all(a != b for a, b in zip(before, _panels(page), strict=True))
    page.keyboard.press("0")
    assert _panels(page) == before
    page.keyboard.press("f")
    assert _clock(page) == "0.80 s"
    page.keyboard.press("o")
    assert page.locator(".overlaid").is_checked()
    page.keyboard.press(" ")
    assert page.locator(".play").get_attribute("aria-label") == "Pause"
    page.wait_for_selector(".play[aria-label=Play]")
    assert _clock(page) == "1.00 s"
    page.locator(".track input").focus()
    page.keyboard.press("Home")
    assert _clock(page) == "0.00 s"


def test_a_click_on_a_plot_goes_to_that_time(watch):
    page = watch()
    drawing = page.locator(".plots svg").first
    start, end, *_ = map(float, drawing.get_attribute("data-span").split())
    box, width = drawing.bounding_box(), float(drawing.get_attribute("viewBox").split()[2])
    x = (start + 0.25 * (end - start)) / width * box["width"]
    drawing.click(position={"x": x, "y": box["height"] / 3})
    assert float(_clock(page).split()[0]) == pytest.approx(0.25, abs=0.01)
    assert _cursors(page)[0] == pytest.approx(box["x"] + x, abs=1.5)


def test_a_link_opens_the_moment_the_engines_and_the_view(watch):
    page = watch(f"#scene={SCENE}&t=0.4&engines=reference,pybullet&view=overlay")
    page.wait_for_selector(".clock:text('0.40 s')")
    assert page.locator(".overlaid").is_checked()
    assert [t.get_attribute("class").split()[1] for t in page.locator(".tag").all()] == [
        "eng-reference",
        "eng-pybullet",
    ]
    assert page.locator(".eng-mujoco:visible").count() == 0
    _slide(page, 700)
    page.wait_for_url("**t=0.700**")
    assert page.evaluate("new URLSearchParams(location.hash.slice(1)).get('engines')") == "reference,pybullet"


def test_a_link_to_engines_of_another_page_hides_none(watch):
    page = watch(f"#scene={SCENE}&t=0.4&engines=somebody-else")
    page.wait_for_selector(".clock:text('0.40 s')")
    assert page.locator(".tags .tag").count() == 3


def test_the_failing_cell_leads_to_its_moment(watch):
    page = watch()
    page.locator("table.matrix td.tone-fail a").first.click()
    page.locator("details.cell[open] a", has_text="replay").click()
    page.wait_for_selector(".clock:text('0.80 s')")
    assert page.locator(".tag.eng-mujoco .jump").inner_text() == "fails at 0.80 s"
    _slide(page, 100)
    page.locator(".tag.eng-mujoco .jump").click()
    assert _clock(page) == "0.80 s"


def test_a_recording_that_ends_early_says_so(watch):
    page = watch()
    _slide(page, 500)
    assert page.locator(".tag.eng-pybullet .end").is_hidden()
    _slide(page, 700)
    assert page.locator(".tag.eng-pybullet .end").inner_text() == "ended at 0.60 s"
    assert page.locator(".tag.eng-reference .end").is_hidden()


def test_the_overlay_is_one_panel_with_an_outline_for_every_other_engine(watch):
    page = watch()
    _slide(page, 600)
    page.check(".overlaid")
    colours = page.evaluate("""() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => {
      const c = document.querySelector(".stage canvas"), flat = document.createElement("canvas");
      document.querySelector(".track input").dispatchEvent(new Event("input"));
      requestAnimationFrame(() => {
        [flat.width, flat.height] = [c.width, c.height];
        const paper = flat.getContext("2d");
        paper.drawImage(c, 0, 0);
        const seen = new Map(), data = paper.getImageData(0, 0, flat.width, flat.height).data;
        for (let k = 0; k < data.length; k += 4) {
          if (data[k + 3] < 255) continue;
          const name = data.slice(k, k + 3).join(",");
          seen.set(name, (seen.get(name) || 0) + 1);
        }
        done(Object.fromEntries(seen));
      });
    })))""")
    assert colours.get("0,114,178", 0) > 200  # outlines of MuJoCo and PyBullet, in their own colours
    assert colours.get("184,74,0", 0) > 200


def test_a_broken_block_leaves_the_charts(chromium, page_path, tmp_path):
    text = page_path.read_text(encoding="utf-8")
    start = text.index(f'data-scene="{SCENE}"')
    broken = tmp_path / "broken.html"
    broken.write_text(text[:start] + text[start:].replace(">H4sI", ">AAAA", 1), encoding="utf-8")
    context = chromium.new_context()
    page = context.new_page()
    page.goto(broken.as_uri())
    page.wait_for_selector("html.no-player")
    assert "cannot be shown" in page.locator(".told").inner_text()
    assert page.locator(".still svg").first.is_visible()
    assert page.locator(".stage").is_hidden()
    context.close()
