"""The polynomials of which proxies consist: squared distances from a point, a segment and a line, and heights."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from refimpl.linear import Array

if TYPE_CHECKING:
    from refimpl.construct.cloud import Cloud

Exact: TypeAlias = Sequence[Fraction]
Taking: TypeAlias = Callable[[Fraction], Any]
Polynomial: TypeAlias = Callable[[Sequence[Any], Taking], Any]
"""A formula of +, − and × of the coordinates x, y, z and of constants, which the second argument takes in."""


@dataclass(frozen=True)
class Shared:
    """A polynomial that is also the sum of one that others share, whose values are kept, and of a small one."""

    whole: Polynomial
    base: Polynomial
    rest: Polynomial

    def __call__(self, x: Sequence[Any], of: Taking, /) -> Any:
        """Compute it as a whole."""
        return self.whole(x, of)


def rational(numbers: Array, cloud: Cloud) -> list[Fraction]:
    """Numbers of a proxy's field, lengths, in a cloud's units."""
    return [cloud.inwards(v) for v in numbers.tolist()]


def less(a: Exact, b: Exact) -> list[Fraction]:
    """Difference a − b."""
    return [u - v for u, v in zip(a, b, strict=True)]


def inner(a: Sequence[Any], b: Sequence[Any]) -> Any:
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def columns_of(rotation: Array) -> tuple[list[list[Fraction]], Fraction]:
    """Columns of a quaternion's rotation matrix times its squared length, and that; of a quaternion of about 1."""
    (x, y, z, w), _ = about_one([Fraction(v) for v in rotation.tolist()])
    columns = [
        [w * w + x * x - y * y - z * z, 2 * (x * y + w * z), 2 * (x * z - w * y)],
        [2 * (x * y - w * z), w * w + y * y - x * x - z * z, 2 * (y * z + w * x)],
        [2 * (x * z + w * y), 2 * (y * z - w * x), w * w + z * z - x * x - y * y],
    ]
    return columns, x * x + y * y + z * z + w * w


def about_one(way: Exact) -> tuple[list[Fraction], Fraction]:
    """Divide a direction by a power of two, so that doubles can hold it; and that."""
    top = max(abs(v) for v in way)
    size = Fraction(2) ** (top.numerator.bit_length() - top.denominator.bit_length())
    return [v / size for v in way], size


def _from(x: Sequence[Any], start: Exact, of: Taking) -> list[Any]:
    return [a - of(b) for a, b in zip(x, start, strict=True)]


def square(center: Exact, minus: Fraction = Fraction(0)) -> Polynomial:
    """Squared distance from a point, less a constant."""

    def formula(x: Sequence[Any], of: Taking) -> Any:
        v = _from(x, center, of)
        return inner(v, v) - of(minus)

    return formula


class Home(NamedTuple):
    """A ball, and its polynomial, which those of balls a little beside it share."""

    center: Exact
    square: Fraction
    formula: Polynomial

    @classmethod
    def at(cls, center: Exact, size: Fraction) -> Home:
        """Home of a ball by its squared radius."""
        return cls(center, size, square(center, size))

    def beside(self, center: Exact, size: Fraction) -> Shared:
        """Squared distance from another centre, less another squared radius."""
        way = [2 * (h - c) for h, c in zip(self.center, center, strict=True)]
        level = inner(self.center, self.center) - self.square - inner(center, center) + size
        return Shared(square(center, size), self.formula, along(way, level))


def _cross(u: Sequence[Any], v: Sequence[Any]) -> list[Any]:
    return [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]


def across(start: Exact, way: Exact, minus: Fraction = Fraction(0)) -> Polynomial:
    """Squared distance from a line times the way's square, less a constant times that square."""

    def formula(x: Sequence[Any], of: Taking) -> Any:
        v = _cross(_from(x, start, of), [of(w) for w in way])
        return inner(v, v) - of(minus * inner(way, way))

    return formula


def near_segment(p: Exact, q: Exact, minus: Fraction = Fraction(0)) -> Polynomial:
    """Squared distance from the segment pq times its squared length, less a constant times that.

    What a point is beyond an end is added to its distance from the line, at right angles to it.
    """
    way = less(q, p)

    def formula(x: Sequence[Any], of: Taking) -> Any:
        v, w, d = _from(x, p, of), _from(x, q, of), [of(a) for a in way]
        side = _cross(v, d)
        before, beyond = _raised(-inner(v, d)), _raised(inner(w, d))
        return inner(side, side) + before * before + beyond * beyond - of(minus * inner(way, way))

    return formula


def _raised(value: Any) -> Any:
    return max(value, Fraction(0)) if isinstance(value, Fraction) else value.raised()


def along(way: Exact, level: Fraction = Fraction(0)) -> Polynomial:
    """Height way·x − level; coordinates that do not count are left out."""

    def formula(x: Sequence[Any], of: Taking) -> Any:
        terms = [_times(a, w, of) for a, w in zip(x, way, strict=True) if w]
        if not terms:
            return of(-level)
        total = terms[0]
        for term in terms[1:]:
            total = total + term
        return total - of(level) if level else total

    return formula


def _times(value: Any, factor: Fraction, of: Taking) -> Any:
    if abs(factor) == 1:
        return value if factor > 0 else -value
    return value * of(factor)


def off_slab(way: Exact, low: Fraction, high: Fraction) -> list[Polynomial]:
    """Two heights that are at most 0 where low ≤ way·x ≤ high."""
    return [along(way, high), along([-w for w in way], -low)]
