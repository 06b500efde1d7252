"""Two runs compared: what is new, gone, changed and worse, and how it is told."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from markdown_it import MarkdownIt

from oracles.accuracy import Accuracy, Errors, Spread
from oracles.outcome import Run
from oracles.scene import DISTANCE
from reports import cli, diff_report, summary
from reports.diff import NOT_ASKED, Comparison, compare, report_at
from reports.diff_accuracy import shifts
from tests.sample_run import Page, sample_run
from tests.test_report_hostile import NASTY, TAME, hostile_run


@pytest.fixture(scope="module")
def data() -> Any:
    return json.loads(summary.report_json(sample_run()))


def saved(data: Any, folder: Path) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "report.json").write_text(json.dumps(data), "utf-8")
    return folder


@pytest.fixture
def compared(data: Any, tmp_path: Path) -> Callable[[Callable[[Any], object]], Comparison]:
    """Compare the sample with itself, changed."""

    def comparison(change: Callable[[Any], object]) -> Comparison:
        after = copy.deepcopy(data)
        change(after)
        return compare(report_at(saved(data, tmp_path / "before")), report_at(saved(after, tmp_path / "after")))

    return comparison


def new_one(data: Any) -> None:
    data["buckets"].append({**data["buckets"][0], "id": "0123456789ab", "symptom": "false contact", "key": "a new one"})


def moved(data: Any) -> None:
    first = data["buckets"][0]
    first.update(id="0123456789ab", key=first["key"].replace("deep · 1e-1", "touching · 1e-2"))


def counted(factor: float) -> Callable[[Any], None]:
    def change(data: Any) -> None:
        data["buckets"][2]["count"] = int(data["buckets"][2]["count"] * factor)

    return change


def not_asked(data: Any) -> None:
    gone = data["buckets"].pop(0)
    cell = gone["engine"], gone["query"], gone["pair"]
    data["counts"] = [c for c in data["counts"] if (c["engine"], c["query"], c["pair"]) != cell]


def upgraded(data: Any) -> None:
    data["versions"]["python-fcl"] = "0.8"


def test_a_run_and_itself(compared: Any) -> None:
    found = compared(lambda data: None)
    assert (found.new, found.gone, found.changed, found.cells, found.entries) == ((), (), (), (), ())
    assert found.same == 10
    assert not found.worse
    assert diff_report.headline(found) == "The same versions: 0 new findings, 0 gone, 0 changed, 10 the same."
    assert [part.heading for part in diff_report.parts(found)] == ["What ran"]


def test_new_finding_is_worse(compared: Any) -> None:
    found = compared(new_one)
    assert [told.id for told in found.new] == ["0123456789ab"]
    assert found.worse
    assert found.same == 10


def test_gone_finding_is_not_worse(compared: Any) -> None:
    found = compared(lambda data: data["buckets"].pop(2))
    ((told, why),) = found.gone
    assert told.symptom == "ray hits behind the surface"
    assert why == f"0 of {diff_report.text.count(told.compared)}; 1.23e+03 at the rate before"
    assert not found.worse


def test_finding_that_was_not_asked_for_is_told_so(compared: Any) -> None:
    assert [why for _, why in compared(not_asked).gone] == [NOT_ASKED]


def test_finding_shown_by_another_scene_has_moved(compared: Any) -> None:
    found = compared(moved)
    assert (found.new, found.gone, found.same, found.worse) == ((), (), 9, False)
    assert [change.what for change in found.changed] == [("was shown as deep · 1e-1",)]


@pytest.mark.parametrize(
    ("severity", "worse"), [("wrong boolean", True), ("small", False), ("no answer", True), ("anything", False)]
)
def test_severity(compared: Any, severity: str, worse: bool) -> None:
    found = compared(lambda data: data["buckets"][2].update(severity=severity))
    assert [(change.what[0].split(" → ")[-1], change.worse) for change in found.changed] == [(severity, worse)]
    assert found.worse is worse


@pytest.mark.parametrize(
    ("factor", "said", "worse"),
    [(1.0, [], False), (1.05, [], False), (1.9, [], False), (3.0, ["more"], True), (0.3, ["less"], False)],
)
def test_rates_have_changed_where_chance_does_not_explain_it(
    compared: Any, factor: float, said: list[str], worse: bool
) -> None:
    found = compared(counted(factor))
    assert [change.what[0].split()[0] for change in found.changed] == said
    assert found.worse is worse


def test_rare_findings_do_not_change_by_chance(compared: Any) -> None:
    assert compared(lambda data: data["buckets"][4].update(count=9)).changed == ()
    assert compared(lambda data: data["buckets"][4].update(count=90)).worse


def test_upgrade_cells_and_ledger_are_told(compared: Any) -> None:
    def change(data: Any) -> None:
        upgraded(data)
        data["support"][0]["kind"] = "unsupported"
        data["ledger"][0]["state"] = "STALE"
        data["ledger"].pop(1)

    found = compared(change)
    assert diff_report.headline(found).startswith("python-fcl 0.7.0.11 → 0.8: 0 new findings")
    assert [(old, new) for _, old, new in found.cells] == [("native", "unsupported")]
    assert found.entries == (("fcl · tolerance", "expected", "STALE"), ("fcl · mended", "STALE", "not there"))
    assert not found.worse


def everything(data: Any) -> None:
    for change in (not_asked, new_one, upgraded, counted(1.0)):
        change(data)
    data["buckets"][1].update(severity="wrong boolean")
    data["support"][0]["kind"] = "unsupported"
    data["ledger"][0]["state"] = "STALE"


def test_all_of_it_is_told_in_markdown(compared: Any) -> None:
    said = diff_report.as_markdown(compared(everything))
    headings = [line for line in said.splitlines() if line.startswith("## ")]
    assert headings == [
        "## New",
        "## Changed",
        "## Gone",
        "## Cells answered otherwise",
        "## Ledger",
        "## What ran",
    ]
    assert "a new one" in said
    assert "0.7.0.11" in said


def test_all_of_it_is_told_in_html(compared: Any) -> None:
    found = compared(everything)
    page = Page(diff_report.as_html(found))
    assert page.tags["table"] == len(diff_report.parts(found)) == 6
    assert diff_report.headline(found) in page.words
    assert "a new one" in page.words
    assert page.tags["script"] == 0
    assert not [value for name in ("src", "href", "style") for value in page.values(name)]
    assert any("default-src 'none'" in value for value in page.values("content"))


# -- accuracy ------------------------------------------------------------------------------------------------


def measured(valued: int, median: float, p99: float, engine: str = "fcl") -> Accuracy:
    spread = Spread(median, p99, 1.0)
    return Accuracy((Errors(engine, DISTANCE, "Box–Box", "", valued, valued, 0, 0, spread, spread, None, None),))


@pytest.mark.parametrize(
    ("valued", "median", "p99", "rank"),
    [
        (5000, 1e-9, 1e-7, None),
        (5000, 2.9e-9, 9e-7, None),
        (5000, 4e-9, 1e-7, "median"),
        (5000, 1e-9, 2e-6, "p99"),
        (5000, 2e-10, 1e-7, "median"),
        (90, 1e-8, 1e-3, None),
        (900, 1e-9, 1e-3, None),
        (900, 1e-8, 1e-3, "median"),
    ],
)
def test_errors_have_shifted_where_that_is_clear(valued: int, median: float, p99: float, rank: str | None) -> None:
    found = list(shifts(measured(5000, 1e-9, 1e-7), measured(valued, median, p99)))
    assert [shift.rank for shift in found] == ([rank] if rank else [])
    assert [shift.worse for shift in found] == ([median >= 1e-9] if rank else [])


def test_rounding_is_no_shift() -> None:
    assert list(shifts(measured(5000, 0.0, 0.0), measured(5000, 9e-16, 9e-16))) == []
    assert [shift.worse for shift in shifts(measured(5000, 0.0, 0.0), measured(5000, 1e-14, 1e-14))] == [True]


def test_cells_of_one_run_only_are_not_compared() -> None:
    assert list(shifts(measured(5000, 1e-9, 1e-7), measured(5000, 1.0, 1.0, engine="bullet"))) == []
    assert list(shifts(Accuracy(), measured(5000, 1.0, 1.0))) == []


def test_lost_accuracy_is_worse(tmp_path: Path) -> None:
    places = []
    for median in (1e-9, 1e-6):
        run = sample_run()
        run.accuracy = measured(5000, median, 1e-3)
        places.append(saved(json.loads(summary.report_json(run)), tmp_path / repr(median)))
    before, after = map(report_at, places)
    assert compare(before, after).worse
    assert not compare(after, before).worse
    assert "less accurate in 1 cell, more in 0" in diff_report.headline(compare(before, after))
    assert "fcl · distance · Box–Box" in diff_report.as_markdown(compare(before, after))


# -- the command ---------------------------------------------------------------------------------------------


@pytest.fixture
def both(data: Any, tmp_path: Path) -> tuple[str, str]:
    after = copy.deepcopy(data)
    everything(after)
    return str(saved(data, tmp_path / "a")), str(saved(after, tmp_path / "b"))


def test_diff_prints_and_its_status_tells(both: tuple[str, str], capsys: pytest.CaptureFixture[str]) -> None:
    before, after = both
    assert cli.main(["diff", before, after]) == 1
    said = capsys.readouterr().out
    assert said.startswith("python-fcl 0.7.0.11 → 0.8: 1 new finding, 1 gone, 1 changed (1 for the worse), 8 the same.")
    assert "a new one" in said
    assert cli.main(["diff", before, before + "/report.json"]) == 0


def test_diff_is_written_where_it_is_asked_to(
    both: tuple[str, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["diff", *both, "--markdown"]) == 1
    markdown = capsys.readouterr().out
    assert cli.main(["diff", *both, "--out", str(tmp_path / "diff.md")]) == 1
    assert (tmp_path / "diff.md").read_text("utf-8") == markdown
    assert cli.main(["diff", *both, "--out", str(tmp_path / "diff.html"), "--out", str(tmp_path / "too.md")]) == 1
    assert (tmp_path / "diff.html").read_text("utf-8").endswith("</html>")
    assert (tmp_path / "too.md").read_text("utf-8") == markdown
    assert capsys.readouterr().out.count("\n") == 2


def test_diff_of_no_runs(both: tuple[str, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for arguments in (
        [both[0]],
        [both[0], str(tmp_path)],
        [str(tmp_path / "none"), both[0]],
        [*both, "--out", "diff.txt"],
        [*both, "--out", str(tmp_path / "no" / "diff.md")],
    ):
        assert cli.main(["diff", *arguments]) == 2
        assert capsys.readouterr().err.count("\n") == 1


def test_diff_of_hostile_words(tmp_path: Path) -> None:
    def structure(words: str) -> list[str]:
        one, other = hostile_run(words), hostile_run(words)
        other.versions = {words: f"{words}2"}
        other.buckets = []
        reports = [json.loads(summary.report_json(run)) for run in (one, other)]
        for item in reports[0]["buckets"]:
            item.update(id=words, key=words, severity=words)
        places = [saved(data, tmp_path / str(i)) for i, data in enumerate(reports)]
        said = diff_report.as_markdown(compare(*map(report_at, places)))
        return [token.type for token in MarkdownIt("commonmark").enable("table").parse(said)]

    assert structure(NASTY) == structure(TAME)


def test_diff_of_empty_runs(tmp_path: Path) -> None:
    place = saved(json.loads(summary.report_json(Run(0, 1.0, ""))), tmp_path)
    assert diff_report.headline(compare(report_at(place), report_at(place))).endswith("0 the same.")
