"""Progress and summary on a terminal, wide or narrow, live or not."""

from __future__ import annotations

import io
import re

import pytest
from rich.console import Console

from oracles.outcome import Run
from reports import tables, terminal, text
from tests.sample_run import sample_run

# -- terminal ------------------------------------------------------------------------------------------------


def test_live_display_shows_the_run() -> None:
    console = Console(file=io.StringIO(), force_terminal=True, width=100, _environ={"TERM": "xterm"})
    run = sample_run()
    with terminal.progress(console, 60.0) as progress:
        assert isinstance(progress, terminal.LiveProgress)
        progress.started(["fcl", "bullet"], 484)
        progress.advanced(run, 23.0)
    shown = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", console.file.getvalue())  # type: ignore[attr-defined]
    assert "asking fcl and bullet · 484 cells" in shown
    assert "23\u202fs of 60\u202fs" in shown
    assert run.buckets[-1].key in shown
    assert f"{len(run.buckets)} buckets" in shown


@pytest.mark.parametrize("live", [True, False])
def test_a_run_of_passes_is_not_told_to_end_in_time(live: bool) -> None:
    console = Console(file=io.StringIO(), force_terminal=live, width=100, _environ={"TERM": "xterm"})
    with terminal.progress(console, None) as progress:
        progress.started(["fcl"], 484)
        progress.advanced(sample_run(), 73.0)
    shown = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", console.file.getvalue())  # type: ignore[attr-defined]
    assert "484 cells" in shown
    assert "73\u202fs" in shown
    assert " of " not in shown
    assert "finishing" not in shown


def test_live_display_is_not_redrawn_for_every_answer() -> None:
    console = Console(file=io.StringIO(), force_terminal=True, width=100, _environ={"TERM": "xterm"})
    run = sample_run()
    with terminal.progress(console, 60.0) as progress:
        for i in range(200):
            progress.advanced(run, i / 1000)
    assert console.file.getvalue().count("0\u202fs of 60\u202fs") < 20  # type: ignore[attr-defined]


def test_terminal_obeys_no_engine() -> None:
    console = Console(file=io.StringIO(), force_terminal=True, width=100, color_system=None, _environ={"TERM": "xterm"})
    run = sample_run()
    run.engines, run.problems = ["\x1b]0;owned\x07", "[red]x"], ["\x1b[2J", "[/nonsense]"]
    run.buckets[0].symptom = "\x1b[8mhidden [bold]"
    terminal.print_summary(run, console)
    shown = console.file.getvalue()  # type: ignore[attr-defined]
    assert not re.search(r"\x1b(?!\[0?m)", shown)
    for words in ("⟨U+001B⟩]0;owned", "[red]x", "[/nonsense]", "hidden [bold]"):
        assert words in shown.replace("\n", "")


@pytest.mark.parametrize("width", [80, 100, 200])
def test_summary_fits_the_terminal_and_cuts_no_number(width: int) -> None:
    console = Console(file=io.StringIO(), width=width)
    run = sample_run()
    terminal.print_summary(run, console)
    shown = console.file.getvalue()  # type: ignore[attr-defined]
    assert max(map(len, shown.splitlines())) <= width
    for row in tables.summary(run).rows:
        numbers = " +".join(re.escape(entry.text) for entry in row[1:])
        assert re.search(f"{row[0].text.rpartition(' · ')[2]} +{numbers}", shown)


def test_summary_of_an_empty_run() -> None:
    console = Console(file=io.StringIO(), width=100)
    terminal.print_summary(Run(0, 1.0, "", problems=["nothing ran"]), console)
    assert "nothing ran" in console.file.getvalue()  # type: ignore[attr-defined]


def test_many_buckets_are_cut_in_the_terminal() -> None:
    console = Console(file=io.StringIO(), width=120)
    run = sample_run()
    run.buckets *= 4
    terminal.print_summary(run, console)
    shown = console.file.getvalue()  # type: ignore[attr-defined]
    assert f"and {text.count(len(run.buckets) - terminal.MOST_BUCKETS)} more buckets in the report" in shown
