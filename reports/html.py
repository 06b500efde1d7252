"""`index.html`: the report as one file that needs no network and no script."""

from __future__ import annotations

from itertools import groupby

from jinja2 import Environment, PackageLoader, StrictUndefined

from oracles.outcome import Run
from reports import text
from reports.content import TITLE, WORDS, content
from reports.tables import LEGEND, Table


def column_groups(table: Table) -> list[tuple[str, int]]:
    """Headings above the headings: name and width of each run of columns that share one; empty without any."""
    groups = [(name, len(list(columns))) for name, columns in groupby(table.columns, key=lambda c: c.group)]
    return groups if any(name for name, _ in groups) else []


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
    environment.globals.update(column_groups=column_groups)
    template = environment.get_template("report.html.jinja")
    return template.render(report=content(run), title=TITLE, words=WORDS, legend=LEGEND)
