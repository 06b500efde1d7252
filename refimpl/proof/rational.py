"""Exact numbers and vectors for the checker: read with suspicion, computed without rounding.

Part of what has to be believed; needs nothing but the standard library.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any, TypeAlias

Number: TypeAlias = float | Fraction | int
Vector: TypeAlias = tuple[Number, Number, Number]
Whole: TypeAlias = Sequence[int]
Exact: TypeAlias = Sequence[Fraction]

MAX_BITS = 1 << 17  # of a number in a certificate: what doubles of all exponents lead to stays below
MAX_ITEMS = 1 << 16  # claims, vertices, triangles, planes
ROOT_BITS = 160  # irrational square roots are enclosed to about this many leading bits


class InvalidCertificate(ValueError):
    """The certificate, or a shape given with it, is malformed, or does not prove what it claims."""


def number(value: Any, what: str) -> Fraction:
    """Read a number."""
    if type(value) not in (int, float, Fraction):  # no subclass: it may compare as it likes
        raise InvalidCertificate(f"{what}: not a number but {type(value).__name__}")
    if isinstance(value, float) and not math.isfinite(value):
        raise InvalidCertificate(f"{what}: must be finite, got {value!r}")
    exact = Fraction(value)
    if max(exact.numerator.bit_length(), exact.denominator.bit_length()) > MAX_BITS:
        raise InvalidCertificate(f"{what}: a number of more than {MAX_BITS} bits")
    return exact


def items(value: Any, what: str, count: int | None = None) -> Sequence[Any]:
    """Read a tuple, of `count` items if that is given."""
    if type(value) not in (tuple, list):  # no subclass: it may answer differently the second time
        raise InvalidCertificate(f"{what}: expected a tuple, got {type(value).__name__}")
    if len(value) > MAX_ITEMS or (count is not None and len(value) != count):
        raise InvalidCertificate(f"{what}: {len(value)} items, expected {count or 'fewer'}")
    return tuple(value)


def vector(value: Any, what: str, count: int = 3) -> Exact:
    """Read `count` numbers."""
    return [number(v, what) for v in items(value, what, count)]


def index(value: Any, what: str, end: int) -> int:
    """Read one of 0, 1, …, end − 1."""
    if type(value) is not int or not 0 <= value < end:
        raise InvalidCertificate(f"{what}: not one of the first {end} indices")
    return value


def shares(value: Any, end: int) -> dict[int, Fraction]:
    """Read weights ≥ 0 of some of `end` things, not all zero: pairs of an index and a weight."""
    found: dict[int, Fraction] = {}
    for item in items(value, "shares"):
        i, weight = items(item, "shares", 2)
        found[index(i, "shares", end)] = number(weight, "shares")
    if not any(found.values()) or min(found.values()) < 0:
        raise InvalidCertificate("shares: must be positive numbers")
    return found


def whole(vectors: Sequence[Exact]) -> tuple[list[Whole], int]:
    """Put vectors on one common denominator: integers, and that denominator."""
    unit = 1
    for denominator in {x.denominator for v in vectors for x in v}:
        unit = math.lcm(unit, denominator)
        if unit.bit_length() > 4 * MAX_BITS:
            raise InvalidCertificate("the numbers have no common denominator of reasonable size")
    return [[x.numerator * (unit // x.denominator) for x in v] for v in vectors], unit


def direction(value: Any) -> Whole:
    """Take integers along a direction: its length means nothing."""
    n = whole([vector(value, "n")])[0][0]
    if not any(n):
        raise InvalidCertificate("n: a direction must not be zero")
    return n


def dot(u: Sequence[Any], v: Sequence[Any]) -> Any:
    """Scalar product."""
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


def minus(u: Sequence[Any], v: Sequence[Any]) -> list[Any]:
    """Difference u − v."""
    return [u[0] - v[0], u[1] - v[1], u[2] - v[2]]


def cross(u: Sequence[Any], v: Sequence[Any]) -> list[Any]:
    """Vector product."""
    return [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]


def root(square: Fraction) -> tuple[Fraction, Fraction]:
    """Enclose the square root of `square` ≥ 0; both ends are equal when it is rational."""
    product = square.numerator * square.denominator
    shift = max(0, ROOT_BITS - product.bit_length() // 2)
    low, scale = math.isqrt(product << 2 * shift), square.denominator << shift
    return Fraction(low, scale), Fraction(low + (low * low != product << 2 * shift), scale)


def is_positive(matrix: Sequence[Sequence[Fraction]]) -> bool:
    """Whether a symmetric matrix is positive semidefinite: xᵀ M x ≥ 0 for all x.

    With a pivot p > 0, xᵀ M x is p·(x₀ + …)² and the form of the Schur complement in the other unknowns, and x₀
    can be chosen so that the square vanishes. With p = 0 its row must vanish too, and then the rest decides.
    """
    if not matrix:
        return True
    (pivot, *row), *rest = matrix
    if pivot < 0 or (pivot == 0 and any(row)):
        return False
    share = [x / pivot if pivot else Fraction(0) for x in row]
    return is_positive(
        [[m - s * x for m, x in zip(line[1:], row, strict=True)] for line, s in zip(rest, share, strict=True)]
    )
