"""The survey of bounding volumes: engines that are wrong by a little are caught, with a proof that is another's."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from oracles.isolation.children import Said
from oracles.ledger import Ledger
from oracles.surveys import load_survey
from oracles.surveys.bounding import Bounding, dimension, extent, points_in
from oracles.surveys.bounding_engines import Fcl, Miniball, Reference, Trimesh
from oracles.surveys.bounding_shapes import Ground, ball_of, barrel_of, brick_of
from oracles.surveys.judging import Judge, judged
from oracles.surveys.survey import Case

SURVEY = Bounding()
BEST = Reference()
CUBE = [[float(x), float(y), float(z)] for x in (0, 2) for y in (0, 2) for z in (0, 2)]


def asking(engine):
    def ask(cases: Sequence[Case]) -> list[Said]:
        found = []
        for case in cases:
            try:
                found.append(Said(engine.answer(case)))
            except Exception as error:  # whatever a library raises
                found.append(Said(lost=type(error).__name__))
        return found

    return ask


def counted(engine, *questions: str, regimes=("random", "cuboid")) -> dict[str, Any]:
    cases = [c for c in SURVEY.cases(0) if c.question in questions and c.regime in regimes]
    return {c.question + "/" + c.regime: c for c in judged(SURVEY, "planted", engine, cases, asking(engine))}


class Lowered(Reference):
    """Wrong: radii and extents lack 10⁻¹² of their length."""

    def answer(self, case: Case) -> Any:
        answer = super().answer(case)
        for name in ("radius", "half_extents"):
            if name in answer:
                answer[name] = (np.array(answer[name]) * (1 - 1e-12)).tolist()
        return answer


class Padded(Reference):
    """Wrong: a thousandth is added."""

    def answers(self, question: str) -> bool:
        return True

    def answer(self, case: Case) -> Any:
        answer = super().answer(case)
        for name in ("radius", "half_extents"):
            if name in answer:
                answer[name] = (np.array(answer[name]) * 1.001).tolist()
        return answer


class CornerLost(Reference):
    """Wrong: the hull lacks its last corner."""

    def answer(self, case: Case) -> Any:
        return {"vertices": super().answer(case)["vertices"][:-1]}


def test_the_reference_is_right_and_what_lacks_a_bit_is_not():
    questions = ("sphere-contains", "box-contains", "sphere-size", "hull", "centre")
    for count in counted(BEST, *questions, regimes=("random", "doubled", "one point")).values():
        assert count.right == count.asked > 0, (count.question, count.regime)
    for count in counted(Lowered(), "sphere-contains", "box-contains").values():
        assert count.wrong == count.asked, (count.question, count.regime)
        assert count.worst < 1e-10


def test_what_is_larger_than_it_could_be_is_caught():
    for count in counted(Padded(), "sphere-size", "box-size", regimes=("cuboid",)).values():
        assert count.wrong == count.asked
        expected = {"sphere-size": 1.001, "box-size": 1.001**3}[count.question] - 1
        assert count.worst == pytest.approx(expected, rel=1e-6)


def test_cylinders_that_lack_a_bit_or_are_padded():
    """Asked once each, without looking for smaller cases: a search of an axis takes time."""
    inside, small = (Case(f"cylinder-{aspect}", "cuboid", {"points": CUBE}) for aspect in ("contains", "size"))
    right = BEST.answer(inside)
    assert SURVEY.judge(inside, right).amount == 0
    assert 0 < SURVEY.judge(inside, {**right, "radius": right["radius"] * (1 - 1e-12)}).amount < 1e-10
    padded = {**right, "radius": right["radius"] * 1.001}
    assert SURVEY.judge(small, padded).amount == pytest.approx(1.001**2 - 1, rel=1e-6)


def test_a_corner_that_is_lost_is_caught():
    for count in counted(CornerLost(), "hull", regimes=("random", "coplanar")).values():
        assert count.wrong == count.asked
        assert all(len(witness.case.data["points"]) <= 3 for witness in count.witnesses)


def test_witnesses_are_small_and_say_what_is_proven():
    counts = counted(Lowered(), "sphere-contains")
    (witness,) = [witness for count in counts.values() for witness in count.witnesses]
    assert len(witness.case.data["points"]) <= 2
    assert "outside of the sphere" in witness.judgement.words
    SURVEY.check(witness.case)
    again = Case.from_json(witness.case.to_json())
    assert SURVEY.judge(again, witness.said.answer).amount == witness.judgement.amount


def test_distances_from_volumes():
    cube = np.array(CUBE)
    ball = ball_of({"center": [1, 1, 1], "radius": 1.0})
    assert ball.beyond(cube)[0] == pytest.approx(np.sqrt(3) - 1, rel=1e-15)
    brick = brick_of({"to_origin": np.eye(4)[:3].tolist(), "extents": [4, 4, 2]})
    assert brick.beyond(cube) == (1.0, 1)
    assert brick.volume() == 32
    turned = brick_of({"center": [1, 1, 1], "half_extents": [1, 1, 1], "rotation": [0, 0, 0, 2]})
    assert turned.beyond(cube)[0] == 0
    barrel = barrel_of({"center": [1, 1, 1], "axis": [0, 0, 1], "height": 1.0, "radius": 1.0})
    assert barrel.beyond(cube)[0] == pytest.approx(0.5)
    assert barrel.volume() == pytest.approx(np.pi)
    assert Ground(cube).beyond_hull(cube[:7])[0] == pytest.approx(2 / np.sqrt(3), rel=1e-12)
    assert Ground(cube).beyond_hull(cube)[0] == 0
    up = np.nextafter(2.0, 3)
    assert 0 < Ground(np.array([[up, up, up]])).beyond_hull(cube)[0] < 1e-15


def test_nonsense_is_lost_not_judged():
    case = Case("sphere-contains", "random", {"points": CUBE})
    for answer in ({}, {"center": [0, 0], "radius": 1}, {"center": [0, 0, np.nan], "radius": 1},
                   {"center": [0, 0, 0], "radius": -1.0}, {"center": [0, 0, 0], "radius": "1"}, None):  # fmt: skip
        with pytest.raises((ValueError, TypeError, LookupError)):
            SURVEY.judge(case, answer)
    for data in ({}, {"points": []}, {"points": [[1, 2]]}, {"points": [[np.inf, 0, 0]]}, {"points": CUBE * 100}):
        with pytest.raises((ValueError, TypeError, LookupError)):
            SURVEY.check(Case("hull", "random", data))
    with pytest.raises(ValueError, match="torus"):
        SURVEY.check(Case("torus", "random", {"points": CUBE}))


def test_simpler_clouds_can_still_be_asked():
    for case in SURVEY.cases(0)[::17]:
        for simple in list(SURVEY.simpler(case))[:8]:
            SURVEY.check(simple)
            assert len(repr(simple.data)) < len(repr(case.data))
            if case.question == "box-size":
                assert dimension(points_in(simple.data)) == 3


def test_cases_are_those_of_the_seed():
    assert [c.to_json() for c in SURVEY.cases(3)] == [c.to_json() for c in SURVEY.cases(3)]
    assert SURVEY.cases(3)[0].data != SURVEY.cases(4)[0].data
    assert load_survey("bounding").name == "bounding"
    assert extent(np.zeros((1, 3))) == 1.0


def test_trimesh_assumes_a_face_on_the_box():
    """Around the regular tetrahedron its box is twice as large as the cube whose diagonals are the edges."""
    pytest.importorskip("trimesh")
    points = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]]
    case = Case("box-size", "tetrahedron", {"points": points})
    said = SURVEY.judge(case, Trimesh().answer(case))
    assert said.amount > 0.9
    least = brick_of(said.proof)
    assert least.volume() == pytest.approx(8.0, rel=1e-9)
    assert least.beyond(np.array(points))[0] == 0
    judge = Judge(SURVEY, "trimesh", Trimesh(), Ledger.load().name_of)
    assert judge.shown(case, Said(Trimesh().answer(case))).entry == "box-lies-on-a-face"


def test_miniball_and_fcl_answer():
    pytest.importorskip("miniball")
    pytest.importorskip("fcl")
    ball = Case("sphere-size", "random", {"points": CUBE[:5]})
    assert SURVEY.judge(ball, Miniball().answer(ball)).amount < 1e-12
    centre = Case("centre", "random", {"points": CUBE})
    assert SURVEY.judge(centre, Fcl().answer(centre)).amount == 0
    off = SURVEY.judge(centre, {"center": [1, 1, 1 + 2**-40]})
    assert off.amount == float(Fraction(1, 2**41))
