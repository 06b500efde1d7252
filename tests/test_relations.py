"""Relations: engines that break one are caught by it, and by nothing that they keep; right ones are let through."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from oracles.batch import Batch
from oracles.clumsiness import odd_numbers
from oracles.engine import (
    COLUMNS,
    NATIVE,
    VELOCITIES,
    WIDTH,
    Answers,
    Convention,
    Effective,
    Engine,
    Kind,
    Status,
    Support,
)
from oracles.impact_reference import reference_of
from oracles.motion import WIDTH as MOTION
from oracles.motion import Motion
from oracles.outcome import Kind as Verdicts
from oracles.outcome import Outcome, Verdict
from oracles.records import outcome_from_json, outcome_to_json
from oracles.relations import RELATIONS, Relations, question, relate
from oracles.scene import BOOLEAN, CONTACTS, DISTANCE, IMPACT, RAYCAST, Cell
from oracles.screening import Screening
from oracles.shrink import shrink
from refimpl.linear import norm
from refimpl.pairs import TABLE
from refimpl.proof import check
from refimpl.shapes import (
    AABB,
    KDOP,
    Box,
    Capsule,
    Composite,
    ConvexPolyhedron,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Point,
    Polyhedron,
    Ray,
    Sphere,
)
from tests.conftest import effort, name_of
from tests.reference_engine import Desk, Reference
from tests.wrong_engines import Honest

Columns = dict[str, Any]
Spoil = Callable[[str, Any, Any, Columns], None]


def batches(cell: Cell, each: int, seed: int = 5) -> list[Batch]:
    pair = cell.type_a, cell.type_b
    drawn = Batch.draw_impacts(pair, seed, (0,), each) if cell.query == IMPACT else Batch.draw(pair, seed, (0,), each)
    return [batch for batch in drawn if batch.is_of(cell.query)]


def related(engine: Engine, cell: Cell, each: int, names: list[str] | None = None, judges: Any = None) -> Relations:
    found = Relations()
    for batch in batches(cell, each):
        part = relate(Desk(engine, judges), cell, batch, names=names)
        found.findings += part.findings
        found.counts.update(part.counts)
    return found


def compared(found: Relations) -> int:
    return sum(n for key, n in found.counts.items() if key[3] is Verdicts.AGREES)


FAILED = (Verdicts.WRONG, Verdicts.INCONSISTENT, Verdicts.CRASHED, Verdicts.REFERENCE_WRONG)


def broken(found: Relations) -> set[str]:
    """Relations between whose answers something was wrong."""
    return {key[1] for key, n in found.counts.items() if n and key[3] in FAILED}


def told(found: Relations) -> list[tuple[str, str]]:
    return [(f.related.relation if f.related else "", f.verdict.claim) for f in found.findings]


class Spoiled(Reference):
    """The reference, spoiled in one cell, asked in either order of the types or in one."""

    def __init__(self, cell: Cell, spoil: Spoil, *, one_way: bool = False) -> None:
        self.cell, self.spoil, self.one_way = cell, spoil, one_way

    def answer(self, query: str, A: Kind, B: Kind, rows_a: Any, rows_b: Any) -> Answers:
        answers = super().answer(query, A, B, rows_a, rows_b)
        flipped = Cell(query, B, A) == self.cell and A is not B and not self.one_way
        if Cell(query, A, B) != self.cell and not flipped:
            return answers
        columns = {name: np.array(getattr(answers, name)) for name in COLUMNS}
        sides = A.unpack(np.asarray(rows_a)[:, : None if query != IMPACT else A.width()]), B.unpack(np.asarray(rows_b))
        self.spoil(query, *(sides[::-1] if flipped else sides), columns)
        table = np.full((len(answers), WIDTH), np.nan)
        for name, values in columns.items():
            table[:, COLUMNS[name]] = values.reshape(len(answers), -1)
        return Answers.from_table(np.array(answers.status), table, {})


# -- right engines -------------------------------------------------------------------------------------------

QUERIES = (DISTANCE, CONTACTS, BOOLEAN)


@pytest.mark.parametrize("cell", [Cell(q, A, B) for q in QUERIES for A in (Point, Sphere) for B in (Sphere, AABB)])
def test_a_right_engine_of_its_own_breaks_none(cell: Cell) -> None:
    found = related(Honest(), cell, 10 * effort())
    assert told(found) == []
    assert compared(found) > 1000


SEARCHED = {Polyhedron, Composite, Cylinder, Ellipsoid, KDOP, ConvexPolyhedron}
SOME = [(Sphere, Polyhedron), (Box, Cylinder), (AABB, KDOP), (Capsule, ConvexPolyhedron), (Sphere, Composite)]
"""Of the pairs that need a search, those that an ordinary run of the tests has time for."""
PAIRS = [
    pair if pair in SOME or not SEARCHED & set(pair) else pytest.param(pair, marks=pytest.mark.soak) for pair in TABLE
]


@pytest.mark.parametrize("pair", PAIRS, ids=name_of)
def test_the_reference_breaks_none(pair: tuple[Kind, Kind]) -> None:
    quick = not SEARCHED & set(pair)
    for query in (RAYCAST,) if pair[0] is Ray else (DISTANCE, BOOLEAN) if quick else (DISTANCE,):
        found = related(Reference(), Cell(query, *pair), 4 if quick else 1)
        assert told(found) == []
        assert compared(found) > 50


@pytest.mark.parametrize("pair", [(Sphere, Sphere), (Sphere, Box), (Capsule, HalfSpace)])
def test_right_impacts_break_none(pair: tuple[Kind, Kind]) -> None:
    found = related(Reference(), Cell(IMPACT, *pair), 3)
    assert told(found) == []
    assert compared(found) > 150


class Padded(Reference):
    """Adds a margin to everything, and says so, or does not."""

    def __init__(self, *, declared: bool) -> None:
        self.declared = declared

    def effective(self, query: str, A: Kind, rows_a: Any, B: Kind, rows_b: Any) -> tuple[Effective, Effective]:
        margin = 0.01 if self.declared and query == DISTANCE else 0.0
        sides = [Effective(kind, rows, np.full(len(rows), margin)) for kind, rows in ((A, rows_a), (B, rows_b))]
        return sides[0], sides[1]

    def answer(self, query: str, A: Kind, B: Kind, rows_a: Any, rows_b: Any) -> Answers:
        answers = super().answer(query, A, B, rows_a, rows_b)
        if query == DISTANCE:
            np.copyto(answers.distance, answers.distance - 0.02)
            for name in ("normal", "on_a", "on_b"):
                np.copyto(getattr(answers, name), np.nan)
        return answers


def test_margins_that_are_declared_are_no_contradiction() -> None:
    cell = Cell(DISTANCE, Sphere, Box)
    assert told(related(Padded(declared=True), cell, 6)) == []
    failed = broken(related(Padded(declared=False), cell, 6))
    assert {"scaled_up", "scaled_down", "queries"} <= failed
    assert not failed & {"swapped", "mirrored", "turned", "quarter_turned", "translated"}


class Rough(Spoiled):
    """Declares that it may be as wrong as it is."""

    def tolerance(self, query: str, A: Kind, B: Kind) -> Any:
        found = super().tolerance(query, A, B)
        return type(found).uniform(0.0, 0.3, "rough") if query == DISTANCE else found


def test_an_error_within_the_tolerance_is_none() -> None:
    cell = Cell(DISTANCE, Sphere, Sphere)
    assert told(related(Rough(cell, _off(lambda a, b: a.center[:, 0] > 0)), cell, 6)) == []


# -- engines that break one ------------------------------------------------------------------------------------


def _off(where: Callable[[Any, Any], Any]) -> Spoil:
    """Too far by a tenth of the way between the centres, where a condition holds."""

    def spoil(query: str, a: Any, b: Any, columns: Columns) -> None:
        columns["distance"] += np.where(where(a, b), 0.1 * norm(_apart(a, b)), 0.0)

    return spoil


def _apart(a: Any, b: Any) -> Any:
    return b.reference_point - a.reference_point


def _widest(a: Any, b: Any) -> Any:
    return np.argmax(np.abs(_apart(a, b)), axis=-1)


def _handed(a: Any, b: Any) -> Any:
    """Whether a triple of directions that no change of frame touches is left-handed."""
    along = np.cross(b.q - b.p, a.center - b.p)
    far = a.center + b.p + b.q
    return np.sum(along * far, axis=-1) < 0


BOTH = ["swapped", "mirrored", "turned", "quarter_turned", "translated", "scaled_up", "scaled_down", "same_sets"]
BALLS, BALL_CAPSULE = Cell(DISTANCE, Sphere, Sphere), Cell(DISTANCE, Sphere, Capsule)

FAULTS: list[tuple[Cell, Callable[[Any, Any], Any], set[str]]] = [
    (BALLS, lambda a, b: a.radius > b.radius, {"swapped"}),
    (BALLS, lambda a, b: _widest(a, b) == 2, {"turned"}),
    (BALLS, lambda a, b: np.abs(_apart(a, b))[:, 0] > 1.01 * np.abs(_apart(a, b))[:, 1], {"turned", "quarter_turned"}),
    (BALLS, lambda a, b: norm(a.center + b.center) > 8 * norm(_apart(a, b)), {"translated"}),
    (BALLS, lambda a, b: np.minimum(a.radius, b.radius) > 100, {"scaled_up", "scaled_down"}),
    (BALL_CAPSULE, lambda a, b: norm(a.center - b.p) < 0.9 * norm(a.center - b.q), {"same_sets"}),
    (BALL_CAPSULE, _handed, {"mirrored", "translated", "same_sets"}),
    (Cell(DISTANCE, Sphere, Box), lambda a, b: b.rotation[:, 3] < 0, {"same_sets"}),
]


@pytest.mark.parametrize(("cell", "where", "expected"), FAULTS)
def test_a_broken_relation_is_found_and_no_other(cell: Cell, where: Any, expected: set[str]) -> None:
    found = related(Spoiled(cell, _off(where)), cell, 8, BOTH)
    assert broken(found) == expected


def test_one_order_of_a_pair_may_be_the_wrong_one() -> None:
    engine = Spoiled(Cell(DISTANCE, Box, Sphere), _off(lambda a, b: a.magnitude > 0), one_way=True)
    found = related(engine, Cell(DISTANCE, Sphere, Box), 2, BOTH)
    assert broken(found) == {"swapped"}


ELSEWHERE: list[tuple[str, Cell, Cell]] = [
    ("as_ellipsoid", Cell(DISTANCE, Sphere, Box), Cell(DISTANCE, Box, Ellipsoid)),
    ("as_capsule", Cell(DISTANCE, Sphere, Box), Cell(DISTANCE, Capsule, Box)),
    ("as_capsule", Cell(DISTANCE, Point, Box), Cell(DISTANCE, Capsule, Box)),
    ("as_box", Cell(DISTANCE, Sphere, AABB), Cell(DISTANCE, Sphere, Box)),
    ("as_kdop", Cell(DISTANCE, Sphere, AABB), Cell(DISTANCE, Sphere, KDOP)),
    ("as_hull", Cell(DISTANCE, Sphere, Box), Cell(DISTANCE, Sphere, ConvexPolyhedron)),
    ("as_hull", Cell(DISTANCE, Sphere, KDOP), Cell(DISTANCE, Sphere, ConvexPolyhedron)),
    ("as_composite", Cell(DISTANCE, Sphere, Cylinder), Cell(DISTANCE, Sphere, Composite)),
    ("queries", Cell(DISTANCE, Sphere, Box), Cell(CONTACTS, Sphere, Box)),
    ("segment", Cell(RAYCAST, Ray, Box), Cell(DISTANCE, Capsule, Box)),
    ("arrival", Cell(RAYCAST, Ray, Box), Cell(DISTANCE, Point, Box)),
    ("witnesses", Cell(DISTANCE, Capsule, Box), Cell(DISTANCE, Point, Box)),
]


@pytest.mark.parametrize(("name", "cell", "other"), ELSEWHERE)
def test_an_error_in_one_cell_shows_against_another(name: str, cell: Cell, other: Cell) -> None:
    found = related(Spoiled(other, _off(lambda a, b: a.magnitude >= 0)), cell, 4)
    assert broken(found) == {name}
    assert {f.verdict.kind for f in found.findings} == {Verdicts.WRONG}
    assert all(f.scene.cell in (other, Cell(cell.query, cell.type_b, cell.type_a)) for f in found.findings)


def _cut(query: str, a: Any, b: Any, columns: Columns) -> None:
    columns["distance"] += np.where(len(b.triangles) > 40, 0.1, 0.0) * np.maximum(a.magnitude, b.magnitude)


def test_a_leak_between_triangles_shows_when_a_mesh_is_refined() -> None:
    cell = Cell(DISTANCE, Sphere, Polyhedron)
    found = related(Spoiled(cell, _cut), cell, 2, ["finer_mesh", "turned", "mirrored"])
    assert broken(found) == {"finer_mesh"}


def _wrong_sign(query: str, a: Any, b: Any, columns: Columns) -> None:
    columns["distance"] += 2 * (a.radius + b.radius)


def _flipped(query: str, a: Any, b: Any, columns: Columns) -> None:
    columns["normal"] *= -1


def _elsewhere(query: str, a: Any, b: Any, columns: Columns) -> None:
    columns["on_a"] += 0.1 * np.maximum(a.magnitude, b.magnitude)[:, None]


def _late(query: str, a: Any, b: Any, columns: Columns) -> None:
    columns["t"] *= 1.1


def _blind(query: str, a: Any, b: Any, columns: Columns) -> None:
    columns["hit"][:] = 0


def _forgets_large(query: str, a: Any, b: Any, columns: Columns) -> None:
    columns["hit"] = np.where(b.radius > a.radius, 0, columns["hit"])


OWN: list[tuple[str, Cell, Spoil]] = [
    ("larger", BALLS, _wrong_sign),
    ("larger", Cell(BOOLEAN, Sphere, Sphere), _forgets_large),
    ("normals", BALLS, _flipped),
    ("witnesses", BALLS, _elsewhere),
    ("arrival", Cell(RAYCAST, Ray, Sphere), _late),
    ("segment", Cell(RAYCAST, Ray, Sphere), _blind),
    ("queries", Cell(BOOLEAN, Sphere, Sphere), _blind),
]


@pytest.mark.parametrize(("name", "spoiled", "spoil"), OWN)
def test_an_engine_that_contradicts_itself_is_found(name: str, spoiled: Cell, spoil: Spoil) -> None:
    asked = BALLS if name == "queries" else spoiled
    assert name in broken(related(Spoiled(spoiled, spoil), asked, 6))


def _clamped(query: str, a: Any, b: Any, columns: Columns) -> None:
    for name in VELOCITIES:
        columns[name] = np.clip(columns[name], -8.0, 8.0)


def _left_handed(query: str, a: Any, b: Any, columns: Columns) -> None:
    columns["angular_a"] = np.abs(columns["angular_a"])


class Heavy(Reference):
    """Heavy bodies do not bounce."""

    def answer(self, query: str, A: Kind, B: Kind, rows_a: Any, rows_b: Any) -> Answers:
        motion = Motion.unpack(np.asarray(rows_a)[:, -MOTION:])
        return reference_of(replace(motion, restitution=motion.restitution * (motion.a.inverse_mass > 0.2)))


MEETING, AGAINST_BOX = Cell(IMPACT, Sphere, Sphere), Cell(IMPACT, Sphere, Box)


@pytest.mark.parametrize(
    ("engine", "cell", "expected"),
    [
        (Spoiled(MEETING, _clamped), MEETING, {"moving_along", "quicker", "scaled_up"}),
        (Heavy(), MEETING, {"heavier", "swapped"}),
        (Spoiled(AGAINST_BOX, _left_handed), AGAINST_BOX, {"mirrored", "quarter_turned"}),
    ],
)
def test_impacts_that_break_a_principle_are_found(engine: Engine, cell: Cell, expected: set[str]) -> None:
    assert expected <= broken(related(engine, cell, 6))


# -- findings ----------------------------------------------------------------------------------------------------


def test_a_finding_names_both_scenes_and_carries_the_proof() -> None:
    cell = Cell(DISTANCE, Box, Sphere)
    engine = Spoiled(cell, _off(lambda a, b: a.magnitude > 0), one_way=True)
    finding = related(engine, Cell(DISTANCE, Sphere, Box), 2, ["swapped"]).findings[0]
    verdict, other = finding.verdict, finding.related
    assert other is not None
    assert verdict.kind is Verdicts.INCONSISTENT
    assert verdict.symptom == "swapping A and B changes the distance"
    assert (type(other.scene.a), type(other.scene.b)) == (Box, Sphere)
    assert other.answer["distance"] != finding.answer["distance"]
    assert verdict.proof_scene is not None
    lower, upper = check(verdict.certificate, verdict.proof_scene.a, verdict.proof_scene.b)
    assert verdict.lower <= lower <= upper <= verdict.upper
    assert verdict.severity is not None
    again = question(Desk(engine), "swapped", finding.scene)
    assert again is not None
    assert (again.verdict.symptom, again.verdict.amount) == (verdict.symptom, verdict.amount)
    assert question(Desk(Reference()), "swapped", finding.scene) is None


class Clueless:
    """Judges who can tell nothing."""

    def screen(self, *given: Any) -> Screening:
        return Screening.of_fates(given[-1])

    def convict(self, *_: object) -> Verdict:
        return Verdict(Verdicts.UNDECIDED)


def test_a_contradiction_needs_no_reference() -> None:
    found = related(Spoiled(BALLS, _off(lambda a, b: a.radius > b.radius)), BALLS, 4, ["swapped"], Clueless())
    assert found.findings
    for finding in found.findings:
        assert finding.verdict.kind is Verdicts.INCONSISTENT
        assert finding.verdict.certificate is None
        assert "at least one of the two is wrong" in finding.verdict.claim
        off = float(norm(_apart(finding.scene.a, finding.scene.b)))
        assert finding.verdict.amount == pytest.approx(0.1 * off, rel=1e-6)


class Fragile(Reference):
    """Cannot answer what is far away, or anything that is the wrong way round."""

    def __init__(self, *, one_way: bool = False) -> None:
        self.one_way = one_way

    def answer(self, query: str, A: Kind, B: Kind, rows_a: Any, rows_b: Any) -> Answers:
        answers = super().answer(query, A, B, rows_a, rows_b)
        lost = np.abs(np.asarray(rows_a)[:, :3]).max(axis=1) > 200
        lost = np.full(len(lost), (A, B) not in TABLE) if self.one_way else lost
        status = np.where(lost, Status.CRASHED, Status.ANSWERED).astype(np.int8)
        columns = {name: getattr(answers, name) for name in COLUMNS}
        return Answers(status, **columns, errors={int(i): "on purpose" for i in np.flatnonzero(lost)})


def test_a_lost_image_is_a_finding() -> None:
    found = related(Fragile(), BALLS, 4, ["scaled_up", "swapped"])
    assert broken(found) == {"scaled_up", "swapped"}
    assert {f.verdict.kind for f in found.findings} == {Verdicts.CRASHED}
    assert "on purpose" in found.findings[0].verdict.claim
    other_way = related(Fragile(one_way=True), Cell(DISTANCE, Sphere, Box), 4, ["swapped"])
    assert {f.verdict.symptom for f in other_way.findings} == {"swapping A and B loses the answer"}


class Picky(Reference):
    def _support(self, query: str, A: Kind, B: Kind) -> Support:
        return NATIVE if (A, B) in TABLE and query == DISTANCE else Support(type(NATIVE.kind).UNSUPPORTED, "no")

    def conventions(self, query: str, A: Kind, B: Kind) -> Any:
        return {Convention.NO_DEPTH: "on purpose"}


def test_what_cannot_be_asked_or_compared_is_counted() -> None:
    found = related(Picky(), Cell(DISTANCE, Sphere, Box), 2)
    counts = {(key[1], key[3]): n for key, n in found.counts.items()}
    assert counts["swapped", Verdicts.UNSUPPORTED] == counts["mirrored", Verdicts.AGREES] > 20
    assert counts["queries", Verdicts.UNSUPPORTED] == 2 * counts["mirrored", Verdicts.AGREES]


def test_every_relation_says_why_it_exists() -> None:
    for name, relation in RELATIONS.items():
        assert relation.name == name
        assert len(relation.reason) > 30
        assert relation.reason.endswith(".")


def test_relations_are_pure_functions_of_the_batch() -> None:
    engine = Spoiled(BALLS, _off(lambda a, b: a.radius > b.radius))
    first, second = (related(engine, BALLS, 3) for _ in range(2))
    assert first.counts == second.counts
    assert [f.scene.id for f in first.findings] == [f.scene.id for f in second.findings]


HALF_SPACES = Cell(DISTANCE, HalfSpace, HalfSpace)


def test_half_spaces_are_related_exactly_or_not_at_all() -> None:
    found = related(Reference(), HALF_SPACES, 6)
    assert told(found) == []
    assert compared(found) > 250


def test_a_contradiction_is_shrunk_to_a_simple_scene() -> None:
    engine = Spoiled(BALLS, _off(lambda a, b: a.radius > b.radius))
    desk: Any = Desk(engine, Clueless())
    finding = related(engine, BALLS, 2, ["swapped"], Clueless()).findings[0]
    shrunk = shrink(finding, desk, tries=400)
    assert shrunk.verdict.kind is Verdicts.INCONSISTENT
    assert shrunk.verdict.symptom == finding.verdict.symptom
    assert shrunk.related is not None
    assert np.array_equal(shrunk.related.scene.a.pack(), shrunk.scene.b.pack())
    assert odd_numbers(shrunk.scene) <= 2 < odd_numbers(finding.scene)
    assert shrunk.repeats


def test_a_contradiction_survives_its_record() -> None:
    engine = Spoiled(BALLS, _off(lambda a, b: a.radius > b.radius))
    outcome = Outcome(findings=related(engine, BALLS, 2, ["swapped"], Clueless()).findings[:2])
    outcome.relations["spoiled", "swapped", DISTANCE, Verdicts.INCONSISTENT] = 2
    again = outcome_from_json(json.loads(json.dumps(outcome_to_json(outcome))))
    assert again.relations == outcome.relations
    for one, two in zip(outcome.findings, again.findings, strict=True):
        assert one.related is not None
        assert two.related is not None
        assert (one.related.scene.id, one.related.answer) == (two.related.scene.id, two.related.answer)
        assert one.verdict.claim == two.verdict.claim
