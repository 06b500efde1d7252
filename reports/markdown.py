"""`report.md`: the report as GitHub-flavoured Markdown, laid out to be read in a terminal as well."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from html import escape as html_escape

from oracles.outcome import Run
from reports import text
from reports.content import LONGEST_SCRIPT, MOST_SCRIPTS, TITLE, WORDS, Content, Group, content
from reports.findings import BucketView
from reports.proofs import Proof
from reports.tables import LEGEND, Column, Entry, Table

WIDEST = 44
"""Columns up to this wide are padded, so that the source is aligned too."""

SPECIAL = re.compile(r"[\\`*\[\]<>|~&#]|(?<![A-Za-z0-9])_|_(?![A-Za-z0-9])")
"""What Markdown or HTML would read as markup anywhere in a line; an underscore within a word is none."""

LEADING = re.compile(r"^(?:[-+=](?!\d)|\d+[.)](?=\s|$))")
"""What would make a list, a rule or a heading of a line that starts with it."""


def render(run: Run) -> str:
    """Return the report as Markdown."""
    return "\n".join(_lines(content(run))) + "\n"


def escape(line: str) -> str:
    """Markdown that shows this line as it is, in running text and in the cells of a table."""
    escaped = SPECIAL.sub(lambda found: "\\" + found[0], " ".join(line.split("\n")).strip())
    return LEADING.sub(lambda found: found[0][:-1] + "\\" + found[0][-1], escaped)


def fenced(code: str, language: str = "") -> list[str]:
    """Return a code block whose fence is longer than any run of backticks within it."""
    longest = max((len(run) for run in re.findall(r"`+", code)), default=0)
    fence = "`" * max(3, longest + 1)
    return [fence + language, code.rstrip("\n"), fence]


def table_lines(table: Table) -> list[str]:
    """Return the table in Markdown; an entry's note stands in brackets behind it."""
    names = [escape(f"{c.group} {c.title}".strip()) for c in table.columns]
    rows = [[_entry(entry) for entry in row] for row in table.rows]
    widths = [min(WIDEST, max(3, *map(len, column))) for column in zip(names, *rows, strict=True)]
    rule = ["-" * (w - 1) + ":" if c.numeric else "-" * w for c, w in zip(table.columns, widths, strict=True)]
    return [_row(cells, widths, table.columns) for cells in (names, rule, *rows)]


def _entry(entry: Entry) -> str:
    return escape(f"{entry.text} ({entry.note})" if entry.note else entry.text)


def _row(cells: Iterable[str], widths: list[int], columns: tuple[Column, ...]) -> str:
    padded = (c.rjust(w) if col.numeric else c.ljust(w) for c, w, col in zip(cells, widths, columns, strict=True))
    return f"| {' | '.join(padded)} |"


def _lines(report: Content) -> Iterator[str]:
    yield from (f"# {TITLE}", "", escape(report.headline), "")
    for warning in report.warnings:
        yield f"> **{escape(warning)}**"
        yield ">"
    yield from ("", "## What ran", "", *_facts(report.ran), "", *table_lines(report.summary), "")
    yield from ("## Matrix", "")
    for overview in report.overviews:
        yield from (f"{escape(overview.caption)}:", "", *table_lines(overview), "")
    yield from (f"- `{example}`: {escape(meaning)}" for _, example, meaning in LEGEND)
    for matrix in report.matrices:
        yield from ("", *folded(matrix.caption, table_lines(matrix)))
    yield from ("## Findings", "")
    yield from (*table_lines(report.index), "") if report.groups else ("None.", "")
    for group in report.groups:
        yield from _group(group)
    yield from ("## Ledger", "", *(table_lines(report.ledger) if report.ledger.rows else ("No entries.",)), "")
    yield from ("## Regimes and coverage", "", *table_lines(report.regimes), "")
    for coverage in report.coverage:
        yield from folded(coverage.caption, table_lines(coverage))
    if report.relations.rows:
        yield from ("## Relations", "", *table_lines(report.relations), "")
    yield from ("## Support", "")
    yield from table_lines(report.support) if report.support.rows else ("Every cell is native in every engine.",)
    yield from ("", "## Time", "", *table_lines(report.timing), "")
    yield from ("## Words", "", *_facts(WORDS))


def _facts(pairs: Iterable[tuple[str, str]]) -> list[str]:
    return [f"- {escape(label)}: {escape(value)}" for label, value in pairs]


def folded(summary: str, lines: Iterable[str]) -> list[str]:
    """Return lines that a reader unfolds, below a heading."""
    # a summary stands in raw HTML, where Markdown's escapes mean nothing
    return ["<details>", f"<summary>{html_escape(summary)}</summary>", "", *lines, "", "</details>", ""]


def _group(group: Group) -> Iterator[str]:
    yield from (f"### {escape(group.heading)}", "")
    if group.support:
        yield from (escape(group.support), "")
    for bucket in group.buckets:
        yield from _bucket(bucket)


def _bucket(bucket: BucketView) -> Iterator[str]:
    yield from (f"#### {bucket.number}\\. {escape(bucket.title)}", "", escape(bucket.story), "")
    yield from (*_facts(bucket.facts), "", *_scene(bucket.scene), "")
    yield from (*table_lines(bucket.answers), "")
    if bucket.error:
        yield from ("The engine's last words:", "", *fenced(bucket.error), "")
    if bucket.about:
        yield from ("Refuted on these two, to which the answer leads:", "", *_scene(bucket.about), "")
    if bucket.proof:
        yield from folded(f"Certificate: {bucket.proof.interval}", _proof(bucket.proof))
    if bucket.repro and bucket.number > MOST_SCRIPTS:
        yield from (f"Script that shows it: {escape(bucket.file)}", "")
    elif bucket.repro:
        yield from folded(
            f"Script that shows it: {bucket.file}", fenced(text.block(bucket.repro, LONGEST_SCRIPT), "python")
        )


def _scene(proxies: Iterable[tuple[str, str]]) -> list[str]:
    return fenced("\n".join(f"{label} = {proxy}" for label, proxy in proxies), "python")


def _proof(proof: Proof) -> Iterator[str]:
    yield from (f"- {escape(claim)}" for claim in proof.claims)
    yield from ("", *(fenced(proof.data, "json") if proof.whole else [escape(proof.data)]))
