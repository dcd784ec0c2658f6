"""Colours, markers and dashes: the one place where an engine gets its looks, for ever.

An engine's colour depends on its name only, never on its place in a list.  Profiles share the hue
of their engine and differ by the filling of the marker and by the dash.  Verdict tints are a separate system:
they never use an engine's hue, and no verdict is told by colour alone.
"""

from __future__ import annotations

import colorsys
import re
from dataclasses import dataclass
from functools import cache
from hashlib import blake2b

THEMES: dict[str, dict[str, str]] = {
    "light": {
        "paper": "#ffffff",
        "panel": "#f5f6f8",
        "ink": "#15181c",
        "muted": "#555d67",
        "rule": "#d8dce2",
        "strong-rule": "#747c87",
        "link": "#0b4f94",
        "pass-bg": "#ebeff5",
        "pass-ink": "#26374a",
        "fail-bg": "#f7d9d4",
        "fail-ink": "#85140a",
        "broke-bg": "#85140a",
        "broke-ink": "#ffffff",
        "known-bg": "#f5e8c0",
        "known-ink": "#614700",
        "none-bg": "#ffffff",
        "none-ink": "#555d67",
    },
    "dark": {
        "paper": "#0f1217",
        "panel": "#171c23",
        "ink": "#e7eaee",
        "muted": "#a0a9b5",
        "rule": "#2b323b",
        "strong-rule": "#7d8794",
        "link": "#8cc2ff",
        "pass-bg": "#1b2531",
        "pass-ink": "#c6d3e2",
        "fail-bg": "#4b1b16",
        "fail-ink": "#ffbdb2",
        "broke-bg": "#ffb3a6",
        "broke-ink": "#3d0b05",
        "known-bg": "#3b3011",
        "known-ink": "#f1d891",
        "none-bg": "#0f1217",
        "none-ink": "#a0a9b5",
    },
}
TONES = ("pass", "fail", "broke", "known", "none")

# light, dark, marker, dash; contrast at least 5:1 on the page in both themes, apart for the colour-blind
HOUSE = {
    "reference": ("#000000", "#ffffff", "cross", ""),
    "mujoco": ("#0072b2", "#56b4e9", "circle", ""),
    "pybullet": ("#b84a00", "#f0a04b", "square", "7 3"),
    "pymunk": ("#007f5f", "#2bc79b", "triangle", "2 3"),
}
GUEST_MARKERS = ("diamond", "triangle-down", "pentagon", "star", "hexagon")
GUEST_DASHES = ("9 3 2 3", "5 2", "1 2", "9 2 2 2 2 2", "12 4")

DASHES = {"solid": "", "hollow": "4 2", "dotted": "8 2 2 2"}  # of profiles; a fair profile has its engine's

# outlines about the origin, within the circle of radius 1
MARKERS = {
    "cross": "M-.9-.9.9.9M-.9.9.9-.9",
    "circle": "M-1 0A1 1 0 1 0 1 0A1 1 0 1 0-1 0Z",
    "square": "M-.88-.88H.88V.88H-.88Z",
    "triangle": "M0-1.1L1 .75H-1Z",
    "diamond": "M0-1.2L1.1 0L0 1.2L-1.1 0Z",
    "triangle-down": "M0 1.1L1-.75H-1Z",
    "pentagon": "M0-1.1L1.05-.34L.65.89H-.65L-1.05-.34Z",
    "star": "M0-1.25L.35-.4L1.2-.38L.55.18L.78 1.05L0 .55L-.78 1.05L-.55.18L-1.2-.38L-.35-.4Z",
    "hexagon": "M1.05 0L.53.91H-.53L-1.05 0L-.53-.91H.53Z",
}


@dataclass(frozen=True)
class Look:
    """How an engine is drawn.

    Attributes
    ----------
    light, dark : str
        Colour "#rrggbb" on the light and the dark page.
    marker : str
        A key of `MARKERS`.
    fill : str
        How the marker is filled: "solid" for the fair profile, "hollow" for stock, "dotted" (an outline with a
        point in it) for every other profile.
    dash : str
        SVG stroke-dasharray; "" is solid.
    """

    light: str
    dark: str
    marker: str
    fill: str
    dash: str


def base(engine: str) -> str:
    """Name of the engine without its profile."""
    return engine.partition(":")[0]


def profile(engine: str) -> str:
    """Profile of the engine; "" is the fair one."""
    return engine.partition(":")[2]


def slug(engine: str) -> str:
    """Name as a CSS class or fragment: letters, digits and hyphens; different names give different slugs."""
    plain = re.sub(r"[^a-z0-9]+", "-", engine.lower().replace(":", "--")).strip("-")
    if re.fullmatch(r"[a-z][a-z0-9]*(:[a-z][a-z0-9]*)?", engine):
        return engine.replace(":", "-")
    return f"{plain or 'x'}-{blake2b(engine.encode('utf-8', 'replace'), digest_size=3).hexdigest()}"


@cache
def look(engine: str) -> Look:
    """Looks of an engine, a function of its name only."""
    name, variant = base(engine), profile(engine)
    light, dark, marker, dash = HOUSE.get(name) or _guest(name)
    fill = {"": "solid", "stock": "hollow"}.get(variant, "dotted")
    return Look(light, dark, marker, fill, DASHES[fill] or dash)


def _guest(name: str) -> tuple[str, str, str, str]:
    """Looks of an engine the house does not know: hue, marker and dash from a hash of its name."""
    digest = blake2b(name.encode("utf-8", "replace"), digest_size=4).digest()
    hue = int.from_bytes(digest[:2], "big") / 65536.0
    light = _reaching(hue, THEMES["light"]["panel"], darker=True)
    dark = _reaching(hue, THEMES["dark"]["panel"], darker=False)
    return light, dark, GUEST_MARKERS[digest[2] % len(GUEST_MARKERS)], GUEST_DASHES[digest[3] % len(GUEST_DASHES)]


def _reaching(hue: float, background: str, darker: bool) -> str:
    """The most vivid shade of `hue` with a contrast of at least 5.2:1 on `background`."""
    shades = [k / 100.0 for k in range(5, 96)]
    for lightness in reversed(shades) if darker else shades:
        red, green, blue = colorsys.hls_to_rgb(hue, lightness, 0.75)
        colour = f"#{round(red * 255):02x}{round(green * 255):02x}{round(blue * 255):02x}"
        if contrast(colour, background) >= 5.2:
            return colour
    raise AssertionError("black and white reach 5.2:1 on every page colour of the house")


def contrast(a: str, b: str) -> float:
    """Contrast ratio of two colours "#rrggbb", 1 to 21.  WCAG 2.2, success criterion 1.4.3 (W3C, 2023)."""
    light, dark = sorted((_luminance(a), _luminance(b)), reverse=True)
    return (light + 0.05) / (dark + 0.05)


def _luminance(colour: str) -> float:
    channels = [int(colour[k : k + 2], 16) / 255.0 for k in (1, 3, 5)]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in channels]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def css(engines: tuple[str, ...]) -> str:
    """Style sheet of both themes: tokens as custom properties, one class per engine.

    The light theme is the default; the dark one applies where the system asks for it or the page's
    own switch (`data-theme` on the root element) does.  Print is always light.
    """
    light, dark = (_declarations(theme, engines) for theme in ("light", "dark"))
    rules = [
        f":root{{color-scheme:light;{light}}}",
        f'@media screen and (prefers-color-scheme:dark){{:root:not([data-theme="light"]){{color-scheme:dark;{dark}}}}}',
        f'@media screen{{:root[data-theme="dark"]{{color-scheme:dark;{dark}}}}}',
    ]
    for engine in engines:
        name, dash = slug(engine), look(engine).dash
        rules.append(f".eng-{name}{{--c:var(--eng-{name});--dash:{dash.replace(' ', ',') or 'none'}}}")
        rules.append(f".hide-{name} .eng-{name}{{display:none}}")
    return "\n".join(rules)


def _declarations(theme: str, engines: tuple[str, ...]) -> str:
    tokens = {f"--{name}": colour for name, colour in THEMES[theme].items()}
    tokens |= {f"--eng-{slug(e)}": getattr(look(e), theme) for e in engines}
    return "".join(f"{name}:{colour};" for name, colour in tokens.items())
