"""Only the effects a scene calls for: proofs in words, and what leaving the others out saves, for page and terminal."""

from __future__ import annotations

import math
import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from comparisons.effects import ALL, SLOW, SWITCHES, VERDICTS, Proof, Row, from_plain
from mechanics.effects import EFFECTS
from reports.content import Content, view_of
from reports.numbers import short

ACTS = ("changes", "missing", "demanded", "refused")  # what shows that a declared effect is needed


def finding(row: Row) -> str:
    """What was found of one effect, in a sentence."""
    what = "left out" if row.declared else "switched on"
    if row.verdict in ("same", "same until"):
        until = f", until t = {row.time:.4g} s" if row.verdict == "same until" else ""
        size = "to the last bit" if row.difference == 0.0 else f"to {row.difference:.1g} of the motion"
        text = f"{what}, the motion is the same {size}{until}"
        return f"{text} ({row.text})" if row.text else text + _saved(row)
    if row.verdict == "changes":
        return f"{what}, the motion is another one from t = {row.time:.4g} s on"
    if row.verdict == "differs":
        return f"{what}, the motion differs by {row.difference:.1g} of itself from t = {row.time:.4g} s on"
    return f"{what}: {VERDICTS[row.verdict]}: {row.text}"


def _saved(row: Row) -> str:
    if math.isnan(row.ratio):
        return ""
    return (
        f"; with it a run takes {row.ratio:.2f} times as long ({row.rounds} {'rounds' if row.rounds > 1 else 'round'})"
    )


def factor(row: Row) -> str:
    """CPU time with the effect over that without, or why there is none, in a word."""
    if not math.isnan(row.ratio):
        return f"{row.ratio:.2f}"
    if row.verdict == "same until" and "times slower" in row.text:
        return f"> {SLOW:g}"
    return {"changes": "acts", "missing": "acts", "demanded": "acts", "same": "same", "same until": "same"}.get(
        row.verdict, row.verdict
    )


@dataclass(frozen=True)
class Saving:
    """What an effect costs that does nothing, over all scenes in which the motion stayed the same.

    Attributes
    ----------
    scenes : int
        Scenes in which it was switched on.
    same : int
        Scenes in which the motion was the same then.
    worst : float
        Largest difference of these.
    ratios : tuple of float
        CPU time with it over CPU time without.
    """

    scenes: int
    same: int
    worst: float
    ratios: tuple[float, ...]

    @staticmethod
    def of(rows: Sequence[Row]) -> Saving:
        """The saving that rows of one effect tell."""
        same = [row for row in rows if row.verdict in ("same", "same until")]
        worst = max((row.difference for row in same), default=math.nan)
        ratios = sorted(row.ratio for row in same if not math.isnan(row.ratio))
        return Saving(len(rows), len(same), worst, tuple(ratios))

    @property
    def middle(self) -> float:
        """Geometric mean of the ratios; NaN without any."""
        return statistics.geometric_mean(self.ratios) if self.ratios else math.nan

    @property
    def text(self) -> str:
        """Geometric mean and range, as in "1.12 (0.98 to 3.4)"."""
        if not self.ratios:
            return "–"
        return f"{self.middle:.2f} ({self.ratios[0]:.2g} to {self.ratios[-1]:.2g})"


@dataclass(frozen=True)
class Line:
    """One scenario in one engine, as a row of the table."""

    scenario: str
    until: str
    declared: tuple[tuple[str, str, str], ...]  # effect, finding, why it is declared if leaving it out changes nothing
    idle: tuple[tuple[str, str, bool], ...]  # effect, finding, whether switching it on changes something
    together: str
    ratio: str


@dataclass(frozen=True)
class Ledger:
    """Everything that was found with one engine."""

    engine: str
    proofs: tuple[Proof, ...]
    because: Mapping[str, Mapping[str, str]]  # scenario -> effect -> why it is declared though it may do nothing

    @cached_property
    def savings(self) -> dict[str, Saving]:
        """Effect, or all of them at once -> what it costs where it is not declared."""
        rows = [row for proof in self.proofs for row in proof.rows if not row.declared]
        found = {name: Saving.of([row for row in rows if row.effect == name]) for name in (*EFFECTS, ALL, SWITCHES)}
        return {name: saving for name, saving in found.items() if saving.scenes or name != SWITCHES}

    @cached_property
    def lines(self) -> tuple[Line, ...]:
        """One line for each scenario that ran."""
        return tuple(_line(proof, self.because.get(proof.scenario, {})) for proof in self.proofs if proof.rows)

    @property
    def refused(self) -> tuple[tuple[str, str], ...]:
        """Scenarios that did not run, and why."""
        return tuple((proof.scenario, proof.reason) for proof in self.proofs if proof.reason)

    def count(self, declared: bool, *verdicts: str) -> int:
        """Effects of single scenes, declared or not, with one of these verdicts."""
        return sum(
            row.declared == declared and row.verdict in verdicts and row.effect in EFFECTS
            for proof in self.proofs
            for row in proof.rows
        )

    @property
    def sentence(self) -> str:
        """What the numbers come to."""
        same, idle = self.count(False, "same", "same until"), self.count(False, *VERDICTS)
        acts, all_of = self.count(True, *ACTS), self.count(True, *VERDICTS)
        whole = sum(proof.whole for proof in self.proofs if proof.rows)
        told = sum(bool(reason) for line in self.lines for *_, reason in line.declared)
        return (
            f"{len(self.lines)} scenes, {whole} of them to their end: of {idle} effects that are not declared {same} "
            f"change nothing when they are switched on; of {all_of} that are declared {acts} change the motion, or are "
            f"missed by name, when they are left out"
            + (f", and {told} are declared for a reason that is given." if told else ".")
        )


def ledgers(effects: Mapping[str, Any]) -> tuple[Ledger, ...]:
    """What a campaign knows of effects, engine by engine; what another version wrote is left out."""
    found = []
    for engine, told in effects.items():
        proofs = [_read(one) for one in told.values()]
        because = {name: one.get("because", {}) for name, one in told.items()}
        found.append(Ledger(engine, tuple(proof for proof in proofs if proof is not None), because))
    return tuple(found)


def _read(told: Mapping[str, Any]) -> Proof | None:
    try:
        return from_plain({name: value for name, value in told.items() if name not in ("scene", "because")})
    except (TypeError, KeyError):
        return None


def _line(proof: Proof, because: Mapping[str, str]) -> Line:
    declared = tuple(
        (r.effect, finding(r), "" if r.verdict in ACTS else because.get(r.effect, "")) for r in proof.rows if r.declared
    )
    idle = tuple(
        (r.effect, finding(r), r.verdict not in ("same", "same until"))
        for r in proof.rows
        if not r.declared and r.effect in EFFECTS
    )
    last = next(row for row in proof.rows if row.effect == ALL)
    until = "to the end" if proof.whole else f"until {short(proof.until)} of {short(proof.duration)} s"
    return Line(proof.scenario, until, declared, idle, finding(last), factor(last))


def shown(content: Content) -> Mapping[str, Any]:
    """What the section of the page shows."""
    found = ledgers(content.campaign.effects)
    if not found:
        return {}
    views = [content.engines.get(ledger.engine) or view_of(content.campaign, ledger.engine) for ledger in found]
    names = [name for name in (*EFFECTS, ALL, SWITCHES) if any(name in ledger.savings for ledger in found)]
    return {"ledgers": list(zip(found, views, strict=True)), "names": names}
