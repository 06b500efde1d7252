"""Numbers read with suspicion, and no more of them than can be checked soon: part of what has to be believed."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from fractions import Fraction
from typing import Any

from refimpl.proof.vectors import Exact, Number, Whole

MAX_BITS = 1 << 14  # of a numerator or denominator; what doubles of all exponents lead to stays below
MAX_ITEMS = 1 << 16  # claims, vertices, triangles, planes

_left: ContextVar[int] = ContextVar("effort that is left", default=1 << 62)


class InvalidCertificate(ValueError):
    """The certificate, or a shape given with it, is malformed, or does not prove what it claims."""


def require(condition: object, text: str) -> None:
    """Refuse what does not meet a condition."""
    if not condition:
        raise InvalidCertificate(text)


@contextmanager
def effort(limit: int) -> Iterator[Callable[[], int]]:
    """Let no more be spent inside than `limit`; gives a function that tells how much was."""
    before = _left.set(limit)
    try:
        yield lambda: limit - _left.get()
    finally:
        _left.reset(before)


def spend(work: int, bits: int = 0) -> None:
    """Count work, by about half a microsecond; it grows with the square of the bits of long numbers."""
    left = _left.get() - work * (1 + (bits >> 8) ** 2)
    require(left >= 0, "too much work: too many items, or too long numbers")
    _left.set(left)


def number(value: Any, what: str) -> Number:
    """Read a number."""
    if type(value) is float:
        require(math.isfinite(value), f"{what}: must be finite, got {value!r}")
        return value
    if type(value) not in (int, Fraction):  # no subclass: it may compare as it likes
        raise InvalidCertificate(f"{what}: not a number but {type(value).__name__}")
    bits = max(value.numerator.bit_length(), value.denominator.bit_length())
    require(bits <= MAX_BITS, f"{what}: a number of more than {MAX_BITS} bits")
    spend(1, bits)
    return value  # type: ignore[no-any-return]


def rational(value: Any, what: str) -> Fraction:
    """Read a number to calculate with."""
    return Fraction(number(value, what))


def items(value: Any, what: str, count: int | None = None) -> Sequence[Any]:
    """Read a tuple, of `count` items if that is given."""
    if type(value) not in (tuple, list):  # no subclass: it may answer differently the second time
        raise InvalidCertificate(f"{what}: expected a tuple, got {type(value).__name__}")
    if len(value) > MAX_ITEMS or (count is not None and len(value) != count):
        raise InvalidCertificate(f"{what}: {len(value)} items, expected {count or 'fewer'}")
    spend(len(value))
    return tuple(value)


def vector(value: Any, what: str, count: int = 3) -> Exact:
    """Read `count` numbers."""
    return [rational(v, what) for v in items(value, what, count)]


def index(value: Any, what: str, end: int) -> int:
    """Read one of 0, 1, …, end − 1."""
    if type(value) is not int or not 0 <= value < end:
        raise InvalidCertificate(f"{what}: not one of the first {end} indices")
    return value


def surface(value: Any, what: str, end: int) -> list[tuple[int, int, int]]:
    """Read the triangles of a closed surface: every directed edge occurs as often as its reverse."""
    triangles, edges = [], Counter[tuple[int, int]]()
    for row in items(value, what):
        i, j, k = (index(i, what, end) for i in items(row, what, 3))
        triangles.append((i, j, k))
        edges.update([(i, j), (j, k), (k, i)])
    require(edges and all(edges[i, j] == edges[j, i] for i, j in list(edges)), f"{what}: the surface is not closed")
    return triangles


def whole(vectors: Sequence[Sequence[Number]]) -> tuple[list[Whole], int]:
    """Put vectors on one common denominator: integers, and that denominator."""
    ratios = [[x.as_integer_ratio() for x in v] for v in vectors]
    unit = 1
    for denominator in {q for v in ratios for _, q in v}:
        unit = math.lcm(unit, denominator)
        require(unit.bit_length() <= 4 * MAX_BITS, "the numbers have no common denominator of reasonable size")
    spend(4 * len(ratios), unit.bit_length())
    return [[p * (unit // q) for p, q in v] for v in ratios], unit


def shares(value: Any, end: int) -> dict[int, int]:
    """Read weights ≥ 0 of some of `end` things, not all zero, up to a common factor: pairs of an index and a weight."""
    pairs = [items(item, "shares", 2) for item in items(value, "shares")]
    (weights,), _ = whole([[number(weight, "shares") for _, weight in pairs]])
    require(any(weights) and min(weights) >= 0, "shares: must be positive numbers")
    spend(64 + 32 * len(pairs), max(weights).bit_length())
    return {index(i, "shares", end): weight for (i, _), weight in zip(pairs, weights, strict=True)}


def direction(value: Any) -> Whole:
    """Take integers along a direction: its length means nothing."""
    (n,), _ = whole([[number(v, "n") for v in items(value, "n", 3)]])
    require(any(n), "n: a direction must not be zero")
    return n
