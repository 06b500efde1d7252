"""What people read: complete, consistent, and harmless whatever an engine says."""

from __future__ import annotations

import dataclasses
import re
from collections import Counter
from fractions import Fraction
from typing import get_args

import pytest

from oracles.outcome import COMPARED, Kind, Run, SupportNote, Verdict
from oracles.scene import DISTANCE, cells
from refimpl.proof import checker
from reports import findings, html, markdown, tables, text
from tests.sample_run import Page, sample_run


@pytest.fixture(scope="module")
def run() -> Run:
    return sample_run()


@pytest.fixture(scope="module")
def page(run: Run) -> Page:
    return Page(html.render(run))


@pytest.fixture(scope="module")
def notes(run: Run) -> str:
    return markdown.render(run)


# -- counts --------------------------------------------------------------------------------------------------


def amount(entry: tables.Entry) -> int:
    return int(entry.text.replace(text.THIN, ""))


def test_summary_adds_up(run: Run) -> None:
    table = tables.summary(run)
    kinds = [column.title for column in table.columns]
    sums: dict[str, int] = {}
    for row in table.rows:
        engine, _, query = row[0].text.partition(" · ")
        by_kind = dict(zip(kinds[1:], map(amount, row[1:]), strict=True))
        parts = sum(n for kind, n in by_kind.items() if kind not in ("compared", "skipped"))
        assert by_kind["compared"] == parts
        if query:
            sums[engine] = sums.get(engine, 0) + parts
            assert parts == run.total(engine=engine, query=query, kinds=COMPARED)
    assert sums == {engine: run.total(engine=engine, kinds=COMPARED) for engine in run.engines}


def test_coverage_and_regimes_add_up(run: Run) -> None:
    coverage = tables.coverage(run)
    assert all(amount(row[1]) == sum(map(amount, row[2:])) for row in coverage.rows)
    answers = sum(run.total(engine=engine, kinds=COMPARED) for engine in run.engines)
    assert sum(amount(row[1]) for row in coverage.rows) == answers
    assert sum(amount(row[2]) for row in tables.regime_table(run).rows) == answers


def test_matrix_has_every_pair_and_every_cell(run: Run) -> None:
    rows = [row for table in tables.matrices(run, {}) for row in table.rows]
    assert sorted(row[0].text for row in rows) == sorted({cell.pair for cell in cells()})
    assert len(rows) == 25
    assert sum(len(row) - 1 for row in rows) == len(run.engines) * len(cells())


@pytest.mark.parametrize(
    ("verdicts", "state", "words"),
    [
        ({Kind.AGREES: 1234}, "ok", "✓ 1\u202f234"),
        ({Kind.AGREES: 3, Kind.UNDECIDED: 1}, "ok", "✓ 4"),
        ({Kind.UNDECIDED: 2}, "undecided", "? 2"),
        ({Kind.AGREES: 3, Kind.CONVENTION: 1}, "convention", "≈ 4"),
        ({Kind.AGREES: 3, Kind.CRASHED: 1}, "crashed", "✗ crashed 1 of 4"),
        ({Kind.AGREES: 3, Kind.TIMED_OUT: 2, Kind.SKIPPED: 5}, "timed-out", "✗ timed out 2 of 5"),
        ({Kind.WRONG: 2, Kind.CRASHED: 1, Kind.AGREES: 1}, "wrong", "✗ 2 of 4"),
        ({Kind.REFERENCE_WRONG: 1, Kind.WRONG: 2}, "reference-wrong", "✗ reference wrong 1 of 3"),
        ({Kind.SKIPPED: 5}, "problem", "! nothing compared"),
        ({}, "problem", "! nothing compared"),
    ],
)
def test_matrix_entry_names_the_worst(verdicts: dict[Kind, int], state: str, words: str) -> None:
    run = Run(0, 1.0, "", engines=["e"], support={("e", DISTANCE, "Box–Box"): SupportNote("native", "")})
    run.counts.update({("e", DISTANCE, "Box–Box", "generic", kind): n for kind, n in verdicts.items()})
    box_box = next(row for row in tables.matrices(run, {})[0].rows if row[0].text == "Box–Box")
    assert (box_box[1].state, box_box[1].text) == (state, words)


def test_audits_of_the_reference_are_no_answers_of_an_engine(run: Run) -> None:
    assert tables.engines(run) == ["fcl", "bullet"]
    assert tables.audit(run) == Counter({Kind.AGREES: 75})
    assert tables.summary(run).rows[-1][0] == tables.Entry("refimpl", "audited")


# -- sentences -----------------------------------------------------------------------------------------------


def test_headline_names_what_each_engine_did(run: Run) -> None:
    said = findings.headline(run).replace(text.THIN, "")
    assert re.search(r"fcl is wrong in 1071 of \d+ scenes and did not return on 2 scenes", said)
    assert re.search(r"bullet is wrong in 1243 of \d+ scenes and crashed on 4 scenes", said)
    assert said.endswith("8 buckets, 7 new.")


def test_headline_of_a_wrong_reference_says_nothing_else() -> None:
    run = sample_run()
    run.buckets[0].witness = dataclasses.replace(run.buckets[0].witness, verdict=Verdict(Kind.REFERENCE_WRONG))
    assert findings.headline(run).startswith("The reference itself was proven wrong")


def test_every_claim_has_words() -> None:
    vector = (1.0, 0.0, Fraction(1, 3))
    claims = [
        checker.Separated(vector),
        checker.Separated(vector, 2.0),
        checker.Escape(vector),
        checker.Near(vector, vector),
        checker.Common(vector),
        checker.Common(None, 1.5),
        checker.Core(((vector, vector),)),
        checker.Core(((vector, vector),), ((0, 0, 0),)),
        checker.Core(((vector, vector),), ((0, 0, 0),), directions=True),
    ]
    assert {type(claim) for claim in claims} == set(get_args(checker.Claim))
    said = [findings.claim_in_words(claim) for claim in claims]
    assert len(set(said)) == len(said)
    assert all("(1.0, 0.0, 1/3)" in words for words in said[:5])


def test_proof_on_other_proxies_is_shown_with_them(run: Run, page: Page, notes: str) -> None:
    assert "for the Point and the Box of the certificate" in page.words
    for said in (page.words, notes):
        assert "Point(position=[1.0, 0.0, 2.0])" in said


# -- pages ---------------------------------------------------------------------------------------------------


def test_ids_are_unique_and_links_resolve(run: Run, page: Page) -> None:
    ids = page.values("id")
    assert len(ids) == len(set(ids))
    links = page.values("href")
    assert all(link.startswith("#") for link in links)
    assert {link[1:] for link in links} <= set(ids)
    assert {f"bucket-{i}" for i in range(1, len(run.buckets) + 1)} <= set(ids)
    assert set(page.values("aria-labelledby")) <= set(ids)


def test_page_needs_no_network_and_no_script(run: Run, page: Page) -> None:
    assert not page.tags.keys() & {"script", "link", "img", "iframe", "object", "embed", "base", "form"}
    assert not page.values("src")
    assert not any(name.startswith("on") for name, _ in page.attributes)
    style = re.search(r"<style>(.*?)</style>", html.render(run), re.DOTALL)
    assert style
    assert not re.search(r"url\(|@import", style[1])


def test_page_is_made_of_proper_tables(run: Run, page: Page) -> None:
    assert page.tags["caption"] == page.tags["table"] > 5
    assert set(page.values("scope")) == {"row", "col", "colgroup"}
    assert page.tags["h1"] == 1


@pytest.mark.parametrize("form", ["html", "markdown"])
def test_every_bucket_is_told_in_full(run: Run, page: Page, notes: str, form: str) -> None:
    said = page.words if form == "html" else notes.replace("\\", "")
    for view, its in zip(findings.bucket_views(run), run.buckets, strict=True):
        for words in (
            view.title,
            view.story,
            view.severity,
            view.file,
            view.known,
            *(proxy for _, proxy in view.scene),
        ):
            assert words in said
        verdict = its.witness.verdict
        assert repr(verdict.lower) in said
        assert repr(verdict.upper) in said
        for answer in (its.witness.answer, its.witness.reference):
            assert all(text.full(value) in said for name, value in answer.items() if name != "hit")
        if verdict.certificate is not None:
            assert all(findings.claim_in_words(claim) in said for claim in verdict.certificate.claims)
        assert all(line in said for line in its.repro.splitlines())


@pytest.mark.parametrize("form", ["html", "markdown"])
def test_both_forms_have_all_rows(run: Run, page: Page, notes: str, form: str) -> None:
    said = page.words if form == "html" else notes.replace("\\", "")
    everything = [tables.summary(run), *tables.matrices(run, {}), tables.regime_table(run), tables.coverage(run)]
    for table in (*everything, tables.support_notes(run), tables.timing(run)):
        for row in table.rows:
            assert all(entry.text in said for entry in row)


def test_run_without_findings_renders() -> None:
    run = sample_run()
    run.buckets.clear()
    assert "None." in Page(html.render(run)).words
    assert "## Findings\n\nNone.\n" in markdown.render(run)


def test_empty_run_renders() -> None:
    run = Run(0, 1.0, "2026-01-01T00:00:00Z", interrupted=True, problems=["nothing ran"])
    for said in (Page(html.render(run)).words, markdown.render(run)):
        assert "The run was interrupted" in said
        assert "nothing ran" in said


def test_markdown_tables_are_well_formed(notes: str) -> None:
    rows = 0
    for block in re.split(r"\n(?!\|)", notes):
        lines = [line for line in block.split("\n") if line.startswith("|")]
        assert len({len(re.findall(r"(?<!\\)\|", line)) for line in lines}) <= 1
        rows += len(lines)
    assert rows > 200
