"""The survey of mass properties: its truth against quadrature, its judge against wrong engines, its engines."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import pytest

from oracles.isolation.children import Said
from oracles.ledger import Ledger
from oracles.surveys import load_survey
from oracles.surveys.judging import judged
from oracles.surveys.mass import Mass
from oracles.surveys.mass_engines import Bullet, Reference, Trimesh
from oracles.surveys.mass_truth import truth
from oracles.surveys.survey import Case, SurveyEngine
from refimpl import AABB, Box, Capsule, Composite, ConvexPolyhedron, HalfSpace, Polyhedron, Sphere
from tests.solids import L_SHAPE, prism

TURN = [0.3, -0.2, 0.5, 0.7]


@pytest.fixture(scope="module")
def cases() -> list[Case]:
    return list(Mass().cases(0))


def test_every_type_and_regime_is_asked(cases: list[Case]) -> None:
    survey = load_survey("mass")
    assert {(c.question, c.regime) for c in cases} == {(q, r) for q in survey.questions for r in survey.regimes}
    assert [c.to_json() for c in survey.cases(0)] == [c.to_json() for c in cases]
    for case in cases:
        survey.check(Case.from_json(case.to_json()))


def test_truth_of_a_capsule_is_that_of_quadrature() -> None:
    """Discs of squared radius along the axis, in 40 digits, not aligned with any coordinate."""
    with mpmath.workdps(40):
        p, q, radius = np.array([1.0, 2.0, 3.0]), np.array([2.0, 4.0, 5.0]), mpmath.mpf(0.5)
        half = mpmath.mpf(3) / 2
        square = lambda z: radius**2 - max(abs(z) - half, 0) ** 2  # noqa: E731
        knots = [-half - radius, -half, half, half + radius]
        volume = mpmath.quad(lambda z: mpmath.pi * square(z), knots)
        along = mpmath.quad(lambda z: mpmath.pi * square(z) ** 2 / 2, knots)
        found = truth(Capsule(p, q, 0.5))
        assert abs(number(found.volume) / volume - 1) < mpmath.mpf(10) ** -35
        axis = [Fraction(1, 3), Fraction(2, 3), Fraction(2, 3)]
        about = sum(axis[i] * found.inertia[i, j] * axis[j] for i in range(3) for j in range(3))
        assert abs(number(about) / along - 1) < mpmath.mpf(10) ** -35


def number(x: Fraction) -> Any:
    return mpmath.mpf(x.numerator) / x.denominator


def test_truth_of_polytopes_is_that_of_the_formulas_of_a_box() -> None:
    """One box as AABB, as hull of corners, by planes and as mesh: the same fractions, and those of a textbook."""
    low, high = [Fraction(-1), Fraction(1, 4), Fraction(3)], [Fraction(1), Fraction(3), Fraction(7, 2)]
    box = AABB([float(x) for x in low], [float(x) for x in high])
    corners = [[float((low, high)[i >> k & 1][k]) for k in range(3)] for i in range(8)]
    hull = ConvexPolyhedron.from_vertices(corners)
    planes = ConvexPolyhedron(
        np.column_stack([[*np.eye(3), *-np.eye(3)], [-float(x) for x in high] + [float(x) for x in low]])
    )
    sides = [b - a for a, b in zip(low, high, strict=True)]
    volume = math.prod(sides)
    for shape in (box, hull, planes):
        found = truth(shape)
        assert found.volume == volume
        assert list(found.barycentre) == [(a + b) / 2 for a, b in zip(low, high, strict=True)]
        assert found.inertia[0, 0] == volume * (sides[1] ** 2 + sides[2] ** 2) / 12
        assert found.inertia[0, 1] == 0
    both = Composite([box, Box([10, 0, 0], [1, 1, 1], [0, 0, 0, 1])])
    assert truth(both).volume == volume + 8


def test_truth_of_a_mesh_and_what_has_none() -> None:
    assert truth(Polyhedron(*prism(L_SHAPE))).volume == truth(Polyhedron(*prism(L_SHAPE), [5, 5, 5], TURN)).volume
    for shape in (HalfSpace([0, 0, 1], 0), Capsule([0, 0, 0], [1, 0, 0], 0), AABB([0, 0, 0], [1, 1, 0])):
        with pytest.raises(ValueError, match=r"no exact mass|no volume"):
            truth(shape)


def asked(
    engine: SurveyEngine, cases: list[Case], change: Callable[[Any], Any] = lambda said: said, name: str = "planted"
) -> Any:
    def asker(some: Any) -> list[Said]:
        return [Said(change(engine.answer(case))) for case in some]

    return judged(Mass(), name, engine, cases, asker, Ledger.load().name_of)


def test_the_reference_is_right(cases: list[Case]) -> None:
    for count in asked(Reference(), cases):
        assert count.right == count.asked > 0, count
        assert count.worst < 1e-9


class Wrong(Reference):
    """The reference, spoilt."""


SIGNS = [[1, -1, 1], [-1, 1, 1], [1, 1, 1]]
SPOILT: dict[str, Callable[[Any], Any]] = {
    "volume": lambda said: said | {"volume": said["volume"] * (1 + 1e-9)},
    "barycentre": lambda said: said | {"barycentre": [said["barycentre"][0] + 1e-6, *said["barycentre"][1:]]},
    "inertia": lambda said: said | {"inertia": (np.array(said["inertia"]) * SIGNS).tolist()},
    "moments": lambda said: said | {"moments": [x / 12 for x in said["moments"]]},
    "infinite": lambda said: said | {"volume": math.inf},
}  # fmt: skip


@pytest.mark.parametrize("what", SPOILT)
def test_wrong_answers_are_caught_with_a_witness(what: str, cases: list[Case]) -> None:
    some = [case for case in cases if case.question in ("Box", "Polyhedron") and case.regime == "plain"]
    counts = asked(Wrong(), some, SPOILT[what])
    assert all(count.wrong == count.asked for count in counts)
    (witness,) = counts[0].witnesses
    assert witness.judgement is not None
    assert (what if what != "infinite" else "volume") in witness.judgement.words
    assert set(witness.judgement.proof) == {"volume", "barycentre", "inertia"}
    assert eval(Mass().written(witness.case), vars(__import__("refimpl"))) is not None  # our own words


@pytest.mark.parametrize("answer", [None, {}, {"volume": [1, 2]}, {"volume": "x"}, {"inertia": [1]}, 7])
def test_nonsense_is_no_answer(answer: Any, cases: list[Case]) -> None:
    count = asked(Wrong(), cases[:1], lambda _: answer)[0]
    assert count.lost == 1


@pytest.mark.parametrize(
    "data",
    [{}, {"solid": {"type": "Sphere", "numbers": [0, 0, 0, -1]}, "thin": 1, "away": 0, "size": 1},
     {"solid": {"type": "Sphere", "numbers": [0] * 5000}, "thin": 1, "away": 0, "size": 1},
     {"solid": {"type": "Sphere", "numbers": [0, 0, 0, 1]}, "thin": math.nan, "away": 0, "size": 1},
     {"solid": {"type": "HalfSpace", "numbers": [0, 0, 1, 1]}, "thin": 1, "away": 0, "size": 1}],
)  # fmt: skip
def test_cases_from_files_are_checked(data: Any) -> None:
    with pytest.raises((ValueError, TypeError, LookupError)):
        Mass().check(Case("Sphere", "plain", data))


def test_trimesh_is_right_near_the_origin_and_wrong_far_from_it(cases: list[Case]) -> None:
    pytest.importorskip("trimesh")
    some = [case for case in cases if case.question in ("Polyhedron", "Sphere") and case.regime in ("plain", "far")]
    counts = {(count.question, count.regime): count for count in asked(Trimesh(), some, name="trimesh")}
    assert counts["Polyhedron", "plain"].right == counts["Sphere", "plain"].right == 2
    far = counts["Polyhedron", "far"]
    assert far.known == far.asked
    assert far.worst > 0.01
    assert far.explained == {"moments-about-the-origin": far.asked}


def test_bullet_has_the_formulas_of_boxes_and_the_boxes_of_hulls(cases: list[Case]) -> None:
    pytest.importorskip("pybullet")
    counts = {(count.question, count.regime): count for count in asked(Bullet(), cases, name="bullet")}
    for question in ("Sphere", "Box", "Cylinder"):
        for regime in Mass.regimes:
            assert counts[question, regime].right == 2, (question, regime)
    assert counts["ConvexPolyhedron", "plain"].known == 2
    assert counts["ConvexPolyhedron", "plain"].worst > 0.1
    assert counts["Capsule", "plain"].known == 2


def test_the_sphere_of_a_witness_stays_a_sphere() -> None:
    case = next(c for c in Mass().cases(1) if c.question == "Sphere")
    simpler = list(Mass().simpler(case))
    assert simpler
    for other in simpler:
        assert isinstance(other.data["solid"]["numbers"], list)
        assert other.question == Sphere.__name__
