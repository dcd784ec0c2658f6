"""The report page: one self-contained file that opens offline and asks nobody for anything."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from hashlib import sha256

from comparisons.cell import Campaign
from reports.content import Content
from reports.drawing import asset
from reports.palette import css
from reports.sections import environment, rendered
from reports.series import Curves


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
    content = Content(campaign, curves, undrawn, asked or {})
    script = asset("page.js")
    return (
        environment()
        .get_template("page.html")
        .render(
            title=campaign.title or campaign.id,
            policy=policy(script),
            script=script,
            style=css(tuple(content.engines)) + asset("figure.css") + asset("page.css"),
            width=300 + 132 * len(content.engines),  # below this [px] the matrix scrolls in a box of its own
            sections=rendered(content),
        )
    )


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
