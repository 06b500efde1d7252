"""The engine that is right gives no finding; each that is wrong on purpose is convicted, and found by the hunter.

The whole takes hours, most of them machine time: ``pytest -m soak tests/test_planted.py``, or by hand
``proxyproof hunt-mutants --jobs 2`` and ``proxyproof hunt-mutants --correct 1000000``.
"""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from oracles.answers import take
from oracles.batch import Batch
from oracles.engine import Answers
from oracles.judges import Judges
from oracles.outcome import FINDINGS, Kind
from oracles.planted.hunting import Hunted, hunted, questioned, supported_pairs
from oracles.planted.mutant import Mutant
from oracles.planted.mutants import MUTANTS
from oracles.planted.textbook import Textbook
from oracles.scene import BOOLEAN, CONTACTS, DISTANCE, IMPACT, QUERIES, RAYCAST, SWEEP, Scene, cells
from oracles.screening import KINDS
from refimpl.shapes import AABB
from reports import mutants as table
from reports.cli import BAD_INPUT, main
from tests.planted_scenes import FILE, answered, batches, cell_of

SCENES = {name: Scene.from_json(scene) for name, scene in json.loads(FILE.read_text("utf-8")).items()}
FORGETFUL = [m for m in MUTANTS.values() if m.comes_back and not m.engine.remembers]
STATEFUL = [m for m in MUTANTS.values() if m.engine.remembers]
QUICK = (
    "caps-missing",
    "inside-misses",
    "spin-forgotten",
    "crashes-when-equal",
)


def name_of(value: object) -> str | None:
    return value.name if isinstance(value, Mutant) else None


# -- the engine that is right --------------------------------------------------------------------------------


def test_the_right_engine_has_all_queries_and_enough_pairs() -> None:
    supported = [cell for cell in cells() if Textbook().support(cell.query, cell.type_a, cell.type_b)]
    assert {cell.query for cell in supported} == set(QUERIES) - {SWEEP}  # which has wrong engines of its own
    assert len({cell.pair for cell in supported}) == 25


def test_the_right_engine_gives_no_finding_in_thousands_of_scenes() -> None:
    engine, kinds = Textbook(), Counter[Kind]()
    for cell in cells():
        if not engine.support(cell.query, cell.type_a, cell.type_b):
            continue
        for batch in batches(cell, seed=11, each=6 if cell.query != IMPACT else 15):
            answers = answered(engine, cell, batch)
            found = Judges(engine).screen(cell, batch.a, batch.b, batch.motion, answers)
            kinds.update(found.kind)
            for i in np.flatnonzero(found.codes != KINDS.index(Kind.AGREES)).tolist():  # as a campaign does
                verdict = Judges(engine).convict(scene := batch.scene(cell.query, i), take(answers, [i]))
                assert verdict.kind not in FINDINGS, (scene, verdict.claim)
    assert kinds[Kind.AGREES] > 0.9999 * kinds.total()
    assert kinds[Kind.AGREES] > 6_000


@pytest.mark.soak
def test_the_right_engine_gives_no_finding_in_a_million_scenes() -> None:
    run = questioned(scenes=1_000_000, seed=1)
    assert [(b.key, b.witness.verdict.claim) for b in run.buckets] == []
    assert run.total(kinds=FINDINGS) == 0
    assert sum(run.hunters.values()) >= 1_000_000


# -- the engines that are wrong ------------------------------------------------------------------------------


def test_there_are_enough_of_each_kind() -> None:
    count = Counter(mutant.query for mutant in MUTANTS.values())
    assert count[DISTANCE] + count[BOOLEAN] >= 40
    assert all(count[query] >= 10 for query in (CONTACTS, RAYCAST, IMPACT))


def test_each_says_what_is_wrong_in_a_cell_that_the_right_engine_answers() -> None:
    pairs = supported_pairs(Textbook())
    for mutant in MUTANTS.values():
        assert mutant.what.endswith("."), mutant.name
        assert mutant.pair in pairs
        assert mutant.symptoms
        assert mutant.engine().name == mutant.name


def test_each_forgetful_one_has_a_scene() -> None:
    assert set(SCENES) == {mutant.name for mutant in FORGETFUL}


@pytest.mark.parametrize("mutant", FORGETFUL, ids=name_of)
def test_each_is_convicted_in_its_cell_where_the_right_engine_is_not(mutant: Mutant) -> None:
    scene = SCENES[mutant.name]
    assert (scene.cell.query, scene.cell.pair) == (mutant.query, mutant.pair)
    verdict = Judges(mutant.engine()).convict(scene, one_answer(mutant.engine(), scene))
    assert verdict.kind in (Kind.WRONG, Kind.CRASHED)
    assert verdict.symptom == mutant.symptoms[0]
    assert verdict.certificate is not None
    assert Judges(Textbook()).convict(scene, one_answer(Textbook(), scene)).kind is Kind.AGREES


def one_answer(engine: Textbook, scene: Scene) -> Answers:
    motion, place = None if scene.motion is None else scene.motion[None], np.zeros(1, int)
    batch = Batch(scene.a[None], scene.b[None], [scene.regime], place, place, "", {0: ""}, motion)
    return answered(engine, scene.cell, batch)


@pytest.mark.parametrize("mutant", FORGETFUL, ids=name_of)
def test_each_answers_rightly_in_all_other_cells(mutant: Mutant) -> None:
    others = [cell for cell in cells() if (cell.query, cell.pair) != (mutant.query, mutant.pair)]
    engine, right = mutant.engine(), Textbook()
    cell = next(c for c in others if c.query == mutant.query and right.support(c.query, c.type_a, c.type_b))
    for batch in batches(cell, 3, 1):
        theirs, ours = (answered(e, cell, batch) for e in (engine, right))
        assert all(
            np.array_equal(getattr(theirs, n), getattr(ours, n), equal_nan=True) for n in ("hit", "distance", "t")
        )


@pytest.mark.parametrize("mutant", STATEFUL, ids=name_of)
def test_those_that_remember_are_wrong_only_sometimes(mutant: Mutant) -> None:
    engine, cell = mutant.engine(), cell_of(mutant.query, mutant.pair)
    kinds = Counter[Kind]()
    for batch in batches(cell, seed=1, each=100):
        if mutant.name == "stale-box":  # each box is followed by a larger one with the same lower corner
            rows = np.arange(len(batch)) // 2
            larger = AABB(batch.b[rows].lower, batch.b[rows].upper + (np.arange(len(batch)) % 2)[:, None])
            batch = replace(batch, a=batch.a[rows], b=larger)  # noqa: PLW2901
        screening = Judges(engine).screen(cell, batch.a, batch.b, None, answered(engine, cell, batch))
        kinds.update(screening.kind)
        assert set(screening.symptom) <= {"", *mutant.symptoms}
    assert kinds[Kind.AGREES] > kinds[Kind.WRONG] > 0


# -- the hunter ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", QUICK)
def test_the_hunter_finds_and_names_some_in_seconds(name: str) -> None:
    mutant = MUTANTS[name]
    found = hunted(mutant, budget=60.0, settle=0.1, seed=2, pairs=[mutant.pair])
    assert found.found, found.problems
    assert found.named, [bucket.key for bucket in found.buckets]
    for bucket in found.buckets:
        scene = bucket.witness.scene
        assert Scene.from_json(json.loads(json.dumps(scene.to_json()))).id == scene.id
        compile(bucket.repro, "repro", "exec")
        assert mutant.engine.__name__ in bucket.repro


@pytest.mark.soak
def test_the_hunter_finds_all_names_them_and_boils_them_down() -> None:
    done = [hunted(mutant, budget=60.0, settle=5.0) for mutant in MUTANTS.values()]
    assert {found.mutant.name: found.faults for found in done if found.faults} == {}
    small, witnesses = sum(found.small for found in done), sum(len(found.witnesses) for found in done)
    assert small >= 0.9 * witnesses, [(f.mutant.name, len(f.witnesses) - f.small) for f in done]


# -- the command ---------------------------------------------------------------------------------------------


def test_the_command_prints_a_line_for_each_and_fails_for_what_is_not_found(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    missed = Hunted(MUTANTS["caps-missing"], None, [], [])
    monkeypatch.setattr(table, "hunts", lambda *_, **__: iter([missed]))
    assert main(["hunt-mutants", "caps-missing", "--markdown"]) == 1
    printed = capsys.readouterr().out
    assert "| caps-missing | distance Sphere–Capsule | never | 0 |" in printed
    assert "FAULT: not found" in printed
    assert "0 of 1 found" in printed


def test_the_command_refuses_unknown_names(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["hunt-mutants", "no-such-thing"]) == BAD_INPUT
    assert "no wrong engine 'no-such-thing'; there are radius-subtracted" in capsys.readouterr().err
