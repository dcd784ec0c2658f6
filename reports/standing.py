"""Who is right, at what cost: compared on common scenarios only, coverage stated.

An engine that takes four questions and answers four is not better than one that takes six and answers
five.  Counts are therefore compared only where every engine of the comparison was marked, and costs
only where every one of them was right: fast because wrong must be impossible.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from comparisons.cell import Campaign, Cell
from reports.numbers import count, listed, short
from reports.palette import profile
from reports.verdict import ABSENT, BROKEN, chosen, engines, imported, judged, mark, right, scenarios, unjudged


@dataclass(frozen=True)
class Card:
    """How one engine stands.

    Attributes
    ----------
    engine, version : str
    right_common : int
        Common scenarios it has right, of `Group.common`.
    tally : dict
        Word of the verdict -> number of scenarios, over all scenarios of the campaign.
    right, marked, asked : int
        Scenarios it has right, scenarios it was marked on, scenarios there are.
    absent : int
        Scenarios it refused, is not installed for, or that were not run.
    cost : float
        Geometric mean of the CPU milliseconds per simulated second over the scenarios that every engine of
        the group has right; NaN if there is none with a cost.
    relative : float
        `cost` over that of the cheapest engine of the group.
    """

    engine: str
    version: str
    right_common: int
    tally: dict[str, int]
    right: int
    marked: int
    asked: int
    absent: int
    cost: float
    relative: float


@dataclass(frozen=True)
class Group:
    """Engines that may be compared: all fair profiles, or all stock profiles.

    Attributes
    ----------
    title : str
    cards : tuple of Card
        In the order of every table, which is no rank.
    common : tuple of str
        Scenarios on which every engine of the group was marked.
    shared_right : tuple of str
        Those of them that every engine has right and whose cost was measured: the base of the cost figures.
    """

    title: str
    cards: tuple[Card, ...]
    common: tuple[str, ...]
    shared_right: tuple[str, ...]


TITLES = {"": "Fair profiles", "stock": "Stock profiles"}


def groups(campaign: Campaign) -> tuple[Group, ...]:
    """Fair, stock and other profiles; engines that could not run anything take no part in common scenarios."""
    kinds = {"": [], "stock": [], "other": []}
    for engine in engines(campaign):
        kinds[profile(engine) if profile(engine) in TITLES else "other"].append(engine)
    titles = TITLES | {"other": "Other profiles"}
    return tuple(_group(campaign, titles[kind], names) for kind, names in kinds.items() if names)


def _group(campaign: Campaign, title: str, names: list[str]) -> Group:
    table, labels = chosen(campaign), scenarios(campaign)
    present = [n for n in names if any(c.engine == n and c.state not in ABSENT and imported(c) for c in campaign.cells)]
    common = [s for s in labels if present and all(_marked(table.get((s, n))) for n in present)]
    shared = [s for s in common if all(_right_with_cost(table[s, n]) for n in present)]
    costs = {n: _mean_cost([table[s, n] for s in shared]) for n in present}
    least = min((c for c in costs.values() if not math.isnan(c)), default=math.nan)
    cards = []
    for name in names:
        cells = [table[s, name] for s in labels if (s, name) in table]
        tally = Counter(mark(c).word for c in sorted(cells, key=_place))
        cost = costs.get(name, math.nan)
        cards.append(Card(
            engine=name, version=next((c.engine_version for c in cells if c.engine_version), ""),
            right_common=sum(right(table[s, name]) for s in common if (s, name) in table), tally=dict(tally),
            right=sum(map(right, cells)), marked=sum(map(_marked, cells)), asked=len(labels),
            absent=len(labels) - sum(c.state not in ABSENT for c in cells), cost=cost, relative=cost / least,
        ))  # fmt: skip
    return Group(title, tuple(cards), tuple(common), tuple(shared))


def _marked(cell: Cell | None) -> bool:
    """Whether the cell counts: it was judged or the engine broke trying; open questions do not count."""
    if cell is None or cell.state in ABSENT or unjudged(cell) or not imported(cell):
        return False
    return cell.state in BROKEN or judged(cell)


def _place(cell: Cell) -> int:
    """Place in the order from right over open and wrong to broken and absent."""
    sign = mark(cell)
    if sign.tone == "pass":
        return 0 if sign.word == "exact" else 1
    if not judged(cell) and cell.state == "ok":
        return 2
    return {"known": 3, "fail": 4, "broke": 5}.get(sign.tone, 6)


def _right_with_cost(cell: Cell) -> bool:
    return right(cell) and math.isfinite(cell.cost) and cell.cost > 0.0


def _mean_cost(cells: Sequence[Cell]) -> float:
    """Geometric mean of the cost [CPU ms per simulated second]; NaN without cells."""
    return math.exp(sum(math.log(1e3 * c.cost) for c in cells) / len(cells)) if cells else math.nan


def lead_sentence(group: Group, asked: int) -> str:
    """Who is right on the common scenarios, and what it costs, in two short sentences."""
    present = [c for c in group.cards if c.marked]
    if not present:
        return "No engine was marked on any scenario."
    if len(present) == 1:
        card = present[0]
        return f"{card.engine} is right on {card.right} of the {count(card.marked, 'scenario')} it was marked on."
    if not group.common:
        return (
            f"There is no scenario that all {len(present)} engines can run, so they are not compared with each other."
        )
    n = len(group.common)
    scope = f"all {asked}" if n == asked else f"the {n} of {asked}"
    head = f"On {scope} scenarios that every engine can run, {_scores(present, n)}."
    return f"{head} {_costs(present, len(group.shared_right))}"


def _scores(cards: Sequence[Card], common: int) -> str:
    by_score: dict[int, list[str]] = {}
    for card in cards:
        by_score.setdefault(card.right_common, []).append(card.engine)
    parts = []
    for score in sorted(by_score, reverse=True):
        names = by_score[score]
        verb = "" if parts else " is right" if len(names) == 1 else " are right"
        amount = f"all {common}" if score == common else "none" if score == 0 else str(score)
        parts.append(f"{listed(names)}{verb} on {amount}")
    return ", ".join(parts)


def times(relative: float) -> str:
    """ "3.4×"; near 1, where two digits say nothing, "1.03×"."""
    return f"{short(relative, 2 if relative >= 1.095 else 3)}×"


def _costs(cards: Sequence[Card], shared: int) -> str:
    costed = sorted((c for c in cards if not math.isnan(c.cost)), key=lambda c: c.cost)
    if not costed:
        return "No scenario has a measured cost and a right answer from all of them, so no cost is compared."
    others = ", ".join(f"{c.engine} {times(c.relative)}" for c in costed[1:])
    where = "On the only scenario" if shared == 1 else f"On the {shared} scenarios"
    return f"{where} where all are right, {costed[0].engine} takes the least CPU time, {others} as much."
