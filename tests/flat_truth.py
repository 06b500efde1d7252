"""The flat world by brute force: Fractions, and roots of 50 digits; no hull, no Minkowski difference, no order.

Every proxy is its corners, in any order and with any number of others between them, widened by a radius. The segments
between any two of them lie in it; the sides are those that have all others on one hand.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from functools import lru_cache
from itertools import combinations
from typing import Any

from mpmath import inf, mp, mpf

Place = tuple[Fraction, Fraction]


def minus(u: Place, v: Place) -> Place:
    return u[0] - v[0], u[1] - v[1]


def plus(u: Place, factor: Fraction, v: Place) -> Place:
    return u[0] + factor * v[0], u[1] + factor * v[1]


def dot(u: Place, v: Place) -> Fraction:
    return u[0] * v[0] + u[1] * v[1]


def cross(u: Place, v: Place) -> Fraction:
    return u[0] * v[1] - u[1] * v[0]


def real(x: Fraction) -> mpf:
    return mpf(x.numerator) / x.denominator


def length(v: Place) -> mpf:
    return mp.sqrt(real(dot(v, v)))


def vectors(array: Any) -> list[Place]:
    return [(Fraction(x), Fraction(y)) for x, y in array.reshape(-1, 2).tolist()]


def corners(shape: Any) -> tuple[list[Place], Fraction]:
    """Points whose hull, widened by a disc, is the shape; and its radius."""
    none = Fraction(0)
    match type(shape).__name__:
        case "FlatPoint":
            return vectors(shape.position), none
        case "Disc":
            return vectors(shape.center), Fraction(float(shape.radius))
        case "Segment":
            return vectors(shape.p) + vectors(shape.q), Fraction(float(shape.radius))
        case "Rectangle":
            (left, low), (right, high) = vectors(shape.lower)[0], vectors(shape.upper)[0]
            return [(x, y) for x in (left, right) for y in (low, high)], none
    if shape.given == "vertices":
        return vectors(shape.numbers), none
    return corners_of_lines([tuple(map(Fraction, line)) for line in shape.numbers.tolist()]), none


def corners_of_lines(lines: list[tuple[Fraction, ...]]) -> list[Place]:
    """Points that two lines (n_x, n_y, k) share, and that lie behind all."""
    found = []
    for (a, b, j), (c, d, k) in combinations(lines, 2):
        area = a * d - b * c
        if area:
            x, y = (b * k - d * j) / area, (c * j - a * k) / area
            if all(u * x + v * y + w <= 0 for u, v, w in lines):
                found.append((x, y))
    return found


def ways(points: list[Place], others: list[Place]) -> Iterator[Place]:
    """Directions across and along sides, both ways, and between corners, of which one is alone."""
    for p, q in [*segments(points), *segments(others)]:
        x, y = minus(q, p)
        yield from ((x, y), (-x, -y), (y, -x), (-y, x))
    for p in points if min(len(set(points)), len(set(others))) == 1 else []:
        for q in others:
            x, y = minus(q, p)
            yield from ((x, y), (-x, -y))


def room(n: Place, points: list[Place], others: list[Place]) -> Fraction:
    """Gap between the supporting lines across n, times its length."""
    return min(dot(n, q) for q in others) - max(dot(n, p) for p in points)


def off_segment(x: Place, p: Place, q: Place) -> Place:
    """From a point to the nearest one of a segment."""
    step = minus(q, p)
    square = dot(step, step)
    share = min(max(dot(minus(x, p), step) / square, Fraction(0)), Fraction(1)) if square else Fraction(0)
    return minus(plus(p, share, step), x)


def segments(points: list[Place]) -> list[tuple[Place, Place]]:
    """Sides of the hull; where all corners are in line, every segment between two of them."""
    return _sides(tuple(dict.fromkeys(points)))


@lru_cache(maxsize=64)
def _sides(points: tuple[Place, ...]) -> list[tuple[Place, Place]]:
    found = []
    for p, q in combinations(points, 2):
        turns = [cross(minus(q, p), minus(x, p)) for x in points]
        if min(turns) >= 0 or max(turns) <= 0:
            found.append((p, q))
    return found or [(points[0], points[0])]


def square_gap(points: list[Place], others: list[Place]) -> Fraction:
    """Square of the least distance of a corner of one from a segment of the other."""
    gaps = [off_segment(x, p, q) for x in points for p, q in segments(others)]
    gaps += [off_segment(x, p, q) for x in others for p, q in segments(points)]
    return min(dot(gap, gap) for gap in gaps)


def are_apart(points: list[Place], others: list[Place]) -> bool:
    return any(any(n) and room(n, points, others) > 0 for n in ways(points, others))


def signed_distance(a: Any, b: Any) -> mpf:
    """Gap; or minus the least room that a supporting line has across what could be a side."""
    (points, r), (others, s) = corners(a), corners(b)
    if are_apart(points, others):
        return mp.sqrt(real(square_gap(points, others))) - real(r + s)
    sides = {minus(q, p) for p, q in [*segments(points), *segments(others)] if p != q}
    deep = [real(room((side * y, -side * x), points, others)) / length((x, y)) for x, y in sides for side in (1, -1)]
    return max(deep, default=mpf(0)) - real(r + s)


def entry(start: Place, way: Place, p: Place, q: Place, radius: Fraction) -> mpf:
    """First time t ≥ 0 at which start + t·way is within a radius of a segment, if it starts outside."""
    times = []
    edge, offset = minus(q, p), minus(start, p)
    speed, square = cross(edge, way), dot(edge, edge)
    for side in (1, -1):
        if speed:
            t = (side * real(radius) * mp.sqrt(real(square)) - real(cross(edge, offset))) / real(speed)
            along = real(dot(offset, edge)) + t * real(dot(way, edge))
            if radius == 0:
                exactly = dot(offset, edge) - dot(way, edge) * cross(edge, offset) / speed
                times += [t] if 0 <= exactly <= square else []
            elif 0 <= along <= real(square):
                times.append(t)
    for end in (p, q):
        out = minus(start, end)
        a, b, c = dot(way, way), dot(out, way), dot(out, out) - radius * radius
        if b * b >= a * c:
            times.append((-real(b) - mp.sqrt(real(b * b - a * c))) / real(a))
    return min((t for t in times if t >= 0), default=inf)


def ray_time(ray: Any, b: Any) -> mpf:
    """First time of a ray in a shape."""
    (start,), (way,), (points, radius) = vectors(ray.origin), vectors(ray.direction), corners(b)
    if not are_apart([start], points) or square_gap([start], points) <= radius * radius:
        return mpf(0)
    return min(entry(start, way, p, q, radius) for p, q in segments(points))


def sweep_time(a: Any, b: Any, way: Place) -> mpf:
    """First time from 0 to 1 at which B, moving by `way`, meets A: of a corner of one and a segment of the other."""
    (points, r), (others, s) = corners(a), corners(b)
    if not are_apart(points, others) or square_gap(points, others) <= (r + s) ** 2:
        return mpf(0)
    if not any(way):
        return inf
    back = -way[0], -way[1]
    times = [entry(x, way, p, q, r + s) for x in others for p, q in segments(points)]
    times += [entry(x, back, p, q, r + s) for x in points for p, q in segments(others)]
    return min((t for t in times if t <= 1), default=inf)
