"""The record of a run: read back to the bit, damaged files named and done again, nothing that is read trusted."""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from typing import Any

import duckdb
import pytest

import oracles.store
from oracles.bench import Setup, close_workshop
from oracles.engine import Engine
from oracles.measuring import Measured
from oracles.outcome import Kind, Outcome
from oracles.planted.wrong_impacts import AlwaysElastic
from oracles.records import outcome_from_json, outcome_to_json
from oracles.scene import DISTANCE, Cell
from oracles.store import DIGITS, FOLDER, RecordError, Store, file_stem
from oracles.tasks import BulkTask, HuntTask, perform
from refimpl import AABB, Ray, Sphere
from tests.wrong_engines import Crashing, OffByAThousandth


def spec(engine: type[Engine]) -> str:
    return f"{engine.__module__}:{engine.__name__}"


SETUP = Setup((spec(OffByAThousandth),), 3, 0.5)
TASK = BulkTask((Sphere, Sphere), 0, 1)
MANIFEST = {"seed": 3, "versions": {"proxyproof": "1", "fcl": "2"}, "engines": ["fcl"]}


@pytest.fixture(scope="module")
def outcome() -> Outcome:
    found = perform(TASK, SETUP)
    close_workshop()
    return found


@pytest.fixture
def store(tmp_path: Path) -> Store:
    return Store.begin(tmp_path, MANIFEST)


def again(store: Store) -> Store:
    return Store.go_on(store.folder, MANIFEST)


def only_file(store: Store) -> Path:
    (path,) = (store.folder / FOLDER).glob("*.parquet")
    return path


def same(one: Outcome, other: Outcome) -> bool:
    """Equal but for the sheets, of which recalled outcomes have none."""
    plain = [outcome_to_json(replace(found, sheets=[])) for found in (one, other)]
    keys = [
        [(f.scene.id, f.verdict.certificate, f.verdict.proof_scene is None) for f in o.findings] for o in (one, other)
    ]
    return plain[0] == plain[1] and keys[0] == keys[1]


@pytest.mark.parametrize(
    ("engine", "task"),
    [
        (OffByAThousandth, TASK),
        (OffByAThousandth, BulkTask((Ray, Sphere), 1, 1)),
        (OffByAThousandth, HuntTask("honest", Cell(DISTANCE, Sphere, AABB), 0)),
        (Crashing, BulkTask((Sphere, Sphere), 0, 1)),
        (AlwaysElastic, BulkTask((Sphere, Sphere), 0, 1)),
    ],
    ids=lambda x: getattr(x, "name", ""),
)
def test_what_is_recorded_is_recalled_to_the_bit(store: Store, engine: Any, task: Any) -> None:
    found = perform(task, Setup((spec(engine),), 3, 0.5))
    close_workshop()
    assert found.findings
    store.record(task, found)
    assert store.problems == []
    recalled = again(store).recall(task)
    assert recalled is not None
    assert same(found, recalled)
    assert recalled.counts == found.counts
    assert recalled.counted == found.counted
    assert isinstance(next(iter(recalled.counts))[4], Kind)


def test_every_answer_is_a_row(store: Store, outcome: Outcome) -> None:
    store.record(TASK, outcome)
    rows = duckdb.sql(f"SELECT * FROM '{only_file(store)}'")
    assert rows.columns == [
        *("engine", "query", "pair", "regime", "number", "status"),
        *("verdict", "symptom", "amount", "pressure", "error", "size", "gap", "aspect", "proven"),
    ]
    found = rows.fetchall()
    assert len(found) == outcome.hunters["bulk"]
    counts = Counter((*row[:4], Kind(row[6])) for row in found)
    asked = {key: n for key, n in outcome.counts.items() if key[0] != "refimpl" and key[4] is not Kind.UNSUPPORTED}
    assert counts == asked
    assert sum(row[14] for row in found) == len([f for f in outcome.findings if f.engine != "refimpl"])
    wrong = [row for row in found if row[6] == "wrong"]
    assert {row[7] for row in wrong} == {f.verdict.symptom for f in outcome.findings}
    assert all(row[9] > 1 for row in wrong)


def test_a_task_without_answers_can_be_read_with_the_others(store: Store, outcome: Outcome) -> None:
    store.record(BulkTask((Sphere, AABB), 0, 1), Outcome())  # its file is the first, and says of what type columns are
    store.record(TASK, outcome)
    assert len(store.samples) == 2
    with Measured(store.samples, []) as measured:
        assert {errors.engine for errors in measured.errors({})} == {"honest"}


def test_a_task_that_is_not_recorded_is_not_recalled(store: Store, outcome: Outcome) -> None:
    store.record(TASK, outcome)
    other = again(store)
    assert other.waiting == 1
    assert other.recall(BulkTask((Sphere, Sphere), 1, 6)) is None
    assert other.recall(TASK) is not None
    assert other.waiting == 0
    assert other.problems == []


def test_beginning_takes_the_place_of_an_older_record_and_of_nothing_else(store: Store, outcome: Outcome) -> None:
    store.record(TASK, outcome)
    foreign = store.folder / FOLDER / "notes.txt"
    foreign.write_text("mine")
    Store.begin(store.folder, MANIFEST)
    assert list((store.folder / FOLDER).iterdir()) == [foreign]


# -- damage --------------------------------------------------------------------------------------------------


def flip(path: Path) -> None:
    content = bytearray(path.read_bytes())
    content[len(content) // 3] ^= 1
    path.write_bytes(content)


def cut(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-100])


def empty(path: Path) -> None:
    path.write_bytes(b"")


@pytest.mark.parametrize("damage", [flip, cut, empty])
def test_a_damaged_file_is_named_set_aside_and_done_again(store: Store, outcome: Outcome, damage: Any) -> None:
    store.record(TASK, outcome)
    path = only_file(store)
    damage(path)
    found = again(store)
    assert found.recall(TASK) is None
    assert len(found.problems) == 1
    assert path.name in found.problems[0]
    assert "done again" in found.problems[0]
    found.record(TASK, outcome)
    assert again(store).recall(TASK) is not None


def test_half_written_files_are_named_and_removed(store: Store, outcome: Outcome) -> None:
    store.record(TASK, outcome)
    part = store.folder / FOLDER / "bulk-0-Sphere-Box.part"
    part.write_bytes(only_file(store).read_bytes()[:1000])
    found = again(store)
    assert [part.name in line for line in found.problems] == [True]
    assert not part.exists()
    assert found.recall(TASK) is not None


def forged(store: Store, data: Any, task: Any = TASK) -> None:
    """A file as a stranger may make it: whole, and named rightly."""
    part = store.folder / FOLDER / "x.part"
    with duckdb.connect() as database:
        options = "FORMAT parquet, KV_METADATA {outcome: $said}"
        database.execute(f"COPY (SELECT 1 AS x) TO '{part}' ({options})", {"said": json.dumps(data)})
    digest = sha256(part.read_bytes()).hexdigest()[:DIGITS]
    part.rename(part.with_name(f"{file_stem(task)}.{digest}.parquet"))


def changed(data: dict[str, Any], *path: Any, to: Any) -> dict[str, Any]:
    whole = json.loads(json.dumps(data))
    place = whole
    for step in path[:-1]:
        place = place[step]
    place[path[-1]] = to
    return dict(whole)


FORGERIES: list[tuple[tuple[Any, ...], Any]] = [
    (("task",), "bulk-9-Sphere-Sphere"),
    (("format",), "other"),
    (("counts", 0, 5), -1),
    (("counts", 0, 5), 1.5),
    (("counts", 0, 5), 10**30),
    (("counts", 0, 4), "perfect"),
    (("counted",), [["a", "b", "c", "d", 1, "e", 1, 10**400]]),
    (("counted",), {}.fromkeys("ab")),
    (("counts", 0), []),
    (("counts",), None),
    (("problems",), ["x" * 10_000]),
    (("findings", 0, "lower"), 5.0),
    (("findings", 0, "upper"), -5.0),
    (("findings", 0, "certificate"), None),
    (("findings", 0, "certificate", "claims"), []),
    (("findings", 0, "scene", "a", "type"), "os.system"),
    (("findings", 0, "scene", "a", "numbers"), [0.0] * 3),
    (("findings", 0, "kind"), "??"),
]


@pytest.mark.parametrize(("path", "to"), FORGERIES, ids=[".".join(map(str, path)) for path, _ in FORGERIES])
def test_what_a_stranger_writes_is_refused(store: Store, outcome: Outcome, path: tuple[Any, ...], to: Any) -> None:
    data = {"format": oracles.store.FORMAT, "task": TASK.name, **outcome_to_json(outcome)}
    forged(store, changed(data, *path, to=to))
    found = again(store)
    assert found.recall(TASK) is None
    assert len(found.problems) == 1
    assert "damaged" in found.problems[0]


def test_a_forgery_that_is_true_is_as_good_as_the_original(store: Store, outcome: Outcome) -> None:
    forged(store, {"format": oracles.store.FORMAT, "task": TASK.name, **outcome_to_json(outcome)})
    recalled = again(store).recall(TASK)
    assert recalled is not None
    assert same(recalled, outcome)


def test_files_that_are_no_parquet_or_too_large_are_refused(
    store: Store, outcome: Outcome, monkeypatch: pytest.MonkeyPatch
) -> None:
    content = b"PAR1 nothing PAR1"
    name = f"{file_stem(TASK)}.{sha256(content).hexdigest()[:DIGITS]}.parquet"
    (store.folder / FOLDER / name).write_bytes(content)
    found = again(store)
    assert found.recall(TASK) is None
    assert "damaged" in found.problems[0]
    store.record(TASK, outcome)
    monkeypatch.setattr(oracles.store, "LARGEST_FILE", 100)
    found = again(store)
    assert found.recall(TASK) is None
    assert "too large" in found.problems[0]


# -- manifests -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"seed": 4}, "seed was 3, is 4"),
        ({"engines": ["bullet"]}, r"engines was \['fcl'\], is \['bullet'\]"),
        ({"versions": {"proxyproof": "1", "fcl": "3"}}, "versions fcl was '2', is '3'"),
        ({"versions": {"proxyproof": "1"}}, "versions fcl was '2', is None"),
        ({"call limit": 0.5}, "call limit was None, is 0.5"),
    ],
)
def test_a_record_of_another_run_is_refused_by_what_differs(store: Store, change: Any, named: str) -> None:
    with pytest.raises(RecordError, match=f"of another run: {named}$"):
        Store.go_on(store.folder, MANIFEST | change)


@pytest.mark.parametrize("content", ["", "[]", "{}", '{"format": "other"}', "[" * 100_000, "\0"])
def test_folders_without_a_record_are_refused_in_one_line(tmp_path: Path, content: str) -> None:
    with pytest.raises(RecordError, match="holds no record of a run"):
        Store.go_on(tmp_path, MANIFEST)
    (tmp_path / "manifest.json").write_text(content)
    with pytest.raises(RecordError) as refused:
        Store.go_on(tmp_path, MANIFEST)
    assert "\n" not in str(refused.value)


# -- single things -------------------------------------------------------------------------------------------


def test_an_outcome_keeps_what_json_has_no_word_for() -> None:
    odd = Outcome(counted={("a", "b", "c", "d", None, "e"): (2, float("inf"))}, digest="x", lacking={"hull"})
    odd.incidents["the process was started again"] += 2
    odd.counts["refimpl", "distance", "A–B", "r", Kind.AGREES] = 3
    assert outcome_from_json(json.loads(json.dumps(outcome_to_json(odd)))) == odd


@pytest.mark.parametrize("name", ["../../etc/passwd", "a/b", "é" * 300, "", "nul\0", "a b"])
def test_engines_of_any_name_have_files_of_their_own(name: str) -> None:
    stem = file_stem(HuntTask(name, Cell(DISTANCE, Sphere, AABB), 0))
    assert stem.isascii()
    assert not set(stem) & set("/\0. ")
    assert len(stem) < 150
    assert stem != file_stem(HuntTask(name + "_", Cell(DISTANCE, Sphere, AABB), 0))
