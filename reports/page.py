"""The report page: one self-contained file that opens offline and asks nobody for anything."""

from __future__ import annotations

import base64
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from hashlib import blake2b, sha256
from typing import Any

from comparisons.cell import Campaign, Cell, cell_to_json
from comparisons.measurement import Measurement
from reports import museum, phases
from reports.balance import balance
from reports.card import cards, incomparable, lines, remarks
from reports.charts import cost_figures, has_point
from reports.drawing import asset, marker_shape, svg
from reports.findings import findings
from reports.ladders import LEGEND as RUNGS
from reports.ladders import chapters, without_ladders
from reports.matrix import matrix
from reports.numbers import count, duration_text, settings_text, short, unit_text, with_unit
from reports.palette import base, css, profile, slug
from reports.series import Curves
from reports.standing import groups, lead_sentence
from reports.verdict import (
    LEGEND,
    anchor,
    description,
    engines,
    first_of_family,
    mark,
    ratio,
    ratio_text,
    scenarios,
    sentence,
    totals,
)


@dataclass(frozen=True)
class EngineView:
    """An engine as the page names it: marker, name and profile, always in its colour."""

    name: str
    slug: str
    base: str
    profile: str
    icon: str
    version: str


@dataclass(frozen=True)
class CellView:
    """One entry among all cells."""

    cell: Cell
    anchor: str
    mark: Any
    ratio: str
    why: str
    settings: str
    cost: str
    rows: tuple[tuple[str, ...], ...]
    facts: tuple[tuple[str, str], ...]


def page(
    campaign: Campaign, curves: Sequence[Curves] = (), undrawn: int = 0, asked: Mapping[str, float] | None = None
) -> str:
    """The report of a campaign as one HTML document.

    Parameters
    ----------
    curves : sequence of Curves
        What to show over time, as made by `reports.series.time_series`.
    undrawn : int
        Number of scenarios with a recorded motion that are not among them.
    asked : mapping, optional
        Scenario -> coefficient of restitution it declares.
    """
    script, style = asset("page.js"), css(tuple(engines(campaign))) + asset("figure.css") + asset("page.css")
    suite = without_ladders(campaign)
    shown = matrix(suite)
    standing = groups(suite)
    views = {e: _engine(campaign, e) for e in engines(campaign)}
    costed = cost_figures(suite)
    leading = first_of_family(suite, [f.title for f in costed])
    return _template().render(
        campaign=campaign,
        title=campaign.title or campaign.id,
        policy=policy(script),
        script=script,
        style=style,
        engines=views,
        spans=[(g.title, len(g.cards)) for g in standing],
        width=300 + 132 * len(views),  # below this [px] the matrix scrolls in a box of its own
        groups=[(g, spoken(lead_sentence(g, len(shown.rows)), views)) for g in standing],
        matrix=shown,
        legend=LEGEND,
        costs=[(f.title, svg(f)) for f in costed if f.title in leading],
        variants=[(f.title, svg(f)) for f in costed if f.title not in leading],
        uncosted=_uncosted(suite),
        balance=balance(suite, asked or {}),
        ladders=chapters(campaign),
        ladder_legend=RUNGS,
        series=[(c.scenario, [(f.title, svg(f, 560.0, 230.0)) for f in c.figures], c.remark) for c in curves],
        undrawn=undrawn,
        rooms=museum.rooms(campaign),
        phases=phases.lines(campaign),
        card=lines(cards(campaign)),
        carded=tuple(cards(campaign)),
        card_remarks=remarks(cards(campaign)),
        quantities=_quantities(campaign),
        chapters=findings(suite),
        cells=_cells(campaign),
        states=list(dict.fromkeys(mark(c).word for c in campaign.cells)),
        totals=totals(suite),
        tolerances=_tolerances(campaign),
        profiles=_profiles(campaign, views),
        facts=_facts(campaign),
        count=count,
        short=short,
    )


def spoken(sentence: str, views: Mapping[str, EngineView]) -> list[tuple[str, EngineView | None]]:
    """A sentence in pieces: those that name an engine come with it."""
    names = "|".join(re.escape(n) for n in sorted(views, key=len, reverse=True))
    pieces = re.split(rf"(?<![\w:-])({names})(?![\w:-])", sentence)
    return [(piece, views.get(piece) if k % 2 else None) for k, piece in enumerate(pieces)]


def policy(script: str) -> str:
    """Content security policy: nothing may be loaded, and this script is the only one that runs."""
    digest = base64.b64encode(sha256(script.encode()).digest()).decode()
    rules = {
        "default-src": "'none'",
        "style-src": "'unsafe-inline'",
        "script-src": f"'sha256-{digest}'",
        "base-uri": "'none'",
        "form-action": "'none'",
    }
    return "; ".join(f"{name} {value}" for name, value in rules.items())


def data_hash(campaign: Campaign) -> str:
    """Hash of all cells, in any order: equal hashes mean equal data."""
    lines = sorted(cell_to_json(c) for c in campaign.cells)
    return blake2b("\n".join(lines).encode("utf-8", "replace"), digest_size=16).hexdigest()


def _template() -> Any:
    from jinja2 import Environment, FunctionLoader, StrictUndefined
    from markupsafe import Markup

    environment = Environment(
        loader=FunctionLoader(asset), autoescape=True, trim_blocks=True, lstrip_blocks=True, undefined=StrictUndefined
    )
    environment.filters["drawn"] = Markup  # for text of our own making only: SVG, style and script
    return environment.get_template("page.html")


def _engine(campaign: Campaign, engine: str) -> EngineView:
    version = next((c.engine_version for c in campaign.cells if c.engine == engine and c.engine_version), "")
    version = version or str(campaign.engines.get(engine, {}).get("version", ""))
    icon = f'<svg class="fig icon" viewBox="0 0 14 14" aria-hidden="true">{marker_shape(engine, 7.0, 7.0)}</svg>'
    return EngineView(engine, slug(engine), base(engine), profile(engine), icon, version)


def _uncosted(campaign: Campaign) -> list[tuple[str, str]]:
    """(scenario, engine) pairs that were answered but have no point in the figures of cost."""
    return [(c.scenario, c.engine) for c in campaign.cells if c.worst is not None and not has_point(c)]


def _cells(campaign: Campaign) -> list[CellView]:
    views = []
    for cell, fragment in zip(campaign.cells, anchor(campaign).values(), strict=True):
        cost = f"{short(1e3 * cell.cost)} ms/s" if has_point(cell) else ""
        rows = tuple(_measurement(m) for m in cell.measurements)
        settings = settings_text(cell.settings)
        facts = _details(cell, incomparable(campaign, cell))
        views.append(
            CellView(cell, fragment, mark(cell), ratio_text(cell), sentence(cell), settings, cost, rows, facts)
        )
    return views


def _measurement(m: Measurement) -> tuple[str, ...]:
    value = m.text if math.isnan(m.value) else with_unit(m.value, m.unit, 6)
    if m.text and not math.isnan(m.value):
        value = f"{value} ({m.text})"
    demanded = "" if math.isnan(m.tolerance) else with_unit(m.tolerance, m.unit)
    share = "" if math.isnan(m.tolerance) else short(ratio(m))
    when = "" if math.isnan(m.time) else f"{short(m.time, 4)} s"
    return m.quantity, value, demanded, share, when, m.verdict, m.why


def _details(cell: Cell, differs: str) -> tuple[tuple[str, str], ...]:
    timing = ""
    if math.isfinite(cell.cost):
        timing = f"{short(1e3 * cell.cost, 4)} ms CPU per simulated second, {count(cell.repeats, 'repeat')}"
        if math.isfinite(cell.contention):
            timing += f", contention {short(100 * cell.contention, 2)} %"
            timing += " (disturbed: above 25 %)" if cell.contention > 0.25 else ""
    build = f"{short(1e3 * cell.build_seconds)} ms" if math.isfinite(cell.build_seconds) else ""
    reached = (
        f"{short(cell.time, 6)} s of {short(cell.duration, 6)} s" if cell.time else f"{short(cell.duration, 6)} s asked"
    )
    facts = {
        "Engine": f"{cell.engine} {cell.engine_version}",
        "Settings": settings_text(cell.settings),
        "Simulated": reached,
        "Cost": timing,
        "Build": build,
        "Repeats itself": "bit for bit" if cell.deterministic else "no: the cost is the least CPU time of the repeats",
        "Impacts": "" if cell.impacts < 0 else f"{cell.impacts} reported by the engine",
        "Read back": differs,
        "Notes": "; ".join(cell.notes),
        "On record": cell.known,
        "Audit": settings_text(cell.audit),
        "Final state": cell.digest,
        "Recorded motion": cell.trace,
        "Printed": cell.output,
    }
    if not cell.digest:
        del facts["Repeats itself"]
    return tuple((name, text) for name, text in facts.items() if text)


def _quantities(campaign: Campaign) -> list[tuple[str, str, str]]:
    """(name, unit, meaning) of every quantity of the campaign that the comparisons define."""
    from comparisons.judge import describe_quantities

    measured = {m.quantity for c in campaign.cells for m in c.measurements}
    return [(d.name, unit_text(d.unit), d.meaning) for d in describe_quantities() if d.name in measured]


def _tolerances(campaign: Campaign) -> list[tuple[str, dict, list[tuple[str, str, str]]]]:
    """(scenario, description, [(quantity, tolerance with unit, why)]) of every scenario."""
    units = {m.quantity: m.unit for c in campaign.cells for m in c.measurements}
    sections = []
    for scenario in scenarios(campaign):
        told = description(campaign, scenario)
        checks = [
            (c["quantity"], with_unit(c["tolerance"], units.get(c["quantity"], "")), c.get("why", ""))
            for c in told["checks"]
        ]
        sections.append((scenario, told, checks))
    return sections


def _profiles(
    campaign: Campaign, views: Mapping[str, EngineView]
) -> list[tuple[EngineView, str, list[tuple[str, str]]]]:
    """(engine, settings on one line, [(setting, why)]) of every engine."""
    sections = []
    for engine, view in views.items():
        told = campaign.engines.get(engine, {})
        sections.append((view, settings_text(told.get("settings", {})), list(told.get("profile", {}).items())))
    return sections


def _facts(campaign: Campaign) -> list[tuple[str, str]]:
    facts = [("Run", campaign.id), ("Started", campaign.started), ("Took", duration_text(campaign.wall_seconds))]
    for name, value in campaign.fingerprint.items():
        text = settings_text(value) if isinstance(value, Mapping) else str(value)
        facts.append((str(name), text))
    return [*facts, ("Hash of the data", data_hash(campaign))]
