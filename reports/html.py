"""`index.html`: the report as one file that needs no network, and whose script only makes it handier."""

from __future__ import annotations

from base64 import b64encode
from hashlib import sha256
from itertools import groupby

from jinja2 import Environment, PackageLoader, StrictUndefined

from oracles.outcome import Run
from oracles.scene import QUERIES
from refimpl.pairs import PROBES, SOLIDS
from reports import cells, ledger, overview, surveys, tables, text, viewer
from reports.accuracy import NOTE, accuracy
from reports.broad_phase import WHAT
from reports.content import TITLE, WORDS, content
from reports.plots import plots
from reports.tables import LEGEND, Table

MOST_NEW = 12
"""New findings that the overview names; the rest is behind a link."""


def render(run: Run) -> str:
    """Return the report as HTML. The template engine escapes everything but our own style, script and pictures."""
    environment = _environment()
    named = [text.visible(engine) for engine in tables.engines(run)]
    rows = cells.rows(run)
    return environment.get_template("report.html.jinja").render(
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
        rare=cells.rare(run),
        figures={bucket.id: viewer.figure(bucket) for bucket in run.buckets},
        accuracy=accuracy(run),
        accuracy_note=NOTE,
        broad_phase_note=WHAT,
        surveys_note=surveys.WHAT,
        plots=plots(run),
        engines=named,
        types=[kind.__name__ for kind in (*PROBES, *SOLIDS)],
        queries=QUERIES,
        shows=cells.SHOWS,
        style=_style(environment, len(named)),
        script=script(environment),
    )


def page(template: str, own_style: str = "", **values: object) -> str:
    """Return another page in the report's style, to which a style sheet of its own may add something."""
    environment = _environment()
    style = _style(environment, 0) + (_own(environment, own_style) if own_style else "")
    return environment.get_template(template).render(**values, style=style)


def script(environment: Environment | None = None) -> str:
    """Return the one script of the report."""
    return _own(environment or _environment(), "report.js") + viewer.script()


def column_groups(table: Table) -> list[tuple[str, int]]:
    """Headings above the headings: name and width of each run of columns that share one; empty without any."""
    groups = [(name, len(list(columns))) for name, columns in groupby(table.columns, key=lambda column: column.group)]
    return groups if any(name for name, _ in groups) else []


def _environment() -> Environment:
    environment = Environment(
        loader=PackageLoader("reports", "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.globals |= {"column_groups": column_groups}
    environment.filters |= {
        "count": text.count,
        "brief": lambda value: value if value is None else f"{value:.3g}",
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
    return _own(environment, "report.css") + "".join(only) + viewer.style()


def _own(environment: Environment, name: str) -> str:
    assert environment.loader is not None
    return environment.loader.get_source(environment, name)[0]
