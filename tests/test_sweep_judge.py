"""Sweeps under judgement: engines that are wrong are found and named, the right one never is."""

from __future__ import annotations

import dataclasses
import json
import math
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from oracles import claims, sweep_reference
from oracles.answers import take
from oracles.batch import Batch
from oracles.course import Course
from oracles.engine import Answers, Status, answer_row
from oracles.judges import Judges, audited, finding_of
from oracles.outcome import Kind, Verdict
from oracles.records import finding_from_json, finding_to_json
from oracles.scene import SWEEP, Scene
from oracles.strategies import scenes
from oracles.sweep_reference import first_contacts, proven_sweep
from oracles.sweep_regimes import SWEEP_REGIMES, TURNING
from refimpl import Box, Capsule, Sphere, distance
from refimpl.motions import RigidMotion
from refimpl.shapes import Point
from tests.conftest import name_of
from tests.sweeping_engines import (
    AtStart,
    Bounding,
    Deaf,
    Flipped,
    InLengths,
    Outside,
    Padded,
    Scaled,
    Stepping,
    Sweeper,
    answers_of,
)

# A ball of radius 1 comes from the left by 8 and meets a wall of thickness 2 at x = 6 − 1 − 1 = 4, at half time.
WALL = Scene(
    SWEEP,
    Sphere([0, 0, 0], 1),
    Box([6, 0, 0], [1, 2, 2], [0, 0, 0, 1]),
    "example",
    "",
    Course.translating([8, 0, 0], [0, 0, 0]),
)
RIGHT: dict[str, Any] = {"hit": 1.0, "t": 0.5, "point": [5, 0, 0], "normal": [1, 0, 0]}


def told(**values: Any) -> Answers:
    """One answer."""
    return Answers.from_table(np.array([Status.ANSWERED], dtype=np.int8), np.array([answer_row(**values)]), {})


def convict(scene: Scene, **values: Any) -> Verdict:
    """Verdict on one answer, by both judges: the floats must say the same."""
    judges, answers = Judges(Sweeper()), told(**values)
    verdict = judges.convict(scene, answers)
    motion = None if scene.motion is None else scene.motion[None]
    seen = judges.screen(scene.cell, scene.a[None], scene.b[None], motion, answers)
    assert (seen.kind[0], seen.symptom[0]) == (verdict.kind, verdict.symptom)
    assert seen.amount[0] == pytest.approx(verdict.amount, rel=1e-6, abs=1e-9)
    return verdict


CASES: list[tuple[dict[str, Any], str, float]] = [
    ({"t": 0.25}, claims.EARLY, 2.0),  # a quarter of the way of 8 is left
    ({"t": 0.625}, claims.LATE, 1.0),  # an eighth of the way of 8 since then
    ({"t": 0.0}, claims.EARLY, 4.0),
    ({"hit": 0.0, "t": np.inf}, claims.SWEEP_MISSED, 2.0),  # in the wall to a depth of 2, at least
    ({"point": [5, 3, 0]}, claims.SWEEP_POINT, 2.0),
    ({"normal": [-1, 0, 0]}, claims.SWEEP_TILTED, 1.0),
    ({"normal": [0.5, 0, 0]}, claims.BRIEF, 0.5),
]


@pytest.mark.parametrize(("change", "symptom", "amount"), CASES)
def test_each_error_is_named_and_measured(change: dict[str, Any], symptom: str, amount: float) -> None:
    assert convict(WALL, **RIGHT).kind is Kind.AGREES
    found = convict(WALL, **{**RIGHT, **change})
    assert (found.kind, found.symptom) == (Kind.WRONG, symptom)
    assert amount * (1 - 1e-6) <= found.amount <= (amount if symptom != claims.SWEEP_TILTED else 9.0) * 1.5
    if symptom in (claims.EARLY, claims.LATE, claims.SWEEP_MISSED):
        assert found.lower <= 0.5 <= found.upper
        assert found.upper - found.lower <= 1e-12


def test_a_hit_without_a_time_is_no_answer() -> None:
    found = Judges(Sweeper()).convict(WALL, told(**{**RIGHT, "t": math.nan}))
    assert (found.kind, found.symptom) == (Kind.WRONG, claims.NOT_A_NUMBER)
    assert found.certificate is not None


def test_a_hit_of_what_is_missed_is_false_by_the_gap_at_its_time() -> None:
    past = dataclasses.replace(WALL, motion=Course.translating([8, 8, 0], [0, 0, 0]), b=WALL.b.translated([0, -4, 0]))
    found = convict(past, **{**RIGHT, "t": 0.25})
    assert (found.symptom, found.lower) == (claims.SWEEP_FALSE, math.inf)
    assert past.course is not None
    at = past.course.at(past.a, past.b, 0.25)
    assert found.amount == pytest.approx(float(distance(*at).distance), rel=1e-9)
    assert convict(past, hit=0.0, t=np.inf).kind is Kind.AGREES


def test_of_a_graze_a_slightly_wrong_time_is_no_error_but_of_a_hit_it_is() -> None:
    """The ball passes under the wall's edge by 1e-10: the way that is off is long, the gap and the depth are not."""
    graze = dataclasses.replace(WALL, a=WALL.a.translated([0, 3.0 - 1e-10, 0]))
    found = first_contacts(graze.a[None], graze.b[None], Course.translating([8, 0, 0], [0, 0, 0])[None])
    assert found.hit[0]
    time = float(found.t[0])
    point, normal = found.point[0].tolist(), found.normal[0].tolist()
    judges = Judges(Sweeper())
    for t in (time - 1e-6, time, time + 1e-6):
        assert judges.convict(graze, told(hit=1.0, t=t, point=point, normal=normal)).kind is Kind.AGREES
    assert judges.convict(graze, told(hit=0.0, t=np.inf)).kind is Kind.AGREES
    assert convict(WALL, **{**RIGHT, "t": 0.5 + 1e-6}).symptom == claims.LATE
    assert convict(WALL, **{**RIGHT, "t": 0.5 - 1e-6}).symptom == claims.EARLY


def test_only_the_relative_motion_counts_and_the_point_moves_along() -> None:
    both = dataclasses.replace(WALL, motion=Course.translating([11, 5, 0], [3, 5, 0]))
    assert convict(both, **{**RIGHT, "point": [6.5, 2.5, 0]}).kind is Kind.AGREES
    assert convict(both, **RIGHT).symptom == claims.SWEEP_POINT


def test_overlap_from_the_start_is_contact_at_0_without_a_normal() -> None:
    inside = dataclasses.replace(WALL, a=WALL.a.translated([5, 0, 0]))
    assert convict(inside, hit=1.0, t=0.0, point=[5.5, 0, 0]).kind is Kind.AGREES
    assert convict(inside, hit=0.0, t=np.inf).symptom == claims.SWEEP_MISSED


# -- wrong engines ---------------------------------------------------------------------------------------------

PAIRS = [(Sphere, Sphere), (Sphere, Box), (Point, Capsule), (Box, Box)]
STRAIGHT = [name for name in SWEEP_REGIMES if name not in TURNING]

PLANTED: list[tuple[type[Sweeper], tuple[Any, Any], set[str]]] = [
    (Stepping, (Sphere, Box), {claims.SWEEP_MISSED, claims.LATE}),
    (Bounding, (Box, Box), {claims.EARLY, claims.SWEEP_FALSE}),
    (Deaf, (Sphere, Box), {claims.SWEEP_MISSED}),
    (InLengths, (Sphere, Sphere), {claims.LATE, claims.EARLY}),
    (Flipped, (Sphere, Sphere), {claims.SWEEP_TILTED}),
    (AtStart, (Sphere, Box), {claims.SWEEP_POINT}),
    (Padded, (Sphere, Box), {claims.EARLY, claims.SWEEP_FALSE}),
    (Outside, (Sphere, Sphere), {claims.SWEEP_MISSED}),
    (Scaled, (Sphere, Box), {claims.LENGTHY}),
]


@pytest.fixture(scope="module")
def drawn() -> dict[tuple[Any, Any], Batch]:
    """Three scenes of every regime without turning, of each pair."""
    found = {}
    for pair in PAIRS:
        (batch,) = Batch.draw_sweeps(pair, 5, (1, 2), 3)
        rows = [i for i, name in enumerate(batch.regimes) if name in STRAIGHT]
        course = batch.motion[rows] if isinstance(batch.motion, Course) else None
        names = [batch.regimes[i] for i in rows]
        groups, numbers = batch.groups[rows], batch.numbers[rows]
        found[pair] = dataclasses.replace(
            batch, a=batch.a[rows], b=batch.b[rows], regimes=names, groups=groups, numbers=numbers, motion=course
        )
    return found


def screened(engine: Sweeper, batch: Batch) -> tuple[Any, Answers]:
    """What the judge makes of a whole batch."""
    kinds = type(batch.a), type(batch.b)
    answers = answers_of(engine, SWEEP, kinds, batch.rows)
    cell = batch.scene(SWEEP, 0).cell
    return Judges(engine).screen(cell, batch.a, batch.b, batch.motion, answers), answers


@pytest.mark.parametrize("pair", PAIRS, ids=name_of)
def test_the_right_engine_is_never_wrong(pair: Any, drawn: dict[tuple[Any, Any], Batch]) -> None:
    batch, engine = drawn[pair], Sweeper()
    screening, answers = screened(engine, batch)
    for i in np.flatnonzero(screening.kind != Kind.AGREES):
        assert Judges(engine).convict(batch.scene(SWEEP, int(i)), take(answers, [i])).kind is Kind.AGREES
    hits = {batch.regimes[i] for i in np.flatnonzero(answers.hit == 1)}
    assert len(hits) >= 8
    assert "sweep_just_missing" not in hits


@pytest.mark.parametrize(("kind", "pair", "symptoms"), PLANTED, ids=lambda x: getattr(x, "__name__", ""))
def test_a_wrong_engine_is_found_and_named(
    kind: type[Sweeper], pair: Any, symptoms: set[str], drawn: dict[tuple[Any, Any], Batch]
) -> None:
    batch, engine = drawn[pair], kind()
    screening, answers = screened(engine, batch)
    wrong = np.flatnonzero((screening.kind == Kind.WRONG) & screening.certain)
    seen = {str(screening.symptom[i]) for i in wrong}
    assert symptoms & seen
    first = next(i for i in wrong if screening.symptom[i] in symptoms)
    verdict = Judges(engine).convict(batch.scene(SWEEP, int(first)), take(answers, [first]))
    assert (verdict.kind, verdict.symptom) == (Kind.WRONG, screening.symptom[first])
    assert verdict.certificate is not None
    assert verdict.amount > 0 or verdict.symptom == claims.NOT_A_NUMBER


# -- scenes ----------------------------------------------------------------------------------------------------


@settings(max_examples=25)
@given(data=st.data())
def test_scenes_of_sweeps_go_through_json_to_the_bit(data: st.DataObject) -> None:
    pair = data.draw(st.sampled_from(PAIRS))
    scene = data.draw(scenes(dataclasses.replace(WALL, a=WALL.a).cell.__class__(SWEEP, *pair)))
    again = Scene.from_json(json.loads(json.dumps(scene.to_json())))
    assert again.id == scene.id
    assert np.array_equal(again.rows[0], scene.rows[0])
    moved = dataclasses.replace(scene, motion=Course.translating([1, 2, 3], [0, 0, 7.5]))
    assert moved.id != scene.id


@pytest.mark.parametrize(
    "damage",
    [{"a": {"linear": [1, 2, 3]}}, {"a": 7, "b": 8}, [], {"linear": [1, 2, 3]}],
)
def test_what_is_no_course_is_refused(damage: Any) -> None:
    data = WALL.to_json() | {"motion": damage}
    with pytest.raises(ValueError, match="not a"):
        Scene.from_json(data)
    endless = WALL.to_json()
    endless["motion"]["a"]["linear"][0] = math.inf
    with pytest.raises(ValueError, match="below"):
        Scene.from_json(endless)


def test_a_finding_carries_its_certificate_through_json() -> None:
    answers = told(**{**RIGHT, "t": 0.25})
    verdict = Judges(Sweeper()).convict(WALL, answers)
    finding = finding_of("sweeper", WALL, answers, verdict)
    again = finding_from_json(json.loads(json.dumps(finding_to_json(finding))))
    assert again.verdict.certificate == verdict.certificate
    assert again.scene.id == WALL.id
    data = finding_to_json(finding)
    data["upper"] = 0.4
    with pytest.raises(ValueError, match="proves only"):
        finding_from_json(json.loads(json.dumps(data)))


def test_the_reference_is_audited(drawn: dict[tuple[Any, Any], Batch], monkeypatch: pytest.MonkeyPatch) -> None:
    batch = drawn[Sphere, Sphere]
    for i in range(0, len(batch), 3):
        assert audited(batch.scene(SWEEP, i)).kind is Kind.AGREES
    true = first_contacts(WALL.a[None], WALL.b[None], WALL.course[None])  # type: ignore[index]
    late = dataclasses.replace(true, t=true.t + 0.01)
    monkeypatch.setattr(sweep_reference, "_asked", lambda *_: late)
    sweep_reference._kept.clear()
    found = audited(WALL)
    sweep_reference._kept.clear()
    assert found.kind is Kind.REFERENCE_WRONG


def test_a_course_knows_its_way_and_its_turns() -> None:
    box = Box([0, 0, 0], [3, 4, 0], [0, 0, 0, 1])
    still, spin = np.zeros(3), np.array([0.0, 0.0, 2.0])
    turning = Course(RigidMotion(still, spin, still), RigidMotion([0, 0, 3], still, still))
    assert turning.turns
    assert float(turning.way(box, WALL.b)) == pytest.approx(3 + 2 * 5)
    assert float(WALL.course.way(WALL.a, WALL.b)) == 8  # type: ignore[union-attr]
    assert proven_sweep(WALL.a, WALL.b, WALL.course)[1][0] <= Fraction(1, 2)  # type: ignore[arg-type]
