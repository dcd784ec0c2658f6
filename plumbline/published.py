"""Published figures: run the scenes they were published for, and print published, ours and the ratio."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from adapters import registry
from comparisons.cell import Cell
from comparisons.published import Figure, compare, figures
from plumbline.plan import Job, plan
from plumbline.results import Results
from reports.numbers import unit_text
from scenarios import catalogue

WHOLE = ("ok", "fail", "xfail", "xpass")  # states in which the run came to its end


def chosen(steps: Sequence[float], engines: Sequence[str], scenarios: Sequence[str]) -> tuple[Figure, ...]:
    """Figures at the steps given (none: those checked by default) of the engines and scenarios selected.

    Raises
    ------
    UnknownName
        For an engine or a scenario that is not there.
    ValueError
        For a step that a scenario does not allow.
    """
    names = set(registry.select(engines))
    families = {s.family for selector in scenarios for s in catalogue.find(selector)}
    found = figures(tuple(steps) or None)
    return tuple(f for f in found if f.engine in names and (not scenarios or f.scenario.partition("[")[0] in families))


def jobs(wanted: Sequence[Figure]) -> list[Job]:
    """The job that answers each figure, in their order; figures of one run share theirs."""
    made: dict[tuple[str, str, str], Job] = {}
    answers = []
    for figure in wanted:
        place = (figure.scenario, figure.engine, repr(sorted(figure.settings.items())))
        if place not in made:
            scenario = next(s for s in catalogue.find(figure.scenario) if s.name == figure.scenario)
            (made[place],) = plan((scenario,), (figure.engine,), figure.settings)
        answers.append(made[place])
    return answers


def rows(wanted: Sequence[Figure], results: Results) -> list[dict[str, Any]]:
    """One row per figure: what was published, what we measure, whether they agree (None: nothing to compare)."""
    cells = {cell.key: cell for cell in results.cells}
    return [_row(figure, cells[job.key]) for figure, job in zip(wanted, jobs(wanted), strict=True)]


def _row(figure: Figure, cell: Cell) -> dict[str, Any]:
    measured = cell.of(figure.quantity) if cell.state in WHOLE else None
    value = measured.value if measured and math.isfinite(measured.value) else None
    said = compare(figure, value) if value is not None else None
    return {
        "scenario": figure.scenario,
        "engine": figure.engine,
        "settings": dict(figure.settings),
        "quantity": figure.quantity,
        "unit": measured.unit if measured else "",
        "published": figure.published,
        "published_for": figure.published_for,
        "digits": figure.digits,
        "ours": value,
        "ratio": said.ratio if said and said.agrees is not None else None,
        "agrees": said.agrees if said else None,
        "theory": figure.theory,
        "source": figure.source,
        "missing": "" if value is not None else cell.reason or "not measured",
    }


def exit_code(found: Sequence[dict[str, Any]], results: Results) -> int:
    """As of the run, where only a figure that does not agree is a finding."""
    code = results.exit_code(fail_on=("error", "crash", "timeout", "oom", "diverged"))
    if code in (3, 4, 5):
        return code
    return 1 if any(row["agrees"] is False or row["missing"] for row in found) else 0


def show(found: Sequence[dict[str, Any]], console: Any) -> None:
    """Print the figures."""
    from rich.table import Table
    from rich.text import Text

    table = Table(box=None, pad_edge=False, header_style="bold")
    for name in ("scene", "quantity", "published for", "ours in"):
        table.add_column(name, overflow="fold")
    for name in ("published", "ours", "ratio"):
        table.add_column(name, justify="right", no_wrap=True)
    table.add_column("agrees")
    for row in found:
        knobs = ", ".join(f"{v:g}" if isinstance(v, float) else str(v) for k, v in row["settings"].items() if k != "dt")
        engine = row["engine"] + (f" ({knobs})" if knobs else "")
        quantity = f"{row['quantity']} [{unit_text(row['unit'])}]" if unit_text(row["unit"]) else row["quantity"]
        scene = f"{row['scenario'].partition('[')[0]}, {row['settings']['dt'] * 1e3:g} ms"
        numbers = [_number(row[name]) for name in ("published", "ours", "ratio")]
        verdict = Text(_agreement(row), style="bold red" if row["agrees"] is False else "")
        table.add_row(scene, quantity, row["published_for"], engine, *numbers, verdict)
    console.print(table)
    for source in dict.fromkeys(row["source"] for row in found):
        console.print(Text(source, style="dim"))
    compared = [row for row in found if row["agrees"] is not None]
    console.print(f"{sum(row['agrees'] for row in compared)} of {len(compared)} published figures agree")


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.6g}"


def _agreement(row: dict[str, Any]) -> str:
    if row["missing"]:
        return f"✕ {row['missing']}"
    if row["agrees"] is None:
        return "nothing published at this step"
    return f"✓ {row['digits']} digits" if row["agrees"] else f"✕ not to {row['digits']} digits"
