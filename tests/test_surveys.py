"""Surveys: engines that answer other things than pairs are asked apart, judged, counted and shown; nothing is lost."""

from __future__ import annotations

import json
import math
import subprocess
import sys
import time
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path

import jsonschema
import pytest

from oracles import plan, surveys
from oracles.bench import Setup, Workshop
from oracles.buckets import Buckets
from oracles.fault import Known, unknown
from oracles.filing import Filing
from oracles.isolation import children, processes
from oracles.isolation.children import Said, ask_apart
from oracles.ledger import Ledger
from oracles.outcome import Run
from oracles.surveys.judging import SurveyCount, judged
from oracles.surveys.survey import Case, SurveyEngine
from oracles.tasks import SurveyTask
from refimpl.pairs import TABLE
from reports import html, junit, ledgers, markdown
from reports.findings import warnings
from reports.reading import NoReport, run_from_data
from reports.running import FINISHED, INCOMPLETE, REFERENCE_WRONG, exit_status
from reports.summary import report_data, report_json, schema
from tests import surveyed
from tests.surveyed import Roots
from tests.test_executors import gone


@pytest.fixture(autouse=True)
def _registered(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(surveys, "SURVEYS", {"roots": "tests.surveyed:Roots"})
    monkeypatch.setattr(plan, "SURVEYS", surveys.SURVEYS)


def verdicts(engine: SurveyEngine, name: str = "planted", known: Known = unknown) -> dict[tuple[str, str], SurveyCount]:
    def asker(cases: Sequence[Case]) -> list[Said]:
        return [Said(engine.answer(case)) for case in cases]

    survey = Roots()
    return {(c.question, c.regime): c for c in judged(survey, name, engine, survey.cases(0), asker, known)}


def run_with(counts: dict[tuple[str, str], SurveyCount]) -> Run:
    return Run(0, 1.0, "2026-01-01T00:00:00+00:00", surveys=list(counts.values()))


def test_a_right_engine_is_found_right() -> None:
    found = verdicts(surveyed.Right())
    assert set(found) == {(q, r) for q in Roots.questions for r in Roots.regimes}
    assert all(count.right == count.asked > 0 and not count.failed and not count.witnesses for count in found.values())
    worst = max(abs(Fraction(math.sqrt(n)) ** 2 - Fraction(n)) / Fraction(n) for n in surveyed.NUMBERS if n > 100)
    assert found["root", "large"].worst == float(worst) > 0


def test_a_wrong_engine_is_counted_and_shown_by_the_simplest_case() -> None:
    found = verdicts(surveyed.Halves())
    small, large = found["root", "small"], found["root", "large"]
    assert (small.asked, small.right, small.wrong) == (5, 2, 3)
    assert (large.wrong, large.worst) == (2, float(Fraction(1e9) / 4 - 1))
    (witness,) = small.witnesses
    assert witness.case.data == {"number": 1.0}
    assert witness.judgement is not None
    assert witness.judgement.amount == 0.75
    assert not large.witnesses  # one for each question, symptom and entry
    assert not found["sign", "small"].failed


def test_a_known_fault_is_counted_apart() -> None:
    found = verdicts(surveyed.Halves(), known=lambda fault: "halves" if fault.amount < 1 else "")
    count = found["root", "small"]
    assert (count.known, count.wrong, count.explained) == (2, 1, {"halves": 2})
    assert [(shown.case.data["number"], shown.entry) for shown in count.witnesses] == [(1.0, "halves"), (8.0, "")]
    assert count.failed
    assert exit_status(run_with(verdicts(surveyed.Halves(), known=lambda fault: "halves"))) == FINISHED


def test_an_answer_that_is_no_number_is_no_right_answer() -> None:
    found = verdicts(surveyed.NotANumber())
    assert found["root", "large"].lost == 2
    assert found["root", "small"].right == 5


def test_a_crash_a_hang_and_nonsense_are_lost_and_nothing_else_is() -> None:
    cases = Roots().cases(0)[: len(surveyed.NUMBERS)]
    said = ask_apart(
        "oracles.surveys.survey:answerer", "tests.surveyed:Fragile math", [case.to_json() for case in cases], 0.3
    )
    lost = dict(zip(surveyed.NUMBERS, said, strict=True))
    assert (lost[0.0].answer, lost[2.0].answer) == (0.0, math.sqrt(2))
    assert "SIGSEGV" in lost[1.0].lost
    assert lost[4.0].lost == "no answer within 0.3 s"
    assert lost[10.0].lost == "RuntimeError: no roots of ten"
    assert (lost[1e9].answer, lost[1e9].lost) == ("a potato", "")  # it is for the judge to say that it is none
    assert "not JSON serializable" in lost[123456.789].lost
    with pytest.raises(ValueError, match="potato"):
        Roots().judge(cases[5], lost[1e9].answer)


def test_an_adapter_that_does_not_load_loses_all_and_ends() -> None:
    found = SurveyTask("roots", "right").do(Workshop(Setup(())))
    assert all(count.right == count.asked for count in found.surveys)
    assert [count.absent for count in SurveyTask("roots", "absent").do(Workshop(Setup(()))).surveys] == [
        "needs the module no_such_module_at_all, which is not installed: pip install nothing"
    ]
    said = ask_apart("oracles.surveys.survey:answerer", "tests.surveyed:NoSuchClass math", [{}] * 3, 0.5)
    assert ["NoSuchClass" in one.lost for one in said] == [True] * 3
    gone = ask_apart("oracles.isolation.no_such_module:answerer", "", [{}] * 9, 0.5)
    assert ["no_such_module" in one.lost for one in gone] == [True] * 9


def test_many_hangs_do_not_hold_up_a_run_and_crashes_lose_nothing_else(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(children, "MOST_LOST", 1)

    def asked(*numbers: float) -> list[Said]:
        cases = [Case("root", "", {"number": number}).to_json() for number in numbers]
        return ask_apart("oracles.surveys.survey:answerer", "tests.surveyed:Fragile math", cases, 0.1)

    hung = asked(2.0, 4.0, 2.0)
    assert [bool(one.lost) for one in hung] == [False, True, True]
    assert hung[2].lost == "not asked any more: no answer within 0.1 s"
    crashed = asked(1.0, 1.0, 2.0, 1.0)
    assert ["SIGSEGV" in one.lost for one in crashed] == [True, True, False, True]


def test_memory_beyond_the_limit_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    cases = [Case("root", "", {"number": number}).to_json() for number in (1.0, 2.0)]
    for limit, lost in ((1 << 27, "MemoryError: "), (1 << 30, "")):
        monkeypatch.setattr(children, "MEMORY", limit)
        first, second = ask_apart("oracles.surveys.survey:answerer", "tests.surveyed:Leaking math", cases, 2.0)
        assert first.lost == lost
        assert (second.answer, second.lost) == (math.sqrt(2), "")


def test_no_child_is_left_when_the_campaign_is_killed() -> None:
    asking = (
        "from oracles.isolation.children import ask_apart; case = {'question': 'root', 'regime': '', 'data': "
        "{'number': 4.0}}; ask_apart('oracles.surveys.survey:answerer', 'tests.surveyed:Fragile math', [case], 600.0)"
    )
    with subprocess.Popen([sys.executable, "-c", asking], cwd=Path(__file__).parents[1]) as parent:
        patience = time.monotonic() + 30
        while not (below := list(processes.below((parent.pid,)))) and time.monotonic() < patience:
            time.sleep(0.01)
        parent.kill()
    assert below
    assert all(gone(one.number, within=10.0) for one in below)


def test_a_busy_machine_is_no_hang(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(children, "main_thread_time", lambda number: 0.0)  # it got no processor
    number = {"number": 3.0}
    case = Case("root", "", number).to_json()
    said = ask_apart("oracles.surveys.survey:answerer", "tests.surveyed:Slow math", [case, case], 0.2)
    assert [one.answer for one in said] == [math.sqrt(3.0)] * 2


def test_the_plan_asks_surveys_with_shipped_engines_and_all_pairs_only() -> None:
    pairs = list(TABLE)
    names = [task.name for task in plan.surveys(Ledger(), ["fcl"], pairs)]
    assert names == [f"survey-roots-{engine}" for engine in Roots.engines]
    assert not list(plan.surveys(Ledger(), ["fcl"], pairs[1:]))
    assert not list(plan.surveys(Ledger(), ["mine"], pairs))


def test_reports_show_what_was_found_and_read_it_back() -> None:
    counts = verdicts(surveyed.Halves())
    run = run_with(counts)
    run.surveys.append(SurveyCount("roots", "absent", absent="needs a thing"))
    data = json.loads(report_json(run))
    jsonschema.validate(data, json.loads(schema()))
    again = run_from_data(data)
    assert report_data(again)["surveys"] == data["surveys"]
    new = ledgers.settle(run, Ledger(own=(Path("own.toml"),)), update=False)
    assert [exit_status(one, settled=new) for one in (run, again)] == [INCOMPLETE] * 2
    page, lines, cases = html.render(run), markdown.render(run), junit.render(run, [])
    for said in ("Square roots", "✗ 3 of 5 wrong", "root(1.0)", "needs a thing"):
        assert said in page
        assert said in lines.replace("\\", "")
    told = "survey roots, planted, root: 5 wrong and 0 lost of 7"
    assert told in warnings(run)
    assert told in page
    assert 'failures="1"' in cases
    assert "small: 3 wrong and 0 lost of 5; large: 2 wrong and 0 lost of 2" in cases


def test_the_reference_is_not_excused_where_it_is_wrong_and_proves_nothing_where_it_is_lost() -> None:
    assert exit_status(run_with(verdicts(surveyed.Halves(), "refimpl"))) == REFERENCE_WRONG
    assert exit_status(run_with(verdicts(surveyed.NotANumber(), "refimpl"))) == INCOMPLETE


def test_a_witness_that_shows_nothing_is_refused() -> None:
    data = report_data(run_with(verdicts(surveyed.Halves())))
    witness = next(item["witnesses"][0] for item in data["surveys"] if item["witnesses"])
    for name, value in (("answer", 1.0), ("answer", "potato"), ("tolerance", 9.0), ("lost", 3)):
        before, witness[name] = witness[name], value
        with pytest.raises(NoReport, match="damaged"):
            run_from_data(data)
        witness[name] = before
    witness["case"]["data"] = {"number": "Infinity"}
    with pytest.raises(NoReport, match="damaged"):
        run_from_data(data)
    witness["case"]["data"] = {"number": 1.0}
    assert run_from_data(data).surveys
    data["surveys"][0]["survey"] = "os:system"
    with pytest.raises(NoReport, match="no survey"):
        run_from_data(data)


def test_filing_adds_what_surveys_found() -> None:
    run = Run(0, 1.0, "")
    task = SurveyTask("roots", "absent")
    Filing(run, Buckets(Ledger())).file(task, task.do(Workshop(Setup(()))))
    assert [count.engine for count in run.surveys] == ["absent"]
