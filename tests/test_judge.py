"""The judge: every kind of verdict, from the proven interval and the answer's own properties."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import oracles.audit
import oracles.reference
from oracles import claims
from oracles.answers import reference_answers, take
from oracles.audit import audit
from oracles.claimed_shapes import is_fragile
from oracles.engine import COLUMNS, WIDTH, Answers, Bound, Convention, Effective, Kind, Status, Tolerance
from oracles.judge import Judge
from oracles.outcome import Kind as Verdicts
from oracles.outcome import Severity
from oracles.reference import SEARCH_ERROR, UNIONS, error_of, is_quick, proven, signed
from oracles.rules import Rules
from oracles.scene import BOOLEAN, CONTACTS, DISTANCE, MOVING, RAYCAST, Cell, Scene, cells
from refimpl import Box, Capsule, Composite, Ellipsoid, HalfSpace, Point, Proxy, Ray, Sphere, distance, raycast
from refimpl.linear import Array
from refimpl.pairs import TABLE
from refimpl.proof import certify, check
from tests.conftest import name_of, regimes_in_turn, scenes_of
from tests.wrong_engines import Honest


class Exact(Honest):
    """An engine on paper: its answers are given by the tests."""

    def __init__(self, absolute: float = 0.0, relative: float = 1e-12) -> None:
        self.bound = Bound(absolute, relative)

    def tolerance(self, query: str, A: Kind, B: Kind) -> Tolerance:
        return Tolerance(self.bound, self.bound, self.bound, "for this test")


class Grown(Exact):
    """Declares that it grows each shape by a hundredth."""

    def effective(self, query: str, A: Kind, rows_a: Array, B: Kind, rows_b: Array) -> tuple[Effective, Effective]:
        margin = np.full(len(rows_a), 0.01)
        return Effective(A, rows_a, margin), Effective(B, rows_b, margin)


class BlindInside(Exact):
    def conventions(self, query: str, A: Kind, B: Kind) -> Mapping[Convention, str]:
        return {Convention.NO_HIT_FROM_INSIDE: "by design"}


class AnyDepth(Exact):
    def conventions(self, query: str, A: Kind, B: Kind) -> Mapping[Convention, str]:
        return {Convention.DEPTH_OF_ITS_NORMAL: "by design"}


class NoDepth(Exact):
    def conventions(self, query: str, A: Kind, B: Kind) -> Mapping[Convention, str]:
        return {Convention.NO_DEPTH: "by design"}


class OneTriangle(Exact):
    def conventions(self, query: str, A: Kind, B: Kind) -> Mapping[Convention, str]:
        return {Convention.OF_ONE_TRIANGLE: "by design"}


def answers_of(scene: Scene, **changes: Any) -> Answers:
    """The reference's own answer, with some columns changed."""
    right = reference_answers(scene.query, scene.a[None], scene.b[None])
    table = np.full((1, WIDTH), np.nan)
    for name, columns in COLUMNS.items():
        table[0, columns] = np.ravel(changes.get(name, getattr(right, name)[0]))
    return Answers.from_table(np.zeros(1, dtype=np.int8), table, {})


def verdict(engine: Honest, scene: Scene, **changes: Any) -> Any:
    """Convict, after checking that the float screening agrees wherever it is certain."""
    answers, judge = answers_of(scene, **changes), Judge(engine)
    screening = judge.screen(scene.cell, scene.a[None], scene.b[None], answers)
    found = judge.convict(scene, answers)
    if screening.certain[0] and screening.kind[0] is Verdicts.WRONG:
        assert found.kind is Verdicts.WRONG
        assert found.symptom == screening.symptom[0]
    if screening.kind[0] is Verdicts.AGREES:
        assert found.kind is Verdicts.AGREES
    return found


APART = Scene(DISTANCE, Sphere([0, 0, 0], 1), Box([4, 0, 0], [1, 1, 1], [0, 0, 0, 1]), "generic")
OVERLAPPING = Scene(CONTACTS, Sphere([0, 0, 0], 1), Box([1.5, 0, 0], [1, 1, 1], [0, 0, 0, 1]), "generic")
BEAM = Scene(RAYCAST, Ray([-5, 0, 0], [2, 0, 0]), Sphere([0, 0, 0], 1), "generic")
INSIDE = Scene(RAYCAST, Ray([0.5, 0, 0], [2, 0, 0]), Sphere([0, 0, 0], 1), "generic")
CASES: list[tuple[Scene, dict[str, Any], str, float]] = [
    (APART, {"distance": 2.001}, claims.LONG, 1e-3),
    (APART, {"distance": 1.5}, claims.SHORT, 0.5),
    (APART, {"distance": -math.inf}, claims.SHORT, math.inf),
    (APART, {"normal": [-1, 0, 0]}, claims.OVERSHOT, 4.0),
    (APART, {"normal": [0.6, 0.8, 0]}, claims.OVERSHOT, math.sqrt(3.6) - 1),
    (APART, {"on_a": [1.25, 0, 0]}, claims.OFF_SHAPE, 0.25),
    (APART, {"on_b": [3.25, 0, 0], "on_a": [0.9, 0, 0]}, claims.APART, 0.35),
    (APART, {"on_a": [0, 1, 0]}, claims.APART, math.sqrt(10) - 2),
    (OVERLAPPING, {"hit": 0.0}, claims.MISSED, 0.5),
    (OVERLAPPING, {"distance": -0.25}, claims.LONG, 0.25),
    (OVERLAPPING, {"distance": -0.75}, claims.SHORT, 0.25),
    (OVERLAPPING, {"normal": [-1, 0, 0]}, claims.STUCK, 1.0),
    (OVERLAPPING, {"normal": [0, 1, 0]}, claims.STUCK, 0.5),
    (OVERLAPPING, {"point": [3, 0, 0]}, claims.OUTSIDE, 1.5),
    (BEAM, {"normal": [-7, 0, 0]}, claims.LENGTHY, 6.0),
    (BEAM, {"normal": [0, 0, 0]}, claims.BRIEF, 1.0),
    (BEAM, {"hit": 0.0, "t": math.inf}, claims.RAY_MISSED, 1.0),
    (BEAM, {"t": 1.5}, claims.RAY_OFF, 1.0),
    (BEAM, {"t": 2.25}, claims.RAY_LATE, 0.5),
    (BEAM, {"normal": [1, 0, 0]}, claims.TILTED, 2.0),
    (BEAM, {"point": [-1.5, 0, 0]}, claims.RAY_POINT, 0.5),
    (INSIDE, {"hit": 0.0, "t": math.inf}, claims.RAY_MISSED, 0.5),
    (INSIDE, {"t": 0.25}, claims.RAY_LATE, 0.5),
]


@pytest.mark.parametrize(("scene", "change", "symptom", "amount"), CASES)
def test_each_wrong_property_is_named_and_measured(
    scene: Scene, change: dict[str, Any], symptom: str, amount: float
) -> None:
    assert verdict(Exact(), scene).kind is Verdicts.AGREES
    found = verdict(Exact(), scene, **change)
    assert (found.kind, found.symptom) == (Verdicts.WRONG, symptom)
    assert found.amount == pytest.approx(amount, rel=1e-9)
    assert symptom in found.claim
    shown = found.proof_scene
    lower, upper = check(found.certificate, shown.a, shown.b)
    assert found.lower <= lower <= upper <= found.upper
    generous = Exact(absolute=min(amount * 1.001, 1e300))
    of_length = symptom in (claims.LENGTHY, claims.BRIEF)  # which no engine has a tolerance of its own for
    assert math.isinf(amount) or (verdict(generous, scene, **change).symptom == symptom) is of_length


def test_false_contact_and_false_ray() -> None:
    apart = Scene(BOOLEAN, APART.a, APART.b, "generic")
    found = verdict(Exact(), apart, hit=1.0)
    assert (found.symptom, found.amount, found.severity) == (claims.FALSE, 2.0, Severity.BOOLEAN)
    miss = Scene(RAYCAST, Ray([-5, 3, 0], [2, 0, 0]), Sphere([0, 0, 0], 1), "generic")
    found = verdict(Exact(), miss, hit=1.0, t=2.0)
    assert (found.symptom, found.severity) == (claims.RAY_FALSE, Severity.BOOLEAN)
    assert found.amount == pytest.approx(2.0)


def test_an_effective_shape_makes_a_convention() -> None:
    shorter = {"distance": 1.98, "on_a": [1.01, 0, 0], "on_b": [2.99, 0, 0]}
    assert verdict(Exact(), APART, **shorter).kind is Verdicts.WRONG
    assert verdict(Grown(), APART, **shorter).kind is Verdicts.CONVENTION
    assert verdict(Grown(), APART).kind is Verdicts.AGREES
    found = verdict(Grown(), APART, distance=1.9)
    assert found.kind is Verdicts.WRONG
    assert found.amount == pytest.approx(0.08)


def test_conventions_excuse_what_they_name_and_no_more() -> None:
    missed = {"hit": 0.0, "t": math.inf}
    assert verdict(BlindInside(), INSIDE, **missed).kind is Verdicts.CONVENTION
    assert verdict(BlindInside(), BEAM, **missed).kind is Verdicts.WRONG
    sideways = {"distance": -math.sqrt(3), "normal": [0, 1, 0], "on_a": [np.nan] * 3, "on_b": [np.nan] * 3}
    corner = Scene(CONTACTS, Sphere([0, 0, 0], 1), Sphere([1, 0, 0], 1), "generic")
    assert verdict(Exact(), corner, **sideways).kind is Verdicts.WRONG
    assert verdict(AnyDepth(), corner, **sideways).kind is Verdicts.CONVENTION
    assert verdict(AnyDepth(), corner, **(sideways | {"distance": -1.5})).symptom == claims.STUCK


def test_what_rounding_could_excuse_is_undecided() -> None:
    """The moved box is rounded, so an error of just the tolerance is neither proven nor refuted."""
    kinds = [verdict(Exact(bound, 0.0), OVERLAPPING, distance=-0.75).kind for bound in (0.2499, 0.25, 0.2501)]
    assert kinds == [Verdicts.WRONG, Verdicts.UNDECIDED, Verdicts.AGREES]


HUGE = 1.7976931348623157e308
ENDLESS = Scene(CONTACTS, HalfSpace([0, 0, 1], 0), HalfSpace([0, 1, -1], 2), "generic")


@pytest.mark.parametrize(
    ("scene", "change"),
    [
        (APART, {"distance": HUGE}),
        (APART, {"on_a": [HUGE, 0, 0]}),
        (APART, {"on_b": [math.inf, 0, 0]}),
        (APART, {"normal": [1e300, 0, 0]}),
        (BEAM, {"t": HUGE}),
        (BEAM, {"t": -1.0}),
        (BEAM, {"normal": [0, math.inf, 0]}),
        (OVERLAPPING, {"distance": math.nan}),
    ],
)
def test_numbers_that_no_scene_has_are_no_answers(scene: Scene, change: dict[str, Any]) -> None:
    found = verdict(Exact(), scene, **change)
    assert (found.kind, found.symptom) == (Verdicts.WRONG, claims.NOT_A_NUMBER)
    assert found.lower <= found.upper


def test_an_endless_overlap_owes_neither_normal_nor_witnesses() -> None:
    assert verdict(Exact(), ENDLESS).kind is Verdicts.AGREES


def test_wrong_on_both_shapes_in_different_ways() -> None:
    between = {"distance": 1.99, "on_a": [1.005, 0, 0], "on_b": [2.995, 0, 0]}
    found = verdict(Grown(), APART, **between)
    assert (found.kind, found.symptom) == (Verdicts.WRONG, claims.NEITHER)
    assert found.amount == pytest.approx(0.01)
    assert "effectively uses" in found.claim


@pytest.mark.parametrize("status", [Status.ERROR, Status.CRASHED, Status.TIMED_OUT])
def test_a_lost_answer_keeps_its_text_and_the_truth(status: Status) -> None:
    right = answers_of(APART)
    lost = Answers(
        status=np.array([status], dtype=np.int8),
        **{n: getattr(right, n) for n in COLUMNS},
        errors={0: "the last words"},
    )
    found = Judge(Exact()).convict(APART, lost)
    assert found.kind is (Verdicts.TIMED_OUT if status is Status.TIMED_OUT else Verdicts.CRASHED)
    assert "the last words" in found.claim
    assert found.lower == found.upper == 2.0
    assert found.severity is Severity.LOST


@pytest.mark.parametrize("pair", TABLE, ids=name_of)
def test_the_reference_agrees_with_itself_in_every_regime(pair: tuple[type[Proxy], type[Proxy]]) -> None:
    queries = [cell for cell in cells() if (cell.type_a, cell.type_b) == pair and cell.query not in MOVING]
    for regime in regimes_in_turn(pair):
        a, b = scenes_of(pair, regime, 24 if is_quick(*pair) else 3)
        for cell in queries:
            agrees_with_itself(cell, a, b, regime)


def agrees_with_itself(cell: Cell, a: Proxy, b: Proxy, regime: str) -> None:
    of_union = isinstance(a, UNIONS) or isinstance(b, UNIONS)  # whose ways out are searched
    engine = Exact(absolute=0.0, relative=10 * (SEARCH_ERROR if of_union else error_of(a, b)))
    answers = reference_answers(cell.query, a, b)
    if cell.query == CONTACTS:
        keep = np.flatnonzero(np.isfinite(answers.distance))
        a, b, answers = a[keep], b[keep], take(answers, keep)
    if len(a):
        screening = Judge(engine).screen(cell, a, b, answers)
        for i, kind in enumerate(screening.kind):
            case = regime, screening.symptom[i], screening.amount[i]
            if kind is Verdicts.WRONG:
                assert not screening.certain[i], (*case, a[i], b[i])
                scene = Scene(cell.query, a[i], b[i], regime)
                right = {Verdicts.AGREES}
                if regime in ("sliver", "combined") and is_fragile(a) and is_fragile(b):
                    # rounding a move turns either of them
                    right.add(Verdicts.UNDECIDED)
                assert Judge(engine).convict(scene, take(answers, [i])).kind in right, (*case, a[i], b[i])
                continue
            assert kind is Verdicts.AGREES, (*case, a[i], b[i])


@pytest.mark.parametrize("pair", TABLE, ids=name_of)
def test_the_audit_passes_what_is_right(pair: tuple[type, type]) -> None:
    many = 2 if is_quick(*pair) else 1
    for regime in regimes_in_turn(pair):
        a, b = scenes_of(pair, regime, many)
        for i in range(many):
            found = audit(a[i], b[i])
            assert found.kind is Verdicts.AGREES, f"{found.claim} {a[i]} {b[i]}"


def test_the_normal_of_a_rays_hit_on_a_capsules_side_does_not_tilt_where_rounding_takes_it_for_a_cap() -> None:
    direction = np.array([-0.642518613028296, 0.3742354851224078, 1.3027346750537467])
    ray = Ray([0.7460430045706195, 2.006799740432945, -3.662809664332766], direction)
    p = [-0.42411258561085363, 2.4434206196226516, -1.7746629267557683]
    q = [-0.852458327629718, 2.6929109430375906, -0.906173143386604]
    capsule = Capsule(p, q, 0.25)
    normal = raycast(ray, capsule).normal
    assert abs(normal @ direction) <= 1e-15  # the ray runs along the axis, and grazes
    assert audit(ray, capsule).kind is Verdicts.AGREES


@pytest.mark.parametrize("size", [1e-6, 1.0, 1e9])
def test_a_normals_length_is_held_to_the_same_whatever_the_size(size: float) -> None:
    scene = Scene(DISTANCE, Sphere(np.zeros(3), size), Sphere([4 * size, 0.0, 0.0], size), "test")
    engine = Exact(relative=1e-2)
    assert verdict(engine, scene, normal=[1 + 9e-7, 0.0, 0.0]).kind is Verdicts.AGREES
    for length, symptom in ((1.001, claims.LENGTHY), (0.999, claims.BRIEF), (1.5, claims.LENGTHY), (0.0, claims.BRIEF)):
        found = verdict(engine, scene, normal=[length, 0.0, 0.0])
        assert (found.kind, found.symptom) == (Verdicts.WRONG, symptom)


def test_the_reference_is_asked_and_proven_once_for_each_pair(monkeypatch: pytest.MonkeyPatch) -> None:
    a = Ellipsoid(np.arange(9.0).reshape(3, 3), [0.3, 0.4, 0.5])
    b = Sphere([10.0, 0.25, 0.125], np.ones(3))
    wanted = np.array([True, False, True])
    once = signed(a, b, wanted)
    certificate = proven(a[0], b[0])[0]
    monkeypatch.setattr(oracles.reference, "distance", None)
    monkeypatch.setattr(oracles.reference, "certify", None)
    again = signed(a[::-1], b[::-1], wanted)
    for one, other in zip(once, again, strict=True):
        np.testing.assert_array_equal(one, other[::-1])
        assert one[1] == 0.0
    assert proven(a[0], b[0])[0] is certificate
    with pytest.raises(TypeError):
        signed(a, b, ~wanted)


def test_balls_are_asked_about_by_their_formula() -> None:
    rng = np.random.default_rng(2)
    for size in (1e-200, 1.0, 1e140):
        p, c, r = size * rng.normal(size=(50, 3)), size * rng.normal(size=(50, 3)), size * rng.uniform(0, 2, 50)
        wanted = rng.random(50) < 0.8
        low, high = signed(Point(p), Capsule(c, c, r), wanted)
        assert np.array_equal(low, high)
        assert np.all(low[~wanted] == 0)
        exact = distance(Point(p), Capsule(c, c, r)).distance
        assert np.all(np.abs(low - exact)[wanted] <= 1e-15 * 10 * size)


def test_shapes_that_an_engine_takes_as_they_are_stay_the_same() -> None:
    scene = OVERLAPPING
    answers = answers_of(scene)
    for engine, same in ((Exact(), True), (Grown(), False)):
        rules, b = Rules(engine), scene.b[None]
        rows = rules.effectively(scene.cell, rules.questioned(scene.cell, scene.a[None], b, answers))
        assert (rows.b is b) == same


TWINS = Composite([Sphere([-1, 0, 0], 1), Sphere([1, 0, 0], 1)])
BETWEEN = Scene(CONTACTS, Sphere([0, 0, 0], 0.25), TWINS, "generic")
"""A ball between two: each overlaps it by 0.25, and the way out, up or down, is longer."""


def test_the_depth_of_unions_is_judged_against_an_interval() -> None:
    truth = audit(BETWEEN.a, BETWEEN.b)
    assert truth.kind is Verdicts.AGREES
    assert truth.upper == pytest.approx(-0.25, abs=1e-9)
    assert truth.lower == pytest.approx(-0.75, abs=0.02)
    nothing = {"on_a": [np.nan] * 3, "on_b": [np.nan] * 3}
    for depth in (0.25, -truth.lower):
        assert verdict(Exact(relative=1e-9), BETWEEN, distance=-depth, **nothing).kind is Verdicts.AGREES
    query = Scene(DISTANCE, BETWEEN.a, BETWEEN.b, "generic")
    unsaid = nothing | {"normal": [np.nan] * 3}
    assert verdict(Exact(relative=1e-9), query, distance=-0.4, **unsaid).kind is Verdicts.AGREES
    found = verdict(Exact(), BETWEEN, distance=-0.2, **nothing)
    assert (found.kind, found.symptom) == (Verdicts.WRONG, claims.LONG)
    assert found.amount == pytest.approx(0.05, abs=1e-9)
    found = verdict(Exact(), BETWEEN, distance=-1.0, **nothing)
    assert (found.kind, found.symptom) == (Verdicts.WRONG, claims.SHORT)
    apart = Scene(DISTANCE, Sphere([0, 0, 4], 0.25), TWINS, "generic")
    assert verdict(Exact(), apart, distance=2.0).symptom == claims.SHORT


BOXES = Composite([Box([side, 0, 0], [1, 1, 1], [0, 0, 0, 1]) for side in (-1, 1)])
BETWEEN_BOXES = Scene(CONTACTS, Box([0, 0, 0], [0.25, 0.25, 0.25], [0, 0, 0, 1]), BOXES, "generic")


def test_who_tells_the_depth_of_the_deepest_parts_is_not_wrong_where_the_way_out_is_known() -> None:
    """Of polytopes the reference knows that no way is shorter; a certificate proves the depth of two parts."""
    nothing = {"on_a": [np.nan] * 3, "on_b": [np.nan] * 3}
    assert answers_of(BETWEEN_BOXES).distance == -1.25
    parts = {"distance": -0.25, "normal": [1.0, 0, 0], **nothing}
    assert verdict(Exact(relative=1e-9), BETWEEN_BOXES, **parts).kind is Verdicts.AGREES
    found = verdict(Exact(relative=1e-9), BETWEEN_BOXES, **parts | {"distance": -0.2})
    assert (found.kind, found.symptom) == (Verdicts.WRONG, claims.LONG)


def test_the_way_out_of_unions_must_free_and_touch() -> None:
    """Deeper than the deepest pair of pieces, it is a way out; as deep as that, the others may overlap still."""
    way = audit(BETWEEN.a, BETWEEN.b)
    depth, normal = -way.lower, answers_of(BETWEEN).normal[0]
    nothing = {"on_a": [np.nan] * 3, "on_b": [np.nan] * 3}
    assert verdict(AnyDepth(relative=1e-9), BETWEEN, distance=-0.4, **nothing).kind is Verdicts.AGREES
    for wrong in ({"normal": [1.0, 0, 0]}, {"distance": -0.4, **nothing}):
        found = verdict(Exact(relative=1e-9), BETWEEN, **wrong)
        assert (found.kind, found.symptom) == (Verdicts.WRONG, claims.STUCK)
    assert verdict(Exact(relative=1e-9), BETWEEN, normal=normal).kind is Verdicts.AGREES
    piece = {"distance": -0.25, "normal": [1.0, 0, 0]}
    assert verdict(Exact(relative=1e-9), BETWEEN, **piece, **nothing).kind is Verdicts.AGREES
    inexact = piece | {"distance": -0.26}
    assert verdict(Exact(absolute=0.02), BETWEEN, **inexact, **nothing).kind is Verdicts.AGREES
    assert verdict(Exact(absolute=0.002), BETWEEN, **inexact, **nothing).symptom == claims.STUCK
    high = Scene(CONTACTS, Sphere([0, 0, 1.0], 0.5), TWINS, "generic")
    out = answers_of(high)
    assert out.normal[0] == pytest.approx([0, 0, -1.0], abs=1e-9)
    assert verdict(Exact(relative=1e-9), high).kind is Verdicts.AGREES
    assert verdict(Exact(relative=1e-9), high, on_a=out.on_a[0] + [0, 0, -0.125]).symptom == claims.OFF_SHAPE
    aside = Scene(CONTACTS, Sphere([2.125, 0, 0], 0.25), TWINS, "generic")
    assert verdict(Exact(relative=1e-9), aside).kind is Verdicts.AGREES
    deeper = Scene(CONTACTS, Sphere([1.9, 0.5, 0], 0.25), TWINS, "generic")
    far = {"distance": 1.2 * float(answers_of(deeper).distance[0]), **nothing}
    assert verdict(Exact(relative=1e-2), deeper, **far).kind is Verdicts.WRONG
    assert depth > 0.25


HUGE = float("1e400")


@pytest.mark.parametrize(
    ("scene", "change", "symptom"),
    [
        (APART, {"distance": HUGE}, claims.LONG),
        (APART, {"distance": 1e308}, claims.NOT_A_NUMBER),
        (APART, {"on_a": [HUGE, 0, 0]}, claims.NOT_A_NUMBER),
        (APART, {"normal": [HUGE, 0, 0]}, claims.NOT_A_NUMBER),
        (OVERLAPPING, {"distance": -HUGE}, claims.SHORT),
        (OVERLAPPING, {"point": [0, -HUGE, 0]}, claims.NOT_A_NUMBER),
        (OVERLAPPING, {"hit": HUGE}, claims.NOT_A_NUMBER),
        (OVERLAPPING, {"hit": 0.5}, claims.NOT_A_NUMBER),
        (Scene(BOOLEAN, OVERLAPPING.a, OVERLAPPING.b, "generic"), {"hit": 2.0}, claims.NOT_A_NUMBER),
        (BEAM, {"hit": -1.0}, claims.NOT_A_NUMBER),
        (BEAM, {"t": HUGE}, claims.NOT_A_NUMBER),
        (BEAM, {"point": [HUGE] * 3}, claims.NOT_A_NUMBER),
    ],
)
def test_numbers_that_no_scene_can_have_are_wrong(scene: Scene, change: dict[str, Any], symptom: str) -> None:
    found = verdict(Exact(), scene, **change)
    assert (found.kind, found.symptom) == (Verdicts.WRONG, symptom)


def test_an_answer_is_named_by_the_first_claim_that_its_tolerance_does_not_excuse() -> None:
    """A depth that is too small by 0.05, along a normal by which a move leaves 0.23."""
    tilted = {"distance": -0.45, "normal": [0.6, 0.8, 0], "on_a": [np.nan] * 3, "on_b": [np.nan] * 3}
    named = [(verdict(Exact(absolute=t), OVERLAPPING, **tilted).symptom) for t in (0.0, 0.049, 0.051, 0.2, 0.3)]
    assert named == [claims.LONG, claims.LONG, claims.STUCK, claims.STUCK, ""]


def test_an_overlap_whose_depth_is_not_told_is_an_overlap_all_the_same() -> None:
    nothing = {"on_a": [np.nan] * 3, "on_b": [np.nan] * 3, "normal": [np.nan] * 3}
    overlap = Scene(DISTANCE, OVERLAPPING.a, OVERLAPPING.b, "generic")
    assert verdict(NoDepth(), overlap, distance=-math.inf, **nothing).kind is Verdicts.AGREES
    assert verdict(Exact(), overlap, distance=-math.inf, **nothing).symptom == claims.SHORT
    found = verdict(NoDepth(), APART, distance=-math.inf, **nothing)
    assert (found.symptom, found.amount) == (claims.SHORT, 2.0)
    assert verdict(NoDepth(), overlap, distance=-0.25).symptom == claims.LONG


def test_the_contact_of_one_triangle_has_a_depth_of_its_own() -> None:
    other = {"distance": -0.125, "normal": [0, 0, 1], "on_a": [np.nan] * 3, "on_b": [np.nan] * 3}
    assert verdict(Exact(), OVERLAPPING, **other).kind is Verdicts.WRONG
    assert verdict(OneTriangle(), OVERLAPPING, **other).kind is Verdicts.CONVENTION
    assert verdict(OneTriangle(), OVERLAPPING, hit=0.0).symptom == claims.MISSED
    assert verdict(OneTriangle(), OVERLAPPING, **other, point=[9, 0, 0]).symptom == claims.OUTSIDE


def test_what_an_engine_cannot_hold_is_not_judged() -> None:
    right = answers_of(APART)
    status = np.array([Status.UNSUPPORTED], dtype=np.int8)
    answers = Answers(status, **{n: getattr(right, n) for n in COLUMNS}, errors={0: "no ellipsoid"})
    assert list(Judge(Exact()).screen(APART.cell, APART.a[None], APART.b[None], answers).kind) == [Verdicts.UNSUPPORTED]


def test_points_and_half_spaces_as_witnesses() -> None:
    scene = Scene(DISTANCE, Point([0, 0, 3]), HalfSpace([0, 0, 2], -2), "generic")
    assert verdict(Exact(), scene).kind is Verdicts.AGREES
    assert verdict(Exact(), scene, on_a=[0, 0, 2.5]).symptom == claims.OFF_SHAPE
    both = Scene(DISTANCE, HalfSpace([0, 0, 1], 0), HalfSpace([0, 0, -1], 2), "generic")
    assert verdict(Exact(), both).kind is Verdicts.AGREES
    assert verdict(Exact(), both, distance=1.0).symptom == claims.SHORT
    endless = Scene(BOOLEAN, HalfSpace([0, 0, 1], 0), HalfSpace([0, 1, -1], 2), "generic")
    assert verdict(Exact(), endless, hit=0.0).symptom == claims.MISSED


@pytest.mark.parametrize("name", ["normal", "on_a", "on_b"])
def test_the_audit_sees_a_wrong_normal_or_witness(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def off(query: str, a: Any, b: Any) -> Answers:
        right = reference_answers(query, a, b)
        aside = np.sign(right.on_a) if name == "on_a" else np.array([1.0, 0.0, 0.0])
        return replace(right, **{name: getattr(right, name) + 1e-9 * aside})

    deep = Scene(DISTANCE, BETWEEN.a, BETWEEN.b, "generic")
    for scene in (APART, deep):
        assert audit(scene.a, scene.b).kind is Verdicts.AGREES
    monkeypatch.setattr(oracles.audit, "reference_answers", off)
    for scene in (APART, deep):
        assert audit(scene.a, scene.b).kind is Verdicts.REFERENCE_WRONG


def test_a_ray_that_leaves_from_just_outside_a_half_space_is_judged() -> None:
    """It starts 1e-17 above the plane, and its certificate proves that it misses."""
    ray = Ray(
        [0.0068599498034951165, 0.0024774137905935476, -0.0013982291509301308],
        [-1.5681913771978957, -0.5663392671154143, 0.31963658053564753],
    )
    solid = HalfSpace([0.17202561693328822, -0.7450203204314866, 0.6444780130174237], 0.0015667644639662526)
    assert certify(ray, solid).lower == math.inf
    engine = Exact(absolute=0.0, relative=10 * error_of(ray, solid))
    answers = reference_answers(RAYCAST, ray[None], solid[None])
    assert Judge(engine).convict(Scene(RAYCAST, ray, solid, "here"), answers).kind is Verdicts.AGREES


@pytest.mark.parametrize("speed", [1e-9, 1.0, 1e9])
def test_how_long_a_ray_s_direction_is_does_not_blur_the_judgement(speed: float) -> None:
    """A ray leaves a small ball, or just misses it: by a hair, which rounding of a far end would hide."""
    ball = Sphere([0.0, 0.0, 0.0], 1e-3)
    leaving = Ray([1e-3 * (1 + 1e-15), 0.0, 0.0], [speed, 0.5 * speed, 0.0])
    missing = Ray([-1e-2, 1e-3 * (1 + 1e-9), 0.0], [speed, 0.0, 0.0])
    hitting = Ray([-1e-2, 1e-3 * (1 - 1e-9), 0.0], [speed, 0.0, 0.0])
    engine = Exact(absolute=0.0, relative=10 * error_of(leaving, ball))
    for ray, hit in ((leaving, 0.0), (missing, 0.0), (hitting, 1.0)):
        right = reference_answers(RAYCAST, ray[None], ball[None])
        assert right.hit[0] == hit
        assert Judge(engine).convict(Scene(RAYCAST, ray, ball, "here"), right).kind is Verdicts.AGREES
        if ray is not leaving:  # which touches, as far as the engine promises
            wrong = replace(right, hit=1.0 - right.hit, t=np.array([1e-2 / speed]), point=right.point * np.nan)
            assert Judge(engine).convict(Scene(RAYCAST, ray, ball, "here"), wrong).kind is Verdicts.WRONG
