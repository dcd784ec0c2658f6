"""What a benchmark returns: a promise, what was measured, and what the same scene gave in other engines."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Figure:
    """One measured number beside the number promised.

    Attributes
    ----------
    what : str
    value : float
        As measured; NaN if it could not be, which never meets a promise.
    target : float
    unit : str
        "" for a ratio or a count.
    at_least : bool
        Whether the promise is value >= target; otherwise value <= target.
    """

    what: str
    value: float
    target: float
    unit: str = ""
    at_least: bool = False

    @property
    def met(self) -> bool:
        """Whether the promise is kept."""
        return self.value >= self.target if self.at_least else self.value <= self.target


@dataclass(frozen=True)
class Beside:
    """The same scene in an engine: what it cost, never without the error that this bought.

    Attributes
    ----------
    engine : str
    error : float
        In the unit of the row's `judged`; NaN where there is no answer.
    seconds : float
        Wall time of one run, warm [s]; NaN where there is no answer.
    note : str
        Why there is no answer, or what has to be known of it.
    """

    engine: str
    error: float = math.nan
    seconds: float = math.nan
    note: str = ""


@dataclass(frozen=True)
class Row:
    """One promise and what became of it.

    Attributes
    ----------
    name : str
        Of the module that measured it.
    subject : str
    figures : tuple of Figure
        All of them must be met.
    how : str
        How it was measured, and where the truth comes from.
    judged : str
        What `Beside.error` is, with its unit; "" without other engines.
    beside : tuple of Beside
    missed : str
        Why a figure is not met, where one is not; known before, hence a text, and shown only then.
    """

    name: str
    subject: str
    figures: tuple[Figure, ...]
    how: str
    judged: str = ""
    beside: tuple[Beside, ...] = ()
    missed: str = ""

    @property
    def met(self) -> bool:
        """Whether every figure keeps its promise."""
        return all(figure.met for figure in self.figures)
