"""``proxyproof accuracy``: how accurate and how quick the engines of a run were, in the terminal."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from reports import options
from reports.options import BadInput
from reports.running import FINISHED, OUT

if TYPE_CHECKING:
    from rich.table import Table as RichTable

    from oracles.accuracy import Accuracy
    from reports.tables import Table


def accuracy(
    place: Annotated[
        Path,
        typer.Argument(parser=options.place("DIR"), metavar="[DIR]", help="Folder of the report, or its report.json."),
    ] = OUT,
    pair: Annotated[
        list[str] | None, typer.Option(metavar="A-B", help="Pair to show, as Sphere-Box; may be repeated.")
    ] = None,
    every: Annotated[bool, typer.Option("--all", help="Show every pair, and the speeds.")] = False,
    markdown: Annotated[bool, typer.Option("--markdown", help="Print the tables as Markdown.")] = False,
) -> int:
    """Print how accurate the engines of a run were: errors by rank, the worst cells, with --all every pair and speeds.

    The single regimes are in accuracy.csv beside the report.
    """
    known = read(place)
    if pair:
        known = of_pairs(known, options.pairs(pair))
    show(tables_of(known, brief=not (every or pair)), markdown=markdown)
    return FINISHED


def read(place: Path) -> Accuracy:
    """Read the accuracy in a report; raises `BadInput` where there is none."""
    from reports.accuracy_data import accuracy_from  # noqa: PLC0415
    from reports.reading import NoReport, read_report  # noqa: PLC0415

    try:
        return accuracy_from(read_report(place).get("accuracy"))
    except (NoReport, ValueError) as error:
        raise BadInput(f"{place}: {error}") from None


def of_pairs(known: Accuracy, pairs: Sequence[str]) -> Accuracy:
    """Leave out all but some pairs, and what is summed over all of them."""
    return replace(
        known,
        errors=tuple(row for row in known.errors if row.pair in pairs),
        speeds=tuple(speed for speed in known.speeds if speed.pair in pairs),
    )


def tables_of(known: Accuracy, *, brief: bool) -> list[Table]:
    """Tables to print: in brief without those that have a row for each pair."""
    from oracles.outcome import Run  # noqa: PLC0415
    from reports.accuracy import EACH_CELL  # noqa: PLC0415
    from reports.accuracy import accuracy as every  # noqa: PLC0415

    engines = list(dict.fromkeys([*(row.engine for row in known.errors), *(speed.engine for speed in known.speeds)]))
    found = every(Run(0, 0.0, "", engines=engines, accuracy=known))
    return [table for table in (found[:-EACH_CELL] if brief else found) if table.rows]


def show(tables: Sequence[Table], *, markdown: bool) -> None:
    """Print tables, on a terminal or as Markdown."""
    from rich.console import Console  # noqa: PLC0415
    from rich.text import Text  # noqa: PLC0415

    from reports.accuracy import NOTE  # noqa: PLC0415
    from reports.console import PLAIN_WIDTH  # noqa: PLC0415
    from reports.markdown import escape, table_lines  # noqa: PLC0415

    if not tables:
        raise BadInput("the run measured no errors there")
    if markdown:
        print(
            "\n\n".join([NOTE, *(f"{escape(table.caption)}:\n\n" + "\n".join(table_lines(table)) for table in tables)])
        )
        return
    console = Console()
    if not console.is_terminal:
        console = Console(width=PLAIN_WIDTH)
    for table in tables:
        console.print(Text(table.caption, "bold"))
        console.print(_rich(table))
        console.print()
    console.print(Text(NOTE, "dim"))


def _rich(table: Table) -> RichTable:
    """A table whose notes stand below what they are notes on."""
    from rich.box import SIMPLE_HEAD  # noqa: PLC0415
    from rich.table import Table as RichTable  # noqa: PLC0415
    from rich.text import Text  # noqa: PLC0415

    form = RichTable(box=SIMPLE_HEAD, show_edge=False, header_style="bold")
    for column in table.columns:
        words = column.title.split(" ") if column.numeric else [column.title]
        heading = Text("\n".join(filter(None, (column.group, *words))))
        form.add_column(heading, justify="right" if column.numeric else "left", no_wrap=True)
    for row in table.rows:
        form.add_row(*(Text("\n".join(filter(None, (entry.text, entry.note)))) for entry in row))
    return form
