"""Ladder: one difficulty, raised rung by rung until an engine breaks.

A ladder is data.  Its rungs are scenarios of one family, or values of one knob of the engine on one
scenario; what counts as broken is what the scenario demands: stability and a coarse truth.  A module of
`scenarios.ladders` that holds a tuple `LADDERS` is found by being there.
"""

from __future__ import annotations

import importlib
import math
import pkgutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from functools import cache

from scenarios import catalogue
from scenarios.scenario import Check, Scenario

STABLE = Check("stability", 0.5, "counted in ways to break, of which a sound motion shows none", exact=0.25)


@dataclass(frozen=True)
class Ladder:
    """One difficulty.

    Attributes
    ----------
    name : str
    raises : str
        What is raised, in words.
    unit : str
        Of the rungs; "1" for a ratio.
    family : str
        Of the scenarios.
    rungs : tuple of float
        From easy to hard, in steps of a constant ratio or nearly.
    parameter : str
        Of the family, that takes the rungs' values; "" if they are values of `knob`.
    knob : str
        Of the engine; engines that do not have it do not climb.
    lacking : str
        A knob that keeps engines that have it from this ladder; "" for none.
    fixed : mapping
        Other parameters of the family.
    monotone : bool
        Whether what breaks an engine at one rung breaks it at all harder ones.  Then the climb ends at the first
        rung that breaks it, and the edge is found by bisection; otherwise every rung is tried.
    """

    name: str
    raises: str
    unit: str
    family: str
    rungs: tuple[float, ...]
    parameter: str = ""
    knob: str = ""
    lacking: str = ""
    fixed: Mapping[str, object] = field(default_factory=dict)
    monotone: bool = True

    def __post_init__(self) -> None:
        if bool(self.parameter) == bool(self.knob):
            raise ValueError(
                f"ladder {self.name!r}: either a parameter of the family or a knob of the engine is raised"
            )
        steps = [math.copysign(1.0, b - a) for a, b in zip(self.rungs, self.rungs[1:], strict=False)]
        if len(set(steps)) != 1 or min(self.rungs) <= 0.0:
            raise ValueError(f"ladder {self.name!r}: rungs = {self.rungs} are not positive, rising or falling")

    def scenario(self, rung: float) -> Scenario:
        """The scenario of a rung."""
        raised = {self.parameter: rung} if self.parameter else {}
        return catalogue.families()[self.family].of(**{**self.fixed, **raised})

    def settings(self, rung: float) -> dict[str, float]:
        """Settings of the engine on a rung."""
        return {self.knob: float(rung)} if self.knob else {}

    def between(self, good: float, bad: float) -> float | None:
        """A rung half way between two, geometrically, of three digits; None if there is none left to try."""
        middle = float(f"{math.sqrt(good * bad):.3g}")
        whole = self.parameter and isinstance(catalogue.families()[self.family].defaults[self.parameter], int)
        middle = float(round(middle)) if whole else middle
        return middle if min(good, bad) < middle < max(good, bad) else None


@cache
def ladders() -> dict[str, Ladder]:
    """Every ladder by name, sorted.

    Raises
    ------
    ValueError
        If two have the same name.
    """
    import scenarios.ladders

    found: dict[str, Ladder] = {}
    for module in pkgutil.iter_modules(scenarios.ladders.__path__):
        for ladder in importlib.import_module(f"scenarios.ladders.{module.name}").LADDERS:
            if ladder.name in found:
                raise ValueError(f"two ladders are called {ladder.name!r}")
            found[ladder.name] = ladder
    return dict(sorted(found.items()))


def find(patterns: Sequence[str] = ()) -> tuple[Ladder, ...]:
    """Ladders whose names match any of the patterns (names or globs); all without a pattern.

    Raises
    ------
    UnknownName
        For a pattern that matches none.
    """
    known = ladders()
    for pattern in patterns:
        if not any(fnmatchcase(name, pattern) for name in known):
            raise catalogue.unknown("ladder", pattern, tuple(known))
    return tuple(one for name, one in known.items() if not patterns or any(fnmatchcase(name, p) for p in patterns))
