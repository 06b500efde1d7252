"""What commands print with: consoles of the right width, and tables as a terminal shows them."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.padding import Padding
from rich.table import Table as RichTable
from rich.text import Text

from reports import text
from reports.tables import Table

PLAIN_WIDTH = 120
"""Columns where the output is no terminal and has no width of its own."""

STYLES = {
    "wrong": "red",
    "inconsistent": "red",
    "crashed": "magenta",
    "timed-out": "magenta",
    "reference-wrong": "bold red",
    "problem": "yellow",
    "ok": "green",
}
"""Colours of the states that tables name."""


def console(stream: Any = None) -> Console:
    """Console on a stream, standard output by default."""
    stream = sys.stdout if stream is None else stream
    return Console(file=stream, width=None if stream.isatty() else PLAIN_WIDTH, highlight=False)


def rich_table(table: Table) -> RichTable:
    """Return a table that folds its words where they do not fit; an entry's note stands below it."""
    form = RichTable(box=SIMPLE_HEAD, pad_edge=False, show_edge=False, header_style="bold")
    for column in table.columns:
        form.add_column(
            Text(f"{column.group} {column.title}".strip()),
            justify="right" if column.numeric else "left",
            no_wrap=column.numeric,
            overflow="fold",
        )
    for row in table.rows:
        cells = [Text(entry.text, STYLES.get(entry.state, "")) for entry in row]
        for cell, entry in zip(cells, row, strict=True):
            if entry.note:
                cell.append(f"\n{entry.note}", "dim")
        form.add_row(*cells)
    return form


def facts(pairs: Iterable[tuple[str, str]]) -> RichTable:
    """Labels and what they say, side by side; long words are folded."""
    form = RichTable.grid(padding=(0, 2))
    form.add_column(style="dim", no_wrap=True)
    form.add_column(overflow="fold")
    for label, words in pairs:
        form.add_row(Text(label), Text(words))
    return form


def section(shown: Console, heading: str, *content: Any) -> None:
    """Print a heading, and content below it that is set in."""
    shown.print(Text(f"\n{heading}", "bold"))
    for item in content:
        shown.print(Padding(item, (0, 0, 0, 2)))


def lines(items: Iterable[str]) -> RichTable:
    """Sentences, each behind a bullet."""
    form = RichTable.grid(padding=(0, 1))
    form.add_column(no_wrap=True)
    form.add_column(overflow="fold")
    for item in items:
        form.add_row("•", Text(text.visible(item, limit=4000)))
    return form
