"""One verdict over several phases of a step: a single impact is a lottery ticket.

The same scenario is begun later by fractions of a step (`scenarios.phase`), so that its impacts fall at
different phases of the engine's steps.  What is demanded is judged where it is worst, because nobody
chooses the phase; what is only told is told of the first phase; least, median and largest of every
quantity are kept beside.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from comparisons.judge import Judgement, verdict
from comparisons.measurement import Measurement


def over_phases(judgements: Sequence[Judgement]) -> tuple[Judgement, dict[str, tuple[float, ...]]]:
    """The judgement of all phases together, and every number by quantity, phase after phase.

    A phase that broke or was refused decides the state; NaN stands where a quantity was not measured.
    """
    values = {row.quantity: tuple(_value(j, row.quantity) for j in judgements) for row in judgements[0].measurements}
    told = {name: series for name, series in values.items() if any(math.isfinite(v) for v in series)}
    for k, judgement in enumerate(judgements):
        if judgement.state not in ("ok", "fail"):
            reason = f"{judgement.reason} (phase {k}/{len(judgements)} of a step)" if k else judgement.reason
            return replace(judgement, reason=reason), told
    rows = tuple(_worst(row, judgements) for row in judgements[0].measurements)
    return Judgement(rows, *verdict(rows)), told


def _value(judgement: Judgement, quantity: str) -> float:
    return next((m.value for m in judgement.measurements if m.quantity == quantity), math.nan)


def _worst(first: Measurement, judgements: Sequence[Judgement]) -> Measurement:
    """The measurement of the phase in which a demanded quantity is largest; that of the first where nothing is."""
    if math.isnan(first.tolerance):
        return first
    rows = [(m, k) for k, j in enumerate(judgements) for m in j.measurements if m.quantity == first.quantity]
    worst, k = max(rows, key=lambda row: math.inf if math.isnan(row[0].value) else row[0].value)
    text = f"worst of {len(judgements)} phases of a step, at {k}/{len(judgements)}"
    return replace(worst, text="; ".join(filter(None, (worst.text, text))))
