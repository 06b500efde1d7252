"""Vectors of exact numbers: rationals, or integers after a common denominator has been taken out."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from fractions import Fraction
from typing import Any

from mpmath import mpf  # type: ignore[import-untyped]

DIGITS = 60
Vector = tuple[Any, Any, Any]
Matrix = tuple[Vector, Vector, Vector]
UNIT_VECTORS: Matrix = ((1, 0, 0), (0, 1, 0), (0, 0, 1))


def number(x: Any) -> Fraction:
    """The rational number that a double is."""
    return Fraction(float(x))


def vector(v: Any) -> Vector:
    """Three doubles as rationals."""
    x, y, z = v
    return number(x), number(y), number(z)


def real(x: Any) -> mpf:
    """An exact number rounded to the working precision."""
    return mpf(x.numerator) / x.denominator if isinstance(x, Fraction) else mpf(x)


def dot(u: Vector, v: Vector) -> Any:
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


def cross(u: Vector, v: Vector) -> Vector:
    return u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]


def plus(u: Vector, v: Vector) -> Vector:
    return u[0] + v[0], u[1] + v[1], u[2] + v[2]


def minus(u: Vector, v: Vector) -> Vector:
    return u[0] - v[0], u[1] - v[1], u[2] - v[2]


def scaled(factor: Any, v: Vector) -> Vector:
    return factor * v[0], factor * v[1], factor * v[2]


def opposite(v: Vector) -> Vector:
    return -v[0], -v[1], -v[2]


def applied(matrix: Matrix, v: Vector) -> Vector:
    return dot(matrix[0], v), dot(matrix[1], v), dot(matrix[2], v)


def across(e: Vector, w: Vector) -> Vector:
    """The part of w at right angles to e, times e·e, so that integers stay integers."""
    return minus(scaled(dot(e, e), w), scaled(dot(e, w), e))


def perpendicular(e: Vector) -> Vector:
    """Some vector at right angles to e ≠ 0, not zero."""
    axis = min(UNIT_VECTORS, key=lambda u: abs(dot(u, e)))
    return cross(axis, e)


def rotated(quaternion: Any, v: Vector) -> Vector:
    """Turn v by the quaternion (u, w): ((w² − u·u) v + 2(u·v) u + 2w u×v) / (w² + u·u)."""
    x, y, z, w = (number(component) for component in quaternion)
    u = (x, y, z)
    turned = plus(scaled(w * w - dot(u, u), v), scaled(2 * dot(u, v), u))
    return scaled(1 / (w * w + dot(u, u)), plus(turned, scaled(2 * w, cross(u, v))))


def sum_product(u: Sequence[int], v: Sequence[int]) -> int:
    return sum(x * y for x, y in zip(u, v, strict=True))


def whole(vectors: Iterable[Sequence[Any]]) -> tuple[list[tuple[int, ...]], int]:
    """Vectors of rationals as integers that count 1/unit, and that unit."""
    rows = [[Fraction(x) for x in v] for v in vectors]
    unit = math.lcm(*(x.denominator for row in rows for x in row))
    return [tuple(int(x * unit) for x in row) for row in rows], unit


def primitive(v: Sequence[int]) -> tuple[int, ...]:
    """Integers without their common divisor."""
    divisor = math.gcd(*v) or 1
    return tuple(x // divisor for x in v)


def in_floats(v: Sequence[Any], unit: Any = 1) -> list[float]:
    """Components v/unit, each rounded once; what no double can hold becomes 0."""
    return [float(Fraction(x) / unit) for x in v]


def in_reals(v: Sequence[float]) -> Vector:
    """Doubles at the working precision."""
    x, y, z = (mpf(float(c)) for c in v)
    return x, y, z
