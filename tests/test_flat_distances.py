"""Signed distances of the flat world: against brute force in every regime, in both orders, alone and in rows."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mpmath import mpf

import refimpl
from refimpl import Separation
from refimpl.flat import ConvexPolygon, Disc, Flat, FlatPoint, FlatRay, Rectangle, Segment
from refimpl.flat.pairs import TABLE
from refimpl.rules import CLOSED
from tests import flat_truth
from tests.flat_scenes import REGIMES, whole

PAIRS: list[Any] = [pair for pair in TABLE if pair[0] is not FlatRay]
EACH = 2
Ask = Callable[[Any, Any], Separation]


@cache
def true_scenes(pair: Any) -> list[tuple[str, Any, Any, mpf, float]]:
    """Scenes of every regime, with their true signed distance and their size."""
    found = []
    rng = np.random.default_rng(PAIRS.index(pair))
    for name, make in REGIMES.items():
        for _ in range(EACH):
            a, b = make(*pair, rng)
            size = max(float(a.magnitude), float(b.magnitude))
            if size > 0:
                found.append((name, a, b, flat_truth.signed_distance(a, b), size))
    return found


def errors(ask: Ask, pair: Any) -> dict[str, float]:
    """Worst of a pair: of the distance, of the witnesses, and of the room that the normal leaves; parts of the size."""
    worst = dict.fromkeys(("distance", "witnesses", "normal", "unit", "on"), 0.0)
    for _, a, b, true, size in true_scenes(pair):
        found = ask(a, b)
        (points, r), (others, s) = flat_truth.corners(a), flat_truth.corners(b)
        n = tuple(Fraction(x) for x in found.normal.tolist())
        left = flat_truth.real(flat_truth.room((n[0], n[1]), points, others) - r - s)
        step = found.on_b - found.on_a - found.distance * found.normal
        outside = [_outside(x, of, radius) for x, of, radius in ((found.on_a, points, r), (found.on_b, others, s))]
        for what, amount in (
            ("distance", float(abs(mpf(float(found.distance)) - true) / size)),
            ("witnesses", float(np.max(np.abs(step)) / size)),
            ("normal", float(abs(left - true) / size)),
            ("unit", abs(float(np.hypot(*found.normal)) - 1)),
            ("on", float(max(outside) / size)),
        ):
            worst[what] = max(worst[what], amount)
    return worst


def _outside(x: Any, points: Any, radius: Fraction) -> mpf:
    (place,) = flat_truth.vectors(x)
    gap = flat_truth.square_gap([place], points) if flat_truth.are_apart([place], points) else Fraction(0)
    return flat_truth.mp.sqrt(flat_truth.real(gap)) - flat_truth.real(radius)


@pytest.mark.parametrize("pair", PAIRS, ids=lambda p: f"{p[0].__name__}-{p[1].__name__}")
def test_distances_witnesses_and_normals_are_those_of_brute_force(pair: Any) -> None:
    most = 1e-14 if TABLE[pair].exactness == CLOSED else 1e-12
    worst = errors(refimpl.distance, pair)
    assert worst["distance"] <= most
    assert worst["distance"] <= 2e-15  # what is measured, in any regime
    assert worst["unit"] <= 1e-15
    assert max(worst["witnesses"], worst["normal"], worst["on"]) <= 5e-15


@pytest.mark.parametrize(
    ("what", "wrong"),
    [
        ("distance", lambda f: replace(f, distance=f.distance * (1 + 1e-11))),
        ("distance", lambda f: replace(f, distance=np.maximum(f.distance, 0.0))),
        ("witnesses", lambda f: replace(f, on_a=f.on_b)),
        ("on", lambda f: f.flipped()),
        ("normal", lambda f: replace(f, normal=f.normal[::-1])),
        ("on", lambda f: replace(f, on_a=f.on_a + 1e-9 * f.normal, on_b=f.on_b + 1e-9 * f.normal)),
    ],
)
def test_wrong_answers_are_seen(what: str, wrong: Any) -> None:
    pair = (Segment, ConvexPolygon)
    assert errors(lambda a, b: wrong(refimpl.distance(a, b)), pair)[what] > 1e-12


def test_a_depth_by_the_sides_of_one_shape_alone_is_seen() -> None:
    """The classic mistake of separating axes: only the first polygon's sides are tried."""

    def one_sided(a: Any, b: Any) -> Separation:
        found = refimpl.distance(a, b)
        if found.distance > 0:
            return found
        n = np.array([(0.0, -1.0), (1.0, 0.0), (0.0, 1.0), (-1.0, 0.0)])
        rooms = -refimpl.support(a, n) - refimpl.support(b, -n)
        return replace(found, distance=np.max(rooms))

    assert errors(one_sided, (Rectangle, ConvexPolygon))["distance"] > 1e-3


@pytest.mark.parametrize("pair", PAIRS, ids=lambda p: f"{p[0].__name__}-{p[1].__name__}")
def test_both_orders_and_rows_of_a_batch_answer_alike_to_the_last_bit(pair: Any) -> None:
    rng = np.random.default_rng(7)
    size = ConvexPolygon.from_vertices(rng.normal(size=(30, 5, 2)))
    of: dict[type[Flat], Flat] = {
        FlatPoint: FlatPoint(rng.normal(size=(30, 2))),
        Disc: Disc(rng.normal(size=(30, 2)), rng.uniform(0.1, 2, size=30)),
        Segment: Segment(*rng.integers(-2, 3, size=(2, 30, 2)), rng.integers(0, 2, size=30)),
        Rectangle: Rectangle(low := rng.integers(-3, 2, size=(30, 2)), low + rng.integers(0, 3, size=(30, 2))),
        ConvexPolygon: size,
    }
    a, b = of[pair[0]], of[pair[1]].translated((0.5, 0.25))
    both, hits = refimpl.distance(a, b), refimpl.intersect(a, b)
    back = refimpl.distance(b, a)
    assert np.array_equal(both.distance, back.distance)
    assert np.array_equal(both.on_a, back.on_b)
    assert np.array_equal(both.normal, -back.normal)
    for i in range(30):
        alone = refimpl.distance(a[i], b[i])
        for name in ("distance", "on_a", "on_b", "normal"):
            assert np.array_equal(getattr(alone, name), getattr(both, name)[i]), (name, a[i], b[i])
        assert refimpl.intersect(a[i], b[i]) == hits[i]
    table = refimpl.distance(a[:, None], b[None, :6])
    assert np.array_equal(np.diagonal(table.distance[:6]), both.distance[:6])


@given(st.integers(0, 2**32), st.sampled_from(PAIRS))
@settings(max_examples=60, deadline=None)
def test_a_collision_is_resolved_by_its_shifts(seed: int, pair: Any) -> None:
    rng = np.random.default_rng(seed)
    a, b = (whole(kind, rng) for kind in pair)
    found = refimpl.collide(a, b, 1.0, 3.0)
    true = flat_truth.signed_distance(a, b)
    assert found.hit == (true <= 1e-15)
    if found.hit:
        assert np.allclose(found.shift_b, 3 * -found.shift_a)
        moved = refimpl.distance(a.translated(found.shift_a), b.translated(found.shift_b))
        assert abs(float(moved.distance)) <= 1e-13
        assert found.depth == pytest.approx(float(-true), abs=1e-14)
    else:
        assert not found.shift_a.any()


def test_known_answers() -> None:
    unit = Rectangle((0, 0), (1, 1))
    cross = refimpl.distance(Segment((-1, 0), (1, 0)), Segment((0, -3), (0, 3)))
    assert cross.distance == -1  # in the plane the short way is sideways, by half the shorter one's length
    assert refimpl.distance(unit, unit).distance == -1
    assert refimpl.distance(unit, Rectangle((1, 1), (2, 2))).distance == 0
    assert refimpl.intersect(unit, Rectangle((1, 1), (2, 2)))
    assert refimpl.distance(Disc((0, 0), 2), Disc((0, 0), 1)).distance == -3
    assert refimpl.distance(unit, Disc((4, 5), 1)).distance == 4
    triangle = ConvexPolygon([(-1, 0, 0), (0, -1, 0), (3, 4, -12)])
    assert refimpl.distance(FlatPoint((1, 1)), triangle).distance == pytest.approx(-1, abs=1e-15)
    assert refimpl.distance(FlatPoint((7, 4)), triangle).distance == pytest.approx(5, abs=1e-15)
