"""`index.html`: the report as one file that needs no network, and whose script only makes it handier."""

from __future__ import annotations

from base64 import b64encode
from hashlib import sha256

from jinja2 import Environment, PackageLoader, StrictUndefined

from oracles.outcome import Run
from oracles.scene import QUERIES
from refimpl.pairs import PROBES, SOLIDS
from reports import cells, ledger, overview, tables, text
from reports.content import TITLE, WORDS, content
from reports.tables import LEGEND

MOST_NEW = 12
"""New findings that the overview names; the rest is behind a link."""


def render(run: Run) -> str:
    """Return the report as HTML. Everything is escaped by the template engine but our own style and script."""
    environment = _environment()
    rows = cells.rows(run)
    template = environment.get_template("report.html.jinja")
    return template.render(
        report=content(run),
        title=TITLE,
        words=WORDS,
        legend=LEGEND,
        cards=overview.cards(run),
        unsettled=overview.unsettled_entries(run),
        spent=overview.spent(run),
        most_new=MOST_NEW,
        rows=rows,
        places=cells.places(run, rows),
        engines=[text.visible(engine) for engine in tables.engines(run)],
        types=[kind.__name__ for kind in (*PROBES, *SOLIDS)],
        queries=QUERIES,
        shows=cells.SHOWS,
        style=_style(environment, len(tables.engines(run))),
        script=_own(environment, "report.js"),
    )


def _environment() -> Environment:
    environment = Environment(
        loader=PackageLoader("reports", "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {
        "count": text.count,
        "visible": text.visible,
        "sha256": digest,
        "ledger_anchor": ledger.anchor,
        "is_address": ledger.is_address,
    }
    return environment


def digest(code: str) -> str:
    """Name of an inline style or script by which a content security policy lets it in, and nothing else."""
    return f"sha256-{b64encode(sha256(code.encode()).digest()).decode()}"


def _style(environment: Environment, engines: int) -> str:
    """Return the style sheet, with a rule for each engine that may be the only one that is shown."""
    only = (f".only-{i} .e:not(.e{i}) {{ display: none; }}\n" for i in range(engines))
    return _own(environment, "report.css") + "".join(only)


def _own(environment: Environment, name: str) -> str:
    assert environment.loader is not None
    return environment.loader.get_source(environment, name)[0]
