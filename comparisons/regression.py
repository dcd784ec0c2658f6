"""Regression: what a cell was in the baseline, what it is now, and whether that is news.

A `Record` is what a baseline keeps of a cell: its state, the digest of its last state and every measured number.
`compare` sets a cell beside its record and calls the outcome by one word of `OUTCOMES`.

Whether a number has changed is asked of a band around the recorded one.  On the platform class a record was made on
the same program gives the same bits, and the band is `SAME`, a share of the number, for programs that were written anew
in the same method.  On another class rounding differs from the first multiplication on, and contact amplifies it: the
band is `OTHER`, a share of the number or of its tolerance, whichever is larger, and what nothing is demanded of has
none.  No band is narrower than what a computation errs by that rounds only (`exact` of the check, or its default).
docs/ci.md tells what was measured for both.
"""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields
from typing import Any

from comparisons.cell import Campaign, Cell
from comparisons.measurement import Measurement
from scenarios.scenario import Check

SAME = 1e-3  # share of the recorded value a value may differ by on the same platform class
OTHER = 0.1  # on another one, of the value or its tolerance
ROUNDING = Check.exact  # what nothing is demanded of may always differ by, in its unit

OUTCOMES = (
    "identical",  # state, digest and every number, bit by bit
    "in band",  # not identical, but every number within its band
    "improved",  # better than recorded by more than the band: to be accepted, never accepted silently
    "moved",  # neither better nor worse by what is demanded, but something else that is measured left its band
    "regressed",  # worse than recorded by more than the band, or in state
    "gone",  # answered in the baseline, and no answer now
    "new",  # not in the baseline
    "not comparable",  # the scenario asks something else now
)
FINDINGS = ("regressed", "moved", "gone")  # what a run is stopped for
STANDING = {"ok": 3, "xpass": 3, "fail": 2, "xfail": 2, "refused": 1, "not-installed": 1, "not-run": 1}  # broke: 0
ABSENT, ANSWERED = 1, 2


@dataclass(frozen=True)
class Record:
    """What a baseline keeps of a cell.

    Attributes
    ----------
    scenario, version, engine, engine_version, settings, state, digest
        As in `Cell`.
    question : str
        Hash of what was asked: scene, duration, sampling.
    values : dict
        Quantity -> its value, where it is a number.
    words : dict
        Quantity -> what was said of it, where a word is the answer (such as the impact law).
    demanded : dict
        Quantity -> [tolerance, exact], where something was demanded.
    platform : str
        Platform class it was made on.
    reason : str
        Why it was accepted.
    """

    scenario: str
    version: int
    engine: str
    engine_version: str
    settings: Mapping[str, float | str]
    state: str
    digest: str
    question: str
    values: Mapping[str, float]
    words: Mapping[str, str]
    demanded: Mapping[str, Sequence[float]]
    platform: str
    reason: str = ""

    @property
    def identity(self) -> str:
        """What the record is about; see the function of that name."""
        return identity(self.scenario, self.engine, self.settings)


@dataclass(frozen=True)
class Change:
    """A cell beside its record.

    Attributes
    ----------
    scenario, engine, settings
    outcome : str
        One of `OUTCOMES`.
    record : Record or None
    cell : Cell or None
    quantity : str
        The one that decided, or that differs most; "" if it was none.
    before, now : float
        Its values; NaN where there is none.
    why : str
        What decided, where it was no number.
    same : bool
        Whether record and cell are of one platform class.
    """

    scenario: str
    engine: str
    settings: Mapping[str, float | str]
    outcome: str
    record: Record | None
    cell: Cell | None
    quantity: str = ""
    before: float = math.nan
    now: float = math.nan
    why: str = ""
    same: bool = True


@dataclass(frozen=True)
class Shift:
    """One number that differs.

    `bands` is by how many half-widths of its band, positive for larger; `weight`, how much that matters: the
    difference over the tolerance where one is demanded.
    """

    quantity: str
    before: float
    now: float
    demanded: bool
    bands: float
    weight: float


@dataclass(frozen=True)
class Baseline:
    """Records that a campaign is to be compared with.

    Attributes
    ----------
    name : str
    platform : str
        Platform class of the campaign.
    records : tuple of Record
        Of the cells that the campaign was to have; one for each.
    """

    name: str
    platform: str
    records: tuple[Record, ...] = field(default=())

    def to_plain(self) -> dict[str, Any]:
        """As `run.json` holds it."""
        return {"name": self.name, "platform": self.platform, "records": [to_plain(r) for r in self.records]}

    @staticmethod
    def from_plain(data: Mapping[str, Any]) -> Baseline:
        """The inverse of `to_plain`."""
        return Baseline(data["name"], data["platform"], tuple(from_plain(r) for r in data["records"]))


def identity(scenario: str, engine: str, settings: Mapping[str, float | str]) -> str:
    """What is the same in every version of an engine: scenario, engine and settings, as one text."""
    return json.dumps([scenario, engine, dict(settings)], sort_keys=True)


def record(cell: Cell, question: str, platform: str, reason: str = "") -> Record:
    """What a baseline keeps of `cell`."""
    numbers = {m.quantity: m.value for m in cell.measurements if not math.isnan(m.value)}
    return Record(
        cell.scenario,
        cell.version,
        cell.engine,
        cell.engine_version,
        dict(cell.settings),
        cell.state,
        cell.digest,
        question,
        numbers,
        _words(cell),
        {m.quantity: [m.tolerance, m.exact] for m in cell.measurements if not math.isnan(m.tolerance)},
        platform,
        reason,
    )


def _words(cell: Cell) -> dict[str, str]:
    """Answers that are words: they have no unit.  Of a number that could not be measured the text is a remark."""
    return {m.quantity: m.text for m in cell.measurements if math.isnan(m.value) and not m.unit}


def to_plain(made: Record) -> dict[str, Any]:
    """A record as JSON holds it; infinity is written as a word, since JSON has none."""
    data = asdict(made)
    return data | {
        "values": {name: value if math.isfinite(value) else str(value) for name, value in made.values.items()}
    }


def from_plain(data: Mapping[str, Any]) -> Record:
    """The inverse of `to_plain`.

    Raises
    ------
    ValueError
        For a record that lacks something or holds something unknown.
    """
    names = {f.name for f in fields(Record)}
    if set(data) != names:
        raise ValueError(f"not a record of a baseline: {', '.join(sorted(set(data) ^ names))} too much or too little")
    return Record(**{**data, "values": {name: float(value) for name, value in data["values"].items()}})


def changes(campaign: Campaign) -> tuple[Change, ...]:
    """Every cell of the campaign beside its record, in the order of its plan, then what is gone.

    Empty if the campaign was not to be compared with a baseline.
    """
    if not campaign.baseline:
        return ()
    baseline = Baseline.from_plain(campaign.baseline)
    questions = {label: str(told.get("question", "")) for label, told in campaign.scenarios.items()}
    matched, lost = pairs(baseline.records, campaign.cells)
    found = [compare(r, cell, questions.get(cell.scenario, ""), baseline.platform) for r, cell in matched]
    gone = [Change(r.scenario, r.engine, r.settings, "gone", r, None, why="the run has no such cell")
            for r in lost if STANDING.get(r.state, 0) >= ANSWERED]  # fmt: skip
    return (*found, *gone)


def pairs(
    records: Iterable[Record], cells: Iterable[Cell]
) -> tuple[list[tuple[Record | None, Cell]], tuple[Record, ...]]:
    """Every cell with its record, or None, and the records that are left over.

    A record is that of the cell with the same scenario, engine and settings.  Where of a scenario and an engine one of
    each is left, they belong together, too: a setting was added, or has another default now.
    """
    cells, known = list(cells), {r.identity: r for r in records}
    matched = [(known.pop(identity(c.scenario, c.engine, c.settings), None), c) for c in cells]
    single: dict[tuple[str, str], list[Record]] = {}
    for r in known.values():
        single.setdefault((r.scenario, r.engine), []).append(r)
    alone = Counter((c.scenario, c.engine) for r, c in matched if r is None)
    for k, (r, cell) in enumerate(matched):
        left = single.get((cell.scenario, cell.engine), [])
        if r is None and len(left) == alone[cell.scenario, cell.engine] == 1:
            matched[k] = (left[0], cell)
            known.pop(left[0].identity)
    return matched, tuple(known.values())


def compare(before: Record | None, cell: Cell, question: str, platform: str) -> Change:
    """`cell`, which answers `question` on `platform`, beside its record."""
    if before is None:
        return Change(cell.scenario, cell.engine, cell.settings, "new", None, cell)
    same = before.platform == platform
    shift, why = None, _incomparable(before, cell, question if same else "")
    if why:
        outcome = "not comparable"
    elif outcome := _by_state(before.state, cell.state):
        shift, why = _decisive(list(_shifts(before, cell, same)), outcome), f"{before.state} → {cell.state}"
    elif _identical(before, cell):
        outcome = "identical"
    else:
        outcome, shift, why = _by_numbers(before, cell, same)
    told = () if shift is None else (shift.quantity, shift.before, shift.now)
    return Change(cell.scenario, cell.engine, cell.settings, outcome, before, cell, *told, why=why, same=same)


def _incomparable(before: Record, cell: Cell, question: str) -> str:
    """Why the cell answers another question than the record did; "" if it does not."""
    if before.version != cell.version:
        return f"version {before.version} of the scenario was recorded, and this is version {cell.version}"
    if question and before.question and question != before.question:
        return "the scenario asks something else under the same version number"
    return ""


def _identical(before: Record, cell: Cell) -> bool:
    """Whether everything that was recorded is the same; what is measured since then only is no change of the answer."""
    now = record(cell, "", "")
    same = (now.settings, now.state, now.digest) == (before.settings, before.state, before.digest)
    return same and now.values | before.values == now.values and now.words | before.words == now.words


def _by_state(before: str, now: str) -> str:
    """What the states alone decide; "" if it is left to the numbers.

    Right, wrong, absent and broken stand in this order; whether a failure is on record changes nothing in the answer.
    """
    stood, stands = STANDING.get(before, 0), STANDING.get(now, 0)
    if stood >= ANSWERED and stands == ABSENT:
        return "gone"
    return "" if stood == stands else "regressed" if stands < stood else "improved"


def _by_numbers(before: Record, cell: Cell, same: bool) -> tuple[str, Shift | None, str]:
    """Outcome, the number that decides, and the reason if none does."""
    shifts = list(_shifts(before, cell, same))
    for outcome in ("regressed", "improved", "moved"):
        shift = _decisive(shifts, outcome)
        if shift is not None:
            return outcome, shift, ""
    lost = [name for name in before.values if name in before.demanded and cell.of(name) is None]
    if lost:
        return "gone", None, f"{lost[0]} is not measured any more"
    said = _words(cell)
    other = [name for name, text in before.words.items() if name in said and said[name] != text]
    if other:
        return "moved", None, f"{other[0]}: {before.words[other[0]]} → {said[other[0]]}"
    most = max(shifts, key=lambda s: abs(s.bands), default=None)
    return "in band", most, "" if most else "nothing that is measured differs"


def _decisive(shifts: Sequence[Shift], outcome: str) -> Shift | None:
    """Of the numbers out of their bands in the direction that `outcome` means the weightiest, or None."""
    side = {
        "regressed": [s for s in shifts if s.demanded and s.bands > 1.0],
        "improved": [s for s in shifts if s.demanded and s.bands < -1.0],
        "moved": [s for s in shifts if not s.demanded and abs(s.bands) > 1.0],
    }.get(outcome, [])
    return max(side, key=lambda s: s.weight, default=None)


def _shifts(before: Record, cell: Cell, same: bool) -> Iterator[Shift]:
    """Every number of the record that is another one now."""
    for m in cell.measurements:
        old = before.values.get(m.quantity, math.nan)
        if m.value == old or math.isnan(old):
            continue
        bands = _bands(old, m, same)
        demanded = not math.isnan(m.tolerance)
        weight = abs(m.value - old) / m.tolerance if demanded and m.tolerance > 0.0 else abs(bands)
        yield Shift(m.quantity, old, m.value, demanded, bands, math.inf if math.isnan(weight) else weight)


def _bands(old: float, m: Measurement, same: bool) -> float:
    """By how many half-widths of the band around the recorded value the number is off."""
    demanded = not math.isnan(m.tolerance)
    if not (same or demanded):
        return 0.0
    if math.isnan(m.value) or math.isinf(old):
        return math.inf if math.isnan(m.value) else -math.inf
    floor = ROUNDING if math.isnan(m.exact) else m.exact
    share = SAME * abs(old) if same else OTHER * max(abs(old), m.tolerance)
    return (m.value - old) / max(share, floor)


def tally(found: Iterable[Change]) -> dict[str, int]:
    """How often each outcome occurs, in the order of `OUTCOMES`; what does not occur is left out."""
    outcomes = [c.outcome for c in found]
    return {word: outcomes.count(word) for word in OUTCOMES if word in outcomes}
