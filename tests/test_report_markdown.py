"""`report.md`: what it leaves out when it must be short, and the summary of a step that GitHub shows."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from markdown_it import MarkdownIt

from oracles.outcome import Run, State
from reports import findings, markdown, step_summary, verify
from reports.content import Content, content
from reports.cutting import Part, fitting, put_together
from tests.sample_run import sample_run


@pytest.fixture(scope="module")
def run() -> Run:
    """Many known findings, and two new ones of later cells."""
    run = sample_run()
    known = run.buckets[7]
    new = [run.buckets[2], run.buckets[8]]
    run.buckets = [*new, *[known] * 60]
    return run


@pytest.fixture(scope="module")
def said_of(run: Run) -> Content:
    return content(run)


@pytest.fixture(scope="module")
def whole(run: Run) -> str:
    return markdown.render(run)


def told(said: str) -> list[int]:
    return [int(number) for number in re.findall(r"^#### (\d+)\\\. ", said, re.MULTILINE)]


def test_whole_report_leaves_nothing_out(run: Run, whole: str) -> None:
    assert "Left out" not in whole
    assert sorted(told(whole)) == list(range(1, len(run.buckets) + 1))


@pytest.mark.parametrize("share", [0.02, 0.05, 0.1, 0.3, 0.6, 0.9, 0.999])
def test_short_report_fits_and_keeps_what_is_new(run: Run, said_of: Content, whole: str, share: float) -> None:
    limit = int(len(whole.encode()) * share)
    said = markdown.written(said_of, limit)
    assert len(said.encode()) <= limit
    left, known = told(said), [n for n in told(said) if n > 2]
    if known:
        assert set(left) >= {1, 2}
        assert known == list(range(3, 3 + len(known)))
    cut = verify.CUT.search(said)
    missing = len(run.buckets) - len(left)
    assert (cut and (int(cut[1]), int(cut[2]))) == ((missing, len(run.buckets)) if missing else None)
    assert "> **Left out, to be short: " in said
    for heading in ("Time", "Words", "Ledger"):
        assert (f"## {heading}\n" in said) != (f"; {heading.lower()}" in said.replace("the ledger", "ledger"))


def test_report_grows_with_its_limit(said_of: Content, whole: str) -> None:
    sizes = [len(markdown.written(said_of, limit)) for limit in range(2_000, 60_000, 8_000)]
    assert sizes == sorted(sizes)
    assert markdown.written(said_of, len(whole.encode())) == whole


def test_nothing_is_better_than_half_a_headline(said_of: Content) -> None:
    assert markdown.written(said_of, 300) == ""


def test_news_come_first(whole: str) -> None:
    headings = re.findall(r"^## (.*)$", whole, re.MULTILINE)
    assert headings[:3] == ["New", "What ran", "Matrix"]
    news = whole[whole.index("## New") : whole.index("## What ran")]
    assert [line.split("|")[1].strip() for line in news.splitlines() if line.rstrip().endswith("| NEW    |")] == [
        "1",
        "2",
    ]
    assert "STALE (1 witness passes now)" in news
    assert "CHANGED" in news
    assert "expected" not in news


def test_nothing_new_has_no_heading() -> None:
    run = sample_run()
    run.ledger = []
    for its in run.buckets:
        its.state = State.EXPECTED
    assert "## New" not in markdown.render(run)


def test_pictures_are_linked_where_they_lie_beside(run: Run, whole: str) -> None:
    assert "![" not in whole
    said = markdown.render(run, beside=True)
    images = [
        child.attrs["src"]
        for token in MarkdownIt("commonmark").parse(said)
        for child in token.children or []
        if child.type == "image"
    ]
    assert images == [view.picture for view in findings.bucket_views(run)]


def test_scripts_and_issues_are_linked_where_they_lie_beside(run: Run, said_of: Content, whole: str) -> None:
    linked = markdown.written(said_of, markdown.LIMIT, beside=True)
    for view in findings.bucket_views(run):
        for path in (view.file, view.issue):
            assert f"]({path})" in linked
            assert f": {path}\n" in whole
    assert "](" not in whole


# -- fitting -------------------------------------------------------------------------------------------------


def test_parts_are_taken_by_rank_and_stay_in_order() -> None:
    late, early = Part(("b" * 40,), 1, ("# B",)), Part(("a" * 40,), 0, ("# A",))
    assert fitting([late, early], 100) == [late, early]
    assert fitting([late, early], 60) == [early]
    assert list(put_together([late, early])) == ["# B", "", "b" * 40, "# A", "", "a" * 40]


def test_a_series_ends_where_one_does_not_fit() -> None:
    parts = [Part(("x" * n,), 0, series=True) for n in (10, 90, 10)]
    assert fitting(parts, 50) == parts[:1]
    alone = [Part(("x" * n,), 0) for n in (10, 90, 10)]
    assert fitting(alone, 50) == [alone[0], alone[2]]


def test_headings_are_paid_and_shown_once() -> None:
    parts = [Part(("line",), 0, ("## heading",)) for _ in range(3)]
    said = "\n".join(put_together(parts)) + "\n"
    assert said.count("heading") == 1
    assert fitting(parts, len(said)) == parts
    assert fitting(parts, len(said) - 1) == parts[:2]


# -- the summary of a step -----------------------------------------------------------------------------------


@pytest.fixture
def summary(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    path = tmp_path / "summary.md"
    monkeypatch.setenv(step_summary.VARIABLE, str(path))
    return path


def test_summary_is_appended(run: Run, whole: str, summary: Path) -> None:
    summary.write_text("before\n")
    assert step_summary.append(run) == ""
    assert summary.read_text("utf-8") == "before\n\n" + whole


@pytest.mark.parametrize("there", [0, 500_000, 1_000_000, 1_040_000])
def test_summary_stays_within_the_limit_with_what_is_there(run: Run, summary: Path, there: int) -> None:
    summary.write_text("x" * there)
    assert step_summary.append(run) == ""
    assert there < summary.stat().st_size <= step_summary.LIMIT


def test_full_summary_is_left_alone(run: Run, summary: Path) -> None:
    summary.write_text("x" * (step_summary.LIMIT - 100))
    assert "is full" in step_summary.append(run)
    assert summary.stat().st_size == step_summary.LIMIT - 100


def test_summary_that_cannot_be_written_is_told(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(step_summary.VARIABLE, str(tmp_path))
    assert "cannot be written" in step_summary.append(run)


def test_no_summary_is_asked_for(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(step_summary.VARIABLE, raising=False)
    assert step_summary.append(run) == ""
