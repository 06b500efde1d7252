"""Vectors of exact numbers: computed without rounding. Part of what has to be believed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any, TypeAlias

Number: TypeAlias = float | Fraction | int
Vector: TypeAlias = tuple[Number, Number, Number]
Whole: TypeAlias = Sequence[int]
Exact: TypeAlias = Sequence[Fraction]

NONE = Fraction(0)
ROOT_BITS = 160  # irrational square roots are enclosed to about this many leading bits


def dot(u: Sequence[Any], v: Sequence[Any]) -> Any:
    """Scalar product."""
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


def minus(u: Sequence[Any], v: Sequence[Any]) -> list[Any]:
    """Difference u − v."""
    return [u[0] - v[0], u[1] - v[1], u[2] - v[2]]


def cross(u: Sequence[Any], v: Sequence[Any]) -> list[Any]:
    """Vector product."""
    return [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]


def times(factor: Any, v: Sequence[Any]) -> list[Any]:
    """Multiple of a vector."""
    return [factor * x for x in v]


def root(square: Fraction) -> tuple[Fraction, Fraction]:
    """Enclose the square root of `square` ≥ 0; both ends are equal when it is rational."""
    product = square.numerator * square.denominator
    shift = max(0, ROOT_BITS - product.bit_length() // 2)
    low, scale = math.isqrt(product << 2 * shift), square.denominator << shift
    return Fraction(low, scale), Fraction(low + (low * low != product << 2 * shift), scale)


def is_positive(matrix: Sequence[Sequence[Any]]) -> bool:
    """Whether a symmetric matrix is positive semidefinite: xᵀ M x ≥ 0 for all x.

    With a pivot p > 0, p·xᵀ M x is (p·x₀ + …)² and p times the form of the Schur complement in the other unknowns, and
    x₀ can be chosen so that the square vanishes. With p = 0 its row must vanish too, and then the rest decides.
    """
    if not matrix:
        return True
    (pivot, *row), *rest = matrix
    if pivot < 0 or (pivot == 0 and any(row)):
        return False
    scale = pivot or 1
    return is_positive([[scale * m - x * line[0] for m, x in zip(line[1:], row, strict=True)] for line in rest])
