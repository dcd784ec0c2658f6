"""How it was judged, with what tolerances, settings and versions, and on what machine."""

from __future__ import annotations

from collections.abc import Mapping
from hashlib import blake2b
from typing import Any

from comparisons.cell import Campaign, cell_to_json
from reports.content import Content, EngineView
from reports.numbers import duration_text, settings_text, unit_text, with_unit
from reports.verdict import description, scenarios


def shown(content: Content) -> Mapping[str, Any]:
    """What the section shows."""
    campaign = content.campaign
    return {
        "quantities": _quantities(campaign),
        "tolerances": _tolerances(campaign),
        "profiles": _profiles(campaign, content.engines),
        "facts": _facts(campaign),
        "run": campaign.command,
    }


def data_hash(campaign: Campaign) -> str:
    """Hash of all cells, in any order: equal hashes mean equal data."""
    lines = sorted(cell_to_json(c) for c in campaign.cells)
    return blake2b("\n".join(lines).encode("utf-8", "replace"), digest_size=16).hexdigest()


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
