"""The ledger over the life of a fault that is no scene's: of a survey's engine, and of a broad phase before crowds."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any, ClassVar

import jsonschema
import pytest

from oracles import plan, surveys
from oracles.bench import Setup, Workshop
from oracles.buckets import Buckets
from oracles.crowds import judging as crowd_judging
from oracles.crowds.asking import Answer
from oracles.crowds.boxes import BoxCrowd, crowds
from oracles.crowds.failing import ASKED, LOST, MISSING, NOT_NEAREST
from oracles.fault import BROAD_PHASE
from oracles.filing import Filing
from oracles.isolation.children import Said
from oracles.ledger import Entry, Ledger, settle
from oracles.ledger.reading import LedgerError
from oracles.ledger.studies import CaseWitness, CrowdWitness, failed_in
from oracles.ledger.update import UNEXPLAINED
from oracles.ledger.witness import load_witness, path_of, text_of
from oracles.outcome import Run, State
from oracles.surveys import SURVEYS, load_survey
from oracles.surveys import judging as survey_judging
from oracles.surveys.survey import Case, Library
from oracles.tasks import CrowdTask, Task
from refimpl.pairs import TABLE
from reports import html, junit, ledgers, markdown
from reports.reading import run_from_data
from reports.running import FINISHED, INCOMPLETE, exit_status
from reports.summary import report_data, report_json, schema
from tests.surveyed import Roots, Switched
from tests.test_broad_phase_engines import Exact

PAIRS = list(TABLE)
ENGINES = ["fcl", "planted"]
"""Of the run: the name of one that is shipped, with which surveys are made, and one with a broad phase."""


class Survey(Roots):
    """Of one engine, that can be switched."""

    engines: ClassVar = {"switched": Library("tests.surveyed:Switched", "math", "nothing", "numpy")}


class BroadPhase(Exact):
    """Right or wrong, as is told."""

    finds_nearest: ClassVar[bool] = True
    fault: ClassVar[str] = ""

    def said(self, crowd: BoxCrowd) -> Answer:
        """What it answers."""
        if self.fault == LOST:
            return Answer(lost="it is not there")
        pairs = frozenset((min(p), max(p)) for p in self.pairs(crowd))
        if self.fault == MISSING:
            pairs = frozenset(pair for pair in pairs if not crowd.balls[list(pair)].any())
        gaps = crowd.thinned().gaps()
        apart = [(gaps[i, j], (i, j)) for j in range(len(crowd)) for i in range(j)]
        named = (max if self.fault == NOT_NEAREST else min)(apart, default=(0, None))[1]
        return Answer(pairs, nearest=named)


@pytest.fixture(autouse=True)
def _in_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """Everything but the processes of their own."""

    def asked(maker: str, spec: str, data: Sequence[Any], each: float) -> list[Said]:
        return [_said(Case.from_json(item)) for item in data]

    made = [crowd for crowd in crowds(0, 8) if crowd.regime in ("thrown", "thrown, moved")]
    monkeypatch.setattr(surveys, "SURVEYS", {"roots": "tests.test_ledger_studies:Survey"})
    monkeypatch.setattr(plan, "SURVEYS", surveys.SURVEYS)
    monkeypatch.setattr(survey_judging, "ask_apart", asked)
    monkeypatch.setattr(crowd_judging, "ask", lambda spec, some: [BroadPhase().said(crowd) for crowd in some])
    monkeypatch.setattr("oracles.tasks.crowds", lambda seed, count: made)
    monkeypatch.setattr(BroadPhase, "fault", "")
    monkeypatch.setenv("SWITCHED_FAULT", "")


def _said(case: Case) -> Said:
    try:
        return Said(Switched().answer(case))
    except RuntimeError as error:
        return Said(lost=str(error))


def studied(own: Path, *, update: bool = False) -> tuple[int, Run]:
    """What a campaign does with surveys and crowds, and what the command line does then; gives the exit status."""
    ledger = Ledger.load([own], shipped=False, create=True)
    run = Run(0, 1.0, "2026-01-01T00:00:00+00:00", engines=ENGINES)
    run.engine_versions = plan.versions(ENGINES, PAIRS) | {"planted": "1.0"}
    known = ledger.at(run.engine_versions)
    filing, shop = Filing(run, Buckets(known)), Workshop(Setup(()))
    tasks: list[Task] = list(plan.surveys(known, ENGINES, PAIRS))
    tasks += [task for task in plan.crowds(known, ENGINES, PAIRS) if task.name == "crowds-planted"]
    bench = SimpleNamespace(engine=SimpleNamespace(broad_phase=BroadPhase), spec="", name="planted")
    theirs: Any = SimpleNamespace(bench=lambda name: bench, setup=SimpleNamespace(seed=0))
    for task in tasks:
        filing.file(task, task.do(theirs if isinstance(task, CrowdTask) else shop))
    settle(run, known, filing.replayed)
    return exit_status(run, settled=ledgers.settle(run, known, update=update)), run


def states(run: Run) -> list[State]:
    return [note.state for note in run.ledger]


def entries(own: Path) -> list[dict[str, Any]]:
    return list(tomllib.loads(own.read_text("utf-8")).get("entry", []))


def break_it(monkeypatch: pytest.MonkeyPatch, what: str, fault: str) -> None:
    if what == "survey":
        monkeypatch.setenv("SWITCHED_FAULT", fault)
    else:
        monkeypatch.setattr(BroadPhase, "fault", fault)


@pytest.mark.parametrize(
    ("what", "fault", "symptom", "engine", "asked"),
    [
        ("survey", "halves", "wrong answer", "switched", ("survey roots", "root")),
        ("survey", "silent", "no answer", "switched", ("survey roots", "root")),
        ("crowd", MISSING, MISSING, "planted", ("broad phase", "pairs")),
        ("crowd", NOT_NEAREST, NOT_NEAREST, "planted", ("broad phase", "nearest")),
        ("crowd", LOST, LOST, "planted", ("broad phase", "pairs")),
    ],
)
def test_the_life_of_a_fault(
    what: str, fault: str, symptom: str, engine: str, asked: tuple[str, str],
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    own = tmp_path / "own.toml"
    own.write_text("# what we know\n", "utf-8")
    status, run = studied(own)
    assert (status, run.ledger, list(failed_in(run))) == (FINISHED, [], [])

    break_it(monkeypatch, what, fault)
    capsys.readouterr()
    status, run = studied(own)
    assert status == INCOMPLETE
    printed = tomllib.loads(capsys.readouterr().out.partition("# add to ")[2].partition("\n")[2])["entry"]
    (entry,) = printed
    assert (entry["engine"], entry["query"], entry["pair"], entry["symptom"]) == (engine, *asked, symptom)
    assert entry["cause"].startswith(UNEXPLAINED)
    assert entry["first_seen"]["version"]

    assert studied(own, update=True)[0] == FINISHED
    assert entries(own) == printed
    for name in entry["witnesses"]:
        kept = load_witness(tmp_path, engine, name)
        assert isinstance(kept, CaseWitness if what == "survey" else CrowdWitness)
        assert kept.id == name
        assert kept.version == entry["first_seen"]["version"]
        assert text_of(kept) == path_of(tmp_path, engine, name).read_text("utf-8")

    status, run = studied(own)
    assert (status, states(run)) == (FINISHED, [State.EXPECTED])
    (note,) = run.ledger
    assert note.seen > 0
    assert note.holding == tuple(entry["witnesses"])
    known = [count for count in (*run.surveys, *run.crowds) if count.known]
    assert sum(count.known for count in known) == note.seen
    assert not any(count.failed for count in run.surveys)

    break_it(monkeypatch, what, "")
    capsys.readouterr()
    status, run = studied(own)
    assert (status, states(run)) == (INCOMPLETE, [State.STALE])
    gone = capsys.readouterr().out.partition("# take out of ")[2].partition("\n")[2]
    assert tomllib.loads(gone)["entry"] == printed
    assert 'tests="5" failures="1"' in junit.render(run, []), "the entry, the run, two questions, a broad phase"
    assert studied(own, update=True)[0] == FINISHED
    assert entries(own) == []
    assert own.read_text("utf-8").startswith("# what we know\n")
    assert list((tmp_path / "witnesses" / engine).iterdir()) == []


def test_reports_tell_the_state_in_the_words_of_the_ledger(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    own = tmp_path / "own.toml"
    break_it(monkeypatch, "survey", "halves")
    break_it(monkeypatch, "crowd", NOT_NEAREST)
    _, run = studied(own, update=True)
    for page in (html.render(run), markdown.render(run)):
        assert page.count(State.NEW.value) >= 3  # the crowds of two regimes
        assert "3 new in surveys and crowds" in page
    _, run = studied(own)
    for page in (html.render(run), markdown.render(run).replace("\\", "")):
        assert "new in surveys" not in page
        for entry in entries(own):
            assert f"{entry['name']}: {UNEXPLAINED[:-1]}" in page
    data = json.loads(report_json(run))
    jsonschema.validate(data, json.loads(schema()))
    again = report_data(run_from_data(data))
    assert all(again[name] == data[name] for name in ("surveys", "crowds", "ledger"))


def test_a_witness_that_fails_otherwise_is_changed_and_what_it_shows_is_new(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    own = tmp_path / "own.toml"
    break_it(monkeypatch, "survey", "halves")
    assert studied(own, update=True)[0] == FINISHED
    break_it(monkeypatch, "survey", "silent")
    status, run = studied(own)
    assert (status, states(run)) == (INCOMPLETE, [State.CHANGED])
    assert "beyond what the entry says" in run.ledger[0].why
    assert [(failed.symptom, failed.entry) for failed in failed_in(run)] == [("no answer", "")]
    assert studied(own, update=True)[0] == FINISHED
    assert [entry["symptom"] for entry in entries(own)] == ["no answer"]


def test_other_versions_and_libraries_that_are_not_asked_are_unmatched(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    own = tmp_path / "own.toml"
    break_it(monkeypatch, "survey", "halves")
    break_it(monkeypatch, "crowd", MISSING)
    assert studied(own, update=True)[0] == FINISHED
    text = own.read_text("utf-8")
    own.write_text(text.replace('versions = ">=', 'versions = "<'), "utf-8")
    status, run = studied(own)
    assert (status, states(run)) == (INCOMPLETE, [State.UNMATCHED] * 2)
    assert len(list(failed_in(run))) == 3  # both crowds
    own.write_text(text, "utf-8")
    absent = Library("tests.surveyed:Switched", "no_such_module_at_all", "nothing", "numpy")
    monkeypatch.setattr(Survey, "engines", {"switched": absent})
    _, run = studied(own)
    assert {note.engine for note in run.ledger} == {"planted"}


def test_a_new_fault_does_not_hide_behind_a_known_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    own = tmp_path / "own.toml"
    listed = '[[entry]]\nengine = "switched"\nname = "large"\ncause = "Of large numbers."\nregime = "large"\n'
    own.write_text(listed, "utf-8")
    break_it(monkeypatch, "survey", "halves")
    status, run = studied(own)
    assert (status, states(run)) == (INCOMPLETE, [State.EXPECTED])
    counts = {count.regime: count for count in run.surveys if count.question == "root"}
    assert (counts["large"].known, counts["large"].wrong) == (2, 0)
    assert (counts["small"].known, counts["small"].wrong) == (0, 3)
    assert sorted(failed.entry for failed in failed_in(run)) == ["", "large"]


def test_witnesses_that_prove_nothing_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    own = tmp_path / "own.toml"
    break_it(monkeypatch, "survey", "halves")
    break_it(monkeypatch, "crowd", MISSING)
    assert studied(own, update=True)[0] == FINISHED
    ids = {entry["engine"]: entry["witnesses"][0] for entry in entries(own)}
    damages: dict[str, list[Any]] = {
        "switched": [lambda d: d["case"].update(answer=1.0), lambda d: d["case"]["case"]["data"].update(number=4.0)],
        "planted": [lambda d: d["crowd"].update(depth=9.0), lambda d: d["crowd"].update(pair=None)],
    }
    for engine, name in ids.items():
        path = path_of(tmp_path, engine, name)
        text = path.read_text("utf-8")
        for damage in (*damages[engine], lambda d: d.update(engine="other"), lambda d: d.update(version=1)):
            data = json.loads(text)
            damage(data)
            path.write_text(json.dumps(data), "utf-8")
            with pytest.raises(LedgerError, match=name):
                load_witness(tmp_path, engine, name)


SHIPPED_LEDGER = Ledger.load()
OF_STUDIES = [entry for entry in SHIPPED_LEDGER.entries if entry.query[0].startswith(("survey", BROAD_PHASE))]


@pytest.mark.parametrize(
    ("entry", "name"),
    [(entry, name) for entry in OF_STUDIES for name in entry.witnesses],
    ids=lambda one: one if isinstance(one, str) else one.name,
)
def test_every_shipped_witness_is_explained_by_its_entry(entry: Entry, name: str, monkeypatch: Any) -> None:
    monkeypatch.undo()
    kept = SHIPPED_LEDGER.witnesses[entry.engine, name]
    if isinstance(kept, CaseWitness):
        survey = load_survey(kept.survey)
        judge = survey_judging.Judge(survey, kept.engine, survey.engines[kept.engine].load())
        fault = judge.fault(kept.shown)
    else:
        assert isinstance(kept, CrowdWitness)
        one = kept.witness
        fault = crowd_judging.Failure(one.symptom, one.pair, one.depth).fault(kept.engine, one.crowd)
    assert SHIPPED_LEDGER.explaining(fault) == entry


def test_what_surveys_and_crowds_show_is_explained_by_no_entry_about_scenes(monkeypatch: Any) -> None:
    monkeypatch.undo()
    asked = [(f"survey {name}", question) for name in SURVEYS for question in load_survey(name).questions]
    asked += [(BROAD_PHASE, pair) for pair in ASKED.values()]
    others = [entry for entry in SHIPPED_LEDGER.entries if entry not in OF_STUDIES]
    assert len(others) > 50
    assert [entry.key for entry in others if any(entry.fits_cell(*cell) for cell in asked)] == []
