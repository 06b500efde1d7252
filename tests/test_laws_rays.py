"""What no raycast may break, over the whole table: the laws of first hits, drawn by Hypothesis.

Near grazing, rounding moves the time of a hit by much more than a point from the surface. So the laws are stated in
space: a time claims that the segment before it is free, and that the point there is on the surface.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from hypothesis import assume
from hypothesis import strategies as st

from oracles.claimed_shapes import past
from oracles.growth import grown
from refimpl import bounds, intersect, raycast
from refimpl.pairs import TABLE
from refimpl.shapes import AABB, Capsule, HalfSpace, Point, Polyhedron, Proxy, Ray, ShapeError
from tests.laws import PLACES, QUATERNIONS, SMALL, UNIONS, drawn, law, shift, size_of, span

PAIRS = [pair for pair in TABLE if pair[0] is Ray]
ROUNDING = 4e-12
"""Part of the scene by which a computed hit may lie off the surface, with what moving and rounding the ray adds."""
STILL = np.array([0.0, 0.0, 0.0, 1.0])


def cast(ray: Ray, b: Proxy) -> float:
    """First time of a hit, in units of the direction's length; inf on a miss."""
    return float(raycast(ray, b).t)


def end_of(ray: Ray, b: Proxy) -> float:
    """A time by which the ray is past anything of a bounded solid."""
    return float(past(ray[None], b[None])[0])


def _segment(ray: Ray, t: float) -> Capsule:
    return Capsule(ray.origin, ray.at(np.float64(t)), 0.0)


def _size(ray: Ray, b: Proxy, t: float = 0.0) -> float:
    end = np.abs(ray.at(np.float64(t))).max() if math.isfinite(t) else 0.0
    return max(size_of(ray, b), float(end), float(np.linalg.norm(ray.direction)))


def free_until(ray: Ray, b: Proxy, t: float, slack: float = 0.0) -> bool:
    """Whether a ray is free of a solid before a time, but for rounding."""
    until = min(t, end_of(ray, b))
    return until == 0 or span(_segment(ray, until), b).high >= -slack - ROUNDING * _size(ray, b, until)


def arrived(ray: Ray, b: Proxy, t: float, slack: float = 0.0) -> bool:
    """Whether a ray has met a solid by a time, but for rounding; inf says that it never does."""
    return math.isinf(t) or span(Point(ray.at(np.float64(t))), b).low <= slack + ROUNDING * _size(ray, b, t)


@law(PAIRS)
def test_both_orders_agree_to_the_bit(pair: Any, data: Any) -> None:
    ray, b = drawn(data, pair)
    there, back = raycast(ray, b), raycast(b, ray)
    for name in ("hit", "t", "point", "normal"):
        assert np.array_equal(getattr(there, name), getattr(back, name), equal_nan=True)
    assert bool(intersect(ray, b)) == bool(intersect(b, ray)) == bool(there.hit)


@law(PAIRS)
def test_a_hit_is_the_first_point_of_the_solid(pair: Any, data: Any) -> None:
    """Free before, arrived then, no sooner than the distance from the start allows; and by the sign of the distance."""
    ray, b = drawn(data, pair)
    t, start = cast(ray, b), span(Point(ray.origin), b)
    allowed = ROUNDING * _size(ray, b, t)
    assert free_until(ray, b, t)
    assert arrived(ray, b, t)
    assert t * np.linalg.norm(ray.direction) >= start.low - allowed
    assert t == 0 or start.high >= -allowed
    end = end_of(ray, b)
    whole = span(_segment(ray, max(end, t) if math.isfinite(t) else end), b)
    if abs(whole.high) > allowed:
        assert math.isfinite(t) == (whole.high < 0)


@law(PAIRS, place=PLACES, quaternion=QUATERNIONS)
def test_isometries_keep_the_hit(pair: Any, data: Any, place: Any, quaternion: Any) -> None:
    """What is hit in one scene first is so in the other: each time is tried in the other's space."""
    ray, b = drawn(data, pair)
    q = STILL if AABB in pair else np.array(quaternion)
    offset = place * size_of(ray, b)
    try:
        ray_there, b_there = (x.translated(offset) if AABB in pair else x.transformed(q, offset) for x in (ray, b))
    except ShapeError:
        assume(False)
    t, there = cast(ray, b), cast(ray_there, b_there)
    back = q * [-1, -1, -1, 1]
    ends = [
        Point(n) for n in span(_segment(ray_there, min(there, float(past(ray[None], b[None])[0]))), b_there).normals
    ]
    normals = [(-end.rotated(back).position, -end.position) for end in ends]
    slack = shift(b, b_there, normals, offset)
    for one, other, time in ((ray, b, there), (ray_there, b_there, t)):
        assert free_until(one, other, time, slack + ROUNDING * size_of(ray_there, b_there))
        assert arrived(one, other, time, slack + ROUNDING * size_of(ray_there, b_there))


@law(PAIRS, power=st.integers(-40, 40))
def test_scaling_by_powers_of_two_keeps_the_time_to_the_bit(pair: Any, data: Any, power: int) -> None:
    ray, b = drawn(data, pair, SMALL if Polyhedron in pair else None)
    found, scaled = raycast(ray, b), raycast(ray.scaled(2.0**power), b.scaled(2.0**power))
    assert scaled.t == found.t
    assert np.array_equal(scaled.point, np.ldexp(found.point, power), equal_nan=True)
    assert np.array_equal(scaled.normal, found.normal, equal_nan=True)


@law(PAIRS, by=st.floats(0.0, 1.0))
def test_what_is_larger_is_hit_no_later(pair: Any, data: Any, by: float) -> None:
    """Grown shapes, and bounding volumes: before they are hit, what they hold is not."""
    ray, b = drawn(data, pair, SMALL if set(pair) & set(UNIONS) else None)
    larger = [grown(b, by * b.magnitude)]
    if not isinstance(b, HalfSpace):
        larger += [bounds.aabb(b), bounds.bounding_sphere(b)]
    for around in larger:
        assert free_until(ray, b, cast(ray, around))
        t = cast(ray, b)
        assert arrived(ray, around, t)
