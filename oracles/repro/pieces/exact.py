"""Exact numbers: a double is a rational, and no sum is rounded."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

Vector = Sequence[Any]


class Refused(Exception):
    """The certificate does not hold."""


def require(condition: object, text: str) -> None:
    """Refuse what does not meet a condition."""
    if not condition:
        raise Refused(text)


def number(value: Any) -> Fraction:
    """Take a double or an integer as the rational that it is, and a text such as '1/3'."""
    if isinstance(value, str):
        above, _, below = value.partition("/")
        return Fraction(int(above, 0), int(below or "1", 0))
    require(not isinstance(value, float) or math.isfinite(value), f"not a number: {value!r}")
    return Fraction(value)


def vector(values: Any) -> list[Fraction]:
    """Take three numbers."""
    require(len(values) == 3, f"not three numbers: {values!r}")
    return [number(value) for value in values]


def dot(u: Vector, v: Vector) -> Any:
    """Scalar product."""
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


def cross(u: Vector, v: Vector) -> list[Any]:
    """Vector product."""
    return [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]


def minus(u: Vector, v: Vector) -> list[Any]:
    """Difference u − v."""
    return [u[0] - v[0], u[1] - v[1], u[2] - v[2]]


def along(u: Vector, t: Any, v: Vector) -> list[Any]:
    """Point u + t v."""
    return [u[0] + t * v[0], u[1] + t * v[1], u[2] + t * v[2]]


def times(t: Any, v: Vector) -> list[Any]:
    """Multiple t v."""
    return [t * v[0], t * v[1], t * v[2]]


def root(square: Fraction) -> tuple[Fraction, Fraction]:
    """Enclose a square root, to 160 bits; both ends are equal where it is rational."""
    product = square.numerator * square.denominator
    shift = max(0, 160 - product.bit_length() // 2)
    low, scale = math.isqrt(product << 2 * shift), square.denominator << shift
    return Fraction(low, scale), Fraction(low + (low * low != product << 2 * shift), scale)


def length(v: Vector) -> tuple[Fraction, Fraction]:
    """Enclose the length of a vector."""
    return root(Fraction(dot(v, v)))


def whole(vectors: Sequence[Vector]) -> tuple[list[list[int]], int]:
    """Put vectors on one common denominator: integers, and that denominator."""
    unit = math.lcm(*{number(x).denominator for v in vectors for x in v})
    return [[int(number(x) * unit) for x in v] for v in vectors], unit
