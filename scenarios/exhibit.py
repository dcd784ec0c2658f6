"""What makes a scenario an exhibit of the museum: where it comes from and what cures it.

The manners of the house: an exhibit is a behaviour with an accepted truth, not a reproach.  Every row
stands beside the engine's own documented remedy, versions are named, and a documented trade-off is
called one.  Numbers are measured in the run; none is written here but the truth.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Remedy:
    """Settings that the engine's documentation or its maintainers give for this case.

    Attributes
    ----------
    engine : str
        Name with profile.
    words : str
        What is done, for people.
    source : str
        Where it is documented.
    settings : mapping
        Knob -> value, where the profile alone does not say it.
    """

    engine: str
    words: str
    source: str
    settings: Mapping[str, float | str] = field(default_factory=dict)


@dataclass(frozen=True)
class Exhibit:
    """The label beside a scenario.

    Attributes
    ----------
    number : int
        Place in the museum.
    title : str
    shown : str
        What is to be seen, in two or three sentences.
    truth : str
        What everybody accepts, in one sentence.
    figures : mapping
        Quantity -> its true value (a number, or words); what the table shows, in this order.
    origin : tuple of str
        Links to where users met it.
    remedies : tuple of Remedy
    """

    number: int
    title: str
    shown: str
    truth: str
    figures: Mapping[str, float | str]
    origin: tuple[str, ...]
    remedies: tuple[Remedy, ...] = ()
