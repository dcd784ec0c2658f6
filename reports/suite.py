"""The cells of a campaign that are verdicts of a suite, and not steps on the way to something else."""

from __future__ import annotations

from dataclasses import replace

from comparisons.cell import Campaign


def suite_of(campaign: Campaign) -> Campaign:
    """The campaign without steps on ladders and without points of a sweep at other than the default settings."""
    return without_ladders(without_sweep(campaign))


def without_sweep(campaign: Campaign) -> Campaign:
    """The campaign without cells that are only points of curves: what remains was run at the defaults."""
    if not campaign.sweep:
        return campaign
    settings = {name: dict(told.get("settings", {})) for name, told in campaign.engines.items()}
    return replace(campaign, cells=tuple(c for c in campaign.cells if dict(c.settings) == settings.get(c.engine)))


def without_ladders(campaign: Campaign) -> Campaign:
    """The campaign without the cells that were only steps on a ladder."""
    steps = {key for told in campaign.ladders.values() for tries in told["climbs"].values() for _, key in tries}
    return replace(campaign, cells=tuple(c for c in campaign.cells if c.key not in steps))
