"""The reference against 50 digits: the numbers that the README promises, over every regime."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from mpmath import mp, mpf

import refimpl
from refimpl import Capsule, Composite, HalfSpace, Point, Polyhedron, Ray
from refimpl.pairs import ITERATIVE, TABLE
from tests import truth
from tests.conftest import QUICK, effort, name_of, regimes_in_turn, scenes_of

UNIONS = (Polyhedron, Composite)
CONVEX = [pair for pair in TABLE if pair[1] not in UNIONS and pair[0] not in UNIONS]
PAIRS = [pair for pair in CONVEX if pair[0] is not Ray]
UNION_PAIRS = [pair for pair in TABLE if pair not in CONVEX and pair[0] is not Ray]
RAY_PAIRS = [pair for pair in TABLE if pair[0] is Ray]
ACCURACY = 1e-14
"""Of rays, and of the pairs that are closed forms or finite."""


def accuracy(pair):
    return 1e-12 if TABLE[pair].exactness == ITERATIVE else ACCURACY


def few(pair):
    """Scenes of a regime: the truth of the larger and curved types takes longer."""
    return effort() if set(pair) <= QUICK else max(effort() // 5, 1)


def many(pair):
    """Scenes of a regime where nothing but the reference answers."""
    return 100 if set(pair) <= QUICK else 4 if set(pair) & set(UNIONS) else 16


def cases(pairs):
    """Pairs and regimes: all, but in the quick profile a third of those whose truth takes long."""
    return [(pair, regime) for pair in pairs for regime in regimes_in_turn(pair)]


def case(a, b, i):
    return f"{a[i]!r}, {b[i]!r}"


@pytest.mark.parametrize(("pair", "regime"), cases(PAIRS), ids=name_of)
def test_distance_is_true(pair, regime):
    """To 1e-14 of the scene's size, or 1e-12 for searches."""
    a, b = scenes_of(pair, regime, few(pair))
    found, hits = refimpl.distance(a, b), refimpl.intersect(a, b)
    for i in range(len(a)):
        true = truth.signed_distance(a[i], b[i])
        if math.isinf(true):
            assert found.distance[i] == true, case(a, b, i)
            assert hits[i]
            continue
        size = truth.scene_scale(a[i], b[i], true) or 1.0
        error = abs(true - float(found.distance[i])) / size
        assert error <= accuracy(pair), f"{float(error)} in {case(a, b, i)}"
        if abs(true) > accuracy(pair) * size:
            assert bool(hits[i]) == (true <= 0), case(a, b, i)


@pytest.mark.parametrize(("pair", "regime"), cases(PAIRS), ids=name_of)
def test_witnesses_keep_the_contract(pair, regime):
    """on_a ∈ A, on_b ∈ B, on_b − on_a = σ·normal, and moving B by −σ·normal makes the two touch.

    With the last, it proves the distance from both sides, or that the depth is not too small.
    """
    a, b = scenes_of(pair, regime, few(pair))
    found, bound = refimpl.distance(a, b), accuracy(pair)
    for i in np.flatnonzero(np.isfinite(found.distance)):
        size = float(max(a[i].magnitude, b[i].magnitude, abs(found.distance[i]))) or 1.0
        for witness, shape in ((found.on_a[i], a[i]), (found.on_b[i], b[i])):
            if isinstance(shape, Point):
                assert np.array_equal(witness, shape.position)
                continue
            assert truth.signed_distance(Point(witness), shape) <= 2 * bound * size, case(a, b, i)
        gap = found.on_b[i] - found.on_a[i] - found.distance[i] * found.normal[i]
        assert np.linalg.norm(gap) <= 2 * bound * size, case(a, b, i)
        assert abs(np.linalg.norm(found.normal[i]) - 1) <= 1e-15 * 4
        assert abs(_gap_along(a[i], b[i], found.normal[i]) - found.distance[i]) <= 3 * bound * size, case(a, b, i)


def _gap_along(a, b, n):
    """−(h_A(n) + h_B(−n)) in 60 digits: what the planes across the normal keep apart, or leave overlapping."""
    with mp.workdps(60):
        n = tuple(mpf(float(x)) for x in n)
        length = mp.sqrt(sum(x * x for x in n))
        return -(_support(a, n) + _support(b, tuple(-x for x in n))) / length


def _support(shape, n):
    """Support function; a half-space is asked along its own normal, up to rounding."""
    if isinstance(shape, HalfSpace):
        own = [mpf(float(x)) for x in shape.normal]
        size = mp.sqrt(sum(x * x for x in own))
        assert sum((x / size - y) ** 2 for x, y in zip(own, n, strict=True)) < 1e-30
        return -mpf(float(shape.k)) / size
    body = truth.body_of(shape)
    return body.support(n) + truth.real(body.radius) * mp.sqrt(sum(x * x for x in n))


@pytest.mark.parametrize("pair", PAIRS, ids=name_of)
def test_both_orders_agree_to_the_bit(pair):
    for regime in regimes_in_turn(pair):
        rows = many(pair)
        a, b = scenes_of(pair, regime, rows)
        there, back = refimpl.distance(a, b), refimpl.distance(b, a)
        assert np.array_equal(there.distance, back.distance)
        assert np.array_equal(refimpl.intersect(a, b), refimpl.intersect(b, a))
        apart = np.full(rows, True)
        if pair[0] is pair[1]:
            apart = np.any(a.reference_point != b.reference_point, axis=-1)
        for this, that in ((there.on_a, back.on_b), (there.on_b, back.on_a), (there.normal, -back.normal)):
            assert np.array_equal(this[apart], that[apart], equal_nan=True)


@pytest.mark.parametrize("pair", TABLE, ids=name_of)
def test_a_row_of_a_batch_equals_the_pair_alone_to_the_bit(pair):
    query = refimpl.raycast if pair[0] is Ray else refimpl.distance
    for regime in regimes_in_turn(pair):
        rows = min(many(pair), 40)
        a, b = scenes_of(pair, regime, rows)
        together, meets = query(a, b), refimpl.intersect(a, b)
        for i in {0, 1, rows // 2, rows - 1}:
            alone = query(a[i], b[i])
            assert bool(refimpl.intersect(a[i], b[i])) == meets[i]
            for name in type(alone).__dataclass_fields__:
                assert np.array_equal(getattr(alone, name), getattr(together, name)[i], equal_nan=True), case(a, b, i)


@pytest.mark.parametrize(("pair", "regime"), cases(RAY_PAIRS), ids=name_of)
def test_rays_hit_where_they_truly_do(pair, regime):
    """Hit or miss, and the hit point's place, are those of a solid grown or shrunk by 1e-14 at most."""
    rays, b = scenes_of(pair, regime, few(pair))
    found = refimpl.raycast(rays, b)
    for i in range(len(rays)):
        ray = rays[i]
        span = truth.ray_interval(ray, b[i])
        size = float(max(ray.magnitude, b[i].magnitude)) or 1.0
        if bool(found.hit[i]) != (span is not None):
            reach = 4 * (size + np.linalg.norm(ray.origin)) / np.linalg.norm(ray.direction)
            reach = max(reach, float(found.t[i]) if found.hit[i] else float(span[0]))
            sigma = truth.signed_distance(Capsule(ray.origin, ray.at(reach), 0.0), b[i])
            assert abs(sigma) <= ACCURACY * max(size, float(np.abs(ray.at(reach)).max())), case(rays, b, i)
            continue
        if span is None or span[0] == 0:
            continue
        point = found.point[i]
        size = max(size, float(np.abs(point).max()))
        assert abs(truth.signed_distance(Point(point), b[i])) <= 2 * ACCURACY * size, case(rays, b, i)
        until = truth.signed_distance(Capsule(ray.origin, point, 0.0), b[i])
        assert abs(until) <= 2 * ACCURACY * size, case(rays, b, i)


@pytest.mark.parametrize("regime", ["generic", "aligned", "nearly_touching", "sliver"])
@pytest.mark.parametrize("pair", UNION_PAIRS, ids=name_of)
def test_unions_apart_are_true_and_ways_out_are_free(pair, regime):
    """Apart, to 1e-12; overlapping, no less deep than their pieces, and apart after the translation that is told."""
    a, b = scenes_of(pair, regime, max(effort() // 10, 1))
    found, hits = refimpl.distance(a, b), refimpl.intersect(a, b)
    for i in range(len(a)):
        true, told = truth.signed_distance(a[i], b[i]), float(found.distance[i])
        size = truth.scene_scale(a[i], b[i], true) or 1.0
        if true > 0:
            assert abs(true - told) <= 1e-12 * size, case(a, b, i)
        else:
            assert told <= true + 1e-12 * size, case(a, b, i)
        if abs(true) > 1e-12 * size:
            assert bool(hits[i]) == (true <= 0), case(a, b, i)
        if -math.inf < told < 0:
            moved = b[i].translated(-told * found.normal[i])
            assert truth.signed_distance(a[i], moved) >= -3e-12 * max(size, -told), case(a, b, i)


def test_half_spaces_face_each_other_exactly_or_not_at_all():
    """Also where one normal is the other's times a power of two, or times a whole number, or is off in its last bit."""
    rng = np.random.default_rng(3)
    n = np.round(rng.normal(size=(300, 3)) * 2.0**20) * 2.0 ** rng.integers(-400, 400, 300)[:, None]
    n[::4, 1] = 0.0
    factors = np.array([1.0, 3.0, 2.0**-300, 2.0**300, -1.0])[np.arange(300) % 5]
    m = -factors[:, None] * n
    off = np.arange(300) % 7 == 0
    m[off, 2] = np.nextafter(m[off, 2], 0.0)
    gap = refimpl.distance(HalfSpace(n, np.zeros(300)), HalfSpace(m, np.zeros(300))).distance
    for i in range(300):
        u, v = [Fraction(x) for x in n[i].tolist()], [Fraction(x) for x in m[i].tolist()]
        facing = not any(u[j] * v[k] - u[k] * v[j] for j, k in ((0, 1), (1, 2), (2, 0))) and u[0] * v[0] <= 0
        facing = facing and sum(x * y for x, y in zip(u, v, strict=True)) < 0
        assert (gap[i] == 0.0) == facing, (n[i], m[i])
    assert 100 < np.count_nonzero(gap == 0.0) < 250


def test_an_error_of_2e_14_is_seen():
    """The tests above can fail: the truth notices an answer that is off by twice the promise."""
    a, b = scenes_of((refimpl.Box, refimpl.Box), "generic", 5)
    found = refimpl.distance(a, b).distance
    for i in range(5):
        size = truth.scene_scale(a[i], b[i])
        assert abs(truth.signed_distance(a[i], b[i]) - (float(found[i]) + 2e-14 * size)) > ACCURACY * size
