"""Markdown summary: verdict table, findings and reproduce lines, below the limit of a job summary."""

from __future__ import annotations

import re

from comparisons.cell import Campaign
from comparisons.frontier import TARGETS
from comparisons.regression import changes
from reports.card import at_stake
from reports.findings import findings
from reports.frontier import ADVISED, BADGE, BUDGETS, accuracy, advice_text, share_text, target_text
from reports.ladders import climbs
from reports.matrix import Entry, matrix
from reports.numbers import count, short, with_unit
from reports.regressions import chapters
from reports.regressions import lead_sentence as baseline_sentence
from reports.standing import groups, lead_sentence
from reports.suite import suite_of
from reports.verdict import LEGEND, RED, case_name, totals

ACCURACY = (
    "CPU milliseconds per simulated second to come down to a relative place error (how far any point of a body is "
    "from its true place, over the length of the motion), between measured settings, never extrapolated. Times are "
    f"of one machine: read ratios. {BADGE}: disturbed timing. Advice is for an error of {target_text(ADVISED)}."
)
LIMIT = 1_000_000  # bytes; GitHub cuts a job summary off at 1 MiB


def markdown(campaign: Campaign, limit: int = LIMIT) -> str:
    """Summary of the campaign as GitHub-flavoured Markdown of at most `limit` bytes.

    Steps on a ladder are no verdicts: of them the frontiers are told.  What does not fit is left out line by
    line from the end of the longest parts, and the text says what and how much.
    """
    suite = suite_of(campaign)
    judged = bool(suite.cells) or not campaign.ladders
    head = [f"# {plain(campaign.title or campaign.id)}", "", *(_verdicts(suite) if judged else [])]
    parts = [
        ("changes against the baseline", _baseline(suite)),
        ("verdict rows", _table(suite) if judged else []),
        ("ladders", _ladders(campaign)),
        ("accuracy against time", _accuracy(campaign)),
        ("read-back cards", _card(suite)),
        ("findings", _findings(suite)),
        ("reproduce lines", _reproduce(suite)),
    ]
    room = limit - _size(head) - 400  # what is left out is told in at most this many bytes
    told = []
    text = head
    for noun, lines in parts:
        kept = _fitting(lines, room)
        room -= sum(_size([line]) for line in kept)
        text += kept
        if len(kept) < len(lines):
            if noun == "reproduce lines" and kept:
                text.append("```")
            told.append(f"{len(lines) - len(kept)} of {len(lines)} lines of {noun}")
    if told:
        text += [
            "",
            f"**Cut to {limit} bytes: left out {', '.join(told)}. The page and the CSV files hold everything.**",
        ]
    return "\n".join(text) + "\n"


def _fitting(lines: list[str], room: int) -> list[str]:
    kept = []
    for line in lines:
        room -= _size([line])
        if room < 0:
            break
        kept.append(line)
    return kept


def _size(lines: list[str]) -> int:
    return sum(len(line.encode("utf-8", "replace")) + 1 for line in lines)


def _verdicts(campaign: Campaign) -> list[str]:
    """What happened, in sentences, and the signs of the table."""
    labels = len({c.scenario for c in campaign.cells})
    lines = []
    sections = groups(campaign)
    for group in sections:
        name = f"**{group.title}.** " if len(sections) > 1 else ""
        lines += [f"{name}{plain(lead_sentence(group, labels))}", ""]
    legend = " · ".join(f"{glyph} {word}: {meaning}" for glyph, word, meaning in LEGEND)
    return [*lines, f"{totals(campaign)}.", "", f"{legend}. The number is error / tolerance: above 1 fails.", ""]


def _table(campaign: Campaign) -> list[str]:
    shown = matrix(campaign)
    lines = ["| scenario | decides | " + " | ".join(plain(e) for e in shown.engines) + " |"]
    lines.append("|---|---|" + "---|" * len(shown.engines))
    for row in shown.rows:
        entries = " | ".join(_entry(e) for e in row.entries)
        lines.append(f"| {plain(row.scenario)} | {plain(row.decides)} | {entries} |")
    lines.append("")
    lines += [f"{n}. {plain(text)}" for n, text in enumerate(shown.footnotes, 1)]
    return [*lines, ""]


def _entry(entry: Entry | None) -> str:
    if entry is None:
        return ""
    note = f" [{entry.note}]" if entry.note else ""
    return f"{entry.mark.glyph} {entry.mark.word} {plain(entry.ratio)}".rstrip() + note


def _baseline(campaign: Campaign) -> list[str]:
    """What is not identical to the baseline, where there is one."""
    found = changes(campaign)
    if not found:
        return []
    lines = ["## Against the baseline", "", plain(baseline_sentence(campaign, found)), ""]
    for chapter in chapters(campaign, found):
        lines += [f"### {chapter.mark.glyph} {chapter.mark.word} ({count(len(chapter.lines), 'cell')})", ""]
        lines += [f"- **{plain(n.engine)}** on {plain(n.scenario)}: {plain(n.sentence)}" for n in chapter.lines]
        lines.append("")
    return lines


def _ladders(campaign: Campaign) -> list[str]:
    """How far each engine got on each ladder, and how it broke."""
    if not campaign.ladders:
        return []
    head, rows = ["ladder", "engine", "holds to", "breaks at", "how"], []
    for c in climbs(campaign):
        ends = ("–" if rung is None else with_unit(rung, c.unit) for rung in (c.frontier.good, c.frontier.bad))
        rows.append([c.ladder, c.engine, *ends, c.word])
    return ["## Ladders", "", *_rows(head, rows)]


def _accuracy(campaign: Campaign) -> list[str]:
    """Shares, time to reach each error, and advice, of a campaign that swept knobs."""
    told = accuracy(campaign)
    if not told.sections:
        return []
    lines = ["## What accuracy costs in time", "", ACCURACY, ""]
    head = ["share reached within", *(f"{short(b)} ms/s" for b in BUDGETS), "refused", "not run to the end"]
    shares = [[s.engine, *(share_text(s, b) for b in BUDGETS), str(s.refused), str(s.unfinished)] for s in told.shares]
    lines += _rows(head, shares)
    for section in told.sections:
        rows = [[r.engine, *(f"{e.glyph} {e.text}" for e in r.entries), r.order,
                 "; ".join(filter(None, (r.alarm, r.failures)))] for r in section.rows]  # fmt: skip
        lines += [f"### {plain(section.scenario)}", ""]
        lines += _rows(["engine", *(target_text(t) for t in TARGETS), "order", "alarms"], rows)
        lines += [f"{plain(' '.join(advice_text(section.advice)))}", ""]
    return lines


def _rows(head: list[str], rows: list[list[str]]) -> list[str]:
    """A Markdown table."""
    told = ["| " + " | ".join(plain(text) for text in row) + " |" for row in (head, *rows)]
    return [told[0], "|" + "---|" * len(head), *told[1:], ""]


def _card(campaign: Campaign) -> list[str]:
    """What engines got otherwise than asked."""
    rows = [f"- **{plain(engine)}**: {plain('; '.join(told))}" for engine, told in at_stake(campaign).items()]
    return ["## Read back otherwise than asked", "", *rows, ""] if rows else []


def _findings(campaign: Campaign) -> list[str]:
    lines = []
    for chapter in findings(campaign):
        lines += [f"## {chapter.glyph} {chapter.title} ({count(chapter.amount, 'cell')})", ""]
        for engine, own in chapter.by_engine:
            for finding in own:
                where = ", ".join(plain(c.scenario) for c, _ in finding.cells)
                lines.append(f"- **{plain(engine)}** on {where}: {plain(finding.reason)}")
        lines.append("")
    return lines


def _reproduce(campaign: Campaign) -> list[str]:
    cells = [c for c in campaign.cells if c.state in RED and c.reproduce]
    if not cells:
        return []
    lines = [f"# {case_name(c)} on {c.scenario}: {c.state}\n{c.reproduce}" for c in cells]
    return ["## Reproduce", "", "```sh", *(line.replace("`", "'") for line in lines), "```"]


def plain(text: str) -> str:
    """`text` as Markdown that shows it as it is: on one line, without links, tables or HTML of its own."""
    flat = re.sub(r"\s+", " ", text).strip()
    return re.sub(r"([\\`*_\[\]<>|#~&])", r"\\\1", flat)
