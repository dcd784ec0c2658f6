"""One line of a read-back card, which scenes depend on it, and how it is written down."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, fields
from typing import Any

GIVEN = "inertia given"
NUMBERS = ("asked", "got", "tolerance", "least", "most")


@dataclass(frozen=True)
class Reading:
    """One line of a card.

    Attributes
    ----------
    name, unit : str
    asked : float
        What the scene says; infinite for a bound that is not there.
    got : float
        What the motion shows (a median where several were read); NaN if nothing could be read.
    tolerance : float
        Largest difference that still counts as the same, in the reading's unit.
    least, most : float
        Extremes of what was read; `got` where only one was.
    refused : bool
        Whether the engine says that it cannot: an answer, no mismatch.
    said : str
        A remark, or why nothing could be read.
    about : tuple of str
        What a scene must have to depend on this: names of effects and shapes, and the like (see `facts`).
    bears_on : tuple of str
        Words in the names of the quantities that depend on it.
    """

    name: str
    unit: str
    asked: float
    got: float
    tolerance: float
    least: float = math.nan
    most: float = math.nan
    refused: bool = False
    said: str = ""
    about: tuple[str, ...] = ()
    bears_on: tuple[str, ...] = ()

    @property
    def same(self) -> bool:
        """Whether everything that was read is what was asked, to the tolerance."""
        read = [v for v in (self.got, self.least, self.most) if not math.isnan(v)]
        return bool(read) and all(v == self.asked or abs(v - self.asked) <= self.tolerance for v in read)

    @property
    def verdict(self) -> str:
        """ "same", "differs", "refused" or "unread"."""
        if self.refused:
            return "refused"
        return "unread" if math.isnan(self.got) else "same" if self.same else "differs"

    def matters(self, facts: Iterable[str], fastest: Mapping[str, float] | None = None) -> bool:
        """Whether it differs and a scene with these facts depends on it.

        `fastest` says how fast things get there, by unit ("m/s", "rad/s"): a bound above that plays no part.
        """
        bounded = self.asked == math.inf and (fastest or {}).get(self.unit, math.inf) < self.got
        return self.verdict == "differs" and set(self.about) <= set(facts) and not bounded


def facts(scene: Mapping[str, Any]) -> set[str]:
    """What a reading may depend on, of a scene as `mechanics.scene_file` writes it."""
    found = {e["type"] for e in scene["effect"]} | {b["shape"]["type"] for b in scene["body"]}
    found |= {f"unlike {e['type']}" for e in scene["effect"] if e.get("between")}
    return found | ({GIVEN} if any("inertia" in b for b in scene["body"]) else set())


def fastest(scene: Mapping[str, Any], duration: float) -> dict[str, float]:
    """Largest speeds a scene can reach without being pushed, by unit: those at the start and what gravity adds."""
    fall = sum(math.hypot(*e.get("acceleration", (0.0, 0.0, -9.81))) for e in scene["effect"] if e["type"] == "Gravity")
    start = {n: max(math.hypot(*b.get(n, (0.0,))) for b in scene["body"]) for n in ("velocity", "angular_velocity")}
    return {"m/s": start["velocity"] + fall * duration, "rad/s": start["angular_velocity"]}


def dependent(quantity: str, readings: Iterable[Reading]) -> bool:
    """Whether a quantity depends on any of the readings."""
    return any(word in quantity for reading in readings for word in reading.bears_on)


def to_plain(reading: Reading) -> dict[str, Any]:
    """For JSON: NaN becomes null, infinity "inf"; `verdict` beside it."""
    told = asdict(reading) | {"verdict": reading.verdict}
    for name in NUMBERS:
        value = told[name]
        told[name] = None if math.isnan(value) else str(value) if math.isinf(value) else value
    return told


def from_plain(told: Mapping[str, Any]) -> Reading:
    """Reading of what `to_plain` wrote.

    Raises
    ------
    KeyError
        For a field that is missing.
    """
    kept: dict[str, Any] = {f.name: told[f.name] for f in fields(Reading)}
    for name in NUMBERS:
        kept[name] = math.nan if kept[name] is None else float(kept[name])
    for name in ("about", "bears_on"):
        kept[name] = tuple(kept[name])
    return Reading(**kept)
