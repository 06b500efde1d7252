"""The comparison of two runs as tables and sentences, and from these as Markdown and HTML."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from oracles.outcome import COMPARED
from reports import html, text
from reports.diff import Comparison, Report, Told
from reports.ledger import COLOURS
from reports.markdown import escape, table_lines
from reports.tables import Column, Entry, Table

TITLE = "proxyproof: two runs compared"
RANKS = {"median": "median", "p99": "99th percentile"}
MOST_CELLS = 40
"""Cells that are named one by one where engines answer otherwise."""


@dataclass(frozen=True)
class Part:
    """A heading, and a table below it."""

    heading: str
    table: Table


def headline(found: Comparison) -> str:
    """What changed, in a sentence."""
    worse = sum(change.worse for change in found.changed)
    said = [
        f"{text.plural(len(found.new), 'new finding')}",
        f"{text.count(len(found.gone))} gone",
        f"{text.count(len(found.changed))} changed" + (f" ({text.count(worse)} for the worse)" if worse else ""),
        f"{text.count(found.same)} the same",
    ]
    if found.errors:
        better = sum(not shift.worse for shift in found.errors)
        cells = text.plural(len(found.errors) - better, "cell")
        said.append(f"less accurate in {cells}, more in {text.count(better)}")
    upgrades = [f"{name} {old} → {new}" for name, old, new in _versions(found)]
    return f"{', '.join(upgrades) or 'The same versions'}: {', '.join(said)}."


def parts(found: Comparison) -> list[Part]:
    """Everything that changed, what is worse first; empty tables are left out."""
    made = [
        Part("New", _new(found)),
        Part("Changed", _changed(found)),
        Part("Gone", _gone(found)),
        Part("Accuracy", _errors(found)),
        Part("Cells answered otherwise", _cells(found)),
        Part("Ledger", _entries(found)),
        Part("What ran", _ran(found)),
    ]
    return [part for part in made if part.table.rows]


def as_markdown(found: Comparison) -> str:
    """Return the comparison in Markdown."""
    lines = [f"# {TITLE}", "", escape(headline(found)), ""]
    for part in parts(found):
        lines += [f"## {part.heading}", "", *table_lines(part.table), ""]
    return "\n".join(lines)


def as_html(found: Comparison) -> str:
    """Return the comparison as one file of HTML."""
    return html.page("diff.html.jinja", title=TITLE, headline=headline(found), parts=parts(found))


def _versions(found: Comparison) -> Iterator[tuple[str, str, str]]:
    """Versions that differ."""
    before, after = found.before.run.versions, found.after.run.versions
    for name in dict.fromkeys([*before, *after]):
        old, new = before.get(name, "none"), after.get(name, "none")
        if old != new:
            yield text.visible(name), text.visible(old), text.visible(new)


def _amount(told: Told) -> str:
    return f"≥ {text.short(told.amount)}" if 0 < told.amount < float("inf") else "–"


def _state(state: str) -> Entry:
    colours = {known.value: colour for known, colour in COLOURS.items()}
    return Entry(text.visible(state), state=colours.get(state, ""))


def _new(found: Comparison) -> Table:
    rows = [
        (
            *map(Entry, (text.visible(told.id), text.visible(told.key), text.visible(told.severity), _amount(told))),
            Entry(f"{text.count(told.count)} of {text.count(told.compared)}"),
            _state(told.state),
        )
        for told in found.new
    ]
    columns = (*map(Column, ("id", "finding", "severity")), Column("wrong by", True), Column("seen", True))
    return Table("Findings that the run before does not have", (*columns, Column("ledger")), tuple(rows))


def _changed(found: Comparison) -> Table:
    rows = []
    for change in found.changed:
        direction = Entry("worse", state="wrong") if change.worse else Entry("")
        named = map(Entry, (text.visible(change.after.id), text.visible(change.after.key)))
        rows.append((*named, direction, Entry(text.visible("; ".join(change.what)))))
    columns = (Column("id"), Column("finding"), Column("worse?"), Column("what changed"))
    return Table("Findings of both runs", columns, tuple(rows))


def _gone(found: Comparison) -> Table:
    rows = []
    for told, why in found.gone:
        seen = f"{text.count(told.count)} of {text.count(told.compared)}"
        said = (text.visible(told.id), text.visible(told.key), text.visible(told.severity), seen, why)
        rows.append(tuple(map(Entry, said)))
    columns = (*map(Column, ("id", "finding", "severity")), Column("was seen", True), Column("now"))
    return Table("Findings that the run after does not have", columns, tuple(rows))


def _errors(found: Comparison) -> Table:
    rows = []
    for shift in found.errors:
        direction = Entry("worse", state="wrong") if shift.worse else Entry("better", state="ok")
        said = (
            " · ".join(map(text.visible, shift.cell)),
            RANKS[shift.rank],
            *map(text.short, (shift.before, shift.after)),
        )
        rows.append((*map(Entry, said), direction))
    columns = (Column("cell"), Column("error"), Column("before", True), Column("after", True), Column("worse?"))
    return Table("Relative errors that are clearly larger or smaller", columns, tuple(rows))


def _cells(found: Comparison) -> Table:
    rows: list[tuple[Entry, ...]] = [
        (Entry(" · ".join(map(text.visible, cell))), Entry(text.visible(old)), Entry(text.visible(new)))
        for cell, old, new in found.cells[:MOST_CELLS]
    ]
    more = len(found.cells) - MOST_CELLS
    if more > 0:
        rows.append((Entry(f"and {text.count(more)} more"), Entry(""), Entry("")))
    return Table("Cells that engines answer otherwise", tuple(map(Column, ("cell", "before", "after"))), tuple(rows))


def _entries(found: Comparison) -> Table:
    rows = [(Entry(text.visible(name)), _state(old), _state(new)) for name, old, new in found.entries]
    return Table("Entries of the ledger", tuple(map(Column, ("entry", "before", "after"))), tuple(rows))


def _ran(found: Comparison) -> Table:
    both = found.before, found.after
    rows = [_row(label, (text.visible(told(report)) for report in both)) for label, told in RAN]
    rows += [_row(name, (old, new)) for name, old, new in _versions(found)]
    return Table("Both runs", tuple(map(Column, ("", "before", "after"))), tuple(rows))


def _row(label: str, said: Iterable[str]) -> tuple[Entry, ...]:
    return (Entry(label), *map(Entry, said))


def _compared(report: Report) -> str:
    return text.count(report.run.total(kinds=COMPARED))


RAN = (
    ("started", lambda report: report.run.started),
    ("time", lambda report: text.seconds(report.run.seconds)),
    ("seed", lambda report: str(report.run.seed)),
    ("engines", lambda report: ", ".join(report.run.engines)),
    ("answers compared", _compared),
    ("findings", lambda report: text.count(len(report.findings))),
)
"""What is told of each run."""
