"""Exact vectors, and the proxies as hulls of a few rational points.

This reading of the shapes is another one than the checker's, so that a mistake in either shows.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from refimpl.flat.shapes import Disc, Rectangle, Segment
from refimpl.proof.claims import Bound
from refimpl.shapes import AABB, Box, Capsule, Point, Proxy, Sphere

Vector = tuple[Any, Any, Any]
ZERO = (0, 0, 0)
AXES = [(1, 0, 0), (0, 1, 0), (0, 0, 1)]


def dot(u: Vector, v: Vector) -> Any:
    """Scalar product."""
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


def cross(u: Vector, v: Vector) -> Vector:
    """Vector product."""
    return u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]


def along(start: Vector, factor: Any, way: Vector) -> Vector:
    """Point start + factor·way."""
    return start[0] + factor * way[0], start[1] + factor * way[1], start[2] + factor * way[2]


def minus(u: Vector, v: Vector) -> Vector:
    """Difference."""
    return u[0] - v[0], u[1] - v[1], u[2] - v[2]


def opposite(v: Vector) -> Vector:
    """Give −v."""
    return -v[0], -v[1], -v[2]


def root(square: Fraction, bits: int = 160) -> tuple[Fraction, Fraction]:
    """Square root from below and above, with about `bits` leading bits; both are equal when it is rational."""
    radicand = square.numerator * square.denominator
    shift = max(0, bits - radicand.bit_length() // 2)
    radicand <<= 2 * shift
    whole, scale = math.isqrt(radicand), square.denominator << shift
    return Fraction(whole, scale), Fraction(whole + (whole * whole < radicand), scale)


def exact(v: Sequence[Any]) -> Vector:
    """Three numbers as rationals."""
    return Fraction(v[0]), Fraction(v[1]), Fraction(v[2])


def doubles(point: Vector) -> Vector:
    """Nearest doubles; the point itself when it exceeds them."""
    try:
        return float(point[0]), float(point[1]), float(point[2])
    except OverflowError:
        return point


def rationals(array: Any) -> Any:
    """Exact numbers of a field; a vector of two lies in the plane z = 0."""
    numbers = tuple(Fraction(x) for x in array.tolist())
    return (*numbers, Fraction(0)) if len(numbers) == 2 else numbers


def frame(box: AABB | Box) -> tuple[Vector, Vector, tuple[Vector, Vector, Vector]]:
    """Centre, half extents, and axes of length 1."""
    if isinstance(box, AABB):
        low, high = rationals(box.lower), rationals(box.upper)
        half = along(ZERO, Fraction(1, 2), minus(high, low))
        return along(low, 1, half), half, (AXES[0], AXES[1], AXES[2])
    return rationals(box.center), rationals(box.half_extents), turned(box.rotation)


def turned(rotation: Any) -> tuple[Vector, Vector, Vector]:
    """Columns of the rotation matrix of a quaternion."""
    *v, w = rationals(rotation)
    columns = []
    for i, e in enumerate(AXES):  # (w² + v²) R e = (w² − v²) e + 2 (v·e) v + 2 w v × e
        image = along(along(ZERO, w * w - dot(v, v), e), 2 * v[i], v)
        columns.append(along(ZERO, 1 / (w * w + dot(v, v)), along(image, 2 * w, cross(v, e))))
    return columns[0], columns[1], columns[2]


def core(shape: Proxy) -> tuple[list[Vector], Fraction]:
    """Points whose hull, widened by a ball, is the bounded `shape`; and that ball's radius."""
    match shape:
        case Point():
            return [rationals(shape.position)], Fraction(0)
        case Sphere() | Disc():
            return [rationals(shape.center)], Fraction(shape.radius.tolist())
        case Rectangle():
            low, high = rationals(shape.lower), rationals(shape.upper)
            return list({(x, y, Fraction(0)): 1 for x in (low[0], high[0]) for y in (low[1], high[1])}), Fraction(0)
        case Capsule() | Segment():
            return list({rationals(shape.p): 1, rationals(shape.q): 1}), Fraction(shape.radius.tolist())
        case AABB() | Box():
            centre, half, axes = frame(shape)
            corners = [centre]
            for h, axis in zip(half, axes, strict=True):
                corners = [along(c, s, axis) for c in corners for s in {h: 1, -h: 1}]  # one where flat
            return corners, Fraction(0)
    raise TypeError(f"{type(shape).__name__} is not the hull of points")


def round_down(bound: Bound) -> float:
    """Largest double that is not above `bound`."""
    try:
        nearest = float(bound)
    except OverflowError:
        nearest = math.inf if bound > 0 else -math.inf
    return math.nextafter(nearest, -math.inf) if nearest > bound else nearest


def round_up(bound: Bound) -> float:
    """Smallest double that is not below `bound`."""
    return -round_down(-bound)
