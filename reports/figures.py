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
    label : str
        Direct label; "" is the engine's name.
    """

    engine: str
    x: Sequence[float]
    y: Sequence[float]
    joined: bool = False
    marked: bool = True
    tips: Sequence[str] = ()
    label: str = ""


@dataclass(frozen=True)
class Figure:
    """A figure.

    Attributes
    ----------
    title, x, y, series
    guide : (value of y, label) or None
        A horizontal line of reference; what lies below is shaded as good.
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
    front: bool = False
    summary: str = ""


def front(points: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """Points that no other equals or betters in both x and y, from left to right."""
    kept: list[tuple[float, float]] = []
    for x, y in sorted(points):
        if not kept or y < kept[-1][1]:
            kept.append((x, y))
    return kept
