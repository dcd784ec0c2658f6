"""A figure as a value.

It knows engines and numbers but no pixels and no colours, so that every writer draws the same figure.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Axis:
    """One axis.

    Attributes
    ----------
    label : str
        Quantity with its unit.
    log : bool
    better : str
        Direction in words, for example "down is better"; "" where neither is.
    limits : (least, most) or None
        None: from the data.
    least_span : float
        A linear axis from the data spans at least this much, so that rounding is not blown up to a signal.
    """

    label: str
    log: bool = False
    better: str = ""
    limits: tuple[float, float] | None = None
    least_span: float = 0.0


@dataclass(frozen=True)
class Series:
    """Points of one engine, in the order in which they are joined.

    Attributes
    ----------
    engine : str
        Decides colour, marker and dash; "" is the truth, drawn as a broad grey line below all others.
    x, y : sequences of float
        Infinite y are drawn on a rail at the upper edge; NaN interrupts the line.
    joined : bool
        Whether a line joins the points.
    marked : bool
        Whether each point gets a marker.
    tips : sequence of str
        What each point says when pointed at; empty, or one per point.
    label : str or None
        Direct label; "" is the engine's name, None is none (of several series of one engine, all but the first).
    low : sequence of float
        Lower end of a band that reaches up to `y`, drawn behind the line; empty for none.
    """

    engine: str
    x: Sequence[float]
    y: Sequence[float]
    joined: bool = False
    marked: bool = True
    tips: Sequence[str] = ()
    label: str | None = ""
    low: Sequence[float] = ()


@dataclass(frozen=True)
class Figure:
    """A figure.

    Attributes
    ----------
    title, x, y, series
    guide : (value of y, label) or None
        A horizontal line of reference; what lies below is shaded as good.
    marks : tuple of ("x" or "y", value, label)
        Thin lines of reference besides; those outside the plot are left out.
    front : bool
        Whether to draw the Pareto front: nothing measured is lower in both x and y.
    summary : str
        The figure in words, for those who cannot see it.
    """

    title: str
    x: Axis
    y: Axis
    series: tuple[Series, ...]
    guide: tuple[float, str] | None = None
    marks: tuple[tuple[str, float, str], ...] = ()
    front: bool = False
    summary: str = ""
