"""``proxyproof show``: a finding of a report in the terminal."""

from __future__ import annotations

import shlex
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from reports import options, text

if TYPE_CHECKING:
    from rich.console import Console

    from reports.findings import BucketView

FINISHED = 0
DEFAULT = "discrepancy-report"

Folder = Annotated[
    Path,
    typer.Option(
        "--run",
        parser=options.place("--run"),
        metavar="DIR",
        help="Folder of the report, or its report.json. Default: discrepancy-report.",
        show_default=False,
    ),
]
Which = Annotated[str, typer.Argument(metavar="ID", help="The finding's number or id, or how the id begins.")]


def show(
    which: Annotated[
        str | None,
        typer.Argument(metavar="ID", help="The finding's number or id, or how the id begins. Default: a list of all."),
    ] = None,
    run: Folder = Path(DEFAULT),
) -> int:
    """Show a finding of a report, or list them all.

    Its story, its scene, both answers in full precision, and the proof.
    """
    from reports.console import console  # noqa: PLC0415
    from reports.reading import chosen, read_report  # noqa: PLC0415

    with options.reading():
        data = read_report(run)
        shown = console()
        if which is None:
            _print_list(data, shown)
        else:
            item = chosen(data, which)
            print_finding(view_of(data, item), item, run, shown)
    return FINISHED


def view_of(data: dict[str, Any], item: dict[str, Any]) -> BucketView:
    """The bucket of a report as people read it; raises `NoReport` when it is damaged."""
    from reports.findings import bucket_views  # noqa: PLC0415
    from reports.reading import bucket_from_data, run_from_data  # noqa: PLC0415

    found = run_from_data(data)
    found.buckets = [bucket_from_data(item)]
    (view,) = bucket_views(found)
    return replace(view, number=int(item["number"]), file=str(item["repro"]))


def print_finding(view: BucketView, item: dict[str, Any], run: Path, shown: Console) -> None:
    """Print a finding at length."""
    from rich.text import Text  # noqa: PLC0415

    from reports.console import STYLES, facts, lines, rich_table, section  # noqa: PLC0415
    from reports.ledger import COLOURS  # noqa: PLC0415

    name = text.visible(item["id"])
    state = Text(view.state, STYLES.get(COLOURS.get(item["state"], ""), "green"))
    shown.print(Text.assemble((f"{view.number}. {name}", "bold"), "  ", state))
    shown.print(Text(view.title))
    shown.print(Text(f"\n{view.story}"))
    section(shown, "Facts", facts(view.facts))
    section(shown, "Scene", facts(view.scene))
    section(shown, "Answers", rich_table(view.answers))
    if view.error:
        section(shown, "The engine's last words", Text(view.error))
    if view.about:
        section(shown, "Refuted on these two, to which the answer leads", facts(view.about))
    if view.proof:
        section(shown, f"Proof: {view.proof.interval}", lines(view.proof.claims))
    shown.print(Text("\nGo on", "bold"))
    for label, command in _commands(view, name, run):
        shown.print(Text.assemble(f"  {label:<13}", (command, "cyan")), soft_wrap=True)


def _commands(view: BucketView, name: str, run: Path) -> tuple[tuple[str, str], ...]:
    """What to do next, to be copied."""
    folder = run if run.is_dir() else run.parent
    where = "" if str(folder) == DEFAULT else f" --run {_quoted(folder)}"
    return (
        ("ask again", f"proxyproof replay {name}{where}"),
        ("without us", f"python {_quoted(folder / view.file)}"),
        ("report it", _quoted(folder / view.issue)),
    )


def _quoted(path: Path) -> str:
    return text.visible(shlex.quote(str(path)), limit=1000)


def _print_list(data: dict[str, Any], shown: Console) -> None:
    """A line for each finding, what is new first."""
    from reports.console import rich_table  # noqa: PLC0415
    from reports.ledger import COLOURS  # noqa: PLC0415
    from reports.tables import Column, Entry, Table  # noqa: PLC0415

    rows = []
    for item in data["buckets"]:
        said = (item.get(name) for name in ("number", "id", "key", "count", "state"))
        number, name, key, count, state = map(text.visible, said)
        rows.append((*map(Entry, (number, name, key, count)), Entry(state, state=COLOURS.get(item.get("state"), ""))))
    columns = (Column("#", True), Column("id"), Column("finding"), Column("seen", True), Column("ledger"))
    shown.print(rich_table(Table("", columns, tuple(rows))) if rows else "no findings")
