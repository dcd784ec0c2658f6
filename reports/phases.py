"""What the phase of a step does to an impact: least, median and largest of a quantity, engine by engine."""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence
from dataclasses import dataclass

from comparisons.cell import Campaign, Cell
from reports.numbers import short, unit_text
from reports.verdict import chosen, engines, scenarios

TOLD = ("restitution", "energy kept")  # besides what is demanded


@dataclass(frozen=True)
class Spread:
    """A quantity over the phases of a step.

    Attributes
    ----------
    least, median, most : float
    missing : int
        Phases at which it could not be measured.
    """

    least: float
    median: float
    most: float
    missing: int

    @staticmethod
    def of(values: Sequence[float]) -> Spread | None:
        """None where nothing was measured."""
        known = [v for v in values if not math.isnan(v)]
        if not known:
            return None
        return Spread(min(known), statistics.median(known), max(known), len(values) - len(known))

    @property
    def text(self) -> str:
        """ "0.07 · 0.5 · 0.8", or one number where all are the same in three digits."""
        parts = [short(v) for v in (self.least, self.median, self.most)]
        same = parts[0] if len(set(parts)) == 1 else " · ".join(parts)
        return f"{same} ({self.missing} not measured)" if self.missing else same


@dataclass(frozen=True)
class Line:
    """One quantity of one scenario over all engines; None where an engine was not tried at several phases."""

    scenario: str
    quantity: str
    spreads: tuple[Spread | None, ...]


def lines(campaign: Campaign) -> tuple[Line, ...]:
    """Lines of every scenario that was run at several phases, for its deciding quantity and for restitution."""
    table, order = chosen(campaign), engines(campaign)
    found = []
    for scenario in scenarios(campaign):
        cells = [table.get((scenario, e)) for e in order]
        own = [c for c in cells if c is not None and c.phases]
        for name in _quantities(own):
            spreads = tuple(Spread.of(c.phases.get(name, ())) if c else None for c in cells)
            unit = unit_text(next((m.unit for c in own for m in c.measurements if m.quantity == name), ""))
            found.append(Line(scenario, f"{name} [{unit}]" if unit else name, spreads))
    return tuple(found)


def _quantities(cells: Sequence[Cell]) -> list[str]:
    """Those that are always told, then those that decide somewhere."""
    measured = {name for c in cells for name in c.phases}
    deciding = dict.fromkeys(c.worst.quantity for c in cells if c.worst)
    return [name for name in dict.fromkeys((*TOLD, *deciding)) if name in measured]
