"""The verb `ablate`: which setting makes the difference between an engine's stock and fair profiles."""

from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING, Any

import click

from plumbline.cli_sweep import PHASES, one, progress_option
from plumbline.command import as_json, execute, usage

if TYPE_CHECKING:
    from comparisons.ablation import Part
    from comparisons.cell import Campaign

SOURCE = "ablation"


@click.command("ablate")
@click.argument("scene", metavar="SCENARIO")
@click.option("-e", "--engine", "library", required=True, metavar="NAME",
              help="Engine whose stock profile is led to its fair one: mujoco, pybullet or pymunk.")  # fmt: skip
@click.option("--phases", type=click.IntRange(1), default=PHASES, show_default=True,
              help="Phases of a step at which impacts are tried; the worst counts.")  # fmt: skip
@click.option("--out", metavar="DIR", help="Folder of the run.  [default: in runs/]")
@progress_option
@as_json
def ablate(scene: str, library: str, **asked: Any) -> int:
    """Bring the settings of an engine's fair profile into its stock profile one at a time, and take them out again.

    For each the share of the distance between the two errors that it explains: alone, and last.

    \b
    plumbline ablate 'bouncing-ball[e=0.5]' -e pybullet
    """  # fmt: skip
    with usage():
        from adapters.ablation import LIBRARIES, settings
        from scenarios.catalogue import unknown

        if library not in LIBRARIES:
            raise unknown("engine with a stock and a fair profile", library, tuple(LIBRARIES))
        campaign = _measured(scene, library, asked)
        reasons = settings(library)
        parts = _parts(campaign, library, reasons)
    if asked["json_"]:
        rows = [{k: v if isinstance(v, str) or math.isfinite(v) else None for k, v in vars(p).items()} for p in parts]
        click.echo(json.dumps(rows, indent=1))
    else:
        _show(parts, campaign, library, reasons)
    return 0


def _measured(scene: str, library: str, asked: dict[str, Any]) -> Campaign:
    """Both profiles and everything between them on one scenario."""
    from adapters import registry
    from adapters.ablation import settings
    from plumbline.campaign import Options
    from plumbline.plan import choose, plan

    (scenario,) = choose(None, (one(scene)[0],))
    between = [f"{library}:{kind}{name}" for name in settings(library) for kind in ("stock+", "fair-")]
    registry.register(SOURCE, "adapters.ablation:ENGINES")
    try:
        jobs = plan((scenario,), (library, f"{library}:stock", *between))
        options = Options(jobs=2, phases=asked["phases"], card=False)
        return execute(jobs, f"Ablation of {library} on {scenario.name}", options, asked).campaign
    finally:
        registry.unregister(SOURCE)


def _parts(campaign: Campaign, library: str, names: Any) -> tuple[Part, ...]:
    from comparisons.ablation import explained

    errors = _errors(campaign)
    return explained(
        errors[f"{library}:stock"],
        errors[library],
        {name: errors[f"{library}:stock+{name}"] for name in names},
        {name: errors[f"{library}:fair-{name}"] for name in names},
    )


def _errors(campaign: Campaign) -> dict[str, float]:
    from comparisons.frontier import Point

    return {cell.engine: Point.of(cell).error for cell in campaign.cells}


def _show(parts: tuple[Part, ...], campaign: Campaign, library: str, reasons: dict[str, str]) -> None:
    from plumbline.listing import table
    from reports.numbers import short

    errors = _errors(campaign)
    click.echo(f"{campaign.title}: relative place error {short(errors[f'{library}:stock'])} stock, "
               f"{short(errors[library])} fair")  # fmt: skip
    rows = [("setting", "stock with it", "explains alone", "fair without it", "explains last", "why")]
    for p in parts:
        shares = ["–" if math.isnan(s) else f"{round(100 * s)} %" for s in (p.alone, p.last)]
        rows.append((p.setting, short(p.error_with), shares[0], short(p.error_without), shares[1], reasons[p.setting]))
    table(rows)
