"""The read-back card: what an engine really applied, told from motion alone.

Small scenes (`comparisons.flight_probes`, `comparisons.contact_probes`) with one effect to be read each
are run with the settings of the run they belong to.  What was asked and what was got stand side by side.
Where the two differ, the quantities that depend on it compare two different questions, and the cells of
that engine say so; their rows stay.
"""

from __future__ import annotations

from collections.abc import Iterable

from adapters.engine import Refusal
from adapters.run import Failure
from comparisons import contact_probes, flight_probes
from comparisons.probe import Ask
from comparisons.reading import Reading

PROBES = (*flight_probes.PROBES, *contact_probes.PROBES)


def read_back(ask: Ask, needs: Iterable[str] | None = None, step: float = 1e-3) -> tuple[Reading, ...]:
    """The card of an engine.

    Parameters
    ----------
    ask : function (scene, times) -> Run
        Runs a scene in the engine.
    needs : names of effects, optional
        Read only what scenes with these effects depend on; without it everything.
    step : float
        Time step of the engine [s], over the phases of which impacts are spread.
    """
    known = None if needs is None else set(needs)
    readings: list[Reading] = []
    broken = ""
    for probe in PROBES:
        if known is not None and not set(probe.effects) <= known:
            continue
        if broken:
            readings += probe.blank(said=broken)
            continue
        scene = probe.scene(step)
        run = ask(scene, probe.times(step))
        if isinstance(run.outcome, Refusal) and probe.instead is not None:
            readings += probe.instead(ask, run.outcome.reason)
        elif isinstance(run.outcome, Refusal):
            readings += probe.blank(refused=True, said=run.outcome.reason)
        elif isinstance(run.outcome, Failure):
            readings += probe.blank(said=f"{run.outcome.state} in {run.outcome.stage}: {run.outcome.reason}")
            # a process that had to be killed costs its deadline: no second one is risked
            broken = readings[-1].said if run.outcome.state in ("crash", "timeout", "oom") else ""
        else:
            readings += probe.read(scene, run.outcome)
    return tuple(readings)
