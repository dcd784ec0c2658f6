"""Accuracy against time in words: time to reach an error, orders and alarms, shares, duels and advice.

Every format of the report takes its rows from here.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from comparisons.advice import Advice, advise
from comparisons.cell import Campaign
from comparisons.frontier import TARGETS, WHOLE, Frontier, Point, frontiers
from comparisons.order import ROUNDING, Alarm
from comparisons.pareto import Reach
from comparisons.wins import Duel, Share, duel, share
from reports.numbers import power_of_ten, rounded, settings_text, short
from reports.verdict import WORDS, engine_order, mark, scenarios

BUDGETS = (1.0, 10.0, 100.0, 1000.0)  # CPU ms per simulated second; the last is real time
ADVISED = 1e-3  # the relative error for which every report gives advice
DISTURBED = 0.25  # contention above which a timing is badged
BADGE = "†"
COUNTS = ("iterations", "substeps", "sides")  # knobs that get finer as they grow
NO_STEP = "no time step"


@dataclass(frozen=True)
class Entry:
    """What it takes one engine to come down to one target: a glyph and words, never one without the other."""

    glyph: str
    text: str
    tone: str  # of `reports.palette.TONES`
    setting: str = ""  # at which it was measured


@dataclass(frozen=True)
class Row:
    """One engine on one scenario."""

    engine: str
    entries: tuple[Entry, ...]
    order: str
    alarm: str
    failures: str


@dataclass(frozen=True)
class Section:
    """One scenario: a row for each engine that answered, word and reason of each that did not, and advice."""

    scenario: str
    found: tuple[Frontier, ...]
    rows: tuple[Row, ...]
    absent: tuple[tuple[str, str], ...]
    advice: Advice


@dataclass(frozen=True)
class Accuracy:
    """What a campaign says of accuracy against time; without sections if it swept nothing.

    Attributes
    ----------
    sections : tuple of Section
    engines : tuple of str
        In the order of every table.
    shares : tuple of Share
        One for each engine.
    duels : mapping
        Target -> (first, second) -> Duel.
    without : tuple of str
        Scenarios that were swept and do not ask where bodies are.
    unmeasured : tuple of str
        Scenarios of which no run came to its end.
    """

    sections: tuple[Section, ...] = ()
    engines: tuple[str, ...] = ()
    shares: tuple[Share, ...] = ()
    duels: Mapping[float, Mapping[tuple[str, str], Duel]] = field(default_factory=dict)
    without: tuple[str, ...] = ()
    unmeasured: tuple[str, ...] = ()


def accuracy(campaign: Campaign) -> Accuracy:
    """Accuracy against time of a campaign that swept knobs."""
    if not campaign.sweep:
        return Accuracy()
    found = frontiers(campaign)
    engines = tuple(engine_order(f.engine for f in found))
    asked = list(dict.fromkeys(f.scenario for f in found))
    rest = [name for name in scenarios(campaign) if name not in asked]
    answered = {c.scenario for c in campaign.cells if c.state in WHOLE}
    duels = {
        target: {(a, b): duel(found, a, b, target) for a in engines for b in engines if a != b} for target in TARGETS
    }
    return Accuracy(
        sections=tuple(_section(name, [f for f in found if f.scenario == name]) for name in asked),
        engines=engines,
        shares=tuple(share(found, engine) for engine in engines),
        duels=duels,
        without=tuple(name for name in rest if name in answered),
        unmeasured=tuple(name for name in rest if name not in answered),
    )


def _section(scenario: str, found: Sequence[Frontier]) -> Section:
    by_engine = {f.engine: f for f in found}
    ordered = tuple(by_engine[e] for e in engine_order(by_engine))
    return Section(
        scenario,
        ordered,
        tuple(_row(f) for f in ordered if f.answered),
        tuple((f.engine, absent_text(*f.absent)) for f in ordered if not f.answered),
        advise(found, scenario, ADVISED),
    )


def _row(found: Frontier) -> Row:
    entries = tuple(entry(found, target) for target in TARGETS)
    return Row(found.engine, entries, order_text(found), alarm_text(found), failures_text(found))


def entry(found: Frontier, target: float) -> Entry:
    """What it takes to come down to a target."""
    reached, point = found.reach(target)
    if point is None:
        best = found.best
        words = f"not reached (best {short(best.error, 2)})" if best else "not reached (no run came to its end)"
        return Entry("✕", words, "fail")
    text = cost_text(reached) + (f" {BADGE}" if disturbed(point) else "")
    return Entry("✓", text, "pass", told_settings(point.cell.settings))


def cost_text(reached: Reach) -> str:
    """ "≤ 0.82 ms/s" where the cheapest setting is within the target already, else "4.1 ms/s"."""
    return f"{'≤ ' if reached.how == 'below' else ''}{short(reached.cost, 2)} ms/s"


def disturbed(point: Point) -> bool:
    """Whether the machine disturbed the measurement of cost by more than a quarter."""
    return point.cell.contention > DISTURBED


def order_text(found: Frontier) -> str:
    """The observed order of the main ladder and where it was seen, where there is one."""
    order = found.main.order
    if order is None:
        return NO_STEP
    if math.isnan(order.slope):
        exact = bool(found.main.whole) and max(p.error for p in found.main.whole) <= ROUNDING
        return "exact to rounding" if exact else "none: the error does not fall steadily"
    text = f"{order.slope:.2f} ({step_text(order.first)} to {step_text(order.last)})"
    return text if math.isnan(order.stalls) else f"{text}, stalls at {short(order.stalls, 2)}"


def told_settings(settings: Mapping[str, float | str]) -> str:
    """Settings on one line, the time step as a fraction of a second where it is one."""
    told = {name: step_text(float(value)) if name == "dt" else value for name, value in settings.items()}
    return settings_text(told)


def step_text(step: float) -> str:
    """A step as people write it: 1/960, or 0.003 where it is no fraction of a second."""
    return f"1/{round(1.0 / step)}" if step < 1.0 and abs(1.0 / step - round(1.0 / step)) < 1e-6 else short(step)


def alarm_text(found: Frontier) -> str:
    """The gravest finer-is-worse alarm over all ladders, with the step that is to blame; "" for none."""
    raised = [(alarm, curve.knob) for curve in found.curves for alarm in curve.alarms]
    if not raised:
        return ""
    more = f", and {len(raised) - 1} more" if len(raised) > 1 else ""
    return f"▲ finer is worse: {_alarm(*max(raised, key=lambda pair: pair[0].growth))}{more}"


def _alarm(alarm: Alarm, knob: str) -> str:
    before, after = (
        step_text(s) if knob == "dt" else short(1.0 / s if knob in COUNTS else s) for s in (alarm.coarse, alarm.fine)
    )
    grown = f"{short(alarm.error, 2)} to {short(alarm.finer_error, 2)}"
    return f"{knob} {before} to {after}: {'broke' if math.isinf(alarm.finer_error) else grown}"


def failures_text(found: Frontier) -> str:
    """Settings without an answer: "2 of 10 settings broke (diverged, timeout); 1 of 10 not run"; "" for none."""
    broke = [p for p in found.points if p.broke]
    words = ", ".join(dict.fromkeys(mark(p.cell).word for p in broke))
    parts = [f"{len(broke)} of {len(found.points)} settings broke ({words})"] if broke else []
    return "; ".join(parts + ([f"{found.unrun} of {len(found.points)} not run"] if found.unrun else []))


def absent_text(state: str, reason: str) -> str:
    """ "refused: the scene is not planar"."""
    return rounded(f"{WORDS[state][1] if state in WORDS else state}: {reason}")


def share_text(one: Share, budget: float) -> str:
    """ "62 % of 40": never a share without what it is a share of."""
    return f"{round(100 * one.within(budget))} % of {one.asked}" if one.asked else "–"


def duel_text(one: Duel) -> str:
    """ "12–3–1 of 20": won, drawn and lost on common scenarios; on the rest neither comes down to the target."""
    return f"{one.wins}–{one.draws}–{one.losses} of {one.common}" if one.common else "–"


def advice_text(advice: Advice) -> list[str]:
    """Advice in sentences."""
    if not advice.choices:
        return [f"No engine comes down to {target_text(advice.error)}.", *_short_of(advice), *_absences(advice)]
    first = advice.choices[0]
    lines = [f"Use {setting_text(first.point, first.default)}: error {_measured(first.point)}{_caveat(first.passes)}."]
    if advice.ratio is not None:
        second, dearer = advice.choices[1], short(advice.ratio, 2)
        named = setting_text(second.point, second.default)
        lines.append(f"Next: {named}, {dearer} times as expensive{_caveat(second.passes)}.")
    default = first.default
    if default is not None and default.cell.key != first.point.cell.key:
        usual = _otherwise(default, first.point)
        lines.append(f"Its default ({usual}) {_fault(default, first.point, advice.error)}.")
    return [*lines, *_short_of(advice), *_absences(advice)]


def setting_text(point: Point, default: Point | None) -> str:
    """Engine and what is set otherwise than by default, on one line; everything where the default is not known."""
    usual = default.cell.settings if default is not None else {}
    changed = {name: value for name, value in point.cell.settings.items() if usual.get(name) != value}
    return f"{point.cell.engine} ({told_settings(changed) or 'its default settings'})"


def target_text(target: float) -> str:
    """A target as a power of ten where it is one: "10⁻³", else "0.002"."""
    power = round(math.log10(target))
    return power_of_ten(power) if math.isclose(target, 10.0**power) and power < -1 else short(target)


def _otherwise(default: Point, chosen: Point) -> str:
    """Those of the default settings that the chosen ones change."""
    return told_settings({n: v for n, v in default.cell.settings.items() if chosen.cell.settings.get(n) != v})


def _measured(point: Point) -> str:
    return f"{short(point.error, 2)} at {short(point.cost, 2)} ms/s"


def _caveat(passes: bool) -> str:
    return "" if passes else "; but another check of the scenario fails there"


def _fault(default: Point, chosen: Point, error: float) -> str:
    if default.broke:
        return f"broke: {default.cell.reason}"
    if not default.whole:
        return "was not measured"
    if default.error <= error:
        dearer = short(default.cost / chosen.cost, 2)
        return f"is accurate enough ({short(default.error, 2)}) but costs {dearer} times as much"
    return f"errs by {short(default.error, 2)}, {short(default.error / error, 2)} times what is asked"


def _short_of(advice: Advice) -> list[str]:
    return [
        f"{engine} does not get there: "
        + (f"best {_measured(best)} ({told_settings(best.cell.settings)})." if best else "no run came to its end.")
        for engine, best in advice.short
    ]


def _absences(advice: Advice) -> list[str]:
    return [f"{engine}: {absent_text(state, reason)}." for engine, state, reason in advice.absent]
