"""Numbers with a bound of their error, so that a formula computed in doubles decides whatever it can decide.

A formula of +, − and × is written once and computed in up to four arithmetics: doubles with a bound of their error, the
processor's extended doubles where there are any, twofold doubles, and fractions. Each settles what the one before left
open (the filters of Fortune and Van Wyk, Static Analysis Yields Efficient Exact Integer Arithmetic for Computational
Geometry, 1996).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any, ClassVar, Self, TypeAlias

import numpy as np

from refimpl.impacts.twofold import Twofold
from refimpl.linear import Array, Bools

Range: TypeAlias = tuple[float, float]
TINY = 2.0**-1000  # more than underflow takes from a product, or from what was scaled to about 1
UP = 1 + 2.0**-40  # bounds are themselves rounded, a few times each
EXTENDED = np.finfo(np.longdouble).nmant == 63 and bool(1 + np.longdouble(2.0**-63) > 1)
"""Whether there are doubles of 64 bits: on x86, but not with every compiler; elsewhere they are slow or absent."""


@dataclass(eq=False)
class Enclosed:
    """An array of numbers that are off by at most `error`.

    Attributes
    ----------
    value : (...) doubles, extended or twofold doubles
    error : float
        One bound for all of them.
    grain : int or None
        All true numbers are whole multiples of 2^grain, and so is what is computed from them. An error smaller than
        the grain is therefore none.
    known : (low, high) or None
        Between these all true numbers lie; None where it is seen from the values.
    """

    value: Any
    error: float = 0.0
    grain: int | None = None
    known: Range | None = None
    unit: ClassVar[float] = 2.0**-53

    @cached_property
    def range(self) -> Range:
        """Two doubles between which all true numbers lie."""
        if self.known is not None:
            return self.known
        near = self.nearest
        return _widened(float(near.min()) - self.error, float(near.max()) + self.error) if near.size else (0.0, 0.0)

    @property
    def size(self) -> float:
        """Largest absolute value that a number can have, as it is and as computed."""
        low, high = self.range
        return (max(high, -low) + self.error) * UP

    @property
    def nearest(self) -> Array:
        """Values rounded to doubles, where these are fewer."""
        return np.asarray(self.value)

    def __getitem__(self, chosen: Any) -> Self:
        """Some of the numbers; None for all."""
        return self if chosen is None else type(self)(self.value[chosen], self.error, self.grain, self.range)

    def _made(self, value: Any, error: float, grain: int | None, known: Range) -> Self:
        exact = grain is not None and error * UP < math.ldexp(1.0, max(grain, -1060))
        return type(self)(value, 0.0 if exact else error * UP, grain, known)

    def __neg__(self) -> Self:
        low, high = self.range
        return type(self)(-self.value, self.error, self.grain, (-high, -low))

    def __add__(self, other: Self) -> Self:
        (a, b), (c, d) = self.range, other.range
        return self._sum(other, self.value + other.value, _widened(a + c, b + d))

    def __sub__(self, other: Self) -> Self:
        (a, b), (c, d) = self.range, other.range
        return self._sum(other, self.value - other.value, _widened(a - d, b - c))

    def _sum(self, other: Self, value: Any, known: Range) -> Self:
        error = self.error + other.error
        rounding = self.unit * self._rounded(max(known[1], -known[0]) + error, self.size + other.size)
        return self._made(value, error + rounding, _least(self, other), known)

    def _rounded(self, result: float, terms: float) -> float:
        """By what the error of a sum is measured: by the result, if it is rounded correctly."""
        del terms
        return result

    def __mul__(self, other: Self) -> Self:
        a, b = self.size, other.size
        ends = [x * y for x in self.range for y in other.range]
        grain = None if self.grain is None or other.grain is None else self.grain + other.grain
        error = a * other.error + b * self.error + self.unit * a * b + TINY
        return self._made(self.value * other.value, error, grain, _widened(min(ends), max(ends)))

    def raised(self) -> Self:
        """The numbers, and 0 for negative ones."""
        return type(self)(np.maximum(self.value, 0.0), self.error, self.grain, self._raised_range())

    def _raised_range(self) -> Range:
        low, high = self.range
        return max(low, 0.0), max(high, 0.0)

    def may_be_greatest(self) -> Bools:
        """Which numbers may be the greatest, for all that is known; without error all of these are."""
        top = self.value.max()
        room = (2 * self.error + 4 * self.unit * abs(top)) * UP if self.error else 0.0
        return ~np.asarray(self.value < top - room)  # what is no number may be

    def signs(self) -> tuple[Bools, Bools]:
        """Which numbers surely are at most 0, and which surely are more."""
        away = np.abs(self.nearest) * (1 - 2.0**-50)
        known = away > self.error if self.error else np.ones(away.shape, dtype=bool)
        return known & (self.nearest <= 0), known & (self.nearest > 0)

    @classmethod
    def lifted(cls, numbers: Array) -> Any:
        """Doubles as what is computed with."""
        return numbers

    @classmethod
    def joined(cls, parts: list[Self]) -> Self:
        """Put arrays together, with the largest of their errors."""
        return cls(np.concatenate([part.value for part in parts]), max(part.error for part in parts))

    def exactly(self, index: int) -> Fraction:
        """One number, of those without error."""
        return Fraction(float(self.value[index]))

    @classmethod
    def of(cls, number: Fraction | float, grain: int | None = None) -> Self:
        """Take in one number."""
        near = float(number)
        return cls(np.array(near), 0.0 if near == number else cls.unit * abs(near) * UP + TINY, grain)


class EnclosedExtended(Enclosed):
    """The same with extended doubles of 64 bits; only where there are any (`EXTENDED`)."""

    unit = 2.0**-64

    @classmethod
    def lifted(cls, numbers: Array) -> Any:
        """Doubles as what is computed with."""
        return numbers.astype(np.longdouble)

    def exactly(self, index: int) -> Fraction:
        """One number, of those without error."""
        return sum((Fraction(half) for half in _halves(self.value[index])), Fraction(0))

    @classmethod
    def of(cls, number: Fraction | float, grain: int | None = None) -> Self:
        """Take in one number."""
        high = float(number)
        near = np.longdouble(high) + np.longdouble(float(Fraction(number) - Fraction(high)))
        exact = sum((Fraction(half) for half in _halves(near)), Fraction(0)) == number
        return cls(np.array(near), 0.0 if exact else cls.unit * abs(high) * UP + TINY, grain)


def _halves(number: np.longdouble) -> tuple[float, float]:
    """Two doubles whose sum an extended double is."""
    high = float(number)
    return high, float(number - high)


class EnclosedTwice(Enclosed):
    """The same with twofold doubles."""

    unit = 2.0**-99  # a few operations of the sloppy sum and product, each with 2⁻¹⁰⁴ of its terms

    @classmethod
    def lifted(cls, numbers: Array) -> Any:
        """Doubles as what is computed with."""
        return Twofold(numbers)

    def _rounded(self, result: float, terms: float) -> float:
        """By what the error of a sum is measured: the sloppy one by its terms."""
        del result
        return terms

    @property
    def nearest(self) -> Array:
        """Values rounded to doubles."""
        return np.asarray(self.value.high)

    def raised(self) -> Self:
        """The numbers, and 0 for negative ones."""
        negative = self.value.high < 0
        low = np.where(negative, 0.0, self.value.lows)
        raised = Twofold(np.where(negative, 0.0, self.value.high), low)
        return type(self)(raised, self.error, self.grain, self._raised_range())

    def may_be_greatest(self) -> Bools:
        """Which numbers may be the greatest, for all that is known; without error all of these are."""
        high, low = self.value.high, self.value.lows
        top = float(high.max())
        under = float(low[high == top].max())
        rest = self.value - Twofold(np.array(top), np.array(under))
        room = (2 * self.error + 4 * self.unit * abs(top)) * UP
        return np.asarray(rest.high >= -room if self.error else (high == top) & (low == under))

    @classmethod
    def joined(cls, parts: list[Self]) -> Self:
        """Put arrays together, with the largest of their errors."""
        high, low = (
            np.concatenate(halves) for halves in zip(*((p.value.high, p.value.lows) for p in parts), strict=True)
        )
        return cls(Twofold(high, low), max(part.error for part in parts))

    def exactly(self, index: int) -> Fraction:
        """One number, of those without error."""
        return Fraction(float(self.value.high[index])) + Fraction(float(self.value.lows[index]))

    @classmethod
    def of(cls, number: Fraction | float, grain: int | None = None) -> Self:
        """Take in one number."""
        high = float(number)
        low = float(Fraction(number) - Fraction(high))
        exact = Fraction(high) + Fraction(low) == number
        error = 0.0 if exact else cls.unit * abs(high) * UP + TINY
        return cls(Twofold(np.array(high), np.array(low)), error, grain)


def _widened(low: float, high: float) -> Range:
    return math.nextafter(low, -math.inf), math.nextafter(high, math.inf)


def _least(a: Enclosed, b: Enclosed) -> int | None:
    return None if a.grain is None or b.grain is None else min(a.grain, b.grain)


def grain_of(numbers: Array) -> int:
    """Largest e for which all doubles are whole multiples of 2^e."""
    mantissa, exponent = np.frexp(numbers)
    whole = np.ldexp(mantissa, 53).astype(np.int64)
    present = whole != 0
    if not np.any(present):
        return 0
    last = np.frexp((whole & -whole)[present].astype(np.float64))[1] - 1
    return int(np.min(exponent[present] - 53 + last))


def grain_of_number(number: Fraction) -> int | None:
    """The same for one number; None where it is no multiple of a power of two."""
    q = number.denominator
    return None if q & (q - 1) else 1 - q.bit_length()
