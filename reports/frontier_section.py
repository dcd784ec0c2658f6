"""The section of the page on accuracy against time: what its template shows."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from comparisons.frontier import TARGETS
from comparisons.wins import MARGIN
from reports.content import Content
from reports.drawing import svg
from reports.frontier import ADVISED, BADGE, BUDGETS, Section, advice_text, duel_text, share_text, target_text
from reports.frontier_figures import panels, shares
from reports.numbers import listed
from reports.verdict import first_of_family

PANEL = (440.0, 300.0)  # [px]


def shown(content: Content) -> Mapping[str, Any]:
    """Names and values for the template; empty if nothing was swept."""
    told = content.frontier
    if not told.sections:
        return {}
    drawn = [(title, svg(figure, *PANEL)) for title, figure in panels(told, content.campaign)]
    leading = first_of_family(content.campaign, [title for title, _ in drawn])
    stairs = shares(told)
    return {
        "order": [content.engines[e] for e in told.engines],
        "targets": listed([target_text(t) for t in TARGETS]),
        "columns": [target_text(t) for t in TARGETS],
        "shares_figure": svg(stairs, 620.0, 280.0) if stairs else "",
        "shares": [(budget, [share_text(one, budget) for one in told.shares]) for budget in BUDGETS],
        "coverage": [
            ("scenarios refused", [one.refused for one in told.shares]),
            ("scenarios not run to the end", [one.unfinished for one in told.shares]),
        ],
        "duels": [(target_text(target), _matrix(content, target)) for target in TARGETS],
        "margin": MARGIN,
        "advised": target_text(ADVISED),
        "badge": BADGE,
        "sections": [_told(section) for section in told.sections],
        "without": told.without,
        "unmeasured": told.unmeasured,
        "panels": [(title, drawing) for title, drawing in drawn if title in leading],
        "variants": [(title, drawing) for title, drawing in drawn if title not in leading],
    }


def _matrix(content: Content, target: float) -> list[tuple[Any, list[str]]]:
    """(engine, what it won, drew and lost against each) for every engine."""
    told = content.frontier
    pairs = told.duels[target]
    return [
        (content.engines[a], ["·" if a == b else duel_text(pairs[a, b]) for b in told.engines]) for a in told.engines
    ]


def _told(section: Section) -> dict[str, Any]:
    return {
        "scenario": section.scenario,
        "rows": section.rows,
        "absent": section.absent,
        "spoken": advice_text(section.advice),
    }
