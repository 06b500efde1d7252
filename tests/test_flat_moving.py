"""Rays and sweeps of the flat world: against brute force of 50 digits, and the laws that times obey."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from mpmath import inf, mpf

import refimpl
from refimpl import RigidMotion, Translation
from refimpl.flat import ConvexPolygon, Disc, FlatPoint, FlatRay, FlatTranslation, Rectangle, Segment
from refimpl.flat.pairs import TABLE
from refimpl.proof import certify_sweep, check_sweep
from refimpl.sweeps.methods import methods_of
from tests import flat_truth
from tests.flat_scenes import REGIMES

TARGETS: list[Any] = [b for a, b in TABLE if a is FlatRay]
PAIRS: list[Any] = [pair for pair in TABLE if pair[0] is not FlatRay]


def _toward(rng: np.random.Generator, name: str, offset: Any, size: float) -> Any:
    """A way that leads to a place, exactly, nearly or hardly."""
    way = offset + rng.normal(size=2) * size * 10.0 ** rng.uniform(-17, 0) * rng.integers(0, 2)
    way = np.round(way) if name == "whole" else way
    return way if way.any() else np.array([size, 0.0])


@cache
def rays(kind: Any) -> list[tuple[Any, Any, mpf]]:
    found = []
    rng = np.random.default_rng(TARGETS.index(kind))
    for name, make in REGIMES.items():
        for _ in range(4):
            a, b = make(FlatPoint, kind, rng)
            size = max(float(a.magnitude), float(b.magnitude))
            assert isinstance(a, FlatPoint)
            ray = FlatRay(a.position, _toward(rng, name, b.reference_point - a.position, size))
            found.append((ray, b, flat_truth.ray_time(ray, b)))
    return found


def sweeps(pair: Any) -> Iterator[tuple[Any, Any, FlatTranslation, mpf]]:
    rng = np.random.default_rng(PAIRS.index(pair) + 50)
    for name, make in REGIMES.items():
        for _ in range(2):
            a, b = make(*pair, rng)
            size = max(float(a.magnitude), float(b.magnitude)) or 1.0
            offset = (a.reference_point - b.reference_point) * rng.choice([0.5, 1, 2])
            way = _toward(rng, name, offset, size)
            yield a, b, FlatTranslation(way), flat_truth.sweep_time(a, b, flat_truth.vectors(way)[0])


def miss(found: Any, true: mpf, way: Any, size: float) -> float:
    """How far a time is off, as a height over the surface that is met, as a part of the size; 1 for a wrong hit."""
    if bool(found.hit) != (true != inf):
        return 1.0
    if not found.hit:
        return 0.0
    steep = 1.0 if found.t == 0 or true == 0 else abs(float(found.normal @ way)) / float(np.hypot(*way))
    return float(abs(mpf(float(found.t)) - true) * float(np.hypot(*way)) / size) * steep


def off_shape(point: Any, shape: Any) -> float:
    """How far a point is outside of a shape."""
    (place,), (points, radius) = flat_truth.vectors(point), flat_truth.corners(shape)
    gap = flat_truth.square_gap([place], points) if flat_truth.are_apart([place], points) else 0
    return float(flat_truth.mp.sqrt(flat_truth.real(flat_truth.Fraction(gap))) - flat_truth.real(radius))


def worst_ray(change: Any, kind: Any) -> float:
    return max(
        miss(change(refimpl.raycast(ray, b)), true, ray.direction, max(float(ray.magnitude), float(b.magnitude)))
        for ray, b, true in rays(kind)
    )


@pytest.mark.parametrize("kind", TARGETS)
def test_rays_hit_when_brute_force_does(kind: Any) -> None:
    assert worst_ray(lambda found: found, kind) <= 2e-15


def test_wrong_times_and_hits_of_rays_are_seen() -> None:
    for change in (
        lambda found: replace(found, t=found.t * (1 + 1e-11)),
        lambda found: replace(found, hit=np.True_, t=np.float64(1.0)),
        lambda found: replace(found, hit=np.False_, t=np.float64(np.inf)),
    ):
        assert worst_ray(change, Disc) > 1e-12


def test_hits_of_rays_lie_on_the_surface_and_their_normals_look_out() -> None:
    rng = np.random.default_rng(8)
    seen = 0
    for kind in TARGETS:
        for _ in range(15):
            b = REGIMES["near"](FlatPoint, kind, rng)[1]
            away = 9 * rng.normal(size=2)
            found = refimpl.raycast(FlatRay(b.reference_point + away, 0.3 * rng.normal(size=2) - away), b)
            if found.hit and found.t > 0:
                seen += 1
                assert abs(refimpl.distance(FlatPoint(found.point), b).distance) <= 1e-13
                assert refimpl.support(b, found.normal) == pytest.approx(float(found.normal @ found.point), abs=1e-13)
    assert seen > 20


def test_rays_that_pass_a_corner_are_decided_exactly() -> None:
    """The corners are those of a turned square in thirds, which doubles do not have: one bit decides."""
    square = ConvexPolygon.from_vertices([(1 / 3, 0), (0, 1 / 3), (-1 / 3, 0), (0, -1 / 3)])
    for height in (np.nextafter(1 / 3, 1), 1 / 3, np.nextafter(1 / 3, 0)):
        assert refimpl.raycast(FlatRay((-5, height), (1, 0)), square).hit == (height <= 1 / 3)
    for start in (np.nextafter(1 / 3, 1), 1 / 3):
        assert refimpl.raycast(FlatRay((start, 0), (1, 0)), square).hit == (start <= 1 / 3)


@pytest.mark.parametrize("pair", PAIRS, ids=lambda p: f"{p[0].__name__}-{p[1].__name__}")
def test_sweeps_meet_when_brute_force_does_and_lie_in_their_proof(pair: Any) -> None:
    met = 0
    for a, b, motion, true in sweeps(pair):
        size = max(float(a.magnitude), float(b.magnitude), float(np.max(np.abs(motion.vector))))
        found = refimpl.sweep(a, b, None, motion)
        assert miss(found, true, motion.vector, size) <= 2e-15, (a, b, motion, float(true))
        proof = certify_sweep(a, b, None, motion)
        lower, upper = check_sweep(proof, a, b, None, motion)
        assert lower == upper or upper - lower <= 1e-12
        if true == inf:
            assert lower == inf
        else:
            met += 1
            assert float(lower) - 1e-15 <= true <= float(upper) + 1e-15
            assert found.t_lower <= found.t
            moved = b.translated(found.t * motion.vector)
            for shape in (a, moved):
                assert off_shape(found.point, shape) <= 1e-14 * size, (a, b, motion)
    assert met > 5


def test_wrong_times_of_sweeps_are_seen() -> None:
    worst = 0.0
    for a, b, motion, true in sweeps((Disc, Rectangle)):
        found = refimpl.sweep(a, b, None, motion)
        worst = max(worst, miss(replace(found, t=found.t * (1 + 1e-11)), true, motion.vector, 1.0))
    assert worst > 1e-12


def test_every_pair_of_the_flat_table_names_its_method() -> None:
    for a, b in TABLE:
        assert methods_of(a, b) == (None if a is FlatRay else ("ray cast against the difference", "–"))


def test_only_the_relative_motion_matters_and_both_orders_agree() -> None:
    rng = np.random.default_rng(9)
    a = ConvexPolygon.from_vertices(rng.integers(-2, 3, size=(40, 4, 2)))
    b = Segment(*rng.integers(4, 8, size=(2, 40, 2)), 0.5)
    way = rng.integers(-9, 3, size=(40, 2)).astype(float)
    found = refimpl.sweep(a, b, None, FlatTranslation(way))
    other = refimpl.sweep(a, b, FlatTranslation(-way / 2), FlatTranslation(way / 2))
    back = refimpl.sweep(b, a, FlatTranslation(way), None)
    assert 5 < np.sum(found.hit & (found.t > 0)) < 40
    assert np.array_equal(found.t, other.t)
    assert np.array_equal(found.t, back.t)
    assert np.array_equal(found.normal, -back.normal, equal_nan=True)
    for i in range(0, 40, 3):
        alone = refimpl.sweep(a[i], b[i], None, FlatTranslation(way[i]))
        assert np.array_equal(alone.t, found.t[i])
        assert np.array_equal(alone.point, found.point[i], equal_nan=True)


def test_a_miss_of_rounding_that_is_a_touch_is_a_contact() -> None:
    """The corner at thirds arrives, at the very end of its way, at a side that is not parallel to any axis."""
    a = ConvexPolygon.from_vertices([(-1, -1 / 3), (2, 2 / 3), (-1, 5)])
    b = FlatPoint((2.0, -1.0))
    for way in ((-2.0, 1.0), (-2.0, np.nextafter(1.0, 0))):
        true = flat_truth.sweep_time(a, b, flat_truth.vectors(np.array(way))[0])
        assert refimpl.sweep(a, b, None, FlatTranslation(way)).hit == (true != inf)
    touching = refimpl.sweep(Disc((0, 0), 1), Rectangle((2, -1), (3, 1)), None, FlatTranslation((-1, 0)))
    assert touching.hit
    assert touching.t == 1
    assert not refimpl.sweep(Disc((0, 0), 1), Rectangle((2, -1), (3, 1)), None, FlatTranslation((-0.999, 0))).hit


@pytest.mark.parametrize("motion", [Translation((1, 0, 0)), RigidMotion((0, 0, 0), (0, 0, 1), (0, 0, 0))])
def test_motions_of_space_are_refused(motion: Any) -> None:
    for ask in (refimpl.sweep, certify_sweep):
        with pytest.raises(TypeError, match="flat proxy is a FlatTranslation"):
            ask(Disc((0, 0), 1), Disc((3, 0), 1), motion)
    with pytest.raises(TypeError, match="is no FlatTranslation"):
        refimpl.sweep(refimpl.Sphere((0, 0, 0), 1), refimpl.Sphere((0, 0, 0), 1), FlatTranslation((1, 0)))
