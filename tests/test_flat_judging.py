"""The flat world under judgement: an engine that is right, and others that are wrong on purpose; impacts."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

pytest.importorskip("pymunk")

import refimpl
from oracles import claims, impact_laws
from oracles.answers import take
from oracles.batch import Batch
from oracles.engine import COLUMNS, AnswerRow, Answers, Engine, Row, Solver, Status
from oracles.engine import Kind as Type
from oracles.engines.pymunk_engine import PymunkEngine
from oracles.flat_stages import FLAT_TARGETS
from oracles.motion import Motion, Moving
from oracles.outcome import FINDINGS, SUSPECT
from oracles.scene import (
    BOOLEAN,
    CONTACTS,
    DISTANCE,
    IMPACT,
    RAYCAST,
    SWEEP,
    Cell,
    Scene,
    cells,
)
from oracles.world import PLANE
from refimpl.flat import Disc, FlatPoint, FlatRay, Rectangle
from refimpl.flat.area import area_properties
from refimpl.linear import dot, norm
from tests.conftest import name_of
from tests.flat_engines import AtTheEnd, FlatTextbook, InLine, Inward, Standing, Stopping, WrongSign
from tests.reference_engine import Desk
from tests.test_pymunk import told


@pytest.fixture(scope="module")
def pymunk() -> PymunkEngine:
    engine = PymunkEngine()
    engine.warm()
    return engine


# -- the judge -----------------------------------------------------------------------------------------------


def batches(cell: Cell, each: int) -> Iterator[Batch]:
    pair = cell.type_a, cell.type_b
    draw = {SWEEP: Batch.draw_sweeps, IMPACT: Batch.draw_impacts}.get(cell.query, Batch.draw)
    drawn = draw(pair, 7, (0,), each)
    for batch in drawn:
        if batch.is_of(cell.query):
            yield batch


def convicted(engine: Engine, cell: Cell, each: int, proofs: int = 1000) -> Counter[str]:
    """Symptoms that are proven of an engine in scenes of every regime; of so many suspects in a batch."""
    desk, found = Desk(engine), Counter[str]()
    for batch in batches(cell, each):
        answers = desk.answer(cell, batch.rows)
        screening = desk.judges.screen(cell, batch.a, batch.b, batch.motion, answers)
        found["scenes"] += len(batch)
        for i in screening.rows_of(SUSPECT)[:proofs].tolist():
            verdict = desk.judges.convict(batch.scene(cell.query, i), take(answers, [i]))
            if verdict.kind in FINDINGS:
                found[verdict.symptom] += 1
    return found


CELLS = [cell for cell in cells() if FlatTextbook().support(cell.query, cell.type_a, cell.type_b)]


def test_a_right_engine_is_never_convicted() -> None:
    assert len(CELLS) == 14
    total = Counter[str]()
    for cell in CELLS:
        total += convicted(FlatTextbook(), cell, 12)
    assert total.keys() == {"scenes"}, total
    assert total["scenes"] > 2500


@pytest.mark.parametrize(
    ("wrong", "cell", "symptoms"),
    [
        (InLine, Cell(BOOLEAN, Disc, Rectangle), {claims.FALSE}),
        (InLine, Cell(DISTANCE, FlatPoint, Rectangle), {claims.SHORT}),
        (WrongSign, Cell(CONTACTS, Disc, Rectangle), {claims.LONG}),
        (Inward, Cell(DISTANCE, Disc, Disc), {claims.STUCK, claims.OVERSHOT}),
        (AtTheEnd, Cell(RAYCAST, FlatRay, Disc), {claims.RAY_POINT}),
        (Stopping, Cell(SWEEP, Disc, Disc), {claims.SWEEP_MISSED}),
        (Standing, Cell(DISTANCE, FlatPoint, Disc), {claims.NOT_A_NUMBER}),
    ],
)
def test_engines_that_are_wrong_are_found_and_named(wrong: type[Engine], cell: Cell, symptoms: set[str]) -> None:
    found = convicted(wrong(), cell, 12, proofs=20)
    assert found.keys() - {"scenes"}, "nothing was found"
    assert found.keys() <= symptoms | {"scenes"}, found


def test_vectors_of_the_plane_are_cut_and_filled() -> None:
    table = np.full((2, 27), np.nan)
    table[:, COLUMNS["normal"]] = [[0.6, 0.8, 0.0], [0.6, 0.0, 0.8]]
    answers = PLANE.cut(Answers.from_table(np.full(2, Status.ANSWERED, dtype=np.int8), table, {}))
    np.testing.assert_array_equal(answers.normal, [[0.6, 0.8], [np.inf, np.inf]])
    np.testing.assert_array_equal(PLANE.fill(answers.normal)[0], [0.6, 0.8, 0.0])
    np.testing.assert_array_equal(PLANE.fill(np.array([np.nan, np.nan])), [np.nan] * 3)


# -- impacts -------------------------------------------------------------------------------------------------


class Sticky(PymunkEngine):
    """Leaves the second body a thousandth of its speed too slow."""

    def solver(self, query: str, A: Type, B: Type) -> Solver:
        solve = super().solver(query, A, B)

        def slowed(a: Row, b: Row) -> AnswerRow:
            row = list(solve(a, b))
            row[COLUMNS["velocity_b"]] = [0.999 * v for v in row[COLUMNS["velocity_b"]]]
            return row

        return slowed


@pytest.mark.parametrize("pair", FLAT_TARGETS, ids=name_of)
def test_impacts_keep_the_laws_and_are_found_out_where_they_do_not(pair: Any, pymunk: PymunkEngine) -> None:
    cell = Cell(IMPACT, *pair)
    found = convicted(pymunk, cell, 12)
    assert found.keys() == {"scenes"}, found
    assert found["scenes"] > 100
    assert impact_laws.MOMENTUM in convicted(Sticky(), cell, 2, proofs=5)


@pytest.mark.parametrize("pair", FLAT_TARGETS, ids=name_of)
def test_flat_impacts_touch_where_they_say(pair: Any) -> None:
    """At the point both have, they part along the normal, and nothing moves out of the plane."""
    batch = next(batches(Cell(IMPACT, *pair), 6))
    motion, size = batch.motion, np.maximum(batch.a.magnitude, batch.b.magnitude)
    assert isinstance(motion, Motion)
    assert not motion.leaves_the_plane
    normal = motion.normal[:, :2] / norm(motion.normal)[:, None]
    for shape, outward in ((batch.a, normal), (batch.b, -normal)):
        off = refimpl.distance(FlatPoint(motion.point[:, :2]), shape).distance
        reach = dot(refimpl.support_point(shape, outward) - motion.point[:, :2], outward)
        assert (np.abs(off) <= 1e-14 * size).all()
        assert (np.abs(reach) <= 1e-14 * size).all()
    for body, shape in zip(motion.bodies, (batch.a, batch.b), strict=True):
        moves = body.inverse_mass > 0
        own = area_properties(shape)
        found = body.inertia[moves, 2, 2] * body.inverse_mass[moves]
        np.testing.assert_allclose(found, own.gyration[moves], rtol=1e-14)
    assert (motion.closing[np.array(batch.regimes) != "parting"] <= 0).all()


def test_fast_bodies_do_not_move_before_they_meet(pymunk: PymunkEngine) -> None:
    """The step is so short that nothing goes far in it, whatever the speed: momentum is kept to rounding."""
    still, one = np.zeros(3), np.eye(3)
    a = Moving(np.array([-1.0, 0.0, 0.0]), np.array([3e7, -4e7, 0.0]), still, np.asarray(1.0), one)
    b = Moving(np.array([1.0, 0.5, 0.0]), still, np.array([0.0, 0.0, 1e7]), np.asarray(2.0), one)
    motion = Motion(a, b, still, np.array([1.0, 0.0, 0.0]), np.asarray(1.0), np.asarray(0.0))
    scene = Scene(IMPACT, Disc([-1.0, 0.0], 1.0), Rectangle([0.0, -0.5], [2.0, 1.5]), "by hand", motion=motion)
    answer = told(pymunk, scene)
    impulse = 2 * 2.5e7 / (1 + 2 + 0.5**2)  # B's point flees by 0.5e7, and its lever is 0.5
    np.testing.assert_allclose(answer["velocity_a"], [3e7 - impulse, -4e7, 0.0], rtol=0, atol=1e-3)
    np.testing.assert_allclose(answer["velocity_b"], [2 * impulse, 0.0, 0.0], rtol=0, atol=1e-3)


def test_an_impact_by_hand(pymunk: PymunkEngine) -> None:
    """A disc of mass 1 runs into one of mass 3 with restitution 1/2: the common speed is 1, and they part with 2."""
    still, one = np.zeros(3), np.eye(3)
    a = Moving(np.array([-1.0, 0.0, 0.0]), np.array([4.0, 1.0, 0.0]), still, np.asarray(1.0), one)
    b = Moving(np.array([1.0, 0.0, 0.0]), still, still, np.asarray(1.0 / 3.0), one)
    motion = Motion(a, b, still, np.array([1.0, 0.0, 0.0]), np.asarray(0.5), np.asarray(0.0))
    scene = Scene(IMPACT, Disc([-1.0, 0.0], 1.0), Disc([1.0, 0.0], 1.0), "by hand", motion=motion)
    answer = told(pymunk, scene)
    np.testing.assert_allclose(answer["velocity_a"], [-0.5, 1.0, 0.0], rtol=0, atol=1e-11)
    np.testing.assert_allclose(answer["velocity_b"], [1.5, 0.0, 0.0], rtol=0, atol=1e-11)
    spinning = replace(motion, a=replace(a, angular_velocity=np.array([1.0, 0.0, 0.0])))
    with pytest.raises(ValueError, match="move in the plane"):
        Scene.from_json(replace(scene, motion=spinning).to_json())
    assert Scene.from_json(scene.to_json()).id == scene.id
