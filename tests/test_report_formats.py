"""The forms that programs read, each held against its schema and read by somebody else's parser."""

from __future__ import annotations

import copy
import dataclasses
import json
from collections import Counter
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import junitparser
import pytest
from jsonschema import Draft202012Validator
from markdown_it import MarkdownIt
from sarif.loader import load_sarif_file
from sarif_kit.validate import validation_errors

from oracles.outcome import Kind, Run, Severity, State, SupportNote
from oracles.scene import QUERIES, TYPES
from refimpl.proof.wire import KINDS
from reports import findings, issues, junit, running, sarif, summary
from tests.sample_run import bucket, sample_run
from tests.test_report_hostile import NASTY, TAME, hostile_run

SCHEMA = json.loads(summary.schema())


@pytest.fixture(scope="module")
def run() -> Run:
    return sample_run()


def as_expected() -> Run:
    """A run in which nothing asks for anything to be done."""
    run = sample_run()
    for its in run.buckets:
        its.state, its.entry, its.cause = State.EXPECTED, "tolerance", "known"
    run.ledger = [note for note in run.ledger if note.state in (State.EXPECTED, State.UNMATCHED)]
    return run


def as_junit(run: Run) -> str:
    return junit.render(run, findings.bucket_views(run))


def as_sarif(run: Run) -> str:
    return sarif.render(run, findings.bucket_views(run))


def sarif_log(run: Run) -> Any:
    return json.loads(as_sarif(run))


# -- report.json ---------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def data(run: Run) -> Any:
    return json.loads(summary.report_json(run))


def test_schema_is_one() -> None:
    Draft202012Validator.check_schema(SCHEMA)


def test_report_is_of_its_schema(data: Any) -> None:
    validator = Draft202012Validator(SCHEMA)
    assert list(validator.iter_errors(data)) == []
    assert list(validator.iter_errors(json.loads(summary.report_json(Run(0, 1.0, ""))))) == []
    assert data["$schema"] == summary.SCHEMA


def test_schema_knows_what_the_code_knows() -> None:
    names = SCHEMA["$defs"]
    assert names["verdict"]["enum"] == [kind.value for kind in Kind]
    assert names["state"]["enum"] == [state.value for state in State]
    assert names["severity"]["enum"] == [severity.value for severity in Severity]
    assert set(names["query"]["enum"]) == set(QUERIES)
    assert set(names["proxy"]["properties"]["type"]["enum"]) == set(TYPES)
    told = {entry["properties"]["kind"]["const"]: entry for entry in names.values() if "const" in _kind(entry)}
    assert set(told) == set(KINDS)
    for name, (_, parts) in KINDS.items():
        assert set(told[name]["properties"]) == {"kind", *parts}


def _kind(entry: Any) -> Any:
    return entry.get("properties", {}).get("kind", {})


def _first(data: Any) -> Any:
    return data["buckets"][0]


@pytest.mark.parametrize(
    "spoil",
    [
        lambda data: data.pop("digest"),
        lambda data: data.update(more=1),
        lambda data: data.update(format="proxyproof-report-0"),
        lambda data: data["counts"][0].update(verdict="fine"),
        lambda data: data["counts"][0].update(count=-1),
        lambda data: data["support"][0].pop("reason"),
        lambda data: data["ledger"][0].update(state="OLD"),
        lambda data: _first(data).update(id="XYZ"),
        lambda data: _first(data).update(lower="nan"),
        lambda data: _first(data).update(decade=0.5),
        lambda data: _first(data)["scene"]["a"].update(type="Torus"),
        lambda data: _first(data)["scene"]["a"]["numbers"].append("1"),
        lambda data: _first(data)["certificate"]["claims"][0].update(kind="trust me"),
        lambda data: _first(data)["certificate"]["claims"][0].update(more=1),
        lambda data: data["buckets"][8]["certificate"]["residuals"].update(energy="a lot"),
        lambda data: data["buckets"][8]["scene"]["motion"].update(restitution=2),
    ],
)
def test_schema_refuses(data: Any, spoil: Any) -> None:
    whole = {name: value[:9] if isinstance(value, list) else value for name, value in data.items()}
    assert Draft202012Validator(SCHEMA).is_valid(whole)
    spoiled = copy.deepcopy(whole)
    spoil(spoiled)
    assert not Draft202012Validator(SCHEMA).is_valid(spoiled)


# -- junit.xml -----------------------------------------------------------------------------------------------


def cases_of(run: Run) -> dict[tuple[str, str], junitparser.TestCase]:
    """Cases by class and name, as junitparser reads them."""
    suites = junitparser.JUnitXml.fromroot(ElementTree.fromstring(as_junit(run).encode()))
    found = {(case.classname, case.name): case for suite in suites for case in suite}
    for suite in suites:
        assert suite.tests == len(list(suite))
        assert suite.failures == sum(isinstance(r, junitparser.Failure) for case in suite for r in case.result)
        assert suite.errors == sum(isinstance(r, junitparser.Error) for case in suite for r in case.result)
        assert suite.skipped == sum(isinstance(r, junitparser.Skipped) for case in suite for r in case.result)
    assert suites.tests == len(found)
    return found


def test_junit_has_a_case_for_each_cell_and_entry(run: Run) -> None:
    cases = cases_of(run)
    cells = {(f"{engine}.{query}", pair) for engine, query, pair in run.support}
    entries = {(f"{note.engine}.ledger", note.name) for note in run.ledger}
    assert set(cases) == cells | entries | {("proxyproof", "run is complete")}
    for (engine, query, pair), note in run.support.items():
        skipped = [r for r in cases[f"{engine}.{query}", pair].result if isinstance(r, junitparser.Skipped)]
        assert bool(skipped) == (note.kind == "unsupported")
        assert [r.message for r in skipped] == [note.reason] * len(skipped)


def test_junit_fails_what_is_new_stale_or_changed(run: Run) -> None:
    failing = {name for name, case in cases_of(run).items() if case.is_failure}
    new = {(f"{b.engine}.{b.query}", b.pair) for b in run.buckets if b.state is State.NEW}
    entries = {(f"{n.engine}.ledger", n.name) for n in run.ledger if n.state in (State.STALE, State.CHANGED)}
    assert failing == new | entries
    told = cases_of(run)["fcl.boolean", "Sphere–Capsule"].result[0]
    assert told.type == "missed contact"
    assert "1 new finding: missed contact" in told.message
    assert "repro/001-fcl-boolean-Sphere-Capsule-missed-contact.py" in told.text


def test_junit_passes_what_is_expected() -> None:
    cases = cases_of(as_expected())
    assert not any(case.is_failure or case.is_error for case in cases.values())
    assert "[expected]" in cases["fcl.boolean", "Sphere–Capsule"].system_out


def _lose_a_regime(run: Run) -> None:
    run.counts = Counter({key: n for key, n in run.counts.items() if key[:3] != ("fcl", "boolean", "AABB–AABB")})


def _against_reference(run: Run) -> None:
    its = run.buckets[0]
    its.state = State.NEW
    its.witness = dataclasses.replace(
        its.witness, verdict=dataclasses.replace(its.witness.verdict, kind=Kind.REFERENCE_WRONG)
    )


@pytest.mark.parametrize(
    ("change", "case", "outcome"),
    [
        (lambda run: None, None, None),
        (lambda run: run.problems.append("a worker was lost"), ("proxyproof", "run is complete"), "is_error"),
        (lambda run: setattr(run, "interrupted", True), ("proxyproof", "run is complete"), "is_error"),
        (_lose_a_regime, ("fcl.boolean", "AABB–AABB"), "is_error"),
        (_against_reference, ("fcl.boolean", "Sphere–Capsule"), "is_error"),
        (lambda run: run.buckets.pop(0), ("fcl.boolean", "Sphere–Capsule"), "is_failure"),
        (lambda run: setattr(run.buckets[0], "state", State.NEW), ("fcl.boolean", "Sphere–Capsule"), "is_failure"),
        (lambda run: run.ledger.append(sample_run().ledger[1]), ("fcl.ledger", "mended"), "is_failure"),
    ],
)
def test_junit_is_red_where_it_should_be(change: Any, case: Any, outcome: str | None) -> None:
    run = as_expected()
    change(run)
    bad = {name for name, its in cases_of(run).items() if its.is_failure or its.is_error}
    assert bad == ({case} if case else set())
    if case:
        assert getattr(cases_of(run)[case], str(outcome))


def test_junit_is_green_when_the_exit_status_is() -> None:
    run = as_expected()
    assert running.exit_status(run, settled=not run.unsettled[State.NEW]) == 0
    assert 'failures="0" errors="0"' in as_junit(run)


def test_junit_of_hostile_words() -> None:
    nasty, tame = (ElementTree.fromstring(as_junit(hostile_run(words))) for words in (NASTY, TAME))
    assert [element.tag for element in nasty.iter()] == [element.tag for element in tame.iter()]
    assert len(as_junit(hostile_run(TAME, error="x" * 10_000_000))) < 100_000


# -- report.sarif --------------------------------------------------------------------------------------------


def test_sarif_is_of_the_standards_schema(run: Run) -> None:
    for its in (run, as_expected(), hostile_run(NASTY), Run(0, 1.0, "")):
        assert validation_errors(json.loads(as_sarif(its))) == []


def test_sarif_has_a_result_for_each_bucket(run: Run) -> None:
    log = sarif_log(run)["runs"][0]
    rules = log["tool"]["driver"]["rules"]
    assert [r["fingerprints"][sarif.FINGERPRINT] for r in log["results"]] == [its.id for its in run.buckets]
    for its, result in zip(run.buckets, log["results"], strict=True):
        assert rules[result["ruleIndex"]]["id"] == result["ruleId"] == its.symptom.replace(" ", "-")
        assert bool(result["suppressions"]) == (its.state is State.EXPECTED)
        assert (result["baselineState"] == "new") == (its.state is State.NEW)
        assert result["occurrenceCount"] == its.count
    assert [result["level"] for result in log["results"][:5]] == ["error", "error", "error", "warning", "note"]
    told = [note["message"]["text"] for note in log["invocations"][0]["toolExecutionNotifications"]]
    assert [line[:7] for line in told] == ["STALE e", "CHANGED"]


def test_fingerprint_outlives_other_findings(run: Run) -> None:
    fewer = sample_run()
    del fewer.buckets[0]
    assert fewer.buckets[0].id == run.buckets[1].id
    assert len({its.id for its in run.buckets}) == len(run.buckets)


def test_sarif_is_read_by_sarif_tools(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "report.sarif"
    path.write_text(as_sarif(run), "utf-8")
    read = load_sarif_file(str(path))
    assert read.get_distinct_tool_names() == ["proxyproof"]
    found = read.get_report()
    assert [found.get_issue_count_for_severity(level) for level in ("error", "warning", "note")] == [5, 2, 3]
    first = read.get_records()[0]
    assert first["Location"] == "repro/001-fcl-boolean-Sphere-Capsule-missed-contact.py"


def test_sarif_messages_hold_no_links(run: Run) -> None:
    said = sarif_log(hostile_run("[a](http://b.example)"))["runs"][0]["results"][0]["message"]["text"]
    assert r"\[a\](http://b.example)" in said


# -- issues --------------------------------------------------------------------------------------------------


def issues_of(run: Run) -> list[str]:
    return list(issues.issues(run, findings.bucket_views(run)))


@pytest.fixture(scope="module")
def texts(run: Run) -> list[str]:
    return issues_of(run)


def test_issue_has_every_part_a_maintainer_needs(run: Run, texts: list[str]) -> None:
    for its, text in zip(run.buckets, texts, strict=True):
        headings = [line for line in text.splitlines() if line.startswith("#")]
        wanted = ["Versions", "Steps to reproduce", "Expected", "Actual", "How often"]
        assert [line.lstrip("# ") for line in headings[1:6] if line.startswith("## ")] == wanted
        assert its.symptom in headings[0]
        assert {"fcl": "python-fcl 0.7.0.11", "bullet": "pybullet 3.2.7"}[its.engine] in text
        assert its.repro.strip() in text
        assert "report.json" not in text
        for name in its.regimes:
            assert run.regimes[name] in text.replace("\\", "")


def test_issue_says_what_is_true_and_why(texts: list[str]) -> None:
    assert "The two overlap: σ = -0.75 (signed distance, exactly)." in texts[0]
    assert "The call does not return." in texts[1]
    assert "The ray hits: 1.133974596215561" in texts[2]
    assert "Of this one they do not: witness off its shape" in texts[4]
    assert "| distance | nan" in texts[5]
    assert "ValueError: nothing came back" in texts[6]
    assert "need a change of at least 0.3" in texts[8]
    assert "The scene, in full precision:" in texts[0]
    assert "The scene, of which the script has every number:" in texts[9]
    assert "- Composite: the union of its parts\n- Polyhedron: " in texts[9]
    for number in (0, 2, 3, 4, 8):
        assert "Why this is so:" in texts[number]
        assert "checked in exact rational arithmetic" in texts[number]


def test_issue_names_what_is_alike() -> None:
    run = sample_run()
    known, like = run.buckets[7], run.buckets[3]
    like.entry = known.entry
    run.support["fcl", "distance", "Box–Box"] = SupportNote("native", "")
    said = issues_of(run)[7]
    assert "https://example.org/1" in said
    assert f"- {like.key}: 355 times" in said


def test_long_script_is_attached() -> None:
    run = sample_run()
    run.buckets[0].repro = "x = 1\n" * 5000
    said = issues_of(run)[0]
    assert "repro/001-fcl-boolean-Sphere-Capsule-missed-contact.py, to be attached" in said
    assert len(said) < 5000


def test_issue_of_hostile_words() -> None:
    def structure(words: str) -> list[str]:
        run = hostile_run(words)
        said = issues_of(run)[0]
        return [token.type for token in MarkdownIt("commonmark").enable("table").parse(said)]

    assert structure(NASTY) == structure(TAME)


def test_issues_stay_in_their_folder() -> None:
    run = sample_run()
    run.buckets = [bucket("../..", run.buckets[0].witness.scene, run.buckets[0].witness.verdict, {"deep": 1})]
    assert findings.bucket_views(run)[0].issue.startswith("issues/001-boolean-")
    assert issues.title(run.buckets[0]).endswith("missed contact, by at least 0.75")
