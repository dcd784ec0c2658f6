"""The report page: one self-contained file that opens offline and asks nobody for anything."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from hashlib import sha256

from comparisons.cell import Campaign
from reports.content import Content
from reports.drawing import asset
from reports.frontier import accuracy
from reports.motion import Shown
from reports.palette import css
from reports.sections import environment, rendered
from reports.suite import without_sweep

PLAYER = ("inks", "blocks", "meshes", "camera", "webgl", "canvas", "plots", "stage", "player")
SCRIPTS = ("page.js", *(f"player/{name}.js" for name in PLAYER))
STYLES = ("figure.css", "page.css", "player.css")


def page(
    campaign: Campaign,
    motion: Shown | None = None,
    asked: Mapping[str, float] | None = None,
) -> str:
    """The report of a campaign as one HTML document.

    Parameters
    ----------
    motion : Shown, optional
        What to show of recorded motions, as made by `reports.motion.motion`.
    asked : mapping, optional
        Scenario -> coefficient of restitution it declares.
    """
    content = Content(without_sweep(campaign), motion or Shown(), asked or {}, accuracy(campaign))
    script = "".join(map(asset, SCRIPTS))
    return (
        environment()
        .get_template("page.html")
        .render(
            title=campaign.title or campaign.id,
            policy=policy(script),
            script=script,
            style=css(tuple(content.engines)) + "".join(map(asset, STYLES)),
            width=300 + 132 * len(content.engines),  # below this [px] the matrix scrolls in a box of its own
            engines=content.engines.values(),
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
