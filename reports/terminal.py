"""What the terminal shows: progress while a campaign runs, and a summary when it is over."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Iterator, Sequence
from types import TracebackType
from typing import Protocol

from rich.box import SIMPLE_HEAD
from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.table import Table as RichTable
from rich.text import Text

from oracles.ledger.states import UNSETTLED
from oracles.outcome import COMPARED, FINDINGS, Kind, Run
from reports import findings, tables, text
from reports.console import ROOMY, STYLES

SHOWN = (Kind.AGREES, Kind.CONVENTION, Kind.UNDECIDED, Kind.WRONG, Kind.CRASHED, Kind.TIMED_OUT)
MOST_BUCKETS = 10
DIGITS = 16
"""Of the digest, enough to tell two runs apart; `report.json` has them all."""
REFRESH, PLAIN_EVERY = 0.2, 10.0
"""Seconds between two updates of a live display, and between two plain lines."""


class Progress(Protocol):
    """A listener that is told of a campaign's progress while its block runs."""

    def __enter__(self) -> Progress: ...

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None: ...

    def started(self, engines: Sequence[str], cells: int) -> None:
        """Take note of what is asked."""

    def advanced(self, run: Run, elapsed: float) -> None:
        """Show how far the run is."""


def progress(console: Console, budget: float | None) -> Progress:
    """Live display on a terminal, a plain line now and then elsewhere. Without a budget the end is not known."""
    live = console.is_terminal and not console.is_dumb_terminal
    return LiveProgress(console, budget) if live else PlainProgress(console, budget)


class PlainProgress:
    """A line at the start, and one every ten seconds."""

    def __init__(self, console: Console, budget: float | None) -> None:
        self.console, self.budget = console, budget
        self._next = PLAIN_EVERY

    def __enter__(self) -> PlainProgress:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Nothing to take down."""

    def started(self, engines: Sequence[str], cells: int) -> None:
        """Say what is asked."""
        time = "" if self.budget is None else f", {text.seconds(self.budget)}"
        self._print(f"asking {_engines(engines)}: {text.plural(cells, 'cell')}{time}")

    def advanced(self, run: Run, elapsed: float) -> None:
        """Say how far the run is, when it is time again."""
        if elapsed < self._next:
            return
        self._next = elapsed - elapsed % PLAIN_EVERY + PLAIN_EVERY
        verdicts = tables.grouped(run).get((), Counter())
        compared, found = tables.total(verdicts, COMPARED), tables.total(verdicts, FINDINGS)
        self._print(
            f"{_clock(elapsed, self.budget)}: {text.plural(compared, 'answer')} compared, "
            f"{text.plural(found, 'finding')} in {text.plural(len(run.buckets), 'bucket')}"
        )

    def _print(self, line: str) -> None:
        self.console.print(Text(line), soft_wrap=True)


class LiveProgress:
    """A bar, the verdicts so far and the latest buckets, redrawn in place."""

    def __init__(self, console: Console, budget: float | None) -> None:
        self.console, self.budget = console, budget
        self._live = Live(console=console, auto_refresh=False, transient=True)
        self._asked = Text("starting the engines")
        self._last = 0.0

    def __enter__(self) -> LiveProgress:
        self._live.__enter__()
        self._live.update(self._asked, refresh=True)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._live.__exit__(kind, error, trace)

    def started(self, engines: Sequence[str], cells: int) -> None:
        """Show what is asked."""
        self._asked = Text(f"asking {_engines(engines)} · {text.plural(cells, 'cell')}")
        self._live.update(self._asked, refresh=True)

    def advanced(self, run: Run, elapsed: float) -> None:
        """Redraw, but not more often than anybody can see."""
        now = time.monotonic()
        if now - self._last >= REFRESH:
            self._last = now
            self._live.update(self._display(run, elapsed), refresh=True)

    def _display(self, run: Run, elapsed: float) -> RenderableType:
        verdicts = tables.grouped(run).get((), Counter())
        compared = tables.total(verdicts, COMPARED)
        bar = RichTable.grid(padding=(0, 2))
        pace = f"{text.count(round(compared / elapsed))}/s" if elapsed > 0 else ""
        bar.add_row(
            ProgressBar(self.budget, min(elapsed, self.budget or 0.0), width=32),
            _clock(elapsed, self.budget),
            f"{text.count(compared)} compared",
            pace,
        )
        said = Text("   ").join(
            Text(
                f"{kind.value} {text.count(verdicts[kind])}",
                STYLES.get(kind.value.replace(" ", "-"), "") if verdicts[kind] else "dim",
            )
            for kind in SHOWN
        )
        latest = [
            Text(f"  {text.visible(bucket.key)} ({text.count(bucket.count)})", overflow="ellipsis", no_wrap=True)
            for bucket in run.buckets[-5:]
        ]
        heading = [Text(f"{text.plural(len(run.buckets), 'bucket')}, the latest:", "dim")] if latest else []
        return Group(self._asked, bar, said, *heading, *latest)


def _engines(engines: Sequence[str]) -> str:
    return " and ".join(map(text.visible, engines))


def _clock(elapsed: float, budget: float | None) -> str:
    if budget is None:
        return text.seconds(round(elapsed))
    late = " (finishing)" if elapsed > budget else ""
    return f"{text.seconds(round(elapsed))} of {text.seconds(budget)}{late}"


def verdict_table(run: Run, width: int) -> RichTable:
    """Verdicts per engine and query, each query indented below its engine; fits into 80 columns."""
    table = tables.summary(run)
    padding = (0, 1) if width >= ROOMY else (0, 0)
    form = RichTable(box=SIMPLE_HEAD, pad_edge=False, padding=padding, show_edge=False, header_style="bold")
    for column in table.columns:
        heading = Text("\n".join(column.title.split()) if column.numeric else "")
        form.add_column(heading, justify="right" if column.numeric else "left", no_wrap=True)
    for i, row in enumerate(table.rows):
        engine, _, query = row[0].text.partition(" · ")
        if i and not query:
            form.add_section()
        heading = Text(f"  {query}" if query else engine, overflow="ellipsis")
        form.add_row(heading, *(Text(entry.text, STYLES.get(entry.state, "")) for entry in row[1:]))
    return form


def print_summary(run: Run, console: Console) -> None:
    """Print the headline, the verdicts per engine and query, and the top buckets."""

    def line(words: str, style: str = "") -> None:
        console.print(Text(words, style))

    line(findings.headline(run), "bold")
    for warning in findings.warnings(run):
        line(warning, "yellow")
    line("")
    console.print(verdict_table(run, console.width))
    if split := tables.time_split(run):
        line(split)
    line("")
    for row in (*_top(run), *_unsettled(run)):
        line(row)


def _unsettled(run: Run) -> Iterator[str]:
    """Entries of the ledger that ask for something to be done."""
    for note in run.ledger:
        if note.state in UNSETTLED:
            name = f"{text.visible(note.engine)} · {text.visible(note.name)}"
            yield f"{note.state.value}: {name}: {text.visible(note.why)}"


def _top(run: Run) -> Iterator[str]:
    """The first buckets, what is new before the worst: one line of names, one of words."""
    for view in findings.bucket_views(run)[:MOST_BUCKETS]:
        yield f"{view.number:>3}. {view.title}"
        yield f"     {view.severity}; {dict(view.facts)['seen']}; {view.state}"
    more = len(run.buckets) - MOST_BUCKETS
    if more > 0:
        yield f"     … and {text.plural(more, 'more bucket')} in the report"
    if run.buckets:
        yield ""
