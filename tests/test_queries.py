"""The door: laws that every cell obeys, hard cases as ordinary input, and errors that help."""

from __future__ import annotations

import math

import numpy as np
import pytest

import refimpl
from oracles.regimes import REGIMES
from refimpl import (
    AABB,
    Box,
    Capsule,
    Composite,
    HalfSpace,
    Point,
    Polyhedron,
    Ray,
    Sphere,
    UnsupportedOperation,
    collide,
    distance,
    intersect,
    raycast,
)
from refimpl.pairs import CLOSED, FINITE, ITERATIVE, TABLE, require_complete, required_pairs
from tests.conftest import name_of, scenes_of

SIMPLE = {Point, Sphere, Capsule, HalfSpace, AABB, Box}
PAIRS = [pair for pair in TABLE if set(pair) <= SIMPLE]
"""Pairs that are fast enough for whole batches; `tests.test_laws` draws scenes of all."""
CONVEX = [pair for pair in TABLE if pair[0] is not Ray and not set(pair) & {Polyhedron, Composite}]
UNIT = [0.0, 0.0, 0.0, 1.0]


def size_of(a, b, sigma):
    return np.maximum(np.maximum(a.magnitude, b.magnitude), np.abs(sigma))


def test_the_table_is_complete_and_says_how():
    rows = refimpl.table()
    assert len(rows) == 88
    probes, solids = {Point, Ray}, {b for _, b in rows}
    assert len(solids) == 11
    assert set(rows) >= {(probe, solid) for probe in probes for solid in solids}
    assert len({frozenset(pair) for pair in rows}) == 88
    assert all(rule.exactness in (CLOSED, FINITE, ITERATIVE) and rule.algorithm for rule in rows.values())
    rows.clear()
    assert len(refimpl.table()) == 88


def test_a_missing_row_is_an_error_that_names_it():
    for pair in required_pairs():
        rows = refimpl.table()
        del rows[pair]
        with pytest.raises(LookupError, match=rf"lacks \({pair[0].__name__}, {pair[1].__name__}\)"):
            require_complete(rows)
    with pytest.raises(LookupError, match="has no use for"):
        require_complete(refimpl.table() | {(Point, Point): TABLE[Sphere, Sphere]})


@pytest.mark.parametrize("pair", PAIRS, ids=name_of)
def test_rigid_motion_and_scale_change_nothing(pair):
    """Move, turn by quarter turns (exact) and scale by powers of two (exact): the same distance to rounding."""
    for regime in REGIMES:
        a, b = scenes_of(pair, regime, 60)
        sigma = distance(a, b).distance
        finite = np.isfinite(sigma)
        size = size_of(a, b, np.where(finite, sigma, 0.0))
        offset = np.array([0.5, -0.25, 2.0]) * size.max()
        moved = distance(a.translated(offset), b.translated(offset)).distance
        assert np.all(np.abs(moved[finite] - sigma[finite]) <= 1e-14 * 4 * size.max())
        assert np.array_equal(distance(a.scaled(2.0**-30), b.scaled(2.0**-30)).distance, np.ldexp(sigma, -30))
        if AABB not in pair:
            turned = distance(a.rotated([1, 1, 1, 1]), b.rotated([1, 1, 1, 1])).distance
            assert np.all(np.abs(turned[finite] - sigma[finite]) <= 1e-14 * size[finite])
            q = [0.3, -0.1, 0.2, 0.7]
            turned = distance(a.rotated(q), b.rotated(q)).distance
            bounded = finite if pair != (HalfSpace, HalfSpace) else np.zeros_like(finite)
            assert np.all(np.abs(turned[bounded] - sigma[bounded]) <= 4e-14 * size[bounded])


@pytest.mark.parametrize("pair", PAIRS, ids=name_of)
def test_intersect_has_the_sign_of_distance(pair):
    for regime in REGIMES:
        a, b = scenes_of(pair, regime, 200)
        sigma = distance(a, b).distance
        clear = np.abs(sigma) > 1e-14 * size_of(a, b, np.where(np.isfinite(sigma), sigma, 0.0))
        assert np.array_equal(intersect(a, b)[clear], (sigma <= 0)[clear])


@pytest.mark.parametrize("pair", TABLE, ids=name_of)
def test_a_batch_of_none_has_no_answers(pair):
    a, b = scenes_of(pair, "generic", 3)
    asked = (raycast, intersect) if pair[0] is Ray else (distance, collide, intersect)
    for query in asked:
        for x, y in ((a[:0], b[:0]), (a[:0], b[0]), (a[0], b[:0]), (b[:0], a[:0]), (b[0], a[:0])):
            found = query(x, y)
            columns = [found] if query is intersect else [getattr(found, name) for name in found.__dataclass_fields__]
            assert {column.shape for column in columns} <= {(0,), (0, 3)}


@pytest.mark.parametrize("masses", [(1.0, 1.0), (0.0, 1.0), (1.0, 0.0), (1e-3, 7.0)])
@pytest.mark.parametrize("pair", PAIRS, ids=name_of)
def test_shifts_lead_to_positions_without_overlap(pair, masses):
    for regime in REGIMES:
        a, b = scenes_of(pair, regime, 40)
        found = collide(a, b, inverse_mass_a=masses[0], inverse_mass_b=masses[1])
        sigma = distance(a, b).distance
        assert np.array_equal(found.hit, sigma <= 0)
        bounded = np.isfinite(sigma)
        size = size_of(a, b, np.where(bounded, sigma, 0.0))
        safe = distance(
            a.translated(np.where(bounded[:, None], found.shift_a, 0)),
            b.translated(np.where(bounded[:, None], found.shift_b, 0)),
        )
        assert np.all(safe.distance[bounded] >= -5e-14 * size[bounded])
        overlap = bounded & (sigma < 0)
        assert np.all(np.abs(safe.distance[overlap]) <= 5e-14 * size[overlap])
        for w, shift in zip(masses, (found.shift_a, found.shift_b), strict=True):
            if w == 0:
                assert np.all(shift[bounded] == 0)
        assert np.all(found.shift_a[sigma > 0] == 0)
        assert np.all(found.depth == np.where(sigma <= 0, -sigma, 0.0))


def test_half_spaces_overlap_without_end_unless_they_face_exactly():
    up, down = HalfSpace([0, 0, 3], -6), HalfSpace([0, 0, -2], 2)
    assert distance(up, down).distance == -1.0
    assert distance(up, HalfSpace([0, 0, -2], 10)).distance == 3.0
    tilted = HalfSpace([0, 1e-200, -2], 2)
    found = distance(up, tilted)
    assert found.distance == -math.inf
    assert np.isnan(found.normal).all()
    data = collide(up, tilted)
    assert data.hit
    assert data.depth == math.inf
    assert np.isnan(data.shift_a).all()
    assert intersect(up, tilted)


@pytest.mark.parametrize(
    ("a", "b", "sigma"),
    [
        (Sphere([0, 0, 0], 1), Sphere([0, 0, 0], 2), -3.0),
        (Sphere([0, 0, 0], 1), Sphere([0, 3, 0], 2), 0.0),
        (Capsule([1, 1, 1], [1, 1, 1], 0.5), Capsule([1, 1, 1], [1, 1, 1], 0.0), -0.5),
        (Capsule([-1, 0, 0], [1, 0, 0], 0.5), Capsule([0, -1, 0], [0, 1, 0], 0.25), -0.75),
        (Capsule([0, 0, 0], [4, 0, 0], 1), Capsule([1, 0, 0], [2, 0, 0], 1), -2.0),
        (Capsule([0, 0, 0], [4, 0, 0], 1), Capsule([1, 3, 0], [9, 3, 0], 1), 1.0),
        (Box([0, 0, 0], [1, 1, 1], UNIT), Box([0, 0, 0], [1, 1, 1], UNIT), -2.0),
        (Box([0, 0, 0], [1, 1, 1], UNIT), Box([2, 2, 0], [1, 1, 1], UNIT), 0.0),
        (Box([0, 0, 0], [1, 1, 1], UNIT), Box([2, 0.5, 0], [1, 1, 1], UNIT), 0.0),
        (Box([0, 0, 0], [1, 1, 1], UNIT), Box([0, 5, 0], [1, 1, 1], [0, 0, 7, 0]), 3.0),
        (AABB([0, 0, 0], [1, 1, 1]), AABB([4, 5, 1], [9, 9, 9]), 5.0),
        (Point([0, 0, 0]), AABB([-1, -2, -3], [5, 5, 5]), -1.0),
        (Point([0, 0, 0]), Box([0, 0, 0], [3, 2, 1], UNIT), -1.0),
        (Capsule([-9, 0, 0], [9, 0, 0], 0.5), Box([0, 0, 0], [2, 3, 4], UNIT), -3.5),
        (Capsule([0, 0, -0.5], [0, 0, 0.5], 0.25), Box([0, 0, 0], [2, 3, 1], UNIT), -1.75),
        (Sphere([0, 0, 5], 1), HalfSpace([0, 0, 2], -4), 2.0),
    ],
)
def test_hard_cases_are_ordinary_inputs(a, b, sigma):
    assert distance(a, b).distance == sigma
    assert distance(b, a).distance == sigma
    assert bool(intersect(a, b)) == (sigma <= 0)
    normal = distance(a, b).normal
    assert abs(np.linalg.norm(normal) - 1) < 1e-15
    assert abs(distance(a, b.translated(-sigma * normal)).distance) <= 1e-15


@pytest.mark.parametrize(
    ("ray", "solid", "t", "normal"),
    [
        (Ray([-5, 0, 0], [2, 0, 0]), Sphere([0, 0, 0], 1), 2.0, [-1, 0, 0]),
        (Ray([-5, 1, 0], [1, 0, 0]), Sphere([0, 0, 0], 1), 5.0, [0, 1, 0]),
        (Ray([-5, 1.0000001, 0], [1, 0, 0]), Sphere([0, 0, 0], 1), math.inf, None),
        (Ray([5, 0, 0], [1, 0, 0]), Sphere([0, 0, 0], 1), math.inf, None),
        (Ray([0.5, 0, 0], [1, 0, 0]), Sphere([0, 0, 0], 1), 0.0, None),
        (Ray([0, 0, 9], [0, 0, -3]), Capsule([0, 0, 0], [0, 0, 1], 2), 2.0, [0, 0, 1]),
        (Ray([5, 0, 0.5], [-1, 0, 0]), Capsule([0, 0, 0], [0, 0, 1], 2), 3.0, [1, 0, 0]),
        (Ray([5, 0, 0], [-1, 0, 0]), Capsule([0, 0, 0], [0, 0, 0], 2), 3.0, [1, 0, 0]),
        (Ray([0, 0, 9], [1, 0, -3]), HalfSpace([0, 0, 5], 0), 3.0, [0, 0, 1]),
        (Ray([0, 0, 9], [1, 0, 0]), HalfSpace([0, 0, 5], 0), math.inf, None),
        (Ray([-5, 1, 0], [1, 0, 0]), AABB([-1, -1, -1], [1, 1, 1]), 4.0, [-1, 0, 0]),
        (Ray([-5, 0, 0], [0.5, 0, 0]), Box([0, 0, 0], [1, 1, 1], [0, 0, 1, 0]), 8.0, [-1, 0, 0]),
        (Ray([1e-9, -5e-9, 0], [0, 1e-12, 0]), AABB([-1e-9] * 3, [1e-9] * 3), 4000.0, [0, -1, 0]),
    ],
)
def test_rays(ray, solid, t, normal):
    for found in (raycast(ray, solid), raycast(solid, ray)):
        assert found.t == pytest.approx(t, rel=1e-15)
        assert bool(found.hit) == math.isfinite(t) == bool(intersect(ray, solid))
        if normal is None:
            assert np.isnan(found.normal).all()
        else:
            assert found.normal == pytest.approx(normal, abs=1e-15)
            assert found.point == pytest.approx(ray.origin + t * ray.direction, abs=1e-15)


@pytest.mark.parametrize("power", [-1000, -600, -300, 300, 600, 1000])
@pytest.mark.parametrize("pair", [p for p in CONVEX if HalfSpace not in p], ids=name_of)
def test_extreme_scales_neither_overflow_nor_vanish(pair, power):
    """Scaling by a power of two is exact, and so is its effect, up to numbers no double can hold."""
    a, b = scenes_of(pair, "generic", 20 if pair in PAIRS else 4)
    sigma = distance(a, b).distance
    scaled = distance(a.scaled(2.0**power), b.scaled(2.0**power)).distance
    assert np.array_equal(scaled, np.ldexp(sigma, power))


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (lambda: distance(Sphere([0, 0, 0], 1), 3), TypeError, "needs two proxies, got int: 3"),
        (
            lambda: distance(Ray([0, 0, 0], [1, 0, 0]), Sphere([0, 0, 0], 1)),
            UnsupportedOperation,
            "use raycast",
        ),
        (
            lambda: distance(Point([0, 0, 0]), Point([0, 0, 0])),
            UnsupportedOperation,
            "Point against Point is not a cell",
        ),
        (
            lambda: raycast(Sphere([0, 0, 0], 1), Sphere([0, 0, 0], 1)),
            UnsupportedOperation,
            "raycast needs a Ray",
        ),
        (lambda: collide(Sphere([0, 0, 0], 1), Sphere([0, 0, 0], 1), 0, 0), ValueError, "both 0"),
        (
            lambda: collide(Sphere([0, 0, 0], 1), Sphere([0, 0, 0], 1), -1, 0),
            ValueError,
            "inverse_mass_a must be finite",
        ),
        (
            lambda: collide(Sphere([0, 0, 0], 1), Sphere([0, 0, 0], 1), 1, math.nan),
            ValueError,
            "inverse_mass_b",
        ),
    ],
)
def test_errors_name_the_thing_and_the_way_out(call, error, words):
    with pytest.raises(error) as caught:
        call()
    assert words in str(caught.value)
