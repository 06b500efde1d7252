"""What no pair algorithm may break, over the whole table: the laws of signed distances, drawn by Hypothesis.

Of unions that overlap, the reference knows an interval: the laws hold for the distance somewhere within, so what they
say of the ends is that no lower end of what must be less lies above an upper end of what must be more.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import assume
from hypothesis import strategies as st

from oracles.growth import grown
from refimpl import collide, compiling, distance, intersect
from refimpl.pairs import TABLE
from refimpl.proof import certify, check
from refimpl.shapes import AABB, Composite, HalfSpace, Point, Polyhedron, Proxy, Ray, ShapeError, Sphere
from tests.conftest import regimes_in_turn, scenes_of
from tests.laws import PLACES, QUATERNIONS, SMALL, UNIONS, Span, drawn, law, promise, shift, size_of, span

PAIRS = [pair for pair in TABLE if pair[0] is not Ray]
CONVEX_PAIRS = [pair for pair in PAIRS if not set(pair) & set(UNIONS)]
MOVABLE = [pair for pair in PAIRS if pair != (HalfSpace, HalfSpace)]
"""Two half-spaces have a distance only while they face exactly, which no rounded motion keeps."""
NUDGE = 1e-11
"""Part of the scene by which unions are moved beyond their free places, or shrunk there: a proof needs a gap."""


def at_most(less: Span, more: Span, slack: float, offset: float = 0.0) -> bool:
    """Whether a distance in the first interval may be no more than one in the second, plus an offset."""
    return less.low <= more.high + offset + slack


@law(PAIRS)
def test_both_orders_agree_to_the_bit(pair: Any, data: Any) -> None:
    a, b = drawn(data, pair)
    there, back = distance(a, b), distance(b, a)
    assert there.distance == back.distance
    assert bool(intersect(a, b)) == bool(intersect(b, a))
    if pair[0] is not pair[1] or not np.array_equal(a.pack(), b.pack()):
        for this, that in ((there.on_a, back.on_b), (there.on_b, back.on_a), (there.normal, -back.normal)):
            assert np.array_equal(this, that, equal_nan=True)


@law(MOVABLE, place=PLACES, quaternion=QUATERNIONS)
def test_isometries_keep_the_distance(pair: Any, data: Any, place: Any, quaternion: Any) -> None:
    """σ is the largest gap over all directions: what rounding did to both at both normals bounds what it did to σ."""
    a, b = drawn(data, pair)
    q = np.array(quaternion) if AABB not in pair else np.array([0.0, 0.0, 0.0, 1.0])
    sigma = span(a, b)
    offset = place * size_of(a, b)
    try:
        moved = [x.translated(offset) if AABB in pair else x.transformed(q, offset) for x in (a, b)]
    except ShapeError:  # a cylinder shorter than the rounding of its new place
        assume(False)
    found = span(*moved)
    normals = [(n, Point(n).rotated(q).position) for n in sigma.normals]
    normals += [(Point(n).rotated(q * [-1, -1, -1, 1]).position, n) for n in found.normals]
    slack = _slack((a, b), moved, normals, offset) + 2.0 * promise(pair) * size_of(*moved, found.low)
    assert at_most(sigma, found, slack)
    assert at_most(found, sigma, slack)


def _slack(pair: Any, images: Any, normals: Any, offset: Any, factor: float = 1.0) -> float:
    """What rounding the images of both proxies may have done to their distance."""
    facing = [(-n, -m) for n, m in normals]
    return shift(pair[0], images[0], normals, offset, factor) + shift(pair[1], images[1], facing, offset, factor)


@law(PAIRS, power=st.integers(-40, 40), factor=st.floats(0.01, 100.0))
def test_scaling_scales_the_distance(pair: Any, data: Any, power: int, factor: float) -> None:
    """By powers of two to the bit, else to rounding."""
    a, b = drawn(data, pair, SMALL if Polyhedron in pair else None)
    sigma = span(a, b)
    exact = span(a.scaled(2.0**power), b.scaled(2.0**power))
    assert (exact.low, exact.high) == (math.ldexp(sigma.low, power), math.ldexp(sigma.high, power))
    if pair not in MOVABLE:
        return
    try:
        scaled = a.scaled(factor), b.scaled(factor)
    except ShapeError:
        assume(False)
    found, expected = span(*scaled), Span(factor * sigma.low, factor * sigma.high, sigma.normals)
    normals = [(n, n) for n in (*sigma.normals, *found.normals)]
    slack = _slack((a, b), scaled, normals, np.zeros(3), factor) + 2.0 * promise(pair) * size_of(*scaled, found.low)
    assert at_most(expected, found, slack)
    assert at_most(found, expected, slack)


@law(PAIRS, place=PLACES, near=st.sampled_from((1.0, 0.25, 0.0)))
def test_no_detour_by_a_point_is_shorter(pair: Any, data: Any, place: Any, near: float) -> None:
    """σ(A, B) ≤ σ(A, p) + σ(p, B) for every point p, and |σ(p, B) − σ(q, B)| ≤ ‖p − q‖."""
    a, b = drawn(data, pair)
    size = size_of(a, b)
    p = Point(b.reference_point + near * place * size)
    to_b, sigma = span(p, b), span(a, b)
    slack = 8e-12 * size_of(a, b, sigma.low)
    if isinstance(a, Point):
        far = float(np.linalg.norm(a.position - p.position))
        assert at_most(sigma, to_b, slack, far)
        assert at_most(to_b, sigma, slack, far)
        return
    assert at_most(sigma, to_b, slack, span(a, p).high)


@law(PAIRS, by=st.floats(0.0, 1.0))
def test_growing_brings_nothing_farther(pair: Any, data: Any, by: float) -> None:
    """Neither does another part; and what a point of both was, it still is."""
    a, b = drawn(data, pair, SMALL if set(pair) & set(UNIONS) else None)
    sigma, hit = span(a, b), bool(intersect(a, b))
    larger: list[tuple[Proxy, Proxy]] = [(a, grown(b, by * b.magnitude))]
    if not isinstance(a, Point):
        larger.append((grown(a, by * a.magnitude), b))
    if set(pair) & set(UNIONS) and not isinstance(a, Point):
        larger.append((Composite([a, Sphere(b.reference_point, by * float(b.magnitude) + 1e-3)]), b))
    for pair_of_more in larger:
        found = span(*pair_of_more)
        slack = 2.0 * promise(pair) * size_of(*pair_of_more, sigma.low)
        assert at_most(found, sigma, slack)
        assert intersect(*pair_of_more) or not hit or abs(found.low) <= slack


@law(PAIRS)
def test_intersect_has_the_sign_of_the_distance(pair: Any, data: Any) -> None:
    a, b = drawn(data, pair)
    sigma = distance(a, b).distance
    if abs(sigma) > promise(pair) * size_of(a, b, sigma):
        assert bool(intersect(a, b)) == (sigma <= 0)


@law(PAIRS, share=st.floats(0.0, 1.0))
def test_safe_positions_are_proven_free(pair: Any, data: Any, share: float) -> None:
    """Certificates, checked in exact arithmetic, leave at most the rounding of the shift as an overlap."""
    a, b = drawn(data, pair)
    found = collide(a, b, inverse_mass_a=share, inverse_mass_b=1.0 - share)
    assume(math.isfinite(found.depth))
    assert np.all(found.shift_a == 0) or found.hit
    assert found.least <= found.depth
    size = size_of(a, b, found.depth)
    allowed = (2.0 * promise(pair) + 4e-15) * size
    tries = [(0.0, 0.0)]
    if set(pair) & set(UNIONS):
        tries += [(NUDGE, 0.0), (NUDGE, NUDGE)]  # the way out may graze, or slide along walls that it touches
    assert any(_proven_free(a, b, found, nudge * size, less, allowed) for nudge, less in tries)


def _proven_free(a: Proxy, b: Proxy, found: Any, nudge: float, less: float, allowed: float) -> bool:
    """Whether the shifts, lengthened by a nudge, are proven to leave no overlap but for rounding."""
    aside = nudge / 2 * np.where(np.isfinite(found.normal), found.normal, 0.0)
    try:
        free = a.translated(found.shift_a - aside), b.translated(found.shift_b + aside)
        if less:
            free = _shrunk(free[0], less), _shrunk(free[1], less)
    except ShapeError:
        assume(False)
    noise = less * size_of(a, b) + sum(
        shift(before, after, [(n, n)], after.reference_point - before.reference_point)
        for before, after, n in ((a, free[0], found.normal), (b, free[1], -found.normal))
        if not isinstance(before, HalfSpace)
    )
    lower, _ = check(certify(*free), *free)
    return bool(lower >= -allowed - noise)


def _shrunk(shape: Proxy, part: float) -> Proxy:
    """Smaller by a part of itself, where it is."""
    middle = shape.reference_point
    return shape if isinstance(shape, Point) else shape.translated(-middle).scaled(1.0 - part).translated(middle)


def test_compiled_kernels_answer_the_same_bits(monkeypatch: pytest.MonkeyPatch) -> None:
    """One function for all pairs, for the kernels are compiled once in a process."""
    pytest.importorskip("numba")
    monkeypatch.setenv("PROXYPROOF_COMPILE", "1")
    compiling._compiled_package.cache_clear()
    used = []
    original = compiling.is_compiled
    monkeypatch.setattr(compiling, "is_compiled", lambda module: used.append(original(module)) or original(module))
    for pair in CONVEX_PAIRS:
        for regime in regimes_in_turn(pair):
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
