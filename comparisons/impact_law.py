"""Which impact law an engine realised, where mechanics leaves the answer to it.

Several impacts at once have more than one defensible outcome.  A scenario lists them as final
velocities by law; the run's law is the one whose velocities lie nearest, in the largest component of
any body, if that is within 5 % of the largest speed any law gives.  It is named, not marked.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from comparisons.measurement import Case, Quantity

QUANTITIES = {
    "impact law": ("", "the admissible impact law whose final velocities the run has, to 5 %"),
    "distance from impact law": ("1", "largest difference of final velocities from that law, over the largest speed"),
}

SAME = 0.05  # of the largest speed: laws differ by more, and stepping errors are far below


def measure(case: Case) -> Iterator[Quantity]:
    """Name of the nearest law, and how far off it is; nothing where the scenario leaves nothing open."""
    laws = {name: np.array(velocities) for name, velocities in case.scenario.laws.items()}
    if not laws:
        return
    final, at = case.trajectory.v[-1], float(case.trajectory.t[-1])
    scale = max(float(np.linalg.norm(v, axis=1).max()) for v in laws.values()) or 1.0
    off = {name: float(np.abs(final - v).max()) / scale for name, v in laws.items()}
    nearest = min(off, key=lambda name: off[name])
    word = nearest if off[nearest] <= SAME else f"unknown (nearest {nearest}, off by {off[nearest]:.0%})"
    yield Quantity("impact law", np.nan, "", at, word)
    yield Quantity("distance from impact law", off[nearest], "1", at)
