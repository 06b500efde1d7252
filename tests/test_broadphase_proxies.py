"""Proxies at the door of the broad phase: their boxes, infinite ones too, and the narrow test of candidates."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from refimpl import (
    Box,
    Capsule,
    Composite,
    ConvexPolyhedron,
    HalfSpace,
    Point,
    Proxy,
    Ray,
    Sphere,
    UnsupportedOperation,
    aabb,
    intersect,
)  # fmt: skip
from refimpl.broadphase import STRUCTURES, BruteForce, HashGrid, Numbered, boxes_of, pairs
from refimpl.shapes import KDOP

RNG = np.random.default_rng(5)
GIVEN: list[Proxy] = [
    Sphere(RNG.random((12, 3)) * 4, RNG.random(12) + 0.2),
    HalfSpace((0, 0, 2), -0.5),
    Box(RNG.random((2, 3, 3)) * 4, (0.4, 0.5, 0.6), RNG.normal(size=(2, 3, 4))),
    HalfSpace((1, 2, 3), -4),
    Composite([Sphere((1, 1, 1), 0.5), HalfSpace((0, -3, 0), 9)]),
    Sphere((0, 0, 0), 1),
    ConvexPolyhedron.from_vertices([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]),
    Point((0.1, 0.1, 0.1)),
    KDOP.around(RNG.random((10, 3))),
    Capsule((0, 0, 0), (3, 3, 3), 0.2),
]


def alone(proxies: list[Proxy]) -> list[Proxy]:
    """Every proxy by itself, in the order in which they are numbered."""
    return [x.flattened()[i] for x in proxies for i in range(int(np.prod(x.batch_shape)))]


def test_numbers_run_through_batches_and_types() -> None:
    numbered, each = Numbered.of(GIVEN), alone(GIVEN)
    assert len(numbered) == len(each) == 12 + 1 + 6 + 7
    assert [type(x) for x in numbered.batches].count(Sphere) == 1
    for number, x in enumerate(each):
        batch = numbered.batches[numbered.batch[number]]
        assert repr(batch[int(numbered.place[number])]) == repr(x)
    lower, upper = numbered.boxes()
    for number, x in enumerate(each):
        assert [lower[number].tolist(), upper[number].tolist()] == [corner.tolist() for corner in boxes_of(x)]


@pytest.mark.parametrize("name", STRUCTURES)
def test_pairs_of_proxies_and_of_their_boxes(name: str) -> None:
    each = alone(GIVEN)
    boxes = [boxes_of(x) for x in each]
    meet = [
        [i, j]
        for i, j in combinations(range(len(each)), 2)
        if np.all(np.maximum(boxes[i][0], boxes[j][0]) <= np.minimum(boxes[i][1], boxes[j][1]))
    ]
    assert pairs(GIVEN, name).tolist() == meet
    truly = [[i, j] for i, j in meet if intersect(each[i], each[j])]
    assert pairs(GIVEN, name, narrow=True).tolist() == pairs(each, name, narrow=True).tolist() == truly
    assert 0 < len(truly) < len(meet) < len(each) * (len(each) - 1) // 2
    static = np.arange(len(each)) % 2 == 0
    moving = [[i, j] for i, j in truly if i % 2 or j % 2]
    assert pairs(GIVEN, STRUCTURES[name].make, static, narrow=True).tolist() == moving


def test_half_spaces_have_the_bounds_that_they_have() -> None:
    rng = np.random.default_rng(1)
    for normal in [*np.eye(3), *-np.eye(3) * 3, *rng.normal(size=(3, 3)), [0, 1e-200, 0]]:
        half = HalfSpace(normal, rng.normal())
        lower, upper = boxes_of(half)
        assert np.count_nonzero(np.isfinite([lower, upper])) == (np.count_nonzero(normal) == 1)
        points = rng.normal(size=(200, 3)) * 10
        inside = points[points @ np.array(normal) + half.k <= 0]
        assert np.all((lower <= inside) & (inside <= upper))
        k = int(np.argmax(np.abs(normal)))
        if np.isfinite([lower[k], upper[k]]).any():
            bound = upper[k] if np.isfinite(upper[k]) else lower[k]
            assert bound == pytest.approx(-half.k / normal[k], rel=1e-15)


def test_the_boxes_of_unions_with_a_half_space() -> None:
    lower, upper = boxes_of(GIVEN[4])
    assert lower.tolist() == [-np.inf, 0.5, -np.inf]
    assert upper.tolist() == [np.inf] * 3
    ball = Sphere((1, 2, 3), 0.5)
    assert np.array_equal(boxes_of(Composite([ball]))[0], aabb(ball).lower)


def test_queries_of_proxies() -> None:
    structure = HashGrid.of(GIVEN)
    asked = [
        Ray((0, 0, 5), (0, 0, -1)),
        Point((1, 1, 1)),
        Sphere([(1, 1, 1), (9, 9, 9)], 0.5),
        Ray((0, 0, 9), (0, 0, 1)),
    ]
    lower, upper = Numbered.of(GIVEN).boxes()
    found = structure.query(asked)
    expected = BruteForce().build(lower, upper)
    ray = expected.query_rays([0, 0, 5], [0, 0, -1])
    away = expected.query_rays([0, 0, 9], [0, 0, 1])
    boxes = expected.query_boxes([[1, 1, 1], [0.5] * 3, [8.5] * 3], [[1, 1, 1], [1.5] * 3, [9.5] * 3])
    assert found.tolist() == [*ray.tolist(), *np.add(boxes, (1, 0)).tolist(), *np.add(away, (4, 0)).tolist()]
    assert len(away) < len(ray) < len(lower)


def test_what_is_refused() -> None:
    with pytest.raises(TypeError, match="expected proxies, got str"):
        pairs([Point((0, 0, 0)), "x"])  # type: ignore[list-item]
    with pytest.raises(LookupError, match="no structure 'list'; there are 'brute force'"):
        pairs(GIVEN, "list")
    twins = [Point((0, 0, 0))] * 2
    assert pairs(twins).tolist() == [[0, 1]]
    with pytest.raises(UnsupportedOperation, match="Point against Point"):
        pairs(twins, narrow=True)
    assert pairs([], narrow=True).shape == (0, 2)
