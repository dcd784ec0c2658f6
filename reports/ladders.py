"""Ladders: how far each engine got, as one figure for each difficulty."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

from comparisons.cell import Campaign, Cell
from comparisons.climb import ABSENT, Frontier, Try, frontier, how
from reports.drawing import marker_shape
from reports.numbers import short, with_unit
from reports.palette import slug
from reports.verdict import engine_order, sentence

NAMES, WIDTH, RIGHT, ROW, HEAD = 150.0, 760.0, 148.0, 24.0, 34.0  # [px]
GLYPHS = {"refused": "–", "too slow": "◷"}
LEGEND = (
    ("●", "holds", "sound, and as near the truth as the ladder asks"),
    ("✕", "silently wrong", "an answer that no one would take for the truth, handed in as one"),
    ("!", "crashed, raised, gave up", "the engine or its process says that there is no answer"),
    ("◷", "too slow", "killed at the deadline of a rung: a matter of this machine, not of truth"),
    ("–", "refused", "the engine says that it cannot"),
)


@dataclass(frozen=True)
class Climbed:
    """One engine on one ladder, with the reason of its break in words."""

    ladder: str
    engine: str
    unit: str
    tries: tuple[Try, ...]
    frontier: Frontier
    why: str
    top: float  # the hardest rung

    @property
    def word(self) -> str:
        """How it ended: a way to break, "holds" at the top, or that the run ended before."""
        return self.frontier.word or ("holds" if self.frontier.good == self.top else "not run beyond")


@dataclass(frozen=True)
class Chapter:
    """One ladder as the page shows it."""

    name: str
    raises: str
    drawing: str
    climbs: tuple[Climbed, ...]


def climbs(campaign: Campaign) -> tuple[Climbed, ...]:
    """Every climb of the campaign, ladder by ladder, engines in the order of every table."""
    cells = {c.key: c for c in campaign.cells}
    return tuple(c for name, told in campaign.ladders.items() for c in _climbs(name, told, cells))


def chapters(campaign: Campaign) -> tuple[Chapter, ...]:
    """Every ladder of the campaign, drawn."""
    done = climbs(campaign)
    return tuple(
        Chapter(name, told["raises"], _drawn(told, own), own)
        for name, told in campaign.ladders.items()
        if (own := tuple(c for c in done if c.ladder == name))
    )


def glyph(word: str) -> str:
    """The sign for a way to break; "●" for none."""
    if not word:
        return "●"
    return GLYPHS.get(word, "✕" if Frontier(None, None, word).silent else "!")


def _climbs(name: str, told: Mapping[str, Any], cells: Mapping[str, Cell]) -> Iterator[Climbed]:
    falling = told["rungs"][0] > told["rungs"][-1]
    for engine in engine_order(told["climbs"]):
        tried = [(rung, cells[key]) for rung, key in told["climbs"][engine] if key in cells]
        made = [(rung, cell) for rung, cell in tried if cell.state != "not-run"]
        tries = tuple(Try(float(rung), how(cell)) for rung, cell in made)
        edge = frontier(tries, falling)
        why = next((sentence(cell) for rung, cell in made if rung == edge.bad), "")
        yield Climbed(name, engine, told["unit"], tries, edge, why, float(told["rungs"][-1]))


def _drawn(told: Mapping[str, Any], own: Sequence[Climbed]) -> str:
    """Rungs from left to right; a line for each engine, as far as it holds, and the sign and word of its break."""
    rungs = told["rungs"]
    height = HEAD + ROW * len(own) + 8.0
    low, high = math.log(rungs[0]), math.log(rungs[-1])

    def place(rung: float) -> float:
        return NAMES + 14.0 + (WIDTH - NAMES - RIGHT - 14.0) * (math.log(rung) - low) / (high - low)

    parts = [_axis(rungs, told["unit"], place, height)]
    parts += [_row(climb, HEAD + ROW * (k + 0.5), place) for k, climb in enumerate(own)]
    spoken = "; ".join(f"{c.engine} {_told(c)}" for c in own)
    return (
        f'<svg class="fig rungs" viewBox="0 0 {WIDTH:g} {height:g}" role="img" aria-label="{escape(spoken)}">'
        + "".join(parts)
        + "</svg>"
    )


def _axis(rungs: Sequence[float], unit: str, place: Any, height: float) -> str:
    parts, free = [], -math.inf
    for rung in rungs:
        x, label = place(rung), short(rung)
        parts.append(f'<path class="grid" d="M{x:.1f} {HEAD - 6.0:g}V{height - 6.0:g}"/>')
        half = 3.3 * len(label)
        if x - half > free:
            parts.append(f'<text class="tick" text-anchor="middle" x="{x:.1f}" y="{HEAD - 12.0:g}">{label}</text>')
            free = x + half + 4.0
    if unit != "1":
        parts.append(f'<text class="tick" x="4" y="{HEAD - 12.0:g}">{escape(with_unit(1.0, unit)[2:])}</text>')
    return "".join(parts)


def _row(climb: Climbed, y: float, place: Any) -> str:
    edge, name = climb.frontier, f"eng-{slug(climb.engine)}"
    parts = [
        f"<title>{escape(f'{climb.engine}: {_told(climb)}. {climb.why}')}</title>",
        marker_shape(climb.engine, 9.0, y),
        f'<text class="engine" x="20" y="{y + 4.0:.1f}">{escape(climb.engine)}</text>',
    ]
    held = [t.rung for t in climb.tries if not t.broke]
    if edge.good is not None:
        first = next(t.rung for t in climb.tries if not t.broke)
        parts.append(f'<path class="climb" d="M{place(first):.1f} {y:.1f}H{place(edge.good):.1f}"/>')
    parts += [f'<circle class="held" cx="{place(r):.1f}" cy="{y:.1f}" r="3.5"/>' for r in held]
    last = place(edge.good) if edge.good is not None else NAMES
    for t in climb.tries:
        if t.broke and (t.rung == edge.bad or edge.again):
            x = place(t.rung)
            last = max(last, x)
            parts.append(
                f'<text class="sign" text-anchor="middle" x="{x:.1f}" y="{y + 4.5:.1f}">{glyph(t.broke)}</text>'
            )
    last = max([last, *map(place, edge.again)])
    word = climb.word
    parts.append(f'<text class="word" x="{last + 11.0:.1f}" y="{y + 4.0:.1f}">{escape(word)}</text>')
    return f'<g class="{name}">{"".join(parts)}</g>'


def _told(climb: Climbed) -> str:
    edge = climb.frontier
    if not edge.word:
        beyond = "" if climb.word == "holds" else ", not run beyond"
        return f"holds to {with_unit(edge.good, climb.unit)}{beyond}" if edge.good is not None else "was not run"
    if edge.word in ABSENT.values():
        return edge.word
    bad = with_unit(edge.bad or math.nan, climb.unit)
    start = f"holds to {with_unit(edge.good, climb.unit)}, " if edge.good is not None else ""
    again = f"; holds again at {', '.join(short(r) for r in edge.again)}" if edge.again else ""
    return f"{start}{edge.word} at {bad}{again}"
