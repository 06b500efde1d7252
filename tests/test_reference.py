"""The reference against 50 digits: the numbers that the README promises, over every regime."""

from __future__ import annotations

import math

import numpy as np
import pytest

import refimpl
from oracles.regimes import REGIMES
from refimpl import Capsule, Point, Ray
from refimpl.pairs import TABLE
from tests import truth
from tests.conftest import effort, name_of, scenes_of

PAIRS = [pair for pair in TABLE if pair[0] is not Ray]
RAY_PAIRS = [pair for pair in TABLE if pair[0] is Ray]
ACCURACY = 1e-14


def case(a, b, i):
    return f"{a[i]!r}, {b[i]!r}"


@pytest.mark.parametrize("regime", REGIMES)
@pytest.mark.parametrize("pair", PAIRS, ids=name_of)
def test_distance_is_true_to_1e_14(pair, regime):
    a, b = scenes_of(pair, regime, effort())
    found, hits = refimpl.distance(a, b), refimpl.intersect(a, b)
    for i in range(len(a)):
        true = truth.signed_distance(a[i], b[i])
        if math.isinf(true):
            assert found.distance[i] == true, case(a, b, i)
            assert hits[i]
            continue
        size = truth.scene_scale(a[i], b[i]) or 1.0
        error = abs(true - float(found.distance[i])) / size
        assert error <= ACCURACY, f"{float(error)} in {case(a, b, i)}"
        if abs(true) > ACCURACY * size:
            assert bool(hits[i]) == (true <= 0), case(a, b, i)


@pytest.mark.parametrize("regime", REGIMES)
@pytest.mark.parametrize("pair", PAIRS, ids=name_of)
def test_witnesses_keep_the_contract(pair, regime):
    """on_a ∈ A, on_b ∈ B, on_b − on_a = σ·normal, and moving B by −σ·normal makes the two touch."""
    a, b = scenes_of(pair, regime, effort())
    found = refimpl.distance(a, b)
    for i in np.flatnonzero(np.isfinite(found.distance)):
        size = max(truth.scene_scale(a[i], b[i]), abs(float(found.distance[i]))) or 1.0
        for witness, shape in ((found.on_a[i], a[i]), (found.on_b[i], b[i])):
            if isinstance(shape, Point):
                assert np.array_equal(witness, shape.position)
                continue
            assert truth.signed_distance(Point(witness), shape) <= 2 * ACCURACY * size, case(a, b, i)
        gap = found.on_b[i] - found.on_a[i] - found.distance[i] * found.normal[i]
        assert np.linalg.norm(gap) <= 2 * ACCURACY * size, case(a, b, i)
        assert abs(np.linalg.norm(found.normal[i]) - 1) <= 1e-15 * 4
        moved = b[i].translated(-found.distance[i] * found.normal[i])
        assert abs(truth.signed_distance(a[i], moved)) <= 3 * ACCURACY * size, case(a, b, i)


@pytest.mark.parametrize("pair", PAIRS, ids=name_of)
def test_both_orders_agree_to_the_bit(pair):
    for regime in REGIMES:
        a, b = scenes_of(pair, regime, 100)
        there, back = refimpl.distance(a, b), refimpl.distance(b, a)
        assert np.array_equal(there.distance, back.distance)
        assert np.array_equal(refimpl.intersect(a, b), refimpl.intersect(b, a))
        apart = np.any(a.pack()[:, :3] != b.pack()[:, :3], axis=-1) if pair[0] is pair[1] else np.full(100, True)
        for this, that in ((there.on_a, back.on_b), (there.on_b, back.on_a), (there.normal, -back.normal)):
            assert np.array_equal(this[apart], that[apart], equal_nan=True)


@pytest.mark.parametrize("pair", TABLE, ids=name_of)
def test_a_row_of_a_batch_equals_the_pair_alone_to_the_bit(pair):
    query = refimpl.raycast if pair[0] is Ray else refimpl.distance
    for regime in REGIMES:
        a, b = scenes_of(pair, regime, 40)
        together, meets = query(a, b), refimpl.intersect(a, b)
        for i in (0, 1, 17, 39):
            alone = query(a[i], b[i])
            assert bool(refimpl.intersect(a[i], b[i])) == meets[i]
            for name in type(alone).__dataclass_fields__:
                assert np.array_equal(getattr(alone, name), getattr(together, name)[i], equal_nan=True), case(a, b, i)


@pytest.mark.parametrize("regime", REGIMES)
@pytest.mark.parametrize("pair", RAY_PAIRS, ids=name_of)
def test_rays_hit_where_they_truly_do(pair, regime):
    """Hit or miss, and the hit point's place, are those of a solid grown or shrunk by 1e-14 at most."""
    rays, b = scenes_of(pair, regime, effort())
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


def test_an_error_of_2e_14_is_seen():
    """The tests above can fail: the truth notices an answer that is off by twice the promise."""
    a, b = scenes_of((refimpl.Box, refimpl.Box), "generic", 5)
    found = refimpl.distance(a, b).distance
    for i in range(5):
        size = truth.scene_scale(a[i], b[i])
        assert abs(truth.signed_distance(a[i], b[i]) - (float(found[i]) + 2e-14 * size)) > ACCURACY * size
