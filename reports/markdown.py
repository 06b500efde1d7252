"""`report.md`: the report as GitHub-flavoured Markdown, laid out to be read in a terminal as well.

It is cut to what a reader can show, what is new first; it says what it leaves out.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from html import escape as html_escape

from oracles.ledger.states import UNSETTLED
from oracles.outcome import Run, State
from reports import text
from reports.accuracy import NOTE, accuracy
from reports.broad_phase import WHAT
from reports.content import TITLE, WORDS, Content, content
from reports.cutting import Part, fitting, put_together
from reports.findings import BucketView
from reports.proofs import Proof
from reports.surveys import WHAT as SURVEYS
from reports.tables import LEGEND, Column, Entry, Table

LIMIT = 1_000_000
"""Bytes of a report."""

RESERVED = 500
"""Bytes for the sentence on what is left out."""

MOST_NEW = 50
"""Rows of the table of what is new."""

HEAD, NEW, OVERVIEW, KNOWN, NOTES, DETAILS, COVERAGE = range(7)
"""Ranks: what is taken first, where not all can be."""

WIDEST = 44
"""Columns up to this wide are padded, so that the source is aligned too."""

SPECIAL = re.compile(r"[\\`*\[\]<>|~&#]|(?<![A-Za-z0-9])_|_(?![A-Za-z0-9])")
"""What Markdown or HTML would read as markup anywhere in a line; an underscore within a word is none."""

LEADING = re.compile(r"^(?:[-+=](?!\d)|\d+[.)](?=\s|$))")
"""What would make a list, a rule or a heading of a line that starts with it."""


def render(run: Run, limit: int = LIMIT, *, beside: bool = False) -> str:
    """Return the report as Markdown.

    Parameters
    ----------
    limit
        Bytes that it may have; nothing is returned where not even the headline fits.
    beside
        Whether pictures, scripts and issues lie beside it, and may be linked.
    """
    return written(content(run), limit, accuracy(run), beside=beside)


def written(report: Content, limit: int, errors: Sequence[Table] = (), *, beside: bool = False) -> str:
    """Return what a report says as Markdown (see `render`), with tables of errors."""
    parts = list(_parts(report, errors, beside=beside))
    whole = fitting(parts, limit)
    if len(whole) < len(parts):
        taken = fitting(parts, limit - RESERVED)
        if not taken or taken[0] is not parts[0]:
            return ""
        whole = [taken[0], Part(tuple(_left_out(report, parts, taken)), HEAD), *taken[1:]]
    return "\n".join(put_together(whole)) + "\n"


def _left_out(report: Content, parts: list[Part], taken: list[Part]) -> Iterator[str]:
    """What a cut report leaves out, in a sentence."""
    kept = set(map(id, taken))
    gone = [part for part in parts if id(part) not in kept]
    findings, every = sum(part.series for part in gone), sum(len(group.buckets) for group in report.groups)
    said = [f"{findings} of {every} findings"] * bool(findings)
    said += dict.fromkeys(part.name for part in gone if part.name)
    yield f"> **Left out, to be short: {'; '.join(said)}.** The run's folder has the whole: index.html and report.json."
    yield ""


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


def _parts(report: Content, errors: Sequence[Table], *, beside: bool) -> Iterator[Part]:
    """The report in its order, with what matters most ranked first."""

    def section(heading: str, rank: int, name: str, *lines: str) -> Part:
        return Part((*lines, ""), rank, (f"## {heading}",), name=name)

    yield Part(tuple(_head(report)), HEAD)
    for lines in _news(report):
        yield section("New", HEAD, "what is new", *lines)
    yield section("What ran", HEAD, "what ran", *_facts(report.ran), "", *table_lines(report.summary))
    for overview in report.overviews:
        yield section("Matrix", OVERVIEW, "the matrix", f"{escape(overview.caption)}:", "", *table_lines(overview))
    legend = (f"- `{example}`: {escape(meaning)}" for _, example, meaning in LEGEND)
    yield section("Matrix", OVERVIEW, "the matrix", *legend)
    for matrix in report.matrices:
        yield section("Matrix", KNOWN, "the matrix pair by pair", *folded(matrix.caption, table_lines(matrix)))
    yield from _accuracy(errors)
    found = table_lines(report.index) if report.groups else ["None."]
    yield section("Findings", KNOWN, "the list of findings", *found)
    yield from _details(report, beside=beside)
    ledger = table_lines(report.ledger) if report.ledger.rows else ["No entries."]
    yield section("Ledger", KNOWN, "the ledger", *ledger)
    yield section("Regimes", NOTES, "regimes", *table_lines(report.regimes))
    for coverage in report.coverage:
        yield section("Coverage", COVERAGE, "coverage", *folded(coverage.caption, table_lines(coverage)))
    if report.relations.rows:
        yield section("Relations", NOTES, "relations", *table_lines(report.relations))
    for crowds in report.broad_phase:
        lead = [escape(WHAT), ""] if crowds is report.broad_phase[0] else []
        yield section(
            "Broad phase", NOTES, "broad phases", *lead, f"{escape(crowds.caption)}:", "", *table_lines(crowds)
        )
    yield from _surveys(report)
    support = table_lines(report.support) if report.support.rows else ["Every cell is native in every engine."]
    yield section("Support", NOTES, "support", *support)
    yield section("Time", NOTES, "time", *table_lines(report.timing))
    yield section("Words", NOTES, "words", *_facts(WORDS))


def _surveys(report: Content) -> Iterator[Part]:
    """Each subject with its tables, the first of them at a glance and the others to be unfolded."""
    if report.surveys:
        yield Part((escape(SURVEYS), ""), NOTES, ("## Surveys",), name="surveys")
    for part in report.surveys:
        headings = ("## Surveys", f"### {escape(part.title)}")
        first, *others = part.tables
        lines = (escape(part.about), "", f"{escape(first.caption)}:", "", *table_lines(first), "")
        yield Part(lines, NOTES, headings, name="surveys")
        for table in others:
            yield Part(tuple(folded(table.caption, table_lines(table))), NOTES, headings, name="surveys")


def _accuracy(tables: Sequence[Table]) -> Iterator[Part]:
    """Tables of errors: the first, by query, at a glance, and the others to be unfolded."""
    headings, name = ("## Accuracy",), "accuracy"
    for table in tables[:1]:
        yield Part((f"{escape(table.caption)}:", "", *table_lines(table), ""), OVERVIEW, headings, name=name)
        yield Part((escape(NOTE), ""), NOTES, headings, name=name)
    for table in tables[1:]:
        yield Part(tuple(folded(table.caption, table_lines(table))), NOTES, headings, name=name)


def _details(report: Content, *, beside: bool) -> Iterator[Part]:
    """Each finding at length, by cell."""
    for group in report.groups:
        headings = ("## Findings", f"### {escape(group.heading)}")
        support = (escape(group.support), "") if group.support else ()
        for bucket in group.buckets:
            rank = NEW if bucket.state == State.NEW else DETAILS
            lines = (*support, *_bucket(bucket, beside=beside))
            yield Part(lines, rank, headings, series=True)
            support = ()


def _head(report: Content) -> Iterator[str]:
    yield from (f"# {TITLE}", "", escape(report.headline), "")
    for warning in report.warnings:
        yield f"> **{escape(warning)}**"
        yield ">"
    if report.warnings:
        yield ""


def _news(report: Content) -> Iterator[list[str]]:
    """What asks for something to be done: new findings, and entries of the ledger that no longer fit."""
    state = len(report.index.columns) - 1
    rows = [row for row in report.index.rows if row[state].text == State.NEW]
    if rows:
        more = f"And {text.count(len(rows) - MOST_NEW)} more below."
        yield [
            *table_lines(replace(report.index, rows=tuple(rows[:MOST_NEW]))),
            *(["", more] if len(rows) > MOST_NEW else []),
        ]
    entries = [row for row in report.ledger.rows if row[1].text in UNSETTLED]
    if entries:
        yield table_lines(replace(report.ledger, rows=tuple(entries)))


def _facts(pairs: Iterable[tuple[str, str]]) -> list[str]:
    return [f"- {escape(label)}: {escape(value)}" for label, value in pairs]


def folded(summary: str, lines: Iterable[str]) -> list[str]:
    """Return lines that a reader unfolds, below a heading."""
    # a summary stands in raw HTML, where Markdown's escapes mean nothing
    return ["<details>", f"<summary>{html_escape(summary)}</summary>", "", *lines, "", "</details>", ""]


def _bucket(bucket: BucketView, *, beside: bool) -> Iterator[str]:
    yield from (f"#### {bucket.number}\\. {escape(bucket.title)}", "", escape(bucket.story), "")
    if beside:
        yield from (f"![The two proxies of finding {bucket.number}]({bucket.picture})", "")
    yield from (*_facts(bucket.facts), *_files(bucket, beside=beside), "", *_scene(bucket.scene), "")
    yield from (*table_lines(bucket.answers), "")
    if bucket.error:
        yield from ("The engine's last words:", "", *fenced(bucket.error), "")
    if bucket.about:
        yield from ("Refuted on these two, to which the answer leads:", "", *_scene(bucket.about), "")
    if bucket.proof:
        yield from folded(f"Certificate: {bucket.proof.interval}", _proof(bucket.proof))


def _files(bucket: BucketView, *, beside: bool) -> Iterator[str]:
    """Where the script and the issue's text lie; their names are letters and digits only."""
    for label, path in (("script that shows it", bucket.file), ("issue for the engine's project", bucket.issue)):
        if bucket.repro or path != bucket.file:
            yield f"- {label}: [{path}]({path})" if beside else f"- {label}: {path}"


def _scene(proxies: Iterable[tuple[str, str]]) -> list[str]:
    return fenced("\n".join(f"{label} = {proxy}" for label, proxy in proxies), "python")


def _proof(proof: Proof) -> Iterator[str]:
    yield from (f"- {escape(claim)}" for claim in proof.claims)
