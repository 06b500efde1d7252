"""What no pair algorithm may break, over the whole table: the laws of signed distances, drawn by Hypothesis."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from mpmath import mp, mpf  # type: ignore[import-untyped]

from oracles.regimes import REGIMES
from oracles.scene import DISTANCE, Cell
from oracles.strategies import scenes
from refimpl import bounds, collide, compiling, distance, intersect
from refimpl.linear import dot, largest
from refimpl.pairs import ITERATIVE, TABLE
from refimpl.proof import certify, check
from refimpl.shapes import AABB, HalfSpace, Point, Proxy, Ray, ShapeError
from tests.conftest import name_of, scenes_of
from tests.growth import GROW, grown
from tests.truth.bodies import body_of
from tests.truth.rationals import DIGITS, real

CONVEX = {Point, *GROW}
PAIRS = [pair for pair in TABLE if pair[0] is not Ray]
CONVEX_PAIRS = [pair for pair in PAIRS if set(pair) <= CONVEX]
MOVABLE = [pair for pair in CONVEX_PAIRS if pair != (HalfSpace, HalfSpace)]
"""Two half-spaces have a distance only while they face exactly, which no rounded motion keeps."""
BOUNDED = [kind for kind in (Point, *GROW) if kind is not HalfSpace]
EXAMPLES = settings.default.max_examples if settings.default else 20
FEW = settings(max_examples=max(EXAMPLES * 2 // 5, 1))
"""Scenes for each pair and law: there are hundreds of both."""
UNIT = st.tuples(*[st.floats(-1.0, 1.0, allow_subnormal=False)] * 3).filter(lambda v: max(map(abs, v)) > 0.01)
PLACES = st.tuples(*[st.floats(-3.0, 3.0, allow_subnormal=False)] * 3).map(np.array)
QUATERNIONS = st.tuples(*[st.floats(-1.0, 1.0, allow_subnormal=False)] * 4).filter(lambda v: max(map(abs, v)) > 0.01)


def promise(pair: tuple[type, type]) -> float:
    """Error that the exactness class of a pair allows, relative to the scene."""
    return 1e-12 if TABLE[pair].exactness == ITERATIVE else 1e-14


def size_of(a: Proxy, b: Proxy, sigma: Any = 0.0) -> float:
    finite = abs(float(sigma)) if math.isfinite(sigma) else 0.0
    return float(max(a.magnitude, b.magnitude, finite)) or 1.0


def drawn(data: Any, pair: tuple[type, type]) -> tuple[Proxy, Proxy]:
    """Draw a scene; numbers that rounding left without a set are none."""
    try:
        scene = data.draw(scenes(Cell(DISTANCE, *pair)))
    except ShapeError:
        assume(False)
    return scene.a, scene.b


@pytest.mark.parametrize("pair", PAIRS, ids=name_of)
@FEW
@given(data=st.data())
def test_both_orders_agree_to_the_bit(pair: Any, data: Any) -> None:
    a, b = drawn(data, pair)
    there, back = distance(a, b), distance(b, a)
    assert there.distance == back.distance
    assert bool(intersect(a, b)) == bool(intersect(b, a))
    if pair[0] is not pair[1] or not np.array_equal(a.pack(), b.pack()):
        for this, that in ((there.on_a, back.on_b), (there.on_b, back.on_a), (there.normal, -back.normal)):
            assert np.array_equal(this, that, equal_nan=True)


def _shift(before: Proxy, after: Proxy, n: Any, m: Any, offset: Any, factor: float = 1.0) -> float:
    """By how much rounding moved a support plane with the image: |h(image, m) − (factor·h(shape, n) + offset·m)|."""
    if isinstance(before, HalfSpace):
        return 4.0 * 2.0**-52 * float(before.magnitude * factor + largest(offset) + after.magnitude)
    moved = bounds.support(after, m) - (factor * bounds.support(before, n) + dot(offset, m))
    return abs(float(moved))


@pytest.mark.parametrize("pair", MOVABLE, ids=name_of)
@FEW
@given(data=st.data(), place=PLACES, quaternion=QUATERNIONS)
def test_isometries_keep_the_distance(pair: Any, data: Any, place: Any, quaternion: Any) -> None:
    """σ is the largest gap over all directions: what rounding did to both at both normals bounds what it did to σ."""
    a, b = drawn(data, pair)
    q = np.array(quaternion) if AABB not in pair else np.array([0.0, 0.0, 0.0, 1.0])
    sigma = distance(a, b)
    offset = place * size_of(a, b)
    try:
        moved = [x.translated(offset) if AABB in pair else x.transformed(q, offset) for x in (a, b)]
    except ShapeError:  # a cylinder shorter than the rounding of its new place
        assume(False)
    found = distance(*moved)
    normals = [
        (n, Point(n).rotated(q).position)
        for n in (sigma.normal, Point(found.normal).rotated(q * [-1, -1, -1, 1]).position)
    ]
    slack = sum(
        _shift(before, after, sign * n, sign * m, offset)
        for n, m in normals
        for before, after, sign in ((a, moved[0], 1.0), (b, moved[1], -1.0))
    )
    size = size_of(*moved, found.distance)
    assert abs(found.distance - sigma.distance) <= slack + 2.0 * promise(pair) * size


@pytest.mark.parametrize("pair", CONVEX_PAIRS, ids=name_of)
@FEW
@given(data=st.data(), power=st.integers(-40, 40), factor=st.floats(0.01, 100.0))
def test_scaling_scales_the_distance(pair: Any, data: Any, power: int, factor: float) -> None:
    """By powers of two to the bit, else to rounding."""
    a, b = drawn(data, pair)
    sigma = distance(a, b)
    exact = distance(a.scaled(2.0**power), b.scaled(2.0**power))
    assert exact.distance == np.ldexp(sigma.distance, power)
    if pair not in MOVABLE:
        return
    try:
        scaled = a.scaled(factor), b.scaled(factor)
    except ShapeError:
        assume(False)
    found = distance(*scaled)
    zero = np.zeros(3)
    slack = sum(
        _shift(before, after, sign * n, sign * n, zero, factor)
        for n in (sigma.normal, found.normal)
        for before, after, sign in ((a, scaled[0], 1.0), (b, scaled[1], -1.0))
    )
    assert abs(found.distance - factor * sigma.distance) <= slack + 2.0 * promise(pair) * size_of(
        *scaled, found.distance
    )


@pytest.mark.parametrize("pair", CONVEX_PAIRS, ids=name_of)
@FEW
@given(data=st.data(), place=PLACES)
def test_no_detour_by_a_point_is_shorter(pair: Any, data: Any, place: Any) -> None:
    """σ(A, B) ≤ σ(A, p) + σ(p, B) for every point p, and |σ(p, B) − σ(q, B)| ≤ ‖p − q‖."""
    a, b = drawn(data, pair)
    size = size_of(a, b)
    p = Point(b.reference_point + place * size)
    to_b = distance(p, b)
    if pair[0] is Point:
        assert (
            abs(distance(a, b).distance - to_b.distance)
            <= np.linalg.norm(a.reference_point - p.position) + 8e-12 * size
        )
        return
    sigma = distance(a, b).distance
    assert sigma <= distance(a, p).distance + to_b.distance + 8e-12 * size_of(a, b, sigma)


@pytest.mark.parametrize("pair", CONVEX_PAIRS, ids=name_of)
@FEW
@given(data=st.data(), by=st.floats(0.0, 1.0))
def test_growing_brings_nothing_farther(pair: Any, data: Any, by: float) -> None:
    a, b = drawn(data, pair)
    sigma = distance(a, b).distance
    for larger in [(a, grown(b, by * b.magnitude))] + (
        [(grown(a, by * a.magnitude), b)] if pair[0] is not Point else []
    ):
        found = distance(*larger).distance
        assert found <= sigma + 2.0 * promise(pair) * size_of(*larger, sigma)


@pytest.mark.parametrize("pair", PAIRS, ids=name_of)
@FEW
@given(data=st.data())
def test_intersect_has_the_sign_of_the_distance(pair: Any, data: Any) -> None:
    a, b = drawn(data, pair)
    sigma = distance(a, b).distance
    if abs(sigma) > promise(pair) * size_of(a, b, sigma):
        assert bool(intersect(a, b)) == (sigma <= 0)


@pytest.mark.parametrize("pair", CONVEX_PAIRS, ids=name_of)
@FEW
@given(data=st.data(), share=st.floats(0.0, 1.0))
def test_safe_positions_are_proven_free(pair: Any, data: Any, share: float) -> None:
    """Certificates, checked in exact arithmetic, leave at most the rounding of the shift as an overlap."""
    a, b = drawn(data, pair)
    found = collide(a, b, inverse_mass_a=share, inverse_mass_b=1.0 - share)
    assume(math.isfinite(found.depth))
    assert np.all(found.shift_a == 0) or found.hit
    try:
        free = a.translated(found.shift_a), b.translated(found.shift_b)
    except ShapeError:
        assume(False)
    lower, _ = check(certify(*free), *free)
    assert lower >= -(2.0 * promise(pair) + 4e-15) * size_of(a, b, found.depth) - _translation_noise(
        a, b, free, found.normal
    )


def _translation_noise(a: Proxy, b: Proxy, free: tuple[Proxy, Proxy], n: Any) -> float:
    """What rounding the places of the moved proxies did to their support planes."""
    noise = 0.0
    for before, after, sign in ((a, free[0], 1.0), (b, free[1], -1.0)):
        if not isinstance(before, HalfSpace):
            offset = after.reference_point - before.reference_point
            noise += abs(
                float(bounds.support(after, sign * n) - bounds.support(before, sign * n) - dot(offset, sign * n))
            )
    return noise


@pytest.mark.parametrize("kind", BOUNDED, ids=name_of)
@FEW
@given(data=st.data(), direction=UNIT)
def test_bounding_volumes_contain_and_supports_agree(kind: Any, data: Any, direction: Any) -> None:
    """Containment is exact; the support function is held against 60 digits."""
    pair = next(p for p in TABLE if kind in p and p[0] is not Ray)
    shape = next(x for x in drawn(data, pair) if isinstance(x, kind))
    body, box, ball = body_of(shape), bounds.aabb(shape), bounds.bounding_sphere(shape)
    with mp.workdps(DIGITS):
        for i, axis in enumerate([(1, 0, 0), (0, 1, 0), (0, 0, 1)]):
            back = tuple(-x for x in axis)
            assert body.support(axis) + real(body.radius) <= mpf(float(box.upper[i]))
            assert -(body.support(back) + real(body.radius)) >= mpf(float(box.lower[i]))
        n = tuple(mpf(float(x)) for x in direction)
        length = mp.sqrt(sum(x * x for x in n))
        h = body.support(n) + real(body.radius) * length
        center = sum(mpf(float(c)) * x for c, x in zip(ball.center, n, strict=True))
        assert h <= center + mpf(float(ball.radius)) * length
        size = float(shape.magnitude) or 1.0
        assert abs(h - float(bounds.support(shape, direction))) <= 1e-14 * size * float(length) * 3
        for corner in body.points if body.ellipsoid is None else ():
            offset = [real(x) - mpf(float(c)) for x, c in zip(corner, ball.center, strict=True)]
            assert mp.sqrt(sum(x * x for x in offset)) + real(body.radius) <= mpf(float(ball.radius))


def test_compiled_kernels_answer_the_same_bits(monkeypatch: pytest.MonkeyPatch) -> None:
    """One function for all pairs, for the kernels are compiled once in a process."""
    pytest.importorskip("numba")
    monkeypatch.setenv("PROXYPROOF_COMPILE", "1")
    compiling._compiled_package.cache_clear()
    used = []
    original = compiling.is_compiled
    monkeypatch.setattr(compiling, "is_compiled", lambda module: used.append(original(module)) or original(module))
    for pair in CONVEX_PAIRS:
        for regime in REGIMES:
            a, b = scenes_of(pair, regime, 12)
            answers = []
            for rows in (10**9, 1):
                compiling._in_use.clear()
                monkeypatch.setattr(compiling, "WORTH_COMPILING", rows)
                answers.append((distance(a, b), intersect(a, b)))
            (interpreted, hit), (compiled, again) = answers
            for name in ("distance", "on_a", "on_b", "normal"):
                assert np.array_equal(getattr(interpreted, name), getattr(compiled, name), equal_nan=True), (
                    pair,
                    regime,
                )
            assert np.array_equal(hit, again)
    compiling._compiled_package.cache_clear()
    assert any(used)
    assert not all(used)
