"""`index.html`: the report as one file that needs no network and no script."""

from __future__ import annotations

from dataclasses import replace
from itertools import groupby, islice

from jinja2 import Environment, PackageLoader, StrictUndefined

from oracles.outcome import Run
from reports import text
from reports.content import LONGEST_SCRIPT, MOST_SCRIPTS, TITLE, WORDS, content
from reports.tables import LEGEND, Entry, Table


def column_groups(table: Table) -> list[tuple[str, int]]:
    """Headings above the headings: name and width of each run of columns that share one; empty without any."""
    groups = [(name, len(list(columns))) for name, columns in groupby(table.columns, key=lambda c: c.group)]
    return groups if any(name for name, _ in groups) else []


def sections(table: Table) -> list[tuple[str, list[tuple[Entry, ...]]]]:
    """Rows below their headings, the heading left out of their own; one section without heading, where there is none.

    A row "Sphere–Box" below the heading "Sphere" is "Box": narrow enough for a phone.
    """
    rows, found = iter(table.rows), []
    for heading, count in table.sections or (("", len(table.rows)),):
        below = list(islice(rows, count))
        names = (replace(row[0], text=row[0].text.removeprefix(f"{heading}–")) for row in below)
        found.append((heading, [(name, *row[1:]) for name, row in zip(names, below, strict=True)]))
    return found


def render(run: Run) -> str:
    """Return the report as HTML. Everything is escaped by the template engine, without exception."""
    environment = Environment(
        loader=PackageLoader("reports", "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["block"] = text.block
    environment.globals.update(
        column_groups=column_groups, sections=sections, longest_script=LONGEST_SCRIPT, most_scripts=MOST_SCRIPTS
    )
    template = environment.get_template("report.html.jinja")
    return template.render(report=content(run), title=TITLE, words=WORDS, legend=LEGEND)
