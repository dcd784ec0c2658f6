"""What a cell says in one glyph, one word and one sentence; the order of engines and scenarios.

Every format of the report takes its words from here.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from comparisons.cell import Campaign, Cell
from comparisons.measurement import Measurement
from reports.numbers import duration_text, rounded, settings_text, short, with_unit
from reports.palette import HOUSE, base, profile

BROKEN = ("diverged", "error", "crash", "timeout", "oom")
ABSENT = ("refused", "not-installed", "not-run")
RED = ("fail", *BROKEN, "xpass")

WORDS = {
    "fail": ("✕", "fail", "fail"),
    "diverged": ("!", "diverged", "broke"),
    "error": ("!", "error", "broke"),
    "crash": ("!", "crash", "broke"),
    "timeout": ("!", "timeout", "broke"),
    "oom": ("!", "out of memory", "broke"),
    "refused": ("–", "refused", "none"),
    "not-installed": ("–", "not installed", "none"),
    "not-run": ("–", "not run", "none"),
    "xfail": ("~", "known", "known"),
    "xpass": ("▲", "now passes", "known"),
}
LEGEND = (
    ("✓", "exact", "every demanded quantity met to rounding"),
    ("✓", "ok", "within tolerance"),
    ("○", "not marked", "mechanics leaves the answer open: named, not judged"),
    ("✕", "fail", "beyond tolerance"),
    ("!", "diverged, crash, timeout", "the engine broke"),
    ("~", "known", "fails for a reason on record"),
    ("–", "refused", "the engine says it cannot"),
    ("?", "not judged", "a fault of the harness, charged to nobody"),
)


@dataclass(frozen=True)
class Mark:
    """A verdict as shown.

    Attributes
    ----------
    glyph, word : str
        Never one without the other.
    tone : str
        One of `reports.palette.TONES`.
    """

    glyph: str
    word: str
    tone: str


def unjudged(cell: Cell) -> bool:
    """Whether the judge failed and not the engine: a fault of the harness is charged to nobody."""
    return cell.state == "error" and cell.stage == "judge"


def mark(cell: Cell) -> Mark:
    """Glyph, word and tone of a cell."""
    if unjudged(cell):
        return Mark("?", "not judged", "known")
    if cell.state in WORDS:
        return Mark(*WORDS[cell.state])
    if not judged(cell):
        return Mark("○", "not marked", "none")
    return Mark("✓", "exact" if cell.exact else "ok", "pass")


def imported(cell: Cell) -> bool:
    """Whether the engine could be loaded at all; one that could not was not put to the question."""
    return not (cell.state == "error" and cell.stage == "import")


def judged(cell: Cell) -> bool:
    """Whether anything was demanded of the cell."""
    return cell.worst is not None


def right(cell: Cell) -> bool:
    """Whether everything demanded is within tolerance, on record or not."""
    return cell.state in ("ok", "xpass") and judged(cell)


def ratio(row: Measurement | None) -> float:
    """Error over tolerance; infinite if it was demanded and could not be measured, NaN if nothing is demanded."""
    if row is None or math.isnan(row.tolerance):
        return math.nan
    if math.isnan(row.value):
        return math.inf
    if row.tolerance == 0.0:
        return 0.0 if row.value == 0.0 else math.inf
    return abs(row.value) / row.tolerance


def ratio_text(cell: Cell) -> str:
    """The worst error over its tolerance as shown in the matrix: "0.42× tol"; "" where there is none."""
    worst = cell.worst
    if worst is None:
        return ""
    return "unmeasured" if math.isnan(worst.value) else times_tolerance(ratio(worst))


def times_tolerance(share: float) -> str:
    """ "0.42× tol"; far below the tolerance only the order of magnitude matters: "2×10⁻¹² tol"."""
    text = short(share, 1 if 0.0 < share < 1e-3 else 3)
    return f"{text} tol" if "×" in text else f"{text}× tol"


def sentence(cell: Cell) -> str:
    """Why a cell is not simply right, in words; for a passing cell how far inside its tolerance it is."""
    parts = []
    if cell.state in ("fail", "xfail"):
        rows = [m for m in cell.measurements if m.verdict in ("fail", "unmeasured")]
        parts += [failure_text(m) for m in rows] or [cell.reason or "beyond tolerance"]
    elif unjudged(cell):
        parts.append(f"the harness could not judge it: {cell.reason or 'no reason given'}")
    elif cell.state in BROKEN:
        where = f" while {_DOING[cell.stage]}" if cell.stage in _DOING else ""
        parts.append(f"{WORDS[cell.state][1]}{where}{_when(cell)}: {cell.reason or 'no reason given'}")
    elif cell.state in WORDS:
        parts.append(cell.reason or WORDS[cell.state][1])
    elif cell.worst is not None:
        parts.append(within_text(cell.worst))
    else:
        parts += [f"{m.quantity}: {m.text}" for m in cell.measurements if m.text]
    if cell.state == "xpass":
        parts = ["on record as failing, but every demanded quantity is within its tolerance"]
    if cell.known:
        parts.append(f"on record: {cell.known}")
    return rounded("; ".join(parts))


_DOING = {"import": "importing", "build": "building the scene", "start": "starting", "advance": "advancing",
          "read": "reading the state", "judge": "being judged"}  # fmt: skip


def failure_text(row: Measurement) -> str:
    """ "position error 0.28 m is 14× the tolerance 0.02 m (worst at t = 0.8 s)"."""
    if math.isnan(row.value):
        return f"{row.quantity} could not be measured: {row.text or 'no reason given'}"
    when = "" if math.isnan(row.time) else f" (worst at t = {short(row.time)} s)"
    return (
        f"{row.quantity} {with_unit(row.value, row.unit)} is {short(ratio(row))}× the tolerance "
        f"{with_unit(row.tolerance, row.unit)}{when}"
    )


def within_text(row: Measurement) -> str:
    """ "position error 0.008 m, tolerance 0.02 m"."""
    return f"{row.quantity} {with_unit(row.value, row.unit)}, tolerance {with_unit(row.tolerance, row.unit)}"


def _when(cell: Cell) -> str:
    return f" at {short(cell.time)} s of {short(cell.duration)} s" if cell.time > 0.0 else ""


def engine_order(names: Iterable[str]) -> list[str]:
    """Fair profiles first, then stock, then others; within each, engines of the house first, guests by name."""
    house = list(HOUSE)

    def place(name: str) -> tuple[int, int, str, str]:
        kind = {"": 0, "stock": 1}.get(profile(name), 2)
        return kind, house.index(base(name)) if base(name) in house else len(house), base(name), name

    return sorted(set(names), key=place)


def engines(campaign: Campaign) -> list[str]:
    """Engines of the campaign in the order of every table."""
    return engine_order(c.engine for c in campaign.cells)


def scenarios(campaign: Campaign) -> list[str]:
    """Labels of the scenarios in the order they were run; labels that only the description knows are left out."""
    return list(dict.fromkeys(c.scenario for c in campaign.cells))


def first_of_family(campaign: Campaign, labels: Iterable[str]) -> set[str]:
    """Those of `labels` that are the first of their family."""
    family = {c.scenario: c.family for c in campaign.cells}
    first: dict[str, str] = {}
    for label in labels:
        first.setdefault(family.get(label, label), label)
    return set(first.values())


def chosen(campaign: Campaign) -> dict[tuple[str, str], Cell]:
    """The cell that stands for each (scenario, engine): the engine's default settings, else the first that was run."""
    best: dict[tuple[str, str], Cell] = {}
    for cell in campaign.cells:
        place = (cell.scenario, cell.engine)
        described = campaign.engines.get(cell.engine, {}).get("settings")
        if place not in best or (described == dict(cell.settings) and dict(best[place].settings) != described):
            best[place] = cell
    return best


def anchor(campaign: Campaign) -> dict[int, str]:
    """Fragment of each cell by its place in the campaign, unique even if two cells share a key."""
    seen: dict[str, int] = {}
    names = {}
    for place, cell in enumerate(campaign.cells):
        plain = "".join(c for c in cell.key if c.isascii() and c.isalnum()) or "x"
        seen[plain] = seen.get(plain, 0) + 1
        names[place] = f"cell-{plain}" + (f"-{seen[plain]}" if seen[plain] > 1 else "")
    return names


def case_name(cell: Cell) -> str:
    """Engine and settings on one line."""
    return f"{cell.engine} ({settings_text(cell.settings)})" if cell.settings else cell.engine


def description(campaign: Campaign, scenario: str) -> dict:
    """What the campaign says of a scenario, with every field there."""
    blank = {"summary": "", "source": "", "tags": (), "effects": (), "checks": ()}
    return blank | dict(campaign.scenarios.get(scenario, {}))


def totals(campaign: Campaign) -> str:
    """ "56 cells: 40 right, 9 wrong ..." in one line."""
    words: dict[str, int] = {}
    for cell in campaign.cells:
        words[mark(cell).word] = words.get(mark(cell).word, 0) + 1
    spent = f" in {duration_text(campaign.wall_seconds)}" if campaign.wall_seconds > 0.0 else ""
    return f"{len(campaign.cells)} cells{spent}: " + ", ".join(f"{n} {word}" for word, n in words.items())
