"""Shrinking: witnesses become small, findings with one cause come together, and quiet faults keep their own bucket."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import ClassVar

import numpy as np
import pytest

from oracles.allowance import MOST_LOST
from oracles.answers import take
from oracles.around import LOST_AT_ONCE
from oracles.batch import Batch
from oracles.buckets import Buckets, key_of
from oracles.bulk import Proofs
from oracles.clumsiness import odd_numbers
from oracles.degeneracy import FREE, degeneracy, features
from oracles.engine import AnswerRow, Answers, Engine, Row, Status
from oracles.judges import Judges, finding_of
from oracles.ledger.files import Ledger
from oracles.likeness import Failing
from oracles.outcome import FINDINGS, Bucket, Finding, Kind
from oracles.paths import SHARES, leads, path
from oracles.planted.mutants import MUTANTS
from oracles.scene import DISTANCE, IMPACT, RAYCAST, SWEEP, Cell, Scene, cells
from oracles.shrink import shrink, shrink_all
from oracles.words import decade_of
from refimpl import AABB, ConvexPolyhedron, Point, Proxy, Ray, Sphere, distance
from refimpl.proof import check
from tests.wrong_engines import Answer, FlippedNormal, Honest, MissedContact, OffByAThousandth

ANSWER_COLUMNS = 27


class Bench:
    """An engine that answers in this process."""

    def __init__(self, engine: Engine) -> None:
        self.engine, self.judges, self.asked = engine, Judges(engine), 0

    def answer(self, cell: Cell, rows: object, groups: object = None, give_up_after: int | None = None) -> Answers:
        del groups, give_up_after
        first, second = (np.asarray(side) for side in rows)  # type: ignore[attr-defined]
        solve = self.engine.solver(cell.query, cell.type_a, cell.type_b)
        table = np.array([solve(a, b) for a, b in zip(first.tolist(), second.tolist(), strict=True)], dtype=float)
        self.asked += len(table)
        return Answers.from_table(np.full(len(table), Status.ANSWERED, dtype=np.int8), table, {})

    def renew(self) -> None:
        """Each batch has a solver of its own."""


def findings(bench: Bench, cell: Cell, each: int = 12) -> list[Finding]:
    """Proven findings of one bulk batch of a cell, as the bulk hunter picks them, one for each key."""
    pair = cell.type_a, cell.type_b
    draw = {IMPACT: Batch.draw_impacts, SWEEP: Batch.draw_sweeps}.get(cell.query, Batch.draw)
    batches = draw(pair, 7, (0, 1), each)
    found: dict[object, Finding] = {}
    proofs, name = Proofs(), bench.engine.name
    for batch in batches:
        answers = bench.answer(cell, batch.rows)
        screening = bench.judges.screen(cell, batch.a, batch.b, batch.motion, answers)
        for i in np.flatnonzero([kind is Kind.WRONG for kind in screening.kind]):
            scene, alone = batch.scene(cell.query, int(i)), take(answers, [i])
            decade = decade_of(float(screening.amount[i]), scene.size)
            if not proofs.wanted(name, cell, screening.symptom[i], decade, scene.regime):
                continue
            verdict = bench.judges.convict(scene, alone)
            if verdict.kind in FINDINGS:
                finding = finding_of(name, scene, alone, verdict)
                found.setdefault(key_of(finding), finding)
    return list(found.values())


def boiled(engine: Engine, cell: Cell, each: int = 12) -> tuple[list[Bucket], int]:
    """Buckets after shrinking, and how many keys there were before."""
    bench, buckets = Bench(engine), Buckets(Ledger())
    for finding in findings(bench, cell, each):
        buckets.add_proven(finding)
    for group in buckets.to_shrink():
        buckets.rekey(group, shrink_all(group, bench))
    return buckets.sorted(), len(buckets.piles)


CELLS = [
    (OffByAThousandth, Cell(DISTANCE, Sphere, AABB)),
    (OffByAThousandth, Cell(DISTANCE, Point, Sphere)),
    (FlippedNormal, Cell(DISTANCE, Sphere, Sphere)),
    (MissedContact, Cell(RAYCAST, Ray, Sphere)),
    (MissedContact, Cell("boolean", Point, AABB)),
]


@pytest.mark.parametrize(("engine", "cell"), CELLS, ids=lambda x: getattr(x, "__name__", None) or x.pair)
def test_findings_of_one_fault_come_together_in_a_witness_that_is_taken_in_at_a_glance(
    engine: type[Engine], cell: Cell
) -> None:
    buckets, before = boiled(engine(), cell)
    assert before > 8
    assert len({bucket.symptom for bucket in buckets}) == len(buckets) <= 2
    for bucket in buckets:
        scene, verdict = bucket.witness.scene, bucket.witness.verdict
        assert odd_numbers(scene) <= 1, scene
        assert verdict.kind is Kind.WRONG
        about = verdict.proof_scene or scene
        lower, upper = check(verdict.certificate, about.a, about.b)  # type: ignore[arg-type]
        assert verdict.lower <= lower <= upper <= verdict.upper
        assert scene.source.endswith(", shrunk")


@pytest.mark.parametrize("name", ["normal-of-impact-flipped", "always-elastic", "immovable-turns"])
def test_impacts_shrink_to_bodies_along_the_axes(name: str) -> None:
    mutant = MUTANTS[name]
    cell = next(cell for cell in cells() if (cell.query, cell.pair) == (mutant.query, mutant.pair))
    buckets, before = boiled(mutant.engine(), cell, each=6)
    assert before > len(buckets)
    assert len(buckets) <= 2
    assert all(odd_numbers(bucket.witness.scene) <= 1 for bucket in buckets)


# -- two faults of one cell and symptom -----------------------------------------------------------------------


class TwoFaults(Honest):
    """Adds a length to the distance: a gross one here, a slight one there."""

    loud: ClassVar[Callable[[Row, Row, float], float]]
    quiet: ClassVar[Callable[[Row, Row, float], float]]

    def solver(self, query: str, A: type[Proxy], B: type[Proxy]) -> Callable[[Row, Row], AnswerRow]:
        right = super().solver(query, A, B)

        def solve(a: Row, b: Row) -> AnswerRow:
            answer = list(right(a, b))
            answer[1] += type(self).loud(a, b, answer[1]) or type(self).quiet(a, b, answer[1])
            return answer

        return solve

    def spoil(self, answer: Answer, row_a: Row) -> AnswerRow:
        return super().spoil({"distance": answer["distance"]}, row_a)

    def says(self, query: str, A: type[Proxy], B: type[Proxy]) -> frozenset[str]:
        return frozenset({"distance"})


def extent(a: Row, b: Row) -> float:
    return max(map(abs, [*a[3:4], *b[3:4], math.dist(a[:3], b[:3])]))


def touches(a: Row, b: Row, gap: float) -> bool:
    return abs(gap) <= 1e-12 * extent(a, b)


class QuietAtTouching(TwoFaults):
    loud = staticmethod(lambda a, b, gap: 0.0 if touches(a, b, gap) else 0.1 * extent(a, b))
    quiet = staticmethod(lambda a, b, gap: 1e-9 * extent(a, b))


class QuietWhereSmoothIsNought(TwoFaults):
    """The loud one grows with the gap from nothing on; the quiet one is where the balls overlap."""

    loud = staticmethod(lambda a, b, gap: 0.5 * gap if gap > 0 else 0.0)
    quiet = staticmethod(lambda a, b, gap: 1e-8 * extent(a, b) if gap < 0 else 0.0)


class QuietForTheTiny(TwoFaults):
    loud = staticmethod(lambda a, b, gap: 0.1 * b[3] if b[3] > 1e-4 and a[0] != b[0] else 0.0)
    quiet = staticmethod(lambda a, b, gap: 1e-7 * b[3] if b[3] < 1e-4 else 0.0)


@pytest.mark.parametrize("engine", [QuietAtTouching, QuietWhereSmoothIsNought, QuietForTheTiny])
def test_a_quiet_fault_is_not_hidden_by_a_loud_one_of_the_same_symptom(engine: type[TwoFaults]) -> None:
    buckets, before = boiled(engine(), Cell(DISTANCE, Sphere, Sphere), each=20)
    assert before > 5
    decades = sorted(bucket.decade or 0 for bucket in buckets)
    assert len(buckets) == 2, [bucket.key for bucket in buckets]
    assert decades[0] <= -7
    assert decades[1] >= -2
    assert {bucket.symptom for bucket in buckets} == {"distance too large"}


# -- what does not come again ---------------------------------------------------------------------------------


class EveryFiftieth(Honest):
    """Wrong at every fiftieth call of a solver, whatever the scene."""

    def solver(self, query: str, A: type[Proxy], B: type[Proxy]) -> Callable[[Row, Row], AnswerRow]:
        right, calls = super().solver(query, A, B), 0

        def solve(a: Row, b: Row) -> AnswerRow:
            nonlocal calls
            calls += 1
            answer = list(right(a, b))
            answer[1] += extent(a, b) if calls % 50 == 0 else 0.0
            return answer

        return solve


def test_what_does_not_come_again_is_one_bucket_whatever_the_scenes() -> None:
    buckets, before = boiled(EveryFiftieth(), Cell(DISTANCE, Sphere, Sphere), each=30)
    assert before > 3
    assert [(bucket.degeneracy, bucket.decade) for bucket in buckets] == [("not repeatable", None)]
    assert "not repeatable" in buckets[0].key
    assert not buckets[0].witness.repeats
    assert odd_numbers(buckets[0].witness.scene) == 0
    lower, upper = check(buckets[0].witness.verdict.certificate, *sides(buckets[0].witness))  # type: ignore[arg-type]
    assert not lower <= buckets[0].witness.answer["distance"] <= upper


class Remembering(Honest):
    """Answers the first scene that it is asked, and again to whoever has the same first number."""

    def __init__(self) -> None:
        self.kept: dict[float, AnswerRow] = {}

    def solver(self, query: str, A: type[Proxy], B: type[Proxy]) -> Callable[[Row, Row], AnswerRow]:
        right = super().solver(query, A, B)
        return lambda a, b: self.kept.setdefault(a[0], right(a, b))


class ForgettingBench(Bench):
    def renew(self) -> None:
        self.engine.kept.clear()  # type: ignore[attr-defined]


def remembered(engine: Honest, *places: float) -> tuple[Bench, Finding]:
    """A finding on the last of some scenes with the same A, which was asked before."""
    bench, cell = ForgettingBench(engine), Cell(DISTANCE, Sphere, Sphere)
    pairs = [Scene(DISTANCE, Sphere([1.1, 0.0, 0.0], 1.0), Sphere([x, 0.0, 0.0], 1.0), "generic") for x in places]
    rows = tuple(np.stack([scene.rows[i] for scene in pairs]) for i in range(2))
    last = take(bench.answer(cell, rows), [len(pairs) - 1])
    finding = finding_of("honest", pairs[-1], last, bench.judges.convict(pairs[-1], last))
    assert finding.verdict.kind is Kind.WRONG
    return bench, finding


def test_what_fails_only_after_other_scenes_does_not_come_again_but_in_a_row_of_plain_ones() -> None:
    bench, finding = remembered(Remembering(), 4.0, 5.0)
    shrunk = shrink(finding, bench)
    assert not shrunk.repeats
    assert odd_numbers(shrunk.scene) == 0 < odd_numbers(finding.scene)
    assert (shrunk.verdict.symptom, shrunk.scene.regime) == (finding.verdict.symptom, finding.scene.regime)
    lower, upper = check(shrunk.verdict.certificate, *sides(shrunk))  # type: ignore[arg-type]
    assert not lower <= shrunk.answer["distance"] <= upper


class RememberingOdd(Remembering):
    """Remembers only what has an odd first number: it is right in a row of plain scenes."""

    def solver(self, query: str, A: type[Proxy], B: type[Proxy]) -> Callable[[Row, Row], AnswerRow]:
        again, right = super().solver(query, A, B), Honest.solver(self, query, A, B)
        return lambda a, b: again(a, b) if a[0] == 1.1 else right(a, b)


def test_what_fails_only_after_odd_scenes_stays_as_it_was_found() -> None:
    bench, finding = remembered(RememberingOdd(), 4.0, 5.0)
    shrunk = shrink(finding, bench)
    assert not shrunk.repeats
    assert shrunk.scene.id == finding.scene.id


def sides(finding: Finding) -> tuple[Proxy, Proxy]:
    about = finding.verdict.proof_scene or finding.scene
    return about.a, about.b


class Lost(Bench):
    """Loses an engine wherever the two concentric; a process would."""

    lost = 0

    def answer(self, cell: Cell, rows: object, groups: object = None, give_up_after: int | None = None) -> Answers:
        answers = super().answer(cell, rows, groups, give_up_after)
        first, second = (np.asarray(side) for side in rows)  # type: ignore[attr-defined]
        gone = (first[:, :3] == second[:, :3]).all(axis=1)
        type(self).lost += int(gone.sum())
        return replace(answers, status=np.where(gone, np.int8(Status.CRASHED), answers.status))


def test_what_costs_the_engine_becomes_simple_and_costs_it_a_few_times() -> None:
    place = [1.2345, -0.777, 31.4159]
    scene = Scene(DISTANCE, Sphere(place, 0.123), Sphere(place, 4.567), "concentric")
    bench = Lost(Honest())
    answers = bench.answer(scene.cell, tuple(row[None] for row in scene.rows))
    finding = finding_of("honest", scene, answers, bench.judges.convict(scene, answers))
    assert finding.verdict.kind is Kind.CRASHED
    before = bench.lost
    shrunk = shrink(finding, bench)
    assert odd_numbers(shrunk.scene) == 0
    assert bench.lost - before <= MOST_LOST + LOST_AT_ONCE + 2


# -- paths ----------------------------------------------------------------------------------------------------


def at(gap: float, radius: float = 1.0) -> Scene:
    return Scene(DISTANCE, Sphere([0.0, 0.0, 0.0], radius), Sphere([0.0, 0.0, 1.0 + radius + gap], 1.0), "generic")


def test_a_path_leads_where_an_error_grows_and_not_where_it_leaps() -> None:
    scenes = path(at(1e-7), at(2.0, radius=0.5))
    assert len(scenes) == len(SHARES)
    gaps = [float(distance(scene.a, scene.b).distance) for scene in scenes]
    for power in (0.5, 1.0, 2.0):
        assert leads([Failing(scene, abs(gap) ** power) for scene, gap in zip(scenes, gaps, strict=True)])
    leaping = [Failing(scene, 1e-8 if gap < 1e-2 else gap) for scene, gap in zip(scenes, gaps, strict=True)]
    assert not leads(leaping)
    assert not leads([Failing(scene, math.inf) for scene in scenes])


def test_there_is_no_path_between_forms() -> None:
    hulls = [ConvexPolyhedron.from_vertices(np.eye(4, 3) * size) for size in (1.0, 2.0)]
    more = ConvexPolyhedron.from_vertices(np.concatenate([np.eye(3), -np.eye(3)]))
    ball = Sphere([3.0, 0.0, 0.0], 1.0)
    start, near, other = (Scene(DISTANCE, ball, hull, "generic") for hull in (*hulls, more))
    assert path(start, near)
    assert not path(start, other)


# -- the rules ------------------------------------------------------------------------------------------------


def test_shrinking_never_makes_a_scene_special_and_is_the_same_every_time() -> None:
    bench = Bench(OffByAThousandth())
    for finding in findings(bench, Cell(DISTANCE, Sphere, AABB), each=2):
        first, second = (shrink(finding, Bench(OffByAThousandth()), tries=400) for _ in range(2))
        assert first.scene.id == second.scene.id
        assert first.verdict.symptom == finding.verdict.symptom
        assert first.scene.regime == finding.scene.regime
        assert features(first.scene) <= features(finding.scene) | FREE


def test_tries_are_the_scenes_that_are_asked() -> None:
    bench = Bench(OffByAThousandth())
    finding = findings(bench, Cell(DISTANCE, Sphere, AABB), each=1)[0]
    asked = bench.asked
    assert shrink(finding, bench, tries=0).scene.id == finding.scene.id
    assert bench.asked - asked <= 2
    asked = bench.asked
    shrink(finding, bench, tries=50)
    assert bench.asked - asked <= 50 + 5


def test_a_right_scene_is_never_a_witness() -> None:
    scene = Scene(DISTANCE, Sphere([0.0, 0.0, 0.0], 1.0), Sphere([3.0, 0.1, 0.0], 1.0), "generic")
    bench = Bench(OffByAThousandth())
    answers = bench.answer(scene.cell, tuple(row[None] for row in scene.rows))
    finding = finding_of("honest", scene, answers, bench.judges.convict(scene, answers))
    assert degeneracy(scene) == "generic"
    same = shrink(finding, Bench(Honest()))
    assert same.scene.id == scene.id
    assert not same.repeats
