"""The doctor: versions, missing engines, and how far this machine's timings can be trusted right now."""

from __future__ import annotations

import json
import math
import os
from typing import Any

import click

from adapters import registry
from plumbline.fingerprint import fingerprint
from plumbline.listing import table
from plumbline.noise import MORE, Noise, measured

TRIAL = 3.0  # [s]
SHOWN = (0.02, 0.05)  # of the gates


def show(json_: bool, seconds: float | None = None) -> None:
    """Print the examination; timings are tried for `seconds`, `TRIAL` unless another time is given."""
    facts, engines, noise = fingerprint(), registry.listings(), measured(seconds or TRIAL)
    load = os.getloadavg() if hasattr(os, "getloadavg") else ()
    if json_:
        rows = [{"name": e.name, "version": e.version, "state": e.state, "install": e.install} for e in engines]
        told: dict[str, Any] = {"fingerprint": facts, "engines": rows, "noise": noise.told(), "load": list(load)}
        click.echo(json.dumps(told | {"verdict": noise.verdict()}, indent=1))
        return
    packages = facts.pop("packages")
    assert isinstance(packages, dict)
    table([*((name, str(value)) for name, value in facts.items()), *packages.items()])
    click.echo("\nengines")
    table([(e.name, e.version or e.state, e.install or e.reason) for e in engines], "  ")
    click.echo(f"\ntimings: the same work twice and {MORE:.0%} more work, repeated in turns, {noise.trials} times")
    table(rates(noise), "  ")
    if load:
        click.echo(f"  load {load[0]:.1f} on {facts['processors']} processors, contention {noise.contention:.0%}")
    click.echo(f"  {noise.verdict()}")


def rates(noise: Noise) -> list[tuple[str, ...]]:
    """By statistic: the gate, how often identical work would raise an alarm, and how often more work would be seen."""
    alarms, seen = ([f"{what} at {100.0 * g:g} %" for g in SHOWN] for what in ("alarms", f"+{MORE:.0%} seen"))
    lines = [("", "gate", *alarms, *seen)]
    for name in noise.same:
        gate = noise.gate(name)
        shares = (f"{rate(name, g):.0%}" for rate in (noise.alarms, noise.seen) for g in SHOWN)
        lines.append((name, f"{100.0 * gate:g} %" if math.isfinite(gate) else "none", *shares))
    return lines
