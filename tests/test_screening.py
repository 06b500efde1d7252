"""Screening a batch in arrays says what trying each answer alone, claim by claim, says; and it counts right."""

from __future__ import annotations

import math
from collections import Counter
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from oracles import reference
from oracles.answers import reference_answers, take
from oracles.batch import Batch
from oracles.claimed_shapes import moved_by
from oracles.claims import NEITHER, NOT_A_NUMBER, Questioned
from oracles.draws import NumpyDraws
from oracles.engine import COLUMNS, WIDTH, Answers, Array, Effective, Status
from oracles.engine import Kind as Type
from oracles.outcome import Kind
from oracles.regimes import REGIMES
from oracles.rules import Rules
from oracles.scene import BOOLEAN, CONTACTS, DISTANCE, RAYCAST, Cell
from oracles.screening import KINDS, Screening, counted, fate_of, screen
from refimpl import (
    KDOP,
    Box,
    Capsule,
    Composite,
    ConvexPolyhedron,
    Cylinder,
    HalfSpace,
    Polyhedron,
    Proxy,
    Ray,
    Separation,
    ShapeError,
    Sphere,
    distance,
)
from tests.conftest import effort, name_of
from tests.test_judge import AnyDepth, BlindInside, Exact, Grown, NoDepth, OneTriangle

PAIRS: list[tuple[type[Proxy], type[Proxy]]] = [
    (Sphere, Sphere),
    (Sphere, Box),
    (Capsule, Capsule),
    (HalfSpace, Box),
    (Box, Box),
    (Ray, Box),
    (Ray, HalfSpace),
    (Sphere, Cylinder),
    (Box, ConvexPolyhedron),
    (Sphere, Polyhedron),
    (Sphere, Composite),
]
ENGINES = [Exact(), Grown(), AnyDepth(), NoDepth(), OneTriangle(), Exact(absolute=0.1)]
QUERIES = {True: (RAYCAST,), False: (DISTANCE, CONTACTS, BOOLEAN)}


def spoiled(answers: Answers, seed: list[int]) -> Answers:
    """Answers of which some are right, some a little wrong, some very, and some are none."""
    rng = np.random.default_rng(seed)
    table = np.full((len(answers), WIDTH), np.nan)
    for name, columns in COLUMNS.items():
        values = getattr(answers, name).reshape(len(answers), -1)
        noise = rng.choice([0.0, 0.0, 0.0, 1e-9, 1e-3, 0.02, 1.0], (len(answers), 1)) * rng.normal(size=values.shape)
        table[:, columns] = values * (1.0 + noise) + rng.choice([0.0, 0.0, 0.0, 1e-9, 0.01], values.shape)
    flipped = rng.random(len(table)) < 0.2
    table[:, 0] = np.where(np.isnan(table[:, 0]), np.nan, np.where(flipped, 1.0, 0.0) != (answers.hit == 1))
    grown = np.flatnonzero(rng.random(len(table)) < 0.15)  # by a hundredth on both sides, and without a word more
    table[grown, 2:] = np.nan
    table[grown, 1] = answers.distance[grown] - 0.02
    table[grown, 0] = np.where(np.isnan(answers.distance[grown]), table[grown, 0], table[grown, 1] <= 0)
    table[rng.random(table.shape) < 0.01] = np.nan
    table[rng.random(table.shape) < 0.003] = -np.inf
    status = rng.choice(list(Status), len(table), p=[0.75, *[0.05] * 5]).astype(np.int8)
    table[status != Status.ANSWERED] = np.nan
    words = {Status.ERROR: ("answered 'no'", "TypeError: no"), Status.CRASHED: ("lost",)}
    errors = {int(i): str(rng.choice(words[Status(status[i])])) for i in np.flatnonzero(np.isin(status, [1, 2]))}
    return Answers.from_table(status, table, errors)


def one_by_one(rules: Rules, cell: Cell, a: Proxy, b: Proxy, answers: Answers) -> tuple[Kind, str, float, bool]:
    """Verdict on the one answer, in the words of the contract; the long way."""
    kind, symptom = fate_of(answers, 0)
    if kind is not Kind.AGREES:
        return kind, symptom, 0.0, True
    nominal = rules.questioned(cell, a, b, answers)
    if nominal.unusable[0]:
        return Kind.WRONG, NOT_A_NUMBER, math.inf, True
    ours = sides_of(rules, cell, nominal)
    broken = [side for side in ours if side["violated"]]
    if not broken:
        return Kind.AGREES, "", 0.0, True
    theirs = sides_of(rules, cell, rules.effectively(cell, nominal))
    mine, other = ([s for s in sides if s["violated"] and not s["waived"]] for sides in (ours, theirs))
    if rules.excused_inside(cell, nominal)[0] or not mine or not other:
        return Kind.CONVENTION, (mine or broken)[0]["word"], 0.0, True
    for s, t in zip(ours, theirs, strict=True):
        if s in mine and t in other:
            return Kind.WRONG, s["word"], min(s["excess"], t["excess"]), s["certain"] and t["certain"]
    s, t = mine[0], other[0]
    return Kind.WRONG, NEITHER, min(s["excess"], t["excess"]), s["certain"] and t["certain"]


def sides_of(rules: Rules, cell: Cell, rows: Questioned) -> list[dict[str, Any]]:
    found = []
    for number, claim in enumerate(rows.claims()):
        below, above, error = (float(x[0]) for x in claim.violations())
        allowed = float(rules.allowed(cell, claim.kind, rows.size)[0])
        for word, excess in ((claim.below, below), (claim.above, above)):
            side = {"number": number, "word": word, "excess": excess, "waived": claim.by_convention}
            found.append(side | {"violated": excess > allowed - error, "certain": excess > allowed + error})
    return found


@pytest.mark.parametrize("pair", PAIRS, ids=name_of)
def test_a_batch_is_screened_as_each_answer_alone(pair: tuple[type[Proxy], type[Proxy]]) -> None:
    seen: Counter[Kind] = Counter()
    for number, regime in enumerate(["generic", "touching", "deep", "aligned", "combined"]):
        few = 3 if Polyhedron in pair or Composite in pair else 12 if Ray in pair else 5
        a, b = REGIMES[regime](NumpyDraws(3, (number, 8), few * max(1, effort() // 12)), *pair)
        if isinstance(a, Ray):  # some from inside
            inside = (np.arange(len(a)) % 3 == 0)[:, None]
            a = Ray(np.where(inside, b.reference_point, a.origin), a.direction)
        for query in QUERIES[pair[0] is Ray]:
            cell, answers = Cell(query, *pair), spoiled(reference_answers(query, a, b), [number, len(query)])
            for engine in [*ENGINES, BlindInside()] if query == RAYCAST else ENGINES:
                rules = Rules(engine)
                found = screen(rules, cell, a, b, answers)
                seen.update(found.kind)
                for i in range(len(a)):
                    kind, symptom, amount, certain = one_by_one(rules, cell, a[[i]], b[[i]], take(answers, [i]))
                    here = found.kind[i], found.symptom[i], bool(found.certain[i]), found.amount[i]
                    assert here == (kind, symptom, certain, amount), (regime, query, engine, a[i], b[i], answers, i)
    assert {Kind.AGREES, Kind.WRONG, Kind.CONVENTION, Kind.CRASHED, Kind.TIMED_OUT} <= set(seen)


def test_the_error_is_that_of_the_value_before_any_tolerance() -> None:
    a, b = REGIMES["generic"](NumpyDraws(3, (1,), 40), Sphere, Box)
    right = reference_answers(CONTACTS, a, b)
    off = np.random.default_rng(1).uniform(-0.1, 0.1, 40)
    table = np.full((40, WIDTH), np.nan)
    table[:, 0], table[:, 1], table[:, 8:11] = right.hit, right.distance + off, right.normal
    answers = Answers.from_table(np.zeros(40, dtype=np.int8), table, {})
    for engine in (Exact(), Exact(absolute=1.0)):
        found = screen(Rules(engine), Cell(CONTACTS, Sphere, Box), a, b, answers)
        np.testing.assert_allclose(found.error[right.hit == 1], np.abs(off[right.hit == 1]), atol=1e-12)
        assert np.isnan(found.error[right.hit == 0]).all()
    assert np.isnan(screen(Rules(Exact()), Cell(BOOLEAN, Sphere, Box), a, b, answers).error).all()


class Larger(AnyDepth):
    """Declares that the depths of its contacts are not the pair's, and that it takes balls for larger ones."""

    def effective(self, query: str, A: Type, rows_a: Array, B: Type, rows_b: Array) -> tuple[Effective, Effective]:
        return Effective(A, rows_a + np.array([0.0, 0.0, 0.0, 0.25]), np.zeros(len(rows_a))), Effective.exactly(
            B, rows_b
        )


def test_what_is_not_meant_to_be_the_depth_of_the_pair_is_measured_on_the_shapes_given() -> None:
    a, b = Sphere(np.zeros((2, 3)), np.ones(2)), Sphere([[1.5, 0.0, 0.0], [1.0, 0.0, 0.0]], np.ones(2))
    table = np.full((2, WIDTH), np.nan)
    table[:, 0], table[:, 1] = 1.0, (-0.75, -1.0)  # the first is right of the larger ball, the second of the given one
    table[:, 8:11] = (1.0, 0.0, 0.0)
    answers = Answers.from_table(np.zeros(2, dtype=np.int8), table, {})
    found = screen(Rules(Larger()), Cell(CONTACTS, Sphere, Sphere), a, b, answers)
    np.testing.assert_allclose(found.error, [0.25, 0.0], atol=1e-12)
    assert found.kind[0] is Kind.CONVENTION


def test_no_upper_bound_of_a_depth_is_looked_for_where_no_claim_has_one() -> None:
    """It is that of the other way out where it was looked for, and the same from below."""
    draws = NumpyDraws(3, (0, 8), 40)
    a, b = REGIMES["deep"](draws, Sphere, Composite)
    wanted = np.arange(40) % 5 != 0
    least, most = reference.signed(a, b, wanted)
    alike, same = reference.signed(a, b, wanted, above=False)
    np.testing.assert_array_equal(alike, least)
    np.testing.assert_array_equal(same, least)
    assert (most > least).any()


def test_pressure_is_the_error_by_the_tolerance() -> None:
    a, b = REGIMES["generic"](NumpyDraws(3, (2,), 30), Sphere, Sphere)
    right = reference_answers(DISTANCE, a, b)
    table = np.full((30, WIDTH), np.nan)
    table[:, 1] = right.distance + 0.05
    answers = Answers.from_table(np.zeros(30, dtype=np.int8), table, {})
    found = screen(Rules(Exact(absolute=0.1, relative=0.0)), Cell(DISTANCE, Sphere, Sphere), a, b, answers)
    np.testing.assert_allclose(found.pressure, 0.5, rtol=1e-9)
    assert set(found.kind) == {Kind.AGREES}
    found = screen(Rules(Exact(absolute=0.02, relative=0.0)), Cell(DISTANCE, Sphere, Sphere), a, b, answers)
    np.testing.assert_allclose(found.pressure, 2.5, rtol=1e-9)
    assert set(found.kind) == {Kind.WRONG}
    assert found.certain.all()


@given(st.lists(st.tuples(st.integers(0, 4), st.sampled_from(KINDS)), max_size=40))
def test_counts_are_those_of_a_counter(pairs: list[tuple[int, Kind]]) -> None:
    groups = np.array([group for group, _ in pairs], dtype=int)
    codes = np.array([KINDS.index(kind) for _, kind in pairs], dtype=np.int8)
    assert counted(codes, groups) == Counter(pairs)


def test_a_screening_names_its_kinds_and_counts_its_groups() -> None:
    status = np.array([Status.ANSWERED, Status.CRASHED, Status.TIMED_OUT, Status.ERROR], dtype=np.int8)
    begun = Screening.of_fates(Answers.from_table(status, np.full((4, WIDTH), np.nan), {3: "answered 7"}))
    assert list(begun.kind) == [Kind.AGREES, Kind.CRASHED, Kind.TIMED_OUT, Kind.WRONG]
    assert begun.symptom[3] == NOT_A_NUMBER
    assert begun.rows_of([Kind.WRONG, Kind.CRASHED]).tolist() == [1, 3]
    groups = np.array([0, 0, 1, 1])
    assert begun.counts(groups) == Counter(zip(groups.tolist(), begun.kind, strict=True))


def test_what_is_known_of_a_batch_is_asked_once(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[int] = []

    def counting(x: Proxy, y: Proxy) -> Separation:
        asked.append(len(x))
        return distance(x, y)

    monkeypatch.setattr(reference, "distance", counting)
    (batch,) = Batch.draw((Sphere, Cylinder), 5, (1,), 3)
    answers = reference_answers(BOOLEAN, batch.a, batch.b)
    for engine in (Exact(), AnyDepth()):
        found = screen(Rules(engine), Cell(BOOLEAN, Sphere, Cylinder), batch.a, batch.b, answers)
        assert set(found.kind) == {Kind.AGREES}
    assert asked == [len(batch)]


def test_ways_out_of_composites_are_looked_for_where_an_answer_says_more_than_the_deepest_parts() -> None:
    batch = max(Batch.draw((Box, Composite), 5, (1,), 12), key=len)  # each form of composites is a batch
    every = np.ones(len(batch), dtype=bool)
    low, high = reference.signed(batch.a, batch.b, every)
    deeper = low < high
    assert deeper.sum() > 3, "no overlap with a way out that is longer than its deepest pair"
    x, y = batch.a[np.arange(len(batch))], batch.b[np.arange(len(batch))]
    from_above = reference.kept(x, y, every, enough=np.inf)
    np.testing.assert_array_equal(from_above[1], high)
    np.testing.assert_array_equal(from_above[0], np.where(high >= 0, low, -np.inf))
    enough = np.where(np.arange(len(batch)) % 2 == 0, high - 0.1, high)
    some = reference.kept(x, y, every, enough=enough)
    np.testing.assert_array_equal(some[0], np.where((high >= 0) | (high > enough), low, -np.inf))
    np.testing.assert_array_equal(reference.kept(x, y, every), (low, high))


def test_slabs_that_no_move_leaves_whole_are_asked_for_no_normal() -> None:
    """A point as slabs across five directions, sent away by an answer: rounding leaves no point, and others go on."""
    directions = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1], [1, -1, 0.3]])
    point = KDOP(directions, np.zeros(5), np.zeros(5))[None]
    both = point[[0, 0]]
    normals = np.array([[0.48, 0.6, 0.64], [0.0, 0.0, 1.0]])
    way = np.array([1.0, 0.0])[:, None] * normals
    with pytest.raises(ShapeError, match="the set is empty"):
        both.translated(way)
    moved, can_move = moved_by(both, way)
    assert can_move.tolist() == [False, True]
    np.testing.assert_array_equal(moved.pack(), both.pack())
    table = np.full((2, WIDTH), np.nan)
    table[:, COLUMNS["hit"]] = 1.0
    table[:, COLUMNS["distance"]] = [[-1.0], [0.0]]
    table[:, COLUMNS["normal"]] = normals
    answers = Answers.from_table(np.zeros(2, dtype=np.int8), table, {})
    found = screen(Rules(Exact()), Cell(CONTACTS, KDOP, KDOP), both, both, answers)
    assert [found.kind[0], found.kind[1]] == [Kind.WRONG, Kind.AGREES]
