"""The doctor: versions, missing engines, and how far this machine's timings can be trusted right now."""

from __future__ import annotations

import json
import os
import time
from typing import Any

import click
import numpy as np

from adapters import registry
from adapters.run import Timing
from plumbline.fingerprint import fingerprint
from plumbline.listing import table

REPEATS, INTERVALS = 10, 200
GATE = 0.05  # relative difference of two timings of the same work that would be taken for a real one


def chunk(state: np.ndarray) -> np.ndarray:
    """A piece of work of about 0.1 ms that is the same every time, like one interval of an engine."""
    for _ in range(12):
        state = state @ state
        state = state / np.abs(state).max()
    return state


def sitting() -> tuple[Timing, Timing]:
    """Two timings, A and B, of identical work, repeats interleaved A B B A."""
    seed = np.random.default_rng(1).normal(size=(24, 24))
    wall: dict[str, list[list[int]]] = {"A": [], "B": []}
    cpu: dict[str, list[int]] = {"A": [], "B": []}
    for round_ in range(REPEATS):
        for name in ("AB", "BA")[round_ % 2]:
            state, row = seed, []
            before = time.thread_time_ns()
            for _ in range(INTERVALS):
                start = time.perf_counter_ns()
                state = chunk(state)
                row.append(time.perf_counter_ns() - start)
            wall[name].append(row)
            cpu[name].append(time.thread_time_ns() - before)
    same = ("same",) * REPEATS
    return tuple(Timing(np.array(wall[n]), np.array(cpu[n]), same) for n in "AB")  # type: ignore[return-value]


def noise() -> dict[str, float]:
    """Relative difference of two timings of identical work, by statistic, and the contention meanwhile."""
    a, b = sitting()
    return {
        "envelope": abs(b.seconds / a.seconds - 1.0),
        "fastest repeat": abs(float(b.wall.sum(axis=1).min() / a.wall.sum(axis=1).min()) - 1.0),
        "mean": abs(float(b.wall.mean() / a.wall.mean()) - 1.0),
        "contention": max(a.contention, b.contention),
    }


def verdict(measured: dict[str, float]) -> str:
    """What the self-test says, in a sentence."""
    if measured["envelope"] > GATE:
        return f"do not trust timings now: identical work differs by {measured['envelope']:.0%} even by the envelope"
    if measured["contention"] > 0.25:
        return f"busy machine (contention {measured['contention']:.0%}): trust the envelope (--repeats 5), nothing else"
    return "timings by the envelope can be trusted (--repeats 5 or more)"


def show(json_: bool) -> None:
    """Print the examination."""
    facts, engines, measured = fingerprint(), registry.listings(), noise()
    load = os.getloadavg() if hasattr(os, "getloadavg") else ()
    if json_:
        rows = [{"name": e.name, "version": e.version, "state": e.state, "install": e.install} for e in engines]
        told: dict[str, Any] = {"fingerprint": facts, "engines": rows, "noise": measured, "load": list(load)}
        click.echo(json.dumps(told | {"verdict": verdict(measured)}, indent=1))
        return
    packages = facts.pop("packages")
    assert isinstance(packages, dict)
    table([*((name, str(value)) for name, value in facts.items()), *packages.items()])
    click.echo("\nengines")
    table([(e.name, e.version or e.state, e.install or e.reason) for e in engines], "  ")
    click.echo(f"\ntimings: two measurements of identical work, {REPEATS} repeats each, interleaved")
    table([(name, f"{value:.2%}") for name, value in measured.items()], "  ")
    if load:
        click.echo(f"  load {load[0]:.1f} on {facts['processors']} processors")
    click.echo(f"  {verdict(measured)}")
