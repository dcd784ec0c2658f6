"""Figures as SVG: one element per data point, the engine as CSS class.

Colour, theme and the choice of engines are matters of the style sheet around it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from html import escape
from importlib.resources import files

import numpy as np

from comparisons.pareto import FLOOR, front
from reports.figures import Axis, Figure, Series
from reports.numbers import power_of_ten, short
from reports.palette import MARKERS, css, look, slug


@dataclass(frozen=True)
class _Scale:
    """Maps values of an axis to pixels."""

    log: bool
    least: float
    most: float
    start: float
    end: float

    def __call__(self, value: float) -> float:
        return float(self.of(np.array(value)))

    def of(self, values: np.ndarray) -> np.ndarray:
        """Pixels of many values; NaN stays NaN, and what lies beyond the axis is drawn just beyond it."""
        if self.log:
            low, high = math.log10(self.least), math.log10(self.most)
            part = (np.log10(np.maximum(values, self.least)) - low) / (high - low)
        else:
            part = (values - self.least) / (self.most - self.least)
        return np.asarray(self.start + np.clip(part, -0.02, 1.02) * (self.end - self.start))

    def ticks(self, wanted: int) -> list[tuple[float, str]]:
        if self.log:
            low, high = round(math.log10(self.least)), round(math.log10(self.most))
            step = max(1, math.ceil((high - low) / wanted))
            powers = [p for p in range(low, high + 1) if p % step == 0]
            return [(10.0**p, ("≤" if 10.0**p <= FLOOR * 1.01 else "") + power_of_ten(p)) for p in powers]
        step = _nice((self.most - self.least) / wanted)
        first = math.ceil(self.least / step - 1e-9)
        last = math.floor(self.most / step + 1e-9)
        return [(k * step, short(k * step, 4)) for k in range(first, last + 1)]


@dataclass(frozen=True)
class _Frame:
    """The plot's rectangle in a picture of `width` by `height` pixels, and its scales."""

    width: float
    height: float
    x: _Scale
    y: _Scale


LEFT, RIGHT, TOP, BOTTOM = 52.0, 112.0, 10.0, 38.0
CHARACTER, LETTER = 6.2, 6.5  # width of a digit of a tick label and of a letter of a direct label [px]


def svg(figure: Figure, width: float = 400.0, height: float = 236.0, standalone: bool = False) -> str:
    """The figure as SVG text.

    Parameters
    ----------
    standalone : bool
        True: a file of its own, with style sheet and title.  False: for a page that holds both.
    """
    head = 24.0 if standalone else 0.0
    frame = _framed(figure, width, height, head)
    parts = [f"<title>{escape(figure.title)}</title>"]
    if figure.summary:
        parts.append(f"<desc>{escape(figure.summary)}</desc>")
    if standalone:
        engines = tuple(dict.fromkeys(s.engine for s in figure.series if s.engine))
        style = css(engines) + asset("figure.css")
        parts.append(f"<style>{style}</style>")
        parts.append(f'<rect class="paper" width="{width:g}" height="{height:g}"/>')
        parts.append(f'<text class="title" x="{LEFT:g}" y="18">{escape(figure.title)}</text>')
    parts += _grid(figure, frame) + _marks(figure, frame)
    if figure.front:
        parts.append(_front(figure, frame))
    drawn = sorted(figure.series, key=lambda s: bool(s.engine))
    # what is drawn first is drawn broader, so that equal curves show as layers and none hides the others
    breadths = [1.3 + 2.2 * (len(drawn) - 1 - k) / max(len(drawn), 4) for k in range(len(drawn))]
    parts += [_drawn(one, frame, breadth) for one, breadth in zip(drawn, breadths, strict=True)]
    parts += _labels(figure, frame)
    names = ' xmlns="http://www.w3.org/2000/svg"' if standalone else ""
    return (
        f'<svg{names} class="fig" viewBox="0 0 {width:g} {height:g}" role="img" data-span="{_span(frame.x)}" '
        f'aria-label="{escape(figure.summary or figure.title)}">{"".join(parts)}</svg>'
    )


def _span(x: _Scale) -> str:
    """Where the axis of x begins and ends [px], and the values there: what a cursor needs."""
    return f"{x.start:g} {x.end:g} {x.least:.9g} {x.most:.9g}"


def asset(name: str) -> str:
    """Text of a file that is delivered with this package."""
    return (files("reports") / "assets" / name).read_text(encoding="utf-8")


def _framed(figure: Figure, width: float, height: float, head: float) -> _Frame:
    x_values = [x for s in figure.series for x, y in zip(s.x, s.y, strict=True) if not math.isnan(y)]
    y_values = [y for s in figure.series for y in (*s.y, *s.low)]
    if figure.guide:
        y_values.append(figure.guide[0])
    x_least, x_most = _range(figure.x, x_values)
    y_least, y_most = _range(figure.y, y_values)
    y = _Scale(figure.y.log, y_least, y_most, height - BOTTOM, TOP + head)
    left = max(LEFT, 24.0 + CHARACTER * max((len(label) for _, label in y.ticks(5)), default=0))
    right = max(RIGHT, 31.0 + LETTER * max((len(_label(s)) for s in figure.series), default=0))
    return _Frame(width, height, _Scale(figure.x.log, x_least, x_most, left, width - right), y)


def _range(axis: Axis, values: Sequence[float]) -> tuple[float, float]:
    """Limits of an axis: whole decades, at least two, or the data with a margin."""
    if axis.limits:
        return axis.limits
    finite = [v for v in values if math.isfinite(v)]
    if axis.log:
        logs = [math.log10(max(v, FLOOR)) for v in finite] or [0.0]
        low, high = math.floor(min(logs) - 0.05), math.ceil(max(logs) + 0.05)
        low = max(low, round(math.log10(FLOOR)))
        return 10.0**low, 10.0 ** max(high, low + 1)
    least, most = min(finite, default=0.0), max(finite, default=1.0)
    lacking = max(axis.least_span - (most - least), 0.0)
    margin = 0.5 * lacking + 0.05 * (most - least) or 0.5 * abs(most) or 1.0
    return least - margin, most + margin


def _nice(step: float) -> float:
    """The next larger of 1, 2, 5 times a power of ten."""
    power = 10.0 ** math.floor(math.log10(step))
    return next(m * power for m in (1.0, 2.0, 5.0, 10.0) if m * power >= step * (1.0 - 1e-9))


def _grid(figure: Figure, frame: _Frame) -> list[str]:
    x, y = frame.x, frame.y
    parts = []
    if figure.guide:
        level = y(figure.guide[0])
        parts.append(_rect("good", x.start, level, x.end - x.start, y.start - level))
    for value, label in y.ticks(5):
        parts.append(f'<path class="grid" d="M{x.start:g} {y(value):.1f}H{x.end:g}"/>')
        parts.append(
            f'<text class="tick" x="{x.start - 5:g}" y="{y(value) + 3.5:.1f}" text-anchor="end">{label}</text>'
        )
    for value, label in x.ticks(5):
        parts.append(f'<path class="grid" d="M{x(value):.1f} {y.start:g}v4"/>')
        parts.append(f'<text class="tick" x="{x(value):.1f}" y="{y.start + 15:g}" text-anchor="middle">{label}</text>')
    parts.append(f'<path class="axis" d="M{x.start:g} {y.start:g}H{x.end:g}"/>')
    middle = 0.5 * (y.start + y.end)
    parts.append(f'<text class="name" x="{0.5 * (x.start + x.end):.1f}" y="{y.start + 31:g}" text-anchor="middle">'
                 f"{_named(figure.x)}</text>")  # fmt: skip
    parts.append(f'<text class="name" transform="translate(11 {middle:.1f})rotate(-90)" text-anchor="middle">'
                 f"{_named(figure.y)}</text>")  # fmt: skip
    if figure.guide:
        level = y(figure.guide[0])
        parts.append(f'<path class="guide" d="M{x.start:g} {level:.1f}H{x.end:g}"/>')
        parts.append(
            f'<text class="tick over" x="{x.start + 4:g}" y="{level - 4:.1f}">{escape(figure.guide[1])}</text>'
        )
    return parts


def _marks(figure: Figure, frame: _Frame) -> list[str]:
    """Thin lines of reference with their labels, as far as they lie in the plot."""
    x, y, parts = frame.x, frame.y, []
    for axis, value, label in figure.marks:
        scale = x if axis == "x" else y
        if not scale.least <= value <= scale.most:
            continue
        at = scale(value)
        line = f"M{at:.1f} {y.start:g}V{y.end:g}" if axis == "x" else f"M{x.start:g} {at:.1f}H{x.end:g}"
        place = f'x="{at - 3:.1f}" y="{y.end + 9:.1f}"' if axis == "x" else f'x="{x.end - 4:g}" y="{at - 3:.1f}"'
        parts.append(f'<path class="guide" d="{line}"/>')
        parts.append(f'<text class="tick over" {place} text-anchor="end">{escape(label)}</text>')
    return parts


def _named(axis: Axis) -> str:
    return escape(f"{axis.label} ({axis.better})" if axis.better else axis.label)


def _rect(kind: str, x: float, y: float, width: float, height: float) -> str:
    return f'<rect class="{kind}" x="{x:.1f}" y="{y:.1f}" width="{max(width, 0):.1f}" height="{max(height, 0):.1f}"/>'


def _front(figure: Figure, frame: _Frame) -> str:
    points = [
        p for s in figure.series if s.engine for p in zip(s.x, s.y, strict=True) if math.isfinite(p[0] + p[1])
    ]  # fmt: skip
    kept = front(points)
    if not kept:
        return ""
    path = f"M{frame.x(kept[0][0]):.1f} {frame.y.end:.1f}"
    path += "".join(f"H{frame.x(x):.1f}V{frame.y(y):.1f}" for x, y in kept)
    return f'<path class="front" d="{path}H{frame.x.end:.1f}"/>'


def _drawn(one: Series, frame: _Frame, breadth: float) -> str:
    x, y = frame.x.of(np.array(one.x, dtype=np.float64)), frame.y.of(np.array(one.y, dtype=np.float64))
    kind = f"eng-{slug(one.engine)}" if one.engine else "truth"
    dash = look(one.engine).dash if one.engine else ""
    parts = [_band(one, frame)] if one.low else []
    if one.joined:
        dashed = f' stroke-dasharray="{dash}"' if dash else ""
        broad = f' style="stroke-width:{breadth:.1f}"' if one.engine else ""
        parts.append(f'<path class="line" d="{_path(x, y)}"{dashed}{broad}/>')
    if one.marked and one.engine:
        tips = one.tips or [""] * len(x)
        points = zip(x.tolist(), y.tolist(), tips, strict=True)
        parts += [_marker(one.engine, (px, py), tip) for px, py, tip in points if not math.isnan(py)]
    return f'<g class="{kind}">{"".join(parts)}</g>'


def _band(one: Series, frame: _Frame) -> str:
    """Area between the lower ends and the line, where both are known."""
    known = [(x, low, y) for x, low, y in zip(one.x, one.low, one.y, strict=True) if math.isfinite(low + y)]
    upper = [f"{frame.x(x):.1f} {frame.y(y):.1f}" for x, _, y in known]
    lower = [f"{frame.x(x):.1f} {frame.y(low):.1f}" for x, low, _ in reversed(known)]
    return f'<path class="band" d="M{"L".join(upper + lower)}Z"/>' if known else ""


def _path(x: np.ndarray, y: np.ndarray) -> str:
    """Path data through points [px], broken where y is NaN; relative and in tenths of a pixel, to be short."""
    known = ~np.isnan(y)
    edges = np.flatnonzero(np.diff(known, prepend=False, append=False)).reshape(-1, 2)
    return "".join(_stroke(np.rint(10.0 * np.stack([x[a:b], y[a:b]])).astype(int)) for a, b in edges)


def _stroke(points: np.ndarray) -> str:
    """One unbroken piece of a path; points in the middle of a level stretch are left out."""
    level = np.diff(points[1]) == 0
    ahead = np.diff(points[0]) >= 0
    inner = np.flatnonzero(level[:-1] & level[1:] & ahead[:-1] & ahead[1:]) + 1
    kept = np.delete(points, inner, axis=1)
    steps = [
        f"h{_tenths(dx)}" if dy == 0 else f"l{_tenths(dx)} {_tenths(dy)}" for dx, dy in np.diff(kept, axis=1).T.tolist()
    ]
    return f"M{_tenths(int(kept[0, 0]))} {_tenths(int(kept[1, 0]))}" + "".join(steps)


@cache
def _tenths(number: int) -> str:
    return f"{number / 10:g}"


def marker_shape(engine: str, x: float, y: float, size: float = 4.2) -> str:
    """Marker of an engine at a point [px], as an SVG path."""
    style = look(engine)
    kind = style.fill
    if style.marker == "cross":
        kind = "stroke" if style.fill == "solid" else "stroke thin"
    place = f"translate({x:.1f} {y:.1f})scale({size:g})"
    shape = f'<path class="marker {kind}" transform="{place}" d="{MARKERS[style.marker]}"/>'
    dot = f'<circle class="dot" cx="{x:.1f}" cy="{y:.1f}" r="1.3"/>' if style.fill == "dotted" else ""
    return shape + dot


def _marker(engine: str, point: tuple[float, float], tip: str) -> str:
    shape = marker_shape(engine, *point)
    return f"<g>{shape}<title>{escape(tip)}</title></g>" if tip else shape


def _labels(figure: Figure, frame: _Frame) -> list[str]:
    """Names at the right edge, moved apart, each with a hairline to its last point."""
    ends = []
    for one in figure.series:
        known = [(x, y) for x, y in zip(one.x, one.y, strict=True) if not math.isnan(y)]
        if known and one.label is not None:
            ends.append((frame.y(known[-1][1]), frame.x(known[-1][0]), one))
    ends.sort(key=lambda e: (e[0], e[1]))
    places = spread([e[0] for e in ends], 13.0, frame.y.end + 3.0, frame.y.start)
    parts = []
    for place, (y, x, one) in zip(places, ends, strict=True):
        kind = f"eng-{slug(one.engine)}" if one.engine else "truth"
        at = frame.x.end + 14.0
        hairline = f'<path class="leader" d="M{x + 5:.1f} {y:.1f}L{at - 5:.1f} {place:.1f}"/>'
        swatch = f'<path class="line" d="M{at - 2:.1f} {place:.1f}h10"/>'
        shape = marker_shape(one.engine, at + 3.0, place, 3.4) if one.engine else swatch
        name = f'<text class="label" x="{at + 11:.1f}" y="{place + 3.6:.1f}">{escape(_label(one))}</text>'
        parts.append(f'<g class="{kind}">{hairline}{shape}{name}</g>')
    return parts


def _label(one: Series) -> str:
    text = one.label or one.engine.replace(":", " ") or "truth"
    return text if len(text) <= 20 else text[:19] + "…"


def spread(wanted: Sequence[float], apart: float, least: float, most: float) -> list[float]:
    """Places as near to `wanted` (increasing) as it goes while at least `apart` from each other.

    They stay within [least, most] if there is room; if not, they start at `least` and overflow.
    """
    places: list[float] = []
    for want in wanted:
        places.append(max(want, least if not places else places[-1] + apart))
    ceiling = max(most, least + apart * (len(places) - 1))
    for k in range(len(places) - 1, -1, -1):
        places[k] = min(places[k], ceiling)
        ceiling = places[k] - apart
    return places
