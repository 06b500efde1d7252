"""Flat proxies: what they refuse, what their outlines are, and that changes of them mean what they say."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import refimpl
from refimpl import ShapeError, Sphere, UnsupportedOperation
from refimpl.broadphase import BruteForce, Numbered, Octree
from refimpl.flat import ConvexPolygon, Disc, Flat, FlatPoint, FlatRay, Rectangle, Segment, table
from refimpl.flat.pairs import PROBES, SOLIDS
from refimpl.rules import require_rows
from tests import flat_truth
from tests.flat_scenes import REGIMES

SQUARE = [(1.0, 0.0, -1.0), (-1.0, 0.0, -1.0), (0.0, 1.0, -1.0), (0.0, -1.0, -1.0)]
EXAMPLES: list[Flat] = [
    FlatPoint((1, 2)),
    FlatRay((1, 2), (3, 4)),
    Disc((1, 2), 3),
    Segment((1, 2), (3, 4), 0.5),
    Rectangle((1, 2), (3, 5)),
    ConvexPolygon(SQUARE),
    ConvexPolygon.from_vertices([(0, 0), (2, 0), (1, 3)]),
]


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Disc((0, 0), 0), "Disc.radius must be greater than 0"),
        (lambda: Disc((0, 0, 0), 1), "Disc.center: expected 2 numbers"),
        (lambda: Disc((0, np.nan), 1), "Disc.center must be finite"),
        (lambda: Segment((0, 0), (1, 0), -1), "Segment.radius must be at least 0"),
        (lambda: Rectangle((0, 0), (1, -1)), "Rectangle.upper must not be below Rectangle.lower"),
        (lambda: FlatRay((0, 0), (0, 0)), "FlatRay.direction must not be zero"),
        (lambda: ConvexPolygon([(1, 0), (0, 1)]), "expected 2 × 3 numbers, .*; of corners, use from_vertices"),
        (lambda: ConvexPolygon([(1, 0, 0)]), r"unbounded along"),
        (lambda: ConvexPolygon([(1, 0, -1), (-1, 0, -1)]), r"unbounded along \(0.0, 1.0\)"),
        (lambda: ConvexPolygon([(1, 0, 0), (0, 1, 0)]), "unbounded"),
        (lambda: ConvexPolygon([(1, 0, 0), (-1, 0, 1), (0, 1, 0), (0, -1, 0)]), "no point lies behind all lines"),
        (lambda: ConvexPolygon([SQUARE, [*SQUARE[:3], (0, 1, 0)]]), r"unbounded along .*, at index \(1,\)"),
        (lambda: ConvexPolygon([(1, 0, -1), (0, 0, 1)]), "must have a normal that is not zero"),
        (lambda: ConvexPolygon.from_vertices(np.zeros((0, 2))), "expected"),
        (lambda: ConvexPolygon.from_vertices([(1, 2, 3)]), "expected 1 × 2 numbers"),
        (lambda: Disc((0, 0), 1).translated((1, 2, 3)), r"finite vector \(x, y\)"),
        (lambda: Disc((0, 0), 1).rotated(np.inf), "finite angle"),
        (lambda: refimpl.Composite([Disc((0, 0), 1)]), "expected a solid proxy, got Disc"),
        (lambda: Numbered.of([Disc((0, 0), 1), Sphere((0, 0, 0), 1)]).boxes(), "of the plane and of space"),
    ],
)
def test_what_means_no_set_is_refused_with_its_field(make: Any, words: str) -> None:
    with pytest.raises(ShapeError, match=words):
        make()


@pytest.mark.parametrize(
    ("ask", "words"),
    [
        (lambda: Rectangle((0, 0), (1, 1)).rotated(1.0), "use ConvexPolygon"),
        (lambda: Disc((0, 0), 1).stretched((1, 2)), "no flat type is an ellipse"),
        (lambda: Disc((0, 0), 1).stretched((1, 2, 3)), "takes 2 factors"),
        (lambda: refimpl.distance(Disc((0, 0), 1), Sphere((0, 0, 0), 1)), "not a cell of the pair table"),
        (lambda: refimpl.distance(Sphere((0, 0, 0), 1), Disc((0, 0), 1)), "not a cell of the pair table"),
        (lambda: refimpl.distance(FlatPoint((0, 0)), FlatPoint((0, 0))), "not a cell of the pair table"),
        (lambda: refimpl.distance(FlatRay((0, 0), (1, 0)), Disc((0, 0), 1)), "use raycast"),
        (lambda: refimpl.certify(Disc((0, 0), 1), Sphere((0, 0, 0), 1)), "one is of the plane"),
        (lambda: refimpl.sweep(Disc((0, 0), 1), Sphere((0, 0, 0), 1)), "another world"),
    ],
)
def test_what_a_type_does_not_have_is_refused(ask: Any, words: str) -> None:
    with pytest.raises(UnsupportedOperation, match=words):
        ask()


def test_the_table_has_every_pair_and_a_missing_row_is_an_error() -> None:
    rows = table()
    assert len(rows) == len(PROBES) * len(SOLIDS) + len(SOLIDS) * (len(SOLIDS) + 1) // 2 == 18
    pair = (Disc, Segment)
    with pytest.raises(LookupError, match="Disc, Segment"):
        require_rows({k: v for k, v in rows.items() if k != pair}, list(rows))


@pytest.mark.parametrize("shape", EXAMPLES, ids=lambda s: type(s).__name__)
def test_rows_of_numbers_give_the_same_proxy(shape: Flat) -> None:
    again = type(shape).unpack(shape.pack())
    assert repr(again) == repr(shape)
    both = type(shape).unpack(np.stack([shape.pack(), shape.translated((1, 1)).pack()]))
    assert repr(both[0]) == repr(shape)
    assert repr(both[1]) == repr(shape.translated((1, 1)))


@pytest.mark.parametrize("shape", EXAMPLES, ids=lambda s: type(s).__name__)
def test_a_change_moves_every_point_alike(shape: Flat) -> None:
    """The support function tells: that of the changed set is known from that of the set."""
    if isinstance(shape, FlatRay):
        assert np.allclose(shape.rotated(np.pi / 2).direction, (-4, 3))
        return
    ways = np.array([[np.cos(a), np.sin(a)] for a in np.arange(12) * 0.55])
    h = refimpl.support(shape, ways)
    assert np.allclose(refimpl.support(shape.translated((3, -1)), ways), h + ways @ (3, -1))
    assert np.allclose(refimpl.support(shape.scaled(2.5), ways), 2.5 * h)
    assert np.allclose(refimpl.support(shape.times_power(-3), ways), h / 8)
    if not isinstance(shape, Rectangle):
        turn = np.array([[np.cos(0.7), np.sin(0.7)], [-np.sin(0.7), np.cos(0.7)]])
        assert np.allclose(refimpl.support(shape.rotated(0.7), ways), refimpl.support(shape, ways @ turn.T))
    if not isinstance(shape, Disc) and not (isinstance(shape, Segment) and shape.radius):
        assert np.allclose(refimpl.support(shape.stretched((2, 3)), ways), refimpl.support(shape, ways * (2, 3)))


def is_outline(outline: Any, points: list[tuple[Fraction, Fraction]]) -> bool:
    """Whether corners are a hull's: each is a point, anticlockwise without a straight one, all points to the left."""
    corners = [(Fraction(x), Fraction(y)) for x, y in outline.tolist()]
    while len(corners) > 1 and corners[-1] == corners[0]:
        corners.pop()
    if not set(corners) <= set(points) or corners[0] != min(corners, key=lambda p: (p[1], p[0])):
        return False
    if len(corners) < 3:
        return all(flat_truth.off_segment(p, corners[0], corners[-1]) == (0, 0) for p in points)
    for i, p in enumerate(corners):
        q, r = corners[(i + 1) % len(corners)], corners[(i + 2) % len(corners)]
        side = flat_truth.minus(q, p)
        if flat_truth.cross(side, flat_truth.minus(r, q)) <= 0:
            return False
        if any(flat_truth.cross(side, flat_truth.minus(x, p)) < 0 for x in points):
            return False
    return True


VERTICES = st.lists(
    st.tuples(*[st.one_of(st.integers(-3, 3), st.sampled_from([1e-200, 1 / 3, 0.1, 0.30000000000000004, 1e20]))] * 2),
    min_size=1, max_size=8,
)  # fmt: skip


@given(VERTICES)
@settings(max_examples=80, deadline=None)
def test_corners_of_vertices_are_those_of_their_hull(vertices: list[tuple[float, float]]) -> None:
    shape = ConvexPolygon.from_vertices(np.array(vertices, dtype=np.float64))
    points = [(Fraction(float(x)), Fraction(float(y))) for x, y in vertices]
    assert is_outline(shape.outline.corners, points)


def test_a_wrong_outline_is_seen() -> None:
    points = [(Fraction(x), Fraction(y)) for x, y in ((0, 0), (2, 0), (2, 2), (0, 2), (1, 1))]
    right = np.array([(0, 0), (2, 0), (2, 2), (0, 2)], dtype=np.float64)
    assert is_outline(right, points)
    for wrong in (right[:3], right[::-1], np.roll(right, 1, axis=0), np.insert(right, 1, (1, 0), axis=0)):
        assert not is_outline(wrong, points)


@given(st.lists(st.tuples(st.integers(-3, 3), st.integers(-3, 3), st.integers(-4, 4)), min_size=3, max_size=7))
@settings(max_examples=80, deadline=None)
def test_corners_of_lines_are_where_two_of_them_meet(lines: list[tuple[int, int, int]]) -> None:
    lines = [line for line in lines if any(line[:2])] or [(1, 0, 0)]
    far = Fraction(10**6)  # what it cuts off was unbounded; of what is empty it leaves nothing
    sides = [(1, 0, -far), (-1, 0, -far), (0, 1, -far), (0, -1, -far)]
    cut = flat_truth.corners_of_lines([*[tuple(map(Fraction, line)) for line in lines], *sides])
    if not cut or max(abs(c) for p in cut for c in p) == far:
        with pytest.raises(ShapeError, match="unbounded" if cut else "empty"):
            ConvexPolygon(np.array(lines, dtype=np.float64))
        return
    shape = ConvexPolygon(np.array(lines, dtype=np.float64))
    points, _ = flat_truth.corners(shape)
    corners = {tuple(map(float, p)) for p in shape.outline.corners}
    assert corners <= {(float(x), float(y)) for x, y in points}
    for n in ((1, 0), (0, -1), (2, 3), (-1, 5), (-7, -2)):
        assert refimpl.support(shape, n) == pytest.approx(max(float(n[0] * x + n[1] * y) for x, y in points), abs=1e-14)


def test_a_polygon_of_lines_may_be_a_segment_or_a_point() -> None:
    segment = ConvexPolygon([(1, 0, -1), (-1, 0, 1), (0, 1, -2), (0, -1, 0)])
    assert segment.outline.corners.tolist() == [[1, 0], [1, 2]]
    point = ConvexPolygon([(1, 0, -1), (-1, 0, 1), (0, 1, -2), (0, -1, 2), (1, 1, -3)])
    assert point.outline.corners.tolist() == [[1, 2]]
    assert refimpl.distance(FlatPoint((4, 2)), segment).distance == 3


def test_bounding_volumes_contain_all_corners_exactly() -> None:
    rng = np.random.default_rng(4)
    for kind in SOLIDS:
        for make in REGIMES.values():
            shape = make(FlatPoint, kind, rng)[1]
            box, disc = refimpl.aabb(shape), refimpl.bounding_sphere(shape)
            points, radius = flat_truth.corners(shape)
            (low,), (high,) = flat_truth.vectors(box.lower), flat_truth.vectors(box.upper)
            (middle,), reach = flat_truth.corners(disc)
            for p in points:
                assert all(low[i] <= p[i] - radius and p[i] + radius <= high[i] for i in (0, 1))
                off = flat_truth.minus(p, middle)
                assert reach >= radius
                assert flat_truth.dot(off, off) <= (reach - radius) ** 2


def test_a_quadtree_finds_the_pairs_of_flat_proxies_that_meet() -> None:
    rng = np.random.default_rng(5)
    crowd = Numbered.of(
        [
            Disc(rng.uniform(0, 20, size=(60, 2)), rng.uniform(0.1, 1, size=60)),
            Rectangle(low := rng.uniform(0, 20, size=(60, 2)), low + rng.uniform(0, 2, size=(60, 2))),
            ConvexPolygon.from_vertices(rng.uniform(0, 20, size=(60, 1, 2)) + rng.normal(size=(60, 5, 2))),
        ]
    )
    boxes = crowd.boxes()
    near = Octree().build(*boxes).pairs()
    assert {tuple(p) for p in near.tolist()} == {tuple(p) for p in BruteForce().build(*boxes).pairs().tolist()}
    met = near[crowd.meet(near)]
    every = np.array([(i, j) for i in range(180) for j in range(i + 1, 180)])
    truth = {tuple(p) for p in every[crowd.meet(every)].tolist()}
    assert {tuple(sorted(p)) for p in met.tolist()} == truth
    assert 20 < len(truth) < len(near) < len(every)
