"""Energy, momentum and restitution of every engine side by side, as a table in every format.

For reading (terminal, Markdown, LaTeX) with three digits and a mark where a tolerance is exceeded; for machines
(pandas, CSV, Parquet) with every digit.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from comparisons.cell import Campaign
from reports.balance import SUBJECTS, balance
from reports.markdown import plain
from reports.verdict import chosen, engines, scenarios

if TYPE_CHECKING:
    import pandas as pd
    from rich.table import Table

USUAL = ("energy", "momentum", "restitution")
BROKEN = "✕"
HEAD = ("scenario", "quantity", "unit")
SUFFIXES = {".md": "markdown", ".csv": "csv", ".parquet": "parquet", ".tex": "latex"}
SUPERSCRIPTS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
ESCAPES = {"\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}",
           **{sign: f"\\{sign}" for sign in "&%$#_{}"}}  # fmt: skip


def checked(subjects: Sequence[str]) -> tuple[str, ...]:
    """`subjects`, or the usual ones if there are none.

    Raises
    ------
    ValueError
        For a subject that is none; names those there are.
    """
    for subject in subjects:
        if subject not in SUBJECTS:
            raise ValueError(f"there is no table of {subject!r}; there are: {', '.join(SUBJECTS)}")
    return tuple(subjects) or USUAL


def frame(campaign: Campaign, subjects: Sequence[str] = USUAL) -> pd.DataFrame:
    """One row for each scenario and quantity, one column of numbers for each engine.

    Columns are `scenario`, `quantity`, `unit`, `tolerance` (NaN if nothing is demanded) and the engines; NaN where an
    engine was not measured.
    """
    import pandas as pd

    table, order = chosen(campaign), engines(campaign)
    rows = []
    for scenario in scenarios(campaign):
        cells = {engine: table.get((scenario, engine)) for engine in order}
        found = {engine: {m.quantity: m for m in cell.measurements} for engine, cell in cells.items() if cell}
        names = dict.fromkeys(name for own in found.values() for name in own)
        for name in dict.fromkeys(n for subject in checked(subjects) for n in names if subject in n.lower()):
            told = [own[name] for own in found.values() if name in own]
            limit = next((m.tolerance for m in told if not math.isnan(m.tolerance)), math.nan)
            values = {e: own[name].value if name in own else math.nan for e, own in found.items()}
            rows.append({"scenario": scenario, "quantity": name, "unit": told[0].unit, "tolerance": limit} | values)
    return pd.DataFrame(rows, columns=[*HEAD, "tolerance", *order])


def rows(campaign: Campaign, subjects: Sequence[str], asked: Mapping[str, float] | None) -> Iterator[tuple[str, ...]]:
    """Scenario, quantity, unit and one text for each engine, marked where a tolerance is exceeded."""
    for section in balance(campaign, asked, checked(subjects)):
        for line in section.lines:
            values = (
                f"{value} {BROKEN}" if bad else value for value, bad in zip(line.values, line.broken, strict=True)
            )
            yield section.scenario, line.quantity, line.unit, *values


def terminal(campaign: Campaign, subjects: Sequence[str] = USUAL, asked: Mapping[str, float] | None = None) -> Table:
    """The table for a console."""
    from rich.table import Table
    from rich.text import Text

    table = Table(box=None, pad_edge=False, header_style="bold", caption=f"{BROKEN} beyond tolerance")
    for name in (*HEAD, *engines(campaign)):
        table.add_column(Text(name.replace(":", "\n")), justify="left" if name in HEAD else "right")
    last = ""
    for scenario, *texts in rows(campaign, subjects, asked):
        table.add_row(*map(Text, ("" if scenario == last else scenario, *texts)))
        last = scenario
    return table


def markdown(campaign: Campaign, subjects: Sequence[str] = USUAL, asked: Mapping[str, float] | None = None) -> str:
    """The table as GitHub-flavoured Markdown."""
    order = engines(campaign)
    lines = ["| " + " | ".join(map(plain, (*HEAD, *order))) + " |", "|---|---|---|" + "---:|" * len(order)]
    lines += ["| " + " | ".join(map(plain, row)) + " |" for row in rows(campaign, subjects, asked)]
    return "\n".join([*lines, "", f"{BROKEN} beyond tolerance"]) + "\n"


def latex(campaign: Campaign, subjects: Sequence[str] = USUAL, asked: Mapping[str, float] | None = None) -> str:
    """The table as a LaTeX `longtable`, the only package it needs; a value beyond its tolerance is underlined."""
    order = engines(campaign)
    head = " & ".join(map(_escaped, (*HEAD, *order))) + r" \\ \hline"
    lines = [r"\begin{longtable}{lll" + "r" * len(order) + "}", head, r"\endhead"]
    for row in rows(campaign, subjects, asked):
        cells = [*map(_escaped, row[:2]), _number(row[2]), *map(_number, row[3:])]
        lines.append(" & ".join(cells) + r" \\")
    return "\n".join([*lines, r"\end{longtable}"]) + "\n"


def write(campaign: Campaign, subjects: Sequence[str], path: Path, asked: Mapping[str, float] | None = None) -> Path:
    """Write the table in the format that the name of the file ends in, one of `SUFFIXES`.

    Raises
    ------
    ValueError
        For another ending.
    OSError
        If it cannot be written.
    """
    kind = SUFFIXES.get(path.suffix)
    if kind == "csv":
        frame(campaign, subjects).to_csv(path, index=False, lineterminator="\n")
    elif kind == "parquet":
        frame(campaign, subjects).to_parquet(path, compression="zstd", index=False)
    elif kind is not None:
        text = markdown(campaign, subjects, asked) if kind == "markdown" else latex(campaign, subjects, asked)
        path.write_text(text, encoding="utf-8", errors="replace")
    else:
        raise ValueError(f"{path}: there is no table of that kind; a name ends in {', '.join(SUFFIXES)}")
    return path


def _number(text: str) -> str:
    """A number or unit as people read it, in LaTeX: "2.1×10⁻³" as $2.1\\cdot10^{-3}$, "kg m²" upright."""
    bare = text.removesuffix(BROKEN).strip()
    made = re.sub("×10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)", lambda m: rf"\cdot10^{{{m[1].translate(SUPERSCRIPTS)}}}", bare)
    made = re.sub("([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)", lambda m: f"^{{{m[1].translate(SUPERSCRIPTS)}}}", made)
    made = made.replace("−", "-").replace("∞", r"\infty")
    if made == bare and not re.fullmatch(r"[-\d.]*", bare):
        made = _escaped(bare)
    elif made:
        upright = made.replace(" ", r"\,")
        made = f"${made}$" if made[0] in "-\\" or made[0].isdigit() else rf"$\mathrm{{{upright}}}$"
    return rf"\underline{{{made}}}" if text.endswith(BROKEN) else made


def _escaped(text: str) -> str:
    return "".join(ESCAPES.get(sign, sign) for sign in text)
