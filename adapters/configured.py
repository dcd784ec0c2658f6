"""What the adapters of one engine's profiles share: their name, their settings, and why these are what they are."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from adapters.engine import Knob


@dataclass(kw_only=True)
class Configured:
    """An engine with one set of settings.

    Attributes
    ----------
    name, knobs, defaults, profile, known
        As in `adapters.engine.Engine`; `known`: law of `check_engine` -> why this profile breaks it.
    on_request : bool
        As in `adapters.engine.on_request`: variants that the museum shows beside the others.
    remedy : mapping
        What a stock profile changes all the same, by the engine's own names, as its documentation recommends.
    stock : bool
        Only what the scene says is set, everything else is left as the engine has it.
    departures : set of str or None
        Names of the settings in which it departs from stock, for ablations (`adapters.ablation`); None: all of them,
        or none in a stock profile.
    """

    name: str
    stock: bool
    knobs: Mapping[str, tuple[Knob, ...]]
    defaults: Mapping[str, Knob]
    profile: Mapping[str, str]
    on_request: bool = False
    remedy: Mapping[str, Any] = field(default_factory=dict)
    known: Mapping[str, str] = field(default_factory=dict)
    departures: frozenset[str] | None = None

    def departs(self, setting: str) -> bool:
        """Whether a setting, by the name the adapter has for it, departs from stock."""
        return not self.stock if self.departures is None else setting in self.departures
