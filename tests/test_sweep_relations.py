"""Relations of sweeps: engines that break one are caught by it; right ones are let through."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from oracles.batch import Batch
from oracles.course import WIDTH as COURSE
from oracles.course import Course
from oracles.engine import COLUMNS, NATIVE, WIDTH, Answers, Engine, Kind, Support
from oracles.outcome import Kind as Verdicts
from oracles.outcome import Verdict
from oracles.relations import Relations, question, relate
from oracles.scene import DISTANCE, RAYCAST, SWEEP, Cell
from oracles.screening import Screening
from oracles.sweep_reference import sweep_answers
from refimpl.linear import norm
from refimpl.proof import check_sweep
from refimpl.shapes import AABB, Box, Capsule, Composite, Point, Ray, Sphere
from tests.reference_engine import Desk, Reference

Spoil = Callable[[Any, Any, Course, Any], None]
"""Changes the times of answers in place; infinite is a miss."""
BALLS, BALL_BOX = Cell(SWEEP, Sphere, Sphere), Cell(SWEEP, Sphere, Box)


class Moving(Reference):
    """The reference, asked for sweeps as well; spoiled in one cell."""

    def __init__(self, cell: Cell | None = None, spoil: Spoil | None = None) -> None:
        self.cell, self.spoil = cell, spoil

    def _sweep_support(self, A: Kind, B: Kind) -> Support:
        return NATIVE

    def says(self, query: str, A: Kind, B: Kind) -> frozenset[str]:
        return frozenset({"hit", "t"}) if query == SWEEP else super().says(query, A, B)

    def answer(self, query: str, A: Kind, B: Kind, rows_a: Any, rows_b: Any) -> Answers:
        spoiled = self.spoil is not None and Cell(query, A, B) == self.cell
        if query != SWEEP:
            found = super().answer(query, A, B, rows_a, rows_b)
            return found if not spoiled else _with(found, t=1.2 * found.t)
        rows = np.asarray(rows_a)
        a, b, course = A.unpack(rows[:, :-COURSE]), B.unpack(np.asarray(rows_b)), Course.unpack(rows[:, -COURSE:])
        found = sweep_answers(a, b, course)
        times = np.array(found.t)
        if spoiled and self.spoil is not None:
            self.spoil(a, b, course, times)
        return _with(found, hit=np.isfinite(times).astype(float), t=times)


def _with(answers: Answers, **columns: Any) -> Answers:
    """The same with other hits and times, and without all that is not said of a sweep."""
    kept = {name: getattr(answers, name) for name in COLUMNS} if "hit" not in columns else {}
    table = np.full((len(answers), WIDTH), np.nan)
    for name, values in (kept | columns).items():
        table[:, COLUMNS[name]] = np.reshape(values, (len(answers), -1))
    return Answers.from_table(np.array(answers.status), table, {})


def related(engine: Engine, cell: Cell, each: int, names: list[str] | None = None, judges: Any = None) -> Relations:
    found = Relations()
    for batch in Batch.draw_sweeps((cell.type_a, cell.type_b), 5, (0,), each):
        part = relate(Desk(engine, judges), cell, batch, names=names)
        found.findings += part.findings
        found.counts.update(part.counts)
    return found


def broken(found: Relations) -> set[str]:
    failed = (Verdicts.WRONG, Verdicts.INCONSISTENT, Verdicts.REFERENCE_WRONG)
    return {key[1] for key, n in found.counts.items() if n and key[3] in failed}


SOME = ["translated", "contact", "second_half"]


@pytest.mark.parametrize(
    ("pair", "names", "least"),
    [((Sphere, Sphere), None, 180), ((Point, Box), None, 180), ((Sphere, Composite), SOME, 15)],
)
def test_the_reference_breaks_none(pair: tuple[Kind, Kind], names: list[str] | None, least: int) -> None:
    found = related(Moving(), Cell(SWEEP, *pair), 1, names)
    assert [f.verdict.claim for f in found.findings] == []
    assert sum(n for key, n in found.counts.items() if key[3] is Verdicts.AGREES) > least
    assert not any(n for key, n in found.counts.items() if key[3] is Verdicts.UNDECIDED)


def _between(course: Course) -> Any:
    return course.a.linear - course.b.linear


def _late(where: Callable[[Any, Any, Course], Any]) -> Spoil:
    """A third of the way late, where a condition holds."""

    def spoil(a: Any, b: Any, course: Course, times: Any) -> None:
        times[:] = np.where(where(a, b, course), times + 1 / 3, times)

    return spoil


def _misses(where: Callable[[Any, Any, Course], Any]) -> Spoil:
    def spoil(a: Any, b: Any, course: Course, times: Any) -> None:
        times[where(a, b, course)] = np.inf

    return spoil


def _blind_to_near(a: Any, b: Any, course: Course, times: Any) -> None:
    """Misses what comes soon."""
    times[(times > 0) & (times < 0.4)] = np.inf


def _of_steps(a: Any, b: Any, course: Course, times: Any) -> None:
    """To the next tenth of the whole way, whatever that is."""
    times[:] = np.ceil(10 * times) / 10


KEPT = "mirrored"
"""What all of the following keep."""
BROKEN: list[tuple[Cell, Spoil, set[str]]] = [
    (BALLS, _late(lambda a, b, c: a.radius > b.radius), {"swapped"}),
    (BALLS, _late(lambda a, b, c: norm(c.a.linear) > 4 * norm(_between(c))), {"moving_along"}),
    (BALLS, _late(lambda a, b, c: norm(a.center) > 8 * norm(_between(c))), {"translated"}),
    (BALLS, _late(lambda a, b, c: np.minimum(a.radius, b.radius) > 30), {"scaled_up"}),
    (BALLS, _late(lambda a, b, c: np.maximum(a.radius, b.radius) < 1 / 30), {"scaled_down"}),
    (BALLS, _of_steps, {"first_half"}),
    (BALL_BOX, _late(lambda a, b, c: b.rotation[:, 3] < 0), {"same_sets"}),
]


@pytest.mark.parametrize(("cell", "spoil", "expected"), BROKEN)
def test_a_broken_relation_is_found(cell: Cell, spoil: Spoil, expected: set[str]) -> None:
    assert broken(related(Moving(cell, spoil), cell, 2, [*expected, KEPT])) == expected


@pytest.mark.parametrize(
    ("spoil", "name"),
    [
        (_misses(lambda a, b, c: _between(c)[:, 0] < 0), "backwards"),
        (_blind_to_near, "second_half"),
        (_late(lambda a, b, c: np.argmax(np.abs(_between(c)), axis=-1) == 2), "turned"),
    ],
)  # fmt: skip
def test_a_relation_of_motion_is_broken_alone(spoil: Spoil, name: str) -> None:
    found = related(Moving(BALLS, spoil), BALLS, 2, [name])
    assert {f.verdict.kind for f in found.findings} == {Verdicts.WRONG}
    assert broken(found) == {name}


def test_an_error_in_one_cell_shows_against_another() -> None:
    for name, cell, other in (
        ("as_capsule", BALL_BOX, Cell(SWEEP, Capsule, Box)),
        ("as_box", Cell(SWEEP, Sphere, AABB), BALL_BOX),
        ("flight", Cell(SWEEP, Point, Sphere), Cell(RAYCAST, Ray, Sphere)),
    ):
        found = related(Moving(other, _late(lambda a, b, c: a.magnitude >= 0)), cell, 1, [name])
        assert {f.scene.cell for f in found.findings} == {other}, name
        assert {f.verdict.kind for f in found.findings} == {Verdicts.WRONG}


class Clueless:
    """Judges who can tell nothing."""

    def screen(self, *given: Any) -> Screening:
        return Screening.of_fates(given[-1])

    def convict(self, *_: object) -> Verdict:
        return Verdict(Verdicts.UNDECIDED)


def test_a_time_that_the_engines_own_distance_contradicts_needs_no_reference() -> None:
    late = Moving(BALLS, _late(lambda a, b, c: norm(_between(c)) > 0))
    found = related(late, BALLS, 2, ["contact"], Clueless())
    assert found.findings
    for finding in found.findings:
        assert finding.verdict.kind is Verdicts.INCONSISTENT
        assert finding.verdict.symptom == "a sweep contradicts the distance at its time"
        assert finding.related is not None
        assert finding.related.scene.query == DISTANCE
        assert finding.verdict.amount is not None
        assert finding.verdict.amount == pytest.approx(abs(float(finding.related.answer["distance"])), rel=1e-6)
    assert not related(Moving(), BALLS, 2, ["contact"], Clueless()).findings


def test_a_contradiction_of_swapped_sides_carries_the_proof_of_the_second() -> None:
    engine = Moving(Cell(SWEEP, Box, Sphere), _late(lambda a, b, c: a.magnitude > 0))
    finding = related(engine, BALL_BOX, 1, ["swapped"]).findings[0]
    verdict, other = finding.verdict, finding.related
    assert verdict.kind is Verdicts.INCONSISTENT
    assert other is not None
    assert (type(other.scene.a), type(other.scene.b)) == (Box, Sphere)
    assert "swapping A and B changes the" in verdict.symptom
    proof = verdict.proof_scene
    assert proof is not None
    assert proof.course is not None
    lower, upper = check_sweep(verdict.certificate, proof.a, proof.b, *proof.course.motions)
    way = float(proof.course.way(proof.a, proof.b))
    assert verdict.lower <= float(lower) * way <= float(upper) * way <= verdict.upper or verdict.lower == lower
    again = question(Desk(engine), "swapped", finding.scene)
    assert again is not None
    assert (again.verdict.symptom, again.verdict.amount) == (verdict.symptom, verdict.amount)
    assert question(Desk(Moving()), "swapped", finding.scene) is None


def test_backwards_the_last_contact_is_the_first() -> None:
    """A ball through another, head on: they touch from 0.25 to 0.75 of the way."""
    a, b = Sphere([[-4.0, 0, 0]], [1.0]), Sphere([[0.0, 0, 0]], [1.0])
    course = Course.translating([[8.0, 0, 0]], [[0.0, 0, 0]])
    batch = Batch(a, b, ["own"], np.zeros(1, int), np.zeros(1, int), "own", {0: ""}, course)
    for said, wrong in ((0.25, False), (0.7, False), (0.8, True)):  # nothing that touches begins after the last contact

        def spoil(a: Any, b: Any, course: Course, times: Any, said: float = said) -> None:
            times[course.a.linear[:, 0] > 0] = said

        found = relate(Desk(Moving(BALLS, spoil)), BALLS, batch, names=["backwards"])
        assert broken(found) == ({"backwards"} if wrong else set())
