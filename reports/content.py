"""What the sections of the page are made from, and engines as the page names them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

from comparisons.cell import Campaign
from reports.drawing import marker_shape
from reports.frontier import Accuracy
from reports.matrix import Matrix, matrix
from reports.motion import Shown
from reports.palette import base, profile, slug
from reports.suite import suite_of
from reports.verdict import engines


@dataclass(frozen=True)
class EngineView:
    """An engine as the page names it: marker, name and profile, always in its colour.

    `symbol` is the drawing of the marker, which stands once in the page, and `icon` a reference to it; `drawn` is the
    drawing itself, for the heads of tables: printed on every page, they lose what they only refer to.
    """

    name: str
    slug: str
    base: str
    profile: str
    icon: str
    symbol: str
    drawn: str
    version: str


@dataclass(frozen=True)
class Content:
    """What every section of a page is made from.

    Attributes
    ----------
    campaign : Campaign
    motion : Shown
        Of recorded motions.
    asked : mapping
        Scenario -> coefficient of restitution it declares.
    frontier : Accuracy
        What a sweep says of accuracy against time.
    """

    campaign: Campaign
    motion: Shown = field(default_factory=Shown)
    asked: Mapping[str, float] = field(default_factory=dict)
    frontier: Accuracy = field(default_factory=Accuracy)

    @cached_property
    def suite(self) -> Campaign:
        """The campaign without steps on ladders and points of a sweep."""
        return suite_of(self.campaign)

    @cached_property
    def matrix(self) -> Matrix:
        """The verdict matrix of the suite."""
        return matrix(self.suite)

    @cached_property
    def engines(self) -> dict[str, EngineView]:
        """Engine -> how the page names it, in the order of every table."""
        return {e: view_of(self.campaign, e) for e in engines(self.campaign)}


def view_of(campaign: Campaign, engine: str) -> EngineView:
    """How the page names an engine."""
    version = next((c.engine_version for c in campaign.cells if c.engine == engine and c.engine_version), "")
    version = version or str(campaign.engines.get(engine, {}).get("version", ""))
    shape = marker_shape(engine, 7.0, 7.0)
    symbol = f'<symbol id="i-{slug(engine)}" viewBox="0 0 14 14">{shape}</symbol>'
    drawn = f'<svg class="fig icon" viewBox="0 0 14 14" aria-hidden="true">{shape}</svg>'
    icon = f'<svg class="fig icon" aria-hidden="true"><use href="#i-{slug(engine)}"/></svg>'
    return EngineView(engine, slug(engine), base(engine), profile(engine), icon, symbol, drawn, version)
