"""The page in a browser: offline, without scripts, narrow, by keyboard."""

from __future__ import annotations

from pathlib import Path

import pytest

import reports
from reports.palette import contrast

pytestmark = pytest.mark.browser


@pytest.fixture(scope="module")
def page_path(campaign, traces, falling, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("page")
    return reports.write(campaign, folder, traces, {"free-fall": falling})["index.html"]


@pytest.fixture
def visit(chromium, page_path):
    """Opens the page offline; afterwards nothing may have been requested and nothing may have failed."""
    contexts, outside, errors = [], [], []

    def open_page(fragment: str = "", **options):
        context = chromium.new_context(reduced_motion="reduce", **options)
        contexts.append(context)
        context.set_offline(True)
        page = context.new_page()
        page.on("request", lambda r: None if r.url.startswith("file:") else outside.append(r.url))
        page.on("pageerror", lambda e: errors.append(str(e)))
        page.on("console", lambda m: errors.append(m.text) if m.type in ("error", "warning") else None)
        page.goto(page_path.as_uri() + fragment)
        return page

    yield open_page
    for context in contexts:
        context.close()
    assert outside == []
    assert errors == []


def _background(page) -> str:
    return page.evaluate("getComputedStyle(document.body).backgroundColor")


def test_opens_offline_without_errors(visit):
    page = visit()
    page.wait_for_selector("[data-ready]")
    assert page.locator("table.matrix tbody tr").count() == 9
    assert page.locator("details.cell").count() == 63
    assert page.locator("#cost svg").count() == 8


def test_theme_follows_the_system_and_the_switch(visit):
    page = visit(color_scheme="dark")
    assert _background(page) == "rgb(15, 18, 23)"
    page.click("#theme")
    assert _background(page) == "rgb(255, 255, 255)"
    page.click("#theme")
    assert _background(page) == "rgb(15, 18, 23)"
    page.reload()
    assert page.locator("#theme").inner_text().endswith("dark")
    page.click("#theme")
    assert page.locator("#theme").get_attribute("aria-label") == "Theme: as the system"
    assert _background(visit(color_scheme="light")) == "rgb(255, 255, 255)"


def test_filter_and_verdict_narrow_the_cells(visit):
    page = visit()
    page.fill("#filter", "bouncing-ball mujoco")
    assert page.locator("details.cell:visible").count() == 4
    assert page.locator("#found").inner_text() == "4 of 63 cells"
    page.select_option("#state", "fail")
    assert page.locator("details.cell:visible").count() == 2
    page.fill("#filter", "")
    page.select_option("#state", "")
    assert page.locator("details.cell:visible").count() == 63


def test_a_verdict_leads_to_its_cell_even_if_it_is_filtered_out(visit):
    page = visit()
    page.fill("#filter", "nothing of that name")
    page.locator("table.matrix tbody td.tone-broke a").first.click()
    page.wait_for_selector("details.cell[open] .inside")
    assert "diverged" in page.locator("details.cell[open] summary").inner_text()
    pytest.importorskip("playwright.sync_api").expect(page.locator("details.cell[open] .inside")).to_be_in_viewport()


def test_engine_switch_acts_everywhere(visit):
    page = visit()
    page.click(".engines > summary")
    shown = page.locator(".eng-pybullet-stock:visible").count()
    assert shown > 20
    page.uncheck("[data-engine=pybullet-stock]")
    assert page.locator(".eng-pybullet-stock:visible").count() == 0
    assert page.locator(".eng-pybullet:visible").count() > 20
    page.check("[data-engine=pybullet-stock]")
    assert page.locator(".eng-pybullet-stock:visible").count() == shown


@pytest.mark.parametrize("width", [390, 768, 1280])
def test_the_page_never_scrolls_sideways(visit, width):
    page = visit(viewport={"width": width, "height": 844})
    page.evaluate("document.querySelectorAll('details').forEach((d) => { d.open = true; })")
    assert page.evaluate("document.documentElement.scrollWidth") <= width


def test_header_row_and_first_column_stay_in_view(visit):
    page = visit(viewport={"width": 390, "height": 844})
    box = page.locator(".matrix-box")
    box.evaluate("(e) => e.scrollTo(300, 200)")
    outer = box.bounding_box()
    header = page.locator(".matrix thead tr:last-child th").first.bounding_box()
    label = page.locator(".matrix tbody th").nth(4).bounding_box()
    assert header["y"] == pytest.approx(outer["y"], abs=3)
    assert header["x"] == pytest.approx(outer["x"], abs=3)
    assert label["x"] == pytest.approx(outer["x"], abs=3)


def test_header_row_stays_below_the_bar_on_a_wide_page(visit):
    page = visit(viewport={"width": 1500, "height": 500})
    page.locator(".matrix tbody tr").nth(6).evaluate("(e) => e.scrollIntoView({block: 'center'})")
    header = page.locator(".matrix thead tr:last-child th").first.bounding_box()
    bar = page.locator(".bar").bounding_box()
    assert header["y"] == pytest.approx(bar["y"] + bar["height"], abs=2)


def test_verdicts_tables_and_charts_need_no_script(visit):
    page = visit(java_script_enabled=False)
    for selector in ("table.matrix", "#cost svg", "table.balance", "#replay .still svg", "#findings", "details.cell"):
        assert page.locator(selector).first.is_visible(), selector
    for selector in (".filter", ".engines", "#theme", ".copy", ".player"):
        assert page.locator(selector).first.is_hidden(), selector
    page.locator("details.cell summary").first.click()
    assert page.locator("details.cell .inside code").first.is_visible()


def test_first_tab_reaches_the_skip_link_and_focus_is_visible(visit):
    page = visit()
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.className") == "skip"
    assert page.locator(".skip").bounding_box()["x"] >= 0
    page.keyboard.press("Enter")
    assert page.evaluate("document.activeElement.id") == "main"
    page.locator("#theme").focus()
    page.keyboard.press("Tab")
    assert page.evaluate("getComputedStyle(document.activeElement).outlineStyle") == "solid"


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_rendered_text_is_legible(visit, scheme):
    """Contrast of every visible text against the nearest ground below it, as the browser resolves it."""
    page = visit(color_scheme=scheme)
    pairs = page.evaluate("""() => {
      const ground = (e) => {
        for (; e; e = e.parentElement) {
          const c = getComputedStyle(e).backgroundColor;
          if (c !== "rgba(0, 0, 0, 0)") return c;
        }
        return "rgb(255, 255, 255)";
      };
      const seen = new Map();
      for (const e of document.querySelectorAll("body *")) {
        const own = Array.from(e.childNodes).some((n) => n.nodeType === 3 && n.textContent.trim());
        if (!own || !e.getClientRects().length || ["SCRIPT", "STYLE", "title", "desc"].includes(e.tagName)) continue;
        const ink = e.namespaceURI.endsWith("svg") ? getComputedStyle(e).fill : getComputedStyle(e).color;
        seen.set(ink + "|" + ground(e), e.tagName + "." + (e.getAttribute("class") || ""));
      }
      return Array.from(seen);
    }""")
    assert len(pairs) > 10
    for colours, where in pairs:
        ink, ground = (_hex(c) for c in colours.split("|"))
        assert contrast(ink, ground) >= 4.5, (where, ink, ground)


def _hex(colour: str) -> str:
    return "#" + "".join(f"{int(c):02x}" for c in colour.split("(")[1].rstrip(")").split(",")[:3])


def test_printing_is_light_and_shows_every_column(visit):
    page = visit(color_scheme="dark")
    page.emulate_media(media="print", color_scheme="dark")
    assert _background(page) == "rgb(255, 255, 255)"
    assert page.locator(".filter").is_hidden()
    assert page.locator(".matrix-box").evaluate("(e) => getComputedStyle(e).overflowX") == "visible"
    assert len(page.pdf(format="A4")) > 50_000
