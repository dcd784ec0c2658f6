"""Numbers and units as people read them."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping

SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def short(value: float, digits: int = 3) -> str:
    """`value` with at most `digits` significant digits: "0.042", "14", "2.1×10⁻¹⁰", "∞", "not a number"."""
    if math.isnan(value):
        return "not a number"
    if math.isinf(value):
        return "∞" if value > 0 else "−∞"
    if value == 0.0:
        return "0"
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    power = int(exponent)
    if -4 < power < 5:
        text = f"{float(f'{mantissa}e{exponent}'):.{max(digits - 1 - power, 0)}f}"
        text = text.rstrip("0").rstrip(".") if "." in text else text
    else:
        mantissa = mantissa.rstrip("0").rstrip(".") if "." in mantissa else mantissa
        text = f"{mantissa}×10{str(power).translate(SUPERSCRIPT)}"
    return text.replace("-", "−")


def power_of_ten(power: int) -> str:
    """Label of a decade: "0.1", "1", "10", "10⁻³"."""
    plain = {-1: "0.1", 0: "1", 1: "10", 2: "100"}
    return plain.get(power, f"10{str(power).translate(SUPERSCRIPT)}")


def with_unit(value: float, unit: str, digits: int = 3) -> str:
    """`value` and its unit; the unit "1" is not written."""
    return f"{short(value, digits)} {unit_text(unit)}".rstrip()


def unit_text(unit: str) -> str:
    """A UCUM unit as printed: "kg.m/s" -> "kg m/s", "m2" -> "m²", "1" -> ""."""
    if unit in ("1", ""):
        return ""
    spaced = unit.replace(".", " ")
    return "".join(
        c.translate(SUPERSCRIPT) if c.isdigit() and k and spaced[k - 1].isalpha() else c for k, c in enumerate(spaced)
    )


def settings_text(settings: Mapping[str, float | str]) -> str:
    """Settings on one line: "dt = 0.001, iterations = 200"."""
    return ", ".join(f"{name} = {value:g}" if isinstance(value, (int, float)) else f"{name} = {value}"
                     for name, value in settings.items())  # fmt: skip


def duration_text(seconds: float) -> str:
    """A time as people say it: "0.4 s", "12 s", "3 min 5 s"."""
    if seconds < 60.0:
        return f"{short(seconds, 2)} s"
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes} min {rest} s" if minutes < 60 else f"{minutes // 60} h {minutes % 60} min"


def rounded(text: str) -> str:
    """`text` with long decimal fractions cut to four significant digits, for reading: "0.30016513" -> "0.3002"."""
    return re.sub(r"-?\d+\.\d{6,}(e[-+]?\d+)?", lambda found: f"{float(found[0]):.4g}", text)


def count(number: int, noun: str) -> str:
    """ "1 cell", "3 cells"."""
    return f"{number} {noun}" + ("" if number == 1 else "s")


def listed(items: list[str], last: str = "and") -> str:
    """ "a", "a and b", "a, b and c"."""
    return items[0] if len(items) == 1 else f"{', '.join(items[:-1])} {last} {items[-1]}" if items else ""
