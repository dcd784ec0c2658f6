"""The sections of the page, in order.

A section is one line in `SECTIONS`: a name, what the navigation calls it, and a function that makes from the
`Content` what its template `assets/sections/NAME.html` shows; an empty mapping leaves the section out.
Templates know the macros of `macros.html`, the engines of the campaign as `engines`, and `count` and `short`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

from reports import effects, entries, frontier_section, ledger, method, museum, phases, regressions
from reports.balance import balance
from reports.card import cards, lines, remarks
from reports.charts import cost_figures, has_point
from reports.content import Content, EngineView
from reports.drawing import asset, svg
from reports.findings import findings
from reports.ladders import LEGEND as RUNGS
from reports.ladders import chapters
from reports.numbers import count, short
from reports.replay import SIZE, STEPS
from reports.standing import groups, lead_sentence, times
from reports.verdict import LEGEND, description, first_of_family, totals


@dataclass(frozen=True)
class Section:
    """One section of the page.

    Attributes
    ----------
    name : str
        Its fragment in the page and the name of its template.
    link : str
        What the navigation calls it; "" = not mentioned there.
    shown : function of Content
        Names and values for the template; empty if there is nothing to show.
    """

    name: str
    link: str
    shown: Callable[[Content], Mapping[str, Any]]


@dataclass(frozen=True)
class Rendered:
    """A section as HTML."""

    name: str
    link: str
    html: str


def rendered(content: Content) -> list[Rendered]:
    """Every section that has something to show, in order."""
    told = {"engines": content.engines}
    parts = []
    for section in SECTIONS:
        shown = section.shown(content)
        if shown:
            html = environment().get_template(f"sections/{section.name}.html").render(told | dict(shown))
            parts.append(Rendered(section.name, section.link, html))
    return parts


@cache
def environment() -> Any:
    """The templates of the page: everything is escaped, and an unknown name is an error."""
    from jinja2 import Environment, FunctionLoader, StrictUndefined
    from markupsafe import Markup

    made = Environment(
        loader=FunctionLoader(asset), autoescape=True, trim_blocks=True, lstrip_blocks=True, undefined=StrictUndefined
    )
    made.filters["drawn"] = Markup  # for text of our own making only: SVG, style and script
    made.globals |= {"count": count, "short": short}
    macros = made.get_template("sections/macros.html").module
    made.globals |= {name: made_of for name, made_of in vars(macros).items() if not name.startswith("_")}
    return made


def spoken(sentence: str, views: Mapping[str, EngineView]) -> list[tuple[str, EngineView | None]]:
    """A sentence in pieces: those that name an engine come with it."""
    names = "|".join(re.escape(n) for n in sorted(views, key=len, reverse=True))
    pieces = re.split(rf"(?<![\w:-])({names})(?![\w:-])", sentence)
    return [(piece, views.get(piece) if k % 2 else None) for k, piece in enumerate(pieces)]


def _lead(content: Content) -> Mapping[str, Any]:
    rows = len(content.matrix.rows)
    standing = groups(content.suite)
    told = [(g, spoken(lead_sentence(g, rows), content.engines)) for g in standing]
    return {"groups": told, "verdicts": rows > 0, "ladders": len(content.campaign.ladders), "times": times}


def _verdicts(content: Content) -> Mapping[str, Any]:
    if not content.matrix.rows:
        return {}
    spans = [(g.title, len(g.cards)) for g in groups(content.suite)]
    return {"matrix": content.matrix, "spans": spans, "legend": LEGEND, "totals": totals(content.suite)}


def _cost(content: Content) -> Mapping[str, Any]:
    figures = cost_figures(content.suite)
    if not figures:
        return {}
    leading = first_of_family(content.suite, [f.title for f in figures])
    drawn = [(f.title, svg(f), f.title in leading) for f in figures]
    return {
        "costs": [(title, drawing) for title, drawing, first in drawn if first],
        "variants": [(title, drawing) for title, drawing, first in drawn if not first],
        "uncosted": sum(c.worst is not None and not has_point(c) for c in content.suite.cells),
    }


def _replay(content: Content) -> Mapping[str, Any]:
    motion = content.motion
    if not motion.curves and not motion.replays:
        return {}
    return {
        "series": [(c.scenario, [(f.title, svg(f, *SIZE)) for f in c.figures], c.remark) for c in motion.curves],
        "undrawn": motion.recorded - len(motion.curves),
        "replays": [(r, description(content.suite, r.scenario)["summary"]) for r in motion.replays],
        "dropped": motion.recorded - len(motion.replays),
        "steps": STEPS,
    }


def _ladders(content: Content) -> Mapping[str, Any]:
    drawn = chapters(content.campaign)
    return {"ladders": drawn, "legend": RUNGS} if drawn else {}


def _balance(content: Content) -> Mapping[str, Any]:
    sections = balance(content.suite, content.asked)
    return {"balance": sections, "order": _views(content, content.matrix.engines)} if sections else {}


def _museum(content: Content) -> Mapping[str, Any]:
    rooms = museum.rooms(content.campaign)
    return {"rooms": rooms} if rooms else {}


def _phases(content: Content) -> Mapping[str, Any]:
    spreads = phases.lines(content.campaign)
    return {"phases": spreads, "order": _views(content, content.engines)} if spreads else {}


def _card(content: Content) -> Mapping[str, Any]:
    held = cards(content.campaign)
    return {"card": lines(held), "order": _views(content, held), "remarks": remarks(held)} if held else {}


def _findings(content: Content) -> Mapping[str, Any]:
    told = findings(content.suite)
    return {"chapters": told} if told else {}


def _views(content: Content, engines: Iterable[str]) -> list[EngineView]:
    return [content.engines[e] for e in engines]


SECTIONS = (
    Section("lead", "", _lead),
    Section("verdicts", "Verdicts", _verdicts),
    Section("regressions", "Regressions", regressions.shown),
    Section("frontier", "Accuracy", frontier_section.shown),
    Section("cost", "Cost", _cost),
    Section("replay", "Replay", _replay),
    Section("ladders", "Ladders", _ladders),
    Section("museum", "Museum", _museum),
    Section("balance", "Energy", _balance),
    Section("ledger", "", ledger.shown),
    Section("phases", "", _phases),
    Section("card", "", _card),
    Section("effects", "Effects", effects.shown),
    Section("findings", "Findings", _findings),
    Section("cells", "All cells", entries.shown),
    Section("method", "Method", method.shown),
)
