"""``proxyproof replay``: the engine is asked a finding's scene again, and judged anew."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from reports import options, text
from reports.options import BadInput
from reports.showing import DEFAULT, Folder, Which

if TYPE_CHECKING:
    from rich.console import Console

    from oracles.outcome import Bucket
    from reports.asking import Again
    from reports.tables import Table

RIGHT, STILL_WRONG = 0, 1
CALL_LIMIT = 2.0


def replay(
    which: Which,
    run: Folder = Path(DEFAULT),
    engine: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="Ask this engine instead; needed for one of your own."),
    ] = None,
    call_limit: Annotated[
        float,
        typer.Option(
            parser=options.seconds("--call-limit"),
            metavar="SECONDS",
            help="Processor time the engine has for its answer (waiting: five times that).",
        ),
    ] = CALL_LIMIT,
) -> int:
    """Ask the engine a finding's scene again, and judge it.

    The engine runs in a guarded process, as in a run.

    Exit status: 1 while it is still wrong, 0 when it is right or cannot be proven wrong, 2 when it cannot be asked.
    """
    from oracles.engine import EngineUnavailable  # noqa: PLC0415
    from oracles.outcome import Kind  # noqa: PLC0415
    from reports.asking import ask_again  # noqa: PLC0415
    from reports.console import console  # noqa: PLC0415
    from reports.reading import bucket_from_data, chosen, read_report  # noqa: PLC0415

    with options.reading():
        bucket = bucket_from_data(chosen(read_report(run), which))
    (spec,) = options.engines([engine or _shipped(bucket.engine)])
    try:
        again = ask_again(bucket, spec, call_limit)
    except EngineUnavailable as error:
        raise BadInput(str(error)) from None
    if again.kind is Kind.UNSUPPORTED:
        raise BadInput(f"{again.engine} does not answer this {bucket.query} of {bucket.pair}")
    _tell(bucket, again, console())
    return STILL_WRONG if again.wrong else RIGHT


def _shipped(name: str) -> str:
    """Name of a shipped engine; a report may not choose what is executed."""
    from oracles.engines import SHIPPED  # noqa: PLC0415

    if name not in SHIPPED:
        raise BadInput(f"{text.visible(name)!r} is an engine of one's own: name it again with --engine")
    return name


def _tell(bucket: Bucket, again: Again, shown: Console) -> None:
    """Print both answers, and the verdict on the one of now."""
    from rich.text import Text  # noqa: PLC0415

    from reports.console import rich_table, section  # noqa: PLC0415

    versions = ", ".join(f"{name} {version}" for name, version in again.versions.items())
    shown.print(Text(f"{bucket.id}  {text.visible(bucket.key)}", "bold"))
    shown.print(Text(f"asked again: {text.visible(versions or again.engine)}"))
    if again.answer or bucket.witness.answer:
        section(shown, "Answers", rich_table(_answers(bucket.witness.answer, again.answer)))
    if again.error:
        section(shown, "The engine's last words", Text(text.block(again.error)))
    verdict = ("still wrong", "bold red") if again.wrong else ("not wrong", "bold green")
    shown.print(Text.assemble("\n", verdict, f": {text.visible(again.claim or again.kind.value, limit=1000)}"))


def _answers(then: dict[str, object], now: dict[str, object]) -> Table:
    """What the engine said in the report, and now."""
    from reports.findings import value  # noqa: PLC0415
    from reports.tables import Column, Entry, Table  # noqa: PLC0415

    rows = []
    for name in dict.fromkeys([*then, *now]):
        told = [value(name, answer[name]) if name in answer else "not said" for answer in (then, now)]
        rows.append(tuple(map(Entry, (text.visible(name), *told))))
    return Table("", (Column("answer"), Column("in the report"), Column("now")), tuple(rows))
