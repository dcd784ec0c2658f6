"""Only the effects a scene calls for: what it calls for, what was found, and what it saves."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import click

from adapters import registry
from comparisons.calls import Call, calls
from comparisons.effects import ALL, SWITCHES, Proof, from_plain, prove, to_plain
from mechanics.effects import EFFECTS
from plumbline.fingerprint import fingerprint
from plumbline.listing import table
from plumbline.run_folder import RunFolder, read_manifest
from reports.effects import factor, finding
from scenarios.scenario import Scenario

KEEP = 5.0  # between two writings of what is finished [s]


@dataclass(frozen=True)
class Found:
    """One scenario: what its scene calls for, and the proofs of the engines."""

    scenario: Scenario
    calls: tuple[Call, ...]
    proofs: tuple[Proof, ...]


class Store:
    """Proofs in `run.json` of a folder, which may be that of a run; without a folder they are only held.

    Raises
    ------
    FolderError
        If the folder cannot be read or written.
    """

    def __init__(self, folder: str | Path | None, title: str, command: str) -> None:
        self.folder = Path(folder) if folder else None
        self._written, self._manifest = 0.0, _blank(self.folder, title, command)
        if self.folder is not None and (self.folder / "run.json").exists():
            self._manifest = read_manifest(self.folder)
        self._effects = self._manifest.setdefault("effects", {})

    def get(self, engine: str, version: str, scenario: Scenario) -> Proof | None:
        """What is there of a scenario in an engine, if it is of this version of both."""
        told = self._effects.get(engine, {}).get(scenario.name)
        if told is None or told["scene"] != scenario.version:
            return None
        with suppress(TypeError, KeyError):  # written by another version of this package: to be found out again
            proof = from_plain({name: value for name, value in told.items() if name not in ("scene", "because")})
            return proof if proof.version == version else None
        return None

    def put(self, proof: Proof, scenario: Scenario) -> None:
        """Keep a proof; on disk at the latest when the store is closed."""
        because = {kind.__name__: why for kind, why in scenario.because.items() if kind in scenario.scene.needs}
        more = {"scene": scenario.version, "because": because}
        self._effects.setdefault(proof.engine, {})[proof.scenario] = to_plain(proof) | more
        if time.monotonic() > self._written + KEEP:
            self.close()

    def close(self) -> None:
        """Write what is there."""
        if self.folder is not None:
            with RunFolder(self.folder) as folder:
                folder.describe({name: value for name, value in self._manifest.items() if name != "schema"})
            self._written = time.monotonic()


def _blank(folder: Path | None, title: str, command: str) -> dict[str, Any]:
    """Manifest of a run of nothing but effects."""
    return {
        "id": folder.resolve().name if folder else "",
        "title": title,
        "command": command,
        "started": f"{datetime.now(UTC):%Y-%m-%dT%H:%M:%SZ}",
        "wall_seconds": 0.0,
        "stopped": "",
        "fingerprint": fingerprint(),
        "scenarios": {},
        "engines": {},
        "plan": [],
    }


def find_out(
    scenarios: Sequence[Scenario], engines: Sequence[str], budget: float, clock: float, store: Store
) -> Iterator[Found]:
    """What each scenario calls for and what its effects do in each engine, one scenario after the other."""
    try:
        for scenario in scenarios:
            proofs = []
            for name in engines:
                engine = registry.engine(name)
                proof = store.get(name, str(engine.version), scenario)
                if proof is None:
                    proof = prove(engine, scenario, budget, clock)
                    store.put(proof, scenario)
                proofs.append(proof)
            yield Found(scenario, calls(scenario.scene, scenario.duration), tuple(proofs))
    finally:
        store.close()


def show(found: Found) -> None:
    """Print one scenario: each effect in a sentence with what the first engine showed, then what each engine saves."""
    click.echo(f"{found.scenario.name}: {found.scenario.duration:g} s")
    first = found.proofs[0]
    rows = {row.effect: row for row in first.rows}
    for call in found.calls:
        click.echo(f"\n  {call.effect}: {call.sentence}: {call.why}")
        if call.effect in rows:
            click.echo(f"    {first.engine}: {finding(rows[call.effect])}")
        if remark := remark_of(found.scenario, call.effect):
            click.echo(f"    said by the scenario: {remark}")
    click.echo()
    if ALL in rows:
        click.echo(f"  {ALL} at once: {finding(rows[ALL])}\n")
    click.echo("  CPU time with an effect over CPU time without it, where the motion is the same")
    names = [call.effect for call in found.calls]
    columns = (*names, ALL, SWITCHES)
    table([("engine", *columns), *(_line(proof, columns) for proof in found.proofs)], "  ")
    for proof in found.proofs:
        if proof.reason:
            click.echo(f"  {proof.engine}: {proof.reason}")
        elif not proof.whole:
            click.echo(f"  {proof.engine}: compared until t = {proof.until:.4g} s: there the budget was spent")


def _line(proof: Proof, names: Sequence[str]) -> tuple[str, ...]:
    rows = {row.effect: row for row in proof.rows}
    return (proof.engine, *(factor(rows[name]) if name in rows else "–" for name in names))


def remark_of(scenario: Scenario, effect: str) -> str:
    """Why a scenario declares an effect that may do nothing in it; "" where it does not declare it, or says nothing."""
    kind = EFFECTS[effect]
    return scenario.because.get(kind, "") if kind in scenario.scene.needs else ""


def as_json(found: Found) -> dict[str, Any]:
    """One scenario for programs."""
    return {
        "scenario": found.scenario.name,
        "calls": [call._asdict() | {"sentence": call.sentence} for call in found.calls],
        "because": {kind.__name__: why for kind, why in found.scenario.because.items()},
        "proofs": [to_plain(proof) for proof in found.proofs],
    }
