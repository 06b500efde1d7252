"""Where a ray first hits a proxy, in exact rational arithmetic; irrational times are enclosed.

Nothing here has to be believed: what is found is handed on as a certificate.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import NamedTuple

from refimpl.proof.exact import Difference, nearest
from refimpl.proof.points import Vector, along, core, cross, dot, frame, minus, opposite, rationals, root
from refimpl.shapes import AABB, Box, HalfSpace, Proxy, Ray


class Miss(NamedTuple):
    """The planes normal to `normal`, a direction from the ray to the proxy, have the whole ray on one side."""

    normal: Vector


class Hit(NamedTuple):
    """The first hit is at a time from `low` to `high`, and at `within` the ray is inside.

    `normal(t)` is a direction from the ray to the proxy that separates them up to any time t before the hit.
    """

    low: Fraction
    high: Fraction
    within: Fraction
    normal: Callable[[Fraction], Vector]


def cast(ray: Ray, shape: Proxy) -> Hit | Miss:
    """Find the first hit of a ray."""
    origin, way = rationals(ray.origin), rationals(ray.direction)
    if isinstance(shape, HalfSpace):
        return _plane(origin, way, shape)
    points, radius = core(shape)
    reach = max(Fraction(0), *(dot(minus(point, origin), way) / dot(way, way) for point in points))
    path = list({origin: 1, along(origin, reach, way): 1})  # no point of the core is nearest to a later one
    found = nearest(Difference(path, points))
    ((on_ray, on_shape),) = found.pairs
    gap = minus(on_ray, on_shape)
    if dot(gap, gap) > radius * radius:
        return Miss(found.normal)
    if isinstance(shape, AABB | Box):
        return _slabs(origin, way, shape)
    hit = tube(origin, way, points[0], points[-1], radius)
    assert hit is not None, "a ray that comes within the radius of the segment hits"
    return hit


def moment(time: Fraction, normal: Vector) -> Hit:
    """Give a hit at a rational time, at a plane."""
    return Hit(time, time, time, lambda _: normal)


def _plane(origin: Vector, way: Vector, half: HalfSpace) -> Hit | Miss:
    n, k = rationals(half.normal), Fraction(half.k.tolist())
    inwards = opposite(tuple(half.normal.tolist()))
    height = dot(n, origin) + k
    if height > 0 and dot(n, way) >= 0:
        return Miss(inwards)
    return moment(-height / dot(n, way) if height > 0 else Fraction(0), inwards)


def _slabs(origin: Vector, way: Vector, box: AABB | Box) -> Hit:
    """Last entry into a slab between two parallel faces, for a ray that is known to hit (Kay and Kajiya 1986)."""
    centre, half, axes = frame(box)
    last, normal = Fraction(0), axes[0]
    for h, axis in zip(half, axes, strict=True):
        rate = dot(axis, way)
        if rate:
            inwards = axis if rate > 0 else opposite(axis)
            entry = (dot(inwards, minus(centre, origin)) - h) / abs(rate)
            if entry > last:
                last, normal = entry, inwards
    return moment(last, normal)


def tube(origin: Vector, way: Vector, p: Vector, q: Vector, radius: Fraction) -> Hit | None:
    """First entry into a capsule, if there is one: around p, around the segment's line, around q.

    The square distance from the segment is a convex function of time, made of a quadratic for each of the
    intervals in which the nearest point is p, between both, or q.
    """
    edge, start = minus(q, p), minus(origin, p)
    square, rate, place = dot(edge, edge), dot(edge, way), dot(edge, start)

    def normal(time: Fraction) -> Vector:
        share = min(max((place + time * rate) / square, Fraction(0)), Fraction(1)) if square else 0
        return minus(along(p, share, edge), along(origin, time, way))

    changes = {(end - place) / rate for end in (0, square) if rate}
    times = sorted({Fraction(0)} | {time for time in changes if time > 0})
    for time, end in zip(times, [*times[1:], None], strict=True):
        middle = place + rate * (time + 1 if end is None else (time + end) / 2)
        if 0 < middle < square:
            u, v, limit = cross(way, edge), cross(along(start, time, way), edge), radius * radius * square
        else:
            u, v, limit = way, minus(along(origin, time, way), p if middle <= 0 else q), radius * radius
        # the ray is inside t after `time` where a t² + 2 b t + c ≤ 0, as long as it is in this interval
        a, b, c = dot(u, u), dot(u, v), dot(v, v) - limit
        if c <= 0:
            return Hit(time, time, time, normal)
        if b < 0 <= b * b - a * c:
            low, high = (c / (r - b) for r in reversed(root(b * b - a * c)))
            lowest = -b / a if end is None else min(-b / a, end - time)
            if (a * lowest + 2 * b) * lowest + c <= 0:
                return Hit(time + low, time + high, time + lowest, normal)
    return None
