"""Every scenario by name; selection by name, parameter, suite, tag and effect."""

from __future__ import annotations

import importlib
import pkgutil
import re
from collections.abc import Sequence
from difflib import get_close_matches
from fnmatch import fnmatchcase
from functools import cache

import scenarios
from scenarios.scenario import FAMILIES, Family, Scenario


class UnknownName(ValueError):
    """A selector that selects nothing: names near matches and what there is."""


@cache
def families() -> dict[str, Family]:
    """Every family of the catalogue by name, sorted."""
    for module in pkgutil.walk_packages(scenarios.__path__, "scenarios."):
        importlib.import_module(module.name)
    return dict(sorted(FAMILIES.items()))


def suites() -> tuple[str, ...]:
    """Names of all suites."""
    return tuple(sorted({s for f in families().values() for s in f.suites}))


def suite(name: str) -> tuple[Scenario, ...]:
    """Scenarios of a suite; `smoke` takes the default variant of each of its families only.

    Raises
    ------
    UnknownName
    """
    if name not in suites():
        raise unknown("suite", name, suites())
    chosen = [f for f in families().values() if name in f.suites]
    return tuple(s for f in chosen for s in (f.all()[:1] if name == "smoke" else f.all()))


def find(selector: str) -> tuple[Scenario, ...]:
    """Scenarios of `name`, a glob over names, or `name[param=value, ...]`.

    A bare name or glob gives all variants of the families it matches; parameters give that one.

    Raises
    ------
    UnknownName
        If nothing matches.
    ValueError
        For a parameter that is unknown or out of range.
    """
    match = re.fullmatch(r"([^\[\]]+)\[(.*)\]", selector)
    pattern = match[1] if match else selector
    matching = [f for name, f in families().items() if fnmatchcase(name, pattern)]
    if not matching:
        raise unknown("scenario", pattern, tuple(families()))
    if not match:
        return tuple(s for f in matching for s in f.all())
    parameters = {}
    for item in filter(None, match[2].split(",")):
        name, sign, value = item.partition("=")
        if not sign:
            raise ValueError(f"{selector!r}: {item!r} is not of the form parameter=value")
        parameters[name.strip()] = _value(value.strip())
    return tuple(f.of(**parameters) for f in matching)


def unknown(kind: str, name: str, known: Sequence[str]) -> UnknownName:
    """Error for a name that is not there: near matches first, then all of them."""
    near = get_close_matches(name, known, n=3, cutoff=0.5)
    hint = f"; did you mean {' or '.join(near)}?" if near else ""
    return UnknownName(f"there is no {kind} {name!r}{hint} (there are: {', '.join(known)})")


def _value(text: str) -> object:
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text
