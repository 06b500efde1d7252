"""``proxyproof diff``: what changed between two runs, in the terminal or as a file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from reports import options, text
from reports.options import BadInput

if TYPE_CHECKING:
    from collections.abc import Iterable

    from reports.diff_report import Part

NOT_WORSE, WORSE = 0, 1
ENDINGS = (".html", ".md")


def _report(name: str) -> Any:
    help_ = f"The run {name}: folder of its report, or its report.json."
    return typer.Argument(parser=options.place("RUN"), metavar=name.upper(), help=help_)


def diff(
    before: Annotated[Path, _report("before")],
    after: Annotated[Path, _report("after")],
    out: Annotated[
        list[Path] | None,
        typer.Option(
            parser=options.place("--out", "file"),
            metavar="FILE",
            help="Write it to this file, as HTML (.html) or Markdown (.md); may be repeated.",
        ),
    ] = None,
    markdown: Annotated[bool, typer.Option("--markdown", help="Print it as Markdown.")] = False,
) -> int:
    """Say what changed between two runs.

    Findings that are new, gone or changed, cells, the ledger, and the engines' versions.

    Exit status: 0 when nothing is new or worse, 1 when something is, 2 for bad input.
    """
    from reports import diff_report  # noqa: PLC0415
    from reports.diff import compare, report_at  # noqa: PLC0415

    for path in out or ():
        if path.suffix not in ENDINGS:
            raise BadInput(f"--out must end in {' or '.join(ENDINGS)}, got {str(path)!r}")
    with options.reading():
        found = compare(report_at(before), report_at(after))
    forms = {".html": diff_report.as_html, ".md": diff_report.as_markdown}
    for path in out or ():
        _write(path, forms[path.suffix](found))
    if markdown:
        print(diff_report.as_markdown(found), end="")
    elif not out:
        _print(diff_report.headline(found), diff_report.parts(found))
    else:
        print(diff_report.headline(found))
    return WORSE if found.worse else NOT_WORSE


def _write(path: Path, content: str) -> None:
    try:
        path.write_text(content, encoding="utf-8", errors="backslashreplace", newline="\n")
    except OSError as error:
        raise BadInput(f"cannot write {text.visible(path)}: {error.strerror or error}") from None


def _print(headline: str, parts: Iterable[Part]) -> None:
    from rich.text import Text  # noqa: PLC0415

    from reports.console import console, rich_table, section  # noqa: PLC0415

    shown = console()
    shown.print(Text(headline, "bold"))
    for part in parts:
        section(shown, part.heading, rich_table(part.table))
