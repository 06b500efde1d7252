"""The truth for depths of unions under test, and the reference's interval held against it."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from itertools import product

import numpy as np
import pytest

from refimpl import AABB, Box, Polyhedron
from refimpl.contacts import contacts
from tests import truth
from tests.conftest import effort
from tests.depths import SAME, overlaps, part
from tests.solids import L_SHAPE, prism
from tests.truth import depths
from tests.truth.bodies import body_of
from tests.truth.depths import Arrangement, shortest_way_out

STILL = [0.0, 0, 0, 1]
L_PARTS = [AABB([0, 0, 0], [2, 1, 1]), AABB([0, 0, 0], [1, 2, 1])]


def way_out(a: list, b: list) -> tuple[float, list[float]]:
    length, way = shortest_way_out([body_of(x) for x in a], [body_of(x) for x in b])
    return float(length), [float(x) for x in way]


def test_known_ways_out() -> None:
    small = Box([0.9, 0.9, 0.5], [0.25] * 3, STILL)
    assert way_out(L_PARTS, [small]) == (pytest.approx(0.35 * np.sqrt(2), rel=1e-15), [0.35, 0.35, 0.0])  # the notch
    slot = [AABB([-2, -1, -1], [0, 1, 1]), AABB([1, -1, -1], [3, 1, 1])]
    assert way_out(slot, [AABB([-0.25, -0.5, -0.5], [0.5, 0.5, 0.5])]) == (0.25, [0.25, 0, 0])
    assert way_out(slot, [AABB([-0.25, -0.5, -0.5], [0.75, 0.5, 0.5])]) == (0.25, [0.25, 0, 0])  # fits exactly
    length, way = way_out(slot, [AABB([-0.25, -0.5, -0.75], [0.76, 0.5, 0.75])])  # does not: out at the side
    assert (length, abs(way[1])) == (1.5, 1.5)
    assert way_out(slot, [AABB([0.25, 0, 0], [0.5, 1, 1])]) == (0.0, [0, 0, 0])


def test_one_pair_of_parts_is_the_truth_of_convex_pairs() -> None:
    """By the other truth, which knows the least of all separating axes."""
    rng = np.random.default_rng(3)
    for i in range(effort()):
        a, b = part(rng, i % 2 == 0), part(rng, i % 2 == 0)
        expected = max(0.0, -float(truth.signed_distance(a, b)))
        assert way_out([a], [b])[0] == pytest.approx(expected, rel=1e-14, abs=1e-15)


def test_nothing_shorter_is_free() -> None:
    """Of many shorter translations, along its own way and all around, each is exactly in a difference."""
    rng = np.random.default_rng(4)
    for i in range(effort()):
        a, b = ([body_of(part(rng, i % 2 == 0)) for _ in range(2)] for _ in range(2))
        _, way = shortest_way_out(a, b)
        there = Arrangement.between(a, b)
        length = float(np.linalg.norm([float(x) for x in way]))
        for v in rng.normal(size=(60, 3)) if length else ():
            shorter = v / np.linalg.norm(v) * rng.uniform(0.7, 1 - 1e-9) * length
            assert not there.is_free(_place(shorter, there.unit))
        assert there.is_free(_place(way, there.unit))


def _place(t: object, unit: int) -> depths.Place:
    numbers = [Fraction(x) * unit for x in t]  # type: ignore[attr-defined]
    below = int(np.lcm.reduce([x.denominator for x in numbers], dtype=object))
    x, y, z = (int(n * below) for n in numbers)
    return (x, y, z), below


def test_a_mesh_is_its_parts() -> None:
    """The L as a mesh, cut by the reference, and as two boxes: the interval holds the same truth."""
    mesh = Polyhedron(*prism(L_SHAPE))
    for x, y in product((0.25, 0.75, 1.25), (0.25, 0.75, 1.25)):
        box = Box([x, y, 0.5], [0.3, 0.4, 0.2], [0, 0, 1.0, 3.0])
        expected, _ = way_out(L_PARTS, [box])
        least, depth = contacts(mesh, box).depth_interval
        assert least - 1e-14 <= expected <= depth + 1e-14


def test_the_interval_of_unions_holds_the_truth() -> None:
    found = list(overlaps(5 * effort(), 5))
    assert len(found) > effort()
    assert all(x.holds for x in found)
    assert all(not replace(x, depth=x.truth * (1 - 1e-6)).holds for x in found)
    assert all(not replace(x, least=x.truth * (1 + 1e-6)).holds for x in found)
    assert all(x.depth <= x.truth * (1 + SAME) for x in found)  # of polytopes no way is overlooked
    assert all(x.least >= x.truth * (1 - SAME) for x in found)


def test_a_missing_corner_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without the points where three planes meet, or the lines of two, ways are too long."""
    rng = np.random.default_rng(6)
    scenes = [[[part(rng, True) for _ in range(2)] for _ in range(2)] for _ in range(20)]
    right = [way_out(a, b)[0] for a, b in scenes]
    suspects = depths._suspects
    for missing in (2, 3):

        def lacking(there: Arrangement, count: int, limit: float, no: int = missing) -> list[tuple[int, ...]]:
            return [] if count == no else suspects(there, count, limit)

        monkeypatch.setattr(depths, "_suspects", lacking)
        wrong = []
        for a, b in scenes:
            try:
                wrong.append(way_out(a, b)[0])
            except AssertionError:
                wrong.append(np.inf)
        assert any(w > r for w, r in zip(wrong, right, strict=True))
