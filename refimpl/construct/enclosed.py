"""Numbers with a bound of their error, so that a formula computed in doubles decides whatever it can decide.

A formula of +, − and × is written once and computed in up to three arithmetics: doubles with a bound of their error,
twofold doubles with a bound of theirs, and fractions. Each settles what the one before left open (the filters of
Fortune and Van Wyk, Static Analysis Yields Efficient Exact Integer Arithmetic for Computational Geometry, 1996).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, ClassVar, Self

import numpy as np

from refimpl.impacts.twofold import Twofold
from refimpl.linear import Array, Bools

TINY = 2.0**-1000  # more than underflow takes from a product, or from what was scaled to about 1
UP = 1 + 2.0**-40  # bounds are themselves rounded, a few times each


@dataclass(frozen=True)
class Enclosed:
    """An array of numbers that are off by at most `error`.

    Attributes
    ----------
    value : (...) doubles or twofold doubles
    error : float
        One bound for all of them.
    grain : int or None
        All true numbers are whole multiples of 2^grain, and so is what is computed from them. An error smaller than
        the grain is therefore none.
    """

    value: Any
    error: float = 0.0
    grain: int | None = None
    unit: ClassVar[float] = 2.0**-53

    @property
    def size(self) -> float:
        """Largest absolute value that a true number can have."""
        high = self.nearest
        return (max(float(high.max()), -float(high.min())) + self.error) * UP if high.size else 0.0

    @property
    def nearest(self) -> Array:
        """Values rounded to doubles."""
        return np.asarray(self.value)

    def _made(self, value: Any, error: float, grain: int | None) -> Self:
        exact = grain is not None and error * UP < math.ldexp(1.0, max(grain, -1060))
        return type(self)(value, 0.0 if exact else error * UP, grain)

    def __neg__(self) -> Self:
        return type(self)(-self.value, self.error, self.grain)

    def __add__(self, other: Self) -> Self:
        rounding = self.unit * (self.size + other.size)
        return self._made(self.value + other.value, self.error + other.error + rounding, _least(self, other))

    def __sub__(self, other: Self) -> Self:
        rounding = self.unit * (self.size + other.size)
        return self._made(self.value - other.value, self.error + other.error + rounding, _least(self, other))

    def __mul__(self, other: Self) -> Self:
        a, b = self.size, other.size
        rounding = self.unit * a * b + TINY
        grain = None if self.grain is None or other.grain is None else self.grain + other.grain
        return self._made(self.value * other.value, a * other.error + b * self.error + rounding, grain)

    def raised(self) -> Self:
        """The numbers, and 0 for negative ones."""
        return self._made(np.maximum(self.value, 0.0), self.error, self.grain)

    def may_be_greatest(self) -> Bools:
        """Which numbers may be the greatest, for all that is known; without error all of these are."""
        top = float(self.value.max())
        return np.asarray(self.value >= top - (2 * self.error * UP + 4 * self.unit * abs(top) * bool(self.error)))

    def signs(self) -> tuple[Bools, Bools]:
        """Which numbers surely are at most 0, and which surely are more."""
        away = np.abs(self.nearest) * (1 - 2.0**-50)
        known = away > self.error if self.error else np.ones(away.shape, dtype=bool)
        return known & (self.nearest <= 0), known & (self.nearest > 0)

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


class EnclosedTwice(Enclosed):
    """The same with twofold doubles."""

    unit = 2.0**-99  # a few operations of the sloppy sum and product, each with 2⁻¹⁰⁴ of its terms

    @property
    def nearest(self) -> Array:
        """Values rounded to doubles."""
        return np.asarray(self.value.high)

    def raised(self) -> Self:
        """The numbers, and 0 for negative ones."""
        negative = self.value.high < 0
        low = np.where(negative, 0.0, self.value.lows)
        return self._made(Twofold(np.where(negative, 0.0, self.value.high), low), self.error, self.grain)

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
